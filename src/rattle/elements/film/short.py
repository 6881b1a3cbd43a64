"""The short film: pressure that flows off along the axis only, where it is positive.

F = -(mu R L^3/c^3) |v| (I1 m + I2 k), see `rattle.elements.short_film` for both integrals; without cavitation
F = -(mu R L^3/c^3) pi [(1 + 2 e^2)/s^5 v_n n + 1/s^3 v_t t].
"""

from __future__ import annotations

import math

import numpy as np

from rattle.elements.film import CAVITATION, ratio_of
from rattle.elements.film_frame import FORCE, FULL, WETTED, book, relative_place, seen_velocity
from rattle.elements.film_table import Array
from rattle.elements.short_film import short_integrals, short_peaks
from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import FilmLaw
from rattle.jit.functions import kernel
from rattle.registry import kind


@kernel("film")
def short(ex, ey, vx, vy, wa, wb, p, k, table, out):
    """Force, moments and loss of `Short`."""
    ux, uy = seen_velocity(ex, ey, vx, vy, wa, wb)
    px, py, gap, _size = relative_place(ex, ey, p, k)
    s2 = gap * (2.0 - gap)
    s = math.sqrt(s2)
    if p[k + FULL] != 0.0:
        # along e there is 2 e^2/s^5 + 1/s^5 - 1/s^3 = 3 e^2/s^5 more
        across = p[k + FORCE] * math.pi / (s2 * s)
        more = across * 3.0 / s2 * (px * ux + py * uy)
        book(ex, ey, ux, uy, -across * ux - more * px, -across * uy - more * py, wa, wb, 2.0 * math.pi / s, p, k, out)
        return
    speed = math.sqrt(ux * ux + uy * uy)
    fx, fy, q = 0.0, 0.0, 0.5 * math.pi
    if speed > 0.0:
        over = 1.0 / speed
        mx, my = over * ux, over * uy
        q, first, second = short_integrals(px * mx + py * my, py * mx - px * my, s)
        size = -p[k + FORCE] * speed
        fx = size * (first * mx - second * my)
        fy = size * (first * my + second * mx)
    arc = 2.0 * (q if p[k + WETTED] != 0.0 else math.pi) / s
    book(ex, ey, ux, uy, fx, fy, wa, wb, arc, p, k, out)


@kind("film", "short", short)
class Short(FilmLaw):
    """Closed form for bearings much shorter than their diameter.

    Range: L/D up to 1/4 at small eccentricity; too strong by 5 % at L/D = 0.36 for e = 0.1 c, 0.23 for 0.5 c, 0.08 for
    0.9 c, and by a multiple at L/D = 1.
    Source: Ocvirk (1952), NACA TN 2808 (pressure); the integrals over its positive part: this package.
    """

    cavitation = CAVITATION

    @classmethod
    def notes(cls, values: LawValues) -> list[str]:
        """A remark for the user if the bearing is not short."""
        ratio = ratio_of(values)
        if ratio <= 0.25:
            return []
        return [f"at L/D = {ratio:.3g} a short film is too strong, by a multiple where it is thin; use 'finite'"]

    @classmethod
    def peak(cls, values: LawValues, e: Array, alpha: Array) -> Array:
        peaks = np.empty(len(e))
        short_peaks(e, alpha, peaks)
        return peaks

    @classmethod
    def leakage(cls, values: LawValues, e: Array, alpha: Array) -> Array:
        return np.ones(len(e))
