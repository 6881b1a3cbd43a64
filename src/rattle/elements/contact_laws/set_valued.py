"""Set-valued contact: no penetration, restitution at impacts, Coulomb friction with true sticking.

g >= 0, N >= 0, g N = 0;     impact (newton): u_n+ = -e_N u_n-, u_t+ = -e_T u_t- within |P_t| <= mu P_n
                                    (poisson):  P_n of expansion = e_N that of compression
                                    (energetic): work of P_n in expansion = -e_N^2 that in compression
                                    (lzb): the same, P_n of several contacts growing as forces K delta^n of theirs
"""

from __future__ import annotations

from rattle.interfaces.contacts import ContactKind
from rattle.interfaces.fields import absent
from rattle.registry import Field, kind


@kind("contact", "impact")
class Impact(ContactKind):
    """No penetration; restitution at impacts, Coulomb friction with true sticking; modes: flight, impact, contact.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996); Leine, Nijmeijer, Dynamics and
    Bifurcations of Non-Smooth Mechanical Systems (2004).
    """

    contacts = True
    shares_by_stiffness = "lzb"
    assumes = (
        "Both parts are rigid and never overlap.  They fly, collide and slide: a collision takes no time and returns"
        " the given share of the approach speed, so that there are impulses but no peak forces of collisions; between"
        " collisions dry friction truly sticks."
    )
    restitution = Field("", "normal restitution e_N, 0 to 1", default=0.0, least="not negative")
    tangential_restitution = Field("", "tangential restitution e_T, 0 to 1", default=0.0, least="not negative")
    friction = Field("", "coefficient of friction mu", default=0.0, least="not negative")
    restitution_law = Field(
        "",
        "ratio of velocities (newton), of impulses (poisson) or of work (energetic: never creates energy); of work,"
        " shared among all contacts by their stiffness (lzb)",
        default="newton",
        shape="choice",
        choices=("newton", "poisson", "energetic", "lzb"),
    )
    jam = Field(
        "",
        "if friction locks (Painleve): stop the run, or continue by an impact without collision (impact)",
        default="stop",
        shape="choice",
        choices=("stop", "impact"),
    )
    stiffness = Field("", "K [N/m^n]; of a rigid contact by its ratio to others, with lzb", absent, least="positive")
    exponent = Field("", "exponent n of the force K delta^n; of a rigid contact with lzb", 1.5, least="positive")
