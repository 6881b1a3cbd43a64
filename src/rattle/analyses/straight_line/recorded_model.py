"""A model as a graph: what its kernels do at one instant, and how its start follows from chosen parameters.

Inputs of the graph are t [s], the state y [SI], the chosen parameters p [SI], through every expression of the model
file that uses them, the constants that the start sets, where parameters are chosen, and the energy E_0 at the start
[J], from which the balance counts.  See `rattle.trace`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.assembly.start_constants import constants_of, flat, with_constants
from rattle.analyses.dynamics.methods import require_frictionless_chain, require_one_law
from rattle.analyses.dynamics.run import start_state
from rattle.analyses.straight_line.derived_curves import derived_curve, derived_names
from rattle.analyses.straight_line.recorded_start import RecordedStart, record_start
from rattle.description.model import Model
from rattle.description.reader import read
from rattle.equations.compliant import locate_contacts
from rattle.equations.motion import derivative
from rattle.equations.motion import place as place_bodies
from rattle.equations.state import state_layout
from rattle.equations.system import System, compile_system
from rattle.errors import ModelError, TraceError, suggest
from rattle.interfaces.steppers import StepperKind
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.language.bytecode import SIDE
from rattle.language.recorded import Flag, Operand, Recorded, symbol_of
from rattle.results.columns import columns, width
from rattle.results.result import UnknownName
from rattle.solvers.output_row import record
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph, Symbol, both, select
from rattle.trace.recorded_contacts import RecordedContacts
from rattle.trace.recorded_friction import Joint
from rattle.trace.recorded_rigid import Struck
from rattle.trace.recorded_switches import Switch
from rattle.trace.recording import Recorder, Recording
from rattle.trace.symbol_arrays import Table
from rattle.value_types import Tree

BESIDE = 0.1  # share of what a pivot usually is at least that it may be, with equations solved more exactly
BELOW = 1e-9  # share of the size of the mechanism by which a corner may be below its segment by rounding
SAME = 1e-9  # share of the largest number by which a recording may differ from the kernels: rounding, well amplified
LEAST = 1e-12  # number [SI] with which smaller ones are compared as if they were as large: rounding of zeros
MOVED = 1e-3  # standard deviation of the state beside the start [SI] at which the record is checked
NUDGES = (1e-4, -1e-4, 1e-7, -1e-7)  # changes of a parameter, in shares of it, at which the record is checked


@dataclass(frozen=True)
class ContactFunctions:
    """Recorded functions of the contacts of a model; inputs are, after the other constants, first of all contacts
    whether they are shut (1, else 0), then how fast they closed [m/s or rad/s]."""

    are: RecordedContacts
    gap: list[Operand]  # [m or rad]
    rate: list[Operand]  # [m/s or rad/s]
    normal: list[Operand]  # force [N] or moment [N m] where it is shut
    across: list[Operand]  # speeds of centres of pins across their normals [m/s]
    lasting: list[Operand]  # how long it will last about, which has just begun [s]; 0: unknown
    rubbing: RubbingFunctions | None = None  # of derivatives, if joints rub
    held: HeldFunctions | None = None  # of lanes, and of rigid contacts
    reserve: Sequence[Operand] = ()  # of derivatives: what is left of the slip or the stick of rigid contacts
    strain: Sequence[Operand] = ()  # energy [J] of those that are compliant at their depth

    @property
    def count(self) -> int:
        """Number of contacts, and of joints that rub and of switches after them: of inputs of each kind."""
        return self.are.inputs


@dataclass(frozen=True)
class RubbingFunctions:
    """Recorded functions of joints with set-valued friction, in their modes; lists by joint."""

    joints: list[Joint]
    left: list[Operand]  # what is above zero while a mode lasts: of the limit [N or N m], or slip in its sense
    rested: list[Operand]  # (ny,) the state, joints that stick brought to rest


@dataclass(frozen=True)
class HeldFunctions:
    """Recorded functions of the contacts of a model that end where their force does, and of rigid ones;
    lists by contact, in order.  After them stand joints that rub, see `recorded_friction.Joint`: their reserve, rate as
    slip, force as tangent, acceleration as bend, whether others hold them as calm, what may be rounding
    of the reserve as faint.  Then expressions that switch: their switching function as slip, its rate as tangent, both
    times their side as reserve and as pressed, what may be rounding as faint."""

    numbers: list[int]
    pressed: list[Operand]  # force while it is shut; of a compliant one also what it would pull with [N or N m]
    reserve: list[Operand]  # above zero while it slips as it does [m/s], or sticks [N]; of an open clutch, its rate,
    # of one with a largest torque what is left of that, or the rate with which it slips
    slip: list[Operand]  # [m/s], 0 where it may be rounding
    calm: list[Operand]  # rate of the gap [m/s or rad/s] likewise
    tangent: list[Operand]  # T of B against A along t [N]
    bend: list[Operand]  # second derivative of the gap [m/s^2 or rad/s^2], likewise
    faint: list[Operand]  # force that may be rounding [N or N m]; of an open clutch without
    # impacts its rate [rad/s]
    struck: Struck

    def add(
        self, number: int, pressed: Operand, reserve: Operand, slip: Operand, calm: Operand, tangent: Operand,
        bend: Operand, faint: Operand,
    ) -> None:  # fmt: skip
        """Append what is known of one of them."""
        self.numbers.append(number)
        lists = (self.pressed, self.reserve, self.slip, self.calm, self.tangent, self.bend, self.faint)
        for each, x in zip(lists, (pressed, reserve, slip, calm, tangent, bend, faint), strict=True):
            each.append(x)


@dataclass(frozen=True)
class RecordedModel:
    """Recorded functions of one model.  A flag is true where what was computed stands on sound assumptions."""

    document: Tree  # the tables of the model file
    system: System
    start: Assembled
    parameters: dict[str, float]  # the chosen ones [SI], in the order of the inputs
    graph: Graph  # with functions; `elementary.lower` takes them apart
    derivative: list[Operand]  # (ny,) dy/dt [SI/s], then a flag
    projection: list[Operand]  # (ny,) y on the constraints [SI], then a flag
    curves: dict[str, Operand]  # result columns by name [SI]
    sound_curves: Flag  # their flag
    units: dict[str, str]
    readable: Flag  # flag of the parameters alone: the model has the same parts and forms as the one recorded
    time: Operand  # t [s]
    chosen: dict[str, Operand]  # the parameters
    dependent: dict[str, Operand]  # parameters that follow from the chosen ones [SI]
    first: RecordedStart | None  # how the start follows from the parameters; None if only the assembly knows
    recorded: System  # the system with its recorded numbers
    contacts: ContactFunctions | None = None  # None where contacts are not recorded: the model has none then

    @property
    def state_size(self) -> int:
        """ny."""
        return int(state_layout(self.system).size)

    @property
    def constants(self) -> np.ndarray:
        """(nc,) those that the start has set [m or rad]: inputs after the parameters, numbers where none is chosen."""
        own = flat(constants_of(self.system.model)) if self.parameters else []
        return np.array([*own, *([0.0] * (2 * self.contacts.count if self.contacts else 0))])

    def inputs(self, t: float, y: np.ndarray, values: Any = None) -> np.ndarray:
        """(n_in,) inputs of the graph at y (ny,) and values (np,) of parameters (default: its own) [SI], E_0 = 0."""
        values = list(self.parameters.values()) if values is None else values
        return np.concatenate([[t], y, values, self.constants, [0.0]])

    @property
    def points(self) -> dict[str, Operand]:
        """What follows from the result columns: points of bodies, coordinates, rates and powers of joints and loads."""
        names = [name for name in derived_names(self.recorded.model, self.curves) if not name.endswith(".force")]
        return {name: self.symbol(name) for name in names}

    @property
    def values(self) -> dict[str, float]:
        """Values of all parameters of the model [SI]."""
        return {name: parameter.value for name, parameter in self.system.model.parameters.items()}

    def symbol(self, name: str) -> Operand:
        """What a name in an expression over results stands for: a curve, a parameter or t."""
        if name == "t":
            return self.time
        if name in self.curves:
            return self.curves[name]
        derived = derived_curve(self.graph, self.recorded, self.curves, name)
        if derived is not None:
            return derived[0]
        follows = {**self.dependent, **self.chosen}
        return follows[name] if name in follows else self.values[name]

    @property
    def start_state(self) -> np.ndarray:
        """(ny,) y at t = 0 [SI]."""
        return start_state(self.system, self.start)


def record_model(
    document: Tree, system: System, start: Assembled, names: Sequence[str] = (), *, contacts: bool = False,
    lanes: bool = False, beside: float = 0.0, crowded: bool = False, as_alone: bool = False,
) -> RecordedModel:  # fmt: skip
    """Record a model.  names: parameters that become inputs.

    document: the tables of the model file, of which `system` was made.  contacts: whether contacts are recorded, their
    states as further constants; lanes: as these follow them, else for derivatives.  beside, crowded: see `Recorder`.
    as_alone: whether starts must be those of runs alone wherever they are said to hold, see `record_start`.
    Raises TraceError, with the reason, where it cannot be straight-line code; UnknownName.
    """
    require_parameters(system, names)
    _require_smooth(system, contacts and lanes)
    _require_above(system, start)
    graph = Graph()
    recorder = Recorder(graph, beside, crowded)
    t = graph.input()
    y = np.array([graph.input() for _ in range(state_layout(system).size)], dtype=object)
    inputs = [graph.input() for _ in names]
    recorded = _with_inputs(document, system, recorder, dict(zip(names, inputs, strict=True))) if names else system
    recorder.record_friction(recorded, lanes or contacts, contacts and not lanes)
    met = recorder.record_contacts(recorded, lanes) if contacts else None
    recording = Recording(recorded, recorder)
    rate, sound_rate = recording.guarded(lambda: recording.derivative(t, y))
    touching = _record_contacts(recording, met, t, y, rate if lanes else None)
    closed, sound_closed = recording.guarded(lambda: recording.projection(t, y))
    curves, units, sound_row = record_curves(recording, t, y)
    curves["energy.balance"] = curves["energy.balance"] - graph.input()
    for n in np.flatnonzero(_end_at_points(system)):
        curves.pop(f"{system.joints[system.arrays['contact'][n, at.OWNER]]}.gap", None)
    gaps = [] if touching is None else touching.gap
    first = record_start(system, start, recorded, recorder, y, gaps, as_alone) if names else None
    model = RecordedModel(
        document, system, start, {name: system.model.parameters[name].value for name in names}, graph,
        [*rate, sound_rate], [*closed, sound_closed],
        curves, sound_row, units,
        both(graph, recorder.assumed.values()), t, dict(zip(names, inputs, strict=True)), _dependent(recorded, names),
        first, recorded, touching,
    )  # fmt: skip
    _require_same(model)
    return model


def _with_inputs(document: Tree, system: System, recorder: Recorder, inputs: Mapping[str, Symbol]) -> System:
    """The system whose numbers follow from inputs of the graph, by the name of their parameters.  Raises TraceError."""
    chosen = {name: functools.partial(recorder.number, symbol=symbol) for name, symbol in inputs.items()}
    recorded = compile_system(_counting(read(document, chosen=chosen), system, recorder))
    _require_known_states(recorded)
    return recorded


def _record_contacts(
    recording: Recording, met: RecordedContacts | None, t: Operand, y: np.ndarray,
    rate: Sequence[Operand] | None,
) -> ContactFunctions | None:  # fmt: skip
    """Gaps, forces and impacts of contacts; rate: dy/dt (ny,) for lanes.  None if nothing begins, ends or switches."""
    if met is None or not met.inputs:
        return None

    def measured() -> tuple[SimpleNamespace, HeldFunctions | None, list[Operand]]:
        workspace = recording.run(derivative, t, y, np.zeros(len(y), dtype=object))
        strain = [met.strain(workspace, n) for n in range(len(met))]
        if rate is not None:
            switches: list[Switch] = []
            if met.switches is not None:
                switches = met.switches.at([1.0, *rate], lambda: recording.driven(workspace, t))
            return workspace, _held(met, workspace, y, switches), strain
        by_rate = (met.table[:, at.LEVEL] == 1).any()
        return workspace, _held(met, workspace, y, []) if met.rigid.any() or by_rate else None, strain

    (workspace, held, strain), _ = recording.guarded(measured)
    kept = (at.GAP, at.DGAP, at.NORMAL, at.ACROSS)
    gap, rate_of_gap, normal, across = (list(workspace.contact_kinematics[:, column]) for column in kept)
    rubs = _record_rubbing(met, workspace, y) if rate is None and met.rubbing is not None else None
    reserve: list[Operand] = []
    if rate is None:  # differentiable where a slip is rounding, too
        reserve = [_reserve(met, workspace, n, False) if met.rigid[n] else 1.0 for n in range(len(met))]
    return ContactFunctions(met, gap, rate_of_gap, normal, across, met.lasting(workspace), rubs, held, reserve, strain)


def _record_rubbing(met: RecordedContacts, m: SimpleNamespace, y: np.ndarray) -> RubbingFunctions | None:
    """Functions of joints that rub, for derivatives, at the state y, for which the equations of motion stand in m."""
    assert met.rubbing is not None, "it is asked for joints that rub"
    if not met.rubbing.rubs:
        return None
    rested = y.copy()
    met.rubbing.rest(m, rested)
    return RubbingFunctions(met.rubbing.at(m), met.rubbing.left(m), list(rested))


def _held(met: RecordedContacts, m: SimpleNamespace, y: np.ndarray, switches: Sequence[Switch]) -> HeldFunctions:
    """Functions of contacts that their forces hold, at the state y, for which the equations of motion stand in m."""
    struck, bends = met.struck(m, y), met.bends(m)
    held = HeldFunctions([], [], [], [], [], [], [], [], struck)
    for n in np.flatnonzero(met.by_force).tolist():
        held.add(n, *_held_contact(met, m, n, bends))
    for place, joint in enumerate([] if met.rubbing is None else met.rubbing.at(m)):
        held.add(
            len(met) + place, 1.0, joint.reserve, joint.rate, joint.stuck, joint.force, joint.ahead, joint.slack
        )  # fmt: skip
    for n, switch in enumerate(switches, met.inputs - len(switches)):
        jolts, jumps = (select(flag, 1.0, 0.0) for flag in (switch.jolts, switch.jumps))
        pressed, reserve = switch.side * switch.rate, switch.side * switch.value
        held.add(n, pressed, reserve, switch.value, jolts, switch.rate, jumps, switch.slight)
    return held


def _held_contact(met: RecordedContacts, m: SimpleNamespace, n: int, bends: dict[int, Operand]) -> list[Operand]:
    """What `HeldFunctions` has of contact n, in its order; bends: g'' of rigid ones."""
    row = m.contact_kinematics[n]
    if met.rigid[n]:
        slight, faint = met.faint(m, n)
        slip, rate = (met.calm(m, n, row[column]) for column in (at.SLIP, at.DGAP))
        bend = select(abs(bends[n]) <= slight, 0.0, bends[n])
        if met.table[n, at.LEVEL] and not met.limited[n]:  # open, it waits for a rate
            faint = select(met.is_shut[n], faint, met.slow(m, n))
        return [row[at.NORMAL], _reserve(met, m, n), slip, rate, row[at.TANGENT], bend, faint]
    if met.table[n, at.LEVEL]:
        faint = met.faint_clutch(m, n)
        return [row[at.NORMAL], _reserve(met, m, n), 0.0, 0.0, 0.0, met.parting(m, n), faint]
    return [met.push(m, n), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]


def _reserve(met: RecordedContacts, m: SimpleNamespace, n: int, calm: bool = True) -> Operand:
    """What is left of the slip or the stick of a rigid contact, see `HeldFunctions`; calm: without what may be
    rounding."""
    row = m.contact_kinematics[n]
    if met.table[n, at.LEVEL]:
        rate = met.calm(m, n, row[at.DGAP]) if calm and met.limited[n] else row[at.DGAP]
        free = select(met.is_shut[n], met.most(m, n) - row[at.NORMAL] if met.limited[n] else 1.0, rate)
        return select(met.slips[n], -row[at.DGAP], free) if met.limited[n] else free
    if met.lasts[n]:
        return 1.0
    sticks = abs(met.speed[n]) < 0.5
    slip = met.calm(m, n, row[at.SLIP]) if calm else row[at.SLIP]
    slips = met.speed[n] * slip  # 0 of one that others hold, though it bears all that it can
    return select(sticks, met.friction(m, n) * row[at.NORMAL] - abs(row[at.TANGENT]), slips)


def record_curves(recording: Recording, t: Operand, y: np.ndarray) -> tuple[dict[str, Operand], dict[str, str], Flag]:
    """Result columns by name [SI], the balance of energy as the energy itself; their units, and a flag."""
    row = np.zeros(width(recording.system), dtype=object)
    _, sound = recording.guarded(lambda: recording.run(record, t, y, row))
    table, titles, units = recording.plain(columns)(recording.system, Table([[0.0] * len(row), list(row)]))
    return dict(zip(titles, (column[1] for column in table), strict=True)), units, sound


def _counting(model: Model, system: System, recorder: Recorder) -> Model:
    """A model with new inputs for the constants that the start sets; their values are those of the system."""
    constants: dict[str, tuple[float, ...]] = {
        name: tuple(recorder.number(value, symbol=recorder.graph.input()) for value in each)
        for name, each in constants_of(system.model).items()
    }
    initial = model.initial.with_places(system.model.initial.held)
    return with_constants(replace(model, initial=initial), constants)


def _dependent(recorded: System, chosen: Sequence[str]) -> dict[str, Operand]:
    """Symbols of parameters that follow from chosen ones."""
    values = {name: parameter.value for name, parameter in recorded.model.parameters.items() if name not in chosen}
    return {name: symbol_of(x) for name, x in values.items() if isinstance(x, Recorded)}


def require_parameters(system: System, names: Sequence[str]) -> None:
    """Raise UnknownName for a name that is not a parameter of the model."""
    parameters = system.model.parameters
    for name in names:
        if name not in parameters:
            how = f'; vary a parameter that stands there: m.set({{"parameters.NAME": VALUE, "{name}": "NAME"}})'
            raise UnknownName(f"no parameter '{name}'{how if '.' in name else suggest(name, parameters)}")


def require_written_loads(system: System) -> None:
    """Raise TraceError for a load whose operations are not known."""
    for name, load in system.model.loads.items():
        if load.law is not None:
            raise TraceError(
                f"the load '{name}' is a Python function; only loads of model files can be written as code"
            )


def _require_smooth(system: System, switches: bool) -> None:
    """Raise TraceError for what a calculation without branches and events cannot follow; switches: which it can."""
    require_written_loads(system)
    _require_impacts(system)
    if switches:
        return
    driving = sorted({switch.name for switch in system.switches if switch.driving})
    if driving:
        raise TraceError(
            f"{', '.join(driving)} switches (abs, sign, min, max, floor, mod, if, tables with kinks): code would step"
            " over the jumps of a driver, or of gravity; use a smooth function of t"
        )


def _require_impacts(system: System) -> None:
    """Raise TraceError for rigid contacts that runs refuse: several laws, or what lzb does not know."""
    try:
        require_one_law(system, StepperKind)
        require_frictionless_chain(system)
    except ModelError as error:
        raise TraceError("; ".join(problem.message for problem in error.problems)) from error


def _require_above(system: System, start: Assembled) -> None:
    """Raise TraceError for a corner that is below the segment on which it bears: it touches nothing there."""
    ends = _end_at_points(system)
    if not ends.any():
        return
    workspace = system.plain_workspace()
    with np.errstate(all="ignore"):
        place_bodies.python(workspace, start.q, start.v)
        locate_contacts.python(workspace)
    below = np.flatnonzero(ends & (workspace.contact_kinematics[:, at.ABOVE] < -BELOW * system.size))
    if len(below):
        joint = system.joints[system.arrays["contact"][below[0], at.OWNER]]
        raise TraceError(f"a corner starts below its segment (joint {joint})")


def _end_at_points(system: System) -> np.ndarray:
    """(nc,) True of contacts of corners with segments, which are followed as if these went on: they have no gap."""
    return np.array(system.arrays["lever"][:, at.ONE_WAY] > 0.0, dtype=bool)


def _require_known_states(recorded: System) -> None:
    """Raise TraceError for a state whose start depends on a chosen parameter."""
    for name, state in recorded.model.states.items():
        if isinstance(state.start, Recorded):
            raise TraceError(f"the start of the state '{name}' depends on a parameter that is changed")


def _require_same(model: RecordedModel) -> None:
    """Compare the recorded functions with the kernels, at the start and at changed parameters.

    Raises TraceError where they differ.
    """
    flags = [model.derivative[-1], model.projection[-1], model.sound_curves, model.readable]
    functions = lower(model.graph, [*flags, *model.derivative[:-1], *model.curves.values()])
    y, values = model.start_state, model.parameters
    outputs, modes = _at(model, functions, model.start.t, y, values)
    if not outputs[:4].all():
        raise TraceError(
            "constraints are redundant, the start is next to a singular position, points coincide, or masses differ by"
            " orders of magnitude: straight-line code cannot pass that"
        )
    _require_equal(model, model.system, y, modes, outputs[4:], "at the start; this is a fault of rattle")
    random = np.random.default_rng(0)

    def same(names: Sequence[str], where: str) -> bool:
        """Compare where these parameters are changed; False if the model cannot be changed so."""
        for nudge in NUDGES:
            changed = {**values, **{name: values[name] + nudge * (values[name] or 1.0) for name in names}}
            try:
                other = compile_system(with_constants(read_at(model, changed), constants_of(model.system.model)))
            except ModelError:  # outside of the limits of a parameter
                continue
            moved = y + MOVED * random.standard_normal(len(y))
            outputs, modes = _at(model, functions, model.start.t, moved, changed)
            if outputs[3]:
                if model.contacts is not None:
                    _require_recorded(model, other, changed, where)
                _require_equal(model, other, moved, modes, outputs[4:], where)
                return True
        return False

    fault: TraceError | None = None
    try:
        if same(list(values), "where parameters are changed"):
            return
    except TraceError as error:
        fault = error  # which parameter?
    for name in values:
        same([name], f"where '{name}' is changed")
    if fault is not None:
        raise fault


def read_at(model: RecordedModel, values: Mapping[str, float]) -> Model:
    """The model with other values of parameters [SI].  Raises ModelError."""

    def just(x: float) -> Callable[[float], float]:
        return lambda _: x

    return read(model.document, chosen={name: just(x) for name, x in values.items()})


def _at(
    model: RecordedModel, functions: tuple[Graph, list[Operand]], t: float, y: np.ndarray, values: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Outputs of functions, and the modes of joints that rub and sides of switches for which they hold."""
    graph, outputs = functions
    inputs = model.inputs(t, y, list(values.values()))
    others = 0
    if model.contacts is not None:  # where no run is followed, kernels take those for shut in which bodies overlap
        first, count = len(inputs) - 1 - 2 * model.contacts.count, model.contacts.count
        are, held = model.contacts.are, model.contacts.held
        others = count - len(are)
        pairs = zip(model.contacts.gap, model.contacts.rate, are.table[:, at.LEVEL], strict=True)
        gaps = lower(model.graph, [rate if clutch else gap for gap, rate, clutch in pairs])
        inputs[first : first + len(are)] = gaps[0].evaluate(gaps[1], inputs[:, None])[:, 0] < 0.0
        inputs[first : first + len(are)][are.rigid] = 0.0
        if others and held is not None:  # and joints slip as they move, or stick; switches are on their sides
            told, symbols = lower(model.graph, [*held.slip[-others:], *held.tangent[-others:]])
            switches = count - (0 if are.switches is None else len(are.switches))
            for _ in range(1 if switches == count else 1 + others):  # of some, others are part
                value, rate = told.evaluate(symbols, inputs[:, None])[:, 0].reshape(2, -1)
                side = np.where(value != 0.0, value, np.where(rate != 0.0, rate, 1.0))
                switch = np.arange(len(are), count) >= switches
                inputs[first + count + len(are) : first + 2 * count] = np.sign(np.where(switch, side, value))
    return graph.evaluate(outputs, inputs[:, None])[:, 0], inputs[len(inputs) - 1 - others : -1]


