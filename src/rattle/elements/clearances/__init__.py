"""Clearance models, what a joint with play becomes: one kind per file; and what the program asks of them.

The parameters of a kernel are, one after the other: the points of A and B (x, y each) [m], the clearance [m], the
radius of the bush [m] (0 where it is not asked for), the fields of the joint, and its dimensions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from rattle.registry import Field

Fields = Mapping[str, float]
Dimensions = Mapping[str, tuple[float, ...]]


class FreePlay:
    """The displacements e = (e_0, e_1) of B from its place without play that a joint leaves free; a circle.

    In the frame of A [m]; where a kind says so e_1 is a turn [rad], or nothing.
    """

    two_tips = False  # two kinds of places are candidates for an extreme; `tip` is asked for either

    def __init__(self, clearance: float) -> None:
        self.clearance = clearance
        self.steps = (clearance, clearance)  # what each part of e is measured by

    def first_order(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        """Largest y . e to first order in the clearance, and the e (2,) where it is reached."""
        size = float(np.hypot(*y))
        return self.clearance * size, (self.clearance / size * y if size > 0.0 else np.zeros(2))

    def tip(self, y: np.ndarray, second: bool | None) -> np.ndarray:
        """The e (2,) of largest y . e; second: at a tip of the second kind or of the first, None: at whichever."""
        return self.first_order(y)[1]

    def side(self, e: np.ndarray, y: np.ndarray) -> tuple[float, Callable[[float], np.ndarray]] | None:
        """A curved side on which y . e grows from the place e: its length, and the place (2,) at a way along it."""
        return None

    @property
    def unbounded(self) -> str:
        """Why nothing bounds the play, as a sentence about B; "" where it is bounded."""
        return ""


class ClearanceKind:
    """What a kind of play says about itself; what is left out is that of a pin in a bush."""

    joint: ClassVar[str]  # kind of joint whose play it is
    borne, bearer = "pin", "bush"  # what B and A are called
    contacts: ClassVar[int] = 1  # places that may touch: what the kernel calls `corner` counts them
    walls_turn: ClassVar[bool] = False  # straight walls, which turn with A
    rounded: ClassVar[bool] = True  # a wall is curved: the normal turns as B goes round, its speed is in touch[ACROSS]
    has_radius: ClassVar[bool] = True  # contacts may say the radius of the bush, and forces depend on it
    from_materials: ClassVar[bool] = False  # stiffness follows from materials: the formulas are for a pin in a bush
    orbit: ClassVar[bool] = False  # the play is a circle in which the way of the pin is drawn
    dimensions: ClassVar[Mapping[str, Mapping[str, Field]]] = {}  # tables of a joint with such play

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Longest arms [m] from the mass centres of A and B to what bounds the gap (centres of circles, corners)."""
        return math.hypot(p[0], p[1]), math.hypot(p[2], p[3])

    @staticmethod
    def play_along(fields: Fields, along: np.ndarray) -> np.ndarray:
        """The part of the way of B's point along the joint's line that is play, not motion [m], (n,) of (n,)."""
        return 0.0 * along

    @staticmethod
    def displaced(fields: Fields, e: np.ndarray) -> tuple[float, float, Mapping[str, float]]:
        """Shift of A's point in its frame [m] and changes of the joint's fields that displace B by e (2,)."""
        return float(e[0]), float(e[1]), {}

    @staticmethod
    def free_play(clearance: float, fields: Fields, dimensions: Dimensions) -> FreePlay:
        """What the play leaves free."""
        return FreePlay(clearance)
