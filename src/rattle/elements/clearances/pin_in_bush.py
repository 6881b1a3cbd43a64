"""A pin in a bush with clearance: one contact.

e = (r_B + s_B) - (r_A + s_A)     pin centre minus bush centre, bush (bore radius R) on A, pin (R - c) on B
n = e / |e|                       from the bush centre outwards
g = c - |e|                       gap; the contact point, midway between the surfaces, is s_A + h n on A and
                                  s_B + (h - |e|) n on B, h = R - (c - |e|)/2

Relative velocity u of the two material points, t = n turned by 90 degrees:
    n . u = n . e' = -g'                               d/dt = J_n dv - gamma_n
    t . u = t . e' + w_B (h - |e|) - w_A h  (slip)     d/dt = J_t dv - gamma_t
    gamma_n = n . (s_B w_B^2 - s_A w_A^2) - (t . e')^2 / |e|
    gamma_t = t . (s_B w_B^2 - s_A w_A^2) + (t . e')(n . e') / |e| + (w_A + w_B)(n . e')/2
"""

from __future__ import annotations

import math

from rattle.interfaces.contacts import ClearanceKind
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import kernel
from rattle.jit.geometry import COINCIDENT, ends
from rattle.registry import kind

LEAST = 1e-300  # [m^2]


@kernel("clearance")
def pin(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m], slip [m/s] and gamma [m/s^2] of the contact into its row."""
    sax, say, sbx, sby, ex, ey, dex, dey = ends(body, a, b, p, k)
    c, bore = p[k + at.CLEARANCE], p[k + at.RADIUS]
    wa, wb = body[a, at.W], body[b, at.W]
    e = math.sqrt(max(ex * ex + ey * ey, LEAST))  # in the middle it has a derivative too
    apart = e > COINCIDENT
    inv = select(apart, 1.0 / max(e, COINCIDENT), 0.0)
    nx = select(apart, ex * inv, 1.0)
    ny = ey * inv
    along = nx * dex + ny * dey
    across = nx * dey - ny * dex  # t . e'
    on_a = bore - 0.5 * (c - e)  # h; from the pin centre the arm is h - |e|
    on_b = on_a - e
    turning = across * inv  # rate at which n turns
    rx = sbx * wb * wb - sax * wa * wa
    ry = sby * wb * wb - say * wa * wa

    kinematics[row, at.GAP] = c - e
    kinematics[row, at.DGAP] = -along
    kinematics[row, at.NX], kinematics[row, at.NY] = nx, ny
    kinematics[row, at.PAX], kinematics[row, at.PAY] = sax + on_a * nx, say + on_a * ny
    kinematics[row, at.PBX], kinematics[row, at.PBY] = sbx + on_b * nx, sby + on_b * ny
    # its rate is t . e'' - turning (n . e') + alpha_B (h - |e|) - alpha_A h - (w_A + w_B) (n . e')/2
    kinematics[row, at.SLIP] = across + wb * on_b - wa * on_a
    kinematics[row, at.ACROSS] = across
    kinematics[row, at.GAMMA_N] = nx * rx + ny * ry - across * turning
    kinematics[row, at.GAMMA_T] = -ny * rx + nx * ry + turning * along + 0.5 * (wa + wb) * along


@kind("clearance", "pin", pin)
class PinInBush(ClearanceKind):
    """A pin in a bush: one contact on the circle of the clearance.

    Source: Flores, Ambrosio, Revolute joints with clearance in multibody systems, Comput. Struct. 82 (2004) 1359-1369.
    """

    joint = "revolute"
    from_materials = True
    holds_oil = True
    orbit = True
