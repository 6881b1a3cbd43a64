"""A mechanism of pylinkage as a model: a link with two joints is a bar, one with more a body as it is drawn.

Where k links meet there are k - 1 pins; a slider is a pin in a slot of the ground; a tracker is a point of the link
that holds both of its references.  The file has no units, masses and times: a unit is 1 m, bars weigh 1 kg/m, a step
lasts 1/25 s, as its animations do, unless something else is stated.
"""

from __future__ import annotations

import math
from pathlib import PurePath
from typing import Any

from rattle.exchange.imported import Assumptions, Imported
from rattle.exchange.names import Names, counted, listed
from rattle.exchange.pylinkage.records import Bar, Joint, Linkage, Spot, read_mechanism
from rattle.exchange.refusal import refused

LINEAR_DENSITY = 1.0  # of bars [kg/m]
STEPS = 25.0  # in a second
SAME = 1e-6  # [rad] by which a driver may be drawn elsewhere than it starts
GROUND = -1  # index of the ground among the bodies


def read_pylinkage(text: str, name: str, assumptions: Assumptions) -> Imported:
    """Read the text of a JSON file; name: of the file, for messages.  Raises ModelError."""
    return _Writer(read_mechanism(text, name), name, assumptions).write()


class _Writer:
    """The tables of the model."""

    def __init__(self, mechanism: Linkage, file: str, stated: Assumptions) -> None:
        self.mechanism = mechanism
        self.file = file
        self.unit = stated.scale or 1.0
        self.steps = stated.steps_per_second or STEPS
        self.stated = stated
        self.names = Names()
        self.left_out: list[str] = []
        self.told: list[str] = []
        self.links = [link for link in mechanism.links if self._moves(link)]
        if not self.links:
            raise refused(file, "no link moves: there is no mechanism in it", path=("links",))
        self.bodies = [self.names.new(link.name, "link") for link in self.links]
        self.spots: list[dict[str, Spot]] = [self._spots(link) for link in self.links]  # of joints in each body [m]
        self.at = {joint.id: self._scaled(joint.at) for joint in mechanism.joints.values() if joint.at is not None}
        self.ground = {
            joint: self.at[joint] for joint in mechanism.joints if joint in mechanism.grounded & self.at.keys()
        }
        self.holders: dict[str, list[int]] = {}  # of joints: their bodies
        for n, spots in ((GROUND, self.ground), *enumerate(self.spots)):
            for joint in spots:
                self.holders.setdefault(joint, []).append(n)
        self._track()
        self.ground_points: dict[str, list[float]] = {}
        self.ground_names = Names()
        self.labels: dict[tuple[int, str], str] = {}
        self.joints: dict[str, dict[str, Any]] = {}
        self.pins: dict[tuple[int, str], str] = {}  # of a body in the ground: its joint
        self.drivers: dict[str, dict[str, Any]] = {}

    def write(self) -> Imported:
        """The whole mechanism."""
        points = [self._points(n) for n in range(len(self.links))]
        for joint in self.mechanism.joints.values():
            self._join(joint)
        for n, link in enumerate(self.links):
            if link.motor:
                self._drive(n, link)
        document: dict[str, Any] = {"format": 1}
        if self.mechanism.name:
            document["name"] = " ".join(self.mechanism.name.split())
        if self.ground_points:
            document["ground"] = {"points": self.ground_points}
        document["bodies"] = {body: self._body(n, points[n]) for n, body in enumerate(self.bodies)}
        if self.joints:
            document["joints"] = self.joints
        if self.drivers:
            document["drivers"] = self.drivers
        document["initial"] = {body: self._start(n) for n, body in enumerate(self.bodies)}
        return Imported(
            document,
            f"from {PurePath(self.file).name}, a mechanism of pylinkage",
            self._taken(),
            self._assumed(),
            tuple(self.left_out),
        )

    # ------------------------------------------------------------ bodies
    def _moves(self, link: Bar) -> bool:
        """True of a link that is a body of its own; what is none is told."""
        if link.kind == "ground":
            return False
        if len(link.joints) < 2:
            self.left_out.append(f"link {link.name}, which has fewer than two joints")
            return False
        if all(joint in self.mechanism.grounded for joint in link.joints):
            self.left_out.append(f"link {link.name}, which stands still in the ground")
            return False
        return True

    def _scaled(self, at: Spot) -> Spot:
        return self.unit * at[0], self.unit * at[1]

    def _drawn(self, joint: str) -> Spot:
        """Where a joint is drawn [m]."""
        at = self.mechanism.joints[joint].at
        if at is None:
            raise refused(self.file, f"joint {joint}: a link is held by it, and it has no place", path=("joints",))
        return self._scaled(at)

    def _ends(self, link: Bar) -> tuple[str, str]:
        """The joints of a bar, that of its motor first."""
        first, second = link.joints
        return (second, first) if link.motor == second else (first, second)

    def _length(self, link: Bar) -> float:
        first, second = self._ends(link)
        length = math.dist(self._drawn(first), self._drawn(second))
        if not length > 0.0:
            fault = f"link {link.name}: both of its joints are at one place"
            raise refused(self.file, fault, path=("links",))
        return length

    def _spots(self, link: Bar) -> dict[str, Spot]:
        """Its joints in the axes of the body [m]: from the middle along a bar, else as drawn."""
        if len(link.joints) == 2:
            first, second = self._ends(link)
            half = self._length(link) / 2.0
            return {first: (-half, 0.0), second: (half, 0.0)}
        return {joint: self._drawn(joint) for joint in link.joints}

    def _track(self) -> None:
        """Give every tracker its place in the body that holds both of its references, those of trackers too."""
        waiting = [joint for joint in self.mechanism.joints.values() if joint.references is not None]
        while waiting:
            later = [joint for joint in waiting if not self._place(joint)]
            if len(later) == len(waiting):
                self.left_out += [f"tracker {joint.name}: no link holds both of its references" for joint in later]
                return
            waiting = later

    def _place(self, joint: Joint) -> bool:
        first, second = joint.references or ("", "")
        both = [n for n in self.holders.get(first, ()) if n in self.holders.get(second, ())]
        if not both:
            return False
        n = max(both)  # a link before the ground
        spots = self.ground if n == GROUND else self.spots[n]
        (x, y), (x2, y2) = spots[first], spots[second]
        angle = math.atan2(y2 - y, x2 - x) + joint.polar[1]
        distance = self.unit * joint.polar[0]
        if joint.id not in spots:
            spots[joint.id] = (x + distance * math.cos(angle), y + distance * math.sin(angle))
            self.holders.setdefault(joint.id, []).append(n)
        return True

    def _points(self, n: int) -> dict[str, list[float]]:
        """Names of the points of a body, with their places."""
        own, points = Names(), {}
        for joint, at in self.spots[n].items():
            label = own.new(self.mechanism.joints[joint].name, "point")
            points[label] = list(at)
            self.labels[n, joint] = f"{self.bodies[n]}.{label}"
        return points

    def _body(self, n: int, points: dict[str, list[float]]) -> dict[str, Any]:
        link = self.links[n]
        if len(link.joints) == 2:
            ends = [self.labels[n, joint].partition(".")[2] for joint in self._ends(link)]
            length = self._length(link)
            more = {label: at for label, at in points.items() if label not in ends}
            return {
                "bar": ends,
                "length": length,
                **({"points": more} if more else {}),
                "mass": LINEAR_DENSITY * length,
            }
        mass, inertia, center = _outline([self._drawn(joint) for joint in link.joints])
        return {"points": points, "center": list(center), "mass": mass, "inertia": inertia}

    def _start(self, n: int) -> dict[str, float]:
        link = self.links[n]
        if len(link.joints) != 2:
            return {"angle": 0.0}
        if link.initial is not None:
            return {"angle": link.initial}
        return {"angle": self._direction(link)}

    def _direction(self, link: Bar) -> float:
        (x, y), (x2, y2) = (self._drawn(joint) for joint in self._ends(link))
        return math.atan2(y2 - y, x2 - x)

    # ------------------------------------------------------------ joints and motors
    def _join(self, joint: Joint) -> None:
        """What holds the links together that meet at a joint."""
        here = sorted(n for n in self.holders.get(joint.id, ()) if n != GROUND)
        still = joint.id in self.ground
        if joint.kind == "prismatic" and not still:
            if here:
                label = self._ground_point(f"{joint.name}_line", self._scaled(joint.through))
                axis = math.atan2(joint.axis[1], joint.axis[0])
                entry = {"type": "slot", "connect": [label, self.labels[here[0], joint.id]], "axis": axis}
                self.joints[self.names.new(joint.name, "joint")] = entry
        elif still and (here or joint.kind != "tracker"):
            label = self._ground_point(joint.name, self.ground[joint.id])
            for n in here:
                self._pin(joint, label, n)
            return
        for n in here[1:]:
            self._pin(joint, self.labels[here[0], joint.id], n)

    def _ground_point(self, name: str, at: Spot) -> str:
        label = self.ground_names.new(name, "point")
        self.ground_points[label] = list(at)
        return f"ground.{label}"

    def _pin(self, joint: Joint, first: str, n: int) -> None:
        name = self.names.new(joint.name, "joint")
        self.pins[n, joint.id] = name
        self.joints[name] = {"type": "revolute", "connect": [first, self.labels[n, joint.id]]}

    def _drive(self, n: int, link: Bar) -> None:
        """The motor of a driver, whose angle begins as the file says."""
        if (n, link.motor) not in self.pins:
            raise refused(self.file, f"link {link.name}: the joint of its motor has no place", path=("links",))
        rate = link.rate * self.steps
        drawn = self._direction(link) if len(link.joints) == 2 else 0.0
        begin = drawn if link.initial is None or len(link.joints) != 2 else link.initial
        if abs(math.remainder(begin - drawn, math.tau)) > SAME:
            self.told.append(
                f"{link.name} begins at its initial_angle, {begin:.6g} rad; it is drawn at {drawn:.6g} rad"
            )
        text = _to_and_fro(link, begin, rate) if link.arc is not None else _turning(begin, rate)
        self.drivers[self.names.new("motor", "motor")] = {"joint": self.pins[n, link.motor], "angle": text}

    # ------------------------------------------------------------ words
    def _taken(self) -> tuple[str, ...]:
        mechanism = self.mechanism
        taken = [f"{counted(len(self.links), 'link')}: {listed(link.name for link in self.links)}"]
        joints = [joint for joint in mechanism.joints.values() if joint.kind != "tracker"]
        taken.append(f"{counted(len(joints), 'joint')}: {listed(joint.name for joint in joints)}")
        trackers = [joint.name for joint in mechanism.joints.values() if joint.kind == "tracker"]
        if trackers:
            taken.append(f"{counted(len(trackers), 'tracker')}, as points: {listed(trackers)}")
        if self.drivers:
            driven = [link.name for link in self.links if link.motor]
            taken.append(f"{counted(len(self.drivers), 'motor')}: {listed(driven)}")
        taken += self.told
        if self.names.changed:
            taken.append(f"renamed: {listed(f'{old} is {new}' for old, new in self.names.changed)}")
        return tuple(taken)

    def _assumed(self) -> tuple[str, ...]:
        unit = f"a unit is {self.unit:.9g} m" + ("" if self.stated.scale else " (--scale says otherwise)")
        other = "" if self.stated.steps_per_second else " (--steps-per-second says otherwise)"
        return (
            unit,
            f"masses: links weigh {LINEAR_DENSITY:g} kg/m along the lines between their joints; no gravity",
            f"speed: {self.steps:.9g} steps a second{other}",
        )


