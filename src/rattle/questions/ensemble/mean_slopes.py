"""How the mean of an output changes with each parameter, from the samples of an ensemble.

Where single motions are chaotic a derivative of one of them says nothing, but that of their mean exists.  With
independent parameters p_i and polynomials phi_ij(p_i) that are orthonormal over their fields (see `first_order`),

    F = c_0 + sum_ij c_ij phi_ij(p_i) + rest,      s_i = Cov(F, p_i)/Var(p_i) = c_i1 phi_i1'

is the derivative of the mean of F by p_i, averaged over the field with most weight at its middle; where the mean is
straight it is the derivative itself.  Higher polynomials take from the rest what would widen the bounds.

Source: Yitzhaki, Journal of Business & Economic Statistics 14 (1996) 478-486 (weights of s_i); Long, Ervin, The
American Statistician 54 (2000) 217-224 (bounds, HC3).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy import stats

from rattle.errors import InputError
from rattle.questions.ensemble.contributors import labels, members
from rattle.questions.ensemble.fields import Fields
from rattle.questions.ensemble.first_order import OWN, SAMPLES_PER_TERM, SINGULAR, polynomials
from rattle.questions.ensemble.statistics import CONFIDENCE, Bounded, in_size

HIGHEST = 3  # degree
STILL = 1e-12  # share of an output by which it varies that is rounding
PER_TERM = 20  # samples from which on a higher degree is taken


def mean_slopes(fields: Fields, columns: Sequence[np.ndarray], values: np.ndarray) -> dict[str, Bounded]:
    """d mean/dp [SI] with 95 % bounds, by parameter, or by group "l2, l3" with respect to its first one.

    columns: k parameters (n,); values: the output (n,) [SI], samples without a finite one are left out.
    Raises InputError if there are too few samples, or a parameter is the same in all.
    """
    finite = np.isfinite(values)
    y, first, names = np.asarray(values[finite], dtype=float), [places[0] for places in members(fields)], labels(fields)
    n, d = len(y), len(names)
    if n < (least := SAMPLES_PER_TERM * (d + 1)):
        raise InputError(f"{n} samples with a finite value are too few for {d} slopes; run at least {least}")
    sized, size = in_size(y)
    if np.ptp(sized) <= STILL:
        return dict.fromkeys(names, Bounded(0.0, 0.0, 0.0))
    degree = min(HIGHEST, max(1, n // (PER_TERM * d)))
    terms = [polynomials(fields.fields[k], columns[k][finite], degree) for k in first]
    if why := next((name for name, table in zip(names, terms, strict=True) if not table.shape[1]), ""):
        raise InputError(f"'{why}' has one value in all samples: nothing follows from it")
    q, triangle = np.linalg.qr(np.column_stack([np.ones(n), *terms]))
    if np.abs(np.diag(triangle)).min() < SINGULAR * math.sqrt(n):
        raise InputError("a parameter has the same value in all samples that could be run")
    back = np.linalg.inv(triangle)
    coefficients = back @ (q.T @ sized)
    away = 1.0 - (q**2).sum(axis=1)
    foretold = (sized - q @ (q.T @ sized)) / np.maximum(away, SINGULAR)
    errors = np.sqrt((((q * foretold[:, None]) @ back.T) ** 2).sum(axis=0))
    if away.min() < OWN:  # a sample that determines the fit at its own place says nothing of its error
        errors[:] = np.inf
    wide = float(stats.t.ppf(0.5 + CONFIDENCE / 2.0, n - len(back)))
    place, slopes = 1, {}
    for k, name, table in zip(first, names, terms, strict=True):
        ends = polynomials(fields.fields[k], np.array([fields.fields[k].low, fields.fields[k].high]), 1)[:, 0]
        steep = size * float(np.diff(ends)[0] / (fields.fields[k].high - fields.fields[k].low))
        value, half = steep * float(coefficients[place]), wide * abs(steep) * float(errors[place])
        slopes[name] = Bounded(value, value - half, value + half)
        place += table.shape[1]
    return slopes
