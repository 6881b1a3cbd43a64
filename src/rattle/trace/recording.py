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
from collections.abc import Callable, Sequence
from dataclasses import replace
from types import CodeType, FunctionType, SimpleNamespace
from typing import Any

import numpy as np

from rattle.equations import motion, schur
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import choices, layout
from rattle.jit.functions import KernelFunction
from rattle.jit.workspace import ARRAYS
from rattle.language import bytecode as code
from rattle.language import jets
from rattle.language.expression import OPERATIONS
from rattle.language.recorded import Recorded, symbol_of
from rattle.trace.graph import FUNCTIONS, Graph, Symbol, both, select
from rattle.trace.recorded_table import recorded_table
from rattle.trace.symbol_arrays import Column, arrays

CLOSED = 1e-9  # residual that a projection may leave [m or rad, times the size of the mechanism where that is larger]
CONSTANT = frozenset(("mass", "weight", "gravity", "lever", "const"))  # float arrays that a run only reads


class Recorder:
    """Runs functions of the compiled layer on symbols of one graph; the journal of numbers that are recorded."""

    def __init__(self, graph: Graph, usual: bool = True) -> None:
        self.graph, self.usual = graph, usual  # usual: whether conditions that usually hold are taken for true
        self.guards: list[Symbol] = []
        self.assumed: dict[int, Symbol] = {}  # by place: what reading the model has found true of its parameters
        self._language = _language(graph)
        self._made: dict[Any, Callable[..., Any]] = {
            choices.select.python: select,
            choices.assume.python: self._assume,
            choices.usually.python: self._usually,
            **{one.python: own for one, own in self._language.items()},
        }
        self._math = SimpleNamespace(**{name: getattr(math, name) for name in dir(math)})
        for name in (*FUNCTIONS, "sqrt", "floor"):
            if hasattr(math, name):
                setattr(self._math, name, self._function(name, getattr(math, name)))
        self._builtins = {**vars(builtins), "float": _as_it_is, "min": _smaller, "max": _larger}

    def number(self, value: float, symbol: Symbol) -> Recorded:
        """A number of a model that stands for a symbol and is `value` [SI] where the record is made."""
        return Recorded(value, symbol, self)

    def table(self, block: Sequence[Any], x: Any) -> Any:
        """Symbol of the value of a table at x, of which numbers may be recorded."""
        return recorded_table(self.graph, [symbol_of(one) for one in block], 0, symbol_of(x))[0]

    def operation(self, op: int, *given: Any) -> Any:
        """Symbol of an operation of `language.bytecode` on constants of a model."""
        return self._language[code.unary if len(given) == 1 else code.binary](op, *given)

    def assume(self, condition: Any, holds: bool) -> None:
        """Keep what reading the model has found to be true, or false, of its parameters."""
        if isinstance(condition, Symbol):
            found = condition if holds else ~condition
            self.assumed[found.place] = found

    def largest(self, values: Sequence[Any]) -> Any:
        """The largest of some symbols and numbers; nan if one of them is."""
        result: Any = 0.0
        for one in values:
            result = select(one <= result, result, one)
        return result

    def _assume(self, condition: Any) -> Any:
        if isinstance(condition, Symbol):
            self.guards.append(condition)
            return True
        return condition

    def _usually(self, condition: Any) -> Any:
        return self._assume(condition) if self.usual or not isinstance(condition, Symbol) else False

    def _function(self, op: str, plain: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any) -> Any:
            recorded = any(isinstance(x, Symbol | Recorded) for x in given)
            return self.graph.apply(op, *given) if recorded else plain(*given)

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
            return arrays(self.graph)
        if isinstance(thing, KernelFunction):
            return self.recorded(thing.python)
        if isinstance(thing, FunctionType) and (thing in self._made or thing.__module__ == module):
            return self.recorded(thing)
        return thing

    def replace(self, function: KernelFunction | Callable[..., Any], own: Callable[..., Any]) -> None:
        """Record calls of a function by another one; before anything that calls it."""
        self._made[function.python if isinstance(function, KernelFunction) else function] = own

    def workspace(self, system: System) -> SimpleNamespace:
        """A workspace for recorded functions."""
        recorded = {name: array for name, array in system.arrays.items() if array.dtype == object}
        floats = {name: array.astype(float) for name, array in recorded.items()}
        plain = replace(system, arrays={**system.arrays, **floats}).plain_workspace()
        held: dict[str, Any] = {}
        for name in ARRAYS:
            array = getattr(plain, name)
            if isinstance(array, tuple):  # a table of kernels
                array = tuple(self.recorded(one) for one in array)
            elif name in recorded:
                array = _symbols(recorded[name])
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


