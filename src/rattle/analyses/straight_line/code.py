"""A model as a program in another language: what its kernels do at one instant, recorded once, and a stepper."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.solvers.stepper import LONGEST
from rattle.trace import c
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph, bind
from rattle.version import __version__

__all__ = ["LONGEST", "StraightLine", "c_program", "straight_line"]


class StraightLine(NamedTuple):
    """Functions of t [s] and y [SI], of exact operations, at the model's own parameters."""

    graph: Graph
    derivative: list[Any]  # (ny,) dy/dt [SI/s], then a flag: this was computed on sound assumptions
    projection: list[Any]  # (ny,) y on the constraints [SI], then such a flag
    outputs: list[Any]  # the result columns [SI], then such a flag
    names: list[str]  # of the result columns
    units: list[str]
    start: np.ndarray  # (ny,) y at t = 0
    switching: list[str]  # expressions with abs, sign, min, max or if


def straight_line(model: RecordedModel) -> StraightLine:
    """The functions of a model that was recorded without parameters."""
    names = list(model.curves)
    parts = [model.derivative, model.projection, [*model.curves.values(), model.sound_curves]]
    graph, every = lower(model.graph, [x for part in parts for x in part])
    at_start = np.concatenate([[model.start.t], model.start_state, [0.0]])[:, None]
    balance = every[len(parts[0]) + len(parts[1]) + names.index("energy.balance")]
    energy = float(graph.evaluate([balance], at_start)[0, 0])
    graph, every = bind(graph, every, {graph.inputs[-1]: energy})
    ends = np.cumsum([0, *map(len, parts)])
    rates, projection, outputs = (every[one:other] for one, other in itertools.pairwise(ends))
    switching = sorted({one.name for one in model.system.switches})
    units = [model.units[name] for name in names]
    return StraightLine(graph, rates, projection, outputs, names, units, model.start_state, switching)


def c_program(made: StraightLine, title: str, t_end: float, step: float) -> str:
    """One C99 file: the recorded functions, and a main that integrates them by the Runge-Kutta method of order 4.

    t_end, step: what the program does when not told [s].
    """
    functions = [
        c.function(made.graph, outputs, name)
        for name, outputs in (("derivative", made.derivative), ("project", made.projection), ("outputs", made.outputs))
    ]
    count = made.graph.count(made.derivative)
    lines = [f"{title}, written by rattle {__version__}; {count} operations for a right-hand side"]
    if made.switching:
        lines.append(
            f"Steps go across the switches of {', '.join(made.switching)}: choose a step that is short enough."
        )
    return c.program(lines, functions, made.names, made.units, made.start.tolist(), t_end, step)
