"""Joints that hold two bodies as a closed contact does: a point beside a line, two points at a distance, one point.

Of a disc that rolls: a wheel, or two points at a distance with pitch circles.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rattle.interfaces.contacts import Held, Pose

ENDLESS = {"length": math.inf, "open": 0.0}  # a slot without ends
Vector = tuple[float, float]


def seen_from(frame: Pose, other: Pose, point: Vector) -> Vector:
    """Where a point of another body is in the frame of a body, about its mass centre [m]."""
    x = other[0] + math.cos(other[2]) * point[0] - math.sin(other[2]) * point[1] - frame[0]
    y = other[1] + math.sin(other[2]) * point[0] + math.cos(other[2]) * point[1] - frame[1]
    c, s = math.cos(frame[2]), math.sin(frame[2])
    return c * x + s * y, c * y - s * x


def along_line(
    axis: float, away: float, on_a: Vector, on_b: Vector, *, turned: bool = False, rolls: bool = False
) -> Held:
    """A point of B so far to the left of a line of A; turned: a point of A to the left of a line of B.

    rolls: it is the centre of a disc that rolls on the line.
    """
    line, point = (on_b, on_a) if turned else (on_a, on_b)
    if rolls:
        return _held("wheel", {"axis": axis, "radius": away}, line, point, turned)
    start = (line[0] - away * math.sin(axis), line[1] + away * math.cos(axis))
    return _held("slot", {"axis": axis, **ENDLESS}, start, point, turned)


def _held(kind: str, fields: Mapping[str, float], first: Vector, second: Vector, turned: bool) -> Held:
    return Held(kind, fields, second, first, True) if turned else Held(kind, fields, first, second)


def around_disc(radius: float, roller: float, on_a: Vector, on_b: Vector, rolls: bool) -> tuple[Held, ...]:
    """Two points at the distance radius + roller; roller: radius of a disc of B, negative if it is in a hollow.

    rolls: the disc rolls.
    """
    length = radius + roller
    placed = Held("rod", {"length": length}, on_a, on_b) if length > 0.0 else Held("revolute", {}, on_a, on_b)
    if not rolls:
        return (placed,)
    radii: Any = (radius, abs(roller))  # a pair stands where other fields are numbers
    inside = 1.0 if roller < 0.0 else 0.0
    fields = {"radii": radii, "internal": inside, "pressure_angle": 0.0, "backlash": 0.0}
    return placed, Held("gear", fields, on_a, on_b)


def pinned(a: Pose, b: Pose, on_b: Vector) -> Held:
    """A point of B that stays where it is on A."""
    return Held("revolute", {}, seen_from(a, b, on_b), on_b)
