"""The long film of Pinkus and Sternlicht, as papers on clearance joints have used it.

With v_n, v_t along the eccentricity and across it, e over the clearance and k^2 = s^2 [(v_t/(e v_n))^2 + 1/e^2], in the
unit mu L R^3/c^3:

    v_n > 0:  F_n = -6 v_n/((2 + e^2) s^3) [4 k e^2 + (2 + e^2) pi] f     f = (k + 3)/(k + 3/2)
    v_n < 0:  F_n = -6 |v_n|/((2 + e^2) s^3) [4 k e^2 - (2 + e^2) pi] f   f = k/(k + 3/2)
    F_t = -12 pi v_t/((2 + e^2) s) f

k |v_n| = s |v|/e has no zero in a denominator, so the kernel is written with it.  The second line has |v_n|: with v_n
itself, as some papers print it, F_n jumps at v_n = 0 and the film does work on the mechanism while the pin separates.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.elements.film import ratio_of
from rattle.elements.film_frame import CLEARANCE, SHEAR, book, relative_place, seen_velocity
from rattle.elements.film_table import Array
from rattle.elements.long_film import long_peaks
from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import FilmLaw
from rattle.jit.functions import kernel
from rattle.registry import kind


@kernel("film")
def pinkus_sternlicht(ex, ey, vx, vy, wa, wb, p, k, table, out):
    """Force, moments and loss of `PinkusSternlicht`."""
    ux, uy = seen_velocity(ex, ey, vx, vy, wa, wb)
    _px, _py, gap, size = relative_place(ex, ey, p, k)
    s2 = gap * (2.0 - gap)
    s = math.sqrt(s2)
    e = 1.0 - gap
    nx, ny = 1.0, 0.0
    if size > 0.0:
        nx, ny = ex / size, ey / size
    un, ut = nx * ux + ny * uy, nx * uy - ny * ux
    speed = math.sqrt(ux * ux + uy * uy)
    fn, ft = 0.0, 0.0
    if speed > 0.0:
        unit = p[k + SHEAR] / (p[k + CLEARANCE] * p[k + CLEARANCE])  # mu L R^3/c^3
        long = 2.0 + e * e
        whole = s * speed + 1.5 * e * abs(un)  # e |v_n| (k + 3/2)
        part = (s * speed + (3.0 * e * un if un > 0.0 else 0.0)) / whole
        fn = -6.0 * unit * part * (4.0 * e * s * speed + long * math.pi * un) / (long * s2 * s)
        ft = -12.0 * math.pi * unit * part * ut / (long * s)
    book(ex, ey, ux, uy, fn * nx - ft * ny, fn * ny + ft * nx, wa, wb, 2.0 * math.pi / s, p, k, out)


@kind("film", "pinkus-sternlicht", pinkus_sternlicht)
class PinkusSternlicht(FilmLaw):
    """Superposed wedge and squeeze of an infinitely long bearing, to repeat published work.

    Range: none in practice; 15 to 60 % from two-dimensional films even at L/D = 2.
    Source: Pinkus, Sternlicht, Theory of Hydrodynamic Lubrication (1961), as in Flores, Ambrosio, Claro, Lankarani
    (2006), Mech. Mach. Theory 41, 247-261, with the magnitude of the separating speed.
    """

    @classmethod
    def notes(cls, values: LawValues) -> list[str]:
        """A remark for the user: it is no model of a real bearing."""
        ratio = ratio_of(values)
        return [
            f"pinkus-sternlicht is a law of infinitely long films, here at L/D = {ratio:.3g}; 'finite' is one for it"
        ]

    @classmethod
    def peak(cls, values: LawValues, e: Array, alpha: Array) -> Array:
        """The largest pressure of the exact solution for the wedge and the squeeze of a long film, together."""
        peaks = np.empty(len(e))
        long_peaks(e, alpha, peaks)
        return peaks * 3.0 / ratio_of(values) ** 2
