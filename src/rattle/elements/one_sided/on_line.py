"""Points, corners and discs of B on a line of A, whose free side is to the left.

u: direction of the line, n' = u turned by 90 degrees; d: from the point of A to a corner of B, or to the centre of its
disc (radius r; 0 of a corner)

g = n' . d - r          the wall is at n = -n' from the centre

See `elements.disc_contact` for the rows.
"""

from __future__ import annotations

from rattle.elements.disc_contact import write_disc
from rattle.elements.one_sided.corner_surface import REACH, ROLLER, SHAPE, CornerSurface, between, between_centres
from rattle.elements.one_sided.holding import Vector, along_line
from rattle.interfaces.contacts import Held
from rattle.interfaces.fields import Fields
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import turn_x, turn_y
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import cos, sin
from rattle.registry import kind

ALONG_X, ALONG_Y = range(SHAPE, SHAPE + 2)
CORNERS = SHAPE + 2


@kernel("clearance")
def on_line(body, a, b, p, k, corner, row, kinematics):
    """Write the row of a corner or disc of B on the line; of corner -1 the gap that none is below."""
    ux, uy = turn_x(body, a, p[k + ALONG_X], p[k + ALONG_Y]), turn_y(body, a, p[k + ALONG_X], p[k + ALONG_Y])
    if corner < 0:
        dx, dy = between_centres(body, a, b, p, k)
        kinematics[row, at.GAP] = ux * dy - uy * dx - p[k + ROLLER] - p[k + REACH]
        return
    sax, say, sbx, sby, dx, dy = between(body, a, b, p, k, k + CORNERS + 2 * corner)
    gap = ux * dy - uy * dx - p[k + ROLLER]
    write_disc(body, a, b, True, sax + dx, say + dy, sbx, sby, uy, -ux, gap, p[k + ROLLER], 0.0, row, kinematics)


@kind("one-sided", "on-line", on_line)
class OnLine(CornerSurface):
    """Points, corners or a disc of B on a line of A.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    walls_turn = True

    @staticmethod
    def suits(fields: Fields) -> bool:
        """A line without ends."""
        return not fields["radius"] and not fields["length"]

    @staticmethod
    def shape(fields: Fields) -> tuple[float | LocalFunction, ...]:
        """Direction of the line."""
        return cos(fields["axis"]), sin(fields["axis"])

    @staticmethod
    def guided(fields: Fields, on_a: Vector, on_b: Vector, place: Vector, rolls: bool) -> tuple[Held, ...]:
        """A corner on the line, or the centre of a disc beside it."""
        return (along_line(fields["axis"], fields["roller"], on_a, on_b, rolls=rolls),)
