"""Arithmetic of expressions that never raises: outside its domain it gives what C would give, nan or inf."""

from __future__ import annotations

import math

from rattle.jit.functions import compiled

NAN = math.nan
INF = math.inf
LARGEST = 709.78  # exp of more than this is inf
WHOLE = 2.0**52  # numbers of this size and beyond have no fraction


@compiled
def quotient(x, y):
    """x / y [SI]; inf or nan for y = 0."""
    if y != 0.0:
        return x / y
    if x == 0.0 or x != x:
        return NAN
    return math.copysign(INF, x) * math.copysign(1.0, y)


@compiled
def power_of_size(size, y):
    """size ** y [SI] for a size that is not negative, and not nan."""
    if size == 0.0:
        return 0.0 if y > 0.0 else INF
    exponent = y * math.log(size)
    if exponent > LARGEST:
        return INF
    if exponent != exponent:
        return 1.0
    if exponent == -INF or abs(y) == INF or size == INF:
        return 0.0
    return math.pow(size, y)


@compiled
def power(x, y):
    """x ** y [SI]; nan for a negative x with an exponent that is not an integer."""
    if y == 0.0 or x == 1.0:
        return 1.0
    if x != x or y != y:
        return NAN
    result = power_of_size(abs(x), y)
    if x < 0.0 and abs(y) < INF:
        if y % 1.0 != 0.0:
            return NAN
        if y % 2.0 != 0.0:
            return -result
    return result


@compiled
def whole(x):
    """Largest integer that is not above x."""
    return float(math.floor(x)) if abs(x) < WHOLE else x


@compiled
def wave(x):
    """Distance of x from the nearest integer, positive from an even integer to the next, negative from an odd one."""
    nearest = whole(x + 0.5)
    return x - nearest if nearest % 2.0 == 0.0 else nearest - x


@compiled
def held(side, x):
    """Largest integer not above x, where `wave` of x has this sign, or had it less than half ago."""
    n = whole(x)
    if (n % 2.0 == 0.0) == (side > 0):
        return n
    return n - 1.0 if x - n < 0.5 else n + 1.0


@compiled
def heading(s, ds, dds):
    """Side of a switching function s with time derivatives ds, dds: the sign of the first of them that is not zero.

    At s = 0 this is the side that s enters next; 0 if it stays at zero or is nan.
    """
    for n in range(3):
        value = s if n == 0 else (ds if n == 1 else dds)
        if value > 0.0:
            return 1
        if value < 0.0:
            return -1
        if value != value:
            return 0
    return 0
