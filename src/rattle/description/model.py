"""A mechanism as frozen data: what the model file says, checked and in SI units.

Nothing is computed here: `reader` makes a `Model`, `equations.system` turns it into flat arrays.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any, NamedTuple, TypeVar, overload

import numpy as np

from rattle import registry
from rattle.catalogue.bearings import BearingPlay
from rattle.catalogue.fits import Fit
from rattle.catalogue.oils import Oil
from rattle.interfaces.contacts import ClearanceKind, Corners, OneSidedKind
from rattle.interfaces.fields import LawValues, pair
from rattle.interfaces.joints import DriverKind, JointKind, Motor
from rattle.language.expression import Node
from rattle.language.local_function import LocalFunction
from rattle.language.materials import Material
from rattle.language.recorded import as_number
from rattle.language.tables import NO_TABLES, Tables

DEFAULT_CONTACT = "massless-link"  # of a joint that says its clearance only
DEFAULT_STOP = "impact"  # of a stop that says its ends only
END_ROUNDING = 1e-12  # share of the mass of a bar by which a mass at its end may be negative by rounding
Vector = tuple[float, float]
Value = float | Node  # a number [SI], or an expression in t, state and signals


@dataclass(frozen=True)
class Point:
    """A point of a body, in the body's frame relative to its mass centre [m]."""

    body: str
    name: str
    at: Vector


@dataclass(frozen=True)
class Section:
    """The section of a bar, for bending in the plane."""

    area: float  # [m^2]
    inertia: float  # second moment of area [m^4]
    modulus: float  # section modulus [m^3]
    height: float = math.nan  # in the plane [m]
    title: str = ""


@dataclass(frozen=True)
class Beam:
    """What a bar is made of: straight from end A to end B, x from A."""

    ends: tuple[str, str]
    length: float  # [m]
    centre: float  # x of the mass centre [m]
    section: Section | None
    material: Material | None
    line: tuple[Vector, ...]  # (x, mass per length) [m, kg/m], straight between
    at_ends: Vector = (0.0, 0.0)  # masses there that mass and inertia need besides [kg]

    @property
    def physical(self) -> bool:
        """False if such a mass would be negative: no distribution of mass along the bar is like that."""
        return min(self.at_ends) >= -END_ROUNDING * sum(density for _, density in self.line) * self.length


@dataclass(frozen=True)
class Sheet:
    """What a plate is made of, and where it is cut to see what it bears."""

    thickness: float  # [m]; nan if it is not known
    material: Material | None
    necks: Mapping[str, tuple[Vector, Vector]]  # both ends of each cut, relative to the mass centre [m]


@dataclass(frozen=True)
class Body:
    """A rigid body. Points are in its frame, relative to its mass centre [m].

    A point of the ground that moves is a body without mass, named "ground.POINT", of which drivers set x, y and angle.
    """

    name: str
    mass: float  # [kg]
    inertia: float  # about the mass centre [kg*m^2]
    points: Mapping[str, Vector]
    bar: bool = False
    outline: tuple[tuple[Vector, ...], ...] = ()  # of a plate: corners of its polygon, then those of each hole
    beam: Beam | None = None  # of a bar
    sheet: Sheet | None = None  # of a plate
    z: float = 0.0  # offset of its plane [m]

    @property
    def material(self) -> Material | None:
        """Of which a bar or a plate is; None if that is not said."""
        form = self.beam or self.sheet
        return form.material if form is not None else None


GROUND = "ground"


def is_ground(body: str) -> bool:
    """True for the ground, and for a point of it that moves."""
    return body == GROUND or body.startswith(f"{GROUND}.")


def point_of_ground(body: str) -> str:
    """Name of the point of the ground that this body is, which moves; "" for the ground itself."""
    return body.partition(".")[2]


def on_ground(points: Mapping[str, Vector], end: Point) -> Vector:
    """Where an end is on the ground [m], of whose points these are the places; of one that moves at the start."""
    moving = point_of_ground(end.body)
    return points[moving] if moving else end.at


def frame_of(body: str) -> str:
    """The ground for a point of it that moves, any other body itself: what it is in loops."""
    return GROUND if is_ground(body) else body


@dataclass(frozen=True)
class Choice:
    """A kind of a family and the values of its fields [SI]."""

    kind: str
    values: LawValues

    def number(self, key: str, default: float | None = None) -> float:
        """The value of a field that is a number [SI], with its record; default: where the kind has no such field."""
        return as_number(self.values[key] if default is None else self.values.get(key, default))


