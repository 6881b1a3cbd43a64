"""A recorded model for lanes: its functions split into what a sample determines once and what every step needs."""

from __future__ import annotations

import itertools
from collections.abc import Container, Mapping, Sequence
from typing import Any

import numpy as np

from rattle.analyses.straight_line.derived_curves import derived_units
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.analyses.straight_line.start_kept import driven_bodies
from rattle.analyses.straight_line.starts import Starts
from rattle.description import model as description
from rattle.equations.state import STORED, state_layout
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.language.recorded import Operand, symbol_of
from rattle.language.syntax import Apply, Name, Node, Number, names, walk
from rattle.results.columns import geometry
from rattle.results.contact_summary import RISING
from rattle.results.evaluation import may_tower
from rattle.results.reductions import EVENTS_OF_CONTACT, OF_EVENTS, Output, argument
from rattle.trace import reductions
from rattle.trace.copying import replaced
from rattle.trace.derivative import tangent
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph, Symbol
from rattle.trace.hoist import hoist
from rattle.trace.lane_chain import Function
from rattle.trace.lane_contacts import Meets, Row
from rattle.trace.lane_program import Compile, Model, filled
from rattle.trace.recording import operation
from rattle.trace.reductions import CONDITIONS, EXTREMES, KINDS, OF_CONTACTS, SAMPLED, Reduction

ENERGY = ("kinetic", "potential", "work", "dissipated", "balance")
JUMPS = ("sign", "step", "floor", "mod", "choose", "if<", "if<=", "if>", "if>=")  # operations whose curves may jump
WAVES = ("sin", "cos")
STEADY = ("+", "-", "*", "/", "**", "neg", "sqrt", "hypot")  # operations that change as fast as their operands
PEAKS = {"max": ("abs", "max"), "min": ("min",)}  # by kind of extreme: kinks that point away from it


class Asked:
    """The reductions of some outputs, each once, as curves of a graph and what is asked of them."""

    def __init__(self, model: RecordedModel, outputs: Sequence[Output]) -> None:
        self.model, self.outputs = model, outputs
        self.curves: list[Operand] = []
        self.reductions: list[Reduction] = []
        self._places: dict[Reduction, int] = {}
        self.rows = [[self._row(reduction) for reduction in output.reductions] for output in outputs]
        self.forces = self.towers()

    def _row(self, reduction: Any) -> int:
        """The row of the values that holds a reduction."""
        if reduction.kind in OF_CONTACTS:
            return self._place(Reduction(reduction.kind, -1, 0.0, contacts_of(self.model, reduction), reduction.number))
        symbol = expression(self.model, reduction.inner)
        if reduction.kind in ("share", "first") and not reduction.strict:
            symbol = self.model.graph.apply("select", symbol >= 0.0, symbol + TINY, symbol)
        curve = self._curve(symbol)
        t = argument(reduction, self.model.values) if reduction.kind == "at" else 0.0
        return self._place(Reduction(reduction.kind, curve, t))

    def _curve(self, symbol: Operand) -> int:
        place = self.model.graph.place(symbol)
        curve = next((n for n, x in enumerate(self.curves) if self.model.graph.place(x) == place), len(self.curves))
        if curve == len(self.curves):
            self.curves.append(symbol)
        return curve

    def towers(self) -> dict[str, tuple[int, int]]:
        """Rows of the largest force and of its mean of joints with rigid contacts, beside which forces may
        rise without meaning; none where no output depends on a force."""
        model = self.model.system.model
        units = {**derived_units(model, self.model.curves), **self.model.units}
        units |= dict.fromkeys(("t", *self.model.values), "")
        joints, rows = geometry(model)["joints"], {}
        for joint in may_tower(self.outputs, lambda name: units.get(name, RISING[0]), joints):
            curve = self._curve(self.model.symbol(f"{joint}.force"))
            rows[joint] = self._place(Reduction("max", curve)), self._place(Reduction("mean", curve))
        return rows

    def _place(self, reduction: Reduction) -> int:
        if reduction not in self._places:
            self._places[reduction] = len(self.reductions)
            self.reductions.append(reduction)
        return self._places[reduction]


def contacts_of(model: RecordedModel, reduction: Any) -> tuple[int, ...]:
    """The contacts that a reduction of contacts asks for.  Raises TraceError for impacts of clutches."""
    if model.contacts is None:  # none that begin and end, as of a massless link
        return ()
    joint, _, word = reduction.inner.name.rpartition(".")
    are = model.contacts.are
    asked = tuple(
        n for n, owner in enumerate(are.joints) if owner == joint and (word == "contacts" or bool(are.rigid[n]))
    )
    if word != "contacts" and are.table[list(asked), at.LEVEL].any():
        raise TraceError(f"only single runs tell impacts of the clutch {joint} from other contacts")
    if are.limited[list(asked)].any():
        raise TraceError(f"only single runs tell which contacts of the clutch {joint} begin, as it slips at max_torque")
    level, rigid = are.table[:, at.LEVEL] == 1, are.rigid
    if level[list(asked)].any() and (level | rigid).sum() > 1:
        raise TraceError(f"only single runs tell which contacts of the clutch {joint} begin together with others")
    if (level & rigid)[list(asked)].any() and are.rubbing is not None and are.rubbing.rubs:
        raise TraceError(f"only single runs tell which contacts of the clutch {joint} begin beside joints that rub")
    return asked


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
    return next((why for reduction in output.reductions if (why := _why_not(reduction, output.text, varied))), "")


