"""Numbers with their first two derivatives along a line, by which constraints are differentiated exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Jet:
    """x(s) = value + first s + second s^2/2."""

    value: float
    first: float = 0.0
    second: float = 0.0

    def __add__(self, other):
        o = jet(other)
        return Jet(self.value + o.value, self.first + o.first, self.second + o.second)

    __radd__ = __add__

    def __neg__(self):
        return Jet(-self.value, -self.first, -self.second)

    def __sub__(self, other):
        return self + (-jet(other))

    def __rsub__(self, other):
        return jet(other) - self

    def __mul__(self, other):
        o = jet(other)
        return Jet(
            self.value * o.value,
            self.first * o.value + self.value * o.first,
            self.second * o.value + 2.0 * self.first * o.first + self.value * o.second,
        )

    __rmul__ = __mul__


def jet(x) -> Jet:
    return x if isinstance(x, Jet) else Jet(float(x))


def _chained(x: Jet, value: float, slope: float, bend: float) -> Jet:
    return Jet(value, slope * x.first, slope * x.second + bend * x.first**2)


def sin(x):
    x = jet(x)
    return _chained(x, math.sin(x.value), math.cos(x.value), -math.sin(x.value))


def cos(x):
    x = jet(x)
    return _chained(x, math.cos(x.value), -math.sin(x.value), -math.cos(x.value))


def sqrt(x):
    x = jet(x)
    root = math.sqrt(x.value)
    return _chained(x, root, 0.5 / root, -0.25 / root**3)
