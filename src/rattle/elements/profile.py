"""Outlines of bodies that a function of the direction gives: the values of such a function around the whole turn."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from rattle.language.local_function import LocalFunction

COUNT = 361  # directions in a turn: every degree
STEP = 1e-6  # of the largest value: what is not yet a step

Array = NDArray[np.float64]


@functools.lru_cache(maxsize=64)
def around(function: LocalFunction) -> tuple[Array, Array]:
    """Directions (n,) [rad] from -180 to 180 deg where a function of them is known, and its jets (3, n) there.

    Outside of a table without period a function is not known.
    """
    angles = np.linspace(-np.pi, np.pi, COUNT)
    jets = function(angles)
    defined = np.isfinite(jets).all(axis=0)
    return angles[defined], jets[:, defined]


def degrees(angle: float) -> str:
    """A direction [rad] as messages say it."""
    return f"{np.degrees(angle):.4g} deg"


def gap(function: LocalFunction, key: str, variable: str) -> str:
    """That a function of a direction jumps where the turn begins anew, in words; "" if it does not or is not known."""
    angles, jets = around(function)
    if len(angles) < COUNT or abs(jets[0, -1] - jets[0, 0]) <= STEP * np.abs(jets[0]).max():
        return ""
    end, begin = (f"{jets[0, k]:.4g} m" for k in (-1, 0))
    return (
        f"{key}: its curve has a step at {variable} = 180 deg, from {end} to {begin}, over which a follower would have"
        " to jump"
    )
