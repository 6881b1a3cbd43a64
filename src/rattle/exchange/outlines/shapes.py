"""The shape of the body that a layer is: its outline, holes in it, and how heavy it is."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from rattle.description.model import Vector
from rattle.description.polygon import MOST_CORNERS, Figure, fault, fault_of_holes
from rattle.errors import InputError
from rattle.exchange.outlines.bands import band
from rattle.exchange.outlines.chains import chained
from rattle.exchange.outlines.edges import Array, Circle, Outline, around, as_circle, flattened, moments, together
from rattle.exchange.outlines.plan import MOST_OUTLINES, Layer

FINE = 1e-5  # distance of a polygon from its outline, as a share of its size, where it is asked what is inside of it
SEEN = (4e-4, 5e-5)  # the same of polygons that are shown; the second where the first cross
MOST_SEEN = 400  # corners of polygons that are shown
WORTH = 200  # corners that take as long to look at as an outline takes besides
ALL = slice(None)
SAMPLED = 100_000  # pairs of corners that are looked at to find out whether one outline is in another


@dataclass
class Traced:
    """The closed lines of a layer."""

    name: str
    outlines: list[Outline]
    circles: list[Circle]
    rim: Circle | None = None  # of its circles that which is its outline
    notes: list[str] = field(default_factory=list)  # what of it is no part of a body
    assumed: list[str] = field(default_factory=list)

    @property
    def tests(self) -> int:
        """How much there is to look at to find out what is inside of what."""
        many = len(self.outlines) + len(self.circles)
        return many * (sum(map(len, self.outlines)) + WORTH * len(self.outlines))


class Shape(NamedTuple):
    """A body of one thickness; lengths in units of the drawing."""

    figure: Figure
    polygon: list[Vector]  # [] where it cannot be shown
    holes: list[list[Vector]]
    assumed: tuple[str, ...] = ()


# ---------------------------------------------------------------- what closes
def trace(layer: Layer, tolerance: float) -> Traced:
    """The closed lines of a layer, and which of its circles is its outline."""
    chains = chained(layer.strokes, tolerance)
    if len(chains.outlines) > MOST_OUTLINES:
        raise InputError(f"layer {layer.name}: more than {MOST_OUTLINES} closed lines; keep what bounds a body")
    traced = Traced(layer.name, [], _once(layer.circles, tolerance))
    for outline in _apart([_cleaned(outline, tolerance) for outline in (*layer.outlines, *chains.outlines)], tolerance):
        circle = as_circle(outline, tolerance)
        if circle is not None:
            traced.circles = _once([*traced.circles, circle], tolerance)
        elif moments(outline).area > tolerance**2:
            traced.outlines.append(outline)
        else:
            traced.notes.append(f"a closed line without area on layer {layer.name}")
    traced.notes += [f"{what} on layer {layer.name}, which closes nothing" for what in chains.loose]
    for x, y in chains.branches:
        traced.notes.append(f"lines on layer {layer.name} that branch at ({x:g}, {y:g})")
    traced.rim = _rim(traced)
    return traced


def _cleaned(outline: Outline, tolerance: float) -> Outline:
    """An outline without edges that are no longer than the tolerance."""
    kept = tuple(a for a, b in around(outline) if math.dist(a[:2], b[:2]) > tolerance)
    return kept if len(kept) > 1 else outline


def _once(circles: Iterable[Circle], tolerance: float) -> list[Circle]:
    """Circles that are drawn twice are one."""
    kept: dict[tuple[int, ...], Circle] = {}
    for circle in circles:
        kept.setdefault(tuple(round(x / (tolerance or 1e-300)) for x in circle), circle)
    return list(kept.values())


def _apart(outlines: Sequence[Outline], tolerance: float) -> list[Outline]:
    """Outlines that are drawn twice are one, in whatever sense and wherever they begin."""
    kept: dict[tuple[object, ...], Outline] = {}
    for outline in outlines:
        spots = sorted((round(x / (tolerance or 1e-300)), round(y / (tolerance or 1e-300))) for x, y, _ in outline)
        bend = sum(abs(corner.bulge) for corner in outline)
        kept.setdefault((*spots, round(bend, 6)), outline)
    return list(kept.values())


def _rim(traced: Traced) -> Circle | None:
    """The circle around all else on the layer; None if there is none."""
    widest = max(traced.circles, key=lambda circle: circle.radius, default=None)
    if widest is None:
        return None
    room = widest.radius * (1.0 + 1e-9)
    fits = all(math.dist(c[:2], widest[:2]) + c.radius <= room for c in traced.circles)
    for outline in traced.outlines:
        fits = fits and all(math.dist(p, widest[:2]) <= room for p in flattened(outline, FINE * widest.radius))
    return widest if fits else None


# ---------------------------------------------------------------- the body
def shape_of(traced: Traced, pins: Collection[Circle]) -> Shape:
    """The body that a layer is.

    pins: circles of it at joints, which the pins fill.  Other circles within its outline are holes.  Without an outline
    it is the band around its circles.
    """
    outlines, instead = _outlines(traced, pins)
    pieces = _nested(outlines, traced.name)
    pieces += [_Piece(circle.outline, depth=1) for circle in _holes(traced, pins, pieces)]
    figure = together([(piece.figure, (-1.0) ** piece.depth) for piece in pieces])
    polygon, holes = _seen(pieces, traced.name)
    assumed = [*instead, *(f"{traced.name} {words}" for words in _not_seen(pieces, polygon, holes))]
    return Shape(figure, polygon, holes, tuple(assumed))


def _outlines(traced: Traced, pins: Collection[Circle]) -> tuple[list[Outline], list[str]]:
    """The closed lines of a body, and what stands for them where there is none."""
    outlines = list(traced.outlines)
    if traced.rim is not None and (not outlines or traced.rim not in pins):
        disc = f"{traced.name} has no closed outline: it is the disc of its circle"
        return [*outlines, traced.rim.outline], [disc] if traced.rim in pins else []
    if not outlines:
        return [band(traced.circles)], [f"{traced.name} has no closed outline: it is the band around its circles"]
    return outlines, []


def _nested(outlines: Sequence[Outline], layer: str) -> list[_Piece]:
    """Closed lines, the largest first, with the number of those that each is within."""
    pieces = sorted((_Piece(outline) for outline in outlines), key=lambda piece: -piece.figure.area)
    for k, piece in enumerate(pieces):
        piece.depth = sum(_is_within(piece, other, layer) for other in pieces[:k])
    return pieces


def _holes(traced: Traced, pins: Collection[Circle], pieces: Sequence[_Piece]) -> list[Circle]:
    """Circles that are cut out of a body: those which no pin fills."""
    filled = [circle for circle in traced.circles if any(_concentric(circle, pin) for pin in pins)]
    others = [circle for circle in traced.circles if circle != traced.rim and circle not in filled]
    return _apart_from_others([circle for circle in others if _is_cut(circle, pieces)])


def _not_seen(pieces: Sequence[_Piece], polygon: object, holes: object) -> Iterator[str]:
    """What of a body its picture does not show, in words."""
    solid = sum(piece.depth % 2 == 0 for piece in pieces)
    if solid > 1:
        yield f"has {solid} outlines apart: one body, of which the largest is shown"
    if not polygon:
        yield "is shown without its outline, which has too many corners or walls too thin"
    elif not holes and any(piece.depth == 1 for piece in pieces):
        yield "is shown without its holes, which are too many"


def _is_within(piece: _Piece, other: _Piece, layer: str) -> bool:
    """True if an outline is in a larger one, False if it is beside it.  Raises InputError if they cross."""
    if (piece.low > other.high).any() or (piece.high < other.low).any():
        return False
    every = max(1, len(piece.polygon) * len(other.polygon) // SAMPLED)
    corners = piece.polygon[::every]
    inside = other.hold(corners)
    if inside.any() and not inside.all():
        clear = other.distances(corners) > FINE * other.size
        if len(set(inside[clear])) > 1:
            x, y = piece.outline[0][:2]
            raise InputError(f"layer {layer}: the outline through ({x:g}, {y:g}) crosses another one; draw them as one")
        return bool(inside[clear].any())
    return bool(inside.all())


class _Piece:
    """A closed line of a body, and within how many others it is."""

    def __init__(self, outline: Outline, depth: int = 0) -> None:
        self.outline, self.depth = outline, depth
        self.figure = moments(outline)
        at = np.array([corner[:2] for corner in outline])
        self.size = float(np.ptp(at, axis=0).max())
        self.polygon = np.array(flattened(outline, FINE * self.size))  # near enough to ask what is inside
        self.low, self.high = self.polygon.min(axis=0), self.polygon.max(axis=0)
        self.ends = np.roll(self.polygon, -1, axis=0)
        self.longest = float(np.hypot(*(self.ends - self.polygon).T).max())

    def hold(self, points: Array) -> Array:
        """(n,) whether points (n, 2) are inside: a ray from them crosses the line an odd number of times."""
        a, b, x, y = self.polygon, self.ends, points[:, :1], points[:, 1:]
        spans = (a[:, 1] > y) != (b[:, 1] > y)
        height = b[:, 1] - a[:, 1]
        at = a[:, 0] + (y - a[:, 1]) / np.where(height == 0.0, 1.0, height) * (b[:, 0] - a[:, 0])
        odd: Array = (spans & (at > x)).sum(axis=1) % 2 == 1
        return odd

    def is_clear(self, point: Vector, reach: float) -> bool:
        """True if the line comes nowhere nearer to a point than reach."""
        at = np.array(point)
        if ((at > self.high + reach) | (at < self.low - reach)).any():
            return True
        near = ((self.polygon - at) ** 2).sum(axis=1) <= (
            reach + self.longest
        ) ** 2  # a chord begins so near, or is far
        return not near.any() or bool(self.distances(at[None], near)[0] >= reach)

    def distances(self, points: Array, chords: Array | slice = ALL) -> Array:
        """(n,) how far points (n, 2) are from the line, or from some chords of it."""
        begin = self.polygon[chords]
        chord, to = self.ends[chords] - begin, points[:, None] - begin
        along = np.clip((chord * to).sum(axis=2) / np.maximum((chord**2).sum(axis=1), 1e-300), 0.0, 1.0)
        far: Array = np.hypot(*np.moveaxis(to - along[..., None] * chord, 2, 0)).min(axis=1)
        return far

    def surrounds(self, point: Vector) -> bool:
        """True if a point is inside."""
        at = np.array(point)
        return bool((at > self.low).all() and (at < self.high).all() and self.hold(at[None])[0])


def _apart_from_others(circles: Sequence[Circle]) -> list[Circle]:
    """Circles that are in no larger one, and cross none."""
    kept: list[Circle] = []
    at = np.empty((len(circles), 3))
    for circle in sorted(circles, key=lambda circle: -circle.radius):
        x, y, radius = at[: len(kept)].T
        if not (np.hypot(x - circle.x, y - circle.y) < radius + circle.radius * (1.0 - 1e-6)).any():
            at[len(kept)] = circle
            kept.append(circle)
    return kept


def _is_cut(circle: Circle, pieces: Sequence[_Piece]) -> bool:
    """True if a circle is a hole in solid material: it crosses no outline and is in no hole of that kind."""
    if sum((-1) ** piece.depth for piece in pieces if piece.surrounds(circle[:2])) != 1:
        return False
    return all(piece.is_clear(circle[:2], circle.radius * (1.0 - 1e-6)) for piece in pieces)


def _concentric(circle: Circle, other: Circle) -> bool:
    return math.dist(circle[:2], other[:2]) <= 1e-6 * max(circle.radius, other.radius)


def _seen(pieces: Sequence[_Piece], layer: str) -> tuple[list[Vector], list[list[Vector]]]:
    """The polygon that is shown of a body, and the holes in it; none if they cross."""
    outer, cut = pieces[0], [piece for piece in pieces if piece.depth == 1]
    cut = [piece for piece in cut if outer.surrounds(piece.outline[0][:2])]
    crossed = ""
    for share in SEEN:
        rings = [_polygon(piece.outline, share * outer.size) for piece in (outer, *cut)]
        if sum(map(len, rings)) > MOST_CORNERS:
            rings = rings[:1]
        if len(rings[0]) > MOST_CORNERS:
            return [], []
        crossed = next(filter(None, map(fault, rings)), "")
        if not crossed and not fault_of_holes(rings[0], rings[1:]):
            return rings[0], rings[1:]
    if crossed:
        raise InputError(f"layer {layer}: as a polygon {crossed}")
    return [], []


def _polygon(outline: Outline, tolerance: float) -> list[Vector]:
    """Corners that are shown of an outline: coarser where they are many."""
    path = flattened(outline, tolerance)
    return path if len(path) <= MOST_SEEN else _thinned(path, tolerance)


def _thinned(path: list[Vector], tolerance: float) -> list[Vector]:
    """A closed polygon without corners that are hardly any: where it has many, every second is left out that may be."""
    at = np.array(path)
    while len(at) > MOST_SEEN:
        before, after = np.roll(at, 1, axis=0), np.roll(at, -1, axis=0)
        (u, v), (p, q) = (after - before).T, (at - before).T
        off = np.abs(u * q - v * p) / np.maximum(np.hypot(u, v), 1e-300)
        kept = (off > tolerance) | (np.arange(len(at)) % 2 == 0)
        if kept.all():
            tolerance *= 4.0
        at = at[kept]
    return [(float(x), float(y)) for x, y in at]
