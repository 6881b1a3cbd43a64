"""Revolute joint: two bodies share a point and turn freely about it.

d     = (r_B + s_B) - (r_A + s_A)
Phi   = d = 0                                   [m, m]
gamma = s_B w_B^2 - s_A w_A^2                   [m/s^2]
"""

from __future__ import annotations

from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import JointKind, Motor
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import ends
from rattle.registry import Field, kind


@kernel("joint")
def revolute(body, a, b, p, k, row, rows):
    """Write the two rows of the joint [m, m]."""
    sax, say, sbx, sby, dx, dy, _, _ = ends(body, a, b, p, k)
    wa = body[a, at.W] * body[a, at.W]
    wb = body[b, at.W] * body[b, at.W]

    rows[row, at.RES] = dx
    rows[row, at.NU] = 0.0
    rows[row, at.GAMMA] = sbx * wb - sax * wa
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -1.0, 0.0, say
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = 1.0, 0.0, -sby

    row += 1
    rows[row, at.RES] = dy
    rows[row, at.NU] = 0.0
    rows[row, at.GAMMA] = sby * wb - say * wa
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = 0.0, -1.0, -sax
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = 0.0, 1.0, sbx


@kind("joint", "revolute", revolute)
class Revolute(JointKind):
    """Two bodies share a point and turn freely about it.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.3.
    """

    rows = ("m", "m")
    rows_in_ground = True
    motor = Motor("angle", "torque", "N*m")
    coordinate = "angle"
    massless = "rod"
    rubs = True
    rubs_with = {
        "pin_radius": Field("m", "radius of the pin: mu times the reaction times it is the moment", least="positive")
    }
    drawn_as = "pin"

    @staticmethod
    def friction_arm(fields: Fields, own: Fields) -> float:
        """The radius of the pin [m]."""
        return own["pin_radius"]