def _require_recorded(model: RecordedModel, other: System, values: Mapping[str, float], where: str) -> None:
    """Raise TraceError where the numbers of another system do not follow from the recorded ones, laws included."""
    want, symbols = other.arrays["values"].astype(float), [symbol_of(x) for x in model.recorded.arrays["values"]]
    if len(want) != len(symbols):
        return
    graph, outputs = lower(model.graph, symbols)
    inputs = model.inputs(0.0, model.start_state, list(values.values()))
    got = graph.evaluate(outputs, inputs[:, None])[:, 0]
    finite = np.isfinite(want)
    off = np.abs(got[finite] - want[finite]) > SAME * np.maximum(np.abs(want[finite]), LEAST)
    if off.any() or not np.array_equal(got[~finite], want[~finite], equal_nan=True):
        raise TraceError(f"numbers of a joint, a load or a law of contact cannot be followed {where}")


def _let_clutches_drive(system: System, workspace: Workspace, y: np.ndarray) -> None:
    """Viscous and elastic clutches drive whose driving bodies are the faster ones at y, as `_at` has it."""
    contact = system.arrays["contact"]
    soft = (contact[:, at.LEVEL] == 1) & (contact[:, at.IMPACT] == 0)
    if soft.any():
        nq = 3 * system.body_count
        with np.errstate(all="ignore"):
            place_bodies.python(workspace, y[:nq].copy(), y[nq : 2 * nq].copy())
            locate_contacts.python(workspace)
        ahead = workspace.contact_kinematics[:, at.DGAP] < 0.0
        workspace.contact_memory[soft, at.CLOSED] = np.where(ahead, at.SHUT, at.OPEN)[soft]


