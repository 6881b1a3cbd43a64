"""A recorded calculation together with its derivatives in several directions at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from rattle.errors import TraceError
from rattle.language.recorded import Operand
from rattle.trace.copying import bind
from rattle.trace.derivative import tangent
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph, Symbol
from rattle.trace.lane_chain import Function
from rattle.trace.lane_program import Compile, filled

COMPARE = frozenset(("less", "at_most"))


class Columns:
    """A function of a graph, called with any number of columns."""

    def __init__(self, graph: Graph, outputs: Sequence[Operand], compile_function: Compile) -> None:
        self._call = compile_function(*lower(graph, outputs))
        self._count = len(outputs)

    def __call__(self, columns: np.ndarray) -> np.ndarray:
        """Outputs (n_out, n) for inputs (n_in, n), n >= 1."""
        count = columns.shape[1]
        if not self._count:
            return np.empty((0, count))
        inputs = np.ascontiguousarray(columns[:, filled(count)])
        outputs = np.empty((self._count, inputs.shape[1]))
        self._call(inputs, outputs)
        return outputs[:, :count]


class Linearised:
    """Functions z = f(x) of a graph and their derivatives dz = f_x dx, for k directions dx at one point x.

    The directions are columns of one calculation, so that their number changes neither its size nor its compiling.
    """

    def __init__(self, graph: Graph, outputs: Sequence[Operand], compile_function: Compile) -> None:
        both, copied = bind(graph, outputs, {})
        seeds = {place: both.input() for place in list(both.inputs)}
        self._columns = Columns(both, [*copied, *tangent(both, copied, seeds)], compile_function)
        self._count = len(outputs)

    def __call__(self, x: np.ndarray, dx: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """z (n_out,) at x (n_in,), and dz (n_out, k) for dx (n_in, k), k >= 1.  Flags are 1 or 0; their dz is 0."""
        outputs = self._columns(np.vstack([np.repeat(x[:, None], dx.shape[1], axis=1), dx]))
        return outputs[: self._count, 0], outputs[self._count :]

    def at_points(self, x: np.ndarray, dx: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same at n points in one call: (n, n_out) and (n, n_out, k) for x (n, n_in) and dx (n, n_in, k)."""
        n, n_in, k = dx.shape
        outputs = self._columns(np.vstack([np.repeat(x.T, k, axis=1), dx.transpose(1, 0, 2).reshape(n_in, n * k)]))
        slopes = outputs[self._count :].reshape(self._count, n, k)
        return outputs[: self._count, ::k].T, slopes.transpose(1, 0, 2)


def live_without(graph: Graph, outputs: Sequence[Operand], flag: Operand) -> set[int]:
    """Places that outputs depend on while a flag is false."""
    false, seen = {graph.place(flag)}, set[int]()
    for place in sorted(graph.live(outputs)):  # operands come before what they are used for
        if graph.ops[place] == "both" and not false.isdisjoint(graph.operands[place]):
            false.add(place)
    ahead = [graph.place(x) for x in outputs]
    while ahead:
        place = ahead.pop()
        if place in seen:
            continue
        seen.add(place)
        operands = graph.operands[place]
        chosen = graph.ops[place] == "select" and operands[0] in false
        ahead += [operands[0], operands[2]] if chosen else operands
    return seen


def switching_functions(graph: Graph, outputs: Sequence[Operand], places: Iterable[int] | None = None) -> list[Operand]:
    """What changes its sign where a branch of a calculation changes.  Raises TraceError for what jumps otherwise.

    places: of operations, by default all that the outputs depend on.
    """
    margins: dict[int, Operand] = {}
    for place in graph.live(outputs) if places is None else places:
        if place in graph.estimates:
            continue
        op, operands = graph.ops[place], [Symbol(graph, k) for k in graph.operands[place]]
        if op == "floor":
            raise TraceError("an expression jumps (floor, mod): its sensitivities are not defined there")
        margin: object = None
        if op in COMPARE:
            margin = operands[0] - operands[1]
        elif op == "abs":
            margin = operands[0]
        elif op == "copysign":
            margin = operands[1]
        if isinstance(margin, Symbol):
            margins[margin.place] = margin
    return list(margins.values())


def by_numpy(graph: Graph, outputs: Sequence[Operand]) -> Function:
    """A function of a graph of exact operations that NumPy evaluates: for a few calls machine code takes longer."""

    def call(rows_in: np.ndarray, rows_out: np.ndarray) -> None:
        rows_out[:] = graph.evaluate(outputs, rows_in)

    return call
