"""Discs, points and corners of B on a segment of A, of the length 2 h about the point of A.

u: direction of the segment, n' = u turned by 90 degrees; d: from the point of A to the centre of the disc or to the
corner; x = u . d, y = n' . d

A disc (radius r) bears on both sides and at the ends.  With q = (max(|x| - h, 0) sgn x, y), the offset from the nearest
point of the segment,

    g = |q| - r        n = -q/|q|,    bent = -1/|q| beyond the ends, 0 before

A corner bears on the left side, where y > 0, only while it is over the segment.  So it has a memory: one that is below
(ASLEEP) touches nothing until it is above again, at g = -y = 0, which is no impact.

    awake       g = y over the segment,  |(|x| - h, max(y, 0))| beside it
    held        g = y, also beyond the end: a closed contact, which ends there, see `equations.one_way`

See `elements.disc_contact` for the rows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.elements.disc_contact import write_disc
from rattle.elements.one_sided.corner_surface import REACH, ROLLER, SHAPE, CornerSurface, between, between_centres
from rattle.elements.one_sided.holding import Vector, along_line, around_disc
from rattle.interfaces.contacts import Held
from rattle.interfaces.fields import Fields
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import COINCIDENT, turn_x, turn_y
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import cos, hypot, least, sin
from rattle.registry import kind

ALONG_X, ALONG_Y, HALF = range(SHAPE, SHAPE + 3)
CORNERS = SHAPE + 3
FLUSH = 1e-10  # share of a segment by which a corner may be beyond its end: those that are flush stay borne
NEAREST = 1e-3  # share of a segment as near as which its end turns the direction of the gap of a corner that passes


@compiled
def over_end(x, half):
    """How far x is beyond the nearer end of the segment [m], and on which side: 1 or -1."""
    side = select(x >= 0.0, 1.0, -1.0)
    return side * x - half, side


@kernel("clearance")
def on_segment(body, a, b, p, k, corner, row, kinematics):
    """Write the row of a disc of B on a segment; of corner -1 the gap that none is below."""
    if corner < 0:
        dx, dy = between_centres(body, a, b, p, k)
        kinematics[row, at.GAP] = math.sqrt(dx * dx + dy * dy) - p[k + HALF] - p[k + ROLLER] - p[k + REACH]
        return
    sax, say, sbx, sby, dx, dy = between(body, a, b, p, k, k + CORNERS + 2 * corner)
    ux, uy = turn_x(body, a, p[k + ALONG_X], p[k + ALONG_Y]), turn_y(body, a, p[k + ALONG_X], p[k + ALONG_Y])
    over, side = over_end(ux * dx + uy * dy, p[k + HALF])
    y = ux * dy - uy * dx
    x = side * max(over, 0.0)
    far = math.sqrt(x * x + y * y)
    apart = far > COINCIDENT
    inv = select(apart, 1.0 / max(far, COINCIDENT), 0.0)
    x, y = x * inv, select(apart, y * inv, 1.0)
    nx, ny = -x * ux + y * uy, -x * uy - y * ux
    bent = select(over > 0.0, -inv, 0.0)
    gap, roller = far - p[k + ROLLER], p[k + ROLLER]
    write_disc(body, a, b, True, sax + dx, say + dy, sbx, sby, nx, ny, gap, roller, bent, row, kinematics)


@kernel("clearance")
def over_segment(body, a, b, p, k, corner, row, kinematics):
    """Write the row of a corner of B over a segment, by its PHASE, with how far it is ABOVE it and BEYOND its end.

    Of corner -1 the gap that none is below.
    """
    if corner < 0:
        dx, dy = between_centres(body, a, b, p, k)
        kinematics[row, at.GAP] = math.sqrt(dx * dx + dy * dy) - p[k + HALF] - p[k + REACH]
        return
    sax, say, sbx, sby, dx, dy = between(body, a, b, p, k, k + CORNERS + 2 * corner)
    ux, uy = turn_x(body, a, p[k + ALONG_X], p[k + ALONG_Y]), turn_y(body, a, p[k + ALONG_X], p[k + ALONG_Y])
    over, side = over_end(ux * dx + uy * dy, (1.0 + FLUSH) * p[k + HALF])
    y, phase = ux * dy - uy * dx, kinematics[row, at.PHASE]
    gap, nx, ny, bent = y, uy, -ux, 0.0
    if phase == at.ASLEEP:
        gap, nx, ny = -y, -uy, ux
    elif phase == at.AWAKE and over > 0.0:
        up = max(y, 0.0)
        gap = math.sqrt(over * over + up * up)
        away, rise = (over / gap, up / gap) if gap > COINCIDENT else (1.0, 0.0)
        nx, ny = -side * away * ux + rise * uy, -side * away * uy - rise * ux
        bent = -1.0 / max(gap, COINCIDENT) if up > 0.0 else 0.0
    write_disc(body, a, b, True, sax + dx, say + dy, sbx, sby, nx, ny, gap, 0.0, bent, row, kinematics)
    kinematics[row, at.ABOVE], kinematics[row, at.BEYOND] = y, over


@kind("one-sided", "on-segment", on_segment)
class OnSegment(CornerSurface):
    """A disc of B on a segment of A, on both sides and at its ends.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    walls_turn = True

    @staticmethod
    def suits(fields: Fields) -> bool:
        """A segment against a disc."""
        return fields["length"] > 0.0 and fields["roller"] > 0.0

    @staticmethod
    def shape(fields: Fields) -> tuple[float | LocalFunction, ...]:
        """Direction and half length of the segment."""
        return cos(fields["axis"]), sin(fields["axis"]), 0.5 * fields["length"]

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of A's farther end and of the farthest corner."""
        return hypot(p[0], p[1]) + p[HALF], p[REACH]

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """1/r [1/m]: how fast the direction from an end to the disc turns."""
        return 0.0, 0.0, 1.0 / fields["roller"]

    @staticmethod
    def guided(fields: Fields, on_a: Vector, on_b: Vector, place: Vector, rolls: bool) -> tuple[Held, ...]:
        """A point on the line, or the centre of a disc beside it, or at a distance from an end of the segment."""
        axis, half, roller = fields["axis"], 0.5 * fields["length"], fields["roller"]
        (x, y), c, s = place, math.cos(axis), math.sin(axis)
        along = x * c + y * s
        if roller > 0.0 and abs(along) > half:
            end = math.copysign(half, along)
            return around_disc(0.0, roller, (on_a[0] + end * c, on_a[1] + end * s), on_b, rolls)
        below = y * c - x * s < 0.0
        return (along_line(axis + math.pi if below else axis, roller, on_a, on_b, rolls=rolls),)


@kind("one-sided", "over-segment", over_segment)
class OverSegment(OnSegment):
    """Points and corners of B on the left side of a segment of A, while they are over it.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    @classmethod
    def one_way(cls, fields: Fields) -> bool:
        """It does."""
        return True

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The length of the segment, but no more than the size."""
        return least(size, 2.0 * p[HALF])

    @staticmethod
    def suits(fields: Fields) -> bool:
        """A segment against points."""
        return fields["length"] > 0.0 and not fields["roller"] > 0.0

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """How fast the direction from an end turns to a corner that passes NEAREST to it [1/m]."""
        return 0.0, 0.0, 1.0 / (NEAREST * fields["length"])
