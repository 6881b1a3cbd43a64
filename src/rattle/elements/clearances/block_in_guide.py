"""A block in a guide with play: four corners against two walls.

The walls lie at +-(b + c) beside the line of direction u through the point of A; the block on B has the
length 2a and the height 2b and is centred on the point of B.  Contacts 0 and 1 are those with the upper wall
(n = u turned by +90 degrees), 2 and 3 those with the lower one (n = u turned by -90 degrees), each of one diagonal of
the block: of its two ends the one that is nearer to the wall.  So a block may turn over.  Ends change where the
diagonal is parallel to the wall; both are then as far from it as the point of B, and the other diagonal is nearer.

d = corner - point of A, p_A and p_B its arms from the mass centres, r its velocity against A's material there
    g = b + c - n . d,  slip = t . r
    n . r = -g'        d/dt = J_n dv - gamma_n
    t . r = slip       d/dt = J_t dv - gamma_t
    gamma = p_B w_B^2 - p_A w_A^2 + 2 w_A (-r_y, r_x), along n and t
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import direction, turn_x, turn_y
from rattle.registry import kind


@kernel("clearance")
def guide(body, a, b, p, k, corner, row, kinematics):
    c, axis, angle = p[k + 4], p[k + 6], p[k + 7]
    half_length, half_height = 0.5 * p[k + 8], 0.5 * p[k + 9]
    sax = turn_x(body, a, p[k], p[k + 1])
    say = turn_y(body, a, p[k], p[k + 1])
    ux, uy = direction(body, a, axis)
    side = 1.0 if corner < 2 else -1.0
    nx, ny = -side * uy, side * ux
    # the corner in B's frame; the block lies along the line when B is at `angle` to A
    lx = half_length if corner == 0 or corner == 3 else -half_length
    ly = side * half_height
    cb, sb = math.cos(axis - angle), math.sin(axis - angle)
    dx, dy = cb * lx - sb * ly, sb * lx + cb * ly
    if nx * turn_x(body, b, dx, dy) + ny * turn_y(body, b, dx, dy) < 0.0:  # turned over: the other end
        dx, dy = -dx, -dy
    pbx = turn_x(body, b, p[k + 2] + dx, p[k + 3] + dy)
    pby = turn_y(body, b, p[k + 2] + dx, p[k + 3] + dy)
    pax = body[b, at.X] + pbx - body[a, at.X]
    pay = body[b, at.Y] + pby - body[a, at.Y]
    wa, wb = body[a, at.W], body[b, at.W]
    # velocity of the corner against A's material at the same place
    rx = body[b, at.VX] - wb * pby - body[a, at.VX] + wa * pay
    ry = body[b, at.VY] + wb * pbx - body[a, at.VY] - wa * pax
    along, across = nx * rx + ny * ry, nx * ry - ny * rx
    # acceleration of the corner relative to A = J dv - gamma, with gamma from centripetal and Coriolis terms
    gx = pbx * wb * wb - pax * wa * wa - 2.0 * wa * ry
    gy = pby * wb * wb - pay * wa * wa + 2.0 * wa * rx

    kinematics[row, at.GAP] = half_height + c - nx * (pax - sax) - ny * (pay - say)
    kinematics[row, at.DGAP] = -along
    kinematics[row, at.NX], kinematics[row, at.NY] = nx, ny
    kinematics[row, at.PAX], kinematics[row, at.PAY] = pax, pay
    kinematics[row, at.PBX], kinematics[row, at.PBY] = pbx, pby
    kinematics[row, at.SLIP] = across
    kinematics[row, at.GAMMA_N] = nx * gx + ny * gy
    kinematics[row, at.GAMMA_T] = nx * gy - ny * gx


@kind("clearance", "guide", guide)
class Guide:
    """A block in a guide: four corners against two walls.

    Source: Flores, Leine, Glocker, Modeling and analysis of planar rigid multibody systems with translational
    clearance joints based on the non-smooth dynamics approach, Multibody Syst. Dyn. 23 (2010) 165-190.
    """

    joint = "prismatic"
    corners = 4

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float, float]:
        """Arms [m] of the guide's point and of the farthest corner, from the joint's fields; 1: walls turn with A."""
        return math.hypot(p[0], p[1]), math.hypot(p[2], p[3]) + 0.5 * math.hypot(p[8], p[9]), 1.0
