"""First-order indices from the samples of an ensemble: what each contributor alone causes of an output's variance.

    S_i = Var(E(F | x_i))/Var(F)

The independent contributors x_i of an ensemble make the output a sum of functions f_i of one contributor each and of a
rest, all uncorrelated.  The f_i are fitted together, as sums of polynomials that are orthonormal for the distribution
of x_i, so that effects of any form are met, also those that rise and fall again:

    F = c_0 + sum_i sum_j c_ij phi_ij(x_i) + rest,      Var f_i = sum_j (c_ij^2 - Var c_ij)

The second term takes away what chance adds to the squares.  The degree, the same for all, is the one that foretells
samples best that are left out of the fit.  What the rest keeps are interactions, and what the degree cannot follow.

Bounds hold the index with 95 % confidence, for independent draws: coefficients are drawn from their normal
distribution, whose covariance takes residuals of any distribution into account (HC3).  They do not know what the degree
cannot follow: with less than some 20 samples per contributor they are rather too narrow.

Source: Sobol, Math. Comput. Simul. 55 (2001) 271-280 (decomposition); Li, Wang, Rabitz, J. Phys. Chem. A 106 (2002)
8721-8733 (orthonormal polynomials from random samples); Allen, Technometrics 16 (1974) 125-127 (samples left out);
Long, Ervin, The American Statistician 54 (2000) 217-224 (HC3); Iman, Conover, Technometrics 21 (1979) 499-509 (ranks).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle.errors import InputError
from rattle.jit.choices import TINY
from rattle.questions.ensemble.contributors import labels, members
from rattle.questions.ensemble.fields import Field, Fields
from rattle.questions.ensemble.statistics import CONFIDENCE, Bounded, in_size

HIGHEST = 20  # degree
SAMPLES_PER_TERM = 3  # at least
CELLS = 20_000_000  # numbers of the largest table of polynomials
NODES = 4096  # of the distribution of a field
FEW, MOST = 0.01, 0.5  # ranks are taken where this share of the samples carries more than that share of the variance
DRAWS = 2000  # of the coefficients
SINGULAR = 1e-9  # root mean square below which a polynomial adds nothing but rounding to those before it
ADDS = 0.5  # root mean square, at least, of what a polynomial adds where the samples are: they must tell it from others
OWN = 0.25  # 1 - leverage, at least: a sample must not determine the fit at its own place


class Fit(NamedTuple):
    """All contributors with polynomials to one degree."""

    degree: int
    rest: np.ndarray  # (n,) values minus the fit
    foretold: np.ndarray  # (n,) values minus the fit to all other samples


class FirstOrder(NamedTuple):
    """First-order indices [-] of d contributors."""

    names: tuple[str, ...]  # (d,) parameters, or those of a group: "l2, l3"
    indices: tuple[Bounded, ...]  # (d,)
    explained: Bounded  # their sum; what is missing to 1 are interactions
    ranks: bool  # of the ranks of the output, not of its values
    degree: int
    n: int  # samples from which they come


def first_order(
    fields: Fields, columns: Sequence[np.ndarray], values: np.ndarray, ranks: bool | None = None
) -> FirstOrder:
    """Indices from parameters, k columns (n,), and an output (n,) [SI]; samples without a finite output are left out.

    ranks: take the ranks of the values instead of the values; None: where a few samples carry most of the variance,
    whose shares would say nothing of all others.
    Raises InputError if there are too few samples, or nothing varies.
    """
    finite = np.isfinite(values)
    y = np.asarray(values[finite], dtype=float)
    first, names = [places[0] for places in members(fields)], labels(fields)
    least = SAMPLES_PER_TERM * (len(names) + 1)
    if len(y) < least:
        raise InputError(
            f"{len(y)} samples with a finite value are too few to tell {len(names)} contributors apart; "
            f"run at least {least}"
        )
    if np.ptp(y) == 0.0:
        raise InputError(f"all {len(y)} samples have the value {y[0]:.6g}: nothing varies that could be shared")
    y, _ = in_size(y)
    ranks = carried_by_few(y) if ranks is None else ranks
    if ranks:
        from scipy.stats import rankdata

        y = rankdata(y)
    terms = [polynomials(fields.fields[k], columns[k][finite], _highest(len(y), len(names))) for k in first]
    indices, explained, degree = _shares(terms, (y - y.mean()) / y.std())
    return FirstOrder(names, indices, explained, ranks, degree, len(y))


def carried_by_few(y: np.ndarray) -> bool:
    """Whether a few of the values (n,) carry most of their variance."""
    squares = np.sort((y - y.mean()) ** 2)
    few = math.ceil(FEW * len(y))
    return bool(squares[-few:].sum() > MOST * squares.sum())


def _highest(n: int, d: int) -> int:
    """The highest degree that n samples of d contributors allow."""
    return max(1, min(HIGHEST, (n // SAMPLES_PER_TERM - 1) // d, CELLS // (n * d)))


def polynomials(field: Field, x: np.ndarray, degree: int) -> np.ndarray:
    """(n, <= degree) polynomials at x (n,) with mean 0 and mean square 1 over the field, uncorrelated there."""
    if field.values:
        nodes, weights = np.array(field.values), np.array(field.shares)
        degree = min(degree, len(np.unique(nodes)) - 1)
    else:
        nodes, weights = field.quantile((np.arange(NODES) + 0.5) / NODES), np.full(NODES, 1.0 / NODES)
    middle, half = 0.5 * (field.low + field.high), 0.5 * (field.high - field.low)
    if not half > 0.0:
        return np.zeros((len(x), 0))

    def table(at: np.ndarray) -> np.ndarray:
        return np.polynomial.legendre.legvander((at - middle) / half, degree)

    triangle = np.linalg.qr(np.sqrt(weights)[:, None] * table(nodes), mode="r")
    triangle *= np.sign(np.diag(triangle))[:, None]
    return np.asarray(np.linalg.solve(triangle.T, table(x).T).T[:, 1:])


def _shares(terms: list[np.ndarray], y: np.ndarray) -> tuple[tuple[Bounded, ...], Bounded, int]:
    """Indices of contributors with their polynomials (n, p_i), their sum, and the degree, from values y (n,)."""
    n = len(y)
    place = [(j, i) for i, polynomials in enumerate(terms) for j in range(polynomials.shape[1])]
    place.sort()  # all of degree 1, then all of degree 2: models contain those before them
    table = np.column_stack([np.ones(n), *(terms[i][:, j] for j, i in place)])
    q, triangle = np.linalg.qr(table)
    degrees = np.array([0, *(j + 1 for j, _ in place)])
    new = np.abs(np.diag(triangle)) / math.sqrt(n)  # what a polynomial adds to those before it; 1 over the field
    unclear = np.flatnonzero(new < np.where(degrees > 1, ADDS, SINGULAR))
    usable = degrees[unclear[0]] - 1 if len(unclear) else degrees[-1]
    fits: list[Fit] = []
    for degree in range(1, int(usable) + 1):
        last = int(np.searchsorted(degrees, degree, side="right"))
        rest = y - q[:, :last] @ (q[:, :last].T @ y)
        away = 1.0 - (q[:, :last] ** 2).sum(axis=1)
        if away.min() < (OWN if fits else SINGULAR):
            break
        fits.append(Fit(degree, rest, rest / away))
    if not fits:
        raise InputError("a parameter has the same value in all samples that could be run")
    degree, rest, foretold = min(fits, key=lambda fit: float(fit.foretold @ fit.foretold))
    last = int(np.searchsorted(degrees, degree, side="right"))
    back = np.linalg.inv(triangle[:last, :last])
    coefficients = (back @ (q[:, :last].T @ y))[1:]
    influence = (q[:, :last] * foretold[:, None] @ back.T)[:, 1:]  # (n, terms) of a sample on a coefficient
    variance = float(rest @ rest) / (n - last)
    spread = np.column_stack([influence, (rest**2 - (rest @ rest) / n) / n])
    owner = np.array([i for _, i in place[: last - 1]])
    indices, explained = _bounded(coefficients, variance, spread.T @ spread, owner, len(terms))
    return indices, explained, degree


def _bounded(
    coefficients: np.ndarray, variance: float, covariance: np.ndarray, owner: np.ndarray, d: int
) -> tuple[tuple[Bounded, ...], Bounded]:
    """Indices and their sum from coefficients (p,) and the variance of the rest; covariance (p + 1, p + 1) of all."""
    own = np.diag(covariance)[:-1]
    sizes, vectors = np.linalg.eigh(covariance)
    normal = np.random.Generator(np.random.PCG64(0)).standard_normal((DRAWS, len(sizes)))
    drawn = normal * np.sqrt(np.maximum(sizes, 0.0)) @ vectors.T
    rows = np.zeros((len(owner), d))
    rows[np.arange(len(owner)), owner] = 1.0

    def shares(squares: np.ndarray, rest: np.ndarray) -> np.ndarray:
        parts = squares @ rows
        whole = parts.sum(axis=-1) + np.maximum(rest, 0.0)
        return np.asarray(np.column_stack([parts, parts.sum(axis=-1)]) / np.maximum(whole, TINY)[:, None])

    value = shares((coefficients**2 - own)[None], np.array([variance]))[0]
    every = shares((coefficients + drawn[:, :-1]) ** 2 - 2.0 * own, variance + drawn[:, -1])
    low, high = np.quantile(every, [0.5 - CONFIDENCE / 2, 0.5 + CONFIDENCE / 2], axis=0)
    value, low, high = (np.clip(part, 0.0, 1.0) for part in (value, low, high))
    bounded = [
        Bounded(*map(float, ends)) for ends in zip(value, np.minimum(low, value), np.maximum(high, value), strict=True)
    ]
    return tuple(bounded[:-1]), bounded[-1]
