"""The contact of a ratchet: a pawl on A behind a tooth of B.

g = k p + s (phi_B - phi_A)     gap [rad], pitch p = 2 pi/teeth, g' = s (w_B - w_A), gamma = 0
m = -s, n = 0                   N drives B with the moment s N

k [-] is a memory: it falls by one where g reaches p, and the pawl drops behind the next tooth.  At the start of a run
it is such that 0 <= g < p: with equal angles the pawl is at a tooth.

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2, gaps of angles.
"""

from __future__ import annotations

from collections.abc import Sequence

from rattle.elements.clutches import SENSE
from rattle.interfaces.contacts import ClutchKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.registry import kind


@kernel("clearance")
def ratchet(body, a, b, p, k, corner, row, kinematics):
    """Write gap [rad], its rate [rad/s] and the couple of the contact into its row."""
    sense = p[k + SENSE]
    turned = sense * (body[b, at.PHI] - body[a, at.PHI])
    kinematics[row, at.GAP] = p[k + at.TOOTH] * p[k + at.PITCH] + turned
    kinematics[row, at.DGAP] = sense * (body[b, at.W] - body[a, at.W])
    kinematics[row, at.TURN] = -sense


@kind("clutch", "ratchet", ratchet)
class Ratchet(ClutchKind):
    """A moment in one sense from tooth to tooth, with lost motion of up to a pitch.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The pitch."""
        return p[at.PITCH]
