"""Flat-faced follower: a straight face of B touches a convex cam of A, given by its support function.

n: normal of the face, away from the cam, at the angle nu in B;  m: n turned by 90 deg
d = (r_B + s_B) - (r_A + s_A), from the centre of the cam to a point of the face
x = phi_B + nu - phi_A, the direction of n in A's frame
h(x): distance of the tangent of the cam with the normal x from its centre

    Phi   = n . d - h(x) = 0                                                                              [m]
    gamma = n . (s_B w_B^2 - s_A w_A^2) - 2 w_B (m . d') + w_B^2 (n . d) + h'' (w_B - w_A)^2              [m/s^2]

With friction the face slips over the cam at m . (v_B + w_B x p_B - v_A - w_A x p_A), p_A = s_A + h n + h' m and p_B the
same place on B, by N = |lambda|.

They touch at h n + h' m from the centre, where the radius of curvature is h + h''.  Where this is negative there is no
such cam: its outline has a loop there, over which the face does not reach down to the curve.  The direction x is
between -180 and 180 deg, whatever the number of turns.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.elements.profile import Array, around, degrees, gap
from rattle.interfaces.fields import Fields, function
from rattle.interfaces.joints import JointKind
from rattle.interfaces.laws import TangentKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import direction, ends
from rattle.language.local_jet import function_jet
from rattle.registry import Field, kind

CUT = 0.005  # of the largest support: loops of an outline that reach no farther beyond the face are let pass


@kernel("joint")
def flat_follower(body, a, b, p, k, row, rows):
    """Write the row of the face [m]; p[k + 4:] = angle of its normal in B [rad], support, a function of x [m]."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    nx, ny = direction(body, b, p[k + 4])
    wa, wb = body[a, at.W], body[b, at.W]
    cos, sin = body[a, at.COS], body[a, at.SIN]
    h, dh, ddh = function_jet(p, k + 5, math.atan2(cos * ny - sin * nx, cos * nx + sin * ny))
    turning = wb - wa
    reach = nx * dx + ny * dy

    rows[row, at.RES] = reach - h
    rows[row, at.NU] = 0.0
    rows[row, at.GAMMA] = (
        nx * (sbx * wb * wb - sax * wa * wa)
        + ny * (sby * wb * wb - say * wa * wa)
        - 2.0 * wb * (nx * ddy - ny * ddx)
        + wb * wb * reach
        + ddh * turning * turning
    )
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -nx, -ny, nx * say - ny * sax + dh
    rows[row, at.BX], rows[row, at.BY] = nx, ny
    rows[row, at.BP] = ny * sbx - nx * sby + nx * dy - ny * dx - dh


@kernel("joint")
def along_face(body, a, b, p, k, row, rows):
    """Write the row of the slip of the face over the cam [m/s], with N = |lambda|; as in the derivation."""
    sax, say, sbx, sby, dx, dy, _, _ = ends(body, a, b, p, k)
    nx, ny = direction(body, b, p[k + 4])
    mx, my = -ny, nx
    wa, wb = body[a, at.W], body[b, at.W]
    cos, sin = body[a, at.COS], body[a, at.SIN]
    h, dh, ddh = function_jet(p, k + 5, math.atan2(cos * ny - sin * nx, cos * nx + sin * ny))
    reach = nx * dx + ny * dy
    ax, ay = sax + h * nx + dh * mx, say + h * ny + dh * my
    bx, by = sbx - dx + reach * nx + dh * mx, sby - dy + reach * ny + dh * my
    vx, vy = body[b, at.VX] - body[a, at.VX], body[b, at.VY] - body[a, at.VY]
    off = nx * (vx - wb * by + wa * ay) + ny * (vy + wb * bx - wa * ax)
    # rates of the arms
    moves = h * wb + ddh * (wb - wa)
    dax, day = -wa * say - dh * wa * nx + moves * mx, wa * sax - dh * wa * ny + moves * my
    dbx, dby = dax - vx, day - vy

    rows[row, at.RES] = 0.0
    rows[row, at.NU] = 1.0
    rows[row, at.GAMMA] = wb * off + wb * (mx * dby - my * dbx) - wa * (mx * day - my * dax)
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -mx, -my, ay * mx - ax * my
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = mx, my, bx * my - by * mx


@kind("tangent", "along-face", along_face)
class AlongFace(TangentKind):
    """Slip of a flat follower over its cam, on which friction acts.

    Source: Norton, Cam Design and Manufacturing Handbook (2009), chapter 7.
    """

    unit = "N"


@kind("joint", "flat-follower", flat_follower)
class FlatFollower(JointKind):
    """A straight face of B on a convex cam of A, held on both sides; with `contact` it may lift off.

    Source: do Carmo, Differential Geometry of Curves and Surfaces (1976), section 1-7 (support function).
    """

    rows = ("m",)
    places = False
    moment = True
    drawn_as = "flat-follower"
    rubs = True
    tangents = ("along-face",)
    axis = Field("rad", "direction in B's frame of the normal of the face, away from the cam", default=0.0)
    support = Field(
        "m", "distance from the centre to the tangent with the normal x, from -180 to 180 deg in A's frame",
        function_of="x", least="positive",
    )  # fmt: skip

    @staticmethod
    def fault(fields: Fields) -> str:
        """The cam has to be convex: its outline must not stand out beyond the face that touches it."""
        x, (h, _, _) = around(function(fields, "support"))
        if not len(x):
            return "support: it is not known at any x from -180 to 180 deg; a table needs points there, or a period"
        where, curvature, cut = worst_of(fields)
        if cut <= CUT * np.abs(h).max():
            return ""
        return (
            f"support: a flat face needs a convex cam; near x = {where} the radius of curvature h + h'' is"
            f" {curvature:.4g} m, and the face would cut off {cut:.4g} m. Make the base of the cam larger or its rise"
            ' slower, or use a roller (type = "cam")'
        )

    @staticmethod
    def doubt(fields: Fields) -> str:
        """Small loops of the outline, and steps."""
        where, curvature, cut = worst_of(fields)
        if cut > 0.0:
            return (
                f"support: near x = {where} the radius of curvature h + h'' is {curvature:.4g} m: the cam is not"
                f" convex; the face cuts off {cut:.3g} m"
            )
        return gap(function(fields, "support"), "support", "x")

    @staticmethod
    def bearing_outline(fields: Fields) -> Array:
        """Where the face touches the cam."""
        x, (h, dh, _) = around(function(fields, "support"))
        cos, sin = np.cos(x), np.sin(x)
        return np.column_stack([h * cos - dh * sin, h * sin + dh * cos])


def worst_of(fields: Fields) -> tuple[str, float, float]:
    """Where the outline is least convex, its radius of curvature there [m], and what the face cuts off it [m]."""
    x, (h, dh, ddh) = around(function(fields, "support"))
    curved = h + ddh
    # over a kink the tangent has to turn the right way too
    between = (np.diff(dh) + 0.5 * np.diff(x) * (h[1:] + h[:-1])) / np.diff(x)
    k, j = int(curved.argmin()), int(between.argmin()) if len(between) else 0
    if curved[k] > 0.0 and (not len(between) or between[j] >= 0.0):
        return degrees(x[k]), float(curved[k]), 0.0
    touched = FlatFollower.bearing_outline(fields)
    cut = (touched @ np.array([np.cos(x), np.sin(x)])).max(axis=0) - h
    where, least = (x[k], curved[k]) if curved[k] <= 0.0 else (x[j], between[j])
    return degrees(where), float(least), float(cut.max())
