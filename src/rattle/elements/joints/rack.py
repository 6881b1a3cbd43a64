"""Rack and pinion: a pitch circle of B rolls on a line of A, its pitch line.

u = direction of the line (fixed in A), n = u turned by 90 degrees, d = (r_B + s_B) - (r_A + s_A)
Phi   = u . d - R (phi_B - phi_A) - c = 0                                                     [m]
gamma = u . (s_B w_B^2 - s_A w_A^2) - 2 w_A (n . d') + w_A^2 (u . d)                          [m/s^2]

The centre of the pinion is on the side -n of the line, to the right as seen along u: there it rolls along u when it
turns in the positive sense.  The axis of a road under wheels is 180 degrees.
"""

from __future__ import annotations

from rattle.elements.joints import mesh
from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import Fit, JointKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import position_row
from rattle.registry import Field, kind


@kernel("joint")
def rack(body, a, b, p, k, row, rows):
    """Write the row of the rack [m]; p[k + 4:] = axis [rad], radius [m], c [m]."""
    radius = p[k + 5]
    rolled = radius * (body[b, at.PHI] - body[a, at.PHI]) + p[k + 6]
    position_row(body, a, b, p, k, p[k + 4], rolled, 0.0, 0.0, row, rows)
    rows[row, at.AP] += radius
    rows[row, at.BP] -= radius


@kind("joint", "rack", rack)
class Rack(JointKind):
    """A pinion about a point of B on a rack along a line of A; also a wheel that rolls on a straight road.

    Source: Nikravesh, Planar Multibody Dynamics (2018), disc.
    """

    rows = ("m",)
    rubs = True
    rubs_with = mesh.TEETH
    tangents = ("turning",)
    places = False
    moment = True
    from_start = 1
    drawn_as = "rack"
    axis = Field("rad", "direction of the pitch line in A's frame", default=0.0)
    radius = Field("m", "pitch radius of the pinion on B", least="positive")

    @staticmethod
    def friction_arm(fields: Fields, own: Fields) -> float:
        """That of the teeth [m]."""
        size = (own["module"], own["pressure_angle"])
        return mesh.arm(mesh.straight(*size), mesh.wheel(fields["radius"], *size), own)

    @staticmethod
    def fit(fields: Fields) -> Fit:
        """The pitch line touches the pitch circle, whose centre is on its side -n."""
        words = (
            "its pitch radius needs a distance of the pinion's centre from the line, to the right along `axis`, of {}"
        )
        return Fit(fields["radius"], fields["axis"], words, needed=False)
