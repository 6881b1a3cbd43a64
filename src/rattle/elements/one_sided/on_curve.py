"""Point of B outside of a curve of A in polar form: the follower of a cam, which may lift off.

d, l, e, p, a, f(a): as in `joints.cam`;  u = f'/l,  s = 1/sqrt(1 + u^2)

Phi = l - f(a),   G = e - u p                                                            row of the joint: Phi' = G . d'
g   = s Phi                                    gap [m]: the distance from the curve, exact where the two touch
n   = -(s G + Phi s_d),  s_d = s^3 u (u e - f'' p/l)/l                                   the slope of the gap by d
    at the point of B, p_B = s_B, p_A = s_A + d:  |n| = 1 where they touch
gamma = -(s gamma_Phi) + 2 s' Phi'                                                       [m/s^2], where they touch

gamma_Phi: of the row of the joint.  s' = s_d . r, r: velocity of the point of B relative to the material of A there.

With a roller g = D - r, n = -(slope of D), and gamma is that of the row with the other sign, exact everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rattle.elements.profile import around
from rattle.elements.roller_path import RollerPath
from rattle.elements.rolling import ROLLER, roller_at
from rattle.interfaces.contacts import OneSidedKind
from rattle.interfaces.fields import Fields, function
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import COINCIDENT, ends
from rattle.language.local_jet import function_jet
from rattle.registry import kind


@kernel("clearance")
def on_curve(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m] and gamma [m/s^2] of the point or roller into its row."""
    if p[k + ROLLER] > 0.0:
        roller_above(body, a, b, p, k, row, kinematics)
    else:
        point_above(body, a, b, p, k, row, kinematics)


@compiled
def roller_above(body, a, b, p, k, row, kinematics):
    """The row of a roller."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb = body[a, at.W], body[b, at.W]
    distance, nx, ny, rate, rest = roller_at(body, a, p, k + 4, dx, dy, ddx, ddy)

    kinematics[row, at.GAP] = distance - p[k + ROLLER]
    kinematics[row, at.DGAP] = rate
    kinematics[row, at.NX], kinematics[row, at.NY] = -nx, -ny
    kinematics[row, at.PAX], kinematics[row, at.PAY] = sax + dx, say + dy
    kinematics[row, at.PBX], kinematics[row, at.PBY] = sbx, sby
    kinematics[row, at.GAMMA_N] = nx * (sax * wa * wa - sbx * wb * wb) + ny * (say * wa * wa - sby * wb * wb) + rest


@compiled
def point_above(body, a, b, p, k, row, kinematics):
    """The row of a point."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb = body[a, at.W], body[b, at.W]
    cos, sin = body[a, at.COS], body[a, at.SIN]
    f, df, ddf = function_jet(p, k + 4, math.atan2(cos * dy - sin * dx, cos * dx + sin * dy))
    d = math.sqrt(dx * dx + dy * dy)
    apart = d > COINCIDENT
    inv = select(apart, 1.0 / max(d, COINCIDENT), 0.0)
    ex, ey = select(apart, dx * inv, 1.0), dy * inv
    u = df * inv
    s = 1.0 / math.sqrt(1.0 + u * u)
    gx, gy = ex + u * ey, ey - u * ex
    along, slip = ex * ddx + ey * ddy, ex * ddy - ey * ddx
    turning = slip * inv - wa
    # slope of s by the offset
    on_e, on_p = s * s * s * u * u * inv, -s * s * s * u * ddf * inv * inv
    turned = slip - wa * d
    ds, rate = on_e * along + on_p * turned, along - df * turning
    phi = d - f
    gamma = (
        gx * (sbx * wb * wb - sax * wa * wa)
        + gy * (sby * wb * wb - say * wa * wa)
        - slip * slip * inv
        - 2.0 * df * along * slip * inv * inv
        + ddf * turning * turning
    )

    kinematics[row, at.GAP] = s * phi
    kinematics[row, at.DGAP] = s * rate + ds * phi
    kinematics[row, at.NX] = -s * gx - phi * (on_e * ex - on_p * ey)
    kinematics[row, at.NY] = -s * gy - phi * (on_e * ey + on_p * ex)
    kinematics[row, at.PAX], kinematics[row, at.PAY] = sax + dx, say + dy
    kinematics[row, at.PBX], kinematics[row, at.PBY] = sbx, sby
    kinematics[row, at.GAMMA_N] = -s * gamma + 2.0 * ds * rate


@kind("one-sided", "on-curve", on_curve)
class OnCurve(OneSidedKind):
    """A point outside of a closed curve, as of a cam with a roller: it is only pushed outwards.

    Source: Norton, Cam Design and Manufacturing Handbook (2009), ch. 7; Pfeiffer, Glocker, Multibody Dynamics with
    Unilateral Contacts (1996), chapter 2.
    """

    joint = "cam"
    wall = "a cam"
    walls_turn = True

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """Twice the largest curvature [1/m] of the distance from the curve and of its scale, around the curve."""
        if fields["roller"] > 0.0:
            curvature = RollerPath(function(fields, "radius"), fields["roller"]).curvature
            return 0.0, 0.0, float(2.0 * np.abs(curvature / (1.0 + curvature * fields["roller"])).max())
        f, df, ddf = around(function(fields, "radius"))[1]
        u, v = df / f, ddf / f
        return 0.0, 0.0, float((2.0 * (1.0 + 3.0 * u * u + np.abs(v)) * (1.0 + np.abs(u)) / f).max())
