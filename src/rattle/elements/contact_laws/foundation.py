"""Static force of a round pin on an elastic foundation: springs side by side, which do not feel each other.

p = K_w (e cos theta - c) where that is positive, e = c + delta, cos theta_0 = c/e:

    F = R L K_w c (theta_0/cos theta_0 - sin theta_0)      = R L K_w c (2/3) (2 delta/c)^1.5 for small delta
"""

from __future__ import annotations

import math

from rattle.elements.contact_laws.stiffness import BUSH_RADIUS, LENGTH
from rattle.errors import InputError
from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import StiffnessLaw
from rattle.jit.choices import select
from rattle.jit.functions import kernel
from rattle.language.recorded import as_number
from rattle.registry import Field, kind

SMALL = 0.03  # half an angle of contact [rad] below which the closed form loses more than its series leaves out


@kernel("stiffness")
def bedded(delta, p, k):
    """Force [N] of `Foundation`: p[k:] = R L K_w [N/m], c [m]."""
    if delta <= 0.0:
        return 0.0
    c = p[k + 1]
    s = math.sqrt(delta * (2.0 * c + delta)) / (c + delta)  # sin theta_0
    theta = math.atan2(s * (c + delta), c)
    q = theta * theta
    series = p[k] * c * theta * q * (2.0 / 3.0 + q * (0.2 + q * (107.0 / 1260.0 + q * 779.0 / 22680.0)))
    return select(theta > SMALL, p[k] * (theta * (c + delta) - c * s), series)


@kind("stiffness", "foundation", bedded)
class Foundation(StiffnessLaw):
    """F = R L K_w c (theta_0/cos theta_0 - sin theta_0), cos theta_0 = c/(c + delta): a soft layer, or a worn bush.

    Range: a layer that is thin compared with the contact, R_A much larger than the clearance.
    Source: Johnson, Contact Mechanics (1985), section 4.3.
    """

    bush_radius = BUSH_RADIUS
    foundation = Field("Pa/m", "K_w, pressure per penetration", least="positive")
    length = LENGTH

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        play = as_number(values["clearance"])
        if not play > 0.0:
            raise InputError("an elastic foundation of a pin in a bush needs a clearance")
        radius, length, foundation = (as_number(values[key]) for key in ("bush_radius", "length", "foundation"))
        return radius * length * foundation, play
