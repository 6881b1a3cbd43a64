"""Straight cuts through plates: where they run through material, and what is on both sides of them.

A cut goes from a first end to a second one, both on or beyond the edge, and divides the plate in two.  Its left part is
on the left as one looks along it.  Holes that it crosses are halved with it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.description.polygon import Figure, Vector, figure_of, is_inside
from rattle.language.recorded import bare

Array = NDArray[np.float64]
ROUNDING = 1e-9  # share of the size of a plate within which an end of a cut is on its edge


class CutFault(ValueError):
    """Why a plate cannot be cut so, in words."""


class _Crossings(NamedTuple):
    """Where the line of a cut crosses a ring: numbers of edges, places along the cut, and points."""

    edges: NDArray[np.int64]
    places: Array
    points: Array


Spans = list[tuple[float, float]]  # from where to where along a cut [m]


class Cut:
    """A plate cut from one end to another; rings: of its outline and of each hole [m]; ends [m].

    pieces: from where to where it runs through material, on both sides of it, along it from the first end [m].  left,
    right: area, centre and second moment of both parts [m^2, m, m^4].  crossed: rings of the holes that it halves.
    Raises CutFault unless it divides the plate in two.
    """

    def __init__(self, rings: Sequence[Sequence[Vector]], ends: tuple[Vector, Vector]) -> None:
        outline, *holes = self._all = [_numbers(ring) for ring in rings]
        self.first, second = _numbers(ends)
        self._size = float(np.ptp(outline, axis=0).max())
        self._length = float(np.hypot(*(second - self.first)))
        if not self._length > ROUNDING * self._size:
            raise CutFault("both ends are at one place")
        self.along = (second - self.first) / self._length
        through = _common(self._material(True), self._material(False))
        on_left, span = self._way(outline, through)
        self.pieces = [(a, b) for a, b in through if self._within((a, b)) and a >= span[0] and b <= span[1]]
        self._divide(outline, holes, on_left, span)

    def _way(self, outline: Array, through: Spans) -> tuple[bool, tuple[float, float]]:
        """Where it parts the outline, and whether corners on its line count as left or as right for that: as if it ran

        a little beside them.
        """
        for on_left in (True, False):
            spans = [span for span in self._spans(outline, on_left) if self._within(span)]
            if len(spans) > 1:
                raise CutFault(f"goes through the plate {len(spans)} times, expected once: it must part it in two")
            if spans and any(map(self._within, through)):
                return on_left, spans[0]
        raise CutFault(self._why_not(through))

    def _aside(self, points: Array) -> Array:
        """How far points (..., 2) are to the left [m]."""
        to = points - self.first
        return np.asarray(self.along[0] * to[..., 1] - self.along[1] * to[..., 0])

    def _within(self, span: tuple[float, float]) -> bool:
        near = ROUNDING * self._size
        return span[0] >= -near and span[1] <= self._length + near

    def _is_left(self, ring: Array, on_left: bool) -> NDArray[np.bool_]:
        near = ROUNDING * self._size
        return self._aside(ring) >= (-near if on_left else near)

    def _crossings(self, ring: Array, on_left: bool) -> _Crossings:
        """Where the line crosses a ring, corners on it counting as left or as right, in order along it."""
        aside, left = self._aside(ring), self._is_left(ring, on_left)
        edges = np.flatnonzero(left != np.roll(left, -1))
        share = np.clip(aside[edges] / (aside[edges] - np.roll(aside, -1)[edges]), 0.0, 1.0)[:, None]
        points = (1.0 - share) * ring[edges] + share * np.roll(ring, -1, axis=0)[edges]
        places = (points - self.first) @ self.along
        order = np.argsort(places, kind="stable")
        return _Crossings(edges[order], places[order], points[order])

    def _spans(self, ring: Array, on_left: bool) -> Spans:
        """Where the line is inside of a ring."""
        places = self._crossings(ring, on_left).places.tolist()
        return list(zip(places[::2], places[1::2], strict=True))

    def _material(self, on_left: bool) -> Spans:
        """Where the line is in material."""
        places = sorted(x for ring in self._all for span in self._spans(ring, on_left) for x in span)
        return list(zip(places[::2], places[1::2], strict=True))

    def _why_not(self, through: Spans) -> str:
        near = ROUNDING * self._size
        if any(min(b, self._length) - max(a, 0.0) > near for a, b in through):
            return "one of its ends is in the material, or in a hole: put both on or beyond the edge of the plate"
        return "does not meet the plate: expected two points on or beyond its edge, with material on both sides between"

    def _divide(self, outline: Array, holes: Sequence[Array], on_left: bool, span: tuple[float, float]) -> None:
        """Both parts of the plate."""
        halves = self._halves(outline, on_left, span)
        assert halves is not None, "its span ends where the outline is crossed"
        self._rings = halves
        inside: tuple[list[Array], list[Array]] = [], []
        self.crossed = list[Array]()
        for number, hole in enumerate(holes, 1):
            crossed = [x for x in self._crossings(hole, on_left).places.tolist() if span[0] <= x <= span[1]]
            if len(crossed) > 2:
                raise CutFault(f"meets hole {number} {len(crossed)} times, expected 2")
            parts = self._halves(hole, on_left, (crossed[0], crossed[1])) if crossed else None
            if parts is None:
                far = hole[np.argmax(np.abs(self._aside(hole)))]
                inside[0 if is_inside(halves[0], far) else 1].append(hole)
                continue
            self.crossed.append(hole)
            for side, part in zip(inside, parts, strict=True):
                if _width(self._aside(part)) > ROUNDING * self._size:
                    side.append(part)
        self.left, self.right = (_figure(ring, within) for ring, within in zip(self._rings, inside, strict=True))

    def _halves(self, ring: Array, on_left: bool, span: tuple[float, float]) -> tuple[Array, Array] | None:
        """Corners of the left and of the right part of a ring that is crossed at both ends of a span; None if it is not

        crossed there.
        """
        edges, places, points = self._crossings(ring, on_left)
        start, end = (int(np.argmin(np.abs(places - x))) for x in span)
        if start == end:  # two crossings at one place
            return None
        (a, first), (b, second) = sorted([(int(edges[n]), n) for n in (start, end)])
        up = np.vstack([points[first], ring[a + 1 : b + 1], points[second]])
        down = np.vstack([points[second], ring[b + 1 :], ring[: a + 1], points[first]])
        return (up, down) if self._is_left(ring, on_left)[a + 1] else (down, up)

    def is_left(self, points: Array, forces: Array) -> NDArray[np.bool_]:
        """Whether forces (n, 2) at points (n, 2) act on the left part.

        A point, one for all forces or one for each, belongs to the part around it, outside of the plate to the
        nearest.  On the cut, or in a hole that it crosses, a force acts where it points to, as a pin presses.
        """
        near = [_distances(ring, points) for ring in self._rings]
        left = near[0] < near[1]
        either = np.abs(near[0] - near[1]) <= ROUNDING * self._size
        for hole in self.crossed:
            either |= _distances(hole, points) <= ROUNDING * self._size
        across = self.along[0] * forces[:, 1] - self.along[1] * forces[:, 0]
        return np.asarray(np.where(either, across > 0.0, left))


def _figure(ring: Array, holes: Sequence[Array]) -> Figure:
    """The moments of a part; a hole that was halved reaches to its edge."""
    outline, *within = ([(float(x), float(y)) for x, y in corners] for corners in (ring, *holes))
    return figure_of(outline, within)


def _width(values: Array) -> float:
    return float(np.ptp(values))


def _common(spans: Spans, others: Spans) -> Spans:
    """Where both are."""
    shared = [(max(a, c), min(b, d)) for a, b in spans for c, d in others]
    return sorted(span for span in shared if span[1] > span[0])


def _numbers(points: Sequence[Vector]) -> Array:
    return np.array([(bare(x), bare(y)) for x, y in points])


def _distances(ring: Array, points: Array) -> Array:
    """How far points (n, 2) are from a polygon (n,) [m]; 0 within."""
    nearest, within = np.full(len(points), np.inf), np.zeros(len(points), bool)
    x, y = points.T
    for start, end in itertools.pairwise([*ring, ring[0]]):
        along = end - start
        square = along @ along
        share = np.clip((points - start) @ along / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(points))
        nearest = np.minimum(nearest, np.hypot(*(points - start - share[:, None] * along).T))
        if along[1] != 0.0:  # the edge is met by a ray to the right
            meets = ((start[1] > y) != (end[1] > y)) & (start[0] + (y - start[1]) / along[1] * along[0] > x)
            within ^= meets
    return np.where(within, 0.0, nearest)
