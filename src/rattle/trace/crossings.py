"""Zeros between known brackets, many side by side; each one by itself, so that none depends on its neighbours."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

CLOSE = 1e-11  # distance of a zero from the true one [shares of the step]
MOST = 80  # evaluations; bisection alone takes 37


def bracketed(
    f: Callable[[np.ndarray], np.ndarray], a: np.ndarray, b: np.ndarray, fa: np.ndarray, fb: np.ndarray
) -> np.ndarray:
    """The zeros of f between a and b, (k,), where f is positive at one end and not at the other.

    Inverse quadratic interpolation where it is safe, else bisection.
    Source: Chandrupatla, Advances in Engineering Software 28 (1997) 145-149.
    """
    x1, f1, x2, f2 = b, fb, a, fa
    roots, done = np.zeros_like(a), np.zeros(a.shape, dtype=bool)
    with np.errstate(all="ignore"):
        share = f1 / (f1 - f2)  # the secant first
        for _ in range(MOST):
            nearer = np.abs(f2) < np.abs(f1)
            best, least = np.where(nearer, x2, x1), np.where(nearer, f2, f1)
            limit = CLOSE / np.abs(x2 - x1)
            roots = np.where(done, roots, best)
            done |= (limit > 0.5) | (least == 0.0)
            if done.all():
                break
            share = np.where(share > limit, share, limit)
            share = np.where(share < 1.0 - limit, share, 1.0 - limit)
            x = x1 + share * (x2 - x1)
            value = f(x)
            same = (value > 0.0) == (f1 > 0.0)
            x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
            x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
            x1, f1 = x, value
            xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
            smooth = (phi * phi < xi) & ((1.0 - phi) * (1.0 - phi) < 1.0 - xi)
            inverse = f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
            share = np.where(smooth, inverse, 0.5)
    return roots
