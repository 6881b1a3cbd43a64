"""Gear pair: the pitch circles of two wheels roll on each other; their centres may move.

d = (r_B + s_B) - (r_A + s_A) from the centre of A to that of B,  l = |d|,  psi: direction of d,  p: d turned by 90 deg
wheel outside of A:  R = R_B,  S = R_A + R_B          inside of the ring A:  R = -R_B,  S = R_A - R_B

    Phi   = R_A phi_A + R phi_B - S psi - c = 0                                               [m]
    psi'' = (p . d'')/l^2 - 2 (d . d') (p . d')/l^4
    gamma = S (p . d0/l^2 - 2 (d . d') (p . d')/l^4),   d0 = s_A w_A^2 - s_B w_B^2           [m/s^2]

The line of centres stands for the carrier, so that a planet is one wheel outside of the sun and one inside of the ring.
psi is known up to whole turns only: the row is S times the angle from d to the direction theta = (R_A phi_A + R phi_B
- c)/S, between -180 and 180 deg, which has no jump near zero, whatever the number of turns.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from rattle.elements.joints import mesh
from rattle.elements.profile import degrees
from rattle.elements.wrapped import write_turning
from rattle.interfaces.fields import Fields, pair
from rattle.interfaces.joints import Fit, JointKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import ends
from rattle.language.recorded import least
from rattle.registry import Field, kind

PLAY = 0.5  # of the smaller radius, or of the distance in a ring: more backlash than any teeth have
SLACK = 0.2  # of the smaller radius by which centres may be farther or nearer: teeth of 10 would be out of mesh


@kernel("joint")
def gear(body, a, b, p, k, row, rows):
    """Write the row of the pair [m]; p[k + 4:] = R_A, R_B [m], 1 for a wheel inside of A, two of teeth, c [m]."""
    _, _, _, _, dx, dy, _, _ = ends(body, a, b, p, k)
    ra, rb = p[k + 4], p[k + 5] * (1.0 - 2.0 * p[k + 6])
    s = ra + rb
    theta = (ra * body[a, at.PHI] + rb * body[b, at.PHI] - p[k + 9]) / s
    cos, sin = math.cos(theta), math.sin(theta)
    residual = s * math.atan2(sin * dx - cos * dy, cos * dx + sin * dy)
    write_turning(body, a, b, p, k, ra, rb, residual, row, rows)


@kind("joint", "gear", gear)
class Gear(JointKind):
    """Two toothed wheels, or a wheel in a ring A, about the points of `connect`; with `contact`, involute flanks.

    Source: Willis, Principles of Mechanism (1841), part I, ch. 9; Nikravesh, Planar Multibody Dynamics (2018), gears.
    """

    rows = ("m",)
    rubs = True
    rubs_with = mesh.TEETH
    tangents = ("turning",)
    places = False
    moment = True
    from_start = 1
    drawn_as = "gear"
    radii = Field("m", "pitch radii of the wheels on A and B", shape="pair", least="positive")
    internal = Field("", "A is a ring with B inside", default=False, shape="flag")
    pressure_angle = Field(
        "rad", "of involute teeth, which need a contact: two flanks that push, whose centres may move",
        default=0.0, least="not negative",
    )  # fmt: skip
    backlash = Field(
        "m", "play along the normal of the teeth where the pitch circles touch", default=0.0, least="not negative"
    )

    @staticmethod
    def fit(fields: Fields) -> Fit:
        """The pitch circles touch: centres at the sum of the radii, or at their difference."""
        (ra, rb), ring = pair(fields, "radii"), fields["internal"]
        slack = SLACK * least(ra, rb) if fields["pressure_angle"] > 0.0 else 0.0
        words = f"its pitch radii of {ra:.9g} m and {rb:.9g} m need a distance of the centres of {{}}"
        return Fit(ra - rb if ring else ra + rb, None, words, slack=slack)

    @staticmethod
    def friction_arm(fields: Fields, own: Fields) -> float:
        """That of the teeth [m]."""
        (ra, rb), size = pair(fields, "radii"), (own["module"], own["pressure_angle"])
        first = mesh.ring(ra, *size) if fields["internal"] else mesh.wheel(ra, *size)
        return mesh.arm(first, mesh.wheel(rb, *size), own)

    @staticmethod
    def faults(written: Mapping[str, object], fields: Fields) -> Iterator[tuple[str, str]]:
        """Teeth with flanks are contacts with a pressure angle."""
        angle, contact = fields["pressure_angle"], "contact" in written
        if "pressure_angle" in written and not 0.0 < angle <= mesh.STEEPEST:
            yield (
                "pressure_angle",
                f"{degrees(angle)} is outside of 0 to {degrees(mesh.STEEPEST)}; teeth have 20 deg, for example",
            )
        if contact and "pressure_angle" not in written:
            yield "contact", 'needs pressure_angle, the direction in which the flanks push, as "20 deg"'
        for key in ("pressure_angle", "backlash"):
            if key in written and not contact:
                yield (
                    key,
                    (
                        'needs a contact, as contact = "impact": the flanks only push; leave it out for a pair'
                        " whose pitch circles roll without play and without separating force"
                    ),
                )

    @staticmethod
    def fault(fields: Fields) -> str:
        """A wheel has to be smaller than its ring, and the backlash smaller than teeth."""
        ra, rb = pair(fields, "radii")
        if fields["internal"] and rb >= ra:
            return (
                f"radii: the wheel inside, {rb:g} m, must be smaller than its ring, {ra:g} m;"
                " the ring is A, the first in `connect` and `radii`"
            )
        most = PLAY * least(rb, abs(ra - rb) if fields["internal"] else ra)
        if fields["backlash"] > most:
            return f"backlash: {fields['backlash']:g} m is more than between teeth of these wheels, {most:.3g} m"
        return ""
