"""An assembly as a mechanism of the plane: parts are bodies, markers their points, marker I is side A of a joint."""

from __future__ import annotations

import math
from pathlib import PurePath
from typing import Any

from rattle.exchange.asmt.assembly import GROUND, Assembly, Joint, Marker, Part, read_assembly
from rattle.exchange.asmt.joints import joint_entry
from rattle.exchange.asmt.motions import driver_entry
from rattle.exchange.asmt.plane import Flat, Plane, flat, ground, moment_of_inertia, plane_of, slides
from rattle.exchange.asmt.space import Vector, cross, dot, length, plus, turned
from rattle.exchange.imported import Assumptions, Imported
from rattle.exchange.names import Names, counted, listed

WORDS = {  # kinds of joints
    "RevoluteJoint": "revolute", "CylindricalJoint": "cylindrical", "TranslationalJoint": "translational",
    "FixedJoint": "fixed", "GearJoint": "gear", "RackPinionJoint": "rack-and-pinion",
}  # fmt: skip
STILL = 1e-12  # [m/s, rad/s]: rates below are those of rounding
LEVEL = 1e-9  # of the size of the assembly: heights that differ by less are the same


def read_asmt(text: str, name: str, assumptions: Assumptions) -> Imported:
    """Read the text of an .asmt file; name: of the file, for messages.

    Raises ModelError with file, line and name for what cannot be read, and for mechanisms that are not planar.
    """
    unit = assumptions.scale or 1.0
    assembly = read_assembly(text, name, unit)
    return _Writer(assembly, plane_of(assembly)).write(unit)


