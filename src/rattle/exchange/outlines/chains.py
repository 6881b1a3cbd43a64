"""Lines and arcs that close: outlines of edges in any order and direction."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from rattle.exchange.outlines.edges import Corner, Outline
from rattle.exchange.outlines.plan import Stroke


class _Edge(NamedTuple):
    """An edge between two numbered places."""

    start: int
    end: int
    bulge: float
    what: str


class Chained(NamedTuple):
    """What edges are together."""

    outlines: list[Outline]
    loose: list[str]  # what closes nothing, by its name in the file
    branches: list[tuple[float, float]]  # places at which three or more edges of a closed figure meet


class _Places:
    """Places that are apart by more than a tolerance, by numbers."""

    def __init__(self, tolerance: float) -> None:
        self.reach = tolerance or 1e-300
        self.spots: list[tuple[float, float]] = []
        self._cells: dict[tuple[float, float], list[int]] = {}

    def number(self, x: float, y: float) -> int:
        """The place within the tolerance, or else a new one."""
        column, row = math.floor(x / self.reach), math.floor(y / self.reach)
        for across in (column, column - 1, column + 1):
            for upwards in (row, row - 1, row + 1):
                for k in self._cells.get((across, upwards), ()):
                    if math.dist((x, y), self.spots[k]) <= self.reach:
                        return k
        self.spots.append((x, y))
        self._cells.setdefault((column, row), []).append(len(self.spots) - 1)
        return len(self.spots) - 1


def chained(strokes: Sequence[Stroke], tolerance: float) -> Chained:
    """Closed lines of edges whose ends are as near as the tolerance to each other."""
    places = _Places(tolerance)
    edges = _placed(strokes, places)
    at: dict[int, set[int]] = {}
    for k, edge in enumerate(edges):
        at.setdefault(edge.start, set()).add(k)
        at.setdefault(edge.end, set()).add(k)
    gone = _pruned(edges, at)
    outlines, branches, seen = [], [], set(gone)
    for k in range(len(edges)):
        if k in seen:
            continue
        part = _connected(k, edges, at)
        seen |= part
        forks = sorted({end for n in part for end in edges[n][:2] if len(at[end]) > 2})
        branches += [places.spots[n] for n in forks[:1]]
        if not forks:
            outlines.append(_walked(k, edges, at, places.spots))
    return Chained(outlines, [edges[k].what for k in gone], branches)


def _placed(strokes: Iterable[Stroke], places: _Places) -> list[_Edge]:
    """Edges between places; those without length are left out, and those that are drawn twice are one."""
    edges: dict[tuple[int, int, float], _Edge] = {}
    for stroke in strokes:
        a, b = places.number(*stroke.start[:2]), places.number(*stroke.end[:2])
        if a == b:
            continue
        low, high, bulge = (a, b, stroke.start.bulge) if a < b else (b, a, -stroke.start.bulge)
        edges.setdefault((low, high, round(bulge, 6)), _Edge(a, b, stroke.start.bulge, stroke.what))
    return list(edges.values())


def _pruned(edges: Sequence[_Edge], at: dict[int, set[int]]) -> list[int]:
    """Take away edges with an end that no other edge has; returns their numbers."""
    gone = []
    ends = [place for place, its in at.items() if len(its) == 1]
    while ends:
        place = ends.pop()
        if len(at[place]) != 1:
            continue
        (k,) = at[place]
        gone.append(k)
        for other in edges[k][:2]:
            at[other].discard(k)
            if len(at[other]) == 1:
                ends.append(other)
    return sorted(gone)


def _connected(first: int, edges: Sequence[_Edge], at: dict[int, set[int]]) -> set[int]:
    """All edges that hang together with one."""
    part, new = {first}, [first]
    while new:
        k = new.pop()
        for place in edges[k][:2]:
            more = at[place] - part
            part |= more
            new += more
    return part


def _walked(
    first: int, edges: Sequence[_Edge], at: dict[int, set[int]], spots: Sequence[tuple[float, float]]
) -> Outline:
    """The closed line that begins with an edge, where every place has two."""
    corners, k, place = [], first, edges[first].start
    while True:
        edge = edges[k]
        forward = edge.start == place
        corners.append(Corner(*spots[place], edge.bulge if forward else -edge.bulge))
        place = edge.end if forward else edge.start
        (k,) = at[place] - {k}
        if k == first:
            return tuple(corners)
