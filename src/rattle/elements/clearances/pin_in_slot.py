"""A pin in a straight slot with clearance: one contact, with its walls, a rounded end, or the corners of an open end.

The slot (half width R, length L between the centres of its rounded ends, direction u) is centred on the point of A, the
pin (radius r = R - c) on the point of B.  d = (r_B + s_B) - (r_A + s_A) has the components x = u . d along the slot and
y across it.  The nearest place of the slot is, with f from that place to the centre of the pin,

    on a wall           f = (0, y -+ R)                  |x| <= L/2
    around an end       e = d -+ (L/2) u, n = e/|e|      beyond L/2; its arc has the radius R about that point
    at a corner         f = (x -+ L/2, y -+ R)           beyond L/2 where the end is open: there the walls just stop

    g = |f| - r,  n = -f/|f|  of a wall and a corner;    g = c - |e|  of an arc
    the contact point is p_B = s_B + h n on B, h = r + g/2, and the same place p_A on A

A slot with an open end is a thin wall, of which the pin may touch both sides: a pin that is outside is as far away as
it looks.  Without an open end there is no outside, and the walls bear inwards however far away the pin is.  The normal
and the gap rate are continuous from wall to arc and from wall to corner, so that the pin goes through a mouth in one
contact; only g'' jumps there.  See `elements.disc_contact` for the row.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from rattle.elements.disc_contact import write_disc
from rattle.elements.geneva import AT_END, AT_START, open_at
from rattle.interfaces.contacts import ClearanceKind, FreePlay
from rattle.interfaces.fields import Fields
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import COINCIDENT, direction, ends
from rattle.language.recorded import hypot
from rattle.registry import kind


@compiled
def nearest(x, y, half, opens, width, radius):
    """Nearest place of the slot to the centre of a pin at (x, y) [m] in the frame of the slot.

    half: L/2; opens: index in OPEN; width: R; radius: of the pin [m].
    Returns n (along and across the slot), gap [m], turning rate of n per speed t . r' [1/m], and 1 of a curved wall.
    """
    side, end, on_wall = select(y >= 0.0, 1.0, -1.0), select(x > 0.0, 1.0, -1.0), abs(x) <= half
    closed = opens == 0.0
    # 1 outside of the slot, and 1 at the corner of an open end
    beside = 0.0 if closed else select(abs(y) > width, 1.0, 0.0)
    at_end, at_start = float(opens != AT_START and not closed), float(opens != AT_END and not closed)
    corner = select(x > 0.0, at_end, at_start)
    fx, fy = select(on_wall, 0.0, x - end * half), y - corner * side * width
    far = math.sqrt(fx * fx + fy * fy)
    inv = 1.0 / max(far, COINCIDENT)  # the centre of a pin at a corner is far inside of the material
    around = corner if closed else select(far > width, 1.0, corner)  # 1 where the wall is seen from outside
    out = 1.0 - 2.0 * around
    inside = width - radius - abs(y)
    wall = select(beside > 0.0, -side, side), select(beside > 0.0, abs(y) - width - radius, inside)
    arc = select(around > 0.0, far - (1.0 - corner) * width - radius, width - radius - far)
    return (
        select(on_wall, 0.0, out * fx * inv),
        select(on_wall, wall[0], out * fy * inv),
        select(on_wall, wall[1], arc),
        select(on_wall, 0.0, out * inv),
        select(on_wall, 0.0, 1.0 - around),
    )


@kernel("clearance")
def pin_in_slot(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m], slip [m/s] and gamma [m/s^2] of the contact into its row."""
    sax, say, sbx, sby, dx, dy, _, _ = ends(body, a, b, p, k)
    c, width = p[k + at.CLEARANCE], p[k + at.RADIUS]
    ux, uy = direction(body, a, p[k + at.FIELDS])
    x, y = ux * dx + uy * dy, ux * dy - uy * dx
    half, opens = 0.5 * p[k + at.FIELDS + 1], p[k + at.FIELDS + 2]
    along, across, gap, bent, curved = nearest(x, y, half, opens, width, width - c)
    nx, ny = along * ux - across * uy, along * uy + across * ux
    radius = width - c
    sliding = write_disc(body, a, b, True, sax + dx, say + dy, sbx, sby, nx, ny, gap, radius, bent, row, kinematics)
    kinematics[row, at.ACROSS] = select(curved > 0.0, sliding, 0.0)


class AcrossSlot(FreePlay):
    """Displacements of the pin across the slot by e_0 [m]; e_1 is not used."""

    def first_order(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        """The extreme is on one of the walls; see `FreePlay.first_order`."""
        return self.clearance * abs(float(y[0])), np.array([math.copysign(self.clearance, y[0]), 0.0])


@kind("clearance", "pin-in-slot", pin_in_slot)
class PinInSlot(ClearanceKind):
    """A pin in a straight slot with rounded or open ends: one contact, on a wall, around an end or at its corners.

    Source: Flores, Ambrosio, Revolute joints with clearance in multibody systems, Comput. Struct. 82 (2004) 1359-1369,
    for the rounded ends; Flores, Leine, Glocker, Multibody Syst. Dyn. 23 (2010) 165-190, for the walls.
    """

    joint = "slot"
    borne, bearer = "pin", "slot"
    wall = "a slot"
    walls_turn = True

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of the farther end of the slot (of its middle if it has no ends) and of the pin."""
        half, width = 0.5 * p[at.FIELDS + 1], p[at.RADIUS] if p[at.FIELDS + 2] > 0.0 else 0.0
        end = half if half < math.inf else 0.0
        return hypot(p[0], p[1]) + hypot(end, width), hypot(p[2], p[3])

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """1/r [1/m]: how fast the direction from a corner to the pin turns, which is nowhere nearer than its radius."""
        clearance, width = constants
        return 0.0, 0.0, 1.0 / (width - clearance) if fields["open"] > 0.0 else 0.0

    @staticmethod
    def play_along(fields: Fields, along: np.ndarray) -> np.ndarray:
        """The part (n,) [m] of the displacement beyond the centres of the ends."""
        half, (start, end) = 0.5 * fields["length"], open_at(fields)
        outside: np.ndarray = along - along.clip(-math.inf if start else -half, math.inf if end else half)
        return outside

    @staticmethod
    def displaced(fields: Fields, e: np.ndarray) -> tuple[float, float, Mapping[str, float]]:
        """Displaced across by e_0 [m]; see `ClearanceKind.displaced`."""
        axis = fields["axis"]
        return -math.sin(axis) * float(e[0]), math.cos(axis) * float(e[0]), {}

    @staticmethod
    def free_play(clearance: float, fields: Fields, dimensions: Mapping[str, tuple[float, ...]]) -> FreePlay:
        """The displacements from wall to wall, clearance in m."""
        return AcrossSlot(clearance)
