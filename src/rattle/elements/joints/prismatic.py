"""Prismatic joint: a point of B slides along a line fixed in A; B keeps its angle relative to A.

u = direction of the line (fixed in A), n = u turned by 90 degrees, d = (r_B + s_B) - (r_A + s_A)
Phi_1   = n . d = 0                                                         [m]
Phi_2   = phi_B - phi_A - angle = 0                                         [rad]
gamma_1 = n . (s_B w_B^2 - s_A w_A^2) + 2 w_A (u . d') + w_A^2 (n . d)      [m/s^2]
gamma_2 = 0                                                                 [rad/s^2]
"""

from __future__ import annotations

from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import JointKind, Motor
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import angle_row, direction, ends
from rattle.registry import Field, kind


@compiled
def on_line(body, a, b, p, k, row, rows):
    """Write the row n . d = 0 [m]: the point of B is on the line through the point of A; p[k + 4] = axis [rad]."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    ux, uy = direction(body, a, p[k + 4])
    nx, ny = -uy, ux
    wa, wb = body[a, at.W], body[b, at.W]

    rows[row, at.RES] = nx * dx + ny * dy
    rows[row, at.NU] = 0.0
    rows[row, at.GAMMA] = (
        nx * (sbx * wb * wb - sax * wa * wa)
        + ny * (sby * wb * wb - say * wa * wa)
        + 2.0 * wa * (ux * ddx + uy * ddy)
        + wa * wa * (nx * dx + ny * dy)
    )
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -nx, -ny, nx * say - ny * sax - ux * dx - uy * dy
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = nx, ny, ny * sbx - nx * sby


@kernel("joint")
def prismatic(body, a, b, p, k, row, rows):
    """Write the two rows of the joint [m, rad]; p[k + 4:] = axis, angle [rad]."""
    on_line(body, a, b, p, k, row, rows)
    angle_row(body, a, b, p[k + 5], 0.0, 0.0, row + 1, rows)


@kind("joint", "prismatic", prismatic)
class Prismatic(JointKind):
    """A point of B slides along a line fixed in A; B keeps its angle relative to A.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.3.
    """

    rows = ("m", "rad")
    moment = True
    motor = Motor("position", "thrust", "N")
    coordinate = "position"
    drawn_as = "guide"
    rubs = True
    axis = Field("rad", "direction of the line in A's frame", default=0.0)
    angle = Field("rad", "angle of B relative to A (default: equal to axis)", default=lambda fields: fields["axis"])

    @staticmethod
    def kept_angle(fields: Fields) -> float:
        """The given angle [rad]."""
        return fields["angle"]

    @staticmethod
    def line(fields: Fields) -> float:
        """The given angle [rad]."""
        return fields["axis"]
