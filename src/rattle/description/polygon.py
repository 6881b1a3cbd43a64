"""Plane figures bounded by polygons: whether they are sound, and their area, centre and second moment.

With the corners (x_i, y_i) in order around the figure, i + 1 behind the last being the first, and

    a_i = x_i y_{i+1} - x_{i+1} y_i,      A = 1/2 sum a_i  (positive if counter-clockwise),
    c   = 1/(6 A) sum a_i (r_i + r_{i+1}),
    I_O = 1/12 sum a_i (r_i.r_i + r_i.r_{i+1} + r_{i+1}.r_{i+1}),      I_c = I_O - A c.c

Holes count negative: A = A_0 - sum A_k,  c = (A_0 c_0 - sum A_k c_k)/A,  and I about c by the parallel-axis theorem.

Source: Steger, On the calculation of arbitrary moments of polygons, TU Munich FGBV-96-05 (1996), from Green's theorem.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle.language.recorded import Recorded, bare

Vector = tuple[float, float]
Ring = Sequence[Vector]  # corners in order around, each once
CLOSE = 1e-12  # share of the size of a figure below which a distance counts as none
MOST_CORNERS = 1000  # of one plate, those of its holes included
MOST_PAIRS = 2000  # of edges that a trace watches; with more corners it watches the sign of the area only


class Figure(NamedTuple):
    """A figure with holes."""

    area: float  # [m^2]
    centre: Vector  # [m]
    second: float  # second moment of area about the centre [m^4]


def figure_of(outline: Ring, holes: Sequence[Ring] = ()) -> Figure:
    """Area, centre and second moment of a figure; corners [m], in either sense, of sound rings."""
    whole, *cut = (_moments(ring) for ring in (outline, *holes))
    area = whole.area - sum(hole.area for hole in cut)
    x, y = ((whole.area * whole.centre[k] - sum(hole.area * hole.centre[k] for hole in cut)) / area for k in (0, 1))

    def about_centre(figure: Figure) -> float:
        dx, dy = figure.centre[0] - x, figure.centre[1] - y
        return figure.second + figure.area * (dx * dx + dy * dy)

    return Figure(area, (x, y), about_centre(whole) - sum(map(about_centre, cut)))


def _moments(ring: Ring) -> Figure:
    """Moments of a figure without holes; corners count from the first one, so that a far origin costs no digits."""
    ox, oy = ring[0]
    at = [(x - ox, y - oy) for x, y in ring]
    twice = first_x = first_y = second = 0.0
    for (x, y), (u, v) in zip(at, [*at[1:], at[0]], strict=True):
        a = x * v - u * y
        twice += a
        first_x += a * (x + u)
        first_y += a * (y + v)
        second += a * (x * x + y * y + x * u + y * v + u * u + v * v)
    if twice < 0.0:
        twice, first_x, first_y, second = -twice, -first_x, -first_y, -second
    area, x, y = twice / 2, first_x / (3 * twice), first_y / (3 * twice)
    return Figure(area, (ox + x, oy + y), second / 12 - area * (x * x + y * y))


# ---------------------------------------------------------------- what can be wrong with it
def fault(ring: Ring) -> str:
    """What is wrong with the corners of one ring, "" if nothing; corners count from 1."""
    corners = np.array([(bare(x), bare(y)) for x, y in ring])
    n = len(corners)
    if n < 3:
        return f"{n} corner{'s' * (n != 1)}; a polygon has three or more"
    after = np.roll(corners, -1, axis=0)
    size = float(np.ptp(corners, axis=0).max())
    for k in np.flatnonzero(np.abs(after - corners).max(axis=1) <= CLOSE * size):
        return f"corner {(k + 1) % n + 1} is at the place of corner {k + 1}; give every corner once"
    far = corners - corners[0]
    along = far[np.argmax(np.hypot(*far.T))]
    if np.abs(far[:, 0] * along[1] - far[:, 1] * along[0]).max() <= CLOSE * size**2:
        return "its area is zero: all corners are on one line"
    met = _meeting(corners, corners, size, within=True)
    if met is None:
        return ""
    a, b = (f"the edge from corner {k + 1} to {(k + 1) % n + 1}" for k in met)
    return f"{a} meets {b}; expected the corners in order around, without crossing"


def fault_of_holes(outline: Ring, holes: Sequence[Ring]) -> tuple[int, str] | None:
    """Number of the first hole that is not inside of the outline and apart from the others, and why."""
    rings = [np.array([(bare(x), bare(y)) for x, y in ring]) for ring in (outline, *holes)]
    size = float(np.ptp(rings[0], axis=0).max())
    for k, hole in enumerate(rings[1:]):
        if _meeting(rings[0], hole, size) is not None or not is_inside(rings[0], hole[0]):
            return k, "is not inside of the polygon; expected corners within its edges"
        for other in rings[1 : k + 1]:
            if _meeting(other, hole, size) is not None or is_inside(other, hole[0]) or is_inside(hole, other[0]):
                return k, "overlaps another hole; expected holes apart from each other"
    return None


class _Edge(NamedTuple):
    """One edge of a ring: the number of the ring, its own, from where to where."""

    ring: int
    number: int
    start: Vector
    end: Vector

    @property
    def moves(self) -> bool:
        """True if its record depends on parameters."""
        return any(isinstance(x, Recorded) for x in (*self.start, *self.end))


def watch(rings: Sequence[Ring]) -> None:
    """Let a record of the corners keep that these sound rings do not cross.

    Of two edges that have no point in common, one at least has both ends on one side of the line through the other.
    """
    edges = [_Edge(n, k, ring[k], ring[(k + 1) % len(ring)]) for n, ring in enumerate(rings) for k in range(len(ring))]
    moving = {(edge.ring, edge.number) for edge in edges if edge.moves}
    if not moving or len(moving) * len(edges) > MOST_PAIRS:
        return
    size = max(abs(bare(x)) for ring in rings for corner in ring for x in corner)
    for edge, other in itertools.combinations(edges, 2):
        neighbours = edge.ring == other.ring and abs(edge.number - other.number) in (1, len(rings[edge.ring]) - 1)
        if neighbours or moving.isdisjoint((edge[:2], other[:2])):
            continue
        a, b, c, d = edge.start, edge.end, other.start, other.end
        p, q = _side(a, b, c) * _side(a, b, d), _side(c, d, a) * _side(c, d, b)
        if max(bare(p), bare(q)) > CLOSE * size**4:  # edges may lie on one line, but for rounding
            _ = (p + abs(p)) + (q + abs(q)) > 0.0  # one of the two is positive: this is kept


def watch_sides(ends: tuple[Vector, Vector], rings: Sequence[Ring]) -> None:
    """Let a record of a cut keep on which side of it every corner is, and of every edge both of its ends."""
    for ring in rings:
        for start, end in itertools.pairwise((*ring, ring[0])):
            numbers = [x for point in (*ends, start, end) for x in point]
            if not any(isinstance(x, Recorded) for x in numbers):
                continue
            least = CLOSE * max(abs(bare(x)) for x in numbers) ** 2
            sides = _side(*ends, start), _side(start, end, ends[0]), _side(start, end, ends[1])
            for side in sides:
                if abs(bare(side)) > least:
                    _ = side > 0.0  # this is kept


def _side(a: Vector, b: Vector, c: Vector) -> float:
    """On which side of the line through a and b the point c is: twice a signed area [m^2]."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _sides(start: np.ndarray, end: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(edges, points) on which side of each edge (edges, 2) the points (points, 2) are: twice a signed area [m^2]."""
    along, to = end - start, points[None] - start[:, None]
    side: np.ndarray = along[:, None, 0] * to[..., 1] - along[:, None, 1] * to[..., 0]
    return side


