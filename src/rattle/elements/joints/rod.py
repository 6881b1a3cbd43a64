"""Rod: a massless rigid link of length L between a point of A and a point of B; with stops in its place, a rope.

    d = (r_B + s_B) - (r_A + s_A),  n = d / |d|
    Phi   = |d| - L = 0                                                                  [m]
    gamma = -(|d'|^2 - (n . d')^2) / |d| + n . (s_B w_B^2 - s_A w_A^2)                   [m/s^2]

A pin that stays in contact with its bush is such a rod, L = radial clearance (the paper, section 1).

With friction in its pins, of radius R, the moments tau_A and tau_B against its turning about them, psi' - w_A and
w_B - psi', psi the direction of d, need a shear: without mass, the forces S along the rod and (tau_A - tau_B)/L across
it balance both moments.  What presses on both pins is

    N = hypot(S, (tau_A - tau_B)/L),      |tau| <= mu R N

These are the equations of a body without mass between two revolute joints.

Without a length it has no row: its stops hold the points at a least and a largest distance, see the stop `distance`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from rattle.elements.wrapped import write_turning
from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import JointKind
from rattle.interfaces.laws import TangentKind
from rattle.jit import layout as at
from rattle.jit.choices import assume
from rattle.jit.functions import kernel
from rattle.jit.geometry import COINCIDENT, ends
from rattle.registry import Field, kind


@kernel("joint")
def rod(body, a, b, p, k, row, rows):
    """Write the row of the rod [m]; p[k + 4] = length [m]."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb = body[a, at.W], body[b, at.W]
    d = math.sqrt(dx * dx + dy * dy)
    # coincident ends have no direction: any one does, and the residual -L then moves them apart
    apart = assume(d > COINCIDENT)
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


@kernel("joint")
def turning_on_a(body, a, b, p, k, row, rows):
    """Write the row of psi' - w_A [rad/s], with 1/L."""
    write_turning(body, a, b, p, k, -1.0, 0.0, 0.0, row, rows)
    rows[row, at.NU] = 1.0 / p[k + 4]


@kernel("joint")
def turning_under_b(body, a, b, p, k, row, rows):
    """Write the row of w_B - psi' [rad/s], with 1/L."""
    write_turning(body, a, b, p, k, 0.0, 1.0, 0.0, row, rows)
    rows[row, at.NU] = 1.0 / p[k + 4]


@kind("tangent", "pin-on-a", turning_on_a)
class PinOnA(TangentKind):
    """Turning of a rod about its pin on A.

    Source: Meriam, Kraige, Engineering Mechanics: Statics, section 6/6 (journal bearings).
    """

    unit = "N*m"


@kind("tangent", "pin-on-b", turning_under_b)
class PinOnB(TangentKind):
    """Turning of B on the pin of a rod.

    Source: Meriam, Kraige, Engineering Mechanics: Statics, section 6/6 (journal bearings).
    """

    unit = "N*m"


@kind("joint", "rod", rod)
class Rod(JointKind):
    """A massless rigid link of given length between two points; with stops in place of a length, a rope.

    Source: Grigore et al., Application to the motion and equilibrium of planar kinematic chains, section 1.
    """

    rows = ("m",)
    rubs = True
    rubs_with = {
        "pin_radius": Field("m", "radius of both pins: mu times the force times it is the moment", least="positive")
    }
    tangents = ("pin-on-a", "pin-on-b")
    drawn_as = "rod"
    stops = "distance"
    length = Field("m", "length of the rod; without it stops hold its points", default=math.inf, least="positive")

    @staticmethod
    def faults(written: Mapping[str, object], fields: Fields) -> Iterable[tuple[str, str]]:
        """It has either a length or stops."""
        if "length" in written and "stop" in written:
            yield "stop", "a rod of one length has no stop; for a rope, or a strut that closes up, leave out the length"
        elif "length" not in written and "stop" not in written:
            yield "", "needs length: length of the rod [m]; of a rope stop = { max = ... } instead"
        elif "length" not in written and "friction" in written:
            yield "friction", "a rod without length, which its stops hold, has no friction"

    @staticmethod
    def held_by_stops(fields: Fields) -> bool:
        """True of a rope."""
        return fields["length"] == math.inf

    @staticmethod
    def held_at(value: float) -> dict[str, float]:
        """A rod of that length."""
        return {"length": value}

    @staticmethod
    def friction_arm(fields: Fields, own: Fields) -> float:
        """The radius of the pins [m]."""
        return own["pin_radius"]

    @staticmethod
    def distance(fields: Fields) -> float:
        """The given length [m]; 0 of a rope, which enforces none."""
        return 0.0 if Rod.held_by_stops(fields) else fields["length"]
