"""Statistics of samples, each with bounds that hold it with 95 % confidence.

Bounds are those of independent draws: mean by Student's t, standard deviation by the spread of squares (no normal
distribution is assumed), quantiles by order statistics, shares by Clopper and Pearson.  Points of sobol, halton and lhs
designs spread more evenly than independent ones, so that their bounds are as a rule too wide, not too narrow.

Source: Conover, Practical Nonparametric Statistics (1999), sections 3.1 (shares) and 3.2 (quantiles).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import stats

CONFIDENCE = 0.95
QUANTILES = (0.05, 0.5, 0.95)


class Bounded(NamedTuple):
    """An estimate with its bounds."""

    value: float
    low: float
    high: float


NOTHING = Bounded(math.nan, math.nan, math.nan)


def in_size(values: np.ndarray) -> tuple[np.ndarray, float]:
    """Values (n,) of which the greatest is about 1, and the power of two that makes them the given ones.

    Their powers neither overflow nor vanish, whatever the unit; no digit is lost.
    """
    exponent = min(max(int(np.frexp(np.abs(values).max())[1]), -1021), 1023)
    return np.ldexp(values, -exponent), math.ldexp(1.0, exponent)


def mean(values: np.ndarray) -> Bounded:
    """Mean of values (n,)."""
    n = len(values)
    if not n:
        return NOTHING
    sized, size = in_size(values)
    middle = size * float(sized.mean())
    if n == 1:
        return Bounded(middle, math.nan, math.nan)
    half = size * float(stats.t.ppf(0.5 + CONFIDENCE / 2, n - 1) * sized.std(ddof=1) / math.sqrt(n))
    return Bounded(middle, middle - half, middle + half)


def sd(values: np.ndarray) -> Bounded:
    """Standard deviation of the population from which values (n,) were drawn."""
    n = len(values)
    if n < 2:
        return NOTHING
    sized, size = in_size(values)
    off, finer = in_size(sized - sized.mean())
    variance = float(off @ off) / (n - 1)
    if variance == 0.0:
        return Bounded(0.0, 0.0, 0.0)
    # the variance of the variance is (mu4 - sigma^4)/n; its logarithm is the more normal one
    relative = math.sqrt(max(float((off**4).mean()) / variance**2 - 1.0, 0.0) / n)
    factor = math.exp(0.5 * float(stats.norm.ppf(0.5 + CONFIDENCE / 2)) * relative)
    spread = size * (finer * math.sqrt(variance))
    return Bounded(spread, spread / factor, spread * factor)


def quantile(values: np.ndarray, share: float) -> Bounded:
    """Value that a share of the population does not exceed, from increasing values (n,).

    A bound is infinite where there are too few values to give one.
    """
    n = len(values)
    if not n:
        return NOTHING
    low, high = (int(stats.binom.ppf(p, n, share)) for p in (0.5 - CONFIDENCE / 2, 0.5 + CONFIDENCE / 2))
    return Bounded(
        float(np.quantile(values, share)),
        float(values[low - 1]) if low > 0 else -math.inf,
        float(values[high]) if high < n else math.inf,
    )


def share(count: int, n: int, unknown: int = 0) -> Bounded:
    """Share of the population, of which `count` of n were found, and of `unknown` more it is not known.

    The value counts the unknown ones as not found, the upper bound as found.
    """
    total = n + unknown
    if not total:
        return NOTHING
    low = stats.binomtest(count, total).proportion_ci(CONFIDENCE, "exact").low
    high = stats.binomtest(count + unknown, total).proportion_ci(CONFIDENCE, "exact").high
    return Bounded(count / total, float(low), float(high))


class Statistics(NamedTuple):
    """What is known of an output from n finite values."""

    n: int
    mean: Bounded
    sd: Bounded
    least: float
    most: float
    quantiles: dict[float, Bounded]  # by share


def statistics(values: np.ndarray) -> Statistics:
    """Statistics of values (m,), of which those that are not finite are left out."""
    finite = np.sort(values[np.isfinite(values)])
    n = len(finite)
    ends = (float(finite[0]), float(finite[-1])) if n else (math.nan, math.nan)
    return Statistics(n, mean(finite), sd(finite), *ends, {p: quantile(finite, p) for p in QUANTILES})