class OilAt(NamedTuple):
    """An oil at a temperature [K], with its dynamic viscosity [Pa*s] and density [kg/m^3] there."""

    oil: Oil
    temperature: float
    viscosity: float
    density: float


@dataclass(frozen=True)
class OilFilm:
    """The oil in the clearance of a joint."""

    law: Choice  # of the family "film"
    boundary: float  # thickness of the boundary film [m]: at thinner films the dry contact begins
    roughness: float  # of both surfaces together, root mean square [m]
    density: float  # [kg/m^3]
    specific_heat: float  # [J/(kg*K)]
    assumed: str = ""  # what the program has chosen, in words
    oil: OilAt | None = None  # that the user has named


@dataclass(frozen=True)
class Contact:
    """The contact model of a joint with clearance.

    model: a kind of the family "contact", or "compliant"; then `normal`, `static` and `friction` are its laws.
    With a `film` they are those of the dry contact beside it.
    """

    model: str
    fields: Mapping[str, float] = field(default_factory=dict)
    bush_radius: float = 0.0  # [m]
    normal: Choice | None = None
    static: Choice | None = None
    friction: Choice | None = None
    unused: tuple[str, ...] = ()  # keys that only other models use
    film: OilFilm | None = None  # in the clearance, beside the laws of the dry contact
    word: str = ""  # the law that the user names, where stated damping puts another in its place
    rolling: float = 0.0  # lever arm of the resistance of a disc that rolls [m]
    pushes: bool = False  # of a closed joint: it stands for contacts that only push, and N < 0 is noted

    @property
    def acts(self) -> bool:
        """True if contacts act; otherwise constraints hold the joint."""
        kinds = registry.kinds("contact")
        return self.model not in kinds or kinds[self.model].leaf.contacts

    @property
    def mu(self) -> float:
        """Its coefficient of friction, of a law that of sliding; 0 without friction."""
        if self.friction is not None:
            return self.friction.number("mu", 0.0)
        return self.fields.get("friction", 0.0)

    @property
    def rigid(self) -> bool:
        """True where contacts act that nothing can penetrate."""
        return self.acts and self.normal is None

    @property
    def closed(self) -> bool:
        """True if the clearance is ignored."""
        return not self.acts and not registry.kinds("contact")[self.model].leaf.link

    @property
    def restitution_law(self) -> str:
        """Its law of restitution at impacts; "" if it has none."""
        kind = registry.kinds("contact").get(self.model)
        law = kind.fields.get("restitution_law") if kind is not None else None
        return law.choices[int(self.fields["restitution_law"])] if law is not None else ""

    @property
    def shares_by_stiffness(self) -> bool:
        """True if several contacts share the impulses of an impact by their stiffness."""
        law = self.restitution_law
        return law != "" and law == registry.kinds("contact")[self.model].leaf.shares_by_stiffness

    @property
    def title(self) -> str:
        """The word that the user writes for the model."""
        return self.law if self.normal and self.film is None else self.model

    @property
    def law(self) -> str:
        """The word for the law of its normal force; "" if it has none."""
        return self.word or (self.normal.kind if self.normal else "")

    @property
    def ends_by_force(self) -> bool:
        """True if it ends where its force does, before its gap opens."""
        return self.normal is not None and registry.normal_law(self.normal.kind).leaf.ends_by_force

    @property
    def vanishes(self) -> bool:
        """True if its force is 0 where its gap opens, however fast."""
        return self.normal is not None and registry.normal_law(self.normal.kind).leaf.vanishes


@dataclass(frozen=True)
class Wear:
    """How pin and bush of a joint wear, and the profiles that they have."""

    bush: float  # k: volume lost per force and sliding distance [m^2/N]
    pin: float
    foundation: float  # K_w: pressure per penetration [Pa/m]
    radius: float  # of the bush [m]
    length: float  # of the contact along the pin [m]
    bins: int
    smooth: float  # D of h_i += D (h_{i-1} - 2 h_i + h_{i+1}) after every jump [-]; 0: none
    cycle: float  # [s]; nan: one turn of the driver
    cycles: float
    jump: float  # cycles; nan: chosen
    wall: float  # thickness of the softer part [m]: at this depth it is worn through
    profile: tuple[tuple[float, ...], tuple[float, ...]] | None = None  # depths of bush and pin, (bins,) each [m]
    assumed: str = ""  # what the program has chosen, in words

    def bed(self, clearance: float) -> Choice:
        """The static force of the round pin on this foundation; clearance [m]."""
        fields = {"bush_radius": self.radius, "foundation": self.foundation, "length": self.length}
        return Choice("foundation", {**fields, "clearance": clearance})


