"""Points, corners and discs of B on a line of A, whose free side is to the left.

u: direction of the line, n' = u turned by 90 degrees; d: from the point of A to a corner of B, or to the centre of its
disc (radius r; 0 of a corner)

g = n' . d - r          the wall is at n = -n' from the centre

See `elements.disc_contact` for the rows.
"""

from __future__ import annotations

from collections.abc import Sequence

from rattle.elements.disc_contact import write_disc
from rattle.elements.one_sided.holding import along_line, pinned
from rattle.interfaces.contacts import Corners, Held, OneSidedKind, Pose
from rattle.interfaces.fields import Fields
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import turn_x, turn_y
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import cos, hypot, largest, sin
from rattle.registry import kind

ALONG_X, ALONG_Y, ROLLER, REACH = range(at.POINTS, at.POINTS + 4)
CORNERS = at.POINTS + 4  # x and y of every corner [m], from the mass centre of B


def reach_of(corners: Corners) -> float:
    """Largest distance of a corner from the mass centre of B [m]."""
    return largest(*(hypot(x, y) for x, y in corners.values()))


def flat(corners: Corners) -> list[float]:
    """x and y of all corners [m]."""
    return [number for corner in corners.values() for number in corner]


@compiled
def between(body, a, b, p, k, corner):
    """Arms of the point p[k: k + 2] of A and of the corner p[corner: corner + 2] of B, and d [m], x and y each."""
    sax, say = turn_x(body, a, p[k], p[k + 1]), turn_y(body, a, p[k], p[k + 1])
    sbx, sby = turn_x(body, b, p[corner], p[corner + 1]), turn_y(body, b, p[corner], p[corner + 1])
    return sax, say, sbx, sby, body[b, at.X] + sbx - body[a, at.X] - sax, body[b, at.Y] + sby - body[a, at.Y] - say


@compiled
def between_centres(body, a, b, p, k):
    """From the point p[k: k + 2] of A to the mass centre of B [m], x and y."""
    x = body[b, at.X] - body[a, at.X] - turn_x(body, a, p[k], p[k + 1])
    return x, body[b, at.Y] - body[a, at.Y] - turn_y(body, a, p[k], p[k + 1])


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
class OnLine(OneSidedKind):
    """Points, corners or a disc of B on a line of A.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    joint = "surface"
    wall = "a surface"
    walls_turn = True
    bounded = True
    slides = True

    @staticmethod
    def suits(fields: Fields) -> bool:
        """A line without ends."""
        return not fields["radius"] and not fields["length"]

    @classmethod
    def count(cls, fields: Fields, corners: Corners) -> int:
        """One of every corner."""
        return len(corners)

    @classmethod
    def labels(cls, fields: Fields, corners: Corners) -> tuple[str, ...]:
        """Names of the corners, if there are several."""
        return tuple(corners) if len(corners) > 1 else ()

    @staticmethod
    def parameters(fields: Fields, constants: Sequence[float], corners: Corners) -> Sequence[float | LocalFunction]:
        """Direction of the line, radius of the disc, corners."""
        axis = fields["axis"]
        return (cos(axis), sin(axis), fields["roller"], reach_of(corners), *flat(corners))

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of A's point and of the farthest corner."""
        return hypot(p[0], p[1]), p[REACH]

    @staticmethod
    def held(
        fields: Fields, on_a: tuple[float, float], corners: Corners, corner: int, a: Pose, b: Pose, sticks: bool
    ) -> tuple[Held, ...]:
        """A corner on the line, or the centre of a disc beside it."""
        on_b = list(corners.values())[corner]
        if sticks and not fields["roller"] > 0.0:
            return (pinned(a, b, on_b),)
        return (along_line(fields["axis"], fields["roller"], on_a, on_b, rolls=sticks),)
