"""Models without contacts: the clearance is ignored, or the pin always touches its bush."""

from __future__ import annotations

from rattle.interfaces.contacts import ContactKind
from rattle.registry import kind


@kind("contact", "ideal")
class Ideal(ContactKind):
    """The clearance is ignored: an ideal joint.

    Source: definition.
    """

    assumes = "The play is left out: both parts share one centre, as in a perfect bearing."


@kind("contact", "massless-link")
class MasslessLink(ContactKind):
    """The pin stays on the wall of the bush: a massless rigid link of length = clearance, which can push and pull.

    Its force N is positive if the pin presses on the wall; N < 0 means that the wall would have to
    pull, and every such interval is reported.

    Source: Grigore et al., Application to the motion and equilibrium of planar kinematic chains, section 1.
    """

    link = True
    assumes = (
        "The pin is taken to touch the wall of its bush all the time: a rigid link without mass, as long as the"
        " clearance, joins both centres.  It knows no impacts and no friction.  Where the wall would have to pull,"
        " a real pin would lift off and the model does not hold."
    )
