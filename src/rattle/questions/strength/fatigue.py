"""Fatigue of a repeated history of stress: rainflow cycles, Goodman, Haibach, Miner.

    sigma_ar = sigma_a/(1 - sigma_m/R_m)      amplitude at R = -1 that hurts as much; sigma_m < 0 gives no credit
    N = N_e (S_e/sigma_ar)^k                  cycles to failure; below S_e with the exponent 2 k - 1, if any is above
    D = sum n/N,  life = 1/D                  runs of the record until D = 1

Sources: ASTM E1049-85, 5.4.4 and 5.4.5; Goodman, Mechanics Applied to Engineering (1899); Haibach, Betriebsfestigkeit
(2006), 2.1; Miner, J. Appl. Mech. 12 (1945).
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rattle.errors import InputError

Array = NDArray[np.float64]
NOISE = 1e-9  # share of the largest range below which one is rounding of the computation: its cycles are not counted


class Cycle(NamedTuple):
    """A range between two turns of a history, in its unit, the mean of both, and how often: 1 or a half."""

    range: float
    mean: float
    count: float  # type: ignore[assignment]  # of tuples too, which nobody asks for here


class Endurance(NamedTuple):
    """What a material endures."""

    ultimate: float  # R_m [Pa]
    amplitude: float  # S_e at R = -1 [Pa]
    cycles: float  # N_e, those it endures at S_e
    exponent: float  # k


def rainflow(series: ArrayLike, repeat: bool = False) -> list[Cycle]:
    """Rainflow cycles of a history (n,): rows of range, mean and count, in the order in which they close.

    Three points decide: a range that is no larger than the one after it is a cycle; where it holds the start, half of
    one.  repeat=True: the history repeats for ever, and every cycle closes.  Nothing is rounded, and there are no bins.
    Raises InputError unless all values are finite.

    Source: ASTM E1049-85 (2017), 5.4.4; with repeat 5.4.5.
    """
    values = np.asarray(series)
    if values.ndim != 1 or values.dtype.kind not in "iufb" or not np.isfinite(values).all():
        raise InputError("a history to be counted is a list of finite numbers, in one dimension")
    values = values.astype(float)
    if repeat and len(values):
        first = int(np.abs(values).argmax())
        values = np.concatenate([values[first:], values[: first + 1]])
    return _counted(turns(values).tolist(), closed=repeat)


def turns(values: Array) -> Array:
    """The values (k,) at which a history (n,) turns, its first and its last one; none of a constant."""
    values = values[np.concatenate([[True], np.diff(values) != 0.0])] if len(values) else values
    if len(values) < 2:
        return values[:0]
    up = np.diff(values) > 0.0
    turned: Array = values[np.concatenate([[True], up[1:] != up[:-1], [True]])]
    return turned


def _counted(history: list[float], closed: bool) -> list[Cycle]:
    """The cycles of a history that turns at each of its values; closed: it starts and ends at its greatest one."""
    cycles: list[Cycle] = []
    left: list[float] = []
    for value in history:
        left.append(value)
        while len(left) >= 3 and abs(left[-2] - left[-3]) <= abs(left[-1] - left[-2]):
            low, high = left[-3], left[-2]
            if len(left) == 3 and not closed:
                cycles.append(_cycle(low, high, 0.5))
                del left[0]
            else:
                cycles.append(_cycle(low, high, 1.0))
                del left[-3:-1]
    return cycles + [_cycle(low, high, 0.5) for low, high in itertools.pairwise(left)]


def _cycle(first: float, second: float, count: float) -> Cycle:
    return Cycle(abs(second - first), 0.5 * (first + second), count)


def damage(history: Array, endured: Endurance) -> float:
    """Miner's sum of one run of a history of stress (n,) [Pa] that repeats; inf where a single cycle breaks it."""
    most, least = float(history.max()), float(history.min())
    if most >= endured.ultimate:  # a steady stress too, which has no cycle
        return math.inf
    worst = float(equivalent(np.array([0.5 * (most - least)]), np.array([most]), endured.ultimate)[0])
    if worst <= endured.amplitude:  # so is each of its cycles, none of which has a larger range or a larger mean
        return 0.0
    counted = np.array(rainflow(history, repeat=True)).reshape(-1, 3)
    counted = counted[counted[:, 0] > NOISE * (most - least)]
    amplitude = equivalent(0.5 * counted[:, 0], counted[:, 1], endured.ultimate)
    if len(counted) == 0 or amplitude.max() <= endured.amplitude:
        return 0.0
    if amplitude.max() >= endured.ultimate:
        return math.inf
    k = np.where(amplitude >= endured.amplitude, endured.exponent, 2.0 * endured.exponent - 1.0)
    return float((counted[:, 2] / endured.cycles * (amplitude / endured.amplitude) ** k).sum())


def equivalent(amplitude: Array, mean: Array, ultimate: float) -> Array:
    """Amplitudes at R = -1 (n,) [Pa] that hurt as much as these about such means (Goodman); inf from R_m on."""
    room = 1.0 - np.maximum(mean, 0.0) / ultimate
    with np.errstate(divide="ignore"):
        return np.where(room > 0.0, amplitude / np.where(room > 0.0, room, 1.0), math.inf)
