"""Stops: the ends of the coordinate of a joint, as contacts besides its rows; and the interface of these kinds.

A kind is named after the driver that moves the same coordinate.  The parameters of a kernel are, in this order: the
points of A and B (x, y each) [m], the least and the largest value of the coordinate [m or rad], the direction of the
joint's line in A [rad].  Contact 0 is at the least value and pushes B on, contact 1 at the largest pushes it back.
"""

from __future__ import annotations

from collections.abc import Sequence

from rattle.elements.contact_geometry import ContactGeometry
from rattle.jit import layout as at
from rattle.language.recorded import hypot

LEAST, LARGEST, LINE = at.POINTS, at.POINTS + 1, at.POINTS + 2  # places of the parameters after the points


class StopKind(ContactGeometry):
    """Interface of the kinds of stop; fields `min` and `max` are its ends."""

    contacts = 2
    wall = "a stop"
    rounded = False
    slides = False
    has_radius = False
    column = at.STOP

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of the two points."""
        return hypot(p[0], p[1]), hypot(p[2], p[3])

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The range between the ends, but no more than the size."""
        return min(size, p[LARGEST] - p[LEAST])

    @staticmethod
    def sense(corner: int) -> int:
        """The force on B is positive at the least value, negative at the largest."""
        return 1 if corner == 0 else -1
