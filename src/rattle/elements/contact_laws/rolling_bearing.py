"""Static force of a rolling bearing: rings that are round and rigid, balls or rollers side by side between them.

An element at the angle theta from the load is pressed by e cos theta - c where that is positive, e = c + delta:

    F = Z K/(2 pi) integral over |theta| < theta_0 of (e cos theta - c)^n cos theta,      cos theta_0 = c/e
      = Z K delta^n J_r,    J_r = .2288 (n = 3/2), .2453 (n = 10/9) without play;   the most loaded one bears K delta^n

Elements are spread evenly: that they pass by one after the other is left out.  With theta = theta_0 sin phi the
integrand goes smoothly to zero at both ends, so that equal steps converge faster than any power of them.
"""

from __future__ import annotations

import math

from rattle.errors import InputError
from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import StiffnessLaw
from rattle.jit.functions import kernel
from rattle.language.recorded import as_number
from rattle.registry import Field, kind

STEPS = 16  # of a quarter of phi: the integral is off by less than 1e-9, see test_rolling_bearing.py
QUARTER = 0.5 * math.pi / STEPS


@kernel("stiffness")
def spread(delta, p, k):
    """Force [N] of `RollingElements`: p[k:] = Z K/(2 pi) [N/m^n], n [-], c [m]."""
    if delta <= 0.0:
        return 0.0
    n, c = p[k + 1], p[k + 2]
    e = c + delta
    s = math.sqrt(delta * (2.0 * c + delta)) / e  # sin theta_0
    end = math.atan2(s * e, c)
    total = 0.0
    for step in range(STEPS):
        phi = (step + 0.5) * QUARTER
        theta = end * math.sin(phi)
        pressed = 2.0 * e * math.sin(0.5 * (end + theta)) * math.sin(0.5 * (end - theta))  # e cos theta - c
        force = pressed * math.sqrt(pressed) if n == 1.5 else pressed**n
        total += force * math.cos(theta) * math.cos(phi)
    return 2.0 * p[k] * total * end * QUARTER


@kind("stiffness", "rolling", spread)
class RollingElements(StiffnessLaw):
    """F = Z K delta^n J_r: Z balls or rollers of stiffness K between round rings, some of which bear the load.

    K is that of one element between both rings, of a data sheet or by Hertz; n = 1.5 of balls, 10/9 of rollers.
    The most loaded element bears K delta^n.
    Range: rings that stay round, no load along the axis.
    Source: Harris, Kotzalas, Essential Concepts of Bearing Technology (2007), chapter 7; Stribeck (1907).
    """

    elements = Field("", "Z, number of balls or rollers", least="positive")
    element_stiffness = Field("", "K of one of them between both rings [N/m^n]", least="positive")
    exponent = Field("", "n: 1.5 of balls, 10/9 of rollers", default=1.5, least="positive")

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        play, count = as_number(values["clearance"]), as_number(values["elements"])
        if not play >= 0.0:
            raise InputError("rolling elements need the clearance of their bearing")
        if count < 3.0:
            raise InputError(f"{count:g} rolling elements do not hold a shaft: expected 3 or more")
        stiffness = as_number(values["element_stiffness"])
        return count * stiffness / (2.0 * math.pi), as_number(values["exponent"]), play
