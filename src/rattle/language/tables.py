"""Tables: functions of one number given by points, as straight lines or cubic pieces between them.

A table is a block of numbers in an array: its header, the knots x_0 ... x_n, then four coefficients for each of its n
segments.  With u = x - x_i in segment i:

    f = c_0 + c_1 u + c_2 u^2 + c_3 u^3

z(x) is the knot coordinate: the number of the segment plus the share of it that is passed, counted on from turn to turn
where the table has a period.  Its integers are the knots.  At these a table of kind "linear" has kinks, one of kind
"monotone" jumps in its second derivative: they are switches with the switching function `bytecode.wave` of z.
Outside of a table without period the value is nan.

Source: de Boor, A Practical Guide to Splines (1978), ch. IV (not-a-knot, periodic); Fritsch and Butland, SIAM J. Sci.
Stat. Comput. 5 (1984) 300-304 (monotone).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class Curve:
    """A table as read: x increasing, (n + 1,) numbers each [SI], which may be recorded.

    coefficients: four for each segment.  period: 0 if it has none.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    kind: str
    period: float
    coefficients: tuple[tuple[float, ...], ...]

    @property
    def bends(self) -> bool:
        """True if its knots are switches."""
        return self.kind != "spline"

    def said_outside(self, name: str) -> str:
        """What is said of an argument that is outside of this table."""
        return f"is outside of the table '{name}', which goes from {self.x[0]:g} to {self.x[-1]:g} (in SI units)"

    @property
    def block(self) -> list[float]:
        """Its numbers as the kernels read them."""
        numbers = [float(len(self.coefficients)), self.period, *self.x]
        return [*numbers, *(coefficient for segment in self.coefficients for coefficient in segment)]


def curve(x: Sequence[float], y: Sequence[float], kind: str, period: float = 0.0) -> Curve:
    """The table of this kind through points; x increasing by more than nothing, y at the end of the period as at x[0].

    kind: "linear", "monotone" or "spline".
    """
    steps = [b - a for a, b in itertools.pairwise(x)]
    slopes = [(b - a) / h for a, b, h in zip(y, y[1:], steps, strict=False)]
    if kind == "linear":
        rates: list[float] = []
        segments = [(a, slope, 0.0, 0.0) for a, slope in zip(y, slopes, strict=False)]
    else:
        rates = (_monotone if kind == "monotone" else _spline)(steps, slopes, bool(period > 0.0))
        segments = [_cubic(*segment) for segment in zip(y, steps, slopes, rates, rates[1:], strict=False)]
    return Curve(tuple(x), tuple(y), kind, period, tuple(segments))


def _cubic(y: float, h: float, slope: float, left: float, right: float) -> tuple[float, float, float, float]:
    """Coefficients of the cubic with these rates at its ends."""
    bend = (left + right - 2.0 * slope) / h
    return y, left, (slope - left) / h - bend, bend / h


def _monotone(steps: Sequence[float], slopes: Sequence[float], periodic: bool) -> list[float]:
    """Rates at the knots: weighted harmonic means of the slopes beside them, zero at extremes."""

    def between(h0: float, h1: float, s0: float, s1: float) -> float:
        if s0 * s1 <= 0.0:
            return 0.0
        first, second = 2.0 * h1 + h0, h1 + 2.0 * h0
        return (first + second) / (first / s0 + second / s1)

    def at_end(h0: float, h1: float, s0: float, s1: float) -> float:
        rate = ((2.0 * h0 + h1) * s0 - h0 * s1) / (h0 + h1)
        if rate * s0 <= 0.0:
            return 0.0
        return 3.0 * s0 if s0 * s1 <= 0.0 and abs(rate) > 3.0 * abs(s0) else rate

    inside = [between(*sides) for sides in zip(steps, steps[1:], slopes, slopes[1:], strict=False)]
    if periodic:
        edge = between(steps[-1], steps[0], slopes[-1], slopes[0])
        return [edge, *inside, edge]
    if len(steps) == 1:
        return [slopes[0], slopes[0]]
    last = at_end(steps[-1], steps[-2], slopes[-1], slopes[-2])
    return [at_end(steps[0], steps[1], slopes[0], slopes[1]), *inside, last]


