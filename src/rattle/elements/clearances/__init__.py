"""Clearances: the contacts of a joint with clearance, one kind per file; and the interface of these kinds.

The parameters of a kernel are, in this order: the points of A and B (x, y each) [m], the clearance [m], the
radius of the bush [m] (0 if it is not needed), the fields of the joint, and its dimensions [m].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from rattle.elements.contact_geometry import ContactGeometry
from rattle.jit import layout as at
from rattle.language.recorded import hypot
from rattle.registry import Field

Fields = Mapping[str, float]
Dimensions = Mapping[str, tuple[float, ...]]


class FreePlay:
    """The displacements e = (e_0, e_1) of B from its position without clearance that a joint allows: here a circle.

    e is in the frame of A [m]; for some kinds e_1 is a rotation [rad], or unused.
    """

    two_tips = False  # True: two kinds of corners of the region of e may be extremes, see `tip`

    def __init__(self, clearance: float) -> None:
        self.clearance = clearance
        self.steps = (clearance, clearance)  # scales of the components of e

    def first_order(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        """Largest y . e [unit of the output] to first order in the clearance, and the e (2,) [m, rad] that reaches it.

        y: (2,) derivative of an output with respect to e.
        """
        size = float(np.hypot(*y))
        return self.clearance * size, (self.clearance / size * y if size > 0.0 else np.zeros(2))

    def tip(self, y: np.ndarray, second: bool | None) -> np.ndarray:
        """The e (2,) [m, rad] with the largest y . e; second: the kind of corner, None for the better one."""
        return self.first_order(y)[1]

    def side(self, e: np.ndarray, y: np.ndarray) -> tuple[float, Callable[[float], np.ndarray]] | None:
        """A curved side of the region on which y . e grows from e: its length [m or rad], and e (2,) along it."""
        return None

    @property
    def unbounded(self) -> str:
        """Why the displacements are not bounded, as a clause about B; "" if they are bounded."""
        return ""


class ClearanceKind(ContactGeometry):
    """Interface of the kinds of clearance; the defaults are those of a pin in a bush."""

    joint: ClassVar[str]  # the kind of joint that has this clearance
    borne, bearer = "pin", "bush"  # names of the parts on B and A
    wall = "a bush"
    orbit: ClassVar[bool] = False  # True: a circle in which the path of the pin is drawn
    dimensions: ClassVar[Mapping[str, Mapping[str, Field]]] = {}  # tables of dimensions of a joint with this clearance

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of the two centres."""
        return hypot(p[0], p[1]), hypot(p[2], p[3])

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The clearance [m]."""
        return p[at.CLEARANCE]

    @staticmethod
    def play_along(fields: Fields, along: np.ndarray) -> np.ndarray:
        """The part (n,) [m] of the displacement `along` (n,) [m] of B's point on the joint's line that is clearance."""
        return 0.0 * along

    @staticmethod
    def displaced(fields: Fields, e: np.ndarray) -> tuple[float, float, Mapping[str, float]]:
        """Shift of A's point in its frame [m] and changes of the joint's fields [SI] that displace B by e (2,)."""
        return float(e[0]), float(e[1]), {}

    @staticmethod
    def free_play(clearance: float, fields: Fields, dimensions: Dimensions) -> FreePlay:
        """The displacements that a clearance [m] allows."""
        return FreePlay(clearance)
