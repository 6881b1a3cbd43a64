"""Exact extremes of an output over all displacements that the clearances allow.

Every pin may be anywhere in its circle, every block of a guide anywhere between its walls; each kind of clearance
describes its displacements as a `FreePlay`.  The output is followed uphill: pins move to the point of their circle in
the direction of the last slope, guides from corner to corner of their displacements, and along the sides between.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from rattle.questions.accuracy.displaced_pins import Displaced

ROUNDS = 12
SETTLED = 1e-12  # gain of a round that counts as rounding: share of the extreme, and of 1 [SI] for extremes about 0
NARROW = 1e-7  # share of a side to which its best point is narrowed: the output is flat there, its error the square
MOST_GUIDES = 3  # up to so many guides, all combinations of their corners (tips) are starts
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def extreme(shown: Displaced, t: float, node: np.ndarray, sign: float, slope: np.ndarray) -> float:
    """Maximum (sign 1) or minimum (-1) of the output [SI] at t [s] over all displacements; nan if they are unbounded.

    node: position nearby, see `Displaced`; slope: (k, 2) d output / d e [SI] without displacement.
    """
    guides = [k for k, free in enumerate(shown.free) if free.two_tips]
    if any(free.unbounded for free in shown.free):
        return math.nan
    best = math.nan
    for turned in _kinds_of_tips(len(guides)):
        value = _climb(shown, t, node, sign, slope, dict(zip(guides, turned, strict=True)))
        if math.isnan(best) or sign * value > sign * best:
            best = value
    return best


def _kinds_of_tips(guides: int) -> Iterator[tuple[bool | None, ...]]:
    """For every guide: True to start at a corner with the block rotated, False without; None: as the slope says."""
    if guides <= MOST_GUIDES:
        yield from itertools.product((False, True), repeat=guides)
    else:
        yield (None,) * guides


def _climb(
    shown: Displaced, t: float, node: np.ndarray, sign: float, slope: np.ndarray, turned: dict[int, bool | None]
) -> float:
    """The extreme [SI] that is reached from one choice of corners."""
    best, at = math.nan, np.zeros_like(slope)
    for _ in range(ROUNDS):
        places = zip(shown.free, slope, strict=True)
        e = np.array([free.tip(sign * y, turned.get(k)) for k, (free, y) in enumerate(places)])
        value = shown.value(t, node, e)
        if math.isnan(value) or sign * value <= sign * best:
            break
        small = sign * (value - best) <= SETTLED * (abs(best) + SETTLED)
        best, at = value, e
        if small:
            break
        slope = shown.gradient(t, node, e)
        if not np.isfinite(slope).all():
            return best
    if turned and not math.isnan(best):
        best = _along_sides(shown, t, node, sign, at, best, list(turned))
    return best


def _along_sides(
    shown: Displaced, t: float, node: np.ndarray, sign: float, e: np.ndarray, best: float, guides: list[int]
) -> float:
    """The extreme [SI] after moving along the curved sides of the guides if the slope leads there; pins follow."""
    for _ in range(ROUNDS):
        before = best
        slope = shown.gradient(t, node, e)
        if not np.isfinite(slope).all():
            return best
        for k in guides:
            candidate = _along_side(shown, t, node, sign, e, k, sign * slope[k])
            if candidate is not None and sign * candidate[0] > sign * best:
                best, e = candidate
        if best == before:
            return best
        slope = shown.gradient(t, node, e)
        moved = e.copy()
        for k, free in enumerate(shown.free):
            if k not in guides:
                moved[k] = free.tip(sign * slope[k], None)
        value = shown.value(t, node, moved)
        if sign * value > sign * best:
            best, e = value, moved
        if sign * (best - before) <= SETTLED * (abs(best) + SETTLED):
            return best
    return best


def _along_side(
    shown: Displaced, t: float, node: np.ndarray, sign: float, e: np.ndarray, k: int, y: np.ndarray
) -> tuple[float, np.ndarray] | None:
    """Best output [SI] and displacements on the sides next to one guide's corner; None if the slope leads to none."""
    side = shown.free[k].side(e[k], y)
    if side is None:
        return None
    most, place = side

    def placed(way: float) -> np.ndarray:
        moved = e.copy()
        moved[k] = place(way)
        return moved

    low, high = 0.0, most
    lower, upper = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    f_lower, f_upper = (sign * shown.value(t, node, placed(turn)) for turn in (lower, upper))
    while high - low > NARROW * most:
        if f_lower > f_upper:
            high, upper, f_upper = upper, lower, f_lower
            lower = high - GOLDEN * (high - low)
            f_lower = sign * shown.value(t, node, placed(lower))
        else:
            low, lower, f_lower = lower, upper, f_upper
            upper = low + GOLDEN * (high - low)
            f_upper = sign * shown.value(t, node, placed(upper))
    turn = lower if f_lower > f_upper else upper
    value = sign * max(f_lower, f_upper)
    return (value, placed(turn)) if math.isfinite(value) else None
