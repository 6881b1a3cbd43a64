"""Laws of the oil film between pin and bush: force, moments and loss from where the pin is and how it moves.

The film sees one vector.  With e = pin centre minus bush centre, the rates w_A of the bush and w_B of the pin,

    v = e' - w_m z x e        w_m = (w_A + w_B)/2                                                 [m/s]

is the velocity of the pin's centre in a frame that turns with the mean of both; Reynolds' equation for the gap
h = c - e.u has the right side -v.u.  The force on the pin is F, that on the bush -F at the pin's centre; moments about
the own centre of each follow from the shear of the film and from the balance of moments on it,

    T_c = mu (R^3 L/c) (w_B - w_A) arc        T_A = T_c - X/2        T_B = -T_c - X/2        X = (e x F)_z

with arc = int dphi/H = 2 pi/s over the whole circumference, or 2 Q/s over the part with pressure, s^2 = 1 - (|e|/c)^2.
The loss is -F.e' - T_A w_A - T_B w_B = -F.v + T_c (w_B - w_A) [W]; it is not negative where -F.v is not.

From a least thickness on the coefficients are those of that thickness, also beyond the bush: a trial state of a stepper
gets a finite force, which still resists.

The kernel is  f(ex, ey, vx, vy, w_A, w_B, p, k, table, out), out = F_x, F_y [N], T_A, T_B [N*m], loss [W];
p[k:] comes from `pack`, table from `table` (several films may share one: p[k + START] is where the own part begins).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rattle.elements.film_table import Array
from rattle.language.recorded import as_number
from rattle.registry import Field

WORDS = ("whole", "wetted")
THINNEST = 0.02  # clearance over radius above which the film is not thin


class FilmLaw:
    """Base of the film laws."""

    viscosity = Field("Pa*s", "dynamic viscosity of the oil, at the temperature of the film", least="positive")
    length = Field("m", "of the bush, along its axis", least="positive")
    bush_radius = Field("m", "of the bore", least="positive")
    shear = Field(
        "", "the film drags on the whole circumference, or only where it has pressure", "whole", "choice", choices=WORDS
    )

    @classmethod
    def pack(cls, values: Mapping[str, Any], clearance: float, least: float, start: int = 0) -> tuple[float, ...]:
        """Parameters of the kernel: mu R L^3/c^3 [N s/m], c [m], mu R^3 L/c [N m s], the least film over c [-], ...

        values by field name [SI]; clearance c [m]; least: thinnest film whose coefficients are used [m]; start: first
        coefficient in a table of several films.
        """
        mu, length, radius = (as_number(values[key]) for key in ("viscosity", "length", "bush_radius"))
        full, wetted = values.get("cavitation") == "full", values["shear"] == "wetted"
        force, shear = mu * radius * length * (length / clearance) ** 2 / clearance, mu * radius**3 * length / clearance
        return force, clearance, shear, least / clearance, float(full), float(wetted), float(start)

    @classmethod
    def table(cls, values: Mapping[str, Any]) -> Array:
        """Coefficients that the kernel reads besides its parameters; of most laws there are none."""
        return np.zeros(0)

    @classmethod
    def faults(cls, values: Mapping[str, Any], clearance: float) -> list[str]:
        """What makes the law useless for these values [SI] and this clearance [m], in words."""
        ratio = clearance / as_number(values["bush_radius"])
        if ratio <= THINNEST:
            return []
        fault = f"the clearance is {ratio:.3g} of the radius; the theory of thin films needs at most {THINNEST:g}"
        return [fault]

    @classmethod
    def notes(cls, values: Mapping[str, Any]) -> list[str]:
        """Remarks for the user on the range of validity."""
        return []

    @classmethod
    def peak(cls, values: Mapping[str, Any], e: Array, alpha: Array) -> Array:
        """Largest pressure over mu L^2 |v|/c^3 at eccentricities e [of the clearance], v at alpha [rad] from them.

        All arrays are (n,).
        """
        raise NotImplementedError

    @classmethod
    def leakage(cls, values: Mapping[str, Any], e: Array, alpha: Array) -> Array:
        """What flows out of both ends over 2 R L |v|; nan if the law says nothing about it.  All arrays are (n,)."""
        return np.full(len(e), math.nan)


def ratio_of(values: Mapping[str, Any]) -> float:
    """L/D [-] of the fields of a film."""
    return 0.5 * as_number(values["length"]) / as_number(values["bush_radius"])


CAVITATION = Field(
    "",
    "reynolds: no pressure below that of the surroundings; full: of either sign, as in a submerged or pressurised film",
    "reynolds",
    "choice",
    choices=("reynolds", "full"),
)
