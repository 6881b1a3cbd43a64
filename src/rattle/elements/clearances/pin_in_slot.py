"""A pin in a straight slot with rounded ends and clearance: one contact.

The slot (half width R, length L between the centres of its ends, direction u) is centred on the point of A, the pin
(radius R - c) on the point of B.  The centre of the pin is within c of the line from end to end:

d = (r_B + s_B) - (r_A + s_A),  z = u . d limited to +-L/2     the point of that line nearest to the centre of the pin
e = d - z u,  n = e / |e|                                      between the ends n is across: u turned by +-90 degrees
g = c - |e|                                                    gap; the contact point is p_B = s_B + h n on B,
                                                               h = R - (c + |e|)/2, and the same place p_A on A

r: velocity of the centre of the pin relative to the material of A there, t = n turned by 90 degrees; n turns at the
rate w_n = w_A between the ends, w_A + (t . r)/|e| around them, so normal and gap rate are continuous from wall to end:
    n . r = -g'                                    d/dt = J_n dv - gamma_n
    slip = t . r + (w_B - w_A) h                   d/dt = J_t dv - gamma_t
    gamma_n = -w_n slip + t . (w_B p_B' - w_A p_A')
    gamma_t = w_n (n . r) - n . (w_B p_B' - w_A p_A')
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from rattle.elements.clearances import ClearanceKind, FreePlay
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import direction, ends
from rattle.registry import kind


@kernel("clearance")
def pin_in_slot(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m], slip [m/s] and gamma [m/s^2] of the contact into its row."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    c, radius = p[k + at.CLEARANCE], p[k + at.RADIUS]
    ux, uy = direction(body, a, p[k + at.FIELDS])
    half = 0.5 * p[k + at.FIELDS + 1]
    wa, wb = body[a, at.W], body[b, at.W]
    rx, ry = ddx + wa * dy, ddy - wa * dx
    along = ux * dx + uy * dy
    if abs(along) <= half:
        y = ux * dy - uy * dx
        side = 1.0 if y >= 0.0 else -1.0
        nx, ny, e = -side * uy, side * ux, side * y
        round_ = inv = 0.0
    else:
        z = math.copysign(half, along)
        ex, ey = dx - z * ux, dy - z * uy
        e = math.sqrt(ex * ex + ey * ey)
        inv = 1.0 / e  # |along| > half, so e > 0
        nx, ny = ex * inv, ey * inv
        round_ = nx * ry - ny * rx
    closing, across = nx * rx + ny * ry, nx * ry - ny * rx
    turning = wa + round_ * inv
    h = radius - 0.5 * (c + e)
    pbx, pby = sbx + h * nx, sby + h * ny
    slip = across + (wb - wa) * h
    # rates of the arms
    dpbx = -wb * sby - 0.5 * closing * nx - h * turning * ny
    dpby = wb * sbx - 0.5 * closing * ny + h * turning * nx
    dpax, dpay = dpbx + body[b, at.VX] - body[a, at.VX], dpby + body[b, at.VY] - body[a, at.VY]
    fx, fy = wb * dpbx - wa * dpax, wb * dpby - wa * dpay

    kinematics[row, at.GAP] = c - e
    kinematics[row, at.DGAP] = -closing
    kinematics[row, at.NX], kinematics[row, at.NY] = nx, ny
    kinematics[row, at.PAX], kinematics[row, at.PAY] = sax + dx + h * nx, say + dy + h * ny
    kinematics[row, at.PBX], kinematics[row, at.PBY] = pbx, pby
    kinematics[row, at.SLIP] = slip
    kinematics[row, at.ACROSS] = round_
    kinematics[row, at.GAMMA_N] = -turning * slip + nx * fy - ny * fx
    kinematics[row, at.GAMMA_T] = turning * closing - nx * fx - ny * fy


class AcrossSlot(FreePlay):
    """Displacements of the pin across the slot by e_0 [m]; e_1 is not used."""

    def first_order(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        """The extreme is on one of the walls; see `FreePlay.first_order`."""
        return self.clearance * abs(float(y[0])), np.array([math.copysign(self.clearance, y[0]), 0.0])


@kind("clearance", "pin-in-slot", pin_in_slot)
class PinInSlot(ClearanceKind):
    """A pin in a straight slot with rounded ends: one contact, on a wall or around an end.

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
        half = 0.5 * p[at.FIELDS + 1]
        end = half if half < math.inf else 0.0
        return math.hypot(p[0], p[1]) + end, math.hypot(p[2], p[3])

    @staticmethod
    def play_along(fields: Mapping[str, float], along: np.ndarray) -> np.ndarray:
        """The part (n,) [m] of the displacement beyond the centres of the ends."""
        half = 0.5 * fields["length"]
        outside: np.ndarray = along - along.clip(-half, half)
        return outside

    @staticmethod
    def displaced(fields: Mapping[str, float], e: np.ndarray) -> tuple[float, float, Mapping[str, float]]:
        """Displaced across by e_0 [m]; see `ClearanceKind.displaced`."""
        axis = fields["axis"]
        return -math.sin(axis) * float(e[0]), math.cos(axis) * float(e[0]), {}

    @staticmethod
    def free_play(
        clearance: float, fields: Mapping[str, float], dimensions: Mapping[str, tuple[float, ...]]
    ) -> FreePlay:
        """The displacements from wall to wall, clearance in m."""
        return AcrossSlot(clearance)