def _require_equal(
    model: RecordedModel, system: System, y: np.ndarray, modes: np.ndarray, outputs: np.ndarray, where: str
) -> None:
    t, rate, row = model.start.t, np.zeros_like(y), np.zeros(width(system))
    workspace = system.plain_workspace()
    workspace.contact_kinematics[_end_at_points(system), at.PHASE] = at.HELD
    _let_clutches_drive(system, workspace, y)
    if len(modes):
        rubs = np.flatnonzero(system.arrays["dry"][:, at.DRY_LAW] < 0)
        rough = system.arrays["values"][system.arrays["dry"][rubs, at.DRY_P] + at.DRY_MU_STATIC] > 0.0
        workspace.dry_memory[rubs, at.DRY_MODE] = np.where(rough, modes[: len(rubs)], 1.0)  # nothing holds others
        for switch, side in zip(system.switches, modes[len(rubs) :].astype(int), strict=False):
            workspace.code[switch.row, SIDE] = side
    with np.errstate(all="ignore"):  # what is not finite is said below
        derivative.python(workspace, t, y.copy(), rate)
        record.python(workspace, t, y.copy(), row)
        table, titles, _ = columns(system, np.array([np.zeros_like(row), row]))
    told = table[1][[title in model.curves for title in titles]]
    pushed = np.abs(workspace.weight * workspace.force).max()  # at rest joints leave only rounding of these
    for title, want, got, size in (
        ("right-hand side", rate, outputs[: len(y)], pushed),
        ("result columns", told, outputs[len(y) :], 0.0),
    ):
        if not np.isfinite(want).all():
            raise TraceError("a load, driver or signal has no finite value at the start")
        if want.shape != got.shape or not np.abs(want - got).max() <= SAME * max(LEAST, size, np.abs(want).max()):
            raise TraceError(f"the recorded {title} and those of the kernels differ {where}")
