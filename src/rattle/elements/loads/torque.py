"""Torque: a moment on one body, counter-clockwise positive."""

from __future__ import annotations

from rattle.jit.functions import kernel
from rattle.jit.layout import OUTSIDE, PHI, W
from rattle.registry import Field, kind


@kernel("load")
def torque(t, body, a, b, p, k, force, energy):
    force[b, PHI] += p[k]
    energy[OUTSIDE] += p[k] * body[b, W]


@kind("load", "torque", torque)
class Torque:
    """A moment on one body, counter-clockwise positive.

    Source: definition.
    """

    body = Field("", "body the moment acts on", shape="body")
    torque = Field("N*m", "moment", live=True)