@dataclass(frozen=True)
class WearLimit:
    """How deep a pin and its bush may wear, with or without play, and how fast they do."""

    rate: float  # k of both together: volume lost per force and sliding distance [m^2/N]
    limit: float  # depth that is allowed [m]; nan: not said
    band: Vector | None  # factors of the life that 10 and 90 % reach; None: those that are assumed


@dataclass(frozen=True)
class Stop:
    """The ends of the coordinate of a joint [m or rad], infinite where there is none, and what happens there."""

    minimum: float
    maximum: float
    contact: Contact


@dataclass(frozen=True)
class JointFriction:
    """Friction in a joint without play, by its own reaction, or of a size that does not depend on it."""

    arm: float  # moment by mu and the reaction, as the radius of a pin [m]; 1 where the joint slides
    reach: float = 0.0  # 1 / half length of the block [1/m]; 0: the moment of the joint does not press
    mu: float = 0.0
    mu_static: float = 0.0
    law: Choice | None = None  # None: set-valued, with mu and mu_static
    stated: bool = False  # True: set-valued, mu and mu_static are its size [N or N m]


@dataclass(frozen=True)
class Joint:
    """A joint between A (bush or guide side) and B (pin or block side)."""

    name: str
    kind: str
    a: Point
    b: Point
    fields: Mapping[str, float]
    clearance: float = 0.0  # radial [m]
    contact: Contact | None = None
    dimensions: Mapping[str, tuple[float, ...]] = field(default_factory=dict)  # tables of its kind of clearance [m]
    stop: Stop | None = None
    friction: JointFriction | None = None  # of a joint without play
    constants: tuple[float, ...] = ()  # [m or rad] of a kind whose rows count from the start
    counts: bool = True  # False: of such a kind only the rows act that do not count
    wear: Wear | None = None
    corners: Corners = field(default_factory=dict)  # points of B that may touch a surface
    wears: WearLimit | None = None
    named: Fit | BearingPlay | None = None  # what its play was written as
    radius: float = math.nan  # of its bush or pin [m]
    length: float = math.nan  # of the bearing along its pin [m]
    z: float = math.nan  # offset of its middle [m]

    @property
    def friction_path(self) -> tuple[str, ...]:
        """Where its friction without play is written: that of a disc that rolls on a surface in its contact."""
        return ("joints", self.name, *(("contact", "rolling") if self.leaf.touches else ("friction",)))

    @property
    def friction_named(self) -> str:
        """What that friction is."""
        return "rolling resistance" if self.leaf.touches else "dry friction of joints without play"

    @property
    def worn(self) -> Wear | None:
        """Wear of a joint whose contact is between two profiles; None if its surfaces are round, as those in oil."""
        if self.wear is None or self.wear.profile is None or self.contact is None:
            return None
        if self.contact.normal is None or self.contact.film is not None:
            return None
        return self.wear

    @property
    def numbers(self) -> tuple[float | LocalFunction, ...]:
        """What its kernel takes after the points: the values of its fields, then its constants; nan if not yet set."""
        numbers: list[float | LocalFunction] = []
        for key, declared in registry.kinds("joint")[self.kind].fields.items():
            if declared.shape == "labels":
                continue
            numbers += pair(self.fields, key) if declared.shape == "pair" else (self.fields[key],)
        if self.leaf.placing:
            numbers.append(float(self.counts))
        if self.leaf.from_start:
            numbers += self.constants or ((math.nan if self.counts else 0.0),) * self.leaf.from_start
        return tuple(numbers)

    @property
    def from_start(self) -> int:
        """Number of its constants that the start sets."""
        return self.leaf.from_start if self.counts else 0

    @property
    def rows(self) -> tuple[str, ...]:
        """Units of the rows of its kind that act, m or rad."""
        return self.leaf.rows if self.counts else self.leaf.rows[: self.leaf.placing]

    @property
    def leaf(self) -> type[JointKind]:
        """The class of its kind."""
        return registry.kinds("joint")[self.kind].leaf

    @property
    def play(self) -> type[ClearanceKind]:
        """The class of its kind of clearance; only of a kind of joint that can have clearance."""
        kind = registry.play_of(self.kind)
        assert kind is not None, f"a {self.kind} joint cannot have clearance"
        return kind.leaf

    @property
    def motor(self) -> Motor:
        """The motor of its coordinate; only of a kind of joint that has one."""
        assert self.leaf.motor is not None, f"a {self.kind} joint has nothing to drive"
        return self.leaf.motor

    @property
    def kept_angle(self) -> float | None:
        """Angle of B relative to A [rad] that the joint enforces; None if B can turn."""
        return self.leaf.kept_angle(self.fields)

    @property
    def line(self) -> float | None:
        """Direction in A's frame [rad] of the line on which the point of B moves; None if there is none."""
        return self.leaf.line(self.fields)

    @property
    def distance(self) -> float:
        """Distance of the two points [m] that the joint enforces."""
        return self.leaf.distance(self.fields)

    @property
    def is_loose(self) -> bool:
        """True if the joint has contacts in place of constraints: clearance, or a joint that is one-sided."""
        return self.contact is not None and self.contact.acts and (self.clearance > 0.0 or self.one_sided is not None)

    @property
    def passing(self) -> bool:
        """True if bodies come to its contacts and leave them, so that it does not hold the mechanism together."""
        return bool(self.leaf.passing(self.fields))

    @property
    def held_by_stops(self) -> bool:
        """True if it has no rows and only its stops hold it, as a rope."""
        return self.leaf.held_by_stops(self.fields)

    @property
    def places(self) -> bool:
        """True if its rows say where the point of B is, apart from a slide along a line or a turn about a point."""
        return self.leaf.places and not self.held_by_stops

    @property
    def coordinate(self) -> str:
        """The coordinate that results and expressions know of it: angle, position or distance; "" if none."""
        return self.leaf.stops if self.held_by_stops else self.leaf.coordinate

    @property
    def one_sided(self) -> type[OneSidedKind] | None:
        """The class of its one-sided contacts; None if it has no such."""
        kind = registry.one_sided_of(self.kind)
        return kind.leaf if kind else None

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Contact models of its clearance and of its stop."""
        stop = self.stop.contact if self.stop is not None else None
        return tuple(contact for contact in (self.contact, stop) if contact is not None)

    @property
    def stops_angle(self) -> bool:
        """True if the joint has a stop of its angle, which exerts a moment."""
        kind = registry.stop_of(self.kind)
        return self.stop is not None and kind is not None and kind.leaf.angular

    @property
    def friction_unit(self) -> str:
        """Unit of its own friction: of the row along which it acts, or of the effort of a motor."""
        tangents = self.leaf.tangents
        return registry.kinds("tangent")[tangents[0]].leaf.unit if tangents else self.motor.unit

    @property
    def is_hinge(self) -> bool:
        """True if both bodies share a point and turn about it, apart from the clearance."""
        return self.places and self.line is None and self.distance == 0.0 and self.kept_angle is None


@dataclass(frozen=True)
class Driver:
    """A joint's degree of freedom, or a coordinate of a body, as a function of time: angle [rad] or position [m].

    For a kind that integrates, `value` is its rate.
    """

    name: str
    kind: str
    joint: str  # "" if a body is driven
    value: Value
    point: Point | None = None  # the driven point of a body
    constants: tuple[float, ...] = ()  # [m or rad] of a kind that goes on from the start

    @property
    def moves_ground(self) -> bool:
        """True if it moves a point of the ground."""
        return self.point is not None and is_ground(self.point.body)

    @property
    def path(self) -> tuple[str | int, ...]:
        """Where it is written in the model file."""
        if self.point is None or not self.moves_ground:
            return ("drivers", self.name)
        coordinate = 1 if self.kind == "body-y" else 0
        return ("ground", "points", point_of_ground(self.point.body), coordinate)

    @property
    def leaf(self) -> type[DriverKind]:
        """The class of its kind."""
        return registry.kinds("driver")[self.kind].leaf

    @property
    def sets_angle(self) -> bool:
        """True if its function is the angle of B relative to A."""
        return self.leaf.sets_angle

    @property
    def key(self) -> str:
        """The key of its function in the model file."""
        return next(iter(registry.kinds("driver")[self.kind].fields))

    @property
    def travel(self) -> str:
        """Name of the state that is the integral of its speed; "" if it is driven by angle or position."""
        return f"{self.name}.travel" if self.leaf.rate_of else ""

    @property
    def on(self) -> str:
        """What is driven, in words."""
        return f"joint '{self.joint}'" if self.point is None else f"body '{self.point.body}'"


NUMBERS = {"connect": 4, "point": 2, "pair": 2, "triple": 3, "body": 0}  # of a field of this shape, if not one


@dataclass(frozen=True)
class Load:
    """A load: values [SI] in the order of the kind's fields, with those of its points."""

    name: str
    kind: str
    a: Point
    b: Point
    values: tuple[Value, ...]
    points: bool  # the kernel takes the points before the values
    law: Callable[..., object] | None = None
    slack: Node | None = None  # that of the values which says that it is slack: it changes with the motion alone

    @property
    def fields(self) -> dict[str, tuple[Value, ...]]:
        """Its values [SI] by the name of their field."""
        left, fields = iter(self.values), registry.kinds("load")[self.kind].fields
        return {key: tuple(islice(left, NUMBERS.get(field.shape, 1))) for key, field in fields.items()}


