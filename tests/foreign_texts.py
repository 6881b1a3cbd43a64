"""Files of other programs, written as those programs write them: assemblies, links, mechanisms as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

HEAD = "freeCAD: 3D CAD with Motion Simulation  by  askoh.com"
DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-"


def rotation(axis: Sequence[float], angle: float) -> np.ndarray:
    """Matrix (3, 3) of a turn about an axis, by Rodrigues."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * skew + (1 - math.cos(angle)) * skew @ skew


def about_z(angle: float) -> np.ndarray:
    """Matrix (3, 3) of a turn in the plane."""
    return rotation((0, 0, 1), angle)


class Assembly:
    """Text of an .asmt file: parts, markers and joints are put in, `text` writes it.

    All is given in a drawing plane; `frame` and `shift` put that into space.  Parts have frames of their own.
    """

    def __init__(self, name: str = "Assembly1", frame: Any = None, shift: Sequence[float] = (0, 0, 0)) -> None:
        self.name, self.frame, self.shift = name, np.eye(3) if frame is None else np.asarray(frame, float), shift
        self.ground: dict[str, tuple[Any, ...]] = {}
        self.parts: dict[str, tuple[Any, ...]] = {}
        self.joints: list[tuple[str, str, str, str, Mapping[str, float]]] = []
        self.motions: list[list[str]] = []
        self.gravity: Sequence[float] = (0, -9.81, 0)
        self.sets: list[str] = []
        self.forces: list[str] = []
        self.times = ("0.0", "1.0", "0.01")

    def marker(self, name: str, at: Sequence[float], axes: Any = None, point: Any = None) -> None:
        """A marker of the ground, in the drawing; point: (origin, rotation) of the point in which it stands."""
        self.ground[name] = (at, np.eye(3) if axes is None else axes, point)

    def part(
        self, name: str, at: Sequence[float], turn: Any, mass: float, moments: Sequence[float],
        centre: tuple[Any, Any], markers: Mapping[str, tuple[Any, ...]], rates: Any = ((0, 0, 0), (0, 0, 0)),
    ) -> None:  # fmt: skip
        """A part: frame in the drawing, mass, moments about `centre` (place, axes), markers (place, axes, point)."""
        self.parts[name] = (at, np.asarray(turn, float), mass, moments, centre, markers, rates)

    def joint(self, kind: str, name: str, i: str, j: str, **numbers: float) -> None:
        """A joint between markers "Part1/Marker1", or "Marker1" of the ground."""
        self.joints.append((kind, name, i, j, numbers))

    def turn(self, name: str, joint: str, expression: str) -> None:
        """A motor about a joint."""
        lines = ["MotionJoint", f"\t/{self.name}/{joint}", "RotationZ", f"\t{expression}"]
        self.motions.append(["RotationalMotion", "\tName", f"\t\t{name}", *("\t" + line for line in lines)])

    def text(self) -> str:
        """The whole file."""
        lines = [HEAD, "Assembly", "\tNotes", "\t\t(Text string: '' runs: nil)", "\tName", f"\t\t{self.name}"]
        lines += _frame(1, (0, 0, 0), np.eye(3)) + _rates(1, ((0, 0, 0), (0, 0, 0)))
        space = {
            name: (self.frame @ np.asarray(at, float) + self.shift, self.frame @ axes, point)
            for name, (at, axes, point) in self.ground.items()
        }
        lines += [*_markers(1, space), "\tRefCurves", "\tRefSurfaces", "\tParts"]
        for name, (at, turn, mass, moments, centre, markers, rates) in self.parts.items():
            lines += ["\t\tPart", "\t\t\tName", f"\t\t\t\t{name}"]
            lines += _frame(3, self.frame @ np.asarray(at, float) + self.shift, self.frame @ turn)
            lines += _rates(3, [self.frame @ np.asarray(rate, float) for rate in rates])
            lines += ["\t\t\tFeatureOrder", "\t\t\tPrincipalMassMarker", "\t\t\t\tName", "\t\t\t\t\tMassMarker"]
            lines += _frame(4, *centre)
            lines += ["\t\t\t\tMass", f"\t\t\t\t\t{mass!r}", "\t\t\t\tMomentOfInertias", f"\t\t\t\t\t{_row(moments)}"]
            lines += [
                "\t\t\t\tDensity",
                "\t\t\t\t\t10.0",
                *_markers(3, markers),
                "\t\t\tRefCurves",
                "\t\t\tRefSurfaces",
            ]
        lines += ["\tKinematicIJs", "\tConstraintSets", "\t\tJoints"]
        for kind, name, i, j, numbers in self.joints:
            lines += [f"\t\t\t{kind}", "\t\t\t\tName", f"\t\t\t\t\t{name}"]
            for word, marker in (("MarkerI", i), ("MarkerJ", j)):
                lines += [f"\t\t\t\t{word}", f"\t\t\t\t\t/{self.name}/{marker}"]
            for word, number in numbers.items():
                lines += [f"\t\t\t\t{word}", f"\t\t\t\t\t{number!r} "]
        lines += ["\t\tMotions", *("\t\t\t" + line for motion in self.motions for line in motion)]
        lines += [*self.sets, "\t\tGeneralConstraintSets", "\tForceTorques", *self.forces, "\tConstantGravity"]
        lines += [f"\t\t{_row(self.frame @ np.asarray(self.gravity, float))}", "\tSimulationParameters"]
        run = zip(
            ("tstart", "tend", "hmin", "hmax", "hout"), (*self.times[:2], "1e-9", "1.0", self.times[2]), strict=True
        )
        lines += [line for word, value in run for line in (f"\t\t{word}", f"\t\t\t{value}")]
        return "\n".join(lines) + "\n"


