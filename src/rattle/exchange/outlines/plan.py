"""What is drawn on a layer, in units of the drawing, and what of it is left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from decimal import Decimal
from typing import NamedTuple

from rattle.exchange.outlines.edges import Circle, Corner, Outline
from rattle.exchange.refusal import refused

MOST_EDGES = 10_000  # straight edges and arcs of a drawing, those of repeated blocks counted as often as they are drawn
MOST_OUTLINES = 1_000  # closed lines of a drawing
MOST_CIRCLES = 1_000  # of a drawing
FARTHEST = 1e12  # coordinate of a drawing, in its units


class Stroke(NamedTuple):
    """An edge that is drawn by itself: its first corner with the bulge, and its end."""

    start: Corner
    end: Corner
    what: str  # its name in the file


@dataclass
class Layer:
    """What is drawn on one layer."""

    name: str
    outlines: list[Outline] = field(default_factory=list)
    strokes: list[Stroke] = field(default_factory=list)
    circles: list[Circle] = field(default_factory=list)


@dataclass
class Plan:
    """A drawing by layers, in the order of the file."""

    name: str  # of the file
    layers: dict[str, Layer] = field(default_factory=dict)
    metres: Decimal = Decimal("0.001")  # length of its unit
    assumed: list[str] = field(default_factory=list)
    left_out: Counter[str] = field(default_factory=Counter)  # how often, by what
    edges: int = 0
    outlines: int = 0
    circles: int = 0

    def add_outline(self, layer: str, outline: Outline) -> None:
        """Add a closed line."""
        self._count(len(outline))
        self.outlines += 1
        if self.outlines > MOST_OUTLINES:
            raise refused(self.name, f"more than {MOST_OUTLINES} closed lines; keep what bounds bodies")
        for corner in outline:
            self._reach(corner.x, corner.y)
        self._layer(layer).outlines.append(outline)

    def add_stroke(self, layer: str, start: Corner, end: Corner, what: str) -> None:
        """Add an edge."""
        self._count(1)
        self._reach(start.x, start.y)
        self._reach(end.x, end.y)
        self._layer(layer).strokes.append(Stroke(start, end, what))

    def add_circle(self, layer: str, circle: Circle) -> None:
        """Add a circle."""
        self._reach(abs(circle.x) + circle.radius, circle.y)
        self.circles += 1
        if self.circles > MOST_CIRCLES:
            raise refused(self.name, f"more than {MOST_CIRCLES} circles; keep those of the pins and holes")
        self._layer(layer).circles.append(circle)

    def leave_out(self, what: str, layer: str) -> None:
        """Name what cannot be taken."""
        self.left_out[f"{what} on layer {layer}"] += 1

    def points(self) -> Iterator[tuple[float, float]]:
        """Corners, and the boxes of circles."""
        for layer in self.layers.values():
            for outline in layer.outlines:
                yield from (corner[:2] for corner in outline)
            for stroke in layer.strokes:
                yield stroke.start[:2]
                yield stroke.end[:2]
            for x, y, radius in layer.circles:
                yield x - radius, y - radius
                yield x + radius, y + radius

    @property
    def size(self) -> float:
        """The longer side of the box around everything, in units of the drawing; 0 without anything."""
        points = list(self.points()) or [(0.0, 0.0)]
        return max(max(p[k] for p in points) - min(p[k] for p in points) for k in (0, 1))

    def length(self, number: float) -> float:
        """A length of the drawing in m, rounded once: 0.2 mm are 0.0002 m."""
        return float(Decimal(repr(number)) * self.metres)

    def difference(self, number: float, other: float) -> float:
        """The difference of two lengths of the drawing in m, as the decimals stand: 4.2 - 4 mm are 0.0002 m."""
        return float((Decimal(repr(number)) - Decimal(repr(other))) * self.metres)

    def _layer(self, name: str) -> Layer:
        return self.layers.setdefault(name, Layer(name))

    def _count(self, edges: int) -> None:
        self.edges += edges
        if self.edges > MOST_EDGES:
            raise refused(self.name, f"more than {MOST_EDGES} lines and arcs; keep those of one mechanism")

    def _reach(self, x: float, y: float) -> None:
        if not (abs(x) < FARTHEST and abs(y) < FARTHEST):
            raise refused(self.name, f"a coordinate beyond {FARTHEST:g}; move the drawing to the origin")
