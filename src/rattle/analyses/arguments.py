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
        found = float(value)
    except OverflowError:
        found = math.inf
    if not math.isfinite(found):
        raise InputError(f"{name} must be a finite number, got {found}")
    return found


def positive(name: str, value: Any) -> float:
    """The value as a positive, finite float (any unit).  Raises as `number` does."""
    try:
        found = number(name, value)
    except WrongType:
        raise
    except InputError:
        found = math.nan
    if not found > 0.0:
        raise InputError(f"{name} must be positive and finite, got {value!s:.60}")
    return found


def relative_tolerance(value: Any) -> float:
    """A relative tolerance [-] within the range of double precision.  Raises as `number` does."""
    found = positive("rtol", value)
    if found < TIGHTEST:
        raise InputError(f"rtol = {found:g} is below the digits that numbers have; expected {TIGHTEST:g} or more")
    if found >= 1.0:
        raise InputError(f"rtol = {found:g} leaves no correct digit; 1e-3 is coarse, 1e-8 the default")
    return found


def effort(value: Any) -> float:
    """Work of a search [-], 1 being the usual amount.  Raises as `number` does, and ValueError above MOST_EFFORT."""
    found = positive("effort", value)
    if found > MOST_EFFORT:
        raise InputError(f"effort must be at most {MOST_EFFORT:g} (1 is the usual work of a search), got {found:g}")
    return found


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
