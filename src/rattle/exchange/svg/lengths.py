"""Numbers, lengths and transforms of SVG.

Source: Scalable Vector Graphics (SVG) 2, W3C (2018), chapters 7 and 8.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

NUMBER = re.compile(r"[+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?")
_LENGTH = re.compile(rf"\s*+({NUMBER.pattern})\s*+(mm|cm|in|pt|pc|px|Q|m|)\s*+")
_TRANSFORM = re.compile(r"\s*+,?\s*+([A-Za-z]++)\s*+\(([^()]*+)\)")
LONGEST = 2000  # signs of a length, or of a list of transforms
PIXEL = 0.0254 / 96  # [m]
UNITS = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "pt": 0.0254 / 72, "pc": 0.0254 / 6, "px": PIXEL, "Q": 2.5e-4, "m": 1.0}
LARGEST = 1e12  # a number of a drawing


def numbers_of(text: str) -> list[float] | None:
    """All numbers of a text that holds nothing else but blanks and commas; None if it does."""
    numbers = [float(match[0]) for match in NUMBER.finditer(text)]
    if NUMBER.sub(" ", text).replace(",", " ").strip() or not all(abs(number) < LARGEST for number in numbers):
        return None
    return numbers


def length_of(text: str) -> tuple[float, str] | None:
    """A number and its unit, "" without one; None for what is neither, such as a share."""
    match = _LENGTH.fullmatch(text) if len(text) <= LONGEST else None
    return (float(match[1]), match[2]) if match and abs(float(match[1])) < LARGEST else None


class Matrix(NamedTuple):
    """x' = a x + c y + e, y' = b x + d y + f."""

    a: float = 1.0
    b: float = 0.0
    c: float = 0.0
    d: float = 1.0
    e: float = 0.0
    f: float = 0.0

    def of(self, x: float, y: float) -> tuple[float, float]:
        """A point."""
        return self.a * x + self.c * y + self.e, self.b * x + self.d * y + self.f

    def after(self, other: Matrix) -> Matrix:
        """The matrix that has the effect of the other one and then of this one."""
        x, y = self.of(other.e, other.f)
        return Matrix(
            self.a * other.a + self.c * other.b, self.b * other.a + self.d * other.b,
            self.a * other.c + self.c * other.d, self.b * other.c + self.d * other.d, x, y,
        )  # fmt: skip

    @property
    def scale(self) -> float:
        """How many times as large it makes things, if it keeps circles; else the root of how it changes areas."""
        return math.sqrt(abs(self.a * self.d - self.b * self.c))

    @property
    def keeps_circles(self) -> bool:
        """True if circles stay circles."""
        size = max(map(abs, self[:4]))
        alike = abs(self.a - self.d) + abs(self.b + self.c), abs(self.a + self.d) + abs(self.b - self.c)
        return min(alike) <= 1e-9 * size

    @property
    def mirrors(self) -> bool:
        """True if it turns left into right."""
        return self.a * self.d - self.b * self.c < 0.0


def transform_of(text: str) -> Matrix | None:
    """A list of transforms; None if it is none."""
    if len(text) > LONGEST:
        return None
    matrix, end = Matrix(), 0
    for match in _TRANSFORM.finditer(text):
        numbers = numbers_of(match[2])
        if match.start() != end or numbers is None or (own := _transform(match[1], numbers)) is None:
            return None
        matrix, end = matrix.after(own), match.end()
    return matrix if not text[end:].strip(" ,\t\r\n") else None


def _transform(name: str, n: Sequence[float]) -> Matrix | None:
    """One transform."""
    if name == "matrix" and len(n) == 6:
        return Matrix(*n)
    if name == "translate" and len(n) in (1, 2):
        return Matrix(e=n[0], f=n[1] if len(n) > 1 else 0.0)
    if name == "scale" and len(n) in (1, 2):
        return Matrix(a=n[0], d=n[-1])
    if name == "rotate" and len(n) in (1, 3):
        c, s = math.cos(math.radians(n[0])), math.sin(math.radians(n[0]))
        x, y = n[1:] or (0.0, 0.0)
        return Matrix(c, s, -s, c, x - c * x + s * y, y - s * x - c * y)
    if name in ("skewX", "skewY") and len(n) == 1:
        slope = math.tan(math.radians(n[0]))
        return Matrix(c=slope) if name == "skewX" else Matrix(b=slope)
    return None
