"""Points, corners and discs of B on a disc of A, outside of it or in its hollow.

d: from the point of A to a corner of B, or to the centre of its disc (radius r, 0 of a corner); e = d/|d|; R: radius of
the disc of A

    outside         g = |d| - R - r         the wall is at n = -e from the centre,  bent = -1/|d|
    hollow          g = R - r - |d|         n = +e,  bent = +1/|d|

See `elements.disc_contact` for the rows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.elements.disc_contact import write_disc
from rattle.elements.one_sided.corner_surface import REACH, ROLLER, SHAPE, CornerSurface, between, between_centres
from rattle.elements.one_sided.holding import Vector, around_disc
from rattle.interfaces.contacts import Held
from rattle.interfaces.fields import Fields
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import COINCIDENT
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import least
from rattle.registry import kind

RADIUS = SHAPE
CORNERS = SHAPE + 1


@compiled
def write_round(body, a, b, p, k, corner, side, row, kinematics):
    """Write the row of a corner or disc that is outside (side 1) or in the hollow (-1) of a disc of A."""
    sax, say, sbx, sby, dx, dy = between(body, a, b, p, k, k + CORNERS + 2 * corner)
    far, roller = math.sqrt(dx * dx + dy * dy), p[k + ROLLER]
    bent = -side / max(far, COINCIDENT)
    nx, ny = select(far > COINCIDENT, bent * dx, -side), select(far > COINCIDENT, bent * dy, 0.0)
    gap = side * (far - p[k + RADIUS]) - roller
    return write_disc(body, a, b, True, sax + dx, say + dy, sbx, sby, nx, ny, gap, roller, bent, row, kinematics)


@kernel("clearance")
def on_disc(body, a, b, p, k, corner, row, kinematics):
    """Write the row of a corner or disc outside of a disc of A; of corner -1 the gap that none is below."""
    if corner < 0:
        dx, dy = between_centres(body, a, b, p, k)
        kinematics[row, at.GAP] = math.sqrt(dx * dx + dy * dy) - p[k + RADIUS] - p[k + ROLLER] - p[k + REACH]
        return
    write_round(body, a, b, p, k, corner, 1.0, row, kinematics)


@kernel("clearance")
def in_hollow(body, a, b, p, k, corner, row, kinematics):
    """Write the row of a corner or disc in a hollow of A; of corner -1 the gap that none is below."""
    if corner < 0:
        dx, dy = between_centres(body, a, b, p, k)
        kinematics[row, at.GAP] = p[k + RADIUS] - p[k + ROLLER] - p[k + REACH] - math.sqrt(dx * dx + dy * dy)
        return
    kinematics[row, at.ACROSS] = write_round(body, a, b, p, k, corner, -1.0, row, kinematics)


@kind("one-sided", "on-disc", on_disc)
class OnDisc(CornerSurface):
    """Points, corners or a disc of B outside of a disc of A.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    @staticmethod
    def suits(fields: Fields) -> bool:
        """A disc, but not against the edges of a plate."""
        return fields["radius"] > 0.0 and not fields["hollow"] and not fields["outline"]

    @staticmethod
    def shape(fields: Fields) -> tuple[float | LocalFunction, ...]:
        """Radius of the disc of A."""
        return (fields["radius"],)

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """1/(R + r) [1/m]: how fast the direction from A to B turns where they touch."""
        return 0.0, 0.0, 1.0 / (fields["radius"] + fields["roller"])

    @staticmethod
    def guided(fields: Fields, on_a: Vector, on_b: Vector, place: Vector, rolls: bool) -> tuple[Held, ...]:
        """Two centres, or a centre and a corner, at the distance of touching."""
        return around_disc(fields["radius"], fields["roller"], on_a, on_b, rolls)


@kind("one-sided", "in-hollow", in_hollow)
class InHollow(OnDisc):
    """Points, corners or a disc of B in the hollow of a disc of A.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    rounded = True

    @staticmethod
    def suits(fields: Fields) -> bool:
        """A hollow disc."""
        return fields["radius"] > 0.0 and bool(fields["hollow"])

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """What B may move in it [m], but no more than the size."""
        return least(size, p[RADIUS] - p[ROLLER])

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """Nothing: its gap bends as that of a pin in a bush."""
        return 0.0, 0.0, 0.0

    @staticmethod
    def guided(fields: Fields, on_a: Vector, on_b: Vector, place: Vector, rolls: bool) -> tuple[Held, ...]:
        """The same in a hollow."""
        return around_disc(fields["radius"], -fields["roller"], on_a, on_b, rolls)
