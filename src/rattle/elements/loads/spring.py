"""Spring and damper along the line between two points.

F = stiffness (l - free_length) + damping l'      pulls the points together if positive      [N]
tension_only: max(0, F) where l > free_length, else 0; where the damper takes all of F, what is stored is lost

Along d this is (F/l) d = (stiffness (1 - free_length/l) + damping d.d'/l^2) d, which has no singular point without
free length and damping.  Ends that coincide part along d'; if they rest too, d has no direction and F acts on nothing.
"""

from __future__ import annotations

import math

from rattle.interfaces.loads import LoadKind, LoadRecord, OneSided
from rattle.jit import layout as at
from rattle.jit.choices import TINY, assume, select
from rattle.jit.functions import kernel
from rattle.jit.geometry import AHEAD, COINCIDENT, ends
from rattle.registry import Field, kind

PULL = "stiffness*(length - free_length) + damping*rate"

SLACK = f"(0 if {PULL} > 0 else 1) if length > free_length else 1"


@kernel("load")
def spring(t, body, a, b, p, k, force, energy):
    """Add F [N] on both bodies, the energy stored [J] and dissipated [W]; p[k:] = two points [m], then the fields.

    The last of them is 1 while a spring that only pulls is slack, else 0.
    """
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    stiffness, free_length, damping, slack = p[k + 4], p[k + 5], p[k + 6], p[k + 7]
    assume(dx * dx + dy * dy >= TINY * (free_length + damping * damping * (ddx * ddx + ddy * ddy)))
    dx, dy = dx + AHEAD * ddx, dy + AHEAD * ddy
    square, opening = dx * dx + dy * dy, dx * ddx + dy * ddy  # l^2, l l'
    length = math.sqrt(square)
    elastic = stiffness * (1.0 - free_length / (length + COINCIDENT))
    viscous = damping * opening / (square + TINY)
    stretch, taut = length - free_length, 1.0 - slack
    fx, fy = taut * (elastic + viscous) * dx, taut * (elastic + viscous) * dy
    force[a, at.X] += fx
    force[a, at.Y] += fy
    force[a, at.PHI] += sax * fy - say * fx
    force[b, at.X] -= fx
    force[b, at.Y] -= fy
    force[b, at.PHI] -= sbx * fy - sby * fx
    lost = slack * select(stretch > 0.0, 1.0, 0.0)  # it is stretched, and the damper takes all of the force
    energy[at.POTENTIAL] += 0.5 * stiffness * (taut + lost) * select(free_length > 0.0, stretch * stretch, square)
    energy[at.ELASTIC] -= (taut + lost) * elastic * opening
    energy[at.DISSIPATED] += (taut * viscous - lost * elastic) * opening


@kind("load", "spring", spring)
class Spring(LoadKind):
    """A spring and damper along the line between two points.

    Source: definition.
    """

    drawn_as = "spring"
    record = LoadRecord("length", "N", PULL, -1.0, OneSided("tension_only", SLACK))
    connect = Field("", "its two ends", shape="connect")
    stiffness = Field("N/m", "force per elongation", live=True)
    free_length = Field("m", "length without force", default=0.0, least="not negative", live=True)
    damping = Field("N*s/m", "force per rate of elongation", default=0.0, live=True)
    tension_only = Field(
        "", "it never pushes, as a cord: no force while it is shorter than free_length", default=False, shape="flag"
    )
