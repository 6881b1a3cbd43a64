"""The tables of a mechanism's parts: bodies with their points, joints, drivers, loads."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import filterfalse

from rattle import registry
from rattle.description.model import (
    DEFAULT_CONTACT,
    DEFAULT_STOP,
    Body,
    Choice,
    Contact,
    Driver,
    Joint,
    JointFriction,
    Load,
    Point,
    Stop,
    Value,
    Vector,
    is_ground,
)
from rattle.description.read_bars import read_bar
from rattle.description.read_contact import (
    contact_models,
    read_contact,
    site_of_clearance,
    site_of_one_sided,
    site_of_stop,
)
from rattle.description.read_fields import MANY, FieldReader
from rattle.description.read_friction import joint_friction, rolling_friction
from rattle.description.read_plates import read_plate
from rattle.description.read_play import read_play
from rattle.description.read_values import Values, quoted
from rattle.description.read_wear import kind_wears, read_limit, read_wear
from rattle.description.reading import Path, Table
from rattle.description.tables import BODY, DRIVER, ENDS, JOINT, JOINT_TO_DRIVE, WHOLE_BODIES
from rattle.errors import suggest
from rattle.interfaces.contacts import ClearanceKind, Corners
from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import DriverKind, JointKind
from rattle.interfaces.loads import LoadKind
from rattle.language.expression import Name, Node, Number, names, parse, replaced
from rattle.language.recorded import as_number, bare
from rattle.language.units import Dimension, dimension_of
from rattle.registry import Field

Target = tuple[registry.Kind[DriverKind], str, Point | None, str]  # kind of driver, joint, point, what is driven
NOWHERE = Point("", "", (math.nan, math.nan))
OF_CONTACT = "the friction of a {} belongs to its contact: contact = {{ model, friction, ... }}"
ALIKE = 0.01  # share by which the radius of a bush may differ from that of its fit
LIFTS = "a {} joint with a contact may lift off, and has no friction; leave one of them out"


def moved_joints(driver: str = "") -> list[str]:
    """Kinds of joints that a kind of driver moves; all that can be driven if `driver` is ""."""
    kinds = registry.kinds("joint").items()
    driver = registry.kinds("driver")[driver].leaf.rate_of or driver if driver else ""
    return sorted(name for name, kind in kinds if kind.leaf.motor and driver in ("", kind.leaf.motor.driver))


def local_names(field: Field, a: Point, b: Point) -> dict[str, tuple[Node, Dimension]]:
    """What the local names of a field stand for between two ends, and their dimensions."""
    stand_for: dict[str, tuple[Node, Dimension]] = {}
    for local in field.local:
        node = parse(local.formula)
        ends: dict[str, Node] = {}
        for word in names(node):
            letter, _, key = word.partition(".")
            body = {"A": a, "B": b}[letter].body
            ends[word] = Name(f"{body}.{key}", 0) if body != "ground" else Number(0.0, 0)
        stand_for[local.name] = replaced(node, ends), dimension_of(local.unit)
    return stand_for


def same_angle(joints: Iterable[Joint], a: str, b: str) -> list[str]:
    """Names of joints that together keep two bodies at one angle to each other; none if they can turn."""
    kept: dict[str, list[tuple[str, str]]] = {}
    for joint in joints:
        if joint.kept_angle is not None and (joint.contact is None or joint.contact.closed or joint.clearance == 0.0):
            for body, other in ((joint.a.body, joint.b.body), (joint.b.body, joint.a.body)):
                kept.setdefault(body, []).append((other, joint.name))
    reached: dict[str, list[str]] = {a: []}
    waiting = [a]
    while waiting:
        body = waiting.pop(0)
        for other, joint_name in kept.get(body, ()):
            if other not in reached:
                reached[other] = [*reached[body], f"'{joint_name}'"]
                waiting.append(other)
    return reached.get(b, []) if a != b else []


def _with_bush(table: Table, radius: float) -> Table:
    """A joint with the radius of its bush [m] in the table of its contact, where a fit says it and that does not."""
    contact = table.get("contact")
    if math.isnan(bare(radius)) or not isinstance(contact, Mapping) or "bush_radius" in contact:
        return table
    kind = registry.kinds("contact").get(str(contact.get("model")))
    if kind is not None and not kind.leaf.contacts:
        return table
    return {**table, "contact": {**contact, "bush_radius": radius}}


def _require_bush_of_fit(values: Values, contact: Contact | None, radius: float, path: Path) -> None:
    """Say what differs if a contact says another radius of the bush than the fit [m], which is nan without one."""
    stated = math.nan if contact is None or not contact.bush_radius else bare(contact.bush_radius)
    if abs(stated - bare(radius)) > ALIKE * bare(radius):
        half = f"half of the diameter of the fit is {1e3 * bare(radius):.6g} mm, not {1e3 * stated:.6g} mm"
        values.wrong((*path, "contact", "bush_radius"), f"{half}; leave it out, the fit says it")


def _radius(kind: registry.Kind[JointKind], contact: Contact | None, friction: JointFriction | None) -> float:
    """Radius of the pin of a joint [m], by its bush or by its friction; nan if neither says it."""
    if contact is not None and contact.bush_radius:
        return contact.bush_radius
    by_friction = friction is not None and not friction.stated and "pin_radius" in kind.leaf.rubs_with
    return friction.arm if friction is not None and by_friction else math.nan


def _length(own: float | None, contact: Contact | None) -> float:
    """Length of a bearing along its pin [m], its own or that of its contact; nan if neither is known."""
    if own is not None:
        return own
    law = None if contact is None else contact.film.law if contact.film is not None else contact.static
    length = law.values.get("length") if law is not None else None
    return math.nan if length is None else as_number(length)


class Parts(FieldReader):
    """Reads parts one by one; later parts refer to those read before."""

    def __init__(self, values: Values) -> None:
        super().__init__(values)
        self.ground: dict[str, Vector] = {}  # at t = 0
        self.bodies: dict[str, Body] = {}
        self.joints: dict[str, Joint] = {}
        self.drivers: dict[str, Driver] = {}
        self.loads: dict[str, Load] = {}
        self.broken_joints: set[str] = set()  # present in the file, but with problems
        self.vague: set[str] = set()  # bodies whose points are not all known, because of a problem
        self.driven: dict[str, str] = {}  # joint: its driver

    # ------------------------------------------------------------ bodies and points
    def add_body(self, name: str, table: Table) -> None:
        """Read a body in its general form, a bar, or a plate."""
        path = ("bodies", name)
        if "polygon" in table:
            self.bodies[name] = read_plate(self, name, table)
            return
        if "bar" in table:
            self.bodies[name], sound = read_bar(self, name, table)
            if not sound:
                self.vague.add(name)
            return
        read = self.form(BODY, table, path)
        x, y = read["center"] or (0.0, 0.0)
        points = {key: (px - x, py - y) for key, (px, py) in (read["points"] or {}).items()}
        self.bodies[name] = Body(name, read["mass"], read["inertia"], points, z=read["z"])

    def point(self, written: object, path: Path, alone: bool = False) -> Point:
        """The point named by "body.point"; with `alone` also by "body" (its mass centre; the origin of the ground)."""
        if not isinstance(written, str):
            self.values.wrong(path, f'expected "body.point", got {quoted(written)}')
            return NOWHERE
        body, dot, point = written.partition(".")
        if body != "ground" and body not in self.bodies:
            self.values.wrong(
                path, f"no body {quoted(body)}{suggest(body, ['ground', *filterfalse(is_ground, self.bodies)])}"
            )
            return NOWHERE
        points = self.ground if body == "ground" else self.bodies[body].points
        if not dot and alone:
            return Point(body, "", (0.0, 0.0))
        if point not in points and body in self.vague:
            return NOWHERE
        if body == "ground" and f"ground.{point}" in self.bodies:
            return Point(f"ground.{point}", "", (0.0, 0.0))
        if point not in points:
            hint = suggest(point, points)
            whose = "the ground" if body == "ground" else f"body '{body}'"
            what = f"no point {quoted(point)} on {whose}" if point else f'expected "body.point", got {quoted(written)}'
            self.values.wrong(path, what + hint)
            return NOWHERE
        return Point(body, point, points[point])

    def connect(self, table: Table, path: Path, alone: bool = False, bodies: bool = False) -> tuple[Point, Point]:
        """The two ends of a joint or load; alone: also bodies without a point, bodies: whose points mean nothing."""
        form = (WHOLE_BODIES if bodies else ENDS).like
        if "connect" not in table:
            self.values.wrong(path, f"needs connect = {form}")
            return NOWHERE, NOWHERE
        both = table["connect"]
        here = (*path, "connect")
        if not isinstance(both, list | tuple) or len(both) != 2:
            self.values.wrong(here, f"expected {form}, got {quoted(both)}")
            return NOWHERE, NOWHERE
        a, b = (self.point(end, (*here, k), alone) for k, end in enumerate(both))
        if bodies:
            a, b = (Point(end.body, "", (0.0, 0.0)) for end in (a, b))
        if a.body and (a.body == b.body or (is_ground(a.body) and is_ground(b.body))):
            same = a.body if a.body == b.body else "ground"
            self.values.wrong(here, f"both ends are on '{same}'; expected two different bodies")
        return a, b

    # ------------------------------------------------------------ joints
    def add_joint(self, name: str, table: Table) -> None:
        """Read a joint with its clearance and contact."""
        values, path = self.values, ("joints", name)
        before = len(values.problems)
        kind = self.choose(table, registry.kinds("joint"), path)
        if kind is None:
            self.broken_joints.add(name)
            return
        a, b = self.connect(table, path, alone=kind.leaf.bodies, bodies=kind.leaf.bodies)
        play = registry.play_of(kind.name)
        sizes: Mapping[str, Mapping[str, Field]] = play.leaf.dimensions if play else {}
        values.keys(table, dict.fromkeys(["type", *JOINT.fields, *sizes, *kind.fields]), path)
        fields = self.fields(kind, table, path)
        if len(values.problems) == before:  # of fields that are sound
            self._require_consistent(kind, table, fields, path)
        named, own = kind.name, self.read(JOINT, {key: table[key] for key in table if key not in kind.fields}, path)
        bearing = self._bearing_length(table, kind, own["length"], path)
        if "contact" in table:
            kind, fields = self._lifting(kind, fields, path)
        play_read = read_play(self, name, table, named, kind_wears(kind), path)
        bush = play_read.radius if play is not None and play.leaf.has_radius else math.nan
        table = _with_bush(table, bush)
        contact = self._contact(table, kind, fields, play_read.clearance, path)
        _require_bush_of_fit(values, contact, bush, path)
        clearance = 0.0 if play_read.clearance is None else play_read.clearance
        if len(values.problems) == before:
            contact = self._passing(kind, fields, clearance, contact, path)
        stop = self._stop(table["stop"], kind.name, (*path, "stop")) if "stop" in table else None
        dimensions = self._dimensions(sizes, table, play, contact, path)
        corners = self._corners(fields, b, path) if len(values.problems) == before else {}
        sound, block = len(values.problems) == before, next(iter(dimensions.values()), ())
        friction = self._friction(table, kind, (fields, sound), block, (clearance, contact), (named, path))
        wear, contact = read_wear(self, table, kind, clearance, contact, bearing, (*path, "wear"))
        joint = Joint(
            name, kind.name, a, b, fields, clearance, contact, dimensions, stop, friction, wear=wear, corners=corners,
            counts=not (friction is not None and kind.leaf.placing), named=play_read.title,
            z=math.nan if own["z"] is None else own["z"],
        )  # fmt: skip
        self.joints[name] = self._as_bearing(joint, kind, table, bush, bearing)
        if len(values.problems) > before:
            self.broken_joints.add(name)

    def _as_bearing(
        self, joint: Joint, kind: registry.Kind[JointKind], table: Table, bush: float, bearing: float | None
    ) -> Joint:
        """A joint with the size of its bearing, and how far it may wear.

        bush: radius by a fit [m], nan without one; bearing: length that is stated [m].
        """
        wear = joint.wear
        radius = _radius(kind, joint.contact, joint.friction)
        radius = bush if math.isnan(bare(radius)) else radius
        length = _length(bearing, joint.contact) if wear is None or bearing is not None else wear.length
        wears = None
        if wear is not None or not joint.clearance > 0.0:
            wears = read_limit(self, table, kind, wear, radius, ("joints", joint.name, "wear"))
        return replace(joint, wears=wears, radius=radius, length=length)

    def _bearing_length(
        self, table: Table, kind: registry.Kind[JointKind], length: float | None, path: Path
    ) -> float | None:
        """Length of the bearing of a joint [m]; None if it has none, or has another length of its own."""
        if length is None or kind_wears(kind):
            return length
        why = f"a {kind.name} joint has no pin in a bush, whose length this would be; leave it out"
        self.values.wrong((*path, "length"), why, at_key=True)
        return None

    def _lifting(
        self, kind: registry.Kind[JointKind], fields: dict[str, float], path: Path
    ) -> tuple[registry.Kind[JointKind], dict[str, float]]:
        """The kind that a joint is with a contact, which lets it lift off, and its fields; most are what they were."""
        if kind.leaf.lifting is None:
            return kind, fields
        name, renamed = kind.leaf.lifting
        other = registry.kinds("joint")[name]
        return other, self.fields(other, {}, path) | {renamed.get(key, key): fields[key] for key in fields}

    def _friction(
        self, table: Table, kind: registry.Kind[JointKind], read: tuple[Fields, bool], block: Sequence[float],
        play: tuple[float, Contact | None], entry: tuple[str, Path],
    ) -> JointFriction | None:  # fmt: skip
        """The friction of a joint without play; read: fields, and if they are sound; play: clearance [m], contact.

        entry: kind as it is written, and its path.
        """
        (fields, sound), (clearance, contact), here = read, play, (*entry[1], "friction")
        if kind.leaf.touches and "friction" in table:
            self.values.wrong(here, OF_CONTACT.format(entry[0]), at_key=True)
            return None
        if contact is not None and contact.rolling > 0.0:
            return rolling_friction(contact, fields["roller"])
        if "friction" not in table or "friction" in kind.fields:
            return None
        friction = joint_friction(
            self, table["friction"], kind, fields if sound else None, block, clearance > 0.0, here
        )
        lifts = contact is not None and contact.acts and not clearance > 0.0
        if why := LIFTS.format(kind.name) if lifts else kind.leaf.friction_fault(fields):
            self.values.wrong(here, why, at_key=True)
        return friction

    def _corners(self, fields: Fields, b: Point, path: Path) -> Corners:
        """What of B may touch: the points that are named, the corners of its plate, or its point."""
        labels: Sequence[str] | float = fields.get("corners", ())
        if fields.get("outline"):
            return self._outline(b.body, path)
        if isinstance(labels, float) or not labels:
            return {b.name: b.at}
        return self._named_corners(labels, b.body, path)

    def _outline(self, body: str, path: Path) -> Corners:
        """The corners of a plate, by their numbers from 1 on; none after a problem."""
        outline = self.bodies[body].outline if body in self.bodies else ()
        if not outline:
            why = f"'{body}' is no plate, which has an outline; name its corners: corners = [...]"
            self.values.wrong((*path, "outline"), why, at_key=True)
            return {}
        return {str(n): corner for n, corner in enumerate(outline[0], 1)}

    def _named_corners(self, labels: Sequence[str], body: str, path: Path) -> Corners:
        """Points of a body by their names; without those that it does not have, after a problem."""
        if body != "ground" and is_ground(body):
            why = f"'{body}' moves over t, and other points of the ground do not move with it; leave corners out"
            self.values.wrong((*path, "corners"), why, at_key=True)
            return {}
        points = self.ground if body == "ground" else self.bodies[body].points
        for n, label in enumerate(labels):
            if f"{body}.{label}" in self.bodies:
                why = f"'{body}.{label}' moves over t, away from the other corners; give it a surface of its own"
                self.values.wrong((*path, "corners", n), why)
            elif label not in points:
                own = label.removeprefix(f"{body}.")
                hint = f"; write '{own}': corners are points of this body" if own in points else suggest(label, points)
                self.values.wrong((*path, "corners", n), f"no point {quoted(label)} on '{body}'{hint}")
        return {label: points[label] for label in labels if label in points}

    def _require_consistent(self, kind: registry.Kind[JointKind], table: Table, fields: Fields, path: Path) -> None:
        """Refuse fields of a joint that are sound one by one, but not together."""
        before = len(self.values.problems)
        for key, fault in kind.leaf.faults(table, fields):
            self.values.wrong((*path, key) if key else path, fault)
        if len(self.values.problems) == before and (fault := kind.leaf.fault(fields)):
            self.values.wrong(path, fault)

    def _contact(
        self, table: Table, kind: registry.Kind[JointKind], fields: Fields, clearance: float | None,
        path: Path,
    ) -> Contact | None:  # fmt: skip
        """The contact of a joint: of its clearance, its strands or its one side; None without, or after a problem."""
        here = (*path, "contact")
        if clearance is not None:
            return self._contact_of_play(table, kind.name, clearance, path)
        if (law := kind.leaf.strand(fields)) is not None:
            if "contact" in table:
                self.values.wrong(here, f"a {kind.name} has stiffness and damping of its own", at_key=True)
            static = Choice("power", {"stiffness": law.stiffness, "exponent": 1.0})
            return Contact("compliant", normal=Choice("tension", {"damping": law.damping}), static=static)
        if "contact" in table and (sided := registry.one_sided_of(kind.name)) is not None:
            return read_contact(self, table["contact"], site_of_one_sided(sided, kind.leaf.curvature(fields)), here)
        if "contact" in table and kind.leaf.stops:
            self.values.wrong(here, f"a {kind.name} has contacts at its stop only: write it there", at_key=True)
        elif "contact" in table:
            play = "needs a clearance of the joint (radial, in m)"
            both = f"a {kind.name} joint holds on both sides and has no contact; leave it out"
            self.values.wrong(here, play if registry.play_of(kind.name) is not None else both, at_key=True)
        return None

    def _passing(
        self,
        kind: registry.Kind[JointKind],
        fields: Fields,
        clearance: float,
        contact: Contact | None,
        path: Path,
    ) -> Contact | None:
        """The contact of a joint that bodies come to and leave: it must act, and has a bush if it needs one."""
        if not (what := kind.leaf.passing(fields)):
            return contact
        play = registry.play_of(kind.name)
        if contact is None or not contact.acts or (play is not None and not clearance > 0.0):
            needed = "clearance and a contact" if play is not None else "a contact"
            self.values.wrong(path, f'{what} needs {needed} that acts, such as "impact": it holds by its walls alone')
            return contact
        radius = kind.leaf.assumed_radius(fields)
        if contact.bush_radius > 0.0 or not radius > clearance:
            return contact
        self.values.remarks.append(
            f"{'.'.join(map(str, path))}: bush_radius is not given, and a pin strikes the corners of a mouth with its"
            f" radius; {radius:.3g} m is assumed"
        )
        return replace(contact, bush_radius=radius)

    def _dimensions(
        self, sizes: Mapping[str, Mapping[str, Field]], table: Table, play: registry.Kind[ClearanceKind] | None,
        contact: Contact | None, path: Path,
    ) -> dict[str, tuple[float, ...]]:  # fmt: skip
        """The lengths [m] in the tables of dimensions of a joint with clearance."""
        dimensions = {}
        for key, wanted in sizes.items():
            here = (*path, key)
            if key in table:
                lengths = self.values.table(table[key], here)
                self.values.keys(lengths, wanted, here)
                dimensions[key] = tuple(self.field(size, name, lengths, {}, here) for name, size in wanted.items())
            elif contact is not None and not contact.closed and play is not None:
                inside = ", ".join(wanted)
                self.values.wrong(path, f"a {play.leaf.bearer} with clearance needs {key} = {{ {inside} }} in m")
        return dimensions

    def _contact_of_play(self, table: Table, joint: str, clearance: float, path: Path) -> Contact | None:
        if registry.play_of(joint) is None:
            self.values.wrong((*path, "clearance"), f"a {joint} joint cannot have clearance; leave it out", at_key=True)
            return None
        if "contact" in table:
            return read_contact(self, table["contact"], site_of_clearance(joint, clearance), (*path, "contact"))
        suited = contact_models(joint)
        if DEFAULT_CONTACT in suited:
            return read_contact(self, DEFAULT_CONTACT, site_of_clearance(joint, clearance), path)
        self.values.wrong(path, f"a {joint} joint with clearance needs a contact: {', '.join(suited)}")
        return None

    def _stop(self, written: object, joint: str, path: Path) -> Stop | None:
        """The ends of the coordinate of a joint, with their contact model; None after a problem."""
        values, kind = self.values, registry.stop_of(joint)
        if kind is None:
            where = " or ".join(name for name in registry.kinds("joint") if registry.stop_of(name))
            values.wrong(
                path, f"a {joint} joint has no coordinate that a stop could end; expected {where}", at_key=True
            )
            return None
        table = values.table(written, path)
        values.keys(table, (*kind.fields, "contact"), path)
        if not any(key in table for key in kind.fields):
            ends = " or ".join(f"{key} in {end.unit}" for key, end in kind.fields.items())
            values.wrong(path, f"needs an end: {ends} ({', '.join(end.meaning for end in kind.fields.values())})")
        least, largest = self.fields(kind, table, path).values()
        if least >= largest:
            unit = next(iter(kind.fields.values())).unit
            values.wrong(path, f"min = {least:g} {unit} must be less than max = {largest:g} {unit}")
        contact = read_contact(self, table.get("contact", DEFAULT_STOP), site_of_stop(kind), (*path, "contact"))
        return Stop(least, largest, contact) if contact is not None else None

    # ------------------------------------------------------------ drivers and loads
    def add_driver(self, name: str, table: Table) -> None:
        """Read a driver: a joint's degree of freedom or a coordinate of a body as a function of time."""
        values, path = self.values, ("drivers", name)
        functions = dict.fromkeys(key for kind in registry.kinds("driver").values() for key in kind.fields)
        values.keys(table, [*DRIVER.keys, *functions], path)
        self.read(DRIVER, table, path)
        if "body" in table and "joint" in table:
            values.wrong(path, "give a joint or a body to drive, not both")
            return
        target = self._driven_body(table, path) if "body" in table else self._driven_joint(table, path)
        if target is not None and "speed" in table:
            target = self._with_speed(target)
        if target is None:
            return
        what = target[-1]
        if what in self.driven:
            values.wrong(
                path, f"{what} is already driven by '{self.driven[what]}': two drivers on one degree of freedom"
            )
            return
        self.driven[what] = name
        self._drive(name, target, [key for key in functions if key in table], table)

    def _drive(self, name: str, target: Target, functions: Sequence[str], table: Table) -> None:
        """Add a driver of a target; functions: keys that are written."""
        values, path, (kind, joint, point, what) = self.values, ("drivers", name), target
        wrong = [other for other in functions if other not in kind.fields]
        (key,) = kind.fields
        if kind.leaf.rate_of in table:
            values.wrong(path, f"give {kind.leaf.rate_of} or {key}, not both")
            return
        for other in wrong:
            values.wrong((*path, other), f"{what} is driven by '{key}', not by '{other}'", at_key=True)
        if key in table or not wrong:
            self.drivers[name] = Driver(name, kind.name, joint, self.fields(kind, table, path)[key], point)

    def _driven_joint(self, table: Table, path: Path) -> Target | None:
        """Kind of driver, joint, and what is driven, in words; None after a problem."""
        if "coordinate" in table:
            self.values.wrong((*path, "coordinate"), "only a driven body has a coordinate", at_key=True)
        if "joint" not in table:
            self.values.wrong(path, f"{JOINT_TO_DRIVE.missing}{suggest('', self.joints)}")
            return None
        joint, here = table["joint"], (*path, "joint")
        if not isinstance(joint, str) or joint not in self.joints:
            if joint not in list(self.broken_joints):
                self.values.wrong(here, f"no joint {quoted(joint)}{suggest(str(joint), self.joints)}")
            return None
        motor = self.joints[joint].leaf.motor
        if motor is not None:
            return registry.kinds("driver")[motor.driver], joint, None, f"joint '{joint}'"
        drivable = " or ".join(moved_joints())
        self.values.wrong(here, f"a {self.joints[joint].kind} joint has nothing to drive; expected {drivable}")
        return None

    def _with_speed(self, target: Target) -> Target:
        """The same with the kind of driver that takes a speed, if there is one."""
        rates = (rate for rate in registry.kinds("driver").values() if rate.leaf.rate_of == target[0].name)
        return (next(rates, target[0]), *target[1:])

    def _driven_body(self, table: Table, path: Path) -> Target | None:
        """Kind of driver, no joint, the point, and what is driven, in words; None after a problem."""
        kinds = registry.kinds("driver")
        coordinates = [name.removeprefix("body-") for name in kinds if name.startswith("body-")]
        point = self.point(table["body"], (*path, "body"), alone=True)
        coordinate = table.get("coordinate")
        if coordinate not in coordinates:
            where = (*path, "coordinate") if "coordinate" in table else path
            got = f", got {quoted(coordinate)}" if "coordinate" in table else ""
            self.values.wrong(where, f"expected coordinate = one of {', '.join(coordinates)}{got}")
            return None
        if is_ground(point.body):
            self.values.wrong((*path, "body"), "the ground does not move; expected a body")
        if not point.body or is_ground(point.body):
            return None
        return kinds[f"body-{coordinate}"], "", point, f"{coordinate} of '{table['body']}'"

    def add_load(self, name: str, table: Table) -> None:
        """Read a load of any kind."""
        path = ("loads", name)
        kind = self.choose(table, registry.kinds("load"), path)
        if kind is None:
            return
        self.values.keys(table, ["type", *kind.fields], path)
        a = b = Point("ground", "", (0.0, 0.0))
        before = len(self.values.problems)
        written: list[Value] = []
        points = False
        for key, field in kind.fields.items():
            if field.shape == "connect":
                a, b = self.connect(table, path, alone=True)
                points = True
                written += [*a.at, *b.at]
            elif field.shape in ("point", "body"):
                b = self._place(field, key, table, path)
                points = field.shape == "point"
                written += b.at if points else ()
            elif field.shape in MANY:
                written += self.field(field, key, table, {}, path)
            else:
                with self.values.within(local_names(field, a, b)):
                    written.append(self.field(field, key, table, {}, path))
            if field.turns and len(self.values.problems) == before and not self.broken_joints:
                self._can_turn(a, b, (*path, key))
        slack = self._slack(name, kind.leaf, table)
        if slack is not None:
            written[-1] = slack
        self.loads[name] = Load(name, kind.name, a, b, tuple(written), points, None, slack)

    @staticmethod
    def _slack(name: str, leaf: type[LoadKind], table: Table) -> Node | None:
        """What the kernel takes in place of a flag that lets a load act under a condition only; None if it is not set.

        The flag is the last field.
        """
        one_sided = leaf.record.one_sided if leaf.record is not None else None
        return Name(f"{name}.slack", 0) if one_sided is not None and table.get(one_sided.flag) is True else None

    def _can_turn(self, a: Point, b: Point, path: Path) -> None:
        """Refuse two bodies that cannot turn against each other, and two that nothing holds."""
        held = {end.body for joint in self.joints.values() for end in (joint.a, joint.b)}
        if not is_ground(a.body) and not is_ground(b.body) and not held & {a.body, b.body}:
            self.values.wrong(
                path,
                f"neither '{a.body}' nor '{b.body}' has a joint: they would spin in opposite directions and move"
                " nothing; join them, by a revolute joint for example",
            )
        elif same := same_angle(self.joints.values(), a.body, b.body):
            self.values.wrong(
                path,
                f"{' and '.join(same)} keep{'s' if len(same) == 1 else ''} '{a.body}' and '{b.body}' from turning"
                " against each other: a moment between them moves nothing; connect bodies that turn",
            )

    def _place(self, field: Field, key: str, table: Table, path: Path) -> Point:
        """The point at which a load on one body acts."""
        if key not in table:
            self.values.wrong(path, f"needs {key}: {field.meaning}")
            return NOWHERE
        place = self.point(table[key], (*path, key), alone=field.shape == "body")
        if field.shape == "body" and place.name:
            self.values.wrong((*path, key), f"expected a body, got the point {quoted(table[key])}")
        return place
