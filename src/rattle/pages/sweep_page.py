"""Pages of mechanisms that only rattle itself can compute: the runs of a small sweep, to choose from."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rattle.description.model import Parameter
from rattle.errors import AssemblyError, InputError, ModelError
from rattle.mechanism import Mechanism
from rattle.pages.scene import scene_of
from rattle.progress_bar import progress_bar
from rattle.results.display import in_written_unit
from rattle.results.result import Result
from rattle.value_types import Tree

ONE = 7  # values of a single parameter
TWO = 4  # values of each of two, all combinations
EACH = 3  # values of each of more, one at a time
MOST = 40  # runs of a page


def sweep_scene(
    m: Mechanism, why: str, *, t_end: float | None = None, over: Mapping[str, Sequence[float | str]] | None = None,
    progress: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """The scene of a page with several runs; why: the reason for it, said on the page.

    t_end: of the runs [s].  over: values by parameter; all combinations.  Default: three to seven values between the
    limits of every parameter that has some.  Raises ModelError, AssemblyError, ValueError for too many runs.
    """
    plans = list(runs_of(m, over))
    if len(plans) > MOST:
        raise InputError(f"{len(plans)} runs are too many for a page; ask for at most {MOST}")
    _require_known(m, plans[1:] if over is not None else [])
    runs: list[tuple[str, Result]] = []
    failed: list[str] = []
    for plan in _counted(plans, progress):
        label = _label(m, plan)
        try:
            changed = m.neighbour(plan) if plan else m
            result = changed.simulate(t_end, horizon=not plan).whole()
        except (ModelError, AssemblyError) as error:
            if not plan:
                raise
            failed.append(f"{label}: {str(error).splitlines()[0]}")
            continue
        runs.append((label, result))
    held = f"{len(runs)} runs that were" if len(runs) > 1 else "one run that was"
    notes = [f"this page holds {held} computed before, because {why}", *failed]
    if len(runs) > 1:
        notes.append("how long curves can be trusted was computed for the first run only, the model as in its file")
    return scene_of(runs, title=m.name, notes=notes)


def _require_known(m: Mechanism, plans: Sequence[Tree]) -> None:
    """Raise ModelError where the model takes none of these changes: a name that it does not know, a wrong unit."""
    first: ModelError | None = None
    for plan in plans:
        try:
            m.set(**plan)
        except ModelError as error:
            first = first or error
        else:
            return
    if first is not None:
        raise first


def runs_of(m: Mechanism, over: Mapping[str, Sequence[float | str]] | None) -> Iterator[dict[str, Any]]:
    """Changed parameters of every run; the first is the model as it is."""
    yield {}
    if over is not None:
        names = list(over)
        yield from (dict(zip(names, each, strict=True)) for each in itertools.product(*over.values()))
        return
    yield from _between_limits(m)


def _between_limits(m: Mechanism) -> Iterator[dict[str, float]]:
    """Values between the limits of parameters: all combinations of one or two, of more each for itself."""
    every = m.model.parameters.items()
    ranged = {name: x for name, x in every if x.minimum is not None and x.maximum is not None}
    if len(ranged) <= 2:
        count = ONE if len(ranged) == 1 else TWO
        axes = [_values(parameter, count) for parameter in ranged.values()]
        plans = (dict(zip(ranged, each, strict=True)) for each in itertools.product(*axes))
        yield from (plan for plan in plans if plan and plan != {name: x.value for name, x in ranged.items()})
        return
    for name, parameter in ranged.items():
        yield from ({name: x} for x in _values(parameter, EACH) if x != parameter.value)


def _values(parameter: Parameter, count: int) -> list[float]:
    assert parameter.minimum is not None
    assert parameter.maximum is not None
    return [float(x) for x in np.linspace(parameter.minimum, parameter.maximum, count)]


def _label(m: Mechanism, plan: Tree) -> str:
    """Changed parameters in words."""
    changes = []
    for name, x in plan.items():
        if isinstance(x, float) and name in m.model.parameters:
            parameter = m.model.parameters[name]
            value = in_written_unit(replace(parameter, value=x), m.written_unit(name), 5)
            changes.append(f"{parameter.label or name} = {value}")
        else:
            changes.append(f"{name} = {x}")
    return ", ".join(changes) or "as in the model file"


def _counted(plans: Sequence[dict[str, Any]], progress: bool) -> Iterator[dict[str, Any]]:
    bar = progress_bar(len(plans), "page", unit="run", delay=1.0) if progress else None
    try:
        for plan in plans:
            yield plan
            if bar is not None:
                bar.update()
    finally:
        if bar is not None:
            bar.close()
