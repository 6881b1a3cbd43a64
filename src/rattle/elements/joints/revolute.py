"""Revolute joint: two bodies share a point and turn freely about it.

d     = (r_B + s_B) - (r_A + s_A)
Phi   = d = 0                                   [m, m]
gamma = s_B w_B^2 - s_A w_A^2                   [m/s^2]
"""

from __future__ import annotations

from rattle.jit.functions import kernel
from rattle.jit.layout import AP, AX, AY, BP, BX, BY, GAMMA, NU, RES, W, X, Y, turn_x, turn_y
from rattle.registry import kind


@kernel("joint")
def revolute(body, a, b, p, k, row, rows):
    sax = turn_x(body, a, p[k], p[k + 1])
    say = turn_y(body, a, p[k], p[k + 1])
    sbx = turn_x(body, b, p[k + 2], p[k + 3])
    sby = turn_y(body, b, p[k + 2], p[k + 3])
    wa = body[a, W] * body[a, W]
    wb = body[b, W] * body[b, W]

    rows[row, RES] = body[b, X] + sbx - body[a, X] - sax
    rows[row, NU] = 0.0
    rows[row, GAMMA] = sbx * wb - sax * wa
    rows[row, AX], rows[row, AY], rows[row, AP] = -1.0, 0.0, say
    rows[row, BX], rows[row, BY], rows[row, BP] = 1.0, 0.0, -sby

    row += 1
    rows[row, RES] = body[b, Y] + sby - body[a, Y] - say
    rows[row, NU] = 0.0
    rows[row, GAMMA] = sby * wb - say * wa
    rows[row, AX], rows[row, AY], rows[row, AP] = 0.0, -1.0, -sax
    rows[row, BX], rows[row, BY], rows[row, BP] = 0.0, 1.0, sbx


@kind("joint", "revolute", revolute)
class Revolute:
    """Two bodies share a point and turn freely about it.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.3.
    """

    rows = ("m", "m")
    moment = False
