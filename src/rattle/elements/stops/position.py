"""Stops of a position: the force along the line of a joint whose point of B is at its least or largest position.

u = direction of the line (fixed in A), n' = u turned by 90 degrees, d = (r_B + s_B) - (r_A + s_A), x = u . d
g_0 = x - min,  g_1 = max - x                                             gaps [m]
n_0 = -u,       n_1 = +u                                                  at the point of B
gamma = n . (s_B w_B^2 - s_A w_A^2) +- (-2 w_A (n' . d') + w_A^2 (u . d)) [m/s^2], + at the largest position

This is the row of the driver of the same coordinate.
"""

from __future__ import annotations

import math

from rattle.elements.stops import LARGEST, LEAST, LINE
from rattle.interfaces.contacts import StopKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import direction, ends
from rattle.registry import Field, kind


@kernel("clearance")
def stop_position(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m] and gamma [m/s^2] of one end into its row."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    ux, uy = direction(body, a, p[k + LINE])
    wa, wb = body[a, at.W], body[b, at.W]
    side = -1.0 if corner == 0 else 1.0
    x, across = ux * dx + uy * dy, ux * dy - uy * dx
    rate = ux * ddx + uy * ddy + wa * across
    gamma = (
        ux * (sbx * wb * wb - sax * wa * wa)
        + uy * (sby * wb * wb - say * wa * wa)
        - 2.0 * wa * (ux * ddy - uy * ddx)
        + wa * wa * x
    )

    kinematics[row, at.GAP] = x - p[k + LEAST] if corner == 0 else p[k + LARGEST] - x
    kinematics[row, at.DGAP] = -side * rate
    kinematics[row, at.NX], kinematics[row, at.NY] = side * ux, side * uy
    kinematics[row, at.PAX], kinematics[row, at.PAY] = sax + dx, say + dy
    kinematics[row, at.PBX], kinematics[row, at.PBY] = sbx, sby
    kinematics[row, at.GAMMA_N] = side * gamma


@kind("stop", "position", stop_position)
class StopPosition(StopKind):
    """The position of B's point along the line of the joint stays between two ends.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    walls_turn = True
    min = Field("m", "least position along the line, from the point of A", default=-math.inf)
    max = Field("m", "largest position along the line, from the point of A", default=math.inf)