def _symbols(array: np.ndarray) -> np.ndarray:
    """Numbers of which some are recorded, as symbols and floats."""
    made = np.empty(array.shape, dtype=object)
    made.ravel()[:] = [symbol_of(x) for x in array.ravel()]
    return made


def _as_it_is(x: Any) -> Any:
    if isinstance(x, Recorded):  # of a model, among columns of symbols
        return Column([symbol_of(x)])
    return x if isinstance(x, Symbol | Column) else float(x)


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


# ---------------------------------------------------------------- the language of expressions
COMPARISONS = {
    code.BELOW: operator.lt, code.BELOW_OR_AT: operator.le, code.ABOVE: operator.gt, code.ABOVE_OR_AT: operator.ge,
}  # fmt: skip


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
        if op == code.FLOOR:
            return whole(x)
        if op == code.SIGN:
            return select(x > 0.0, 1.0, select(x < 0.0, -1.0, x))
        return select(x >= 0.0, 1.0, select(x < 0.0, 0.0, x))  # STEP

    def binary(op: int, x: Any, y: Any) -> Any:
        if not (isinstance(x, Symbol) or isinstance(y, Symbol)):
            return code.binary.python(op, x, y)
        if op in pairs:
            return graph.apply(pairs[op], x, y)
        if op == code.MOD:
            return x - y * whole(graph.apply("div", x, y))
        if op in COMPARISONS:
            return select(COMPARISONS[op](x, y), 1.0, -1.0)
        first = (x <= y) if op in (code.MIN, code.BOTH) else (x >= y)
        return select(first | (x != x), x, y)

    def whole(x: Any) -> Any:
        return graph.apply("floor", x) if isinstance(x, Symbol) else code.whole.python(x)

    def chosen(condition: Any, yes: Any, no: Any) -> Any:
        known = not isinstance(condition, Symbol)
        return code.chosen.python(condition, yes, no) if known else select(condition > 0.0, yes, no)

    def choose_jet(stack: Any, top: int) -> None:
        if not isinstance(stack[top], Symbol):
            jets.choose_jet.python(stack, top)
            return
        holds = stack[top] > 0.0
        for n in range(3):
            stack[top + n] = select(holds, stack[top + 3 + n], stack[top + 6 + n])

    def read_table(table: Any, k: int, side: int, x: Any, dx: Any, ddx: Any) -> Any:
        return recorded_table(graph, table, k, x)

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

    return {
        code.unary: unary, code.binary: binary, code.quotient: quotient, code.power: power, code.whole: whole,
        code.chosen: chosen, code.read_table: read_table, jets.heading: heading, jets.choose_jet: choose_jet,
    }  # fmt: skip


def operation(graph: Graph, name: str, *given: Any) -> Any:
    """An operation or function of expressions, by its name in their trees, on symbols and numbers."""
    if name.startswith("if"):
        a, b, yes, no = given
        compare = {"if<": operator.lt, "if<=": operator.le, "if>": operator.gt, "if>=": operator.ge}[name]
        return select(compare(a, b), yes, no)
    op = OPERATIONS[name]
    kernel = (code.unary, code.binary, code.chosen)[len(given) - 1]
    return _language(graph)[kernel](*(given if op == code.CHOOSE else (op, *given)))


