"""Write a drawing of parts as DXF of the year 2000 (AC1015), lengths in mm.

Source: AutoCAD 2018 DXF reference, Autodesk (2017): header, tables, blocks, entities and objects that a file needs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from decimal import Decimal
from itertools import count
from typing import TYPE_CHECKING

from rattle.exchange.outlines.drawn import Drawn, drawn
from rattle.exchange.outlines.edges import Circle, Corner, Outline, arc_centre

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

Tag = tuple[int, str]
COLOURS = (1, 3, 5, 6, 30, 4, 14, 94, 174, 214)  # of layers of bodies, one after the other
BLACK = 7
NULL = "0"  # the handle of nothing


def dxf_of(m: Mechanism) -> tuple[str, list[str]]:
    """The drawing of a mechanism as put together as DXF, and what cannot be seen in it.

    Raises ModelError, AssemblyError.
    """
    sheet = drawn(m)
    return "".join(f"{code}\n{value}\n" for code, value in _Writer(sheet).tags()), sheet.notes


class _Writer:
    """Writes tags; every entry of a table, block, entity or object has a handle."""

    def __init__(self, sheet: Drawn) -> None:
        self.sheet = sheet
        self._handles = count(0x100)

    def tags(self) -> Iterator[Tag]:
        """The whole file."""
        body = [*self._section("TABLES", self._tables()), *self._section("BLOCKS", self._blocks()),
                *self._section("ENTITIES", self._entities()), *self._section("OBJECTS", self._objects())]  # fmt: skip
        yield 999, "lengths in mm; a layer is a body; circles about one centre are a bush and its pin"
        header = [(9, "$ACADVER"), (1, "AC1015"), (9, "$DWGCODEPAGE"), (3, "ANSI_1252"), (9, "$INSUNITS"), (70, "4"),
                  (9, "$MEASUREMENT"), (70, "1"), (9, "$HANDSEED"), (5, self._handle())]  # fmt: skip
        yield from self._section("HEADER", header)
        yield from self._section("CLASSES", [])
        yield from body
        yield 0, "EOF"

    def _section(self, name: str, tags: Iterator[Tag] | Sequence[Tag]) -> Iterator[Tag]:
        yield 0, "SECTION"
        yield 2, name
        yield from tags
        yield 0, "ENDSEC"

    def _handle(self) -> str:
        return f"{next(self._handles):X}"

    # ------------------------------------------------------------ tables
    def _tables(self) -> Iterator[Tag]:
        yield from self._table("VPORT", [])
        kinds = [("ByBlock", ""), ("ByLayer", ""), ("Continuous", "Solid line")]
        yield from self._table(
            "LTYPE", [[(2, name), (70, "0"), (3, words), (72, "65"), (73, "0"), (40, "0.0")] for name, words in kinds]
        )
        layers = [("0", BLACK), *((_text(name), self._colour(k, name)) for k, name in enumerate(self.sheet.layers))]
        yield from self._table(
            "LAYER", [[(2, name), (70, "0"), (62, str(colour)), (6, "Continuous")] for name, colour in layers]
        )
        style = [
            (2, "Standard"),
            (70, "0"),
            (40, "0.0"),
            (41, "1.0"),
            (50, "0.0"),
            (71, "0"),
            (42, "2.5"),
            (3, "txt"),
            (4, ""),
        ]
        yield from self._table("STYLE", [style])
        yield from self._table("VIEW", [])
        yield from self._table("UCS", [])
        yield from self._table("APPID", [[(2, "ACAD"), (70, "0")]])
        yield from self._table("DIMSTYLE", [[(2, "Standard"), (70, "0")]])
        yield from self._table("BLOCK_RECORD", [[(2, "*Model_Space")], [(2, "*Paper_Space")]])

    def _colour(self, k: int, layer: str) -> int:
        return BLACK if k >= len(self.sheet.layers) - 1 or layer == "ground" else COLOURS[k % len(COLOURS)]

    def _table(self, name: str, entries: Sequence[Sequence[Tag]]) -> Iterator[Tag]:
        handle = self._handle()
        yield from (
            (0, "TABLE"),
            (2, name),
            (5, handle),
            (330, NULL),
            (100, "AcDbSymbolTable"),
            (70, str(len(entries))),
        )
        if name == "DIMSTYLE":
            yield 100, "AcDbDimStyleTable"
        for entry in entries:
            own = self._handle()
            yield from (
                (0, name),
                (105 if name == "DIMSTYLE" else 5, own),
                (330, handle),
                (100, "AcDbSymbolTableRecord"),
            )
            yield 100, f"AcDb{RECORDS[name]}TableRecord"
            yield from entry
            if name == "BLOCK_RECORD":
                self._owner(entry[0][1], own)
        yield 0, "ENDTAB"

    def _owner(self, space: str, handle: str) -> None:
        if space == "*Model_Space":
            self.model = handle
        else:
            self.paper = handle

    # ------------------------------------------------------------ blocks and objects
    def _blocks(self) -> Iterator[Tag]:
        for name, owner in (("*Model_Space", self.model), ("*Paper_Space", self.paper)):
            paper = [(67, "1")] if owner == self.paper else []
            yield from ((0, "BLOCK"), (5, self._handle()), (330, owner), (100, "AcDbEntity"), *paper, (8, "0"))
            yield from (
                (100, "AcDbBlockBegin"),
                (2, name),
                (70, "0"),
                (10, "0.0"),
                (20, "0.0"),
                (30, "0.0"),
                (3, name),
                (1, ""),
            )
            yield from (
                (0, "ENDBLK"),
                (5, self._handle()),
                (330, owner),
                (100, "AcDbEntity"),
                *paper,
                (8, "0"),
                (100, "AcDbBlockEnd"),
            )

    def _objects(self) -> Iterator[Tag]:
        root, group = self._handle(), self._handle()
        yield from (
            (0, "DICTIONARY"),
            (5, root),
            (330, NULL),
            (100, "AcDbDictionary"),
            (281, "1"),
            (3, "ACAD_GROUP"),
            (350, group),
        )
        yield from ((0, "DICTIONARY"), (5, group), (330, root), (100, "AcDbDictionary"), (281, "1"))

    # ------------------------------------------------------------ entities
    def _entities(self) -> Iterator[Tag]:
        for layer, outline in self.sheet.outlines:
            yield from self._polyline(layer, outline)
        for layer, circle in self.sheet.circles:
            yield from self._entity("CIRCLE", "AcDbCircle", layer)
            yield from self._circle(circle)
        for layer, start, end in self.sheet.lines:
            yield from self._line(layer, start, end)

    def _entity(self, kind: str, own: str, layer: str) -> Iterator[Tag]:
        yield from (
            (0, kind),
            (5, self._handle()),
            (330, self.model),
            (100, "AcDbEntity"),
            (8, _text(layer)),
            (100, own),
        )

    def _polyline(self, layer: str, outline: Outline) -> Iterator[Tag]:
        yield from self._entity("LWPOLYLINE", "AcDbPolyline", layer)
        yield from ((90, str(len(outline))), (70, "1"))
        for corner in outline:
            yield from _place(10, corner.x, corner.y)
            if corner.bulge:
                yield 42, repr(corner.bulge)

    def _circle(self, circle: Circle) -> Iterator[Tag]:
        yield from (*_place(10, circle.x, circle.y), (30, "0.0"))
        yield 40, _millimetres(self.sheet.digits.get(circle.radius, Decimal(repr(float(circle.radius)))))

    def _line(self, layer: str, start: Corner, end: Corner) -> Iterator[Tag]:
        if not start.bulge:
            yield from self._entity("LINE", "AcDbLine", layer)
            yield from (*_place(10, start.x, start.y), (30, "0.0"), *_place(11, end.x, end.y), (31, "0.0"))
            return
        circle = arc_centre(start[:2], end[:2], start.bulge)
        yield from self._entity("ARC", "AcDbCircle", layer)
        yield from self._circle(circle)
        yield 100, "AcDbArc"
        for code, corner in ((50, start), (51, end)):
            yield code, repr(math.degrees(math.atan2(corner.y - circle.y, corner.x - circle.x)) % 360.0)


RECORDS = {
    "VPORT": "Viewport", "LTYPE": "Linetype", "LAYER": "Layer", "STYLE": "TextStyle", "VIEW": "View", "UCS": "UCS",
    "APPID": "RegApp", "DIMSTYLE": "DimStyle", "BLOCK_RECORD": "Block",
}  # fmt: skip


def _place(code: int, x: float, y: float) -> tuple[Tag, Tag]:
    return (code, _millimetres(Decimal(repr(float(x))))), (code + 10, _millimetres(Decimal(repr(float(y)))))


def _millimetres(metres: Decimal) -> str:
    """A length with all its digits."""
    text = format(metres * 1000, "f")
    whole, _, rest = text.partition(".")
    return f"{whole}.{rest.rstrip('0') or '0'}"


def _text(text: str) -> str:
    """A name in letters of the code page; others by their numbers."""
    return "".join(c if ord(c) < 128 else f"\\U+{ord(c):04X}" for c in text)
