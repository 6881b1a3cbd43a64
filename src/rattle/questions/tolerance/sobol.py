"""Sobol indices: shares of the variance of an output that contributors cause.

    first   S_i = Var(E(F | x_i))/Var(F)        what fixing x_i would take away on average, alone
    total   T_i = E(Var(F | all but x_i))/Var(F)    the same with all interactions

from n rows of points: A and B independent, A_i = A with column i from B; n (d + 2) runs.  Intervals hold the index
with 95 % confidence: the rows are drawn again with replacement, with a fixed seed (percentile bootstrap).  Rows of
Sobol's sequence spread more evenly than independent ones, so that the intervals are as a rule too wide.

Source: Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Comm. 181 (2010) 259-270,
table 2 (b), (f), as in scipy.stats.sobol_indices; Archer, Saltelli, Sobol, J. Statist. Comput. Simul. 58 (1997) 99-120
(bootstrap).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rattle.questions.ensemble.fields import Fields
from rattle.questions.ensemble.sampling import Points, points

RESAMPLES = 1000
CONFIDENCE = 0.95
AT_ONCE = 2**22  # numbers of a batch of resamples


class Indices(NamedTuple):
    """Sobol indices [-] of d contributors with bounds, nan where there are none."""

    first: np.ndarray  # (d,)
    first_low: np.ndarray
    first_high: np.ndarray
    total: np.ndarray
    total_low: np.ndarray
    total_high: np.ndarray
    rows: int  # n from which they come


class Rows:
    """Rows of points for the indices: row j has points A_j, B_j and A_ij, d of them."""

    def __init__(self, fields: Fields, seed: int, most: int) -> None:
        self.fields = fields
        self.d = fields.draws
        self._points: Points = points("sobol", seed, 2 * self.d, most)

    def values(self, first: int, last: int) -> np.ndarray:
        """(k, (d + 2) n) values [SI] of rows `first` to before `last`: all A, all B, then A_1, A_2 ..."""
        both = self._points.points(first, last)
        a, b = both[:, : self.d], both[:, self.d :]
        mixed = [np.where(np.arange(self.d) == i, b, a) for i in range(self.d)]
        return self.fields.values(np.concatenate([a, b, *mixed]))


def indices(outputs: np.ndarray, seed: int) -> Indices:
    """Indices from outputs (d + 2, n) [SI] at the rows; n a power of two, at least 2, all finite."""
    d, n = len(outputs) - 2, outputs.shape[1]
    generator = np.random.Generator(np.random.PCG64(seed))
    batch = max(AT_ONCE // outputs.size, 1)
    estimates = [_estimates(outputs, np.arange(n)[None])]
    for done in range(0, RESAMPLES, batch):
        estimates.append(_estimates(outputs, generator.integers(n, size=(min(batch, RESAMPLES - done), n))))
    every = np.concatenate(estimates, axis=1)  # (first | total, 1 + resamples, d)
    low, high = np.quantile(every[:, 1:], [0.5 - CONFIDENCE / 2, 0.5 + CONFIDENCE / 2], axis=1)
    assert every.shape == (2, 1 + RESAMPLES, d)
    return Indices(every[0, 0], low[0], high[0], every[1, 0], low[1], high[1], n)


def unknown(d: int) -> Indices:
    """Indices that cannot be given."""
    nothing = np.full(d, np.nan)
    return Indices(nothing, nothing, nothing, nothing, nothing, nothing, 0)


def _estimates(outputs: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """(2, r, d) first and total indices from r sets of rows (r, n)."""
    from scipy.stats import sobol_indices

    # one more set: a single one of a single contributor would lose its axes
    taken = outputs[:, np.concatenate([chosen, chosen[:1]])]  # (d + 2, r + 1, n)
    sampled = {"f_A": taken[0], "f_B": taken[1], "f_AB": taken[2:]}
    result = sobol_indices(func=sampled, n=outputs.shape[1])
    shape = (len(chosen) + 1, len(outputs) - 2)
    return np.array([np.reshape(index, shape)[:-1] for index in (result.first_order, result.total_order)])
