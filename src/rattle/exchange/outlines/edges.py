"""Closed lines of straight edges and arcs: their points, areas, mass centres and second moments.

An edge from a to b has a *bulge* as in DXF: the tangent of a quarter of the angle s through which it turns, positive
counter-clockwise, 0 of a straight line.  With L and psi, length and direction of the chord, a point of it is

    p(u) = a + L sin(s u/2)/sin(s/2) (cos, sin)(psi - s/2 + s u/2),      0 <= u <= 1,

which is well conditioned from straight lines to nearly whole circles.  By Green's theorem

    A = int dx dy = 1/2 ring (x dy - y dx),    int x = 1/2 ring x^2 dy,    int x^2 + y^2 = 1/3 ring (x^3 dy - y^3 dx).

The integrands are sums of harmonics of s u up to the fourth: 24 nodes of Gauss and Legendre leave rounding alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.description.model import Vector
from rattle.description.polygon import Figure

Array = NDArray[np.float64]
NODES = 24  # of a quadrature along an edge
MOST_CHORDS = 180  # of one arc
MOST_POINTS = 20_000  # of an outline with so many arcs that each has fewer chords
TOGETHER = 10_000  # edges of which moments are taken at once: 24 numbers of ten arrays each


class Corner(NamedTuple):
    """A corner, and the bulge of the edge that begins there."""

    x: float
    y: float
    bulge: float = 0.0


Outline = tuple[Corner, ...]  # closed: the last edge ends at the first corner


class Circle(NamedTuple):
    """A whole circle."""

    x: float
    y: float
    radius: float

    @property
    def outline(self) -> Outline:
        """The same as two arcs."""
        return (Corner(self.x - self.radius, self.y, 1.0), Corner(self.x + self.radius, self.y, 1.0))


def arc_bulge(sweep: float) -> float:
    """The bulge of an arc through an angle [rad]."""
    return math.tan(0.25 * sweep)


def arc_centre(start: Vector, end: Vector, bulge: float) -> Circle:
    """The circle of an arc; bulge is not 0."""
    (x, y), (u, v) = start[:2], end[:2]
    rise = (1.0 - bulge * bulge) / (4.0 * bulge)  # of the centre to the left of the chord, as a share of it
    centre = 0.5 * (x + u) - rise * (v - y), 0.5 * (y + v) + rise * (u - x)
    return Circle(*centre, 0.25 * math.hypot(u - x, v - y) * (1.0 + bulge * bulge) / abs(bulge))


def as_circle(outline: Outline, tolerance: float) -> Circle | None:
    """The circle that an outline of arcs is; None if it is none."""
    if any(corner.bulge == 0.0 for corner in outline):
        return None
    if abs(abs(sum(math.atan(corner.bulge) for corner in outline)) - 0.5 * math.pi) > 1e-6:
        return None
    arcs = [arc_centre(a[:2], b[:2], a.bulge) for a, b in around(outline)]
    widest = max(arcs, key=lambda arc: arc.radius)
    for arc in arcs:
        if math.dist(arc, widest) > tolerance:
            return None
    return arcs[0]


def around(outline: Sequence[Corner]) -> list[tuple[Corner, Corner]]:
    """Each edge from its first to its second corner."""
    return list(zip(outline, [*outline[1:], outline[0]], strict=True))


# ---------------------------------------------------------------- integrals
@cache
def _nodes() -> tuple[Array, Array]:
    """Places and weights on 0..1."""
    at, weight = np.polynomial.legendre.leggauss(NODES)
    return 0.5 * (at + 1.0), 0.5 * weight


def moments(outline: Outline) -> Figure:
    """Area, centre and second moment about the centre of what a closed line bounds, in either sense."""
    corners = np.array(outline, float)
    low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    middle = 0.5 * (low + high)
    size = float(max(high - low)) or 1.0
    start = (corners[:, :2] - middle) / size
    end, weight = np.roll(start, -1, axis=0), _nodes()[1]
    sums = np.zeros(4)
    for k in range(0, len(start), TOGETHER):
        these = slice(k, k + TOGETHER)
        (x, y), (dx, dy) = _along(start[these], end[these], corners[these, 2])
        parts = (x * dy - y * dx) / 2.0, x * x * dy / 2.0, -y * y * dx / 2.0, (x**3 * dy - y**3 * dx) / 3.0
        sums += [float((part @ weight).sum()) for part in parts]
    area, first_x, first_y, second = map(float, sums)
    if area == 0.0:
        return Figure(0.0, (float(middle[0]), float(middle[1])), 0.0)
    cx, cy = first_x / area, first_y / area
    about = abs(second - area * (cx * cx + cy * cy))
    centre = float(middle[0] + size * cx), float(middle[1] + size * cy)
    return Figure(abs(area) * size**2, centre, about * size**4)


def _along(start: Array, end: Array, bulge: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """(n, NODES) points of edges, and their rates by u."""
    u = _nodes()[0][None]
    chord = end - start
    length, direction = np.hypot(*chord.T)[:, None], np.arctan2(chord[:, 1], chord[:, 0])[:, None]
    half = 2.0 * np.arctan(bulge)[:, None]
    flat = np.abs(half) < 1e-9
    safe = np.where(flat, 1.0, half)
    share = np.where(flat, u, np.sin(safe * u) / np.sin(safe))
    rate = np.where(flat, 1.0, safe / np.sin(safe))
    angle = direction - half + half * u
    point = start[:, :1] + length * share * np.cos(angle), start[:, 1:] + length * share * np.sin(angle)
    turned = angle + half * u
    return point, (length * rate * np.cos(turned), length * rate * np.sin(turned))


def together(parts: Sequence[tuple[Figure, float]]) -> Figure:
    """A figure of several that count with signs."""
    area = sum(sign * figure.area for figure, sign in parts)
    x, y = (sum(sign * figure.area * figure.centre[k] for figure, sign in parts) / area for k in (0, 1))
    second = 0.0
    for figure, sign in parts:
        dx, dy = figure.centre[0] - x, figure.centre[1] - y
        second += sign * (figure.second + figure.area * (dx * dx + dy * dy))
    return Figure(area, (x, y), second)


# ---------------------------------------------------------------- as polygons
def flattened(outline: Outline, tolerance: float) -> list[Vector]:
    """Corners of a polygon that is nowhere farther from a closed line than this, up to 180 chords of an arc."""
    path: list[Vector] = []
    most = max(2, min(MOST_CHORDS, MOST_POINTS // len(outline)))
    for start, end in around(outline):
        path += edge_points(start, end, tolerance, most)[:-1]
    return path


def edge_points(start: Corner, end: Corner, tolerance: float, most: int = MOST_CHORDS) -> list[Vector]:
    """Points of an edge, both ends included."""
    ends = [(start.x, start.y), (end.x, end.y)]
    if start.bulge == 0.0 or ends[0] == ends[1]:
        return ends
    sweep, radius = 4.0 * math.atan(start.bulge), arc_centre(ends[0], ends[1], start.bulge).radius
    step = 2.0 * math.acos(max(-1.0, 1.0 - tolerance / radius)) if radius > tolerance else math.pi
    count = min(most, max(1, math.ceil(abs(sweep) / max(step, 1e-9)), math.ceil(abs(sweep) / 1.6)))
    length, direction = math.dist(*ends), math.atan2(end.y - start.y, end.x - start.x)
    inner: list[Vector] = []
    for k in range(1, count):
        u = k / count
        reach = length * math.sin(0.5 * sweep * u) / math.sin(0.5 * sweep)
        angle = direction - 0.5 * sweep * (1.0 - u)
        inner.append((start.x + reach * math.cos(angle), start.y + reach * math.sin(angle)))
    return [ends[0], *inner, ends[1]]
