"""`Model` -> flat arrays that the kernels read, and the workspace of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple, TypeVar

import numpy as np

from rattle import registry
from rattle.description.model import Joint, Model, driven_ends
from rattle.equations import schur
from rattle.equations.contact_table import CONTACT_TABLES, contact_table
from rattle.equations.friction_table import friction_table
from rattle.interfaces.joints import JointKind
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.workspace import Image, Workspace
from rattle.language import bytecode
from rattle.language.expression import Node, compile_program, concatenate, replaced
from rattle.language.local_function import LocalFunction, packed
from rattle.language.recorded import array_of, bare, largest, least, operate
from rattle.language.switching import Signals, Switch, find_switches
from rattle.value_types import Plain

LARGE = 400  # number of rows above which dense linear algebra is avoided and starting the machine code pays off
SHARE = 0.1  # of the least mass: any other gives the same motion
Fact = TypeVar("Fact")
STATE = {"x": at.X, "y": at.Y, "angle": at.PHI, "vx": at.VX, "vy": at.VY, "omega": at.W}  # columns of `body`


@dataclass(frozen=True)
class Row:
    """A constraint row: the joint or driver it belongs to, and its unit."""

    owner: str
    unit: str
    driver: bool


@dataclass(frozen=True)
class System:
    """A model ready for computation: arrays in SI units, names and their places in the arrays."""

    model: Model
    arrays: Mapping[str, np.ndarray]  # the first part of the workspace, read-only in a run
    bodies: tuple[str, ...]  # without the ground; body i of the arrays is bodies[i - 1]
    joints: tuple[str, ...]  # joints, then drivers, as in the array `joint`
    rows: tuple[Row, ...]
    watched: tuple[str, ...]  # joint of every constraint whose multiplier is monitored for zero crossings
    depth: int
    live_names: tuple[str, ...]  # path of every expression evaluated in a run, programs in order
    program_starts: tuple[int, ...]  # first code row of each of them
    size: float  # a typical length of the mechanism [m]
    switches: tuple[Switch, ...] = ()  # of all expressions that the motion depends on

    @property
    def body_count(self) -> int:
        """Number of moving bodies."""
        return len(self.bodies)

    @property
    def signals(self) -> Signals:
        """Compiled expressions of all signals."""
        rows = [(int(a), int(b), int(k)) for a, b, k in self.arrays["signal"]]
        return Signals(self.arrays["code"], self.arrays["const"], rows, states=len(self.model.states))

    def first_row(self, name: str) -> int:
        """Index of the first constraint row of a joint or driver."""
        return int(self.arrays["joint"][self.joints.index(name), at.FIRST_ROW])

    def first_value(self, name: str) -> int:
        """Index of the first parameter of a joint or driver in `values`."""
        return int(self.arrays["joint"][self.joints.index(name), at.FIRST_P])

    def driver_slot(self, name: str) -> int:
        """Index of the value of a driver's function in `values` [m or rad]; its two derivatives follow."""
        return self.first_value(name) + at.POINTS + len(driven_ends(self.model, self.model.drivers[name])[2])

    @property
    def row_count(self) -> int:
        """Number of constraint rows, drivers included."""
        return len(self.rows)

    @cached_property
    def extent(self) -> float:
        """Size [m], independent of the position: its largest body, or the spread of its ground points."""
        joints, bodies = self.model.joints.values(), self.model.bodies.values()
        held = [end.at for joint in joints for end in (joint.a, joint.b) if end.body == "ground"]
        groups = [held, *([*body.points.values(), (0.0, 0.0)] for body in bodies)]
        return largest(0.0, *(joint.distance for joint in joints), *map(_spread, filter(None, groups))) or self.size

    @property
    def element_states(self) -> int:
        """Number of states of elements, such as the bristles of a friction law, and of the model; `equations.state`."""
        of_laws = self.arrays["contact"][:, at.STATES].sum() + self.arrays["dry"][:, at.DRY_STATES].sum()
        return int(of_laws) + len(self.model.states)

    @property
    def dry_joints(self) -> list[str]:
        """Names of the joints of the entries of `dry`; a rod has two."""
        return [self.joints[n] for n in self.arrays["dry"][:, at.DRY_JOINT].tolist()]

    @property
    def rough_joints(self) -> tuple[str, ...]:
        """Names of the joints without play that have friction."""
        return tuple(dict.fromkeys(self.dry_joints))

    @property
    def turns(self) -> bool:
        """Whether contacts may begin and end, or joints stick and slip."""
        return len(self.arrays["contact"]) > 0 or bool((self.arrays["dry"][:, at.DRY_LAW] < 0).any())

    def workspace(self, also: Iterable[int] = (), **more: np.ndarray | tuple[Plain, ...]) -> Workspace:
        """A new workspace for one run.  also: other joint kernels called.  more: arrays of the time integration."""
        machine = functions.jit_runs()  # read once: another thread may switch to machine code at any moment
        return Workspace({**self._tables(machine, also), **more}, self._image)

    def assembly_workspace(self, beside: Workspace | None = None, **more: np.ndarray) -> Workspace:
        """A new workspace in which given values can be kept, see `kept_values`; a usual one if there are many rows.

        beside: one that the same functions get: both are for machine code, or neither.  more: arrays of a start.
        """
        machine = functions.jit_runs() if beside is None else beside.handle is not functions.IN_PYTHON
        image = self._image if self.row_count > LARGE else self._assembly_image
        return Workspace({**self._tables(machine, ()), **more}, image)

    def plain_workspace(self) -> Workspace:
        """A new workspace for kernels that run as plain Python, whether or not machine code runs."""
        return Workspace(self._tables(False, ()), self._image)

    def _tables(self, machine: bool, also: Iterable[int]) -> dict[str, Any]:
        """Tables of the kernels that are called; made for every workspace, as a law may have been written anew."""
        joint, contact, dry = self.arrays["joint"][:, at.KERNEL].tolist(), self.arrays["contact"], self.arrays["dry"]
        joint += dry[:, at.DRY_KERNEL].tolist()
        tables = {
            "joint_table": registry.table("joint", "driver", "tangent", machine=machine, used=[*joint, *also]),
            "load_table": registry.table("load", machine=machine, used=self.arrays["load"][:, at.KERNEL].tolist()),
        }
        for name, (families, column) in CONTACT_TABLES.items() if len(contact) else ():
            tables[name] = registry.table(*families, machine=machine, used=contact[:, column].tolist())
        if (dry[:, at.DRY_LAW] >= 0).any():
            laws = [*dry[:, at.DRY_LAW].tolist(), *contact[:, at.FRICTION].tolist()]
            tables["friction_table"] = registry.table("friction", machine=machine, used=laws)
        return tables

    @cached_property
    def _image(self) -> Image:
        """What a new workspace begins with, besides the tables of kernels."""
        return self._begun({}) if "_like" not in self.__dict__ else self._renumbered("_image")

    @cached_property
    def _assembly_image(self) -> Image:
        """The same with arrays for given values at the start."""
        if "_like" in self.__dict__:
            return self._renumbered("_assembly_image")
        nr, nq = self.row_count, 3 * self.body_count
        return self._begun(
            {
                "kept_rows": (nr, nq),
                "kept_wide": (nr, nq),
                "kept_span": (nq, nr),
                "kept_left": (nr, nr),
                "kept_tall": (nr, nr),
                "kept_pivot": (2, nr + nq),
                "kept_pivot_tall": (2, nr),
                "kept_places": (9, nq),
                "kept_sides": (5, nr),
                "kept_order": (2, nr + nq),
            }
        )

    def _begun(self, also: Mapping[str, tuple[int, ...]]) -> Image:
        """What a new workspace begins with; also: shapes of more arrays."""
        nb, nr, ns = self.body_count + 1, self.row_count, max(1, len(self.model.recorded))
        nc, nd, states = len(self.arrays["contact"]), len(self.arrays["dry"]), (self.element_states,)
        nm = len(self.arrays["massless"])
        others = {
            "signals": (ns,),
            "travelled": (int(np.any(self.arrays["jet"][:, at.TRAVEL] >= 0)),),
            "jets": (ns, 3),
            "stack": (self.depth,),
            "jet_stack": (3 * self.depth,),
            "jet_out": (3,),
            "body": (nb, at.width("body")),
            "rows": (nr, at.width("rows")),
            "force": (nb, 3),
            "energy": (at.width("energy"),),
            "power": (at.width("power"),),
            "schur": (nr + self.arrays["below"].shape[0],),
            "inverse": (nr,),
            "redundant": (nr,),
            "pivots_of_row": (nr, at.width("pivots_of_row")),
            "solution": (nr,),
            "multiplier": (nr,),
            "acceleration": (nb, 3),
            "change": (3 * nb - 3,),
            "contact_kinematics": (nc, at.width("contact_kinematics")),
            "turning": (nb,),
            "film_force": (5,),
            "bin_sums": (8,),
            "contact_memory": (nc, at.width("contact_memory")),
            "massless_response": (nm, 3 * nb),
            "massless_reaction": (nm, nr),
            "massless_system": (nm, nm),
            "massless_force": (nm,),
            "massless_impulse": (nr if nm else 0,),
            "dry_memory": (nd, at.width("dry_memory")),
            "dry_rows": (nd, at.width("rows")),
            "dry_response": (nd, 3 * nb),
            "dry_reaction": (nd, nr),
            "dry_share": (nd, 2 * nc),
            "dry_system": (nd, nd + 2),
            "element_state": states,
            "element_rate": states,
            **also,
        }
        image = Image(self.arrays, tuple(others.items()))
        image.array("body", image.block)[0, at.COS] = 1.0
        image.array("power", image.block)[:] = 1.0
        image.array("contact_memory", image.block)[:, at.CLOSED] = at.AUTO
        image.array("dry_memory", image.block)[:, at.DRY_MODE] = at.DRY_AUTO
        image.array("dry_memory", image.block)[:, at.DRY_SINCE] = -math.inf
        self._put_own_states(image)
        return image

    def _put_own_states(self, image: Image) -> None:
        """Enter the start of the states of the model."""
        own = [state.start for state in self.model.states.values()]
        image.array("signals", image.block)[: len(own)] = own
        image.array("element_state", image.block)[self.element_states - len(own) :] = own

    def fact(self, key: Any, find: Callable[[], Fact]) -> Fact:
        """What `find` finds of the parts of the model, whatever its numbers: once for all systems of one form."""
        facts = self.__dict__.setdefault("_facts", {})
        if key not in facts:
            facts[key] = find()
        fact: Fact = facts[key]
        return fact

    def _renumbered(self, key: str) -> Image:
        """The image of another system of this form with the numbers of this one."""
        like, changed = self.__dict__["_like"]
        image: Image = getattr(like, key).copied()
        for name, array in changed.items():
            image.array(name, image.block)[...] = array
        if self.model.states:
            self._put_own_states(image)
        return image

    def with_numbers(self, model: Model, changed: Mapping[str, np.ndarray], size: float) -> System:
        """The system of a model of the same form; changed: arrays with other numbers, of the same shapes."""
        system = object.__new__(System)
        system.__dict__.update({key: self.__dict__[key] for key in self.__dataclass_fields__})
        system.__dict__.update(model=model, arrays={**self.arrays, **changed}, size=size)
        system.__dict__["_facts"] = self.__dict__.setdefault("_facts", {})
        system.__dict__["_like"] = self, changed
        return system


