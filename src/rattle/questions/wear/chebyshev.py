"""Stabilised explicit method for y' = f(y) whose fast rates are real and decay: Runge-Kutta-Chebyshev, second order.

A step with s stages is stable while step times fastest rate stays below about 0.65 s^2.
Source: Sommeijer, Shampine, Verwer, RKC: an explicit solver for parabolic PDEs, J. Comput. Appl. Math. 88 (1998) 315.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rattle.jit.choices import TINY

Array = NDArray[np.float64]
DAMPING = 2.0 / 13.0
ROUNDING = 1e-12  # [of the span] what is left when all is done, and below which a step is none
MOST_STAGES = 60


def reach(stages: int) -> float:
    """Largest step times fastest rate at which a step is stable."""
    return 2.0 / 3.0 * (stages * stages - 1.0) * (1.0 - 2.0 * DAMPING / 15.0)


def integrate(
    f: Callable[[Array], Array], y: Array, span: float, rate: Callable[[Array], float], tolerance: float
) -> Array:
    """y after `span`; rate: bound on the fastest rate; tolerance: error per step, relative to the largest |y|.

    Raises ArithmeticError if steps become too small.
    """
    done, h, f0 = 0.0, span, f(y)
    while done < span * (1.0 - ROUNDING):
        h = min(h, span - done)
        fastest = rate(y)
        h = min(h, 0.9 * reach(MOST_STAGES) / fastest) if fastest > 0.0 else h
        stages = max(2, math.ceil(math.sqrt(1.0 + 1.6 * h * fastest)))
        new = _step(f, y, f0, h, stages)
        f1 = f(new)
        size = tolerance * max(float(np.abs(new).max()), TINY)
        error = float(np.abs(0.8 * (y - new) + 0.4 * h * (f0 + f1)).max()) / size
        if error <= 1.0:
            done, y, f0 = done + h, new, f1
        h *= min(5.0, max(0.1, 0.8 * error ** (-1.0 / 3.0))) if error > 0.0 else 5.0
        if not h > ROUNDING * span:
            raise ArithmeticError("steps of the worn profile became too small")
    return y


def _step(f: Callable[[Array], Array], y: Array, f0: Array, h: float, s: int) -> Array:
    """One step with s stages."""
    w0 = 1.0 + DAMPING / s**2
    t, dt, ddt = _chebyshev(s, w0)
    w1 = dt[s] / ddt[s]
    b = np.empty(s + 1)
    b[2:] = ddt[2:] / dt[2:] ** 2
    b[:2] = b[2]
    before, now = y, y + b[1] * w1 * h * f0
    for j in range(2, s + 1):
        mu, nu, last = 2.0 * b[j] * w0 / b[j - 1], -b[j] / b[j - 2], 2.0 * b[j] * w1 / b[j - 1]
        gamma = -(1.0 - b[j - 1] * t[j - 1]) * last
        before, now = now, (1.0 - mu - nu) * y + mu * now + nu * before + last * h * f(now) + gamma * h * f0
    return np.asarray(now)


def _chebyshev(s: int, w: float) -> tuple[Array, Array, Array]:
    """Chebyshev polynomials of degrees 0 to s at w, with first and second derivatives."""
    t, dt, ddt = np.zeros((3, s + 1))
    t[0], t[1], dt[1] = 1.0, w, 1.0
    for j in range(2, s + 1):
        t[j] = 2.0 * w * t[j - 1] - t[j - 2]
        dt[j] = 2.0 * t[j - 1] + 2.0 * w * dt[j - 1] - dt[j - 2]
        ddt[j] = 4.0 * dt[j - 1] + 2.0 * w * ddt[j - 1] - ddt[j - 2]
    return t, dt, ddt
