"""Joints of an assembly as joints of the plane.

I and J stand for the markers, p and q for the bodies that have them; alpha is the angle of a marker's x axis in its
body, s = +1 where the z axis of I is n, -1 where it is -n.

    revolute, cylindrical   I and J at one place
    translational           J on the line through I along its z axis, the axes of both markers along each other
    fixed                   the same place, the axes along each other
    gear                    the wheels of radii r_I, r_J about I and J; radii of opposite sign: one inside of the other
    rack and pinion         x of J in I + R s (phi_q - phi_p) = constant: I on the rack, its x axis along it

Axes along each other may point either way: which, and by how many right angles, is read from the position drawn.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from rattle.exchange.asmt.assembly import Joint, Marker
from rattle.exchange.asmt.plane import Flat
from rattle.exchange.asmt.space import column, dot

Bodies = Callable[[int], Flat]
Label = Callable[[Marker], str]
Shift = Callable[[Marker, tuple[float, float]], str]
Entry = dict[str, Any]
TOUCH = 1e-6  # of the distance of two axes: pitch radii that fit better are taken as they are


def sense(flat: Flat, marker: Marker) -> float:
    """1 where the z axis of a marker is n, -1 where it is -n."""
    return math.copysign(1.0, dot(flat.axes[2], column(marker.frame.axes, 2)))


def joint_entry(joint: Joint, flat: Bodies, label: Label, slides: bool, shift: Shift) -> tuple[list[str], Entry]:
    """The table of a joint, and what is to be told of it."""
    connect = [label(joint.i), label(joint.j)]
    a, b = flat(joint.i.part), flat(joint.j.part)
    if joint.kind == "GearJoint":
        return _gear(joint, a, b, connect)
    if joint.kind == "RackPinionJoint":
        return _rack(joint, a, b, connect, shift)
    if joint.kind == "FixedJoint":
        return [], {"type": "fixed", "connect": connect, "angle": _kept_angle(joint, a, b)}
    if slides:
        axis = a.direction(column(joint.i.frame.axes, 2))
        entry = {"type": "prismatic", "connect": connect, "axis": axis, "angle": _kept_angle(joint, a, b)}
        cylindrical = f"{joint.name} slides along its axis, and does not turn about it"
        return [cylindrical] if joint.kind == "CylindricalJoint" else [], entry
    sliding = f"{joint.name} turns about its axis, and does not slide along it"
    return [sliding] if joint.kind == "CylindricalJoint" else [], {"type": "revolute", "connect": connect}


def _kept_angle(joint: Joint, a: Flat, b: Flat) -> float:
    """The angle of B relative to A that a joint keeps [rad]: that at which axes of both markers are along each other.

    The axis of a cylindrical or translational joint is its z axis; of a fixed one, the one that lies in the plane best.
    """
    axes = (2,) if joint.kind != "FixedJoint" else (0, 1, 2)
    k = max(axes, key=lambda axis: _in_plane(a, joint.i, axis) * _in_plane(b, joint.j, axis))
    drawn = b.angle - a.angle
    kept = a.direction(column(joint.i.frame.axes, k)) - b.direction(column(joint.j.frame.axes, k))
    return kept + math.pi * round((drawn - kept) / math.pi) + 0.0


def _in_plane(flat: Flat, marker: Marker, k: int) -> float:
    return 1.0 - abs(dot(flat.axes[2], column(marker.frame.axes, k)))


def _gear(joint: Joint, a: Flat, b: Flat, connect: list[str]) -> tuple[list[str], Entry]:
    """Two wheels; only the ratio of their radii counts in the file, here their sum is the distance of the axes."""
    ra, rb = joint.numbers
    pa, pb = (flat.in_plane(flat.place(marker.frame.origin)) for flat, marker in ((a, joint.i), (b, joint.j)))
    distance, internal = math.dist(pa, pb), ra * rb < 0.0
    if internal and abs(ra) < abs(rb):  # the ring comes first
        ra, rb, connect = rb, ra, connect[::-1]
    big, small = abs(ra), abs(rb)
    fits = big - small if internal else big + small
    told = []
    if fits > 0.0 and distance > 0.0 and abs(fits - distance) > TOUCH * distance:
        big, small = big * distance / fits, small * distance / fits
        told.append(f"{joint.name}: pitch radii in their ratio, with the sum that the distance of the axes needs")
    entry: Entry = {"type": "gear", "connect": connect, "radii": [big, small]}
    return told, entry | ({"internal": True} if internal else {})


def _rack(joint: Joint, a: Flat, b: Flat, connect: list[str], shift: Shift) -> tuple[list[str], Entry]:
    """The pitch line lies beside the pinion, where it is drawn: the file says its direction only."""
    (radius,) = joint.numbers
    radius *= sense(a, joint.i)
    axis = a.direction(column(joint.i.frame.axes, 0)) + (math.pi if radius > 0.0 else 0.0)
    radius = abs(radius)
    u = (math.cos(axis + a.angle), math.sin(axis + a.angle))
    pa, pb = (flat.in_plane(flat.place(marker.frame.origin)) for flat, marker in ((a, joint.i), (b, joint.j)))
    right = u[1] * (pb[0] - pa[0]) - u[0] * (pb[1] - pa[1])  # of the pinion's centre, seen along u [m]
    if abs(right - radius) > TOUCH * radius:
        n = (math.sin(axis), -math.cos(axis))
        connect = [shift(joint.i, ((right - radius) * n[0], (right - radius) * n[1])), connect[1]]
    return [], {"type": "rack", "connect": connect, "axis": axis, "radius": radius}