@dataclass(frozen=True)
class State:
    """A state of the model's own: its rate [unit/s], an expression, its value at the start [SI]."""

    name: str
    rate: Node
    start: float
    unit: str  # SI unit, "" if it cannot be told
    travel: bool = False  # it is how far a driver has come whose speed is given: a function of time alone


@dataclass(frozen=True)
class ValueTable:
    """A distribution of single values."""

    values: tuple[float, ...]  # [SI], as written
    weights: tuple[float, ...]  # of each value [-], not negative, not all zero


LIMIT_ROUNDING = 1e-12  # share of a limit by which a value may pass it: 0.8*0.175 is not below 0.14


@overload
def within_limits(value: float, minimum: float | None, maximum: float | None) -> bool: ...
@overload
def within_limits(value: np.ndarray, minimum: float | None, maximum: float | None) -> np.ndarray: ...
def within_limits(value: float | np.ndarray, minimum: float | None, maximum: float | None) -> bool | np.ndarray:
    """Whether a value, or each of an array, is between two limits, either of which may be missing, but for rounding."""
    least = -math.inf if minimum is None else minimum - LIMIT_ROUNDING * abs(minimum)
    most = math.inf if maximum is None else maximum + LIMIT_ROUNDING * abs(maximum)
    return (value >= least) & (value <= most)