def _row(numbers: Any) -> str:
    return " \t".join(repr(float(number)) for number in numbers) + " "


def _frame(depth: int, at: Any, axes: Any) -> list[str]:
    tabs = "\t" * depth
    rows = [f"{tabs}\t{_row(row)}" for row in np.asarray(axes, float)]
    return [f"{tabs}Position3D", f"{tabs}\t{_row(at)}", f"{tabs}RotationMatrix", *rows]


def _rates(depth: int, rates: Any) -> list[str]:
    tabs = "\t" * depth
    words = zip(("Velocity3D", "Omega3D"), rates, strict=True)
    return [line for word, rate in words for line in (f"{tabs}{word}", f"{tabs}\t{_row(rate)}")]


def _markers(depth: int, markers: Mapping[str, tuple[Any, ...]]) -> list[str]:
    lines, tabs = ["\t" * depth + "RefPoints"], "\t" * (depth + 1)
    for name, (at, axes, point) in markers.items():
        lines += [f"{tabs}RefPoint", *_frame(depth + 2, *(point or ((0, 0, 0), np.eye(3)))), f"{tabs}\tMarkers"]
        lines += [f"{tabs}\t\tMarker", f"{tabs}\t\t\tName", f"{tabs}\t\t\t\t{name}", *_frame(depth + 4, at, axes)]
    return lines


# the four-bar of OndselSolver, testapp/fourbar.asmt (LGPL-2.1), with the forces that its file stores
LENGTHS, MASSES, INERTIAS = (0.8, 1.8, 1.3), (0.2, 0.4, 0.3), (0.017333333333333, 0.13466666666667, 0.05725)
ANGLES = (0.0, 0.80636087982073, -1.6060600451779)
# t: torque of the motor on the ground; forces of joints 1 to 4 on the part of their marker I [N m, N]
STORED = {
    0.0: (12.193233423319, 27.1380307505, 14.2605417791, 23.9797573421, 16.2225417791,
          6.57269950585, 15.973008219, -1.74518375885, 15.7858580489),
    0.25: (-1.439401188672, 1.79925148584, 5.26411009293, 1.79925148584, 4.06783668458,
           1.01356993817, -2.19662980943, 0.42430877742, -2.15756956742),
    0.4: (6.7650801977556, -14.1571772851, -1.14783237292, -11.6020804249, -1.04221890506,
          -2.39349996798, -1.13778540957, 0.680290084352, 1.57511951024),
    0.75: (-4.3314192323015, -5.41427404038, -19.7935013495, -5.41427404038, -14.6732279412,
           -2.52104811939, -2.09092222235, -0.351128678649, 2.60839695423),
}  # fmt: skip


def fourbar(
    frame: Any = None, shift: Sequence[float] = (0, 0, 0), marker: Any = None, base: Any = (0.1, 0.1, 0.1)
) -> Assembly:
    """That four-bar; frame, shift: of the drawing in space; marker: axes of every marker; base: first pins in parts."""
    axes = np.eye(3) if marker is None else marker
    drawing = Assembly(frame=frame, shift=shift)
    drawing.marker("Marker1", (2.0, 0, 0), axes)
    drawing.marker("Marker2", (0, 0, 0), axes)
    at = np.zeros(3)
    for n, (length, mass, inertia, angle) in enumerate(zip(LENGTHS, MASSES, INERTIAS, ANGLES, strict=True), 1):
        turn = about_z(angle)
        first = np.array(base)
        second = first + np.array([length, 0, 0])
        centre = ((first + second) / 2, np.eye(3))
        markers = {"Marker1": (first, axes, None), "Marker2": (second, axes, None)}
        moments = (0.4 * inertia, 0.6 * inertia, inertia)
        drawing.part(f"Part{n}", at - turn @ first, turn, mass, moments, centre, markers)
        at = at + turn @ (length, 0, 0)
    pins = ("Marker2", "Part1/Marker1"), ("Part1/Marker2", "Part2/Marker1"), ("Part2/Marker2", "Part3/Marker1")
    for n, (i, j) in enumerate((*pins, ("Part3/Marker2", "Marker1")), 1):
        drawing.joint("RevoluteJoint", f"Joint{n}", i, j)
    drawing.turn("Motion1", "Joint1", "2.0d*pi*time")
    return drawing


