"""Force at a point of a body, given in the ground frame or in the frame of the body."""

from __future__ import annotations

from rattle.interfaces.loads import LoadKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import turn_x, turn_y
from rattle.registry import Field, kind


@kernel("load")
def force_at(t, body, a, b, p, k, force, energy):
    """Add the force [N] and its moment [N*m] on body b, and its power [W]; p[k:] = point (2) [m], f (2) [N], frame."""
    sx = turn_x(body, b, p[k], p[k + 1])
    sy = turn_y(body, b, p[k], p[k + 1])
    fx, fy = p[k + 2], p[k + 3]
    if p[k + 4] == 1.0:  # given in the frame of the body
        fx, fy = turn_x(body, b, fx, fy), turn_y(body, b, fx, fy)
    force[b, at.X] += fx
    force[b, at.Y] += fy
    force[b, at.PHI] += sx * fy - sy * fx
    energy[at.OUTSIDE] += fx * (body[b, at.VX] - body[b, at.W] * sy) + fy * (body[b, at.VY] + body[b, at.W] * sx)


@kind("load", "force", force_at)
class Force(LoadKind):
    """A force at a point of a body.

    Source: definition.
    """

    at = Field("", "point at which the force acts", shape="point")
    force = Field("N", "force [fx, fy]", shape="pair", live=True)
    frame = Field("", "frame of fx, fy", shape="choice", choices=("ground", "body"), default="ground")
