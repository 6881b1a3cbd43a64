"""Contacts of clutches: couples between two bodies, at velocity level or from tooth to tooth; and their interface.

The parameters of a kernel are, in this order: the points of A and B (x, y each) [m], which are not used, the sense (1
or -1), and what the kind adds.
"""

from __future__ import annotations

from collections.abc import Sequence

from rattle.elements.contact_geometry import ContactGeometry
from rattle.jit import layout as at

SENSE = at.POINTS  # place of the sense among the parameters


class ClutchKind(ContactGeometry):
    """Interface of the contacts of clutches."""

    wall = "a clutch"
    angular = True
    rounded = False
    slides = False
    has_radius = False
    column = at.EFFORT

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """No points touch."""
        return 0.0, 0.0

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The size: 1 rad."""
        return size
