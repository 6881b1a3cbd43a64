"""Torsion spring and damper between two bodies.

T = stiffness (phi_B - phi_A - free_angle) + damping (w_B - w_A)      turns B back when positive
"""

from __future__ import annotations

from rattle.jit.functions import kernel
from rattle.jit.layout import DISSIPATED, ELASTIC, PHI, POTENTIAL, W
from rattle.registry import Field, kind


@kernel("load")
def torsion_spring(t, body, a, b, p, k, force, energy):
    stiffness, free_angle, damping = p[k + 4], p[k + 5], p[k + 6]
    rate = body[b, W] - body[a, W]
    twist = body[b, PHI] - body[a, PHI] - free_angle
    moment = stiffness * twist + damping * rate
    force[a, PHI] += moment
    force[b, PHI] -= moment
    energy[POTENTIAL] += 0.5 * stiffness * twist * twist
    energy[ELASTIC] -= stiffness * twist * rate
    energy[DISSIPATED] += damping * rate * rate


@kind("load", "torsion-spring", torsion_spring)
class TorsionSpring:
    """A torsion spring and damper between two bodies.

    Source: definition.
    """

    connect = Field("", "the two bodies, or points of them", shape="connect")
    stiffness = Field("N*m/rad", "moment per twist", live=True)
    free_angle = Field("rad", "angle phi_B - phi_A without moment", default=0.0, live=True)
    damping = Field("N*m*s/rad", "moment per rate of twist", default=0.0, live=True)
