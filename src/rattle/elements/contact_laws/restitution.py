"""Damping factor a of a hysteretic contact force, and the restitution x that a free impact then returns.

    F = F_static(delta) (1 + a ddelta/v0)           m dv/dt = -F,  v = ddelta from v0 to -x v0

    v dv / (1 + a v/v0) = -F_static ddelta / m      integrated over approach and return: the right sides
                                                    are equal and opposite for every F_static and m, so
    ln((1 + a)/(1 - x a)) = a (1 + x)

With psi(y) = 1/2 - (y - ln(1 + y))/y^2 = y/3 - y^2/4 + y^3/5 - ... this reads

    psi(a) - x^2 psi(-x a) = (1 - x)(1 + x)/2       free of cancellation as x -> 1 and a -> 0

The left side increases with x and with a, so either is found from the other by bisection, to the last bit.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

from rattle.errors import InputError
from rattle.language.recorded import as_number

LEAST_RESTITUTION = 1e-3  # a is about 1/x as x -> 0: smaller values are replaced by this one
SERIES = 0.1  # below it the closed form of psi loses digits and its series converges in 18 terms


def factor_returning(restitution: float) -> float:
    """Damping factor a [-] with which a free impact returns exactly this restitution [-].

    A restitution below 0.001 is taken as 0.001, where a = 1000 (a is infinite at 0).
    Raises InputError outside [0, 1].
    """
    x = max(float(checked(restitution)), LEAST_RESTITUTION)
    if x == 1.0:
        return 0.0

    # unknown: w = -ln(1 - x a), which is well resolved where x a is close to 1
    def excess(w: float) -> float:
        d = -math.expm1(-w)
        return _psi(d / x, math.log1p(d / x)) - x * x * _psi(-d, -w) - 0.5 * (1.0 - x) * (1.0 + x)

    return -math.expm1(-_bisected(excess, 1.0 + 1.0 / x)) / x


@functools.lru_cache(maxsize=64)
def restitution_returned(factor: float) -> float:
    """Restitution x [-] that a free impact returns under F_static (1 + a ddelta/v0), a = factor.

    Exact for every static force law, mass and speed.  Raises InputError for a negative factor.
    """
    a = float(factor)
    if not a >= 0.0:
        raise InputError(f"a damping factor of {factor} would add energy; it must not be negative")
    if a == 0.0 or math.isinf(a):
        return 1.0 if a == 0.0 else 0.0
    psi_a = _psi(a, math.log1p(a))

    def excess(x: float) -> float:
        if x * a >= 1.0:
            return math.inf
        return psi_a - x * x * _psi(-x * a, math.log1p(-x * a)) - 0.5 * (1.0 - x) * (1.0 + x)

    return _bisected(excess, min(1.0, 1.0 / a))


def checked(restitution: float) -> float:
    """The restitution [-] as a number, recorded or not.  Raises InputError unless it lies within [0, 1]."""
    e = as_number(restitution)
    if not 0.0 <= e <= 1.0:
        raise InputError(f"a restitution of {restitution} is outside 0 ... 1")
    return e


def _psi(y: float, log1p_y: float) -> float:
    if abs(y) > SERIES:
        return 0.5 - (y - log1p_y) / (y * y)
    total = 0.0
    for n in range(20, 2, -1):  # y/3 - y^2/4 + ..., 18 terms leave 1e-20
        total = y * (1.0 / n - total)
    return total


def _bisected(increasing: Callable[[float], float], high: float) -> float:
    """Root in (0, high) of an increasing function, by bisection to neighbouring floating-point numbers."""
    low = 0.0
    while low < (middle := 0.5 * (low + high)) < high:
        if increasing(middle) < 0.0:
            low = middle
        else:
            high = middle
    return high