def _turning(begin: float, rate: float) -> str:
    return f"{begin!r} {'-' if rate < 0.0 else '+'} {abs(rate)!r} rad/s*t"


def _to_and_fro(link: Bar, begin: float, rate: float) -> str:
    """An angle that turns back at the ends of its arc; the expression has no bend at the start.

    With x = begin - start + rate t and the width w of the arc, start + w - |mod(x, 2 w) - w|, or as well
    start + |mod(x + w, 2 w) - w|.
    """
    arc = link.arc
    if arc is None:
        return _turning(begin, rate)
    width = arc.end - arc.start
    first = begin - arc.start
    near = first < width / 2.0
    x = _turning(first if near else first + width, rate)
    back = f"abs(mod({x}, {2.0 * width!r}) - {width!r})"
    return f"{arc.end!r} - {back}" if near else f"{arc.start!r} + {back}"


def _outline(corners: list[Spot]) -> tuple[float, float, Spot]:
    """Mass [kg], inertia [kg m^2] and mass centre [m] of bars from corner to corner, and back to the first."""
    bars = [(p, q, math.dist(p, q)) for p, q in zip(corners, [*corners[1:], corners[0]], strict=True)]
    total = sum(length for _, _, length in bars)
    if total == 0.0:
        return 0.0, 0.0, corners[0]
    x = sum(length * (p[0] + q[0]) / 2.0 for p, q, length in bars) / total
    y = sum(length * (p[1] + q[1]) / 2.0 for p, q, length in bars) / total
    inertia = 0.0
    for p, q, length in bars:
        away = math.dist(((p[0] + q[0]) / 2.0, (p[1] + q[1]) / 2.0), (x, y))
        inertia += LINEAR_DENSITY * length * (length * length / 12.0 + away * away)
    return LINEAR_DENSITY * total, inertia, (x, y)
