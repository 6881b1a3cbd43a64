"""What other rooms need to know of loads: the interface of these kinds."""

from __future__ import annotations

from typing import ClassVar, NamedTuple


class LoadRecord(NamedTuple):
    """What results and expressions know of a load between two points or bodies, besides its coordinate and the rate.

    coordinate: "length" between the points, or "angle" of B relative to A.  force: its force or moment as an expression
    over its fields, the coordinate and `rate`.  power: 1 if it does positive work where the coordinate grows with a
    positive force, -1 where it does so with a negative one.
    """

    coordinate: str
    unit: str  # of the force: N or N*m
    force: str
    power: float


class LoadKind:
    """Interface of the kinds of load."""

    drawn_as: ClassVar[str] = ""  # a form of rattle.drawings.forms; "" if it is not drawn
    record: ClassVar[LoadRecord | None] = None  # what results know of it; None: nothing besides its work
