"""A mechanism of pylinkage as records, checked: every reference leads somewhere, every place is a number."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rattle.description import file as model_file
from rattle.errors import ModelError, suggest
from rattle.exchange.refusal import LARGEST, in_one_line, quoted, refused

JOINTS = ("ground", "revolute", "prismatic", "tracker")
LINKS = ("ground", "driver", "arc_driver", "link")
OLDER = ("Static", "Crank", "Revolute", "Fixed", "Prismatic", "Pivot", "Linear")  # kinds of its older files
TURN = math.tau / 360  # [rad] per step, of a driver that does not say
HALF_TURN = 3.14159  # [rad] at which an arc ends that does not say: the program's own number
MOST = 2000  # joints, links
MOST_ENDS = 5000  # joints of all links together
Spot = tuple[float, float]


class Joint(NamedTuple):
    """A place where links meet, or one that is tracked."""

    id: str
    name: str
    kind: str
    at: Spot | None  # None: of a tracker, which follows from its references
    axis: Spot = (1.0, 0.0)  # of a slider
    through: Spot = (0.0, 0.0)  # a point of its line
    references: tuple[str, str] | None = None  # of a tracker
    polar: Spot = (0.0, 0.0)  # of a tracker: distance from the first, angle from the line to the second [rad]


class Arc(NamedTuple):
    """The limits between which a driver turns to and fro [rad]."""

    start: float
    end: float


class Bar(NamedTuple):
    """A link."""

    id: str
    name: str
    kind: str
    joints: tuple[str, ...]
    motor: str = ""  # joint about which it is turned
    rate: float = 0.0  # [rad] per step
    initial: float | None = None  # angle of a driver at the start [rad]
    arc: Arc | None = None


class Linkage(NamedTuple):
    """The whole file; joints by their ids."""

    name: str
    joints: dict[str, Joint]
    links: tuple[Bar, ...]
    grounded: frozenset[str]  # ids of joints that stand still


def read_mechanism(text: str, file: str) -> Linkage:
    """Read a file.  Raises ModelError with the place in it."""
    if not model_file.is_json(text):
        raise refused(file, "not a mechanism of pylinkage: expected JSON that begins with a brace", 1)
    try:
        document = model_file.parse(text, file)
    except ModelError as error:
        raise in_one_line(error, file) from None
    return _Reader(document, file).read()


Path = tuple[str | int, ...]


class _Reader:
    def __init__(self, document: Mapping[str, object], file: str) -> None:
        self.document = document
        self.file = file

    def read(self) -> Linkage:
        """Joints first, then the links between them."""
        joints = {}
        for n, entry in enumerate(self.entries("joints")):
            joint = self.joint(entry, ("joints", n))
            if joint.id in joints:
                raise self.refused(("joints", n, "id"), f"two joints have the id {quoted(joint.id)}")
            joints[joint.id] = joint
        links: dict[str, Bar] = {}
        ends = 0
        for n, entry in enumerate(self.entries("links")):
            link = self.link(entry, ("links", n), joints)
            if link.id in links:
                raise self.refused(("links", n, "id"), f"two links have the id {quoted(link.id)}")
            links[link.id] = link
            ends += len(link.joints)
            if ends > MOST_ENDS:
                raise self.refused(("links", n), f"more than {MOST_ENDS} joints in all links together")
        self.require_known(joints, links.values())
        still = {joint.id for joint in joints.values() if joint.kind == "ground"}
        still |= {joint for link in links.values() if link.kind == "ground" for joint in link.joints}
        still |= {link.motor for link in links.values() if link.motor}
        still |= {joint.id for joint in joints.values() if joint.kind == "tracker" and joint.references is None}
        name = self.document.get("name")
        return Linkage(name if isinstance(name, str) else "", joints, tuple(links.values()), frozenset(still))

    def refused(self, path: Path, message: str) -> ModelError:
        """The error to raise about a place."""
        return refused(self.file, message, path=path)

    def require_known(self, joints: Mapping[str, Joint], links: Iterable[Bar]) -> None:
        """Refuse references of trackers and of the whole that lead nowhere."""
        for n, joint in enumerate(joints.values()):
            for key, other in zip(("ref_joint1_id", "ref_joint2_id"), joint.references or (), strict=False):
                if other not in joints:
                    raise self.refused(("joints", n, key), f"there is no joint {quoted(other)}{suggest(other, joints)}")
        ground = self.document.get("ground")
        grounds = [link.id for link in links if link.kind == "ground"]
        if ground is not None and ground not in grounds:
            raise self.refused(
                ("ground",), f"there is no ground link {quoted(str(ground))}{suggest(str(ground), grounds)}"
            )

    # ------------------------------------------------------------ values
    def entries(self, key: str) -> list[Mapping[str, object]]:
        """A list of tables."""
        entries = self.document.get(key)
        if not isinstance(entries, list) or not entries:
            fault = (
                "missing: this is no mechanism of pylinkage" if entries is None else "expected a list that is not empty"
            )
            raise self.refused((key,), fault)
        if len(entries) > MOST:
            raise self.refused((key,), f"{len(entries)} entries; at most {MOST} are read")
        tables = []
        for n, entry in enumerate(entries):
            if not isinstance(entry, Mapping):
                raise self.refused((key, n), "expected a table")
            tables.append(entry)
        return tables

    def text(self, entry: Mapping[str, object], key: str, path: Path) -> str:
        """A text that is needed."""
        value = entry.get(key)
        if not isinstance(value, str) or not value:
            raise self.refused((*path, key), "expected a text that is not empty")
        return value

    def kind(self, entry: Mapping[str, object], kinds: Sequence[str], default: str, path: Path) -> str:
        """One of these kinds."""
        kind = entry.get("type", default)
        if kind in OLDER:
            raise self.refused(
                (*path, "type"), f"{quoted(str(kind))} is of an older file; save it with pylinkage 0.8 or newer"
            )
        if kind not in kinds:
            fault = f"the kind {quoted(str(kind))} is not taken{suggest(str(kind), kinds)}"
            raise self.refused((*path, "type"), fault)
        return str(kind)

    def number(self, value: object, path: Path) -> float:
        """A finite number."""
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST:
            raise self.refused(path, f"expected a number, got {quoted(str(value)[:100])}")
        return float(value)

    def pair(self, value: object, path: Path) -> Spot:
        """Two numbers."""
        if not isinstance(value, list) or len(value) != 2:
            raise self.refused(path, f"expected [x, y], got {quoted(str(value)[:100])}")
        return self.number(value[0], (*path, 0)), self.number(value[1], (*path, 1))

    # ------------------------------------------------------------ joints and links
    def joint(self, entry: Mapping[str, object], path: Path) -> Joint:
        """A joint."""
        own = self.text(entry, "id", path)
        name, kind = entry.get("name"), self.kind(entry, JOINTS, "revolute", path)
        at = entry.get("position")
        nowhere = at is None or (isinstance(at, list) and at == [None, None])
        spot = None if nowhere else self.pair(at, (*path, "position"))
        joint = Joint(own, name if isinstance(name, str) and name else own, kind, spot)
        if kind == "tracker":
            first, second = (entry.get(key) or "" for key in ("ref_joint1_id", "ref_joint2_id"))
            polar = tuple(self.number(entry.get(key, 0.0), (*path, key)) for key in ("distance", "angle"))
            if first and second:
                return joint._replace(references=(str(first), str(second)), polar=(polar[0], polar[1]))
        elif kind == "prismatic":
            x, y = self.pair(entry.get("axis", [1.0, 0.0]), (*path, "axis"))
            axis = (x, y) if math.hypot(x, y) > 0.0 else (1.0, 0.0)
            joint = joint._replace(
                axis=axis, through=self.pair(entry.get("line_point", [0.0, 0.0]), (*path, "line_point"))
            )
        if spot is None:
            raise self.refused(
                (*path, "position"), f"joint {joint.name} has no place; build the mechanism and save it again"
            )
        return joint

    def link(self, entry: Mapping[str, object], path: Path, joints: Mapping[str, Joint]) -> Bar:
        """A link; its joints are there."""
        own = self.text(entry, "id", path)
        name, kind = entry.get("name"), self.kind(entry, LINKS, "link", path)
        listed = entry.get("joints", [])
        if not isinstance(listed, list):
            raise self.refused((*path, "joints"), "expected a list of joints")
        for n, joint in enumerate(listed):
            if not isinstance(joint, str) or joint not in joints:
                hint = suggest(str(joint)[:100], joints)
                raise self.refused((*path, "joints", n), f"there is no joint {quoted(str(joint)[:100])}{hint}")
        link = Bar(own, name if isinstance(name, str) and name else own, kind, tuple(dict.fromkeys(listed)))
        return self.driver(link, entry, path, joints) if kind in ("driver", "arc_driver") else link

    def driver(self, link: Bar, entry: Mapping[str, object], path: Path, joints: Mapping[str, Joint]) -> Bar:
        """A link that a motor turns about one of its joints."""
        motor = entry.get("motor_joint")
        if motor is None:
            still = [joint for joint in link.joints if joints[joint].kind == "ground"]
            motor = still[0] if len(still) == 1 else None
        if not isinstance(motor, str) or motor not in joints:
            there = "" if motor is None else f": there is no joint {quoted(str(motor)[:100])}"
            raise self.refused((*path, "motor_joint"), f"link {link.name} needs the joint of its motor{there}")
        if motor not in link.joints:
            raise self.refused((*path, "motor_joint"), f"{quoted(motor)} is not a joint of link {link.name}")
        rate = self.number(entry.get("angular_velocity", TURN), (*path, "angular_velocity"))
        initial = entry.get("initial_angle")
        angle = None if initial is None else self.number(initial, (*path, "initial_angle"))
        arc = None
        if link.kind == "arc_driver":
            start, end = (
                self.number(entry.get(key, default), (*path, key))
                for key, default in (("arc_start", 0.0), ("arc_end", HALF_TURN))
            )
            arc, angle = Arc(start, end), start if angle is None else angle
            if not start < end or not start <= angle <= end:
                fault = f"link {link.name}: expected arc_start < arc_end, and initial_angle between them"
                raise self.refused((*path, "arc_end"), fault)
        return link._replace(motor=motor, rate=rate, initial=angle, arc=arc)
