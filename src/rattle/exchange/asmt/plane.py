"""The plane in which an assembly moves, and its parts as bodies of that plane.

n is the z axis of the first revolute marker.  The assembly moves in a plane if every axis about which a joint turns is
parallel to n, and every axis along which one slides is normal to it, whatever their signs.  The axes of the plane are
x and y of the assembly where n is its z axis (or -z), else y is up, against gravity, or x as near as can be to that of
the assembly.  A marker at r_M in a point at r_ref of a part at r_P is at r_P + R_P (r_ref + R_ref r_M).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from rattle.exchange.asmt.assembly import Assembly, Joint, Marker
from rattle.exchange.asmt.space import (
    Frame,
    Vector,
    across,
    column,
    cross,
    dot,
    length,
    plus,
    times,
    turned,
    turned_back,
)
from rattle.exchange.refusal import refused

PARALLEL = 1e-6  # of 1: the part of an axis that may point elsewhere; files have 12 digits or more
ROUNDING = 1e-15  # of the size of an assembly: lengths that are left where two are equal
EXACT = 1e-12  # of 1: an axis that is one of the part's within rounding is taken to be it
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
TURNS = ("RevoluteJoint", "GearJoint", "RackPinionJoint", "CylindricalJoint")  # in this order they say what n is


class Plane(NamedTuple):
    """Its axes in the assembly; n, the third, looks at the one who draws."""

    x: Vector
    y: Vector
    n: Vector
    grain: float  # lengths below are those of rounding [m]


class Flat(NamedTuple):
    """A part as a body of the plane."""

    origin: tuple[float, float]  # of the part, in the plane [m]
    height: float  # of the part's origin along n [m]
    angle: float  # of the body's x axis [rad]
    axes: tuple[Vector, Vector, Vector]  # of the body, in the part; the third is n
    grain: float  # [m]

    def place(self, inner: Vector) -> tuple[float, float]:
        """A point of the part, in the axes of the body [m]."""
        x, y = dot(self.axes[0], inner), dot(self.axes[1], inner)
        return x if abs(x) > self.grain else 0.0, y if abs(y) > self.grain else 0.0

    def direction(self, inner: Vector) -> float:
        """Angle of a direction in the axes of the body [rad]."""
        return math.atan2(dot(self.axes[1], inner), dot(self.axes[0], inner))

    def in_plane(self, place: tuple[float, float]) -> tuple[float, float]:
        """A point of the body, in the plane [m]."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        x, y = self.origin[0] + c * place[0] - s * place[1], self.origin[1] + s * place[0] + c * place[1]
        return x if abs(x) > self.grain else 0.0, y if abs(y) > self.grain else 0.0


def axis(assembly: Assembly, marker: Marker) -> Vector:
    """The z axis of a marker, in the assembly."""
    return turned(assembly.frame_of(marker.part).axes, column(marker.frame.axes, 2))


def slides(joint: Joint, assembly: Assembly, plane: Plane) -> bool:
    """True of a joint that slides along a line of the plane; a cylindrical one with its axis there cannot turn."""
    if joint.kind == "CylindricalJoint":
        return abs(dot(axis(assembly, joint.i), plane.n)) < 0.5
    return joint.kind == "TranslationalJoint"


def plane_of(assembly: Assembly) -> Plane:
    """The plane of an assembly.  Raises ModelError, with the name of the joint, if it does not move in one."""
    n = _normal(assembly)
    upright = abs(abs(n[2]) - 1.0) < PARALLEL
    x, y, n = (X, Y, Z) if upright else _turned_axes(n, assembly.gravity)
    plane = Plane(x, y, n, _grain(assembly))
    for joint in assembly.joints:
        for word, marker in (("MarkerI", joint.i), ("MarkerJ", joint.j)):
            z = axis(assembly, marker)
            off = abs(dot(z, plane.n)) if slides(joint, assembly, plane) else length(cross(z, plane.n))
            if joint.kind != "FixedJoint" and off > PARALLEL:
                way = "slides along an axis that is not in" if slides(joint, assembly, plane) else "is not normal to"
                message = (
                    f"joint {joint.name}: {word} ({marker.name} of {assembly.name_of(marker.part)}) {way} the plane"
                    f" of the others, by {off:.2g} of 1: the mechanism is not planar"
                )
                raise refused(assembly.file, message, joint.line)
    return plane


