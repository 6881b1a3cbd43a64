"""Wheel: a disc about a point of B, of radius r, rolls on a line of A, on its left.

u = direction of the line (fixed in A), n = u turned by 90 degrees, d = (r_B + s_B) - (r_A + s_A) to the centre
Phi_1   = n . d - r = 0                                                                       [m]
Phi_2   = u . d + r (phi_B - phi_A) - c = 0                                                   [m]
gamma_1 = n . (s_B w_B^2 - s_A w_A^2) + 2 w_A (u . d') + w_A^2 (n . d)                        [m/s^2]
gamma_2 = u . (s_B w_B^2 - s_A w_A^2) - 2 w_A (n . d') + w_A^2 (u . d)                        [m/s^2]

Along u the wheel rolls in the negative sense, as on a road with the axis 0.  On B acts N n + T u where it touches,
N = -lambda_1, T = -lambda_2.  With friction the second row is given up; the wheel slips over the line at the rate of
Phi_2, by N = |lambda_1|.
"""

from __future__ import annotations

from rattle.elements.joints.prismatic import on_line
from rattle.interfaces.joints import JointKind
from rattle.interfaces.laws import TangentKind
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import position_row
from rattle.registry import Field, kind


@compiled
def rolling_row(body, a, b, p, k, c, row, rows):
    """Write the row u . d + r (phi_B - phi_A) - c = 0 [m]; p[k + 4:] = axis [rad], radius [m]."""
    radius = p[k + 5]
    rolled = c - radius * (body[b, at.PHI] - body[a, at.PHI])
    position_row(body, a, b, p, k, p[k + 4], rolled, 0.0, 0.0, row, rows)
    rows[row, at.AP] -= radius
    rows[row, at.BP] += radius


@kernel("joint")
def wheel(body, a, b, p, k, row, rows):
    """Write the rows of the wheel [m]; p[k + 4:] = axis [rad], radius [m], 1 if it does not slip, c [m]."""
    on_line(body, a, b, p, k, row, rows)
    rows[row, at.RES] -= p[k + 5]
    if p[k + 6] > 0.0:
        rolling_row(body, a, b, p, k, p[k + 7], row + 1, rows)


@kernel("joint")
def slipping(body, a, b, p, k, row, rows):
    """Write the row of the slip of the wheel over its line [m/s], with N = |lambda|."""
    rolling_row(body, a, b, p, k, 0.0, row, rows)
    rows[row, at.RES] = 0.0
    rows[row, at.NU] = 1.0


@kind("tangent", "slipping", slipping)
class Slipping(TangentKind):
    """Slip of a wheel over its line, on which friction acts.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5.
    """

    unit = "N"


@kind("joint", "wheel", wheel)
class Wheel(JointKind):
    """A wheel about a point of B rolls on a line of A without slip, held on both sides; with friction it may slip.

    Source: Nikravesh, Planar Multibody Dynamics (2018), disc.
    """

    rows = ("m", "m")
    placing = 1
    places = False
    moment = True
    presses = True
    from_start = 1
    rubs = True
    tangents = ("slipping",)
    drawn_as = "wheel"
    lifting = ("surface", {"radius": "roller"})  # it may lift off its line
    axis = Field("rad", "direction of the line in A's frame; the wheel is on its left", default=0.0)
    radius = Field("m", "radius of the wheel on B", least="positive")