def _why_not(reduction: Any, text: str, varied: Mapping[str, object]) -> str:
    """Why lanes cannot compute a reduction in the output of this text; "" if they can."""
    if reduction.kind in OF_EVENTS:
        word = reduction.inner.name.rpartition(".")[2] if isinstance(reduction.inner, Name) else ""
        told = reduction.kind in OF_CONTACTS and word in EVENTS_OF_CONTACT
        return "" if told else f"{text!r} asks for events that only single runs tell"
    if reduction.kind not in KINDS:
        return f"{reduction.kind}(...) needs a whole curve"
    parts = list(walk(reduction.inner))
    if reduction.kind in EXTREMES and any(isinstance(part, Apply) and part.name in JUMPS for part in parts):
        return f"the curve in {text!r} jumps"
    if reduction.argument is not None and not names(reduction.argument).isdisjoint(varied):
        return f"the instant in {text!r} differs from sample to sample"
    return ""


def needs_short_steps(outputs: Sequence[Output], model: RecordedModel) -> bool:
    """Whether outputs need steps that are short beside the run, as samples in a step of usual length miss something.

    Steps follow the motion.  A condition may hold more shortly, a curve or a load written with functions or with t may
    change faster, and what a driver or a guide takes from a load does not show in the motion at all.  What a driver
    does shortly shows nowhere if it falls between the stages of a step, and it may hit something.
    """
    sampled = [reduction for output in outputs for reduction in output.reductions if reduction.kind in SAMPLED]
    inside, signals = model.system.model, model.system.model.signals
    drivers = [driver.value for driver in inside.drivers.values() if isinstance(driver.value, Apply | Name)]
    if model.contacts is not None and any(_abrupt(value, signals) for value in drivers):
        return True
    if not sampled:
        return False
    if any(_brief(reduction, signals) for reduction in sampled):
        return True
    if pulsates(inside):
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


def pulsates(model: description.Model) -> bool:
    """Whether loads, or gravity, may change faster than what moves."""
    values = [*(model.falling or ()), *(value for load in model.loads.values() for value in load.values)]
    return any(_brisk(value, model.signals) for value in values if isinstance(value, Apply | Name))


def _brisk(node: Node, signals: Container[str]) -> bool:
    """Whether an expression may change faster than the curves in it."""
    for part in walk(node):
        if isinstance(part, Apply) and part.name not in STEADY:
            return True
        if isinstance(part, Name) and (part.name == "t" or part.name in signals):
            return True
    return False


def _abrupt(node: Node, signals: Container[str]) -> bool:
    """Whether a motion may do something between the stages of a step, as powers of t and waves alone do not."""
    used = {part.name for part in walk(node) if isinstance(part, Apply)}
    waves = used & set(WAVES)
    return bool(used - {*STEADY, *WAVES} or (waves and "**" in used)) or any(name in signals for name in names(node))


