"""Bounds of a value and of its rate over a span of time, and those of counted numbers.

Bounds hold for exact arithmetic; who uses them allows for rounding.  nan means that there is no value in the span.
"""

from __future__ import annotations

from typing import NamedTuple

from rattle.jit.functions import compiled
from rattle.language.arithmetic import INF, NAN, held, quotient, whole


class Span(NamedTuple):
    """Bounds of a value [SI] and of its time derivative [SI] over a span of time."""

    low: float
    high: float
    slow: float  # lower bound of the rate
    fast: float  # upper bound of the rate


@compiled
def least(a, b):
    """The smaller number; nan if one is nan."""
    return a if a <= b or a != a else b


@compiled
def most(a, b):
    """The larger number; nan if one is nan."""
    return a if a >= b or a != a else b


@compiled
def product(a, b, c, d):
    """Bounds of [a, b] * [c, d]; zero times infinity is zero, because an infinite bound is never reached."""
    if a != a or b != b or c != c or d != d:
        return NAN, NAN
    ac, ad, bc, bd = a * c, a * d, b * c, b * d
    ac = 0.0 if ac != ac else ac
    ad = 0.0 if ad != ad else ad
    bc = 0.0 if bc != bc else bc
    bd = 0.0 if bd != bd else bd
    return least(least(ac, ad), least(bc, bd)), most(most(ac, ad), most(bc, bd))


@compiled
def chain(low, high, slope_low, slope_high, x):
    """Chain rule: a function of the span x with values low..high and derivative slope_low..slope_high."""
    slow, fast = product(slope_low, slope_high, x.slow, x.fast)
    return Span(low, high, slow, fast)


@compiled
def steady(value):
    """The span of a number that does not change."""
    return Span(value, value, 0.0, 0.0)


@compiled
def wave_span(x):
    """`bytecode.wave`: it rises at the rate of x around even integers, and falls around odd ones."""
    if x.low != x.low or x.high != x.high:
        return Span(NAN, NAN, NAN, NAN)
    first, last = whole(x.low + 0.5), whole(x.high + 0.5)  # nearest integers
    rises, ends_rising = first % 2.0 == 0.0, last % 2.0 == 0.0
    a = x.low - first if rises else first - x.low
    b = x.high - last if ends_rising else last - x.high
    if not last > first:
        slow, fast = (x.slow, x.fast) if rises else (-x.fast, -x.slow)
        return Span(least(a, b), most(a, b), slow, fast)
    several = last > first + 1.0  # with the peaks between the nearest integers
    low = -0.5 if several or not rises else least(a, b)
    high = 0.5 if several or rises else most(a, b)
    size = most(abs(x.slow), abs(x.fast))
    return Span(low, high, -size, size)


@compiled
def whole_span(x, side):
    """floor(x): the integer of its parity where the side is known, otherwise all from floor(low) to floor(high).

    At the ends of a span x may be beyond that integer by rounding; see `bytecode.held`.
    """
    if side != 0:
        a, b = held(side, x.low), held(side, x.high)
        return Span(least(a, b), most(a, b), 0.0, 0.0)
    low, high = whole(x.low), whole(x.high)
    leap = INF if high > low else 0.0
    return Span(low, high, -leap, leap)


# ---------------------------------------------------------------- arithmetic
@compiled
def negative(x):
    """-x."""
    return Span(-x.high, -x.low, -x.fast, -x.slow)


@compiled
def minus(x, y):
    """x - y."""
    return Span(x.low - y.high, x.high - y.low, x.slow - y.fast, x.fast - y.slow)


@compiled
def times(x, y):
    """x y."""
    low, high = product(x.low, x.high, y.low, y.high)
    slow, fast = product(x.slow, x.fast, y.low, y.high)
    down, up = product(x.low, x.high, y.slow, y.fast)
    return Span(low, high, slow + down, fast + up)


@compiled
def reciprocal(low, high):
    """1 / [low, high]; -inf..inf if zero lies inside."""
    if low <= 0.0 and high >= 0.0:
        return -INF, INF
    return quotient(1.0, high), quotient(1.0, low)


@compiled
def over(x, y):
    """x / y."""
    a, b = reciprocal(y.low, y.high)
    low, high = product(x.low, x.high, a, b)
    down, up = product(low, high, y.slow, y.fast)
    slow, fast = product(x.slow - up, x.fast - down, a, b)
    return Span(low, high, slow, fast)


@compiled
def square(low, high):
    """[low, high]**2."""
    a, b = low * low, high * high
    return 0.0 if low <= 0.0 and high >= 0.0 else least(a, b), most(a, b)


# ---------------------------------------------------------------- switches
@compiled
def joined(x, y, leaps):
    """What holds both spans; leaps: True if the value jumps from one to the other."""
    slow = -INF if leaps else least(x.slow, y.slow)
    fast = INF if leaps else most(x.fast, y.fast)
    return Span(least(x.low, y.low), most(x.high, y.high), slow, fast)


@compiled
def switched(side, s, above, below, still, leaps):
    """A switch with the switching function s on a side, or both branches if its side is not known.

    above, below, still: spans for s > 0, s < 0 and s = 0.  leaps: True if the value jumps between the first two.
    """
    way = side
    if side == 0:
        way = 1 if s.low > 0.0 else (-1 if s.high < 0.0 else 0)
    if way > 0:
        return above
    if way < 0:
        return below
    if s.low == 0.0 and s.high == 0.0:  # the switching function stays at zero
        return still
    return joined(above, below, leaps)
