"""Kernels that read a table from its block of numbers; see `language.tables` for what it holds."""

from __future__ import annotations

import math

from rattle.jit.functions import compiled

SEGMENTS, PERIOD, KNOTS = range(3)  # of a block: number of segments, period or 0, the first knot
PER_SEGMENT = 4  # coefficients
EDGE = 1e-9  # share of its last span by which a table may be left there: rounding
ROUNDED = 1e-14  # share of its largest argument by which it may be left in any case
NAN = math.nan


@compiled
def knot_coordinate(table, k, x):
    """z(x) of the table whose block begins at table[k]; nan outside of it."""
    n, period, first = int(table[k]), table[k + PERIOD], k + KNOTS
    start, end = table[first], table[first + n]
    turns = 0.0
    if period > 0.0:
        turns = float(math.floor((x - start) / period)) if abs(x) < 1e15 * period else NAN
        x = x - turns * period
    slight = ROUNDED * (abs(start) + abs(end))
    before, after = EDGE * (table[first + 1] - start) + slight, EDGE * (end - table[first + n - 1]) + slight
    if not (start - before <= x <= end + after):
        return NAN
    low, high = 0, n
    while high - low > 1:
        middle = (low + high) // 2
        if x >= table[first + middle]:
            low = middle
        else:
            high = middle
    here = table[first + low]
    return turns * n + low + (x - here) / (table[first + low + 1] - here)


@compiled
def on_segment(table, k, segment, x):
    """Value and first and second derivative at x of one segment, counted on from turn to turn, of a table at k."""
    n, period, first = int(table[k]), table[k + PERIOD], k + KNOTS
    turns = 0.0
    if period > 0.0:
        turns = float(math.floor(segment / n))
        segment = segment - turns * n
    if not (segment >= 0.0):
        segment = 0.0
    i = min(int(segment), n - 1)
    c = first + n + 1 + PER_SEGMENT * i
    u = x - turns * period - table[first + i]
    c1, c2, c3 = table[c + 1], table[c + 2], table[c + 3]
    return table[c] + u * (c1 + u * (c2 + u * c3)), c1 + u * (2.0 * c2 + u * 3.0 * c3), 2.0 * c2 + 6.0 * u * c3
