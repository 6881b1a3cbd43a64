"""Rod: a massless rigid link of length L between a point of A and a point of B.

    d = (r_B + s_B) - (r_A + s_A),  n = d / |d|
    Phi   = |d| - L = 0                                                                  [m]
    gamma = -(|d'|^2 - (n . d')^2) / |d| + n . (s_B w_B^2 - s_A w_A^2)                   [m/s^2]

A pin that stays in contact with its bush is such a rod, L = radial clearance (the paper, section 1).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from rattle.elements.joints import JointKind
from rattle.jit import layout as at
from rattle.jit.choices import assume
from rattle.jit.functions import kernel
from rattle.jit.geometry import ends
from rattle.registry import Field, kind


@kernel("joint")
def rod(body, a, b, p, k, row, rows):
    """Write the row of the rod [m]; p[k + 4] = length [m]."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb = body[a, at.W], body[b, at.W]
    d = math.sqrt(dx * dx + dy * dy)
    # coincident ends have no direction: any one does, and the residual -L then moves them apart
    apart = assume(d > 1e-150)
    inv = 1.0 / d if apart else 0.0
    nx = dx * inv if apart else 1.0
    ny = dy * inv
    slip = nx * ddy - ny * ddx

    rows[row, at.RES] = d - p[k + 4]
    rows[row, at.NU] = 0.0
    rows[row, at.GAMMA] = (
        -slip * slip * inv + nx * (sbx * wb * wb - sax * wa * wa) + ny * (sby * wb * wb - say * wa * wa)
    )
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -nx, -ny, nx * say - ny * sax
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = nx, ny, ny * sbx - nx * sby


@kind("joint", "rod", rod)
class Rod(JointKind):
    """A massless rigid link of given length between two points.

    Source: Grigore et al., Application to the motion and equilibrium of planar kinematic chains, section 1.
    """

    rows = ("m",)
    no_friction = (
        "a rod without mass cannot pass on the moments that friction in its pins needs: make it a body with two"
        " revolute joints, which have friction"
    )
    drawn_as = "rod"
    length = Field("m", "length of the rod", least="positive")

    @staticmethod
    def distance(fields: Mapping[str, float]) -> float:
        """The given length [m]."""
        return fields["length"]
