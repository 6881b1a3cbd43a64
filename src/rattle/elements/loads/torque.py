"""Torque: a moment on one body, counter-clockwise positive."""

from __future__ import annotations

from rattle.interfaces.loads import LoadKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.registry import Field, kind


@kernel("load")
def torque(t, body, a, b, p, k, force, energy):
    """Add the moment p[k] [N*m] on body b, and its power [W]."""
    force[b, at.PHI] += p[k]
    energy[at.OUTSIDE] += p[k] * body[b, at.W]


@kind("load", "torque", torque)
class Torque(LoadKind):
    """A moment on one body, counter-clockwise positive.

    Source: definition.
    """

    body = Field("", "body on which the moment acts", shape="body")
    torque = Field("N*m", "moment", live=True)