# ---------------------------------------------------------------- one model
class Recording:
    """Calculations of one model on symbols.

    A recording says nothing about states in which the flag of a calculation, see `guarded`, is not true.
    """

    def __init__(self, system: System, recorder: Recorder) -> None:
        if system.rough_joints:
            joints = ", ".join(system.rough_joints)
            raise TraceError(f"dry friction sticks and slips, which straight-line code cannot follow (joints {joints})")
        if len(system.arrays["contact"]):
            owners = system.arrays["contact"][:, layout.OWNER]
            joints = ", ".join(dict.fromkeys(system.joints[n] for n in owners))
            raise TraceError(f"contacts begin and end, which straight-line code cannot follow (joints {joints})")
        self.system, self.graph = system, recorder.graph
        self._recorder = recorder

    def guarded(self, calculation: Callable[[], Any]) -> tuple[Any, Any]:
        """What a calculation on symbols returns, and a flag: everything that it assumes is true."""
        guards = self._recorder.guards
        guards.clear()
        made = calculation()
        return made, both(self.graph, guards)

    def run(self, function: KernelFunction, *arguments: Any) -> SimpleNamespace:
        """Run a kernel (m, *arguments) on symbols; returns the workspace that it leaves."""
        workspace = self._recorder.workspace(self.system)
        self._recorder.recorded(function.python)(workspace, *arguments)
        return workspace

    def plain(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """A copy of a function over NumPy arrays that takes arrays of symbols."""
        return self._recorder.recorded(function)

    def derivative(self, t: Any, y: np.ndarray) -> list[Any]:
        """dy/dt [SI/s], (ny,)."""
        rate = np.zeros(len(y), dtype=object)
        self.run(motion.derivative, t, y, rate)
        return list(rate)

    def projection(self, t: Any, y: np.ndarray) -> list[Any]:
        """y brought onto the constraints, (ny,): two corrections of positions and one of rates.

        The corrections are those of `solvers.projection` next to the constraints, where it takes at most two.  A guard
        asks for what is left of the residuals.
        """
        y, closing = y.copy(), self.closing(t)
        nq = 3 * self.system.body_count
        q, v = y[:nq], y[nq : 2 * nq]
        closing.begin(q, v)
        closing.correct(q, v)
        closing.correct(q, v)
        left = closing.gap()
        if isinstance(left, Symbol):
            self._recorder.guards.append(left < CLOSED * max(1.0, self.system.size))
        closing.close_rates(v)
        return list(y)

    def closing(self, t: Any, prepare: Callable[[Any], None] = lambda workspace: None) -> Closing:
        """What brings positions and rates onto the constraints at the time t."""
        return Closing(self.system, self._recorder, t, prepare)


class Closing:
    """Corrections of positions q and rates v, (3 nb,) symbols each, at one time: those of `equations.motion`.

    prepare: changes values of joints in the workspace once the bodies are placed.
    """

    def __init__(
        self, system: System, recorder: Recorder, t: Any, prepare: Callable[[Any], None] = lambda workspace: None
    ) -> None:
        self.workspace, self._recorder = recorder.workspace(system), recorder
        self._t, self._prepare = t, prepare

    def _run(self, function: KernelFunction, *arguments: Any) -> Any:
        return self._recorder.recorded(function.python)(self.workspace, *arguments)

    def place(self, q: np.ndarray, v: np.ndarray) -> None:
        """Constraint rows at a state."""
        self._run(motion.place, q, v)
        self._prepare(self.workspace)
        self._run(motion.constraints)

    def begin(self, q: np.ndarray, v: np.ndarray) -> None:
        """Constraint rows and their factor at a state."""
        self._run(motion.drive, self._t)
        self.place(q, v)
        self._run(schur.factorise)

    def correct(self, q: np.ndarray, v: np.ndarray) -> None:
        """One correction of the positions, in place, with the factor at hand."""
        self.gap()
        self._run(motion.correct)
        q += self.workspace.change
        self.place(q, v)

    def gap(self) -> Any:
        """The largest residual [m or rad]."""
        return self._run(motion.residual)

    def close_rates(self, v: np.ndarray) -> None:
        """Correct the rates in place, with a factor at the present positions."""
        self._run(schur.factorise)
        self._run(motion.rate_residual)
        self._run(motion.correct)
        v += self.workspace.change
