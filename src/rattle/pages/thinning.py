"""Which numbers of a long result a page keeps, so that no curve loses an extreme.

All curves share some instants: evenly chosen ones, and those at which any curve has its largest or least value.  Beside
them every curve keeps the values at which it turns: a straight line through what is kept then passes through each
maximum and minimum of the result.  A curve that turns more often than a page can hold keeps its largest and least value
between two instants.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.results.result import Result

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
PER_INTERVAL = 2  # values that a curve keeps between two instants, on average
ROUNDING = 1e-6  # change of a curve, as a share of its size, below which it rests: pages hold single precision
NOTHING = 1e-9  # size of a curve as a share of the largest of its unit, below which it is rounding


class Between(NamedTuple):
    """Values of one curve between the instants that all curves share."""

    rows: Rows  # (n,) of the result
    all_turns: bool  # False if the curve turns more often, and these are its largest and least values


def shared_rows(result: Result, most: int) -> Rows:
    """Rows of a result that all curves keep: about `most` evenly chosen ones, and those with an extreme of a curve."""
    n = len(result.t)
    if n <= most:
        return np.arange(n)
    every = math.ceil((n - 1) / (most - 1))
    picked = [np.arange(0, n, every), np.array([n - 1])]
    for name in result.names:
        values = result[name]
        if np.isfinite(values).any():
            picked.append(np.array([np.nanargmax(values), np.nanargmin(values)]))
    return np.unique(np.concatenate(picked))


def between(result: Result, shared: Rows) -> dict[str, Between]:
    """By curve what it keeps between the shared rows; curves that keep nothing are left out."""
    if len(shared) == len(result.t):
        return {}
    sizes: dict[str, float] = {}
    curves = {name: np.asarray(result[name]) for name in result.names}
    for name, values in curves.items():
        unit = result.unit(name)
        sizes[unit] = max(sizes.get(unit, 0.0), _size(values))
    kept: dict[str, Between] = {}
    for name, values in curves.items():
        rest = ROUNDING * max(_size(values), NOTHING * sizes[result.unit(name)])
        turns = turning_rows(values, rest)
        all_turns = len(turns) <= PER_INTERVAL * len(shared)
        rows = turns if all_turns else extreme_rows(values, shared)
        rows = np.setdiff1d(rows[np.isfinite(values[rows])], shared)
        if len(rows):
            kept[name] = Between(rows, all_turns)
    return kept


def turning_rows(values: Array, rest: float) -> Rows:
    """Rows at which a curve (n,) begins to rise, to fall or to rest; a change of at most `rest` is none."""
    change = np.diff(values)
    way = np.where(np.abs(change) > rest, np.sign(change), 0.0)
    return np.flatnonzero(way[1:] != way[:-1]) + 1


def extreme_rows(values: Array, shared: Rows) -> Rows:
    """Rows of the largest and of the least value of a curve (n,) from each shared row to the next."""
    part = np.searchsorted(shared, np.arange(len(values)), side="right") - 1
    picked = []
    for sign in (1.0, -1.0):
        size = np.where(np.isfinite(values), sign * values, -math.inf)
        order = np.lexsort((size, part))  # by part, the largest of each last
        picked.append(order[np.append(np.flatnonzero(np.diff(part[order])), len(order) - 1)])
    return np.unique(np.concatenate(picked))


def _size(values: Array) -> float:
    """Largest finite magnitude of a curve."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
