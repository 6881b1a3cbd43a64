"""Checks of numerical arguments - steps, tolerances, counts; messages name the argument."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rattle.errors import InputError, WrongType

TIGHTEST = 1e-14  # least relative tolerance: floats have about 16 digits
MOST_POINTS = 10_000_000
MOST_BYTES = 2e9  # of the outputs of one run, at most
MOST_EFFORT = 10_000.0  # of a search for equilibria: minutes


def number(name: str, value: Any) -> float:
    """The value as a finite float (any unit).  Raises TypeError if it is not a number, ValueError for nan and inf."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.number):
        raise WrongType(f"{name} must be a number, got {value!r:.60}")
    try:
        result = float(value)
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise InputError(f"{name} must be a finite number, got {result}")
    return result


def positive(name: str, value: Any) -> float:
    """The value as a positive, finite float (any unit).  Raises as `number` does."""
    try:
        result = number(name, value)
    except WrongType:
        raise
    except InputError:
        result = math.nan
    if not result > 0.0:
        raise InputError(f"{name} must be positive and finite, got {value!s:.60}")
    return result


def relative_tolerance(value: Any) -> float:
    """A relative tolerance [-] within the range of double precision.  Raises as `number` does."""
    tolerance = positive("rtol", value)
    if tolerance < TIGHTEST:
        raise InputError(f"rtol = {tolerance:g} is below the digits that numbers have; expected {TIGHTEST:g} or more")
    if tolerance >= 1.0:
        raise InputError(f"rtol = {tolerance:g} leaves no correct digit; 1e-3 is coarse, 1e-8 the default")
    return tolerance


def effort(value: Any) -> float:
    """Work of a search [-], 1 being the usual amount.  Raises as `number` does, and ValueError above MOST_EFFORT."""
    work = positive("effort", value)
    if work > MOST_EFFORT:
        raise InputError(f"effort must be at most {MOST_EFFORT:g} (1 is the usual work of a search), got {work:g}")
    return work


def whole(name: str, value: Any, least: int, most: int = MOST_POINTS) -> int:
    """An integer from `least` to `most`.  Raises TypeError if it is not an integer, ValueError outside the limits."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise WrongType(f"{name} must be an integer, got {value!r:.60}")
    if not least <= int(value) <= most:
        got = f"{int(value)}" if -(10**20) < int(value) < 10**20 else "a number far beyond"
        raise InputError(f"{name} must be from {least} to {most}, got {got}")
    return int(value)


def instants(value: Any) -> np.ndarray:
    """Times [s] as a contiguous array of floats.  Raises TypeError or ValueError if they are not numbers."""
    try:
        return np.ascontiguousarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise (WrongType if not isinstance(value, list | tuple | int) else InputError)(
            f"t_eval must be a time or an array of times in s, got {value!r:.60}"
        ) from None


def require_room(rows: int, columns: int) -> None:
    """Raise InputError if `rows` outputs of `columns` numbers would take too much memory."""
    size = 8.0 * rows * columns
    if size > MOST_BYTES:
        raise InputError(
            f"{rows} outputs of {columns} numbers take {size / 1e9:.1f} GB; at most {MOST_BYTES / 1e9:g} GB are kept:"
            " choose fewer outputs (a larger output interval)"
        )
