"""Recording a model: the package's own kernels, run once on symbols, write down their operations.

Every function of the compiled layer is ordinary Python over arrays.  A recording runs copies of them in which the
names of `math`, of `select` and `assume` and of other kernels stand for their recorded counterparts; the arrays that
change hold symbols, those of structure stay as they are.  So loops unroll, structure folds away, and no formula is
written twice.  What the functions of expressions mean (`rattle.language.bytecode`) is said here once more in
operations of the graph, because there they are guarded against what Python raises.
"""

from __future__ import annotations

import builtins
import math
import operator
from collections.abc import Callable, Iterable, Sequence
from types import CodeType, FunctionType, SimpleNamespace
from typing import Any

import numpy as np

from rattle.equations import motion, schur, state
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import choices, layout
from rattle.jit.functions import KernelFunction
from rattle.jit.workspace import ARRAYS
from rattle.language import bytecode as code
from rattle.language import jets
from rattle.trace.graph import FUNCTIONS, Graph, Symbol, fold, select

CLOSED = 1e-9  # residual that a projection may leave [m or rad, times the size of the mechanism where that is larger]
CONSTANT = frozenset(("mass", "weight", "gravity", "lever", "const"))  # float arrays that a run only reads


class Recorder:
    """Runs functions of the compiled layer on symbols of one graph."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.guards: list[Symbol] = []
        self._made: dict[Any, Callable[..., Any]] = {
            choices.select.python: select,
            choices.assume.python: self._assume,
            **{one.python: own for one, own in _language(graph).items()},
        }
        self._math = SimpleNamespace(**{name: getattr(math, name) for name in dir(math)})
        for name in (*FUNCTIONS, "sqrt", "floor"):
            if hasattr(math, name):
                setattr(self._math, name, self._function(name, getattr(math, name)))
        self._builtins = {**vars(builtins), "float": _as_it_is, "min": _smaller, "max": _larger}

    def _assume(self, condition: Any) -> Any:
        if isinstance(condition, Symbol):
            self.guards.append(condition)
            return True
        return condition

    def _function(self, op: str, plain: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any) -> Any:
            return self.graph.apply(op, *given) if any(isinstance(x, Symbol) for x in given) else plain(*given)

        return call

    def recorded(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """A copy of a plain Python function of the compiled layer that takes symbols."""
        made = self._made.get(function)
        if made is None:
            assert isinstance(function, FunctionType)
            names: dict[str, Any] = {"__builtins__": self._builtins, "__name__": function.__module__}
            made = self._made[function] = FunctionType(
                function.__code__, names, function.__name__, function.__defaults__, function.__closure__
            )
            for name in _names(function.__code__):
                if name in function.__globals__:
                    names[name] = self._stand_in(function.__globals__[name], function.__module__)
        return made

    def _stand_in(self, thing: Any, module: str) -> Any:
        if thing is math:
            return self._math
        if thing is np:
            return _arrays(self.graph)
        if isinstance(thing, KernelFunction):
            return self.recorded(thing.python)
        if isinstance(thing, FunctionType) and thing.__module__ == module:
            return self.recorded(thing)
        return thing

    def workspace(self, system: System) -> SimpleNamespace:
        """A workspace for recorded functions."""
        plain = system.plain_workspace()
        held: dict[str, Any] = {}
        for name in ARRAYS:
            array = getattr(plain, name)
            if isinstance(array, tuple):  # a table of kernels
                array = tuple(self.recorded(one) for one in array)
            elif array.dtype == np.float64 and name not in CONSTANT:
                array = array.astype(object)
            held[name] = array
        return SimpleNamespace(**held)


def _names(found: CodeType) -> set[str]:
    """Names that a function looks up, those of functions inside it included."""
    names = set(found.co_names)
    for one in found.co_consts:
        if isinstance(one, CodeType):
            names |= _names(one)
    return names


def _as_it_is(x: Any) -> Any:
    return x if isinstance(x, Symbol) else float(x)


def _smaller(*given: Any) -> Any:
    if not any(isinstance(x, Symbol) for x in given):
        return min(*given)
    a, b = given
    return select(b < a, b, a)  # as Python and the machine: the first where they are equal or one is nan


def _larger(*given: Any) -> Any:
    if not any(isinstance(x, Symbol) for x in given):
        return max(*given)
    a, b = given
    return select(b > a, b, a)


class Column:
    """A few numbers or symbols side by side, for functions over arrays: NumPy asks comparisons for truth values."""

    def __init__(self, values: Iterable[Any]) -> None:
        self.values = list(values)

    @staticmethod
    def each(function: Callable[..., Any], *given: Any) -> Column:
        """A function element by element; numbers stand for columns of them."""
        count = max((len(x.values) for x in given if isinstance(x, Column)), default=1)
        spread = [x.values * (count // len(x.values)) if isinstance(x, Column) else [x] * count for x in given]
        return Column(function(*row) for row in zip(*spread, strict=True))

    def __getitem__(self, part: slice) -> Column:
        return Column(self.values[part])

    def clip(self, low: float, high: float) -> Column:
        """Values outside of the bounds become the bounds."""
        return self.each(lambda x: select(x < low, low, select(x > high, high, x)), self)

    def __neg__(self) -> Column:
        return self.each(operator.neg, self)

    def __add__(self, other: Any) -> Column:
        return self.each(operator.add, self, other)

    def __radd__(self, other: Any) -> Column:
        return self.each(operator.add, other, self)

    def __sub__(self, other: Any) -> Column:
        return self.each(operator.sub, self, other)

    def __mul__(self, other: Any) -> Column:
        return self.each(operator.mul, self, other)

    def __rmul__(self, other: Any) -> Column:
        return self.each(operator.mul, other, self)

    def __truediv__(self, other: Any) -> Column:
        return self.each(_quotient, self, other)

    def __gt__(self, other: Any) -> Column:
        return self.each(operator.gt, self, other)


def _quotient(a: Any, b: Any) -> Any:
    return a / b if isinstance(a, Symbol) or isinstance(b, Symbol) else fold("div", a, b)


class Table:
    """Rows of numbers or symbols, of which columns are taken as of an array."""

    def __init__(self, rows: Sequence[Sequence[Any]]) -> None:
        self.rows = rows

    def __getitem__(self, part: tuple[slice, int | slice]) -> Any:
        everything, columns = part
        assert everything == slice(None)
        if isinstance(columns, slice):
            width = range(len(self.rows[0]))[columns]
            return SimpleNamespace(T=[self[:, c] for c in width])
        return Column(row[columns] for row in self.rows)


def _arrays(graph: Graph) -> SimpleNamespace:
    """What functions over columns of symbols find under the name of NumPy."""

    def each(op: str) -> Callable[..., Column]:
        return lambda *given: Column.each(lambda *row: graph.apply(op, *row), *given)

    return SimpleNamespace(
        hypot=each("hypot"), cos=each("cos"), sin=each("sin"), where=lambda *given: Column.each(select, *given),
        zeros_like=lambda x: Column([0.0] * len(x.values)), errstate=np.errstate, ndarray=np.ndarray,
        array=lambda parts: SimpleNamespace(T=[one.values for one in parts]), ascontiguousarray=lambda x: x,
    )  # fmt: skip


# ---------------------------------------------------------------- the language of expressions
def _language(graph: Graph) -> dict[KernelFunction, Callable[..., Any]]:
    """What the functions of `bytecode` that branch on values are in a graph."""
    names = {
        code.SQRT: "sqrt", code.EXP: "exp", code.LOG: "log", code.SIN: "sin", code.COS: "cos", code.TAN: "tan",
        code.ASIN: "asin", code.ACOS: "acos", code.ATAN: "atan", code.TANH: "tanh",
    }  # fmt: skip
    pairs = {code.ADD: "add", code.SUB: "sub", code.MUL: "mul", code.DIV: "div", code.POW: "pow"}
    pairs |= {code.ATAN2: "atan2", code.HYPOT: "hypot"}

    def unary(op: int, x: Any) -> Any:
        if not isinstance(x, Symbol):
            return code.unary.python(op, x)
        if op in names:
            return graph.apply(names[op], x)
        if op == code.NEG:
            return -x
        if op == code.SQUARE:
            return x * x
        if op == code.ABS:
            return abs(x)
        if op == code.SIGN:
            return select(x > 0.0, 1.0, select(x < 0.0, -1.0, x))
        return select(x >= 0.0, 1.0, select(x < 0.0, 0.0, x))  # STEP

    def binary(op: int, x: Any, y: Any) -> Any:
        if not (isinstance(x, Symbol) or isinstance(y, Symbol)):
            return code.binary.python(op, x, y)
        if op in pairs:
            return graph.apply(pairs[op], x, y)
        first = (x <= y) if op == code.MIN else (x >= y)
        return select(first | (x != x), x, y)

    def quotient(x: Any, y: Any) -> Any:
        known = not (isinstance(x, Symbol) or isinstance(y, Symbol))
        return code.quotient.python(x, y) if known else graph.apply("div", x, y)

    def power(x: Any, y: Any) -> Any:
        known = not (isinstance(x, Symbol) or isinstance(y, Symbol))
        return code.power.python(x, y) if known else graph.apply("pow", x, y)

    def heading(s: Any, ds: Any, dds: Any) -> int:
        if any(isinstance(x, Symbol) for x in (s, ds, dds)):
            return 0  # the values of the definition: where s = 0 itself counts, runs are left to the generic kernels
        return int(jets.heading.python(s, ds, dds))

    return {code.unary: unary, code.binary: binary, code.quotient: quotient, code.power: power, jets.heading: heading}


# ---------------------------------------------------------------- one model
class Recording:
    """One model on symbols: the inputs t and y, and what its kernels make of them.

    Everything stands in one graph, whose inputs are t, then y.  A recording says nothing about states in which the flag
    of a calculation, see `guarded`, is not true.
    """

    def __init__(self, system: System) -> None:
        if len(system.arrays["contact"]):
            owners = system.arrays["contact"][:, layout.OWNER]
            joints = ", ".join(dict.fromkeys(system.joints[n] for n in owners))
            raise TraceError(f"contacts begin and end, which straight-line code cannot follow (joints {joints})")
        self.system = system
        self.graph = Graph()
        self._recorder = Recorder(self.graph)
        self.t = self.graph.input()
        self.y = np.array([self.graph.input() for _ in range(state.state_layout(system).size)], dtype=object)

    def guarded(self, calculation: Callable[[], Any]) -> tuple[Any, Any]:
        """What a calculation on symbols returns, and a flag: everything that it assumes is true."""
        guards = self._recorder.guards
        guards.clear()
        made = calculation()
        flag: Any = True
        for one in guards:
            flag = self.graph.apply("both", flag, one)
        return made, flag

    def run(self, function: KernelFunction, *arguments: Any) -> SimpleNamespace:
        """Run a kernel (m, *arguments) on symbols; returns the workspace that it leaves."""
        workspace = self._recorder.workspace(self.system)
        self._recorder.recorded(function.python)(workspace, *arguments)
        return workspace

    def plain(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """A copy of a function over NumPy arrays that takes arrays of symbols."""
        return self._recorder.recorded(function)

    def derivative(self) -> list[Any]:
        """dy/dt [SI/s], (ny,)."""
        rate = np.zeros(len(self.y), dtype=object)
        self.run(motion.derivative, self.t, self.y, rate)
        return list(rate)

    def projection(self) -> list[Any]:
        """y brought onto the constraints, (ny,): two corrections of positions and one of rates.

        The corrections are those of `solvers.projection` next to the constraints, where it takes at most two.  A guard
        asks for what is left of the residuals.
        """
        y, workspace = self.y.copy(), self._recorder.workspace(self.system)
        nq = workspace.change.shape[0]
        q, v = y[:nq], y[nq : 2 * nq]
        place, constraints, factorise, residual, rate_residual, correct, drive = (
            self._recorder.recorded(one.python)
            for one in (
                motion.place, motion.constraints, schur.factorise, motion.residual, motion.rate_residual,
                motion.correct, motion.drive,
            )
        )  # fmt: skip
        place(workspace, q, v)
        drive(workspace, self.t)
        constraints(workspace)
        factorise(workspace)
        for _ in range(2):
            residual(workspace)
            correct(workspace)
            q += workspace.change
            place(workspace, q, v)
            constraints(workspace)
        left = residual(workspace)
        if isinstance(left, Symbol):
            self._recorder.guards.append(left < CLOSED * max(1.0, self.system.size))
        factorise(workspace)
        rate_residual(workspace)
        correct(workspace)
        v += workspace.change
        return list(y)