@dataclass(frozen=True)
class Parameter:
    """A named number [SI]; min and max are the range of sliders, tol and dist serve tolerance studies."""

    name: str
    value: float
    unit: str
    minimum: float | None = None
    maximum: float | None = None
    tol: float | None = None
    dist: str | ValueTable = ""  # "" where the file does not say
    label: str = ""  # what sliders and reports call it; "" for its name
    description: str = ""  # what a reader should know of it
    deviates: bool = False  # it is how far a size lies off its nominal one, and may have either sign

    @property
    def title(self) -> str:
        """What people read: its label and its name, or its name alone."""
        return f"{self.label} ({self.name})" if self.label else self.name


@dataclass(frozen=True)
class Initial:
    """Start values that the user gave.

    Per body any of x, y [m], angle [rad], vx, vy [m/s], omega [rad/s]; per clearance joint the offset (2,) [m].
    """

    bodies: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    offsets: Mapping[str, Vector] = field(default_factory=dict)
    near: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    """x, y [m] and angle [rad] per body of a start on whose branch, and in whose turn, this one is looked for."""
    near_shut: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    """The same of the mechanism without play."""
    held: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """What of `bodies` was not given: places of bodies that loads hold, see `assembly.held_bodies`."""

    def given(self, body: str) -> set[str]:
        """Which of x, y and angle of a body the user gave."""
        return {"x", "y", "angle"} & self.bodies.get(body, {}).keys() - self.held.get(body, {}).keys()

    def with_places(self, places: Mapping[str, Mapping[str, float]]) -> Initial:
        """The same with places of such bodies, where none are given."""
        filled = {name: {**place, **self.bodies.get(name, {})} for name, place in places.items()}
        return replace(self, bodies={**self.bodies, **filled}, held={**self.held, **places})


