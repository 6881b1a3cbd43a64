"""Bushing between two bodies: springs and dampers along two directions that turn with A, and for the angle.

e  = R_A^T d - (x, y), d from A's point to B's; (x, y) and angle: the offset                                        [m]
f  = -K e - C e', e' the rate that an observer on A sees;  force R_A f on B at its point, -R_A f on A at the same place
T  = -k (phi_B - phi_A - angle) - c (w_B - w_A) on B, -T on A                                                     [N*m]

Both forces act at one place, so momentum and angular momentum are kept, and all of K and k follow from one potential.
"""

from __future__ import annotations

from rattle.interfaces.loads import LoadKind, LoadQuantity
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import ends
from rattle.registry import Field, kind

ALONG = "((b.x - a.x)*cos(A.angle) + (b.y - a.y)*sin(A.angle))"
ACROSS = "((b.y - a.y)*cos(A.angle) - (b.x - a.x)*sin(A.angle))"
RATE_ALONG = f"((b.vx - a.vx)*cos(A.angle) + (b.vy - a.vy)*sin(A.angle) + A.omega*{ACROSS})"
RATE_ACROSS = f"((b.vy - a.vy)*cos(A.angle) - (b.vx - a.vx)*sin(A.angle) - A.omega*{ALONG})"
OWN_X = f"(stiffness.x*({ALONG} - offset.x) + damping.x*{RATE_ALONG})"
OWN_Y = f"(stiffness.y*({ACROSS} - offset.y) + damping.y*{RATE_ACROSS})"
TWIST = "stiffness.angle*(B.angle - A.angle - offset.angle) + damping.angle*(B.omega - A.omega)"


@kernel("load")
def bushing(t, body, a, b, p, k, force, energy):
    """Add force [N] and moment [N*m] on both bodies, the energy stored [J] and dissipated [W].

    p[k:] = two points [m], then stiffness, damping and offset along x, y and of the angle.
    """
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    cos, sin, turn = body[a, at.COS], body[a, at.SIN], body[a, at.W]
    along, across = cos * dx + sin * dy, cos * dy - sin * dx
    rate_x, rate_y = cos * ddx + sin * ddy + turn * across, cos * ddy - sin * ddx - turn * along
    x, y = along - p[k + 10], across - p[k + 11]
    twist, rate = body[b, at.PHI] - body[a, at.PHI] - p[k + 12], body[b, at.W] - turn
    own_x = -(p[k + 4] * x + p[k + 7] * rate_x)
    own_y = -(p[k + 5] * y + p[k + 8] * rate_y)
    moment = -(p[k + 6] * twist + p[k + 9] * rate)
    fx, fy = cos * own_x - sin * own_y, sin * own_x + cos * own_y
    force[a, at.X] -= fx
    force[a, at.Y] -= fy
    force[a, at.PHI] -= (sax + dx) * fy - (say + dy) * fx + moment  # at the point of B
    force[b, at.X] += fx
    force[b, at.Y] += fy
    force[b, at.PHI] += sbx * fy - sby * fx + moment
    energy[at.POTENTIAL] += 0.5 * (p[k + 4] * x * x + p[k + 5] * y * y + p[k + 6] * twist * twist)
    energy[at.ELASTIC] -= p[k + 4] * x * rate_x + p[k + 5] * y * rate_y + p[k + 6] * twist * rate
    energy[at.DISSIPATED] += p[k + 7] * rate_x * rate_x + p[k + 8] * rate_y * rate_y + p[k + 9] * rate * rate


@kind("load", "bushing", bushing)
class Bushing(LoadKind):
    """A bushing: springs and dampers along x and y of body A and for the angle, as of rubber between two parts.

    Source: definition.
    """

    drawn_as = "bushing"
    rests = True
    quantities = {
        "fx": LoadQuantity("N", f"sin(A.angle)*{OWN_Y} - cos(A.angle)*{OWN_X}"),
        "fy": LoadQuantity("N", f"0 - sin(A.angle)*{OWN_X} - cos(A.angle)*{OWN_Y}"),
        "torque": LoadQuantity("N*m", f"0 - ({TWIST})"),
    }
    connect = Field("", "bodies A and B at their points", shape="connect")
    stiffness = Field(
        "N/m", "along x and y of A, and of the angle", shape="triple", turning="N*m/rad", least="not negative",
        missing="needs stiffness = [x, y, angle] in N/m, N/m, N*m/rad",
    )  # fmt: skip
    damping = Field(
        "N*s/m", "the same of the rates", (0.0, 0.0, 0.0), shape="triple", turning="N*m*s/rad", least="not negative"
    )
    offset = Field(
        "m",
        "of B's point and B's angle in A, where it is without force",
        (0.0, 0.0, 0.0),
        shape="triple",
        turning="rad",
    )
