"""Read the drawing of a mechanism from a DXF file (ASCII, from R12 on).

A layer is a body, the layer `ground` the ground; see `rattle.exchange.outlines.mechanism`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

from rattle.exchange.dxf.sections import MOST_DRAWN, Block, sections_of
from rattle.exchange.dxf.tags import Entity
from rattle.exchange.imported import Assumptions, Imported
from rattle.exchange.outlines.edges import Circle, Corner, arc_bulge
from rattle.exchange.outlines.mechanism import mechanism_of
from rattle.exchange.outlines.plan import Plan
from rattle.exchange.refusal import quoted, refused

DEEPEST = 16  # blocks in blocks
UNEQUAL = 1e-9  # by how much scales of a block along x and y may differ, as a share
TURN = 2.0 * math.pi
CLOSED, MESH, POLYFACE, SPLINE_FRAME = 1, 16, 64, 16  # bits of group code 70
SILENT = {"SEQEND", "VERTEX", "ATTRIB", "VIEWPORT"}  # parts of others, and what is not of the drawing itself


class Placing(NamedTuple):
    """Where a block is: turned, scaled, perhaps mirrored, and moved; x' = a x - s b y, y' = b x + s a y and so on."""

    a: float = 1.0
    b: float = 0.0
    sense: float = 1.0  # -1: mirrored
    x: float = 0.0
    y: float = 0.0
    layer: str = "0"  # of the block: of what is drawn in it on layer 0

    def of(self, x: float, y: float) -> tuple[float, float]:
        """A point of the block in the drawing."""
        across, up = x, self.sense * y
        return self.a * across - self.b * up + self.x, self.b * across + self.a * up + self.y

    @property
    def scale(self) -> float:
        """How many times as large."""
        return math.hypot(self.a, self.b)

    def corner(self, x: float, y: float, bulge: float = 0.0) -> Corner:
        """A corner of the block in the drawing."""
        return Corner(*self.of(x, y), self.sense * bulge)


def read_dxf(text: str, name: str, assumptions: Assumptions) -> Imported:
    """The mechanism of a drawing; name: of the file.  Raises ModelError on what is no whole DXF or holds no body."""
    sections = sections_of(text, name)
    plan = Plan(name, metres=sections.metres)
    if assumptions.scale is not None:
        plan.metres = Decimal(repr(assumptions.scale))
    elif not sections.unit:
        unit = f"unknown unit {sections.units}" if sections.units else "no unit"
        plan.assumed.append(f"lengths in mm: the drawing has {unit} ($INSUNITS)")
    _Reader(plan, sections.blocks).draw(sections.drawn, Placing(), ())
    return mechanism_of(plan, assumptions, f"from the DXF drawing {Path(name).name}")


class _Reader:
    """Draws entities on the plan."""

    def __init__(self, plan: Plan, blocks: Mapping[str, Block]) -> None:
        self.plan, self.blocks = plan, blocks
        self.drawn = 0
        self.kinds: Mapping[str, Callable[[Entity, Placing], None]] = {
            "LINE": self._line, "ARC": self._arc, "CIRCLE": self._circle, "LWPOLYLINE": self._light_polyline,
        }  # fmt: skip

    def draw(self, entities: Sequence[Entity], placing: Placing, within: tuple[str, ...]) -> None:
        """Draw what stands in the section of entities, or in a block; within: the blocks that it is in."""
        for k, entity in enumerate(entities):
            if entity.kind in SILENT or entity.whole(67) == 1 or entity.whole(60) == 1:
                continue
            self.drawn += 1
            if self.drawn > MOST_DRAWN:
                raise refused(
                    self.plan.name,
                    f"more than {MOST_DRAWN} entities, those of blocks as often as inserted",
                    entity.line,
                )
            if entity.kind == "INSERT":
                self._insert(entity, placing, within)
            elif entity.kind == "POLYLINE":
                self._polyline(entity, _vertices(entities, k), placing)
            elif entity.kind in self.kinds:
                self._in_plane(entity, placing, self.kinds[entity.kind])
            else:
                self._leave_out(entity, placing)

    # ------------------------------------------------------------ places
    def _layer(self, entity: Entity, placing: Placing) -> str:
        layer = entity.text(8, "0")
        return placing.layer if layer == "0" else layer

    def _leave_out(self, entity: Entity, placing: Placing, why: str = "") -> None:
        self.plan.leave_out(f"{entity.kind}{why}", self._layer(entity, placing))

    def _in_plane(self, entity: Entity, placing: Placing, draw: Callable[[Entity, Placing], None]) -> None:
        """Draw an entity; one that is seen from below is mirrored about the y axis, one across is left out."""
        x, y, z = (entity.number(code, default) for code, default in ((210, 0.0), (220, 0.0), (230, 1.0)))
        if math.hypot(x, y) > 1e-9 * abs(z):
            self._leave_out(entity, placing, " across the plane")
        elif z < 0.0 and entity.kind != "LINE":
            draw(entity, Placing(-placing.a, -placing.b, -placing.sense, placing.x, placing.y, placing.layer))
        else:
            draw(entity, placing)

    # ------------------------------------------------------------ entities
    def _line(self, line: Entity, placing: Placing) -> None:
        start = placing.corner(line.number(10), line.number(20))
        self.plan.add_stroke(
            self._layer(line, placing), start, placing.corner(line.number(11), line.number(21)), line.kind
        )

    def _circle(self, circle: Entity, placing: Placing) -> None:
        radius = placing.scale * circle.number(40)
        if not radius > 0.0:
            self._leave_out(circle, placing, " without radius")
            return
        self.plan.add_circle(
            self._layer(circle, placing), Circle(*placing.of(circle.number(10), circle.number(20)), radius)
        )

    def _arc(self, arc: Entity, placing: Placing) -> None:
        x, y, radius = arc.number(10), arc.number(20), arc.number(40)
        start, sweep = math.radians(arc.number(50)), math.radians(arc.number(51) - arc.number(50)) % TURN
        if sweep < 1e-9 or sweep > TURN - 1e-9:
            self._circle(arc, placing)
        elif not radius > 0.0:
            self._leave_out(arc, placing, " without radius")
        else:
            (u, v), (p, q) = (
                (x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in (start, start + sweep)
            )
            first = placing.corner(u, v, arc_bulge(sweep))
            self.plan.add_stroke(self._layer(arc, placing), first, placing.corner(p, q), arc.kind)

    def _light_polyline(self, polyline: Entity, placing: Placing) -> None:
        corners: list[list[float]] = []
        for tag in polyline.tags:
            if tag.code == 10:
                corners.append([polyline.as_number(tag), 0.0, 0.0])
            elif tag.code in (20, 42) and corners:
                corners[-1][1 if tag.code == 20 else 2] = polyline.as_number(tag)
        self._path(polyline, [placing.corner(*corner) for corner in corners], placing)

    def _polyline(self, polyline: Entity, vertices: Sequence[Entity], placing: Placing) -> None:
        if polyline.whole(70) & (MESH | POLYFACE):
            self._leave_out(polyline, placing, " that is a mesh")
            return
        vertices = [vertex for vertex in vertices if not vertex.whole(70) & SPLINE_FRAME]
        heights = {vertex.number(30, 0.0) for vertex in vertices}
        if polyline.whole(70) & 8 and len(heights) > 1:
            self._leave_out(polyline, placing, " across the plane")
            return

        def draw(entity: Entity, where: Placing) -> None:
            corners = [where.corner(v.number(10), v.number(20), v.number(42, 0.0)) for v in vertices]
            self._path(entity, corners, where)

        self._in_plane(polyline, placing, draw)

    def _path(self, polyline: Entity, corners: list[Corner], placing: Placing) -> None:
        """A polyline: an outline if it is closed or ends where it begins, else edges."""
        layer = self._layer(polyline, placing)
        closed = bool(polyline.whole(70) & CLOSED)
        path = [a for a, b in itertools.pairwise(corners) if a[:2] != b[:2]]
        if corners and (not closed or not path or corners[-1][:2] != corners[0][:2]):
            path.append(corners[-1])
        if not closed and len(path) > 2 and path[0][:2] == path[-1][:2]:
            closed = bool(path.pop())
        if len(path) < 2:
            self._leave_out(polyline, placing, " without length")
        elif closed:
            self.plan.add_outline(layer, tuple(path))
        else:
            for start, end in itertools.pairwise(path):
                self.plan.add_stroke(layer, start, end, polyline.kind)

    # ------------------------------------------------------------ blocks
    def _insert(self, insert: Entity, placing: Placing, within: tuple[str, ...]) -> None:
        name = insert.text(2)
        block = self.blocks.get(name.lower())
        if block is None:
            raise refused(self.plan.name, f"INSERT of block {quoted(name)}, which is not in the file", insert.line)
        if name.lower() in within or len(within) >= DEEPEST:
            why = "is in itself" if name.lower() in within else f"is in more than {DEEPEST} others"
            raise refused(self.plan.name, f"block {quoted(name)} {why}", insert.line)
        across, up = insert.number(41, 1.0), insert.number(42, 1.0)
        if across == 0.0 or abs(abs(across) - abs(up)) > UNEQUAL * abs(across):
            self._leave_out(insert, placing, f" of {name} with unequal scale")
            return

        def draw(entity: Entity, where: Placing) -> None:
            for moved in _placings(entity, block, where, self._layer(entity, placing)):
                self.draw(block.entities, moved, (*within, name.lower()))

        self._in_plane(insert, placing, draw)


def _vertices(entities: Sequence[Entity], k: int) -> Sequence[Entity]:
    """The vertices that follow a polyline."""
    end = k + 1
    while end < len(entities) and entities[end].kind == "VERTEX":
        end += 1
    return entities[k + 1 : end]


def _placings(insert: Entity, block: Block, where: Placing, layer: str) -> Iterator[Placing]:
    """Where the copies of a block are: one, or rows and columns of them."""
    across, up = insert.number(41, 1.0), insert.number(42, 1.0)
    turn = math.radians(insert.number(50, 0.0))
    c, s = math.cos(turn), math.sin(turn)
    columns, rows = max(1, insert.whole(70, 1)), max(1, insert.whole(71, 1))
    for n in range(min(columns * rows, MOST_DRAWN + 1)):
        right, above = (n % columns) * insert.number(44, 0.0), (n // columns) * insert.number(45, 0.0)
        base_x, base_y = across * block.base[0], up * block.base[1]
        x = insert.number(10) + c * (right - base_x) - s * (above - base_y)
        y = insert.number(20) + s * (right - base_x) + c * (above - base_y)
        yield _after(where, across * c, across * s, math.copysign(1.0, across * up), (x, y), layer)


def _after(where: Placing, a: float, b: float, sense: float, at: tuple[float, float], layer: str) -> Placing:
    """A placing within a placing."""
    x, y = where.of(*at)
    turned = where.sense * b  # a mirror turns the other way
    return Placing(where.a * a - where.b * turned, where.b * a + where.a * turned, where.sense * sense, x, y, layer)
