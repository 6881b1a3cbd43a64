"""Spring and damper along the line between two points.

F = stiffness (l - free_length) + damping l'      pulls the points together if positive      [N]
"""

from __future__ import annotations

import math

from rattle.interfaces.loads import LoadKind, LoadRecord
from rattle.jit import layout as at
from rattle.jit.choices import assume
from rattle.jit.functions import kernel
from rattle.jit.geometry import COINCIDENT, ends
from rattle.registry import Field, kind


@kernel("load")
def spring(t, body, a, b, p, k, force, energy):
    """Add F [N] on both bodies, the energy stored [J] and dissipated [W]; p[k:] = two points [m], then the fields."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    stiffness, free_length, damping = p[k + 4], p[k + 5], p[k + 6]
    length = math.sqrt(dx * dx + dy * dy)
    inv = 1.0 / length if assume(length > COINCIDENT) else 0.0  # coincident ends: no direction, no force
    nx, ny = dx * inv, dy * inv
    rate = nx * ddx + ny * ddy
    stretch = length - free_length
    pull = stiffness * stretch + damping * rate
    fx, fy = pull * nx, pull * ny
    force[a, at.X] += fx
    force[a, at.Y] += fy
    force[a, at.PHI] += sax * fy - say * fx
    force[b, at.X] -= fx
    force[b, at.Y] -= fy
    force[b, at.PHI] -= sbx * fy - sby * fx
    energy[at.POTENTIAL] += 0.5 * stiffness * stretch * stretch
    energy[at.ELASTIC] -= stiffness * stretch * rate
    energy[at.DISSIPATED] += damping * rate * rate


@kind("load", "spring", spring)
class Spring(LoadKind):
    """A spring and damper along the line between two points.

    Source: definition.
    """

    drawn_as = "spring"
    record = LoadRecord("length", "N", "stiffness*(length - free_length) + damping*rate", -1.0)
    connect = Field("", "its two ends", shape="connect")
    stiffness = Field("N/m", "force per elongation", live=True)
    free_length = Field("m", "length without force", default=0.0, least="not negative", live=True)
    damping = Field("N*s/m", "force per rate of elongation", default=0.0, live=True)
