"""Tables on record: the segment of a symbol is found by choices, one for every knot."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.errors import TraceError
from rattle.language.recorded import Flag, Operand
from rattle.language.table_reading import EDGE, KNOTS, PER_SEGMENT, PERIOD
from rattle.trace.graph import Symbol, apply, select

MOST_SEGMENTS = 300  # each costs five choices wherever the table is used


def recorded_table(table: Sequence[Operand], k: int, x: Operand) -> tuple[Operand, Operand, Operand]:
    """Value and first and second derivative at x of the table whose block begins at table[k], as operations.

    The same as `language.bytecode.read_table` without a side.  Raises TraceError for a table with too many points.
    """
    n, period, first = int(float(table[k])), table[k + PERIOD], k + KNOTS
    if n > MOST_SEGMENTS:
        raise TraceError(
            f"a table of {n + 1} points is too long for straight-line code, which takes {MOST_SEGMENTS + 1} at most"
        )
    knots = [table[first + i] for i in range(n + 1)]
    if isinstance(period, Symbol) or period > 0.0:
        x = x - period * apply("floor", (x - knots[0]) / period)
    else:
        slack = EDGE * (knots[n] - knots[0])
        inside = apply("both", _at_most(knots[0] - slack, x), _at_most(x, knots[n] + slack))
        x = select(inside, x, math.nan)
    chosen = [knots[0], *(table[first + n + 1 + j] for j in range(PER_SEGMENT))]
    for i in range(1, n):
        beyond = _at_most(knots[i], x)
        c = first + n + 1 + PER_SEGMENT * i
        segment = [knots[i], *(table[c + j] for j in range(PER_SEGMENT))]
        chosen = [select(beyond, new, old) for new, old in zip(segment, chosen, strict=True)]
    knot, c0, c1, c2, c3 = chosen
    u = x - knot
    return c0 + u * (c1 + u * (c2 + u * c3)), c1 + u * (2.0 * c2 + u * (3.0 * c3)), 2.0 * c2 + 6.0 * (u * c3)


def _at_most(a: Operand, b: Operand) -> Flag:
    return apply("at_most", a, b)
