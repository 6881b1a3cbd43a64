"""The largest value of a curve in a step, on the polynomial through its samples at equal parts of the step.

It is found by Newton's method.  A maximum that this polynomial sees and the parabola through the largest sample and its
neighbours does not, as beside a kink, does not count.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from rattle.language.recorded import Operand
from rattle.trace.graph import select
from rattle.trace.lane_methods import largest, least, weighted

NEWTON = 3  # iterations from the largest sample: the place is good to 1e-4 of a part, the value to rounding
STEEPEST = 2.0  # rise above the largest sample that counts, as a multiple of that of the parabola


def _polynomial(x: Sequence[Operand]) -> list[Operand]:
    """Coefficients of s, s^2, ... for s from -1 to 1 over the step, relative to the sample in the middle."""
    half = len(x) // 2
    nodes = [Fraction(j, half) for j in range(1, half + 1)]
    coefficients: list[Operand] = [0.0] * (2 * half)
    for odd in (True, False):
        inverse = _inverse([[s ** (2 * k + (1 if odd else 2)) for k in range(half)] for s in nodes])
        parts = [
            0.5 * (x[half + j] - x[half - j]) if odd else 0.5 * ((x[half + j] - x[half]) + (x[half - j] - x[half]))
            for j in range(1, half + 1)
        ]
        for k in range(half):
            coefficients[2 * k if odd else 2 * k + 1] = weighted([float(w) for w in inverse[k]], parts)
    return coefficients


def _inverse(a: list[list[Fraction]]) -> list[list[Fraction]]:
    """The inverse of a small matrix, exactly."""
    n = len(a)
    rows = [[*row, *(Fraction(int(i == j)) for j in range(n))] for i, row in enumerate(a)]
    for i in range(n):
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for j in range(n):
            if j != i:
                rows[j] = [x - rows[j][i] * y for x, y in zip(rows[j], rows[i], strict=True)]
    return [row[n:] for row in rows]


def _horner(coefficients: Sequence[Operand], s: Operand) -> Operand:
    value = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        value = value * s + c
    return value


def peak(x: Sequence[Operand]) -> Operand:
    """The largest value of a curve in a step, from its samples."""
    parts = len(x) - 1
    if parts < 2:
        return largest(*x)
    start: Operand = -1.0
    best = x[0]
    left, middle, right = x[:3]
    for i in range(1, parts + 1):
        above, c = x[i] > best, min(i, parts - 1)
        best, start = select(above, x[i], best), select(above, 2.0 * i / parts - 1.0, start)
        left, middle, right = (
            select(above, new, old) for new, old in ((x[c - 1], left), (x[c], middle), (x[c + 1], right))
        )
    bend, slope = (left - middle) + (right - middle), 0.5 * (right - left)
    within = (bend < 0.0) & (abs(slope) <= -bend)
    usual = select(within, (middle - best) - 0.5 * slope * slope / bend, 0.0)
    p = _polynomial(x)
    first = [(k + 1.0) * c for k, c in enumerate(p)]
    second = [(k + 1.0) * c for k, c in enumerate(first[1:])]
    width, s = 2.0 / parts, start
    low, high = largest(start - width, -1.0), least(start + width, 1.0)
    for _ in range(NEWTON):
        slope, bend = _horner(first, s), _horner(second, s)
        s = select(bend < 0.0, least(largest(s - slope / bend, low), high), s)
    rise = (x[parts // 2] - best) + s * _horner(p, s)
    return best + largest(least(rise, STEEPEST * usual), 0.0)
