"""A link of PMKS+ as a mechanism: bodies in the axes of the drawing, so that every angle is 0 at the start."""

from __future__ import annotations

from pathlib import PurePath
from typing import Any, NamedTuple

from rattle.exchange.imported import Assumptions, Imported
from rattle.exchange.names import Names, counted, listed
from rattle.exchange.pmks.link import (
    CLOCKWISE,
    GRAVITY,
    GROUNDED,
    INPUT,
    PRISMATIC,
    WELDED,
    Link,
    Piece,
    Place,
    link_text,
    read_link,
)

EARTH = 9.81  # [m/s^2]
GROUND = -1  # index of the ground among the bodies


def read_pmks(text: str, name: str, assumptions: Assumptions) -> Imported:
    """Read a file with a link of PMKS+; name: of the file, for messages.  Raises ModelError."""
    return _Writer(read_link(link_text(text, name), name), name).write()


class _Mass(NamedTuple):
    mass: float  # [kg]
    inertia: float  # [kg m^2]
    x: float  # [m]
    y: float


class _Writer:
    """The tables of the model."""

    def __init__(self, link: Link, file: str) -> None:
        self.link = link
        self.file = file
        self.names = Names()
        self.places = {joint.id: joint for joint in link.joints}
        self.groups = self._bodies()
        self.bodies = [self.names.new("_".join(piece.name for piece in group), "link") for group in self.groups]
        self.points: list[dict[str, list[float]]] = [{} for _ in self.groups]
        self.labels: dict[tuple[int, str], str] = {}
        self.joints: dict[str, dict[str, Any]] = {}
        self.drivers: dict[str, dict[str, Any]] = {}
        self.ground: dict[str, list[float]] = {}
        self.ground_names = Names()
        self.left_out = [f"force {force}" for force in link.forces]
        self.welded: list[str] = []

    def write(self) -> Imported:
        """The whole mechanism."""
        for n, group in enumerate(self.groups):
            own = Names()
            for place in (self.places[key] for key in dict.fromkeys(key for piece in group for key in piece.joints)):
                label = own.new(place.name, "point")
                self.points[n][label] = self._at(place)
                self.labels[n, place.id] = f"{self.bodies[n]}.{label}"
        for joint in self.link.joints:
            self._join(joint)
        down = [0.0, -EARTH] if self.link.flags >> GRAVITY & 1 else [0.0, 0.0]
        document: dict[str, Any] = {"format": 1, "gravity": down}
        if self.ground:
            document["ground"] = {"points": self.ground}
        document["bodies"] = {body: self._body(n) for n, body in enumerate(self.bodies)}
        if self.joints:
            document["joints"] = self.joints
        if self.drivers:
            document["drivers"] = self.drivers
        document["initial"] = {body: self._start(n, document) for n, body in enumerate(self.bodies)}
        return Imported(
            document,
            f"from {PurePath(self.file).name}, a link of PMKS+",
            self._taken(),
            self._assumed(),
            tuple(self.left_out),
        )

    # ------------------------------------------------------------ bodies
    def _bodies(self) -> list[list[Piece]]:
        """Links that are one body: each by itself, or all that meet at welded joints."""
        roots = [piece for piece in self.link.pieces if piece.root]
        group = {piece.id: [piece] for piece in roots}
        for joint in self.link.joints:
            if joint.has(WELDED):
                whole: list[Piece] = []
                for piece in roots:
                    if joint.id in piece.joints and not any(piece is other for other in whole):
                        whole += [other for other in group[piece.id] if other not in whole]
                for piece in whole:
                    group[piece.id] = whole
        return list({id(pieces): pieces for pieces in group.values()}.values())

    def _at(self, joint: Place) -> list[float]:
        _, over, under = self.link.unit
        return [joint.x.times(over, under), joint.y.times(over, under)]

    def _mass(self, piece: Piece) -> list[_Mass]:
        """Mass of a link: its own, or that of its parts where it has none."""
        _, over, under = self.link.unit
        if piece.piston:
            turning = [joint for joint in piece.joints if not self.places[joint].has(PRISMATIC)]
            x, y = self._at(self.places[(turning or list(piece.joints))[0]])
            return [_Mass(piece.mass.times(1, 1), piece.inertia.times(1, 1), x, y)]
        parts = [part for part in self.link.pieces if part.id in piece.parts and not part.root]
        if parts and piece.mass.thousandths == 0:
            return [mass for part in parts for mass in self._mass(part._replace(parts=()))]
        x, y = (number.times(over, under) for number in piece.center)
        return [_Mass(piece.mass.times(1, 1), piece.inertia.times(1, 1), x, y)]

    def _whole(self, n: int) -> _Mass:
        """Mass of a body, by parallel axes."""
        masses = [mass for piece in self.groups[n] for mass in self._mass(piece)]
        if len(masses) == 1:
            return masses[0]
        total = sum(part.mass for part in masses)
        weights = [part.mass / total if total > 0.0 else 1.0 / len(masses) for part in masses]
        x = sum(weight * part.x for weight, part in zip(weights, masses, strict=True))
        y = sum(weight * part.y for weight, part in zip(weights, masses, strict=True))
        inertia = sum(part.inertia + part.mass * ((part.x - x) ** 2 + (part.y - y) ** 2) for part in masses)
        return _Mass(total, inertia, x, y)

    def _body(self, n: int) -> dict[str, Any]:
        mass = self._whole(n)
        return {"points": self.points[n], "center": [mass.x, mass.y], "mass": mass.mass, "inertia": mass.inertia}

    def _start(self, n: int, document: dict[str, Any]) -> dict[str, float]:
        """Angle 0; the place too, of what slides and is not held by pins."""
        x, y = document["bodies"][self.bodies[n]]["center"]
        slides = any(self.places[joint].has(PRISMATIC) for piece in self.groups[n] for joint in piece.joints)
        return {"x": x, "y": y, "angle": 0.0} if slides else {"angle": 0.0}

    # ------------------------------------------------------------ joints
    def _join(self, joint: Place) -> None:
        """What holds the bodies together that meet at a joint."""
        here = [n for n, group in enumerate(self.groups) if any(joint.id in piece.joints for piece in group)]
        if not here:
            self.left_out.append(f"joint {joint.name}, which belongs to no link")
        elif joint.has(PRISMATIC):
            self._slide(joint, here)
        elif joint.has(GROUNDED):
            kind = {"type": "fixed"} if joint.has(WELDED) else {"type": "revolute"}
            for n in here:
                self._enter(joint, kind, GROUND, n)
            self._drive(joint, "angle", len(here))
        else:
            for n in here[1:]:
                self._enter(joint, {"type": "revolute"}, here[0], n)
            self._drive(joint, "angle", len(here) - 1)
            if joint.has(WELDED):
                self.welded.append(joint.name)

    def _slide(self, joint: Place, here: list[int]) -> None:
        """A body slides on a line of the ground, or of another link."""
        guides = [n for n in here if not any(piece.piston for piece in self.groups[n])]
        guide = GROUND if joint.has(GROUNDED) or not guides or len(here) == 1 else guides[0]
        sliding = [n for n in here if n != guide]
        entry = {"type": "prismatic", "axis": joint.angle.times(1, 1), "angle": 0.0}
        for n in sliding:
            self._enter(joint, entry, guide, n)
        self._drive(joint, "position", len(sliding))

    def _enter(self, joint: Place, entry: dict[str, Any], a: int, b: int) -> None:
        if a == GROUND and (GROUND, joint.id) not in self.labels:
            label = self.ground_names.new(joint.name, "point")
            self.ground[label] = self._at(joint)
            self.labels[GROUND, joint.id] = f"ground.{label}"
        connect = [self.labels[a, joint.id], self.labels[b, joint.id]]
        rest = {key: value for key, value in entry.items() if key != "type"}
        self.joints[self.names.new(joint.name, "joint")] = {"type": entry["type"], "connect": connect, **rest}

    def _drive(self, joint: Place, coordinate: str, joints: int) -> None:
        """The motor of an input, on the first of the joints that were entered there."""
        if not joint.has(INPUT):
            return
        if joints == 0 or list(self.joints.values())[-joints]["type"] == "fixed":
            self.left_out.append(f"the input at {joint.name}, where nothing moves")
            return
        driven = list(self.joints)[-joints]
        speed = -self.link.speed if self.link.flags >> CLOCKWISE & 1 else self.link.speed
        _, over, under = self.link.unit
        text = f"{speed} rpm*t" if coordinate == "angle" else f"{speed * over / under!r} m/s*t"
        self.drivers[self.names.new("motor", "motor")] = {"joint": driven, coordinate: text}

    # ------------------------------------------------------------ words
    def _taken(self) -> tuple[str, ...]:
        link = self.link
        roots = [piece.name for piece in link.pieces if piece.root]
        taken = [f"{counted(len(roots), 'link')}: {listed(roots)}"]
        taken.append(f"{counted(len(link.joints), 'joint')}: {listed(joint.name for joint in link.joints)}")
        inputs = [joint.name for joint in link.joints if joint.has(INPUT)]
        if self.drivers:
            sense = "clockwise" if link.flags >> CLOCKWISE & 1 else "counter-clockwise"
            taken.append(f"input at {listed(inputs)}, {link.speed} rpm {sense}")
        if self.welded:
            taken.append(f"welded, one body: {listed(self.welded)}")
        if self.names.changed:
            taken.append(f"renamed: {listed(f'{old} is {new}' for old, new in self.names.changed)}")
        return tuple(taken)

    def _assumed(self) -> tuple[str, ...]:
        assumed = [f"lengths are in {self.link.unit[0]}, masses in kg, moments of inertia in kg m^2"]
        if any(piece.piston for piece in self.link.pieces):
            assumed.append("the mass of a piston is at its pin")
        if any("position" in driver for driver in self.drivers.values()):
            assumed.append(f"the speed of a driven slider is in {self.link.unit[0]}/s")
        return tuple(assumed)
