"""Cam: a point of B stays on a curve of A, given in polar form about a point of A.

d = (r_B + s_B) - (r_A + s_A),  l = |d|,  e = d/l,  p: e turned by 90 deg,  psi: direction of d
a = psi - phi_A, the direction of d in A's frame;  f(a): distance of the curve from the point of A

    Phi   = l - f(a) = 0                                                                              [m]
    g     = e - f' p/l, the normal of the curve times the length of Phi's gradient
    gamma = -(p . d')^2/l - g . d0 - 2 f' (e . d') (p . d')/l^2 + f'' (p . d'/l - w_A)^2,
            d0 = s_A w_A^2 - s_B w_B^2                                                                [m/s^2]

The multiplier is the component of the force along e; the force itself is sqrt(1 + (f'/l)^2) times as large and normal
to the curve.  The direction a is between -180 and 180 deg, whatever the number of turns; f of a closed curve has the
same value at both.

With friction the point slips along the tangent t = (p + (f'/l) e)/sqrt(1 + (f'/l)^2) at t . (d' - w_A x d).

With a roller of radius r, whose centre is the point of B, the curve is the surface of the cam.  D: distance of the
centre from it, n: normal, u: rate of d as seen from A, see `elements.rolling`

    Phi   = D - r = 0                                                                                 [m]
    gamma = -(n . d0 - 2 n . (w_A x u) + w_A^2 n . d + b (t . u)^2)                                   [m/s^2]

Without roller the curve is the path of the point itself, of a roller's centre the pitch curve of the cam.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.elements.profile import Array, around, degrees, gap
from rattle.elements.roller_path import RollerPath
from rattle.elements.rolling import ROLLER, roller_at
from rattle.interfaces.fields import Fields, function
from rattle.interfaces.joints import JointKind
from rattle.interfaces.laws import TangentKind
from rattle.jit import layout as at
from rattle.jit.choices import assume
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import COINCIDENT, ends
from rattle.language.local_jet import function_jet
from rattle.registry import Field, kind


@kernel("joint")
def cam(body, a, b, p, k, row, rows):
    """Write the row of the cam [m]; p[k + 4] = radius, a function of the angle in A's frame [m], p[k + 5] = roller."""
    if assume(p[k + ROLLER] == 0.0):
        on_path(body, a, b, p, k, row, rows)
    else:
        on_surface(body, a, b, p, k, row, rows)


@compiled
def on_surface(body, a, b, p, k, row, rows):
    """Write the row of a roller on the surface of the cam."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb = body[a, at.W], body[b, at.W]
    distance, nx, ny, _, rest = roller_at(body, a, p, k + 4, dx, dy, ddx, ddy)

    rows[row, at.RES] = distance - p[k + ROLLER]
    rows[row, at.NU] = 0.0
    rows[row, at.GAMMA] = nx * (sbx * wb * wb - sax * wa * wa) + ny * (sby * wb * wb - say * wa * wa) - rest
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -nx, -ny, nx * (say + dy) - ny * (sax + dx)
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = nx, ny, ny * sbx - nx * sby


@compiled
def on_path(body, a, b, p, k, row, rows):
    """Write the row of a point on its path."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb = body[a, at.W], body[b, at.W]
    cos, sin = body[a, at.COS], body[a, at.SIN]
    f, df, ddf = function_jet(p, k + 4, math.atan2(cos * dy - sin * dx, cos * dx + sin * dy))
    d = math.sqrt(dx * dx + dy * dy)
    # in the centre there is no direction: any one does, and the residual -f then moves the point away
    apart = assume(d > COINCIDENT)
    inv = 1.0 / d if apart else 0.0
    ex = dx * inv if apart else 1.0
    ey = dy * inv
    gx, gy = ex + df * ey * inv, ey - df * ex * inv
    along, slip = ex * ddx + ey * ddy, ex * ddy - ey * ddx
    turning = slip * inv - wa

    rows[row, at.RES] = d - f
    rows[row, at.NU] = 0.0
    rows[row, at.GAMMA] = (
        gx * (sbx * wb * wb - sax * wa * wa)
        + gy * (sby * wb * wb - say * wa * wa)
        - slip * slip * inv
        - 2.0 * df * along * slip * inv * inv
        + ddf * turning * turning
    )
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -gx, -gy, gx * say - gy * sax + df
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = gx, gy, gy * sbx - gx * sby


