"""Fixed joint: two bodies share a point and keep their relative angle, as if welded.

d     = (r_B + s_B) - (r_A + s_A)
Phi   = d, phi_B - phi_A - angle = 0            [m, m, rad]
gamma = s_B w_B^2 - s_A w_A^2, 0                [m/s^2, m/s^2, rad/s^2]
"""

from __future__ import annotations

from rattle.elements.joints.revolute import revolute
from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import JointKind
from rattle.jit.functions import kernel
from rattle.jit.geometry import angle_row
from rattle.registry import Field, kind


@kernel("joint")
def fixed(body, a, b, p, k, row, rows):
    """Write the three rows of the joint [m, m, rad]; p[k + 4] = angle [rad]."""
    revolute(body, a, b, p, k, row, rows)
    angle_row(body, a, b, p[k + 4], 0.0, 0.0, row + 2, rows)


@kind("joint", "fixed", fixed)
class Fixed(JointKind):
    """Two bodies share a point and keep their relative angle, as if welded.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.2.
    """

    rows = ("m", "m", "rad")
    rows_in_ground = True
    moment = True
    drawn_as = "weld"
    angle = Field("rad", "angle of B relative to A", default=0.0)

    @staticmethod
    def kept_angle(fields: Fields) -> float:
        """The given angle [rad]."""
        return fields["angle"]