@dataclass(frozen=True)
class DutyCase:
    """What a machine does for a share of its time."""

    share: float  # of time, in proportion to the other cases
    changes: Mapping[str, Any]  # values of parameters, as they are written
    name: str = ""


@dataclass(frozen=True)
class HeatPaths:
    """Where the heat of joints goes."""

    ambient: float | None = None  # temperature of the air [K]
    cooling: Mapping[str, float] = field(default_factory=dict)  # to the air, by joint [W/K]
    conduction: Mapping[tuple[str, str], float] = field(default_factory=dict)  # between two joints [W/K]


@dataclass(frozen=True)
class Settings:
    """The [simulate] table; None means that the program decides."""

    t_end: float = 1.0
    method: str | None = None
    rtol: float | None = None
    atol: float | None = None
    step: float | None = None
    output: float | None = None


@dataclass(frozen=True)
class Model:
    """All content of a model file, in SI units."""

    name: str
    gravity: Vector  # [m/s^2], at t = 0
    parameters: Mapping[str, Parameter]
    signals: Mapping[str, Node]  # in order of evaluation
    signal_units: Mapping[str, str]
    ground: Mapping[str, Vector]
    bodies: Mapping[str, Body]
    joints: Mapping[str, Joint]
    drivers: Mapping[str, Driver]
    loads: Mapping[str, Load]
    initial: Initial
    settings: Settings
    constants: Mapping[str, float]
    remarks: tuple[str, ...] = ()  # on values that may be mistakes
    groups: tuple[tuple[str, ...], ...] = ()  # parameters that are made together: one draw moves all of a group
    states: Mapping[str, State] = field(default_factory=dict)
    tables: Tables = NO_TABLES
    definitions: Mapping[str, Node] = field(default_factory=dict)  # what names of points, joints and loads stand for
    materials: Mapping[str, Material] = field(default_factory=dict)  # of the model's own
    named_materials: Mapping[str, Material] = field(default_factory=dict)  # by the place at which a name stands for one
    duty: tuple[DutyCase, ...] = ()
    heat: HeatPaths | None = None
    falling: tuple[Node, Node] | None = None  # gravity [m/s^2] as a function of t; None: it stays as it is

    @property
    def moving_bodies(self) -> list[str]:
        """Names of all bodies but points of the ground."""
        return [name for name in self.bodies if not is_ground(name)]

    @property
    def motors(self) -> dict[str, Driver]:
        """All drivers but those of points of the ground."""
        return {name: driver for name, driver in self.drivers.items() if not driver.moves_ground}

    @property
    def remembers(self) -> bool:
        """True if it has states of its own, on which all that was before has an influence."""
        return not all(state.travel for state in self.states.values())

    @property
    def falls(self) -> bool:
        """True if there is gravity at some time."""
        return self.falling is not None or any(self.gravity)

    @property
    def recorded(self) -> dict[str, str]:
        """Names and SI units of the quantities that a run records besides bodies, joints and energies."""
        units = {name: state.unit for name, state in self.states.items()}
        return units | {name: self.signal_units.get(name, "") for name in self.signals}


Data = TypeVar("Data")


def with_fields(data: Data, /, **fields: Any) -> Data:
    """As `dataclasses.replace`, for data without derived fields, in a fifth of the time."""
    changed = object.__new__(type(data))
    changed.__dict__.update(data.__dict__)
    changed.__dict__.update(fields)
    return changed


def driven_ends(model: Model, driver: Driver) -> tuple[Point, Point, tuple[float, ...]]:
    """Points A and B between which a driver acts, and the numbers [SI] that its kernel takes before its function."""
    if driver.point is not None:
        return Point("ground", "", (0.0, 0.0)), driver.point, ()
    joint, leaf = model.joints[driver.joint], driver.leaf
    constants = driver.constants or (math.nan,) * leaf.from_start
    return joint.a, joint.b, (*before_function(joint, registry.kinds("driver")[driver.kind]), *constants)


def before_function(joint: Joint, driver: registry.Kind[DriverKind]) -> tuple[float, ...]:
    """Numbers of a joint that the kernel of its driver takes before the function: the direction of its line [rad]."""
    return (0.0 if joint.line is None else joint.line,) if driver.leaf.along_line else ()
