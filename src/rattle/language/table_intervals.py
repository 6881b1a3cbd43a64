"""Interval arithmetic for tables: bounds of their value, rate and knot coordinate over a span of time."""

from __future__ import annotations

import math

from rattle.jit.functions import compiled
from rattle.language.arithmetic import INF, NAN, quotient, whole
from rattle.language.span import Span, chain, least, most, product, whole_span
from rattle.language.table_reading import KNOTS, PER_SEGMENT, PERIOD, knot_coordinate


@compiled
def inside(const, k, x):
    """The part of a span that lies in the table whose block begins at const[k]: only there it has a value."""
    start, end = const[k + KNOTS], const[k + KNOTS + int(const[k])]
    if const[k + PERIOD] > 0.0 or not (x.low <= end and x.high >= start):
        return x
    return Span(max(x.low, start), min(x.high, end), x.slow, x.fast)


@compiled
def knot_span(const, k, x):
    """Knot coordinate of the table whose block begins at const[k], where x is inside of it; nan if it is nowhere."""
    x = inside(const, k, x)
    low, high = knot_coordinate(const, k, x.low), knot_coordinate(const, k, x.high)
    first, last = segments(const, k, whole(low), whole(high))
    if first > last:
        return Span(NAN, NAN, NAN, NAN)
    narrow, wide = INF, 0.0
    for segment in range(first, last + 1):
        width = segment_width(const, k, segment)
        narrow, wide = min(narrow, width), max(wide, width)
    return chain(low, high, 1.0 / wide, 1.0 / narrow, x)


@compiled
def table_span(const, k, x, side):
    """Value of the table whose block begins at const[k]; side: of its switch, 0 if not known."""
    x = inside(const, k, x)
    z = Span(knot_coordinate(const, k, x.low), knot_coordinate(const, k, x.high), 0.0, 0.0)
    numbers = whole_span(z, side)
    first, last = segments(const, k, numbers.low, numbers.high)
    if first > last or x.low != x.low or x.high != x.high:
        return Span(NAN, NAN, NAN, NAN)
    every = last - first + 1 >= int(const[k]) and const[k + PERIOD] > 0.0
    low, high, slope_low, slope_high = INF, -INF, INF, -INF
    for segment in range(first, last + 1):
        start, width = segment_start(const, k, segment), segment_width(const, k, segment)
        a = x.low - start if segment == first and not every else 0.0
        b = x.high - start if segment == last and not every else width
        down, up, falls, rises = cubic_bounds(const, coefficients(const, k, segment), a, b)
        low, high = least(down, low), most(up, high)
        slope_low, slope_high = least(falls, slope_low), most(rises, slope_high)
    slow, fast = product(slope_low, slope_high, x.slow, x.fast)
    return Span(low, high, slow, fast)


@compiled
def segments(const, k, low, high):
    """First and last of the segments low..high of a table, at most one turn of them; none (1, 0) if they are nan."""
    n = int(const[k])
    if not (abs(low) < INF and abs(high) < INF):
        return 1, 0
    if const[k + PERIOD] > 0.0:
        first = int(low)
        return first, first + int(min(high - low, n - 1.0))
    # nothing lies beyond the last knot, and a span that ends there is in one segment
    return int(max(0.0, min(low, n - 1.0))), int(max(0.0, min(high, n - 1.0)))


@compiled
def place_in_turn(const, k, segment):
    """The number of a segment in its turn, and that turn."""
    n = int(const[k])
    turn = segment // n if const[k + PERIOD] > 0.0 else 0
    return segment - turn * n, turn


@compiled
def segment_width(const, k, segment):
    """Width of a segment."""
    i, _ = place_in_turn(const, k, segment)
    return const[k + KNOTS + i + 1] - const[k + KNOTS + i]


@compiled
def segment_start(const, k, segment):
    """Where a segment begins."""
    i, turn = place_in_turn(const, k, segment)
    return turn * const[k + PERIOD] + const[k + KNOTS + i]


@compiled
def coefficients(const, k, segment):
    """Place of the coefficients of a segment."""
    i, _ = place_in_turn(const, k, segment)
    return k + KNOTS + int(const[k]) + 1 + PER_SEGMENT * i


@compiled
def cubic_bounds(const, k, a, b):
    """Least and greatest value, and slope, of the cubic whose coefficients begin at const[k], between a and b."""
    c1, c2, c3 = const[k + 1], const[k + 2], const[k + 3]
    root = math.sqrt(max(c2 * c2 - 3.0 * c1 * c3, 0.0))
    q = -(c2 + root) if c2 >= 0.0 else -(c2 - root)
    low, high, slope_low, slope_high = INF, -INF, INF, -INF
    # both ends, two extremes of the value, one of the slope
    for u in (a, b, quotient(q, 3.0 * c3), quotient(c1, q), quotient(-c2, 3.0 * c3)):
        x = min(max(u if abs(u) < INF else a, a), b)
        value = const[k] + x * (c1 + x * (c2 + x * c3))
        slope = c1 + x * (2.0 * c2 + x * 3.0 * c3)
        low, high = least(value, low), most(value, high)
        slope_low, slope_high = least(slope, slope_low), most(slope, slope_high)
    return low, high, slope_low, slope_high
