"""The data of a path: lines, arcs and curves.

Arcs of circles stay arcs.  Arcs of ellipses and Bezier curves become arcs through points of the curve that are so close
that even chords between them were nowhere farther from it than a tolerance: of a curve of degree n in N steps of its
parameter the second differences of its control points say so, N^2 = n (n - 1)/8 max |second difference|/tolerance.

Source: SVG 2, W3C (2018), chapter 9 and appendix B.2 (from end points of an arc to its centre);
Wang, The subdivision method for finding the intersection between two Bezier curves, Zhejiang Univ. (1984).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from rattle.exchange.outlines.edges import Corner, arc_bulge
from rattle.exchange.outlines.plan import MOST_EDGES
from rattle.exchange.svg.lengths import LARGEST, NUMBER, Matrix

COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
MOST_CHORDS = 200  # of one curve
FLAT = 1e-9  # of the larger radius or the chord: a radius below is none, and the arc a line
SHARP = 0.6  # angle between two chords from which on there is no arc through their ends [rad]
_TOKEN = re.compile(rf"[\s,]*(?:([MmLlHhVvCcSsQqTtAaZz])|({NUMBER.pattern}))")
_FLAG = re.compile(r"[\s,]*([01])")
Point = tuple[float, float]


class Line(NamedTuple):
    """A connected part of a path: its corners, the last one without an edge behind it unless it is closed."""

    corners: list[Corner]
    closed: bool


class PathError(ValueError):
    """What is wrong with the data of a path."""


def commands_of(data: str) -> Iterator[tuple[str, list[float]]]:
    """Commands, each with its numbers: repeated numbers are commands of their own.  Raises PathError."""
    letter, at = "", 0
    data = data.rstrip()
    while at < len(data):
        match = _TOKEN.match(data, at)
        if (
            match is None
            or (match[2] is not None and (not letter or letter in "Zz"))
            or (match[1] is None and match[2] is None)
        ):
            raise PathError(f"expected a command, got '{data[at : at + 12]}'")
        if match[1] is not None:
            letter, at = match[1], match.end()
        numbers, at = _numbers(data, at, letter.upper())
        yield letter, numbers
        if letter in "Mm":
            letter = "L" if letter == "M" else "l"


def _numbers(data: str, at: int, command: str) -> tuple[list[float], int]:
    numbers: list[float] = []
    while len(numbers) < COUNTS[command]:
        flag = command == "A" and len(numbers) in (3, 4)
        match = (_FLAG if flag else _TOKEN).match(data, at)
        text = match[1] if match and flag else match[2] if match else None
        if match is None or text is None:
            raise PathError(f"{command} needs {COUNTS[command]} numbers, got {len(numbers)}")
        number = float(text)
        if not abs(number) < LARGEST:
            raise PathError(f"{text} is out of range")
        numbers.append(number)
        at = match.end()
    return numbers, at


class PathReader:
    """Follows a path."""

    def __init__(self, matrix: Matrix, tolerance: float) -> None:
        """tolerance: of curves, in units of the drawing, into which the matrix leads."""
        self.matrix, self.tolerance = matrix, tolerance
        self.lines: list[Line] = []
        self.corners: list[Corner] = []
        self.at: Point = (0.0, 0.0)
        self.first: Point = (0.0, 0.0)
        self.control: Point | None = None  # of the last curve
        self.curved = ""  # "C" or "Q" if the last command was a curve of that kind
        self.flattened = False
        self.edges = 0

    def read(self, data: str) -> list[Line]:
        """The parts of a path.  Raises PathError."""
        draw: Mapping[str, Callable[[str, list[Point]], None]] = {
            "C": self._cubic,
            "S": self._cubic,
            "Q": self._quadratic,
            "T": self._quadratic,
        }
        for letter, numbers in commands_of(data):
            command = letter.upper()
            if not self.lines and not self.corners and command != "M":
                raise PathError(f"a path begins with M, not with {letter}")
            if command == "Z":
                self._end(closed=True)
                self.at, self.curved = self.first, ""
                self.corners = []
            elif command == "A":
                self._begin()
                self._arc(numbers, self._points(letter, numbers[5:])[0])
                self.curved = ""
            else:
                points = self._points(letter, numbers)
                if command == "M":
                    self._end(closed=False)
                    self.first = self.at = points[0]
                    self.corners = [Corner(*self.matrix.of(*self.at))]
                    self.curved = ""
                    continue
                self._begin()
                draw.get(command, self._line)(command, points)
                self.curved = {"C": "C", "S": "C", "Q": "Q", "T": "Q"}.get(command, "")
        self._end(closed=False)
        return self.lines

    # ------------------------------------------------------------ parts
    def _begin(self) -> None:
        """After Z the next part begins where the last one did."""
        if not self.corners:
            self.corners = [Corner(*self.matrix.of(*self.at))]

    def _end(self, closed: bool) -> None:
        corners = self.corners
        if len(corners) > 1 and corners[0][:2] == corners[-1][:2]:
            closed, corners = True, corners[:-1]
        if len(corners) > 1:
            self.lines.append(Line(corners, closed))
        self.corners = []

    def _points(self, letter: str, numbers: Sequence[float]) -> list[Point]:
        """Points in coordinates of the element."""
        x, y = self.at if letter.islower() else (0.0, 0.0)
        if letter in "Hh":
            return [(x + numbers[0], self.at[1])]
        if letter in "Vv":
            return [(self.at[0], y + numbers[0])]
        return [(x + numbers[k], y + numbers[k + 1]) for k in range(0, len(numbers), 2)]

    def _to(self, point: Point, bulge: float = 0.0) -> None:
        """An edge to a point of the element."""
        self.edges += 1
        if self.edges > MOST_EDGES:
            raise PathError(f"more than {MOST_EDGES} lines and arcs, or chords of curves")
        self.corners[-1] = self.corners[-1]._replace(bulge=bulge)
        self.corners.append(Corner(*self.matrix.of(*point)))
        self.at = point

    def _line(self, command: str, points: list[Point]) -> None:
        self._to(points[0])

    # ------------------------------------------------------------ curves
    def _cubic(self, command: str, points: list[Point]) -> None:
        first = [] if command == "C" else [self._mirrored("C")]
        self._bezier([self.at, *first, *points])
        self.control = points[-2]

    def _quadratic(self, command: str, points: list[Point]) -> None:
        control = points[0] if command == "Q" else self._mirrored("Q")
        self._bezier([self.at, control, points[-1]])
        self.control = control

    def _mirrored(self, kind: str) -> Point:
        """The control point that continues the last curve smoothly."""
        if self.curved != kind or self.control is None:
            return self.at
        return 2.0 * self.at[0] - self.control[0], 2.0 * self.at[1] - self.control[1]

    def _bezier(self, points: list[Point]) -> None:
        self.flattened = True
        n = len(points) - 1
        shown = [self.matrix.of(*point) for point in points]
        bends = [
            math.hypot(*(a[k] - 2.0 * b[k] + c[k] for k in (0, 1)))
            for a, b, c in zip(shown, shown[1:], shown[2:], strict=False)
        ]
        count = min(MOST_CHORDS, max(2, math.ceil(math.sqrt(n * (n - 1) / 8.0 * max(bends) / self.tolerance))))

        def at(u: float) -> Point:
            path = points
            while len(path) > 1:
                path = [((1.0 - u) * a[0] + u * b[0], (1.0 - u) * a[1] + u * b[1]) for a, b in pairwise(path)]
            return path[0]

        self._curve(at, count, points[-1])

    def _curve(self, at: Callable[[float], Point], count: int, end: Point) -> None:
        """Arcs through so many and one points of a curve that goes on from here, and those halfway between them."""
        for k in range(count):
            halfway = self.matrix.of(*at((k + 0.5) / count))
            point = end if k == count - 1 else at((k + 1) / count)
            self._to(point, _bulge_through(self.corners[-1][:2], halfway, self.matrix.of(*point)))

    def _arc(self, numbers: Sequence[float], end: Point) -> None:
        rx, ry, turn = abs(numbers[0]), abs(numbers[1]), math.radians(numbers[2])
        if end == self.at:
            return
        if min(rx, ry) <= FLAT * max(rx, ry, math.dist(self.at, end)):
            self._to(end)
            return
        frame, start, sweep = _ellipse(self.at, end, (rx, ry), turn, bool(numbers[3]), bool(numbers[4]))
        shown = self.matrix.after(frame)
        if shown.keeps_circles and abs(sweep) < 1.999 * math.pi:
            self._to(end, arc_bulge(-sweep if shown.mirrors else sweep))
            return
        self.flattened = True
        radius = max(math.hypot(shown.a, shown.b), math.hypot(shown.c, shown.d))
        step = 2.0 * math.acos(max(0.0, 1.0 - self.tolerance / radius)) if radius > self.tolerance else math.pi / 2
        count = min(MOST_CHORDS, max(2, math.ceil(abs(sweep) / step)))
        self._curve(lambda u: frame.of(math.cos(start + sweep * u), math.sin(start + sweep * u)), count, end)


def _bulge_through(start: Point, halfway: Point, end: Point) -> float:
    """The bulge of the arc through three points; 0 where the curve turns sharply.

    The directions of the two chords differ by half of the angle through which the arc turns.
    """
    (ax, ay), (bx, by) = (halfway[0] - start[0], halfway[1] - start[1]), (end[0] - halfway[0], end[1] - halfway[1])
    turn = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    return math.tan(0.5 * turn) if 1e-9 < abs(turn) < SHARP else 0.0


def _ellipse(
    start: Point, end: Point, radii: Point, turn: float, large: bool, positive: bool
) -> tuple[Matrix, float, float]:
    """The matrix from the unit circle to the ellipse of an arc, the angle at which it begins, and its sweep."""
    c, s = math.cos(turn), math.sin(turn)
    dx, dy = 0.5 * (start[0] - end[0]), 0.5 * (start[1] - end[1])
    u, v = (c * dx + s * dy) / radii[0], (-s * dx + c * dy) / radii[1]
    square = u * u + v * v
    grown = max(1.0, math.sqrt(square))  # radii that are too small are enlarged
    rx, ry = radii[0] * grown, radii[1] * grown
    u, v, square = u / grown, v / grown, min(1.0, square / grown**2)
    rise = math.sqrt(max(0.0, 1.0 / square - 1.0)) * (-1.0 if large == positive else 1.0)
    cu, cv = rise * v, -rise * u  # centre in the frame of the unit circle, about the middle of the chord
    first, last = math.atan2(v - cv, u - cu), math.atan2(-v - cv, -u - cu)
    sweep = (last - first) % (2.0 * math.pi) if positive else -((first - last) % (2.0 * math.pi))
    middle = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])
    x, y = middle[0] + c * rx * cu - s * ry * cv, middle[1] + s * rx * cu + c * ry * cv
    return Matrix(rx * c, rx * s, -ry * s, ry * c, x, y), first, sweep
