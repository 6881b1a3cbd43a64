"""What other rooms need to know of loads: the interface of these kinds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, NamedTuple


class OneSided(NamedTuple):
    """A flag of a load that makes it act under a condition only.

    Where the flag is set, the kernel takes `<load>.slack` in its place, a quantity of the model: 0 where it acts, and 1
    elsewhere.  It is an expression over the same as the force; steps end where it changes.
    """

    flag: str
    slack: str


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
    one_sided: OneSided | None = None


class LoadQuantity(NamedTuple):
    """What results and expressions know of a load besides: an expression over its fields and the state of A and B.

    Names: `A.x` and the like of the bodies, `a.x`, `a.vx` of the points, the fields; of three values `offset.x`,
    `offset.y`, `offset.angle`.
    """

    unit: str
    formula: str


class LoadKind:
    """Interface of the kinds of load."""

    drawn_as: ClassVar[str] = ""  # a form of rattle.drawings.forms; "" if it is not drawn
    record: ClassVar[LoadRecord | None] = None  # what results know of it; None: nothing besides its work
    rests: ClassVar[bool] = False  # True if B is without force at its field `offset` in A, x, y and angle
    quantities: ClassVar[Mapping[str, LoadQuantity]] = {}  # by the key after its name, `<load>.fx`
