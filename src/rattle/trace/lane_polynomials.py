"""Polynomials over a step of lanes, of which the sign and the first zero are asked for.

In Bernstein's form a polynomial shows its sign even where it starts or ends at zero.

Source: Farouki, The Bernstein polynomial basis, Computer Aided Geometric Design 29 (2012) 379-419.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from rattle.language.recorded import Operand
from rattle.trace.graph import select
from rattle.trace.lane_methods import largest, least

NEWTON = 6  # iterations for a zero of a polynomial; a try that misses it is followed by another one
SHORT_OF = 1.0 - 1e-10  # largest share of a step to land at: shorter than the step
HALVINGS = 2  # of a polynomial whose sign is asked for
FAR, LITTLE = 1e300, 1e-300


class Polynomial:
    """A curve over a step by its coefficients."""

    def __init__(self, powers: list[Operand], ends: Operand) -> None:
        """ends: change per step at the end."""
        self.powers, self.ends = powers, ends

    def value(self, s: Operand) -> Operand:
        """At the share s of the step."""
        total = self.powers[-1]
        for c in reversed(self.powers[:-1]):
            total = total * s + c
        return total

    def slope(self, s: Operand) -> Operand:
        """Change per step there."""
        total: Operand = 0.0
        for k in reversed(range(1, len(self.powers))):
            total = total * s + float(k) * self.powers[k]
        return total

    def zero(self) -> Operand:
        """About where it falls through zero first, below zero at its end: a share of the step."""
        left, rises = self.powers[:2]
        secant = least(largest(left / largest(left - self.value(1.0), LITTLE), 1e-3), 1.0)
        s = select(rises > 0.0, select(self.ends < 0.0, 1.0, 0.5), secant)
        for _ in range(NEWTON):
            s = least(largest(self._nearer(s), 0.5 * s), 0.5 + 0.5 * s)
        return least(s, SHORT_OF)

    def beyond(self) -> Operand:
        """Share of the step after its end at which it falls through zero, about; FAR if it rises there."""
        s = self._nearer(self._nearer(1.0))
        return select(s > 1.0, s - 1.0, FAR)

    def _nearer(self, s: Operand) -> Operand:
        slope = self.slope(s)
        return s - self.value(s) / select(slope < 0.0, slope, -FAR)


class Quartic(Polynomial):
    """The curve with these values and changes per step at the ends, and this value midway."""

    def __init__(self, left: Operand, rises: Operand, middle: Operand, right: Operand, ends: Operand) -> None:
        c2 = 3.0 * (right - left) - 2.0 * rises - ends
        c3 = 2.0 * (left - right) + rises + ends
        self.known, self.bulge = (left, rises, right, ends), 16.0 * middle - 8.0 * (left + right) - 2.0 * (rises - ends)
        super().__init__([left, rises, c2 + self.bulge, c3 - 2.0 * self.bulge, self.bulge], ends)

    def lowest(self, margin: Operand) -> Operand:
        """A number below all its values less 16 s^2 (1 - s)^2 times a margin."""
        left, rises, right, ends = self.known
        middle = 0.5 * (left + right) + (rises - ends) / 6.0 + (self.bulge - 16.0 * margin) / 6.0
        pieces = [[left, left + 0.25 * rises, middle, right - 0.25 * ends, right]]
        for _ in range(HALVINGS):
            pieces = [half for piece in pieces for half in _halves(piece)]
        low: Operand = FAR
        for piece in pieces:
            for x in piece:
                low = least(low, x)
        return low


def _halves(b: Sequence[Operand]) -> tuple[list[Operand], list[Operand]]:
    """Coefficients of the two halves of a polynomial in Bernstein's form, by de Casteljau."""
    left, right, rest = [b[0]], [b[-1]], list(b)
    while len(rest) > 1:
        rest = [0.5 * (x + y) for x, y in itertools.pairwise(rest)]
        left.append(rest[0])
        right.append(rest[-1])
    return left, right[::-1]
