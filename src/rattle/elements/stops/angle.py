"""Stops of an angle: the moment of a hinge whose B has turned to its least or largest angle relative to A.

phi = phi_B - phi_A                                                       [rad], continuous over any number of turns
g_0 = phi - min,  g_1 = max - phi                                         gaps [rad]
m_0 = -1,         m_1 = +1                                                couple, n = 0: -g' = m (w_B - w_A)
gamma = 0                                                                 [rad/s^2]

The moment on B is -N m: +N at the least angle, -N at the largest.
"""

from __future__ import annotations

import math

from rattle.elements.stops import LARGEST, LEAST
from rattle.interfaces.contacts import StopKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.registry import Field, kind


@kernel("clearance")
def stop_angle(body, a, b, p, k, corner, row, kinematics):
    """Write gap [rad], its rate [rad/s] and the couple of the normal of one end into its row."""
    phi, rate = body[b, at.PHI] - body[a, at.PHI], body[b, at.W] - body[a, at.W]
    turn = -1.0 if corner == 0 else 1.0
    kinematics[row, at.GAP] = phi - p[k + LEAST] if corner == 0 else p[k + LARGEST] - phi
    kinematics[row, at.DGAP] = -turn * rate
    kinematics[row, at.TURN] = turn


@kind("stop", "angle", stop_angle)
class StopAngle(StopKind):
    """The angle of B relative to A stays between two ends.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    angular = True
    min = Field("rad", "least angle of B relative to A", default=-math.inf)
    max = Field("rad", "largest angle of B relative to A", default=math.inf)