def _normal(assembly: Assembly) -> Vector:
    for kind in TURNS[:3]:
        for joint in assembly.joints:
            if joint.kind == kind:
                return _unit(axis(assembly, joint.j if kind == "RackPinionJoint" else joint.i))
    along = [_unit(axis(assembly, joint.i)) for joint in assembly.joints if joint.kind == "TranslationalJoint"]
    turning = [_unit(axis(assembly, joint.i)) for joint in assembly.joints if joint.kind == "CylindricalJoint"]
    for other in along[1:]:
        n = cross(along[0], other)
        if length(n) > PARALLEL:
            return _unit(n)
    if turning and not any(abs(dot(turning[0], line)) > PARALLEL for line in along):
        return turning[0]
    for n in (Z, Y, X):
        if not any(abs(dot(n, line)) > PARALLEL for line in along):
            return n
    return across(along[0], Z)


def _unit(a: Vector) -> Vector:
    return times(1.0 / length(a), a)


def _grain(assembly: Assembly) -> float:
    origins = [marker.frame.origin for marker in assembly.markers]
    origins += [origin for part in assembly.parts for origin in (part.frame.origin, part.centre.origin)]
    return ROUNDING * max(abs(number) for origin in origins for number in origin)


def _turned_axes(n: Vector, gravity: Vector) -> tuple[Vector, Vector, Vector]:
    """Axes of a plane with the normal n: y against gravity, or x near to that of the assembly."""
    pull = plus(gravity, times(-dot(gravity, n), n))
    if length(pull) > PARALLEL * length(gravity) > 0.0:
        y = across(n, times(-1.0, _unit(pull)))
        return _snapped(cross(y, n)), _snapped(y), _snapped(n)
    x = across(n, X if abs(n[0]) < 0.9 else Y)
    return _snapped(x), _snapped(cross(n, x)), _snapped(n)


def _snapped(a: Vector) -> Vector:
    """The vector, or the axis that it is within rounding."""
    for axis_ in (X, Y, Z):
        for sign in (1.0, -1.0):
            if length(plus(a, times(-sign, axis_))) < EXACT:
                return times(sign, axis_)
    return a


def flat(frame: Frame, plane: Plane) -> Flat:
    """A part as a body: its axes are those of the part, as far as they lie in the plane."""
    n = _snapped(_unit(turned_back(frame.axes, plane.n)))
    first = max((X, Y, Z), key=lambda a: round(length(cross(a, n)), 6))
    x = _snapped(across(n, first))
    y = _snapped(cross(n, x))
    seen = turned(frame.axes, x)
    angle = math.atan2(dot(seen, plane.y), dot(seen, plane.x))
    origin = frame.origin
    return Flat((dot(origin, plane.x), dot(origin, plane.y)), dot(origin, plane.n), angle, (x, y, n), plane.grain)


def ground(frame: Frame, plane: Plane) -> Flat:
    """The assembly as the ground: its axes are those of the plane."""
    x, y, n = (_snapped(turned_back(frame.axes, axis_)) for axis_ in (plane.x, plane.y, plane.n))
    origin = frame.origin
    return Flat((dot(origin, plane.x), dot(origin, plane.y)), dot(origin, plane.n), 0.0, (x, y, n), plane.grain)


def moment_of_inertia(axes: tuple[Vector, Vector, Vector], moments: Vector, centre: Frame) -> float:
    """n . (R diag(J) R^T) n about the mass centre [kg m^2]; axes: of the body in its part, centre: of its moments."""
    n = turned_back(centre.axes, axes[2])
    return sum(moment * part * part for moment, part in zip(moments, n, strict=True))
