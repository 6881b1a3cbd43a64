"""Motor between two bodies: the housing A and the rotor B.

moment +T on B, -T on A, counter-clockwise positive   [N*m];    power T (w_B - w_A) from outside   [W]
"""

from __future__ import annotations

from rattle.interfaces.loads import LoadKind, LoadRecord
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.registry import Field, LocalName, kind


@kernel("load")
def motor(t, body, a, b, p, k, force, energy):
    """Add T [N*m] on both bodies and its power [W]; p[k + 4] = T."""
    force[a, at.PHI] -= p[k + 4]
    force[b, at.PHI] += p[k + 4]
    energy[at.OUTSIDE] += p[k + 4] * (body[b, at.W] - body[a, at.W])


@kind("load", "motor", motor)
class Motor(LoadKind):
    """A moment between two bodies, on the rotor and back on the housing, such as a motor's line of torque over speed.

    Source: definition.
    """

    record = LoadRecord("angle", "N*m", "torque", 1.0)
    connect = Field("", "housing and rotor: two bodies, or points of them", shape="connect", turns=True)
    torque = Field(
        "N*m",
        "moment on the rotor",
        live=True,
        local=(LocalName("speed", "rad/s", "rate of the rotor relative to the housing", "B.omega - A.omega"),),
    )
