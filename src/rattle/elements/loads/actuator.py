"""Actuator along the line between two points: a hydraulic cylinder, a linear motor.

n = d/|d|, d from A's point to B's;  force F n on B, -F n on A                 pushes the points apart if positive  [N]
power F l', l = |d|, from outside                                                                                   [W]
"""

from __future__ import annotations

from rattle.interfaces.loads import LoadKind, LoadRecord
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import ends, line_of
from rattle.registry import Field, kind


@kernel("load")
def actuator(t, body, a, b, p, k, force, energy):
    """Add F [N] on both bodies and its power [W]; p[k:] = two points [m], F."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    nx, ny, _length = line_of(dx, dy, ddx, ddy)  # zero where the ends coincide and rest: no direction, no force
    fx, fy = p[k + 4] * nx, p[k + 4] * ny
    force[a, at.X] -= fx
    force[a, at.Y] -= fy
    force[a, at.PHI] -= sax * fy - say * fx
    force[b, at.X] += fx
    force[b, at.Y] += fy
    force[b, at.PHI] += sbx * fy - sby * fx
    energy[at.OUTSIDE] += fx * ddx + fy * ddy


@kind("load", "actuator", actuator)
class Actuator(LoadKind):
    """A force along the line between two points, such as that of a cylinder.

    Source: definition.
    """

    drawn_as = "actuator"
    record = LoadRecord("length", "N", "force", 1.0)
    connect = Field("", "its two ends", shape="connect")
    force = Field("N", "force that pushes the ends apart", live=True)
