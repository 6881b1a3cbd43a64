"""How fast sensitivities grow: how long a derivative says what a change of a parameter does.

A regular motion separates from its neighbours in proportion to a power of time, a chaotic one exponentially:

    ln |Y| = a + n ln t + lambda t,   n >= 0

is fitted to the size |Y| of the derivatives of the positions.  A body that rests and is then pushed has them all at
once, which is no growth.  The exponent itself: `m.lyapunov()`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rattle.analyses.dynamics.horizon import AGREE

SKIP = 0.2  # share of the run before the fit begins
ENOUGH = 100.0  # growth beyond a power of time from which on it counts as exponential
POINTS = 200  # of the fit, evenly spaced in time
SPELLS, MOST_AT_ONCE = 20, 0.5  # of the fit, and the share of all growth beyond which that in one of them is a jump
BENT = 0.1  # change of a position, in sizes of the mechanism or rad, up to which it counts as linear
LOST = 10.0  # errors of a run are taken for those of a relative change of a parameter by so many tolerances


class Growth(NamedTuple):
    """Exponential growth of the derivatives by one parameter."""

    rate: float  # lambda [1/s]

    @property
    def tenfold(self) -> float:
        """Time in which they grow tenfold [s]."""
        return math.log(10.0) / self.rate


def growth(t: np.ndarray, size: np.ndarray) -> Growth | None:
    """Exponential growth of sizes (n,) at times t (n,) [s] of a whole run, None if there is none."""
    first = SKIP * t[-1]
    some = (t >= first) & (size > 0.0) & np.isfinite(size)
    if some.sum() < 10:
        return None
    at = np.linspace(t[some][0], t[-1], POINTS)
    value = np.interp(at, t[some], np.log(size[some]))
    rises = np.diff(value[:: POINTS // SPELLS])
    if rises.max() > MOST_AT_ONCE * rises.sum():
        return None
    terms = np.column_stack([np.ones_like(at), at, np.log(at)])
    _, rate, power = np.linalg.lstsq(terms, value, rcond=None)[0]
    if power < 0.0:
        _, rate = np.linalg.lstsq(terms[:, :2], value, rcond=None)[0]
    return Growth(float(rate)) if rate * (at[-1] - at[0]) > math.log(ENOUGH) else None


def linear_until(t: np.ndarray, size: np.ndarray, change: float) -> float:
    """The first of the times t (n,) [s] at which a change of the parameter moves a position by BENT; inf if none.

    size: (n,) of the derivatives of positions, in sizes of the mechanism or rad per unit of the parameter.
    """
    beyond = size * change > BENT
    return float(t[np.argmax(beyond)]) if beyond.any() else math.inf


def horizon(t: np.ndarray, size: np.ndarray, values: np.ndarray, rtol: float) -> float:
    """The last of the times t (n,) [s] up to which errors of a run are small.

    size: (n, k) of the derivatives by k parameters, as above; values: (k,) of these.  Errors grow as differences do.
    """
    error = LOST * rtol * (size * np.where(values != 0.0, np.abs(values), 1.0)).max(axis=1)
    large = error > AGREE
    return float(t[max(0, int(np.argmax(large)) - 1)]) if large.any() else float(t[-1])