# ---------------------------------------------------------------- PMKS+
def digits(number: int) -> str:
    """A whole number in the digits of a link."""
    text, rest = "", abs(number)
    while rest:
        text, rest = DIGITS[rest % 64] + text, rest // 64
    return ("0" if number < 0 else "") + (text or "0")


def thousandths(number: float) -> str:
    """A decimal of a link."""
    return digits(round(1000 * number))


SLIDER, INPUT, STILL, WELDED = 1, 2, 4, 8  # flags of a joint


def pmks(
    joints: Sequence[tuple[Any, ...]], links: Sequence[tuple[Any, ...]], forces: Sequence[str] = (),
    speed: int = 20, clockwise: bool = False, gravity: bool = False, unit: int = 2,
) -> str:  # fmt: skip
    """A link.

    joints: (id, x, y, flags, angle); links: (id, mass, inertia, (x, y), joints, "R" or "P", root, parts).
    """
    flags = digits(clockwise + 2 * gravity).rjust(2, "0")
    text = f"{flags}.{thousandths(1)}.{digits(speed)},{thousandths(0.01)}.{unit}01."
    for name, x, y, bits, angle in joints:
        text += f"{digits(bits)}{name},{name},{thousandths(x)},{thousandths(y)},{thousandths(angle)}."
    text += "."
    for name, mass, inertia, (x, y), ends, kind, root, parts in links:
        numbers = ",".join(map(thousandths, (mass, inertia, x, y)))
        text += f"{'Y' if root else 'N'}{kind}{name},{name},{numbers},c5cae9,{','.join(ends)},,{','.join(parts)}."
    text += "." + "".join(f"{force}." for force in forces) + ".NA"
    return text + DIGITS[len(text) % 62]


def pmks_fourbar(**more: Any) -> str:
    """A crank-rocker of three links."""
    joints = [("A", -0.12, -0.04, INPUT | STILL, 0), ("B", -0.12, 0.02, 0, 0), ("C", 0.04, 0.1, 0, 0)]
    links = [
        ("AB", 0.1, 0.003, (-0.12, -0.01), "AB", "R", True, ""),
        ("BC", 0.3, 0.012, (-0.04, 0.06), "BC", "R", True, ""),
    ]
    rocker = ("CD", 0.2, 0.005, (0.06, 0.03), "CD", "R", True, "")
    return pmks([*joints, ("D", 0.08, -0.04, STILL, 0)], [*links, rocker], **more)


# ---------------------------------------------------------------- pylinkage
def pylinkage(**more: Any) -> str:
    """A four-bar as JSON, with a tracker of its rod; more: other entries, by their key in the whole."""
    joints = [
        {"id": "O", "type": "ground", "position": [0.0, 0.0]},
        {"id": "A", "type": "revolute", "position": [0.0, 1.0], "name": "pin"},
        {"id": "B", "type": "revolute", "position": [3.0, 2.0]},
        {"id": "D", "type": "ground", "position": [4.0, 0.0]},
        {"id": "T", "type": "tracker", "position": [1.0, 2.0], "ref_joint1_id": "A", "ref_joint2_id": "B",
         "distance": math.sqrt(2), "angle": math.pi / 4 - math.atan2(1, 3)},
    ]  # fmt: skip
    links = [
        {"id": "ground", "type": "ground", "joints": ["O", "D"]},
        {"id": "crank", "type": "driver", "joints": ["O", "A"], "motor_joint": "O",
         "angular_velocity": math.tau / 100, "initial_angle": math.pi / 2},
        {"id": "rod", "type": "link", "joints": ["A", "B"]},
        {"id": "rocker", "type": "link", "joints": ["B", "D"]},
    ]  # fmt: skip
    return json.dumps({"name": "a four-bar", "joints": joints, "links": links, "ground": "ground"} | more)
