"""Recording a model: the package's own kernels, run once on symbols, write down their operations.

Every function of the compiled layer is ordinary Python over arrays.  A recording runs copies of them in which the
names of `math`, of `select` and `assume` and of other kernels stand for their recorded counterparts; the arrays that
change hold symbols, those of structure stay as they are.  So loops unroll, structure folds away, and no formula is
written twice; see `recorded_language`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, TypeVar

import numpy as np

from rattle.equations import motion, schur, state
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import choices, layout
from rattle.jit import layout as at
from rattle.jit.functions import KernelFunction
from rattle.jit.workspace import ARRAYS
from rattle.language import bytecode as code
from rattle.language.operations import CHOICES, CHOOSE, OPERATIONS
from rattle.language.recorded import Flag, Operand, Recorded, symbol_of
from rattle.trace.graph import Graph, Symbol, both, select
from rattle.trace.recorded_contacts import RecordedContacts
from rattle.trace.recorded_friction import RecordedFriction
from rattle.trace.recorded_language import Copies
from rattle.trace.recorded_switches import Driven, RecordedSwitches
from rattle.trace.recorded_table import recorded_table
from rattle.trace.symbol_arrays import arrays
from rattle.value_types import Plain

T = TypeVar("T")
Prepare = Callable[[SimpleNamespace], None]  # changes values of joints in a workspace
CLOSED = 1e-9  # residual that a projection may leave [m or rad, times the size of the mechanism where that is larger]
CONSTANT = frozenset(("mass", "weight", "gravity", "lever", "const"))  # float arrays that a run only reads


class Recorder:
    """Runs functions of the compiled layer on symbols of one graph; the journal of numbers that are recorded."""

    def __init__(self, graph: Graph, beside: float = 0.0, crowded: bool = False) -> None:
        """beside: conditions x > a that usually hold are taken for true; if not 0 for false, and x > beside a has to
        be; crowded: more rigid contacts with friction at one instant, see `recorded_rigid`."""
        self.graph, self.beside, self.crowded = graph, beside, crowded
        self.guards: list[Flag] = []
        self.assumed: dict[int, Flag] = {}  # by place: what reading the model has found true of its parameters
        own = {choices.assume.python: self._assume, choices.usually.python: self._usually}
        self._copies = Copies(own, arrays(graph))
        self.contacts: RecordedContacts | None = None  # None: a model with contacts cannot be recorded
        self.friction: RecordedFriction | None = None  # None: one with friction in joints cannot be

    def record_friction(self, system: System, modes: bool, slopes: bool) -> None:
        """Let systems with the friction of joints of this one be recorded; before anything else is.

        modes: also where it sticks and slips, with contacts; slopes: it is differentiated.  Raises TraceError.
        """
        if system.rough_joints:
            self.friction = RecordedFriction(self.graph, system, modes, slopes)
            self.friction.begin(self._copies)

    def record_contacts(self, system: System, lanes: bool) -> RecordedContacts:
        """Let systems with the contacts of this one be recorded; before anything else is.  Raises TraceError.

        lanes: as these follow them, else as derivatives do.
        """
        switches = RecordedSwitches(self.graph, system) if lanes else None
        if switches is not None:
            switches.begin(self._copies)
        self.contacts = RecordedContacts(self.graph, system, lanes, self.friction, switches, self.crowded)
        self.contacts.begin(self._copies)
        return self.contacts

    def number(self, value: float, symbol: Symbol) -> Recorded:
        """A number of a model that stands for a symbol and is `value` [SI] where the record is made."""
        return Recorded(value, symbol, self)

    def table(self, block: Sequence[Operand], x: Operand) -> Operand:
        """Symbol of the value of a table at x, of which numbers may be recorded."""
        return recorded_table([symbol_of(number) for number in block], 0, symbol_of(x))[0]

    def operation(self, op: int, *operands: Operand) -> Operand:
        """Symbol of an operation of `language.bytecode` on constants of a model."""
        result: Operand = self._copies.of(code.RECORDS[op].value.python)(*operands)
        return result

    def assume(self, condition: Flag, holds: bool) -> None:
        """Keep what reading the model has found to be true, or false, of its parameters."""
        if isinstance(condition, Symbol):
            assumption = condition if holds else ~condition
            self.assumed[self.graph.place(assumption)] = assumption

    def largest(self, values: Sequence[Operand]) -> Operand:
        """The largest of some symbols and numbers; nan if one of them is."""
        result: Operand = 0.0
        for value in values:
            result = select(value <= result, result, value)
        return result

    def _assume(self, condition: Flag) -> Flag:
        if isinstance(condition, Symbol):
            self.guards.append(condition)
            return True
        return condition

    def _usually(self, condition: Flag) -> Flag:
        if not self.beside or not isinstance(condition, Symbol):
            return self._assume(condition)
        assert condition.op == "less", "a condition x > a"
        least, x = self.graph.operands[condition.place]
        self._assume(Symbol(self.graph, x) > self.beside * self.graph.numbers[least])
        return False

    def recorded(self, function: Plain) -> Plain:
        """A copy of a plain Python function of the compiled layer that takes symbols."""
        return self._copies.of(function)

    def replace(self, function: KernelFunction | Plain, own: Plain) -> None:
        """Record calls of a function by another one; before anything that calls it."""
        self._copies.replace(function.python if isinstance(function, KernelFunction) else function, own)

    def workspace(self, system: System) -> SimpleNamespace:
        """A workspace for recorded functions."""
        recorded = {name: array for name, array in system.arrays.items() if array.dtype == object}
        floats = {name: array.astype(float) for name, array in recorded.items()}
        plain = replace(system, arrays={**system.arrays, **floats}).plain_workspace()
        held: dict[str, object] = {}
        for name in ARRAYS:
            array = getattr(plain, name)
            if isinstance(array, tuple):  # a table of kernels
                array = tuple(self.recorded(kernel) for kernel in array)
            elif name in recorded:
                array = _symbols(recorded[name])
            elif array.dtype == np.float64 and name not in CONSTANT:
                array = array.astype(object)
            held[name] = array
        workspace = SimpleNamespace(**held)
        if self.contacts is not None:
            self.contacts.prepare(workspace)
        return workspace


def _symbols(array: np.ndarray) -> np.ndarray:
    """Numbers of which some are recorded, as symbols and floats."""
    symbols = np.empty(array.shape, dtype=object)
    symbols.ravel()[:] = [symbol_of(x) for x in array.ravel()]
    return symbols


def operation(name: str, *operands: Operand) -> Operand:
    """An operation or function of expressions, by its name in their trees, on symbols and numbers."""
    if name in CHOICES:
        a, b, yes, no = operands
        return select(CHOICES[name](a, b), yes, no)
    value = code.chosen if name == CHOOSE else OPERATIONS[name].value
    result: Operand = EXPRESSIONS.of(value.python)(*operands)
    return result


EXPRESSIONS = Copies()


# ---------------------------------------------------------------- one model
class Recording:
    """Calculations of one model on symbols.

    A recording says nothing about states in which the flag of a calculation, see `guarded`, is not true.
    """

    def __init__(self, system: System, recorder: Recorder) -> None:
        if system.rough_joints and recorder.friction is None:
            joints = ", ".join(system.rough_joints)
            raise TraceError(f"friction of joints (joints {joints}) cannot be straight-line code here")
        if len(system.arrays["contact"]) and recorder.contacts is None:
            owners = system.arrays["contact"][:, layout.OWNER]
            joints = ", ".join(dict.fromkeys(system.joints[n] for n in owners))
            raise TraceError(f"contacts begin and end, which straight-line code cannot follow (joints {joints})")
        self.system, self.graph = system, recorder.graph
        self._recorder = recorder

    def guarded(self, calculation: Callable[[], T]) -> tuple[T, Flag]:
        """What a calculation on symbols returns, and a flag: everything that it assumes is true."""
        guards = self._recorder.guards
        guards.clear()
        outcome = calculation()
        return outcome, both(self.graph, guards)

    def run(self, function: KernelFunction, *arguments: object) -> SimpleNamespace:
        """Run a kernel (m, *arguments) on symbols; returns the workspace that it leaves."""
        workspace = self._recorder.workspace(self.system)
        self._recorder.recorded(function.python)(workspace, *arguments)
        return workspace

    def plain(self, function: Plain) -> Plain:
        """A copy of a function over NumPy arrays that takes arrays of symbols."""
        return self._recorder.recorded(function)

    def derivative(self, t: Operand, y: np.ndarray) -> list[Operand]:
        """dy/dt [SI/s], (ny,)."""
        rate = np.zeros(len(y), dtype=object)
        self.run(motion.derivative, t, y, rate)
        return list(rate)

    def driven(self, workspace: SimpleNamespace, t: Operand) -> list[Driven]:
        """What drivers prescribe at t [s], and gravity that is a function of time."""
        values = workspace.values
        self._recorder.recorded(motion.drive.python)(workspace, t)
        prescribed = []
        for row in workspace.jet:
            k = row[at.TARGET]
            travels = row[at.TRAVEL] >= 0
            prescribed.append(Driven(0.0 if travels else values[k], values[k + 1], values[k + 2]))
        if len(workspace.falling):
            self._recorder.recorded(motion.fall.python)(workspace, t)
            prescribed += [Driven(values[row[at.TARGET]]) for row in workspace.falling]
        return prescribed

    def projection(self, t: Operand, y: np.ndarray) -> list[Operand]:
        """y brought onto the constraints, (ny,): two corrections of positions and one of rates.

        The corrections are those of `solvers.projection` next to the constraints, where it takes at most two.  A guard
        asks for what is left of the residuals.
        """
        y, closing = y.copy(), self.closing(t)
        nq = 3 * self.system.body_count
        q, v = y[:nq], y[nq : 2 * nq]
        closing.take_travels(y)
        closing.begin(q, v)
        closing.correct(q, v)
        closing.correct(q, v)
        left = closing.gap()
        if isinstance(left, Symbol):
            self._recorder.guards.append(left < CLOSED * max(1.0, self.system.size))
        closing.close_rates(v)
        return list(y)

    def closing(self, t: Operand, prepare: Prepare = lambda workspace: None) -> Closing:
        """What brings positions and rates onto the constraints at the time t."""
        return Closing(self.system, self._recorder, t, prepare)


class Closing:
    """Corrections of positions q and rates v, (3 nb,) symbols each, at one time: those of `equations.motion`.

    prepare: changes values of joints in the workspace once the bodies are placed.
    """

    def __init__(
        self, system: System, recorder: Recorder, t: Operand, prepare: Prepare = lambda workspace: None
    ) -> None:
        self.workspace, self._recorder = recorder.workspace(system), recorder
        self._t, self._prepare = t, prepare

    def _run(self, function: KernelFunction, *arguments: object) -> Any:
        return self._recorder.recorded(function.python)(self.workspace, *arguments)

    def place(self, q: np.ndarray, v: np.ndarray) -> None:
        """Constraint rows at a state."""
        self._run(motion.place, q, v)
        self._prepare(self.workspace)
        self._run(motion.constraints)

    def take_travels(self, y: np.ndarray) -> None:
        """How far drivers have come whose speed is given, from a state y."""
        self._run(state.take_travels, y)

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

    def approach(self, q: np.ndarray, way: np.ndarray) -> None:
        """One correction of the positions a way further (3 nb,), in place, with the factor and the rows at hand."""
        self.place(q, way)
        for row in self.workspace.rows:
            row[at.NU] = -row[at.RES]
        self._run(motion.rate_residual)
        self._run(motion.correct)
        q += way + self.workspace.change
        self.place(q, np.zeros(len(q), dtype=object))

    def gap(self) -> Operand:
        """The largest residual [m or rad]."""
        gap: Operand = self._run(motion.residual)
        return gap

    def close_rates(self, v: np.ndarray) -> None:
        """Correct the rates in place, with a factor at the present positions."""
        self._run(schur.factorise)
        self._run(motion.rate_residual)
        self._run(motion.correct)
        v += self.workspace.change
