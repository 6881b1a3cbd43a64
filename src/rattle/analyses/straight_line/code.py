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

__all__ = ["LONGEST", "c_program"]


class _Functions(NamedTuple):
    """The functions of a program, of exact operations; each ends with its flag."""

    graph: Graph
    derivative: list[Any]
    projection: list[Any]
    curves: list[Any]


def _functions(model: RecordedModel) -> _Functions:
    """Functions of t and y, for a model recorded without parameters."""
    parts = [model.derivative, model.projection, [*model.curves.values(), model.sound_curves]]
    graph, every = lower(model.graph, [x for part in parts for x in part])
    at_start = np.concatenate([[model.start.t], model.start_state, [0.0]])[:, None]
    energy = graph.evaluate([every[-2]], at_start)[0, 0]
    graph, every = bind(graph, every, {graph.inputs[-1]: float(energy)})
    ends = np.cumsum([0, *map(len, parts)])
    return _Functions(graph, *(every[one:other] for one, other in itertools.pairwise(ends)))


def c_program(model: RecordedModel, title: str, t_end: float, step: float) -> str:
    """One C99 file: the recorded functions, and a main that integrates them by the Runge-Kutta method of order 4.

    model: recorded without parameters.  t_end, step: what the program does when not told [s].
    """
    made = _functions(model)
    functions = [
        c.function(made.graph, outputs, name)
        for name, outputs in (("derivative", made.derivative), ("project", made.projection), ("outputs", made.curves))
    ]
    count = made.graph.count(made.derivative)
    lines = [f"{title}, written by rattle {__version__}; {count} operations for a right-hand side"]
    switching = sorted({one.name for one in model.system.switches})
    if switching:
        lines.append(f"Steps go across the switches of {', '.join(switching)}: choose a step that is short enough.")
    units = [model.units[name] for name in model.curves]
    return c.program(lines, functions, list(model.curves), units, model.start_state.tolist(), t_end, step)
