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
    made: list[tuple[str, Result]] = []
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
        made.append((label, result))
    held = f"{len(made)} runs that were" if len(made) > 1 else "one run that was"
    notes = [f"this page holds {held} computed before, because {why}", *failed]
    if len(made) > 1:
        notes.append("how long curves can be trusted was computed for the first run only, the model as in its file")
    return scene_of(made, title=m.name, notes=notes)


def _require_known(m: Mechanism, plans: Sequence[Mapping[str, Any]]) -> None:
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
    known = {
        name: one for name, one in m.model.parameters.items() if one.minimum is not None and one.maximum is not None
    }
    if len(known) <= 2:
        count = ONE if len(known) == 1 else TWO
        axes = [_values(one, count) for one in known.values()]
        every = (dict(zip(known, each, strict=True)) for each in itertools.product(*axes))
        yield from (one for one in every if one and one != {name: known[name].value for name in known})
        return
    for name, one in known.items():
        yield from ({name: x} for x in _values(one, EACH) if x != one.value)


def _values(one: Parameter, count: int) -> list[float]:
    assert one.minimum is not None
    assert one.maximum is not None
    return [float(x) for x in np.linspace(one.minimum, one.maximum, count)]


def _label(m: Mechanism, plan: Mapping[str, Any]) -> str:
    """Changed parameters in words."""
    said = []
    for name, x in plan.items():
        if isinstance(x, float) and name in m.model.parameters:
            one = m.model.parameters[name]
            said.append(f"{one.label or name} = {in_written_unit(replace(one, value=x), m.written_unit(name), 5)}")
        else:
            said.append(f"{name} = {x}")
    return ", ".join(said) or "as in the model file"


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
