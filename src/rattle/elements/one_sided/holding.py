"""Joints that hold two bodies as a closed contact does: a point on a line, or two points at a distance."""

from __future__ import annotations

import math

from rattle.interfaces.contacts import Held, Pose

ENDLESS = {"length": math.inf, "open": 0.0}  # a slot without ends
Vector = tuple[float, float]


def seen_from(frame: Pose, other: Pose, point: Vector) -> Vector:
    """Where a point of another body is in the frame of a body, about its mass centre [m]."""
    x = other[0] + math.cos(other[2]) * point[0] - math.sin(other[2]) * point[1] - frame[0]
    y = other[1] + math.sin(other[2]) * point[0] + math.cos(other[2]) * point[1] - frame[1]
    c, s = math.cos(frame[2]), math.sin(frame[2])
    return c * x + s * y, c * y - s * x


def along_line(axis: float, away: float, on_a: Vector, on_b: Vector, turned: bool = False) -> Held:
    """A point of B on a line of A, which is so far to the left of a point of A; turned: a point of A on a line of B."""
    line, point = (on_b, on_a) if turned else (on_a, on_b)
    start, fields = (line[0] - away * math.sin(axis), line[1] + away * math.cos(axis)), {"axis": axis, **ENDLESS}
    return Held("slot", fields, point, start, True) if turned else Held("slot", fields, start, point)


def at_distance(length: float, on_a: Vector, on_b: Vector) -> Held:
    """Two points at a distance; where it is none, one point."""
    if length > 0.0:
        return Held("rod", {"length": length}, on_a, on_b)
    return Held("revolute", {}, on_a, on_b)
