"""Torsion spring and damper between two bodies.

T = stiffness (phi_B - phi_A - free_angle) + damping (w_B - w_A)      acts on B backwards (clockwise) when positive
"""

from __future__ import annotations

from rattle.interfaces.loads import LoadKind, LoadRecord
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.registry import Field, kind


@kernel("load")
def torsion_spring(t, body, a, b, p, k, force, energy):
    """Add T [N*m] on both bodies, the energy stored [J] and dissipated [W]; p[k + 4:] = the fields in their order."""
    stiffness, free_angle, damping = p[k + 4], p[k + 5], p[k + 6]
    rate = body[b, at.W] - body[a, at.W]
    twist = body[b, at.PHI] - body[a, at.PHI] - free_angle
    moment = stiffness * twist + damping * rate
    force[a, at.PHI] += moment
    force[b, at.PHI] -= moment
    energy[at.POTENTIAL] += 0.5 * stiffness * twist * twist
    energy[at.ELASTIC] -= stiffness * twist * rate
    energy[at.DISSIPATED] += damping * rate * rate


@kind("load", "torsion-spring", torsion_spring)
class TorsionSpring(LoadKind):
    """A torsion spring and damper between two bodies.

    Source: definition.
    """

    drawn_as = "torsion-spring"
    record = LoadRecord("angle", "N*m", "stiffness*(angle - free_angle) + damping*rate", -1.0)
    connect = Field("", "the two bodies, or points of them", shape="connect")
    stiffness = Field("N*m/rad", "moment per twist", live=True)
    free_angle = Field("rad", "angle phi_B - phi_A without moment", default=0.0, live=True)
    damping = Field("N*m*s/rad", "moment per rate of twist", default=0.0, live=True)