def _spline(steps: Sequence[float], slopes: Sequence[float], periodic: bool) -> list[float]:
    """Rates at the knots of the cubic spline with continuous second derivative, periodic or not-a-knot."""
    n = len(steps)
    if periodic:
        return _periodic_rates(steps, slopes)
    if n == 1:
        return [slopes[0], slopes[0]]
    if n == 2:  # the parabola through three points
        bend = (slopes[1] - slopes[0]) / (steps[0] + steps[1])
        return [slopes[0] - bend * steps[0], slopes[0] + bend * steps[0], slopes[1] + bend * steps[1]]
    below, above = [*steps[1:], steps[-1] + steps[-2]], [steps[0] + steps[1], *steps[:-1]]
    diagonal = [steps[1], *(2.0 * (a + b) for a, b in itertools.pairwise(steps)), steps[-2]]
    right = [3.0 * (b * s0 + a * s1) for a, b, s0, s1 in zip(steps, steps[1:], slopes, slopes[1:], strict=False)]
    first, last = _end(steps[0], steps[1], slopes[0], slopes[1]), _end(steps[-1], steps[-2], slopes[-1], slopes[-2])
    return _tridiagonal(below, diagonal, above, [first, *right, last])


def _end(h0: float, h1: float, s0: float, s1: float) -> float:
    """Right-hand side of the condition that the first two segments are one cubic."""
    both = h0 + h1
    return ((h0 + 2.0 * both) * h1 * s0 + h0 * h0 * s1) / both


def _tridiagonal(
    below: Sequence[float], diagonal: Sequence[float], above: Sequence[float], right: Sequence[float]
) -> list[float]:
    """Solution of a tridiagonal system, by elimination."""
    pivots, values = [diagonal[0]], [right[0]]
    for low, here, high, value in zip(below, diagonal[1:], above, right[1:], strict=False):
        share = low / pivots[-1]
        pivots.append(here - share * high)
        values.append(value - share * values[-1])
    solution = [values[-1] / pivots[-1]]
    for pivot, high, value in zip(pivots[-2::-1], above[::-1], values[-2::-1], strict=True):
        solution.append((value - high * solution[-1]) / pivot)
    return solution[::-1]


def _periodic_rates(steps: Sequence[float], slopes: Sequence[float]) -> list[float]:
    """Rates of the periodic spline: the tridiagonal system whose corners are one unknown, the rate at the start."""
    n = len(steps)
    before = [steps[-1], *steps[:-1]]
    right = [
        3.0 * (h * s0 + h0 * s) for h0, h, s0, s in zip(before, steps, [slopes[-1], *slopes[:-1]], slopes, strict=True)
    ]
    diagonal = [2.0 * (h0 + h) for h0, h in zip(before, steps, strict=True)]
    # row i: steps[i] m_(i-1) + diagonal m_i + before[i] m_(i+1); rows 1 ... n-1 give their unknowns as p + q m_0
    inner = steps[2:n], diagonal[1:n], before[1 : n - 1]
    corners = [0.0] * (n - 1)
    corners[0] = corners[0] - steps[1]
    corners[-1] = corners[-1] - before[n - 1]
    p, q = _tridiagonal(*inner, right[1:n]), _tridiagonal(*inner, corners)
    start = (right[0] - steps[0] * p[-1] - before[0] * p[0]) / (diagonal[0] + steps[0] * q[-1] + before[0] * q[0])
    return [start, *(a + b * start for a, b in zip(p, q, strict=True)), start]


class Tables(NamedTuple):
    """Tables by name, and one vector of numbers that holds the blocks of all."""

    curves: Mapping[str, Curve]
    place: Mapping[str, int]  # where the block of each begins
    numbers: Sequence[float]


def tables_of(curves: Mapping[str, Curve]) -> Tables:
    """Tables by name with their blocks one after the other."""
    place: dict[str, int] = {}
    numbers: list[float] = []
    for name, curve in curves.items():
        place[name] = len(numbers)
        numbers += curve.block
    return Tables(curves, place, numbers)


NO_TABLES = tables_of({})
