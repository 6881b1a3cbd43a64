"""The film of finite length: the short film corrected by a table of two-dimensional solutions of Reynolds' equation.

F = -(mu R L^3/c^3) |v| e^Lambda [I1 m + (I2 + Lambda_alpha/2 I1) k], the slope of a potential;
see `rattle.elements.film_table` for the table and its coordinates.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.elements.film import CAVITATION, ratio_of
from rattle.elements.film_frame import FORCE, FULL, START, WETTED, book, relative_place, seen_velocity
from rattle.elements.film_table import (
    LONGEST,
    STRIDE,
    Array,
    coefficients,
    edge_place,
    read_line,
    read_ratios,
    read_sheet,
    recorded_coefficients,
)
from rattle.elements.short_film import short_integrals, short_peaks
from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import FilmLaw
from rattle.jit.functions import kernel
from rattle.language.recorded import Recorded, array_of
from rattle.registry import kind

ROUNDED = 1e-12  # share by which L/D may exceed the end of the table by rounding


@kernel("film")
def finite(ex, ey, vx, vy, wa, wb, p, k, table, out):
    """Force, moments and loss of `Finite`."""
    ux, uy = seen_velocity(ex, ey, vx, vy, wa, wb)
    px, py, gap, size = relative_place(ex, ey, p, k)
    s2 = gap * (2.0 - gap)
    s = math.sqrt(s2)
    e = 1.0 - gap
    first_place = int(p[k + START])
    if p[k + FULL] != 0.0:
        along = (1.0 + 2.0 * e * e) / s2 * math.exp(read_line(table, first_place, gap))
        across = math.exp(read_line(table, first_place + STRIDE, gap))
        unit = p[k + FORCE] * math.pi / (s2 * s)
        fx, fy = -unit * across * ux, -unit * across * uy
        if size > 0.0:
            nx, ny = ex / size, ey / size
            more = unit * (along - across) * (nx * ux + ny * uy)
            fx -= more * nx
            fy -= more * ny
        book(ex, ey, ux, uy, fx, fy, wa, wb, 2.0 * math.pi / s, p, k, out)
        return
    speed = math.sqrt(ux * ux + uy * uy)
    fx, fy, q = 0.0, 0.0, 0.5 * math.pi
    if speed > 0.0:
        over = 1.0 / speed
        mx, my = over * ux, over * uy
        a, b = px * mx + py * my, py * mx - px * my
        q, first, second = short_integrals(a, b, s)
        tau, turned = edge_place(a, b, math.sqrt(px * px + py * py), s, q)
        value, slope = read_sheet(table, first_place, gap, tau)
        second += 0.5 * slope * turned * first
        strength = -p[k + FORCE] * speed * math.exp(value)
        fx = strength * (first * mx - second * my)
        fy = strength * (first * my + second * mx)
    arc = 2.0 * (q if p[k + WETTED] != 0.0 else math.pi) / s
    book(ex, ey, ux, uy, fx, fy, wa, wb, arc, p, k, out)


@kind("film", "finite", finite)
class Finite(FilmLaw):
    """Table of the dissipation potential of films from L/D = 1/16 to 2; the default.

    Range: L/D up to 2; force within 0.06 % of two-dimensional solutions up to e = 0.999 c.  Beyond it is extrapolated,
    and off by 1 % at 0.9995 c, by 3 to 11 % at 0.9999 c from L/D = 1 to 1/4.
    Source: Reynolds (1886), Phil. Trans. R. Soc. 177, 157-234; potential and table: this package.
    """

    cavitation = CAVITATION

    @classmethod
    def table(cls, values: LawValues) -> Array:
        """Coefficients of the splines at the L/D of these fields."""
        return _coefficients("full" if values["cavitation"] == "full" else "potential", values)

    @classmethod
    def faults(cls, values: LawValues, clearance: float) -> list[str]:
        """Thin films, and no longer than the table."""
        ratio, faults = ratio_of(values), super().faults(values, clearance)
        if ratio > LONGEST * (1.0 + ROUNDED):
            faults.append(f"L/D is {ratio:.3g}; the table of the law 'finite' ends at {LONGEST:g}: use a shorter bush")
        return faults

    @classmethod
    def peak(cls, values: LawValues, e: Array, alpha: Array) -> Array:
        short = np.empty(len(e))
        short_peaks(e, alpha, short)
        return short * _ratio("peak", values, e, alpha)

    @classmethod
    def leakage(cls, values: LawValues, e: Array, alpha: Array) -> Array:
        return _ratio("leakage", values, e, alpha)


def _coefficients(name: str, values: LawValues) -> Array:
    """Coefficients of the splines of one table of films at the L/D of these fields."""
    ratio = ratio_of(values)
    if isinstance(ratio, Recorded):
        return array_of(recorded_coefficients(name, ratio))
    return coefficients(name, ratio)


def _ratio(name: str, values: LawValues, e: Array, alpha: Array) -> Array:
    """A ratio to the short film from its table."""
    kept = _coefficients(f"{'full_' if values['cavitation'] == 'full' else ''}{name}", values)
    ratios = np.empty(len(e))
    read_ratios(e, alpha, np.array(kept), ratios)  # a copy: compiled functions take no read-only array
    return ratios
