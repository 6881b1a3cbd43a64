"""The contact of a one-way clutch without memory: it has a rate but no gap.

w = s (w_B - w_A)     rate at which B overruns A [rad/s], the rate g' of the contact; the gap itself is always zero
m = -s, n = 0         its row is constant: g'' = s (alpha_B - alpha_A), gamma = 0; N drives B with the moment s N
"""

from __future__ import annotations

from rattle.elements.clutches import SENSE
from rattle.interfaces.contacts import ClutchKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.registry import kind


@kernel("clearance")
def overrunning(body, a, b, p, k, corner, row, kinematics):
    """Write the rate [rad/s] and the couple of the contact into its row."""
    sense = p[k + SENSE]
    kinematics[row, at.GAP] = 0.0
    kinematics[row, at.DGAP] = sense * (body[b, at.W] - body[a, at.W])
    kinematics[row, at.TURN] = -sense


@kind("clutch", "overrunning", overrunning)
class Overrunning(ClutchKind):
    """A moment in one sense, overrunning in the other, decided by the relative rate alone.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), one-way clutches.
    """
