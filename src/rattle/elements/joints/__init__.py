"""Ideal joints and drivers: one kind per file, each a few constraint rows; and what the program asks of them.

Nobody asks for the name of a joint or of its fields: a kind says here what others need to know about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, NamedTuple


class Motor(NamedTuple):
    """What moves the coordinate that a joint leaves free."""

    driver: str  # kind of driver
    effort: str  # its force or torque, as a motor in the joint is asked for it
    unit: str


class JointKind:
    """What a kind of joint says about itself; what is left out is that of a pin which both bodies share."""

    rows: ClassVar[tuple[str, ...]]  # unit of every row, m or rad
    rows_in_ground: ClassVar[bool] = False  # rows are along the axes of the ground, not of A
    moment: ClassVar[bool] = False  # a moment passes from body to body
    motor: ClassVar[Motor | None] = None  # None: no coordinate that a driver could move
    massless: ClassVar[str] = ""  # joint that holds the play as a massless link; its one field is the clearance
    drawn_as: ClassVar[str] = ""  # pin | rod | guide | slot | "" (not drawn)

    @staticmethod
    def kept_angle(fields: Mapping[str, float]) -> float | None:
        """Angle of B relative to A [rad] that the joint keeps; None where B may turn."""
        return None

    @staticmethod
    def line(fields: Mapping[str, float]) -> float | None:
        """Direction in A's frame [rad] of the line through A's point on which B's point stays; None: no such line."""
        return None

    @staticmethod
    def travel(fields: Mapping[str, float]) -> float:
        """How far B's point may go along the line to either side of A's point [m]."""
        return float("inf")

    @staticmethod
    def distance(fields: Mapping[str, float]) -> float:
        """Distance of the two points [m] that the joint keeps."""
        return 0.0


class DriverKind:
    """What a kind of driver says about itself."""

    rows: ClassVar[tuple[str, ...]]  # unit of every row, m or rad
    drives: ClassVar[str]  # joint (those whose motor it is) | body
    effort: ClassVar[tuple[str, str]]  # name and unit of what it exerts on B
    sets_angle: ClassVar[bool] = False  # its function is the angle of B relative to A
    along_line: ClassVar[bool] = False  # its parameters begin with the direction of the joint's line
