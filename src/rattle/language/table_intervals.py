"""Interval arithmetic for tables: bounds of their value, rate and knot coordinate over many spans of time at once."""

from __future__ import annotations

import math

import numpy as np

from rattle.language.span import Array, Span, whole_numbers
from rattle.language.table_reading import EDGE, KNOTS, PER_SEGMENT, PERIOD


def knot_span(const: Array, k: int, x: Span) -> Span:
    """Knot coordinate of the table whose block begins at const[k], where x is inside of it; nan if it is nowhere."""
    knots, _, period = _parts(const, k)
    x = _inside(knots, period, x)
    steps = np.diff(knots)
    low, high = (_coordinate(knots, period, one) for one in (x.low, x.high))
    rates = np.array([x.slow / steps.min(), x.slow / steps.max(), x.fast / steps.min(), x.fast / steps.max()])
    return Span(low, high, rates.min(axis=0), rates.max(axis=0))


def table_span(const: Array, k: int, x: Span, side: Array | None) -> Span:
    """Value of the table whose block begins at const[k]; side: of its switch, None if not known."""
    knots, c, period = _parts(const, k)
    x = _inside(knots, period, x)
    z = knot_span(const, k, x)
    segments = whole_numbers(z, side)
    known = np.isfinite(segments.low) & np.isfinite(segments.high)
    first, last = (np.where(known, one, 0.0).astype(np.int64) for one in (segments.low, segments.high))
    if period == 0.0:  # nothing lies beyond the last knot, and an interval that ends there is in one segment
        first, last = (np.clip(one, 0, len(c) - 1) for one in (first, last))
    bounds = _everywhere(knots, c)
    low, high, least, most = (np.full_like(x.low, one) for one in bounds)
    near = last - first <= 1  # beyond, the bounds of the whole table do
    one = _piece(knots, c, period, first[near], x.low[near], x.high[near], last[near] > first[near], False)
    two = _piece(knots, c, period, last[near], x.low[near], x.high[near], False, last[near] > first[near])
    for target, a, b, pick in zip((low, high, least, most), one, two, (np.minimum, np.maximum) * 2, strict=True):
        target[near] = pick(a, b)
    rates = np.array([least * x.slow, least * x.fast, most * x.slow, most * x.fast])
    unknown = ~known | np.isnan(x.low) | np.isnan(x.high)
    found = low, high, rates.min(axis=0), rates.max(axis=0)
    return Span(*(np.where(unknown, math.nan, one) for one in found))


def _parts(const: Array, k: int) -> tuple[Array, Array, float]:
    """Knots (n + 1,), coefficients (n, 4) and period of a table."""
    n, first = int(const[k]), k + KNOTS
    c = const[first + n + 1 : first + n + 1 + PER_SEGMENT * n].reshape(n, PER_SEGMENT)
    return const[first : first + n + 1], c, float(const[k + PERIOD])


def _inside(knots: Array, period: float, x: Span) -> Span:
    """The part of every span that lies in a table, where there is one: only there the table has a value."""
    if period > 0.0:
        return x
    meets = (x.low <= knots[-1]) & (x.high >= knots[0])
    low = np.where(meets, np.maximum(x.low, knots[0]), x.low)
    return Span(low, np.where(meets, np.minimum(x.high, knots[-1]), x.high), x.slow, x.fast)


def _coordinate(knots: Array, period: float, x: Array) -> Array:
    """Knot coordinate z(x), see `language.tables`."""
    n = len(knots) - 1
    turns = np.floor((x - knots[0]) / period) if period > 0.0 else 0.0 * x
    x = x - turns * period
    slack = EDGE * (knots[-1] - knots[0])
    outside = ~((x >= knots[0] - slack) & (x <= knots[-1] + slack))
    i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, n - 1)
    z = turns * n + i + (x - knots[i]) / (knots[i + 1] - knots[i])
    return np.where(outside, math.nan, z)


def _piece(
    knots: Array, c: Array, period: float, segment: Array, low: Array, high: Array, to_end: Array | bool,
    from_start: Array | bool,
) -> tuple[Array, Array, Array, Array]:  # fmt: skip
    """Bounds of value and slope on the part low..high of a segment; to_end, from_start: on all of it on that side."""
    n = len(knots) - 1
    turns = np.floor(segment / n) if period > 0.0 else 0.0
    i = np.clip(segment - (turns * n if period > 0.0 else 0), 0, n - 1).astype(np.int64)
    shift = turns * period + knots[i]
    a = np.where(from_start, 0.0, low - shift)
    b = np.where(to_end, knots[i + 1] - knots[i], high - shift)
    return _cubic_bounds(c[i].T, a, b)


def _everywhere(knots: Array, c: Array) -> tuple[float, float, float, float]:
    """Bounds of value and slope of a whole table."""
    low, high, least, most = _cubic_bounds(c.T, 0.0 * knots[1:], np.diff(knots))
    return float(low.min()), float(high.max()), float(least.min()), float(most.max())


def _cubic_bounds(c: Array, a: Array, b: Array) -> tuple[Array, Array, Array, Array]:
    """Least and greatest value, and slope, of the cubics c (4, m) between a and b (m,)."""
    root = np.sqrt(np.maximum(c[2] * c[2] - 3.0 * c[1] * c[3], 0.0))
    q = -(c[2] + np.where(c[2] >= 0.0, root, -root))
    with np.errstate(divide="ignore", invalid="ignore"):
        extremes = q / (3.0 * c[3]), c[1] / q, -c[2] / (3.0 * c[3])  # of the value (two), of the slope
    ends = [a, b, *(np.clip(np.where(np.isfinite(u), u, a), a, b) for u in extremes)]
    values = np.array([c[0] + u * (c[1] + u * (c[2] + u * c[3])) for u in ends])
    slopes = np.array([c[1] + u * (2.0 * c[2] + u * 3.0 * c[3]) for u in ends])
    return values.min(axis=0), values.max(axis=0), slopes.min(axis=0), slopes.max(axis=0)
