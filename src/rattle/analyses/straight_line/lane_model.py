"""A recorded model for lanes: its functions split into what a sample determines once and what every step needs."""

from __future__ import annotations

import itertools
from collections.abc import Container, Mapping, Sequence
from typing import Any

import numpy as np

from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.analyses.straight_line.recorded_start import driven_bodies
from rattle.analyses.straight_line.starts import Starts
from rattle.equations.state import state_layout
from rattle.jit.choices import TINY
from rattle.language.recorded import Operand
from rattle.language.syntax import Apply, Name, Node, Number, walk
from rattle.results.reductions import OF_EVENTS, Output, argument
from rattle.trace import reductions
from rattle.trace.copying import replaced
from rattle.trace.elementary import lower
from rattle.trace.hoist import hoist
from rattle.trace.lane_program import Compile, Model, filled
from rattle.trace.recording import operation
from rattle.trace.reductions import CONDITIONS, EXTREMES, KINDS, SAMPLED, Reduction

ENERGY = ("kinetic", "potential", "work", "dissipated", "balance")
JUMPS = ("sign", "step", "floor", "mod", "choose", "if<", "if<=", "if>", "if>=")  # operations whose curves may jump
STEADY = ("+", "-", "*", "/", "**", "neg", "sqrt", "hypot")  # operations that change as fast as their operands
PEAKS = {"max": ("abs", "max"), "min": ("min",)}  # by kind of extreme: kinks that point away from it


class Asked:
    """The reductions of some outputs, each once, as curves of a graph and what is asked of them."""

    def __init__(self, model: RecordedModel, outputs: Sequence[Output]) -> None:
        self.model, self.outputs = model, outputs
        self.curves: list[Operand] = []
        self.reductions: list[Reduction] = []
        self._places: dict[tuple[str, int, float], int] = {}
        self.rows = [[self._row(reduction) for reduction in output.reductions] for output in outputs]

    def _row(self, reduction: Any) -> int:
        """The row of the values that holds a reduction."""
        symbol = expression(self.model, reduction.inner)
        if reduction.kind in ("share", "first") and not reduction.strict:
            symbol = self.model.graph.apply("select", symbol >= 0.0, symbol + TINY, symbol)
        place = self.model.graph.place(symbol)
        curve = next((n for n, x in enumerate(self.curves) if self.model.graph.place(x) == place), len(self.curves))
        if curve == len(self.curves):
            self.curves.append(symbol)
        t = argument(reduction, self.model.values) if reduction.kind == "at" else 0.0
        key = (reduction.kind, curve, t)
        if key not in self._places:
            self._places[key] = len(self.reductions)
            self.reductions.append(Reduction(*key))
        return self._places[key]


def expression(model: RecordedModel, node: Node) -> Operand:
    """An expression over result curves, parameters and t as a symbol of the graph of the model, or a number [SI]."""
    stack: list[Operand] = []
    for part in walk(node):
        if isinstance(part, Number):
            stack.append(part.value)
        elif isinstance(part, Name):
            stack.append(model.symbol(part.name))
        else:
            size = len(part.operands)
            operands = stack[-size:]
            del stack[-size:]
            stack.append(operation(part.name, *operands))
    return stack[0]


def why_not_lanes(output: Output, varied: Mapping[str, object]) -> str:
    """Why lanes cannot compute an output; "" if they can."""
    if output.ideal_names:
        return f"{output.text!r} compares with the mechanism without play"
    for reduction in output.reductions:
        if reduction.kind in OF_EVENTS:
            return f"{output.text!r} asks for events, which stand in single runs"
        if reduction.kind not in KINDS:
            return f"{reduction.kind}(...) needs a whole curve"
        if reduction.kind in EXTREMES and any(
            isinstance(part, Apply) and part.name in JUMPS for part in walk(reduction.inner)
        ):
            return f"the curve in {output.text!r} jumps"
        if reduction.argument is not None and any(
            isinstance(part, Name) and part.name in varied for part in walk(reduction.argument)
        ):
            return f"the instant in {output.text!r} differs from sample to sample"
    return ""


