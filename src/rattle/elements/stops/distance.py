"""Stops of a distance: the force along a rope, or between two points that keep a least distance.

d = (r_B + s_B) - (r_A + s_A),  L = |d|,  u = d / L,  v = u x d' (the speed across)
g_0 = L - min,  g_1 = max - L                                             gaps [m]
n_0 = -u,       n_1 = +u                                                  at the points of A and B
gamma = -+ (n . (s_B w_B^2 - s_A w_A^2) - v^2 / L) with +u for n          [m/s^2], + at the largest distance

At the largest distance B moves as a pin in a bush of that clearance, at the least one outside a round of that radius:

    L'' = u . d'' + v^2 / L,  so that  g_1'' <= |d''|  and  g_0'' <= |d''| + |d'|^2 / min  as long as L >= min

A point that comes nearer than min between two samples, dt apart, cannot leave both of them farther than min by more
than (|d''| + |d'|^2 / min) dt^2 / 8, although L bends more inside: the chord of its way passes through that circle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.elements.stops import LARGEST, LEAST
from rattle.interfaces.contacts import StopKind
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import kernel
from rattle.jit.geometry import COINCIDENT, ends
from rattle.registry import Field, kind


@kernel("clearance")
def stop_distance(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m], speed across [m/s] and gamma [m/s^2] of one end into its row."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb = body[a, at.W], body[b, at.W]
    length = math.sqrt(dx * dx + dy * dy)
    apart = length > COINCIDENT
    inv = select(apart, 1.0 / max(length, COINCIDENT), 0.0)  # coincident points have no direction: any one does
    ux = select(apart, dx * inv, 1.0)
    uy = dy * inv
    across = ux * ddy - uy * ddx
    side = -1.0 if corner == 0 else 1.0
    gamma = ux * (sbx * wb * wb - sax * wa * wa) + uy * (sby * wb * wb - say * wa * wa) - across * across * inv

    kinematics[row, at.GAP] = length - p[k + LEAST] if corner == 0 else p[k + LARGEST] - length
    kinematics[row, at.DGAP] = -side * (ux * ddx + uy * ddy)
    kinematics[row, at.NX], kinematics[row, at.NY] = side * ux, side * uy
    kinematics[row, at.PAX], kinematics[row, at.PAY] = sax, say
    kinematics[row, at.PBX], kinematics[row, at.PBY] = sbx, sby
    kinematics[row, at.ACROSS] = across
    kinematics[row, at.GAMMA_N] = side * gamma


@kind("stop", "distance", stop_distance)
class StopDistance(StopKind):
    """The distance of two points stays between two ends: a rope is taut at its largest.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    rounded = True

    @staticmethod
    def scale_at(corner: int, p: Sequence[float], size: float) -> float:
        """The end itself: the radius of the circle on which the points are there [m]."""
        return p[LEAST + corner]

    @classmethod
    def curved(cls, corner: int) -> float:
        """B is outside the circle at the least distance, inside at the largest."""
        return 2.0 if corner == 0 else 1.0

    min = Field("m", "least distance of the two points", default=-math.inf, least="positive")
    max = Field("m", "largest distance of the two points: the length of a rope", default=math.inf, least="positive")