class _Writer:
    """The tables of the model."""

    def __init__(self, assembly: Assembly, plane: Plane) -> None:
        self.assembly = assembly
        self.plane = plane
        self.flats = [flat(part.frame, plane) for part in assembly.parts]
        self.ground = ground(assembly.frame, plane)
        self.names = Names()
        self.bodies = [self.names.new(part.name, "body") for part in assembly.parts]
        self.points: dict[int, dict[str, list[float]]] = {n: {} for n in range(GROUND, len(assembly.parts))}
        self.labels: dict[int, str] = {}  # of markers by their identity: "body.point"
        self.left_out = list(assembly.left_out)
        self.told: list[str] = []
        self._name_points()

    def write(self, unit: float) -> Imported:
        """The whole mechanism."""
        assembly = self.assembly
        document: dict[str, Any] = {"format": 1, "name": " ".join(assembly.name.split())}
        document["gravity"] = self._gravity()
        if self.points[GROUND]:
            document["ground"] = {"points": self.points[GROUND]}
        document["bodies"] = {
            body: self._body(part, n) for n, (body, part) in enumerate(zip(self.bodies, assembly.parts, strict=True))
        }
        joints = [self.names.new(joint.name, "joint") for joint in assembly.joints]
        entries = {name: self._joint(joint) for name, joint in zip(joints, assembly.joints, strict=True)}
        if entries:
            document["joints"] = entries
        drivers = {}
        for motion in assembly.motions:
            entry = driver_entry(assembly, self.plane, motion, joints, self.flat, self.bodies)
            if entry is None:
                self.left_out.append(f"{motion.kind} {motion.name}, which holds nothing")
            else:
                drivers[self.names.new(motion.name, "driver")] = entry
        if drivers:
            document["drivers"] = drivers
        document["initial"] = {
            body: self._start(part, n, bool(drivers) and not _is_free(assembly, len(drivers)))
            for n, (body, part) in enumerate(zip(self.bodies, assembly.parts, strict=True))
        }
        if (run := self._run()) is not None:
            document["simulate"] = run
        source = f"from {PurePath(assembly.file).name}, an assembly of Ondsel or FreeCAD"
        left_out = tuple(self.left_out + self._heights())
        return Imported(document, source, self._taken(entries, drivers), self._assumed(unit), left_out)

    def flat(self, part: int) -> Flat:
        """A part, or the ground, in the plane."""
        return self.ground if part == GROUND else self.flats[part]

    # ------------------------------------------------------------ bodies
    def _name_points(self) -> None:
        own = {n: Names() for n in self.points}
        for marker in self.assembly.markers:
            label = own[marker.part].new(marker.name, "point")
            body = "ground" if marker.part == GROUND else self.bodies[marker.part]
            place = self.flat(marker.part).place(marker.frame.origin)
            if marker.part == GROUND:
                place = self.ground.in_plane(place)
            self.points[marker.part][label] = list(place)
            self.labels[id(marker)] = f"{body}.{label}"

    def _body(self, part: Part, n: int) -> dict[str, Any]:
        here = self.flats[n]
        return {
            "points": self.points[n],
            "center": list(here.place(part.centre.origin)),
            "mass": part.mass,
            "inertia": moment_of_inertia(here.axes, part.inertia, part.centre),
        }

    def _start(self, part: Part, n: int, driven: bool) -> dict[str, float]:
        """Place and rates of the mass centre; rates only where motors do not say what all of them are."""
        here = self.flats[n]
        x, y = here.in_plane(here.place(part.centre.origin))
        start = {"x": x, "y": y, "angle": here.angle}
        omega = dot(part.omega, self.plane.n)
        arm = turned(part.frame.axes, part.centre.origin)
        velocity = plus(part.velocity, cross(part.omega, arm))
        rates = {"vx": dot(velocity, self.plane.x), "vy": dot(velocity, self.plane.y), "omega": omega}
        if not driven and max(map(abs, rates.values())) > STILL:
            start |= rates
        if not driven and _leaves(part.omega, velocity, self.plane):
            self.left_out.append(f"the rates of {part.name} that lead out of the plane")
        return start

    def _joint(self, joint: Joint) -> dict[str, Any]:
        told, entry = joint_entry(joint, self.flat, self._label, slides(joint, self.assembly, self.plane), self._shift)
        self.told += told
        return entry

    def _label(self, marker: Marker) -> str:
        return self.labels[id(marker)]

    def _shift(self, marker: Marker, by: tuple[float, float]) -> str:
        """A new point of the part that has the marker, beside it."""
        place = self.flat(marker.part).place(marker.frame.origin)
        moved = (place[0] + by[0], place[1] + by[1])
        points, n = self.points[marker.part], 2
        body, _, label = self.labels[id(marker)].partition(".")
        while f"{label}_{n}" in points:
            n += 1
        points[f"{label}_{n}"] = list(self.ground.in_plane(moved) if marker.part == GROUND else moved)
        return f"{body}.{label}_{n}"

    # ------------------------------------------------------------ the rest
    def _gravity(self) -> list[float]:
        pull, plane = self.assembly.gravity, self.plane
        along = dot(pull, plane.n)
        if abs(along) > LEVEL * length(pull):
            self.left_out.append(f"the part of gravity along the axes, {along:.6g} m/s^2")
        return [dot(pull, plane.x) + 0.0, dot(pull, plane.y) + 0.0]

    def _run(self) -> dict[str, float] | None:
        begin, end, output = self.assembly.times
        if not end > begin:
            return None
        return {"t_end": end - begin} | ({"output": output} if 0.0 < output <= end - begin else {})

    def _heights(self) -> list[str]:
        """What is told of offsets along n, which forces in the plane do not need."""
        heights = [
            here.height + dot(here.axes[2], part.centre.origin)
            for here, part in zip(self.flats, self.assembly.parts, strict=True)
        ]
        low, high = min(heights), max(heights)
        if high - low <= LEVEL * max(1.0, abs(low), abs(high)):
            return []
        return [f"offsets of the parts along the axes, from {low:.6g} to {high:.6g} m"]

    def _taken(self, joints: dict[str, Any], drivers: dict[str, Any]) -> tuple[str, ...]:
        assembly = self.assembly
        taken = [f"{counted(len(self.bodies), 'body')}: {listed(part.name for part in assembly.parts)}"]
        for kind in dict.fromkeys(joint.kind for joint in assembly.joints):
            those = [joint.name for joint in assembly.joints if joint.kind == kind]
            taken.append(f"{counted(len(those), f'{WORDS[kind]} joint')}: {listed(those)}")
        if drivers:
            moved = [motion.name for motion in assembly.motions if motion.kind != "AllowRotation"]
            taken.append(f"{counted(len(drivers), 'motion')}: {listed(moved)}")
        taken += self.told
        light = [part.name for part in assembly.parts if part.mass == 0.0]
        if light:
            taken.append(f"no mass in the file: {listed(light)}; forces need one")
        if self.names.changed:
            taken.append(f"renamed: {listed(f'{old} is {new}' for old, new in self.names.changed)}")
        return tuple(taken)

    def _assumed(self, unit: float) -> tuple[str, ...]:
        length_ = f"a length of 1 in the file is {unit:.9g} m" + (" (--scale says otherwise)" if unit == 1.0 else "")
        return (f"{length_}, a mass of 1 is 1 kg",)


def _is_free(assembly: Assembly, drivers: int) -> bool:
    """True if the motors leave freedoms, by the number of equations: rates of the file then say how it starts."""
    equations = {"FixedJoint": 3, "GearJoint": 1, "RackPinionJoint": 1}
    return 3 * len(assembly.parts) > drivers + sum(equations.get(joint.kind, 2) for joint in assembly.joints)


def _leaves(omega: Vector, velocity: Vector, plane: Plane) -> bool:
    """True of rates that lead out of the plane."""
    size = max(length(omega), length(velocity), STILL)
    out = max(abs(dot(velocity, plane.n)), math.hypot(dot(omega, plane.x), dot(omega, plane.y)))
    return out > 1e-6 * size
