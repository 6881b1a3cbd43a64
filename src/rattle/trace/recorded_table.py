"""Tables on record: the segment of a symbol is found by choices, one for every knot."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.errors import TraceError
from rattle.language.recorded import Flag, Operand
from rattle.language.table_reading import EDGE, KNOTS, PER_SEGMENT, PERIOD, ROUNDED
from rattle.trace.graph import Symbol, apply, select

MOST_SEGMENTS = 300  # each costs five choices wherever the table is used


def recorded_table(table: Sequence[Operand], k: int, x: Operand) -> tuple[Operand, Operand, Operand]:
    """Value and first and second derivative at x of the table whose block begins at table[k], as operations.

    The same as `language.bytecode.read_table` without a side.  Raises TraceError for a table with too many points.
    """
    knots, _ = _knots(table, k)
    x, _ = _in_range(table, k, knots, x)
    return _on_segment(table, k, knots, [_at_most(knot, x) for knot in knots[1:-1]], x)


def recorded_knots(table: Sequence[Operand], k: int, x: Operand) -> Operand:
    """As `table_reading.knot_coordinate`, as operations."""
    knots, n = _knots(table, k)
    x, turns = _in_range(table, k, knots, x)
    here: Operand = (x - knots[0]) / (knots[1] - knots[0])
    for i in range(1, n):
        here = select(_at_most(knots[i], x), i + (x - knots[i]) / (knots[i + 1] - knots[i]), here)
    return turns * float(n) + here


def recorded_segment(
    table: Sequence[Operand], k: int, segment: Operand, x: Operand
) -> tuple[tuple[Operand, Operand, Operand], Operand]:
    """Value and derivatives at x by one segment, as `table_reading.on_segment`; at which share of this segment x is."""
    knots, n = _knots(table, k)
    period = table[k + PERIOD]
    if isinstance(period, Symbol) or period > 0.0:
        turns = apply("floor", segment / float(n))
        segment, x = segment - turns * float(n), x - turns * period
    beyond = [_at_most(float(i), segment) for i in range(1, n)]
    left, right = knots[0], knots[1]
    for i, flag in enumerate(beyond, 1):
        left, right = select(flag, knots[i], left), select(flag, knots[i + 1], right)
    return _on_segment(table, k, knots, beyond, x), (x - left) / (right - left)


def _knots(table: Sequence[Operand], k: int) -> tuple[list[Operand], int]:
    n, first = int(float(table[k])), k + KNOTS
    if n > MOST_SEGMENTS:
        raise TraceError(
            f"a table of {n + 1} points is too long for straight-line code, which takes {MOST_SEGMENTS + 1} at most"
        )
    return [table[first + i] for i in range(n + 1)], n


def _in_range(table: Sequence[Operand], k: int, knots: Sequence[Operand], x: Operand) -> tuple[Operand, Operand]:
    """x in the first turn of a table, nan outside of one without turns; the turn."""
    period = table[k + PERIOD]
    if isinstance(period, Symbol) or period > 0.0:
        turns = apply("floor", (x - knots[0]) / period)
        return x - period * turns, turns
    slight = ROUNDED * (abs(knots[0]) + abs(knots[-1]))
    before, after = EDGE * (knots[1] - knots[0]) + slight, EDGE * (knots[-1] - knots[-2]) + slight
    inside = apply("both", _at_most(knots[0] - before, x), _at_most(x, knots[-1] + after))
    return select(inside, x, math.nan), 0.0


def _on_segment(
    table: Sequence[Operand], k: int, knots: Sequence[Operand], beyond: Sequence[Flag], x: Operand
) -> tuple[Operand, Operand, Operand]:
    """Value and derivatives at x on the last segment that is begun; beyond: flags of the knots inside."""
    first = k + KNOTS + len(knots)
    chosen = [knots[0], *(table[first + j] for j in range(PER_SEGMENT))]
    for i, flag in enumerate(beyond, 1):
        c = first + PER_SEGMENT * i
        segment = [knots[i], *(table[c + j] for j in range(PER_SEGMENT))]
        chosen = [select(flag, new, old) for new, old in zip(segment, chosen, strict=True)]
    knot, c0, c1, c2, c3 = chosen
    u = x - knot
    return c0 + u * (c1 + u * (c2 + u * c3)), c1 + u * (2.0 * c2 + u * (3.0 * c3)), 2.0 * c2 + 6.0 * (u * c3)


def _at_most(a: Operand, b: Operand) -> Flag:
    return apply("at_most", a, b)
