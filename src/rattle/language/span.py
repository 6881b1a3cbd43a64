"""Bounds of a value and of its rate over spans of time, and those of counted numbers."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

Array = np.ndarray


class Span(NamedTuple):
    """Bounds of a value [SI] and of its time derivative [SI], each (n,) for n intervals of time."""

    low: Array
    high: Array
    slow: Array  # lower bound of the rate
    fast: Array  # upper bound of the rate


def wave(x: Span) -> Span:
    """`bytecode.wave`: it rises at the rate of x around even integers, and falls around odd ones."""
    first, last = np.floor(x.low + 0.5), np.floor(x.high + 0.5)  # nearest integers
    ways = [np.where(np.mod(n, 2.0) == 0.0, 1.0, -1.0) for n in (first, last)]
    one, two = ways[0] * (x.low - first), ways[1] * (x.high - last)
    low, high = np.minimum(one, two), np.maximum(one, two)  # with the peaks between the nearest integers
    low = np.where((last > first) & ((last > first + 1.0) | (ways[0] < 0.0)), -0.5, low)
    high = np.where((last > first) & ((last > first + 1.0) | (ways[0] > 0.0)), 0.5, high)
    size = np.maximum(np.abs(x.slow), np.abs(x.fast))
    slow = np.where(last > first, -size, np.where(ways[0] > 0.0, x.slow, -x.fast))
    fast = np.where(last > first, size, np.where(ways[0] > 0.0, x.fast, -x.slow))
    unknown = np.isnan(x.low) | np.isnan(x.high)
    return Span(*(np.where(unknown, math.nan, one) for one in (low, high, slow, fast)))


def whole_numbers(x: Span, side: Array | None) -> Span:
    """floor(x): one integer of its parity where the side is known, otherwise all from floor(low) to floor(high)."""
    low, high = np.floor(x.low), np.floor(x.high)
    none = np.zeros_like(low)
    leaps = np.where(high > low, math.inf, 0.0)
    if side is None:
        return Span(low, high, -leaps, leaps)
    odd = np.where(side > 0.0, 0.0, 1.0)
    inner, outer = low + (np.mod(low, 2.0) != odd), high - (np.mod(high, 2.0) != odd)
    held = (side != 0.0) & (inner <= outer)
    return Span(
        np.where(held, inner, low), np.where(held, outer, high),
        np.where(held, none, -leaps), np.where(held, none, leaps),
    )  # fmt: skip