def _meeting(ring: np.ndarray, other: np.ndarray, size: float, within: bool = False) -> tuple[int, int] | None:
    """The first two edges of two rings that cross or touch; within: of one ring, where neighbours share a corner."""
    a, b = ring, np.roll(ring, -1, axis=0)
    c, d = other, np.roll(other, -1, axis=0)
    apart = _all_on_one_side(a, b, c, d, size) | _all_on_one_side(c, d, a, b, size).T | _apart(a, b, c, d, size)
    if within:
        n, k = len(ring), np.arange(len(ring))
        fold = _sides(a, b, d)[k, (k + 1) % n]
        back = ((a - b) * (np.roll(d, -1, axis=0) - b)).sum(axis=1) > 0.0
        apart[k, (k + 1) % n] = (np.abs(fold) > CLOSE * size**2) | ~back
        apart |= apart.T if n > 3 else np.ones_like(apart)
        apart |= np.tri(n, dtype=bool)
    met = np.argwhere(~apart)
    return (int(met[0, 0]), int(met[0, 1])) if len(met) else None


def _all_on_one_side(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, size: float) -> np.ndarray:
    """(edges ab, edges cd) whether both ends of cd are strictly on one side of the line through ab."""
    p, q = _sides(a, b, c), _sides(a, b, d)
    least = CLOSE * size**2
    return ((p > least) & (q > least)) | ((p < -least) & (q < -least))


def _apart(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, size: float) -> np.ndarray:
    """(edges ab, edges cd) whether the boxes around the edges have a gap."""
    low, high = np.minimum(a, b)[:, None] - CLOSE * size, np.maximum(a, b)[:, None] + CLOSE * size
    gaps: np.ndarray = ((np.maximum(c, d)[None] < low) | (np.minimum(c, d)[None] > high)).any(axis=2)
    return gaps


def is_inside(ring: np.ndarray, point: np.ndarray) -> bool:
    """True if a ray from the point crosses the ring an odd number of times."""
    a, b = ring, np.roll(ring, -1, axis=0)
    spans = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    a, b = a[spans], b[spans]
    at = a[:, 0] + (point[1] - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return bool((at > point[0]).sum() % 2)
