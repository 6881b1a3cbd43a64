"""A model as straight-line code: what its kernels do at one instant, recorded once, for programs without this package.

Right-hand side, projection onto the constraints, and every result column; see `rattle.trace`.
"""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.run import start_state
from rattle.equations.motion import derivative
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.results.columns import columns, width
from rattle.solvers.output_row import record
from rattle.solvers.stepper import LONGEST
from rattle.trace import c
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph
from rattle.trace.recording import Recording, Table
from rattle.version import __version__

__all__ = ["LONGEST", "StraightLine", "c_program", "straight_line"]


SAME = 1e-9  # share of the largest number by which a recording may differ from the kernels: rounding, well amplified


class StraightLine(NamedTuple):
    """Recorded functions of one model; inputs of the graph are t [s], then y [SI]."""

    graph: Graph  # of exact operations
    derivative: list[Any]  # (ny,) dy/dt [SI/s], then a flag: this was computed on sound assumptions
    projection: list[Any]  # (ny,) y on the constraints [SI], then such a flag
    outputs: list[Any]  # the result columns [SI], then such a flag
    names: list[str]  # of the result columns
    units: list[str]
    start: np.ndarray  # (ny,) y at t = 0
    switching: list[str]  # expressions with abs, sign, min, max or if


def straight_line(system: System, start: Assembled) -> StraightLine:
    """Record a model.  Raises TraceError, with the reason, where it cannot be straight-line code."""
    _require_smooth(system)
    recording, y = Recording(system), start_state(system, start)
    first = np.zeros(width(system))
    record.python(system.plain_workspace(), start.t, y.copy(), first)
    row = np.zeros(width(system), dtype=object)
    rate, sound_rate = recording.guarded(recording.derivative)
    closed, sound_closed = recording.guarded(recording.projection)
    _, sound_row = recording.guarded(lambda: recording.run(record, recording.t, recording.y, row))
    table, names, units = recording.plain(columns)(system, Table([list(first), list(row)]))
    parts = [[*rate, sound_rate], [*closed, sound_closed], [*(one[1] for one in table), sound_row]]
    graph, every = lower(recording.graph, [x for part in parts for x in part])
    ends = np.cumsum([0, *map(len, parts)])
    rates, projection, outputs = (every[one:other] for one, other in itertools.pairwise(ends))
    _require_same(system, start.t, y, graph, [*rates, *outputs])
    switching = sorted({one.name for one in system.switches})
    said = [units[name] for name in names]
    return StraightLine(graph, rates, projection, outputs, names, said, y, switching)


def _require_smooth(system: System) -> None:
    """Raise TraceError for what a calculation without branches and events cannot follow."""
    for name, load in system.model.loads.items():
        if load.law is not None:
            raise TraceError(
                f"the load '{name}' is a Python function; only loads of model files can be written as code"
            )
    driving = sorted({one.name for one in system.switches if one.driving})
    if driving:
        raise TraceError(
            f"{', '.join(driving)} switches (abs, sign, min, max, if): code would step over the jumps of a driver;"
            " use a smooth function of t"
        )


def _require_same(system: System, t: float, y: np.ndarray, graph: Graph, made: list[Any]) -> None:
    """Compare the recorded functions with the kernels at the start.  Raises TraceError where they differ."""
    rate, row = np.zeros_like(y), np.zeros(width(system))
    workspace = system.plain_workspace()
    derivative.python(workspace, t, y.copy(), rate)
    record.python(workspace, t, y.copy(), row)
    table, _, _ = columns(system, row[None])
    found = graph.evaluate(made, np.concatenate([[t], y])[:, None])[:, 0]
    if not (found[len(y)] and found[-1]):
        raise TraceError(
            "the start is next to a singular position, or points coincide: straight-line code cannot pass it"
        )
    for name, want, got in (
        ("right-hand side", rate, found[: len(y)]),
        ("result columns", table[0], found[len(y) + 1 : -1]),
    ):
        if not np.isfinite(want).all():
            raise TraceError("a load, driver or signal has no finite value at the start")
        if not np.abs(want - got).max() <= SAME * max(1e-12, np.abs(want).max()):
            raise TraceError(f"the recorded {name} differ from the kernels' at the start; this is a fault of rattle")


def c_program(made: StraightLine, title: str, t_end: float, step: float) -> str:
    """One C99 file: the recorded functions, and a main that integrates them by the Runge-Kutta method of order 4."""
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