def lane_model(model: RecordedModel, asked: Asked, compile_function: Compile, starts: Starts) -> Model:
    """Functions of a model for lanes: curves are those asked for, then the energies."""
    nb, ny, graph = model.system.body_count, model.state_size, model.graph
    energies = [model.curves[f"energy.{key}"] for key in ENERGY]
    curves = [*asked.curves, *energies]
    watched = reductions.watched(asked.reductions)
    met = _Met(model, asked)
    size = [ny + 1, ny + 1, len(curves) + 1, len(met.ends), len(met.midway), len(met.levers), len(met.struck)]
    exact, every = lower(
        graph,
        [
            *model.derivative,
            *model.projection,
            *curves,
            model.sound_curves,
            *met.ends,
            *met.midway,
            *met.levers,
            *met.struck,
        ],
    )
    rates, closed, rows, ends, midway, levers, struck = (every[sum(size[:n]) : sum(size[: n + 1])] for n in range(7))
    there = replaced(exact, [*rates, *rows, *ends], dict(zip(exact.inputs[1:], closed[:-1], strict=False)))
    parts = [rates, [*closed, *there], rows, ends, midway, levers, struck]
    if watched:
        parts.append([*rates, *(rows[n] for n in watched)])
    touch = exact.inputs[len(exact.inputs) - 1 - met.inputs : -1]
    early, prepared, late, outputs = hoist(
        exact, [x for part in parts for x in part], [x for x in exact.inputs[1 + ny :] if x not in touch]
    )
    places = np.cumsum([0, *map(len, parts)])
    written = [outputs[a:b] for a, b in itertools.pairwise(places)]
    rate, arrive, row, touched, half = (compile_function(late, part) for part in written[:5])
    strike = compile_function(late, written[6])
    watch = [compile_function(late, part) for part in written[7:]]
    prepare = compile_function(early, prepared)
    energy = compile_function(*lower(graph, [energies[-1]]))
    strain = compile_function(*lower(graph, met.strain)) if met.stores else None

    def begin(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        begun, count = starts.begin(values), values.shape[1]
        fill = filled(count)
        state, first = np.zeros((len(exact.inputs), len(fill))), np.zeros((1, len(fill)))
        state[1 : 1 + ny], state[1 + ny : -1] = begun.y[:, fill], np.vstack([values, begun.constants])[:, fill]
        if strain is not None:  # what starts inside its wall holds energy
            stored = np.zeros((len(met.stores), len(fill)))
            strain(state, stored)
            state[[1 + place for place in met.stores]] = stored
            begun.y[met.stores] = stored[:, :count]
        energy(state, first)
        state[-1] = first[0]
        constants = np.zeros((met.inputs + len(prepared), len(fill)))  # at the start all contacts are open
        prepare(state, constants[met.inputs :])
        return begun.y, constants[:, :count], np.isfinite(begun.y).all(axis=0)

    first = len(asked.curves)
    states = state_layout(model.system).states
    controlled = (*range(6 * nb), *range(states.start, states.stop))
    return Model(
        ny, met.inputs + len(prepared), len(curves), 6 * nb, controlled, begin, rate, None, row,
        (first, first + 1, first + 2, first + 3, first + 4), watch[0] if watch else None, watched, arrive,
        *weight(model.system), met.meets(late, written[5], touched, half, strike),
    )  # fmt: skip


def weight(system: System) -> tuple[float, float]:
    """Energy of lifting a mechanism by its size [J], and its mass [kg]."""
    mass, gravity = system.arrays["mass"][:, 0].astype(float), system.arrays["gravity"].astype(float)
    return float(mass.sum() * np.hypot(*gravity) * system.size), float(mass.sum())


class _Met:
    """What lanes need of the contacts of a model, on its symbols; nothing if there are none."""

    def __init__(self, model: RecordedModel, asked: Asked) -> None:
        self.model = model
        self.levers: list[Operand] = []
        self.ends: list[Operand] = []
        self.midway: list[Operand] = []
        self.struck: list[Operand] = []
        self.inputs = 0
        self.peaks: tuple[int, ...] = ()
        self.held: tuple[int, ...] = ()
        self.strain: list[Operand] = []  # what contacts store at their depths [J], and its places in y
        self.stores: list[int] = []
        if model.contacts is None:
            return
        functions = model.contacts
        self.inputs = 2 * functions.count
        layout, self.strain = state_layout(model.system), list(functions.strain)
        self.stores = [layout.account(n).start + STORED for n in range(len(functions.are))]
        levers = model.recorded.arrays["lever"].copy()
        levers[levers[:, at.ONE_WAY] > 0.0, at.BOW] = 0.0  # segments go on as lines
        self.levers = [symbol_of(x) for x in levers.ravel()]
        self.peaks = tuple(
            sorted({n for reduction in asked.reductions if reduction.kind == "peak" for n in reduction.contacts})
        )
        normal = [functions.normal[n] for n in self.peaks]
        flow = dict(zip(model.graph.inputs, [1.0, *model.derivative[:-1]], strict=False))
        self.ends = [
            *functions.gap, *functions.rate, *functions.across, *functions.lasting,
            *normal, *tangent(model.graph, normal, flow),
        ]  # fmt: skip
        self.midway = [*functions.gap, *functions.rate, *normal]
        held = functions.held
        assert held is not None, "contacts are recorded for lanes"
        self.held = tuple(held.numbers)
        self.ends += [*held.pressed, *held.reserve, *held.slip, *held.tangent, *held.bend, *held.calm, *held.faint]
        self.midway += [*held.pressed, *held.reserve]
        struck = held.struck
        of_contacts = [*struck.shut.values(), *struck.slide.values(), *struck.impulse.values()]
        self.struck = [*struck.state, *of_contacts, *struck.rubs, *struck.free, struck.sound, struck.agreed]

    def meets(
        self, late: Graph, levers: Sequence[Operand], touched: Function, midway: Function, struck: Function
    ) -> Meets | None:
        """As lanes read it; late: the calculation of every step, levers: what stands for them there."""
        if self.model.contacts is None:
            return None
        rows = {place: Row(n) for n, place in enumerate(late.inputs)}
        values = [rows[x.place] if isinstance(x, Symbol) and x.op == "input" else _number(late, x) for x in levers]
        table = self.model.system.arrays["contact"]
        width = len(values) // max(1, len(table))
        switches = 0 if self.model.contacts.are.switches is None else len(self.model.contacts.are.switches)
        entries = [values[n * width : (n + 1) * width] for n in range(len(table))]
        return Meets(
            table, entries, 3 * self.model.system.body_count, touched, midway, struck, self.peaks, self.held,
            pulsates(self.model.system.model), self.model.contacts.count - len(table) - switches, switches,
            tuple(np.flatnonzero(self.model.contacts.are.limited).tolist()),
        )  # fmt: skip


def _number(graph: Graph, x: Operand) -> float:
    return graph.numbers[graph.place(x)]