@kernel("joint")
def along_curve(body, a, b, p, k, row, rows):
    """Write the row of the slip t . r of the point along the curve [m/s], with N/|lambda| = |G|."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb = body[a, at.W], body[b, at.W]
    cos, sin = body[a, at.COS], body[a, at.SIN]
    _, df, ddf = function_jet(p, k + 4, math.atan2(cos * dy - sin * dx, cos * dx + sin * dy))
    d = math.sqrt(dx * dx + dy * dy)
    apart = assume(d > COINCIDENT)
    inv = 1.0 / d if apart else 0.0
    ex, ey = dx * inv if apart else 1.0, dy * inv
    u = df * inv
    size = math.sqrt(1.0 + u * u)
    tx, ty = (u * ex - ey) / size, (u * ey + ex) / size
    along, slip = ex * ddx + ey * ddy, ex * ddy - ey * ddx
    round_ = slip * inv - wa
    turning = round_ + wa - (ddf * round_ - u * along) * inv / (size * size)
    rx, ry = ddx + wa * dy, ddy - wa * dx
    vx, vy = body[b, at.VX] - body[a, at.VX], body[b, at.VY] - body[a, at.VY]
    dbx, dby = -wb * sby, wb * sbx
    dax, day = dbx + vx, dby + vy

    rows[row, at.RES] = 0.0
    rows[row, at.NU] = size
    rows[row, at.GAMMA] = turning * (ty * rx - tx * ry) + wb * (tx * dby - ty * dbx) - wa * (tx * day - ty * dax)
    ax, ay = sax + dx, say + dy
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -tx, -ty, ay * tx - ax * ty
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = tx, ty, sbx * ty - sby * tx


@kind("tangent", "along-curve", along_curve)
class AlongCurve(TangentKind):
    """Slip of a point along its curve, on which friction acts.

    Source: do Carmo, Differential Geometry of Curves and Surfaces (1976), section 1-5 (tangents of plane curves).
    """

    unit = "N"


@kind("joint", "cam", cam)
class Cam(JointKind):
    """A roller of B on a cam of A, or a point on a curve, as a bead on a wire; with `contact` it may lift outwards.

    Source: Norton, Cam Design and Manufacturing Handbook (2009), ch. 7; Nikravesh, Planar Multibody Dynamics (2018).
    """

    rows = ("m",)
    places = False
    drawn_as = "cam"
    rubs = True
    tangents = ("along-curve",)
    radius = Field(
        "m", "distance of the curve from the point of A; a from -180 to 180 deg in A's frame", function_of="a",
        least="positive",
    )  # fmt: skip
    roller = Field(
        "m", "radius of a roller about B's point, that rolls on the curve; default: the point is on it", default=0.0,
        least="not negative",
    )  # fmt: skip

    @staticmethod
    def distance(fields: Fields) -> float:
        """The mean radius [m], with that of the roller, as a first guess."""
        return float(around(function(fields, "radius"))[1][0].mean()) + float(fields["roller"])

    @staticmethod
    def fault(fields: Fields) -> str:
        """The radius has to be positive wherever it is known, and the roller has to reach the curve everywhere."""
        a, jets = around(function(fields, "radius"))
        if not len(a):
            return (
                "radius: it is not known at any angle a from -180 to 180 deg; a table needs points there, or a period"
            )
        k = int(jets[0].argmin())
        if jets[0, k] <= 0.0:
            return (
                f"radius: must be positive at every angle; it is {jets[0, k]:.4g} m at a = {degrees(a[k])}."
                " Put the centre, the first point of `connect`, inside the curve"
            )
        return RollerPath(function(fields, "radius"), fields["roller"]).fault() if fields["roller"] > 0.0 else ""

    @staticmethod
    def friction_fault(fields: Fields) -> str:
        """A roller does not slide."""
        why = "a roller rolls, and friction is in its pin: make it a body with a revolute joint that has friction"
        return why if fields["roller"] > 0.0 else ""

    @staticmethod
    def doubt(fields: Fields) -> str:
        """A closed curve ends where it begins."""
        return gap(function(fields, "radius"), "radius", "a")

    @staticmethod
    def bearing_outline(fields: Fields) -> Array:
        """The curve."""
        a, jets = around(function(fields, "radius"))
        return np.asarray(jets[0] * np.array([np.cos(a), np.sin(a)])).T
