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


class _Halves(NamedTuple):
    """A ring that is divided: from where to where along the cut, and the corners of both parts."""

    start: float
    end: float
    left: Array
    right: Array


class Cut:
    """A plate cut from one end to another; rings: of its outline and of each hole [m]; ends [m].

    pieces: from where to where it runs through material, along it from the first end [m].  left, right: area, centre
    and second moment of both parts [m^2, m, m^4].  crossed: rings of the holes that it goes through.
    Raises CutFault unless it divides the plate in two.
    """

    def __init__(self, rings: Sequence[Sequence[Vector]], ends: tuple[Vector, Vector]) -> None:
        outline, *holes = (_numbers(ring) for ring in rings)
        self.first, second = _numbers(ends)
        self._size = float(np.ptp(outline, axis=0).max())
        self._length = float(np.hypot(*(second - self.first)))
        if not self._length > ROUNDING * self._size:
            raise CutFault("both ends are at one place")
        self.along = (second - self.first) / self._length
        whole = self._halves(outline, "the edge of the plate")
        if whole is None:
            raise CutFault("does not meet the plate; expected two points on or beyond its edge, material between them")
        self._rings = whole.left, whole.right
        inside: tuple[list[Array], list[Array]] = [], []
        gaps = list[float]()
        self.crossed = list[Array]()
        for number, hole in enumerate(holes, 1):
            halves = self._halves(hole, f"hole {number}")
            if halves is None:
                far = hole[np.argmax(np.abs(self._aside(hole)))]
                inside[0 if is_inside(whole.left, far) else 1].append(hole)
                continue
            self.crossed.append(hole)
            gaps += [halves.start, halves.end]
            inside[0].append(halves.left)
            inside[1].append(halves.right)
        if min(_width(self._aside(ring)) for ring in self._rings) <= ROUNDING * self._size:
            raise CutFault("runs along an edge; expected material on both sides")
        edges = sorted([whole.start, *gaps, whole.end])
        self.pieces = list(zip(edges[::2], edges[1::2], strict=True))
        self.left, self.right = (_figure(ring, within) for ring, within in zip(self._rings, inside, strict=True))

    def _aside(self, points: Array) -> Array:
        """How far points (..., 2) are to the left [m]."""
        to = points - self.first
        return np.asarray(self.along[0] * to[..., 1] - self.along[1] * to[..., 0])

    def _halves(self, ring: Array, what: str) -> _Halves | None:
        """Both parts of a ring; None if the cut does not meet it.  Raises CutFault; what: is cut."""
        aside = self._aside(ring)
        left = aside >= -ROUNDING * self._size  # corners on the cut count as left
        crossed = np.flatnonzero(left != np.roll(left, -1))
        share = aside[crossed] / (aside[crossed] - np.roll(aside, -1)[crossed])
        share = np.clip(share, 0.0, 1.0)[:, None]
        at = (1.0 - share) * ring[crossed] + share * np.roll(ring, -1, axis=0)[crossed]
        place = (at - self.first) @ self.along
        near = (place >= -ROUNDING * self._size) & (place <= self._length + ROUNDING * self._size)
        if not near.any():
            return None
        if (met := int(near.sum())) != 2:
            ends = (
                "; one of its ends is in the material or in a hole: put both on or beyond the edge" if met == 1 else ""
            )
            raise CutFault(f"meets {what} {met} time{'s' * (met != 1)}, expected 2{ends}")
        (a, b), (first, second) = crossed[near], at[near]
        one = np.vstack([first, ring[a + 1 : b + 1], second])
        other = np.vstack([second, ring[b + 1 :], ring[: a + 1], first])
        start, end = sorted(place[near])
        if end - start <= ROUNDING * self._size:
            return None
        return _Halves(start, end, *((one, other) if left[a + 1] else (other, one)))

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