def needs_short_steps(outputs: Sequence[Output], model: RecordedModel) -> bool:
    """Whether outputs need steps that are short beside the run, as samples in a step of usual length miss something.

    Steps follow the motion.  A condition may hold more shortly, a curve or a load written with functions or with t may
    change faster, and what a driver or a guide takes from a load does not show in the motion at all.
    """
    sampled = [reduction for output in outputs for reduction in output.reductions if reduction.kind in SAMPLED]
    if not sampled:
        return False
    inside, signals = model.system.model, model.system.model.signals
    if any(_brief(reduction, signals) for reduction in sampled):
        return True
    values = [value for load in inside.loads.values() for value in load.values]
    if any(_brisk(value, signals) for value in values if isinstance(value, Apply | Name)):
        return True
    driven = driven_bodies(model.system, model.start)
    loaded = {point.body for load in inside.loads.values() for point in (load.a, load.b)}
    return len(driven) == model.system.body_count or bool(driven & loaded)  # the motion of these is no measure


def _brief(reduction: Any, signals: Container[str]) -> bool:
    """Whether what a sampled reduction looks for may last shorter than a step of usual length."""
    inner = reduction.inner
    peak = isinstance(inner, Apply) and inner.name in PEAKS.get(reduction.kind, ())
    parts = inner.operands if peak else (inner,)
    return reduction.kind in CONDITIONS or any(_brisk(part, signals) for part in parts)


def _brisk(node: Node, signals: Container[str]) -> bool:
    """Whether an expression may change faster than the curves in it."""
    for part in walk(node):
        if isinstance(part, Apply) and part.name not in STEADY:
            return True
        if isinstance(part, Name) and (part.name == "t" or part.name in signals):
            return True
    return False


def lane_model(model: RecordedModel, asked: Asked, compile_function: Compile, starts: Starts) -> Model:
    """Functions of a model for lanes: curves are those asked for, then the energies."""
    nb, ny, graph = model.system.body_count, model.state_size, model.graph
    energies = [model.curves[f"energy.{key}"] for key in ENERGY]
    curves = [*asked.curves, *energies]
    watched = reductions.watched(asked.reductions)
    size = [ny + 1, ny + 1, len(curves) + 1]
    exact, every = lower(graph, [*model.derivative, *model.projection, *curves, model.sound_curves])
    rates, closed, rows = (every[sum(size[:n]) : sum(size[: n + 1])] for n in range(3))
    there = replaced(exact, [*rates, *rows], dict(zip(exact.inputs[1:], closed[:-1], strict=False)))
    parts = [rates, [*closed, *there], rows, *([[*rates, *(rows[n] for n in watched)]] if watched else [])]
    early, prepared, late, outputs = hoist(exact, [x for part in parts for x in part], exact.inputs[1 + ny :])
    ends = np.cumsum([0, *map(len, parts)])
    rate, arrive, row, *watch = (compile_function(late, outputs[a:b]) for a, b in itertools.pairwise(ends))
    prepare = compile_function(early, prepared)
    energy = compile_function(*lower(graph, [energies[-1]]))

    def begin(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        begun, count = starts.begin(values), values.shape[1]
        fill = filled(count)
        state, first = np.zeros((len(exact.inputs), len(fill))), np.zeros((1, len(fill)))
        state[1 : 1 + ny], state[1 + ny : -1] = begun.y[:, fill], np.vstack([values, begun.constants])[:, fill]
        energy(state, first)
        state[-1] = first[0]
        constants = np.empty((len(prepared), len(fill)))
        prepare(state, constants)
        return begun.y, constants[:, :count], np.isfinite(begun.y).all(axis=0)

    first = len(asked.curves)
    own = state_layout(model.system).own_states
    controlled = (*range(6 * nb), *range(own.start, own.stop))
    return Model(
        ny, len(prepared), len(curves), 6 * nb, controlled, begin, rate, None, row,
        (first, first + 1, first + 2, first + 3, first + 4), watch[0] if watch else None, watched, arrive,
    )  # fmt: skip
