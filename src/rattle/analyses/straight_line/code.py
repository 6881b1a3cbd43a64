"""A model as a program in another language: what its kernels do at one instant, recorded once, and how a run starts."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from rattle.analyses.assembly.start_constants import constants_of
from rattle.analyses.straight_line.derived_curves import derived_units
from rattle.analyses.straight_line.recorded_model import NUDGES, RecordedModel, record_model
from rattle.analyses.straight_line.starts import CLOSED, FAR, MISSED, ROUNDS, SMALL, Starts
from rattle.errors import TraceError
from rattle.language.expression import names, parse
from rattle.language.recorded import Operand
from rattle.language.units import parse_quantity
from rattle.solvers.stepper import LONGEST
from rattle.trace import c, javascript
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph
from rattle.trace.program import Begin, Input, Program
from rattle.value_types import Tree
from rattle.version import __version__

ALONE = 1e-6  # change of a parameter by which `_bound` tries it, in shares of its value
ENERGIES = 5  # result curves that come last: kinetic, potential, work, dissipated, balance
__all__ = ["LONGEST", "c_program", "javascript_module", "program", "straight_line", "units_of", "with_parameters"]


def program(model: RecordedModel) -> Program:
    """A model, recorded without parameters, as a program with all parameters that can be inputs of one."""
    return straight_line(*with_parameters(model))


def with_parameters(model: RecordedModel) -> tuple[RecordedModel, dict[str, str]]:
    """A model, recorded without parameters, with all that can be inputs; the other parameters, and why they cannot."""
    if counting := constants_of(model.system.model):
        names = ", ".join(counting)
        why = f"the start sets how {names} go on from there, anew with every parameter: only `rattle` can do that"
        return model, dict.fromkeys(model.values, why)
    constants = _dependent(model.document, list(model.values))
    chosen = [name for name in list(model.values) if name not in constants]
    if not chosen:
        return model, constants
    recording, refused = _recorded(model, chosen)
    constants |= refused
    if recording is not None and recording.first is None:
        why = "the start does not follow from given values alone: only `rattle` can put the mechanism together anew"
        constants |= dict.fromkeys(recording.parameters, why)
        recording = None
    if recording is not None:
        fixed = _structural(recording)
        constants |= fixed
        if fixed:
            recording, _ = _recorded(model, [name for name in recording.parameters if name not in fixed])
    return recording or model, constants


def _dependent(document: Tree, candidates: Sequence[str]) -> dict[str, str]:
    """Parameters that are written as expressions of others, and that they are."""
    reasons = {}
    for name in candidates:
        entry = document.get("parameters", {}).get(name, 0.0)  # those of fits and bearings are not written
        text = entry["value"] if isinstance(entry, Mapping) else entry
        if isinstance(text, str) and parse_quantity(text) is None:
            used = sorted(names(parse(text, tables=document.get("tables", {}))))
            if used:
                reasons[name] = f"it follows from {', '.join(used)}"
    return reasons


def _recorded(model: RecordedModel, chosen: Sequence[str]) -> tuple[RecordedModel | None, dict[str, str]]:
    """The model recorded with these parameters, without those that cannot be recorded, and why not."""
    if not chosen:
        return None, {}
    try:
        return record_model(model.document, model.system, model.start, chosen), {}
    except TraceError as error:
        if len(chosen) == 1:
            return None, {chosen[0]: str(error)}
    refused: dict[str, str] = {}
    for name in chosen:
        refused |= _recorded(model, [name])[1]
    if not refused:  # each alone, but not together
        return None, dict.fromkeys(chosen, "it cannot be recorded together with the others")
    recording, more = _recorded(model, [name for name in chosen if name not in refused])
    return recording, refused | more


def _structural(model: RecordedModel) -> dict[str, str]:
    """Parameters that stand for another form of the model wherever they are changed."""
    graph, flag = lower(model.graph, [model.readable])
    inputs = model.inputs(model.start.t, model.start_state)
    reasons = {}
    for k, (name, value) in enumerate(model.parameters.items(), 1 + model.state_size):
        tried = np.repeat(inputs[:, None], len(NUDGES), axis=1)
        tried[k] = [value * (1.0 + nudge) + (nudge if value == 0.0 else 0.0) for nudge in NUDGES]
        if not graph.evaluate(flag, tried).any():
            reasons[name] = "it changes the form of the model"
    return reasons


def _bound(model: RecordedModel) -> list[str]:
    """Parameters that have no start where they are changed alone: given start values then contradict each other."""

    def evaluated(graph: Graph, outputs: Sequence[Operand]) -> Callable[[np.ndarray, np.ndarray], None]:
        return lambda inputs, results: np.copyto(results, graph.evaluate(outputs, inputs))

    values = np.array(list(model.parameters.values()))
    tried = np.repeat(values[:, None], 2 * len(values), axis=1)
    for k, value in enumerate(values):
        step = ALONE * (abs(value) or 1.0)
        tried[k, 2 * k : 2 * k + 2] = value - step, value + step
    y = np.repeat(model.start_state[:, None], tried.shape[1], axis=1)
    good = Starts(model, evaluated).solve(y, tried)
    return [name for k, name in enumerate(model.parameters) if not good[2 * k : 2 * k + 2].any()]


def straight_line(model: RecordedModel, constants: Mapping[str, str] | None = None) -> Program:
    """The functions of a recorded model, with its parameters.

    constants: parameters of the model file that are none of the program, and why.
    """
    curves, first = all_curves(model), model.first
    parts: list[list[Operand]] = [model.derivative, model.projection, [*curves.values(), model.sound_curves]]
    if first is not None:
        parts += [[model.readable], first.correction, first.rates, [gap.open for gap in first.gaps]]
    graph, every = lower(model.graph, [x for part in parts for x in part])
    ends = np.cumsum([0, *map(len, parts)])
    rates, projection, outputs, *more = (every[start:end] for start, end in itertools.pairwise(ends))
    begin, size = None, model.system.size
    if first is not None:
        (readable,), correction, closing, gaps = more
        gap_rows = [(gap.words, symbol, gap.unit) for gap, symbol in zip(first.gaps, gaps, strict=True)]
        begin = Begin(
            readable, correction, closing, gap_rows, [size, size, 1.0] * model.system.body_count, CLOSED * size, MISSED,
            FAR, ROUNDS, SMALL,
        )  # fmt: skip
    parameters = model.system.model.parameters
    inputs = [
        Input(name, value, parameters[name].unit, parameters[name].minimum, parameters[name].maximum)
        for name, value in model.parameters.items()
    ]
    switching = sorted({switch.name for switch in model.system.switches})
    return Program(
        graph, rates, projection, outputs, list(curves), units_of(model, curves), inputs,
        model.start_state.tolist(), begin, switching, constants or {}, [] if first is None else _bound(model),
    )  # fmt: skip


def all_curves(model: RecordedModel) -> dict[str, Operand]:
    """Result curves, points of bodies among them, and the energies last."""
    names = list(model.curves)
    ordered = [*names[:-ENERGIES], *model.points, *names[-ENERGIES:]]
    symbols = model.curves | model.points
    return {name: symbols[name] for name in ordered}


def units_of(model: RecordedModel, names: Iterable[str]) -> list[str]:
    """SI units of curves of `all_curves`."""
    units = derived_units(model.system.model, model.curves) | model.units
    return [units[name] for name in names]


def c_program(program: Program, title: str, t_end: float, step: float) -> str:
    """One C99 file: the recorded functions, and a main that integrates them by the Runge-Kutta method of order 4.

    t_end, step: what the program does when not told [s].
    """
    return c.program(_header(program, title), program, t_end, step)


def javascript_module(program: Program, title: str, t_end: float, step: float) -> str:
    """One ES module without dependencies: the recorded functions, and a `run` with the steps of the C program.

    t_end, step: what `run` does when not told [s].
    """
    return javascript.module(_header(program, title), program, t_end, step)


def _header(program: Program, title: str) -> list[str]:
    """What the comment on top of a file says first."""
    count = program.graph.count(program.derivative)
    lines = [f"{title}, written by rattle {__version__}; {count} operations for a right-hand side."]
    if program.switching:
        lines.append(
            f"Steps go across the switches of {', '.join(program.switching)}: choose a step that is short enough."
        )
    groups: dict[str, list[str]] = {}
    for name, why in program.constants.items():
        groups.setdefault(why, []).append(name)
    if program.bound:
        alone = "with one of these changed alone, start values given in the model file contradict each other"
        lines.append(f"To be changed together: {', '.join(program.bound)} ({alone}).")
    lines += [f"Fixed parameters: {', '.join(names)} ({why})." for why, names in groups.items()]
    return lines
