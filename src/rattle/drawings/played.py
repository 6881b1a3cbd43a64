"""Primitives with their places worked out: what is left for matplotlib or SVG are lines, areas and marks in metres."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.drawings.numbers import PIXELS, Array, Moving, Values, number_at

GAP = np.full((1, 1, 2), np.nan)
FEWEST, MOST = 3, 80  # hatches of a wall
APART = 0.8  # distance of hatches, in their length
SPOT = 1e-9  # of the width of a bar: points that are nearer are one
CORNER = np.linspace(0.0, 1.0, 9)  # of the turn at a round corner


class Shape(NamedTuple):
    """A primitive at all frames."""

    style: Mapping[str, Any]  # the primitive as it is written
    rings: list[Array]  # (frames, n, 2) [m]; nan between strokes
    shown: NDArray[np.bool_]  # (frames,) whether it is there


class Stage:
    """A display list with the motion that it follows."""

    def __init__(self, written: Mapping[str, Any], geometry: Mapping[str, Any], moving: Moving, size: float,
                 across: float = PIXELS) -> None:  # fmt: skip
        """size: of the mechanism [m], which is so many pixels across."""
        self.written, self.geometry, self.moving, self.size = written, geometry, moving, size
        self.values = Values(written["numbers"], geometry, moving, size, across)

    def shapes(self, layer: str = "drawn") -> Iterator[Shape]:
        """All primitives of a layer in the order in which they lie over each other."""
        return self.shapes_of(self.written[layer])

    def shapes_of(self, primitives: Iterable[Mapping[str, Any]]) -> Iterator[Shape]:
        """Primitives that are there at one frame at least."""
        for primitive in primitives:
            if (shown := self._shown(primitive)).any():
                rings = [self._world(primitive["frame"], ring) for ring in self._rings(primitive)]
                yield Shape(primitive, rings, shown)

    def held(self) -> Iterator[Array]:
        """Paths (frames, n, 2) [m] that a picture has to hold."""
        for path in self.written["within"]:
            yield self._world(path["frame"], self._path(path["path"]))

    def _shown(self, primitive: Mapping[str, Any]) -> NDArray[np.bool_]:
        """(frames or 1,) whether a primitive is there."""
        return np.atleast_1d(np.asarray(self.values[primitive["when"]] if "when" in primitive else 1.0)) > 0.0

    def _rings(self, primitive: Mapping[str, Any]) -> list[Array]:
        if primitive["draw"] == "path":
            return [self._path(ring) for ring in primitive["rings"]]
        path = self._path(primitive["path"])
        if primitive["draw"] == "wall":
            return [path, hatches(path[0], float(self.values[primitive["stroke"]]))[None]]
        return [path]

    # ------------------------------------------------------------ places
    def _world(self, frame: str | Sequence[int], path: Array) -> Array:
        """A path (frames or 1, n, 2) of a frame as it lies in the world."""
        if isinstance(frame, str):
            (x, y), angle, stretch = self.moving.at(frame, 0.0, 0.0), self.moving.angle(frame), 1.0
        else:
            x, y, angle, stretch = (self.values[place] for place in frame)
        cos, sin = _column(np.cos(angle)), _column(np.sin(angle))
        u, v = _column(stretch) * path[..., 0], path[..., 1]
        return np.stack([_column(x) + cos * u - sin * v, _column(y) + sin * u + cos * v], axis=-1)

    def _path(self, pieces: Sequence[Any]) -> Array:
        """(frames or 1, n, 2) points [m] of a path in its frame."""
        every = [self._piece(piece) for piece in pieces]
        frames = max((len(piece) for piece in every), default=1)
        return np.concatenate([np.broadcast_to(piece, (frames, *piece.shape[1:])) for piece in every], axis=1)

    def _piece(self, piece: Any) -> Array:
        if piece is None:
            return GAP
        if isinstance(piece, list):
            return np.stack(np.broadcast_arrays(*(_column(self.values[place]) for place in piece)), axis=-1)
        if "trail" in piece:
            return np.asarray(self.values[piece["scale"]] * self.moving.trail(piece["trail"], piece["share"]))
        if "arc" in piece:
            return self._arc(piece)
        if "of" in piece:
            return np.array(number_at(self.geometry, piece["of"]), float)[None, :: piece["every"]]
        if "around" in piece:
            return around(self._path(piece["around"])[0], float(self.values[piece["half"]]))[None]
        if "grown" in piece:
            return grown(self._path(piece["grown"])[0], float(self.values[piece["half"]]))[None]
        copies, shift, turn = (float(self.values[piece[key]]) for key in ("copies", "shift", "turn"))
        return self._copies(self._path(piece["path"]), round(copies), shift, turn)

    def _arc(self, piece: Mapping[str, Any]) -> Array:
        x, y, radius, last, start, end = (_column(self.values[place]) for place in piece["arc"])
        share = np.linspace(0.0, 1.0, piece["count"])
        r, angle = radius + (last - radius) * share, start + (end - start) * share
        return np.stack(np.broadcast_arrays(x + r * np.cos(angle), y + r * np.sin(angle)), axis=-1)

    def _copies(self, path: Array, count: int, shift: float, turn: float) -> Array:
        k = np.repeat(np.arange(count), path.shape[1])
        x, y = np.tile(path, (1, count, 1))[0].T
        cos, sin, x = np.cos(k * turn), np.sin(k * turn), x + k * shift
        return np.column_stack([cos * x - sin * y, sin * x + cos * y])[None]


def _column(values: Any) -> Array:
    """Values (frames,) or a number as a column."""
    return np.reshape(np.asarray(values, float), (-1, 1))


def hatches(wall: Array, stroke: float) -> Array:
    """Strokes (n, 2) [m] on the right hand of a line (2, 2), so long each."""
    a, b = wall
    length = float(np.hypot(*(b - a)))
    if not length > 0.0:
        return np.zeros((0, 2))
    u = (b - a) / length
    slant = stroke * np.sqrt(0.5) * (np.array([u[1], -u[0]]) - u)
    count = max(FEWEST, min(MOST, round(length / (APART * stroke))))
    starts = a + ((np.arange(count) + 0.5) / count)[:, None] * (b - a)
    return np.stack([starts, starts + slant, np.full_like(starts, np.nan)], axis=1).reshape(-1, 2)


def around(path: Array, half: float) -> Array:
    """The outline (n, 2) of what lies at most so far from a path (m, 2), with round ends."""
    way = np.gradient(path, axis=0)
    angle = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))
    turns = np.linspace(0.0, np.pi, 19)[1:-1]
    right, left = angle - 0.5 * np.pi, angle + 0.5 * np.pi
    angles = np.concatenate([right, right[-1] + turns, left[::-1], left[0] + turns])
    ends = [path, np.repeat(path[-1:], len(turns), axis=0), path[::-1], np.repeat(path[:1], len(turns), axis=0)]
    return np.vstack(ends) + half * np.column_stack([np.cos(angles), np.sin(angles)])


def grown(points: Array, by: float) -> Array:
    """The outline (n, 2) of what lies at most so far from the convex hull of points (m, 2)."""
    corners = hull(points)
    if float(np.ptp(points, axis=0).max()) < SPOT * by:
        turn = 2.0 * np.pi * np.linspace(0.0, 1.0, 25)
        return np.asarray(points[0] + by * np.column_stack([np.cos(turn), np.sin(turn)]))
    way = np.roll(corners, -1, axis=0) - corners
    after = np.arctan2(way[:, 1], way[:, 0]) - 0.5 * np.pi
    before = np.roll(after, 1)
    angle = before[:, None] + np.mod(after - before, 2.0 * np.pi)[:, None] * CORNER
    return np.asarray(corners[:, None] + by * np.stack([np.cos(angle), np.sin(angle)], axis=2)).reshape(-1, 2)


def hull(points: Array) -> Array:
    """Corners (n, 2) of the convex hull of points (m, 2), counter-clockwise; two if all are on one line."""
    ordered = sorted(map(tuple, points.tolist()))
    corners: list[tuple[float, ...]] = []
    for way in (ordered, ordered[::-1]):
        side: list[tuple[float, ...]] = []
        for x, y in way:
            while len(side) > 1:
                (ax, ay), (bx, by) = side[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                    break
                side.pop()
            side.append((x, y))
        corners += side[:-1]
    return np.array(corners)