def invertible(mass: np.ndarray, model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Bodies and coordinates without inertia (n, 2), and 1 / mass (nb + 1, 3), fictitious where there is none.

    A fictitious mass is SHARE of the least mass of the model, a fictitious inertia SHARE of the least inertia.
    """
    massless = [(i, k) for i in range(1, len(mass)) for k in range(3) if mass[i, k] == 0.0]
    whole = mass.copy()
    if massless:
        masses = [body.mass for body in model.bodies.values() if body.mass > 0.0]
        inertias = [body.inertia for body in model.bodies.values() if body.inertia > 0.0]
        light = least(*masses) if masses else 1.0
        length = length_of(model)
        turning = least(*inertias) if inertias else light * (length * length)
        whole = whole.astype(object)  # any of these may be recorded
        for i, k in massless:
            whole[i, k] = SHARE * (turning if k == 2 else light)
    weight = np.zeros_like(whole)
    weight[1:] = 1.0 / whole[1:]
    return _table(massless, 2), array_of(weight)


def joint_rows(joint: Joint) -> tuple[registry.Kind[JointKind] | None, tuple[float | LocalFunction, ...]]:
    """The kind whose constraint rows this joint has, and the values of its fields; None if only contacts act on it."""
    if joint.is_loose or joint.held_by_stops:
        return None, ()
    contact, joint_kinds = joint.contact, registry.kinds("joint")
    if contact is not None and joint.clearance > 0.0 and registry.kinds("contact")[contact.model].leaf.link:
        return joint_kinds[joint.leaf.massless], (joint.clearance,)
    return joint_kinds[joint.kind], joint.numbers


def is_link(joint: Joint) -> bool:
    """True if the joint is a massless (two-sided) link as long as its clearance."""
    kind = joint_rows(joint)[0]
    return kind is not None and kind.name != joint.kind


class _Programs:
    """Collects expressions and the places of their values."""

    def __init__(self, model: Model, bodies: Mapping[str, int]) -> None:
        self.constants, self.tables, self.definitions = model.constants, model.tables, model.definitions
        self.state = {
            f"{name}.{key}": at.width("body") * i + column
            for name, i in bodies.items()
            for key, column in STATE.items()
        }
        self.signals = {name: n for n, name in enumerate(model.recorded)}
        self.programs: list[Any] = []
        self.names: list[str] = []

    def add(self, node: Node, name: str) -> int:
        self.programs.append(
            compile_program(replaced(node, self.definitions), self.constants, self.state, self.signals, self.tables)
        )
        self.names.append(name)
        return len(self.programs) - 1


def _drivers(
    model: Model, number: Mapping[str, int], values: list[float], programs: _Programs, layout: _Layout
) -> list[tuple[int, int, int]]:
    """Add the drivers to the joints; returns programs of drivers, the places of their values and of their travels."""
    jets, states = [], list(model.states)
    for name, driver in model.drivers.items():
        kind = registry.kinds("driver")[driver.kind]
        end_a, end_b, fields = driven_ends(model, driver)
        a, b = number[end_a.body], number[end_b.body]
        layout.joint.append((len(registry.kinds("joint")) + kind.tag, a, b, len(values), len(layout.rows)))
        values += [*end_a.at, *end_b.at, *fields]
        if driver.travel:
            rate = model.states[driver.travel].rate
            jets.append((programs.add(rate, f"drivers.{name}.speed"), len(values), states.index(driver.travel)))
            values += [0.0, 0.0, 0.0]
        elif isinstance(driver.value, float):
            values += [driver.value, 0.0, 0.0]
        else:
            jets.append((programs.add(driver.value, f"drivers.{name}.{driver.kind}"), len(values), -1))
            values += [0.0, 0.0, 0.0]
        for unit in kind.leaf.rows:
            layout.rows.append(Row(name, unit, True))
            layout.row_body.append((a, b))
    return jets


def _falling(model: Model, programs: _Programs, values: list[float]) -> list[tuple[int, int]]:
    """Programs of the two components of gravity over time, and the places of their values, which are added."""
    nodes = model.falling or ()
    places = [(programs.add(node, f"gravity[{n}]"), len(values) + 3 * n) for n, node in enumerate(nodes)]
    values += [0.0] * 3 * len(places)
    return places


def _expressions(
    model: Model,
    programs: _Programs,
    jets: Sequence[tuple[int, int, int]],
    live: Sequence[tuple[int, int]],
    of_laws: int,
    values: list[float],
) -> tuple[dict[str, np.ndarray], list[Switch], np.ndarray, int]:
    """Arrays of all expressions, their switches, their first rows of code and the depth of the stack.

    jets, live: programs of drivers and of loads, and the places of their values; of_laws: number of states of laws;
    values: to which those of gravity are added.
    """
    falling = _falling(model, programs, values)
    signals = {programs.signals[name]: programs.add(node, f"signals.{name}") for name, node in model.signals.items()}
    rates = [programs.add(state.rate, f"states.{name}.rate") for name, state in model.states.items()]
    code, const, first, depth = concatenate(programs.programs, model.tables)
    needed = _needed_by_drivers(programs, [program for program, *_ in jets], signals)
    spans = [(int(first[n]), int(first[n + 1]), k) for k, n in signals.items()]
    plain = np.array([bare(number) for number in const], dtype=float)
    compiled = Signals(code, plain, spans, [programs.names[n] for n in signals.values()], len(rates))
    of_time = [n for n, *_ in (*jets, *falling)]
    switches = _switches(programs, compiled, first, of_time, [*(n for n, _ in live), *rates])
    arrays = {
        "code": code,
        "const": const,
        "jet": _table([(first[n], first[n + 1], slot, state) for n, slot, state in jets], 4),
        "falling": _table([(first[n], first[n + 1], slot) for n, slot in falling], 3),
        "jet_signal": _table([(first[signals[k]], first[signals[k] + 1], k) for k in needed], 3),
        "signal": _table(spans, 3),
        "live": _table([(first[n], first[n + 1], slot) for n, slot in live], 3),
        "state_rate": _table([(first[n], first[n + 1], k) for k, n in enumerate(rates, of_laws)], 3),
    }
    return arrays | _switch_tables(switches), switches, first, depth


def _switch_tables(switches: Sequence[Switch]) -> dict[str, np.ndarray]:
    """Tables of switches that are watched, and of those that only time acts on."""
    timed = [(s.first, s.last, s.row, s.driving, 1, *(0,) * 4) for s in switches if s.timed]
    watched = [(s.first, s.last, s.row, s.count) for s in switches if not s.timed]
    return {"switch": _table(watched, 4), "timed": _table(timed, at.width("timed"))}


def compile_system(model: Model, length: float | None = None) -> System:
    """Flat arrays (SI units), names and the pattern of the Schur complement of one model.

    length: of the mechanism [m], with its record, where numbers of the model are recorded; default: without a record.
    """
    bodies = {name: n + 1 for n, name in enumerate(model.bodies)}
    number = {"ground": 0, **bodies}
    programs = _Programs(model, bodies)
    values: list[float] = []
    layout = _joints(model, number, values)
    jets = _drivers(model, number, values, programs, layout)
    if length is None:
        length = max([*map(bare, _lengths_of(model)), 0.0]) or 1.0
    contact, lever, films = contact_table(model, number, values, length)
    dry = friction_table(model, number, values, layout.joint, contact)
    load, live = _loads(model, number, values, programs)
    of_laws = sum(row[at.STATES] for row in contact) + sum(row[at.DRY_STATES] for row in dry)
    expressions, switches, first, depth = _expressions(model, programs, jets, live, of_laws, values)
    starts = [*(entry[at.FIRST_ROW] for entry in layout.joint), len(layout.rows)]
    pattern = schur.analyse(layout.row_body, [range(a, b) for a, b in pairwise(starts) if b > a])
    mass = array_of([[0.0] * 3] + [[body.mass, body.mass, body.inertia] for body in model.bodies.values()])
    massless, weight = invertible(mass, model)
    arrays = {
        "mass": mass,
        "weight": weight,
        "massless": massless,
        "gravity": array_of(model.gravity),
        "joint": _table(layout.joint, at.width("joint")),
        "load": _table(load, at.width("load")),
        "contact": _table(contact, at.width("contact")),
        "dry": _table(dry, at.width("dry")),
        "lever": array_of(lever).reshape(-1, at.width("lever")),
        "film_coefficients": array_of(films),
        "values": array_of(values),
        **expressions,
        "watch": np.array(layout.watch, np.int64),
        **pattern._asdict(),
        "row_body": _table(layout.row_body, 2),
    }
    return System(
        model, arrays, tuple(model.bodies), (*model.joints, *model.drivers), tuple(layout.rows),
        tuple(layout.watched), depth + 1,
        tuple(programs.names), tuple(int(n) for n in first[:-1]), length, tuple(switches),
    )  # fmt: skip


class _Layout(NamedTuple):
    """Joints and drivers: their entries of `joint`, rows, bodies of rows, and what is monitored."""

    joint: list[Any]
    rows: list[Row]
    row_body: list[Any]
    watch: list[int]  # rows of massless links, and their joints
    watched: list[str]


def _joints(model: Model, number: Mapping[str, int], values: list[float]) -> _Layout:
    layout = _Layout([], [], [], [], [])
    for name, joint in model.joints.items():
        kind, fields = joint_rows(joint)
        a, b = number[joint.a.body], number[joint.b.body]
        layout.joint.append((kind.tag if kind else -1, a, b, len(values), len(layout.rows)))
        if is_link(joint):
            layout.watch.append(len(layout.rows))
            layout.watched.append(name)
        values += packed([*joint.a.at, *joint.b.at, *fields])
        for unit in () if kind is None else joint.rows if kind.name == joint.kind else kind.leaf.rows:
            layout.rows.append(Row(name, unit, False))
            layout.row_body.append((a, b))
    return layout


def _loads(
    model: Model, number: Mapping[str, int], values: list[float], programs: _Programs
) -> tuple[list[Any], list[tuple[int, int]]]:
    entries = []
    live: list[tuple[int, int]] = []
    for name, load in model.loads.items():
        tag = registry.kinds("load")[load.kind].tag
        start, changes = len(values), False
        for n, value in enumerate(packed(load.values)):
            if isinstance(value, float | int):
                values.append(value)
            else:
                live.append((programs.add(value, f"loads.{name} (value {n + 1})"), len(values)))
                values.append(0.0)
                changes = changes or value is not load.slack
        entries.append((tag, number[load.a.body], number[load.b.body], start, int(changes)))
    return entries, live


def _switches(
    programs: _Programs, signals: Signals, first: np.ndarray, drivers: Sequence[int], acting: Sequence[int]
) -> list[Switch]:
    """Switches of all expressions on which the motion depends: those of drivers and gravity, others that act on it."""
    names = programs.names
    used = [(int(first[n]), int(first[n + 1]), names[n], n in drivers) for n in (*drivers, *acting)]
    return find_switches(signals, used)


def _needed_by_drivers(programs: _Programs, jets: Sequence[int], signals: Mapping[int, int]) -> list[int]:
    """Signals that drivers use, directly or through others, in order of evaluation."""
    wanted: set[int] = set()
    open_ = [k for n in jets for k in programs.programs[n].signals]
    while open_:
        k = open_.pop()
        if k not in wanted:
            wanted.add(k)
            open_ += programs.programs[signals[k]].signals
    return sorted(wanted)


def _table(entries: Sequence[Sequence[int]], width: int) -> np.ndarray:
    return np.array(entries, np.int64).reshape(-1, width)


def _lengths_of(model: Model) -> list[float]:
    """Distances [m] of points from the mass centre of their body, or from the origin, and those that joints keep.

    Of surfaces the corners that touch them, and the sizes of discs.
    """
    points = [p for body in model.bodies.values() for p in body.points.values()] + list(model.ground.values())
    touching = [joint for joint in model.joints.values() if joint.leaf.touches]
    points += [corner for joint in touching for corner in joint.corners.values()]
    sizes = [joint.fields[key] for joint in touching for key in ("radius", "roller")]
    return [abs(x) + abs(y) for x, y in points] + [joint.distance for joint in model.joints.values()] + sizes


def length_of(model: Model) -> float:
    """Largest distance [m] of a point from its body's mass centre, or of a ground point from the origin; 1 if none."""
    return largest(0.0, *_lengths_of(model)) or 1.0


def _spread(points: Iterable[tuple[float, float]]) -> float:
    """Diagonal [m] of the rectangle around some points."""
    x, y = zip(*points, strict=True)
    width, height = largest(*x) - least(*x), largest(*y) - least(*y)
    return operate(bytecode.HYPOT, float(np.hypot(bare(width), bare(height))), width, height)
