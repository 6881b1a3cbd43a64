"""The static positions of a journal in numbers without units: the columns of the table of a film."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rattle.errors import InputError
from rattle.questions.film.journal import Bearing, sommerfeld, stiffness_and_damping, threshold

Columns = dict[str, NDArray[np.float64]]  # (n,) by name
AXES = ("xx", "xy", "yx", "yy")


def locus(film: Bearing, eccentricities: Sequence[float], coefficients: bool = True) -> Columns:
    """Columns (n,) by name, one row for each eccentricity [of the clearance].

    coefficients: also those of stiffness and damping, and what follows from them.

    Raises InputError for an eccentricity that is not between 0 and 1.
    """
    wrong = [e for e in eccentricities if not 0.0 < e < 1.0]
    if wrong:
        raise InputError(f"an eccentricity is between 0 and 1 clearances, not {wrong[0]:g}")
    rows = [_row(film, float(e), coefficients) for e in eccentricities]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]} if rows else {}


def _row(film: Bearing, e: float, coefficients: bool) -> dict[str, float]:
    """What holds at one eccentricity, at a speed of 1 rad/s."""
    c = film.clearance
    fx, fy, _, torque, _ = film.force(e * c, 0.0, 0.0, 0.0, 0.0, 1.0)
    load, attitude = math.hypot(fx, fy), math.atan2(fy, -fx)
    turns = 0.5 / math.pi  # revolutions per second
    values = {
        "eccentricity": e,
        "attitude": attitude,
        "sommerfeld": sommerfeld(film, load, 1.0),
        "friction": abs(torque) / (load * c),
        "pressure": film.peak_pressure(e * c, 0.0, 0.0, 0.0, 0.5) * 2.0 * film.radius * film.length / load,
        "leakage": film.leakage(e * c, 0.0, 0.0, 0.0, 0.5) / (film.radius * c * turns * film.length),
    }
    if not coefficients:
        return values
    stiffness, damping = stiffness_and_damping(film, e, attitude, 1.0)
    mass, whirl = threshold(stiffness, damping)
    return {
        **values,
        **{f"k_{axes}": entry * c / load for axes, entry in zip(AXES, stiffness.ravel(), strict=True)},
        **{f"c_{axes}": entry * c / load for axes, entry in zip(AXES, damping.ravel(), strict=True)},
        "critical_mass": mass * c / load,
        "whirl": whirl,
    }
