"""Operations as a graph: what a calculation does, recorded by running it once on symbols.

A `Symbol` stands for one number of the calculation.  Arithmetic with symbols adds operations to its `Graph`; equal
operations are shared, and exact ones on numbers alone are folded.  Operations are exact as IEEE 754 says (+ - * /,
square root, floor, comparisons, choices, exponents) or functions (sin, exp ...), which `elementary.lower` takes apart
into exact operations.  So every target computes the same bits: nothing is reassociated and nothing contracted.

A symbol has no truth value: a calculation that branches on one cannot be recorded, and says where it does.
Zero times a symbol is folded to zero, as if the symbol were finite.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Literal, TypeGuard, get_args, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rattle.errors import InputError, TraceError
from rattle.language.operations import OPERATIONS
from rattle.language.recorded import Flag, Operand, Recorded, symbol_of
from rattle.value_types import Floats

# exact operations: number of operands
EXACT = {
    "add": 2, "sub": 2, "mul": 2, "div": 2, "neg": 1, "abs": 1, "sqrt": 1, "floor": 1,
    "less": 2, "at_most": 2, "equal": 2, "both": 2, "either": 2, "not": 1, "select": 3,
    "power_of_two": 1, "exponent": 1, "mantissa": 1,
}  # fmt: skip
# functions, see `elementary`: those of expressions, and one of kernels
FUNCTIONS = {
    **{record.recorded: record.operands for record in OPERATIONS.values() if record.recorded not in ("", *EXACT)},
    "copysign": 2,
}
FlagOp = Literal["less", "at_most", "equal", "both", "either", "not"]
FLAGS = frozenset(get_args(FlagOp))  # their results are true or false
COMMUTE = frozenset(("add", "mul", "equal", "both", "either"))
ROUND = 6755399441055744.0  # 1.5 * 2^52: added to |x| < 2^51 it leaves the nearest integer in the lowest bits


class Symbol:
    """One number (or flag) of a recorded calculation: operation number `place` of its graph."""

    __slots__ = ("graph", "place")
    __array_priority__ = 1000.0  # numbers of NumPy leave the operation to the symbol

    def __init__(self, graph: Graph, place: int) -> None:
        self.graph, self.place = graph, place

    @property
    def op(self) -> str:
        """Name of the operation."""
        return self.graph.ops[self.place]

    def __bool__(self) -> bool:
        raise TraceError(f"{_where()}: a branch on a value that is not known when the trace is made; write select(...)")

    def __float__(self) -> float:
        raise TraceError(f"{_where()}: expected a number, but its value is not known when the trace is made")

    __int__ = __index__ = __float__  # all three refuse

    def __repr__(self) -> str:
        return f"<Symbol {self.place}: {self.op}>"

    def __add__(self, other: Operand) -> Operand:
        return self.graph.apply("add", self, other)

    def __radd__(self, other: Operand) -> Operand:
        return self.graph.apply("add", other, self)

    def __sub__(self, other: Operand) -> Operand:
        return self.graph.apply("sub", self, other)

    def __rsub__(self, other: Operand) -> Operand:
        return self.graph.apply("sub", other, self)

    def __mul__(self, other: Operand) -> Operand:
        return self.graph.apply("mul", self, other)

    def __rmul__(self, other: Operand) -> Operand:
        return self.graph.apply("mul", other, self)

    def __truediv__(self, other: Operand) -> Operand:
        return self.graph.apply("div", self, other)

    def __rtruediv__(self, other: Operand) -> Operand:
        return self.graph.apply("div", other, self)

    def __neg__(self) -> Operand:
        return self.graph.apply("neg", self)

    def __pos__(self) -> Operand:
        return self

    def __abs__(self) -> Operand:
        return self.graph.apply("abs", self)

    def __pow__(self, other: Operand) -> Operand:
        if isinstance(other, int) and 0 < other <= 4:
            product: Operand = self
            for _ in range(other - 1):
                product = product * self
            return product
        return self.graph.apply("pow", self, other)

    def __rpow__(self, other: Operand) -> Operand:
        return self.graph.apply("pow", other, self)

    def __mod__(self, other: Operand) -> Operand:
        return self - other * self.graph.apply("floor", self / other)

    def __lt__(self, other: Operand) -> Flag:
        return self.graph.apply("less", self, other)

    def __le__(self, other: Operand) -> Flag:
        return self.graph.apply("at_most", self, other)

    def __gt__(self, other: Operand) -> Flag:
        return self.graph.apply("less", other, self)

    def __ge__(self, other: Operand) -> Flag:
        return self.graph.apply("at_most", other, self)

    def __and__(self, other: Flag) -> Flag:
        return self.graph.apply("both", self, other)

    def __rand__(self, other: Flag) -> Flag:
        return self.graph.apply("both", other, self)

    def __or__(self, other: Flag) -> Flag:
        return self.graph.apply("either", self, other)

    def __ror__(self, other: Flag) -> Flag:
        return self.graph.apply("either", other, self)

    def __invert__(self) -> Flag:
        return self.graph.apply("not", self)

    def __eq__(self, other: Any) -> Any:
        return self.graph.apply("equal", self, other)

    def __ne__(self, other: Any) -> Any:
        return self.graph.apply("not", self.graph.apply("equal", self, other))

    __hash__ = None  # type: ignore[assignment]  # places are what dictionaries hold


def select(condition: Operand, yes: Operand, no: Operand) -> Operand:
    """`yes` where the condition holds, `no` elsewhere; both are computed."""
    if isinstance(condition, Symbol):
        return condition.graph.apply("select", condition, yes, no)
    return yes if condition else no


def select_flag(condition: Flag, yes: Flag, no: Flag) -> Flag:
    """`yes` where the condition holds, `no` elsewhere, of flags."""
    return (condition & yes) | (apply("not", condition) & no)


@overload
def apply(op: FlagOp, *operands: Operand) -> Flag: ...
@overload
def apply(op: str, *operands: Operand) -> Operand | Flag: ...
def apply(op: str, *operands: Operand) -> Operand:
    """An operation of the graph of its operands; of numbers alone an exact one is done."""
    symbols = [x.symbol if isinstance(x, Recorded) else x for x in operands]
    graph = next((x.graph for x in symbols if isinstance(x, Symbol)), None)
    return graph.apply(op, *symbols) if graph is not None else fold(op, *symbols)


def summed(terms: Iterable[Operand]) -> Operand:
    """Their sum, from the first one on."""
    result: Operand = 0.0
    for term in terms:
        result = result + term
    return result


def both(graph: Graph, flags: Iterable[Flag]) -> Flag:
    """A flag: all of these are true."""
    result: Flag = True
    for flag in flags:
        result = graph.apply("both", result, flag)
    return result


class Graph:
    """A recorded calculation: operations in an order in which they can be done."""

    def __init__(self) -> None:
        self.ops: list[str] = []
        self.operands: list[tuple[int, ...]] = []
        self.numbers: dict[int, float] = {}  # of the operations that are numbers
        self.inputs: list[int] = []  # places of the inputs, in order
        self.estimates: set[int] = set()  # places of operations whose branches do not show in what comes of them
        self._known: dict[object, int] = {}
        self._lowered: tuple[Graph, dict[int, Operand]] | None = None

    def __len__(self) -> int:
        return len(self.ops)

    def input(self) -> Symbol:
        """A new input."""
        place = self._put("input", ())
        self.inputs.append(place)
        return Symbol(self, place)

    def _put(self, op: str, operands: tuple[int, ...]) -> int:
        self.ops.append(op)
        self.operands.append(operands)
        return len(self.ops) - 1

    def number(self, value: float) -> int:
        """Place of a number; -0.0 and 0.0 are two, all nan are one."""
        value = float(value)
        key = ("number", value, math.copysign(1.0, value)) if value == value else ("number", "nan")
        place = self._known.get(key)
        if place is None:
            place = self._known[key] = self._put("number", ())
            self.numbers[place] = value
        return place

    def place(self, x: Operand) -> int:
        """Place of a symbol or number."""
        if isinstance(x, Recorded):
            x = symbol_of(x)
        if isinstance(x, Symbol):
            if x.graph is not self:
                raise TraceError("symbols of two traces were mixed")
            return x.place
        return self.number(float(x))

    @overload
    def apply(self, op: FlagOp, *operands: Operand) -> Flag: ...
    @overload
    def apply(self, op: str, *operands: Operand) -> Operand | Flag: ...
    def apply(self, op: str, *operands: Operand) -> Operand:
        """The result of an operation: a number if it is known, the operand it leaves as it is, or a symbol."""
        numbers, held, constant = self.numbers, [], True
        for x in operands:
            if type(x) is not Symbol and isinstance(x, Recorded | Symbol):
                x = symbol_of(x) if isinstance(x, Recorded) else Symbol(x.graph, x.place)
            if type(x) is Symbol:
                if x.graph is self and x.place in numbers:
                    x = numbers[x.place]
                else:
                    constant = False
            held.append(x)
        if constant and op in EXACT:
            return fold(op, *held)
        if op in SIMPLER and (simple := SIMPLER[op](self, *held)) is not None:
            return simple
        places = tuple([x.place if type(x) is Symbol and x.graph is self else self.place(x) for x in held])
        return Symbol(self, self.join(op, places))

    def join(self, op: str, places: tuple[int, ...]) -> int:
        """Place of an operation that cannot be simplified, on those at other places."""
        if op in COMMUTE and places[0] > places[1]:
            places = places[::-1]
        key = (op, places)
        place = self._known.get(key)
        if place is None:
            place = self._known[key] = self._put(op, places)
        return place

    def live(self, outputs: Iterable[Operand]) -> list[int]:
        """Places that the outputs depend on, in order; inputs among them only if they are used."""
        seen: set[int] = set()
        ahead = [self.place(x) for x in outputs]
        while ahead:
            place = ahead.pop()
            if place not in seen:
                seen.add(place)
                ahead += self.operands[place]
        return sorted(seen)

    def count(self, outputs: Iterable[Operand]) -> int:
        """Number of operations that the outputs take."""
        return sum(self.ops[place] not in ("input", "number") for place in self.live(outputs))

    def evaluate(self, outputs: Sequence[Operand], inputs: ArrayLike) -> np.ndarray:
        """Outputs (n_out, n) for inputs (n_in, n), by NumPy: the reference for every target; flags are 0 or 1.

        The graph must be of exact operations alone, see `elementary.lower`.
        """
        columns = np.asarray(inputs, dtype=float)
        if columns.ndim != 2 or columns.shape[0] != len(self.inputs):
            raise InputError(f"inputs: an array ({len(self.inputs)}, n) expected, not {columns.shape}")
        rank = {place: n for n, place in enumerate(self.inputs)}
        values: dict[int, np.float64 | Floats] = {}
        with np.errstate(all="ignore"):
            for place in self.live(outputs):
                op = self.ops[place]
                if op == "input":
                    values[place] = columns[rank[place]]
                elif op == "number":
                    values[place] = np.float64(self.numbers[place])
                else:
                    values[place] = NUMPY[op](*(values[k] for k in self.operands[place]))
        result = np.empty((len(outputs), columns.shape[1]))
        for n, x in enumerate(outputs):
            result[n] = values[self.place(x)]
        return result


# ---------------------------------------------------------------- numbers alone
def _bits(x: ArrayLike) -> NDArray[np.int64]:
    return np.asarray(x, dtype=np.float64).view(np.int64)


def _power_of_two(n: NDArray[np.float64]) -> NDArray[np.float64]:
    """2^n for a whole n from -1022 to 1023, by its bits."""
    return ((_bits(np.asarray(n + (ROUND + 1023.0))) & 0xFFF) << 52).view(np.float64)


NUMPY: dict[str, Callable[..., Any]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "neg": np.negative, "abs": np.abs,
    "sqrt": np.sqrt, "floor": np.floor, "less": np.less, "at_most": np.less_equal, "equal": np.equal,
    "both": np.logical_and, "either": np.logical_or, "not": np.logical_not, "select": np.where,
    "power_of_two": _power_of_two,
    "exponent": lambda x: ((_bits(x) >> 52) & 0x7FF).astype(np.float64) - 1023.0,
    "mantissa": lambda x: ((_bits(x) & 0xFFFFFFFFFFFFF) | 0x3FF0000000000000).view(np.float64),
}  # fmt: skip


def fold(op: str, *operands: Operand) -> Operand:
    """An exact operation on numbers."""
    with np.errstate(all="ignore"):
        result = NUMPY[op](*(x if isinstance(x, bool) else np.float64(x) for x in operands))
    return bool(result) if op in FLAGS else float(result)


def _is(x: Operand, value: float) -> bool:
    return not isinstance(x, Symbol) and x == value


def _is_negative(x: Operand) -> TypeGuard[Symbol]:
    return type(x) is Symbol and x.op == "neg"


def _without_signs(graph: Graph, op: str, a: Operand, b: Operand) -> Operand:
    """A product or quotient of which one or both are negated: the sign goes outwards, where a sum may take it."""
    inner = [Symbol(graph, graph.operands[x.place][0]) if _is_negative(x) else x for x in (a, b)]
    if _is_negative(a) and _is_negative(b):
        return graph.apply(op, *inner)
    if not isinstance(a, Symbol):
        return graph.apply(op, -a, inner[1])
    if not isinstance(b, Symbol):
        return graph.apply(op, inner[0], -b)
    return graph.apply("neg", graph.apply(op, *inner))


def _negated(graph: Graph, x: Symbol) -> Symbol:
    """What a negated (or inverted) symbol is the opposite of."""
    return Symbol(graph, graph.operands[x.place][0])


def _simple_sum(graph: Graph, a: Operand, b: Operand) -> Operand | None:
    if _is(a, 0.0):
        return b
    if _is(b, 0.0):
        return a
    if _is_negative(a):
        return graph.apply("sub", b, _negated(graph, a))
    return graph.apply("sub", a, _negated(graph, b)) if _is_negative(b) else None


def _simple_difference(graph: Graph, a: Operand, b: Operand) -> Operand | None:
    if _is(b, 0.0):
        return a
    if _is(a, 0.0):
        return graph.apply("neg", b)
    return graph.apply("add", a, _negated(graph, b)) if _is_negative(b) else None


def _simple_product(graph: Graph, a: Operand, b: Operand) -> Operand | None:
    if _is_negative(a) or _is_negative(b):
        return _without_signs(graph, "mul", a, b)
    for factor, other in ((a, b), (b, a)):
        if _is(factor, 0.0):
            return 0.0
        if _is(factor, 1.0):
            return other
        if _is(factor, -1.0):
            return graph.apply("neg", other)
    return None


def _simple_quotient(graph: Graph, a: Operand, b: Operand) -> Operand | None:
    if _is_negative(a) or _is_negative(b):
        return _without_signs(graph, "div", a, b)
    if _is(b, 1.0):
        return a
    return 0.0 if _is(a, 0.0) else None


def _simple_flag(op: str) -> Callable[[Graph, Operand, Operand], Operand | None]:
    stays = op == "both"  # True and x is x; False or x is x

    def simple(graph: Graph, a: Operand, b: Operand) -> Operand | None:
        for flag, other in ((a, b), (b, a)):
            if not isinstance(flag, Symbol):
                return other if bool(flag) == stays else not stays
        return None

    return simple


def _simple_choice(graph: Graph, condition: Operand, yes: Operand, no: Operand) -> Operand | None:
    if not isinstance(condition, Symbol):
        return yes if condition else no
    return yes if graph.place(yes) == graph.place(no) else None


# the result of an operation where it takes none, or a simpler one; else None
SIMPLER: dict[str, Callable[..., Operand | None]] = {
    "add": _simple_sum, "sub": _simple_difference, "mul": _simple_product, "div": _simple_quotient,
    "neg": lambda graph, x: _negated(graph, x) if x.op == "neg" else None,
    "not": lambda graph, x: _negated(graph, x) if x.op == "not" else None,
    "copysign": lambda graph, size, sign: 0.0 if _is(size, 0.0) else None,
    "both": _simple_flag("both"), "either": _simple_flag("either"), "select": _simple_choice,
}  # fmt: skip


def _where() -> str:
    """File, line and text of the calculation that cannot be recorded: the nearest frame outside this room."""
    frame = sys._getframe(1)
    here = str(Path(__file__).parent)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(here):
        frame = frame.f_back
    name, line = frame.f_code.co_filename, frame.f_lineno
    import linecache

    text = linecache.getline(name, line).strip()
    return f'{Path(name).name}, line {line} ({frame.f_code.co_name}): "{text}"'
