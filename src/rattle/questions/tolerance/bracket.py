"""The largest x with q(x) <= 0, for a continuous q that rises as a rule: a bracket that narrows.

q is how far the worst of the mechanisms that have to keep the limits is beyond them, in halves of the distance of the
limits; -1 is in their middle.  It may be infinite where mechanisms cannot be run.  The x that is found was looked at:
q(x) <= 0.

Source: Dowell, Jarratt, A modified regula falsi method for computing the root of an equation, BIT 11 (1971) 168-174.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

NARROW = 1e-3  # width of the bracket at the end, as a share of x
SCANNED = (0.25, 0.5, 0.75)  # shares of the x found at which it is looked whether smaller ones hold too
MOST_STEPS = 100
FIRST_STEP = 0.02  # beyond where the edge would be if q rose evenly, as a share of x; doubled from step to step


@dataclass(frozen=True)
class Edge:
    """The largest x that holds, with all smaller ones that were looked at."""

    value: float
    over: float  # the next larger one, which does not hold; nan if the greatest x that was allowed holds
    gap: float = math.nan  # a smaller x does not hold, though larger ones than the value do: that one, else nan


class NotReachedError(Exception):
    """No x holds, not even the least one that may be."""

    def __init__(self, least: float) -> None:
        super().__init__(f"{least:g}")
        self.least = least


Excess = Callable[[float], float]


def edge(excess: Excess, start: float, least: float, most: float, rest: float = -1.0) -> Edge:
    """Search from a start on, between bounds; rest: q(0).  Raises NotReachedError if q(least) > 0."""
    low, high = _bracket(excess, min(max(start, least), most), least, most, rest)
    if math.isnan(high):
        result = Edge(low, high)
    else:
        result = Edge(*_narrowed(excess, (low, excess(low)), (high, excess(high))))
    before = (0.0, rest)
    for share in SCANNED:
        x = share * result.value
        if x <= least:
            continue
        q = excess(x)
        if q > 0.0:
            if before[0] == 0.0:
                low, high = _bracket(excess, x, least, x, rest)
                before = (low, excess(low))
            low, high = _narrowed(excess, before, (x, q))
            return Edge(low, high, x)
        before = (x, q)
    return result


def _bracket(excess: Excess, x: float, least: float, most: float, rest: float) -> tuple[float, float]:
    """Two x about the edge, the second one nan if the greatest that is allowed holds.  Raises NotReachedError."""
    q = excess(x)
    if q > 0.0:
        for n in range(MOST_STEPS):
            if x <= least:
                break
            less = max(1.0 - FIRST_STEP * 2**n, 0.5)
            high, x = x, max(least, x * max(less * min(_linear(q, rest), 1.0), 0.1))
            q = excess(x)
            if q <= 0.0:
                return x, high
        raise NotReachedError(x)
    for n in range(MOST_STEPS):
        if x >= most:
            break
        more = min(1.0 + FIRST_STEP * 2**n, 2.0)
        low, x = x, min(most, x * min(more * max(_linear(q, rest), 1.0), 10.0))
        q = excess(x)
        if q > 0.0:
            return low, x
    return x, math.nan


def _linear(q: float, rest: float) -> float:
    """Where q would be 0 if it rose evenly from `rest` at 0, as a share of the x with q."""
    return -rest / (q - rest) if q > rest else math.inf


def _narrowed(excess: Excess, low: tuple[float, float], high: tuple[float, float]) -> tuple[float, float]:
    """A narrow bracket from (x, q) with q <= 0 and q > 0: false position with halved weights (Illinois)."""
    (a, qa), (b, qb) = low, high
    side = 0
    for _ in range(MOST_STEPS):
        if b - a <= NARROW * b:
            break
        room = 0.4 * NARROW * b
        x = 0.5 * (a + b) if math.isinf(qb) else (a * qb - b * qa) / (qb - qa)
        x = min(max(x, a + min(room, 0.5 * (b - a))), b - min(room, 0.5 * (b - a)))
        q = excess(x)
        if q > 0.0:
            b, qb = x, q
            qa *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            a, qa = x, q
            qb *= 0.5 if side < 0 else 1.0
            side = -1
    return a, b
