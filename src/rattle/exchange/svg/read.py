"""Read outlines of bodies from an SVG file: one plate, or the mechanism of a drawing whose layers are bodies.

A layer of Inkscape, or else the outermost group with a name, is a body; without groups the file is one body, which has
the name of the file.  What circles about one centre are says `rattle.exchange.outlines.mechanism`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

from rattle.exchange.imported import Assumptions, Imported
from rattle.exchange.outlines.edges import Circle, Corner
from rattle.exchange.outlines.mechanism import mechanism_of
from rattle.exchange.outlines.plan import Plan
from rattle.exchange.refusal import quoted, refused
from rattle.exchange.svg.elements import Attributes, Elements, is_hidden, label_of
from rattle.exchange.svg.lengths import PIXEL, UNITS, Matrix, length_of, numbers_of, transform_of
from rattle.exchange.svg.paths import Line, PathError, PathReader

FINE = 5e-5  # distance from a curve of the chords of the arcs that it becomes, as a share of the page
UNEQUAL = 1e-6  # share by which width and height may stretch the drawing differently: they have some six digits
PASSED = {"defs", "title", "desc", "metadata", "style", "script", "clipPath", "mask", "marker", "pattern", "symbol",
          "linearGradient", "radialGradient", "filter", "animate", "set", "view"}  # fmt: skip
GROUPS = {"svg", "g", "a"}


class Scope(NamedTuple):
    """What an element is in."""

    matrix: Matrix
    layer: str
    named: bool  # True: only a layer of Inkscape is another one within it


class Page(NamedTuple):
    """The size of the drawing."""

    metres: Decimal  # length of a unit of the drawing
    side: float  # the longer side, in units of the drawing; 0 if it is not known
    assumed: str = ""


def read_svg(text: str, name: str, assumptions: Assumptions) -> Imported:
    """The plate or mechanism of a drawing; name: of the file.

    Raises ModelError on what is no whole SVG, holds entities, or holds no closed outline.
    """
    reader = _Reader(name, assumptions)
    Elements(name, reader.begin, reader.end).read(text)
    plan = reader.plan
    if reader.flattened:
        plan.assumed.append(f"curves as arcs within {plan.length(reader.tolerance) * 1e3:.2g} mm")
    return mechanism_of(plan, assumptions, f"from the SVG drawing {Path(name).name}")


class _Reader:
    """Draws elements on the plan."""

    def __init__(self, name: str, stated: Assumptions) -> None:
        self.plan, self.stated = Plan(name), stated
        self.scopes: list[Scope] = []
        self.tolerance = FINE
        self.flattened = False
        self.line = 1
        self.shapes: Mapping[str, Callable[[Attributes, Scope], None]] = {
            "path": self._path, "rect": self._rectangle, "circle": self._ellipse, "ellipse": self._ellipse,
            "line": self._line, "polyline": self._polyline, "polygon": self._polyline,
        }  # fmt: skip

    # ------------------------------------------------------------ elements
    def begin(self, kind: str, attributes: Attributes, line: int) -> bool:
        """Draw an element; True if what is in it is to be read."""
        self.line = line
        if not self.scopes:
            if kind != "svg":
                raise refused(self.plan.name, f"not an SVG: it begins with {quoted(kind)}", line)
            self._open(attributes)
            return True
        if kind in PASSED or is_hidden(attributes):
            return False
        scope = self._within(kind, attributes)
        if kind in self.shapes:
            self.kind = kind
            self.shapes[kind](attributes, scope)
        elif kind == "svg" or kind not in GROUPS:
            self.plan.leave_out(f"element {kind}", scope.layer)
            return False
        self.scopes.append(scope)
        return True

    def end(self) -> None:
        """Leave an element."""
        self.scopes.pop()

    def _open(self, attributes: Attributes) -> None:
        page = _page(attributes, self.plan.name, self.line)
        self.plan.metres = page.metres
        if self.stated.scale is not None:
            self.plan.metres = Decimal(repr(self.stated.scale))
        elif page.assumed:
            self.plan.assumed.append(page.assumed)
        self.tolerance = FINE * (page.side or 1000.0)
        self.scopes.append(Scope(Matrix(d=-1.0), Path(self.plan.name).stem, False))

    def _within(self, kind: str, attributes: Attributes) -> Scope:
        """Where an element is, or what is in it."""
        outer = self.scopes[-1]
        matrix = transform_of(attributes.get("transform", ""))
        if matrix is None:
            raise refused(self.plan.name, f"unknown transform {quoted(attributes['transform'])}", self.line)
        label, is_layer = label_of(attributes) if kind in GROUPS else ("", False)
        takes = label != "" and (is_layer or not outer.named)
        layer = label if takes else outer.layer
        return Scope(outer.matrix.after(matrix), layer, outer.named or takes)

    # ------------------------------------------------------------ shapes
    def _number(self, attributes: Attributes, key: str, default: float = 0.0) -> float:
        """A length in units of the drawing."""
        text = attributes.get(key, "").strip()
        if not text or text == "auto":
            return default
        length = length_of(text)
        if length is None:
            raise refused(self.plan.name, f"{key} = {quoted(text)} is no length", self.line)
        number, unit = length
        return number * UNITS[unit] / PIXEL if unit else number

    def _add(self, line: Line, scope: Scope) -> None:
        if line.closed:
            self.plan.add_outline(scope.layer, tuple(line.corners))
            return
        for start, end in zip(line.corners, line.corners[1:], strict=False):
            self.plan.add_stroke(scope.layer, start, end, self.kind)

    def _path(self, attributes: Attributes, scope: Scope) -> None:
        reader = PathReader(scope.matrix, self.tolerance)
        try:
            lines = reader.read(attributes.get("d", ""))
        except PathError as error:
            raise refused(self.plan.name, f"a path: {error}", self.line) from None
        self.flattened = self.flattened or reader.flattened
        for line in lines:
            self._add(line, scope)

    def _line(self, attributes: Attributes, scope: Scope) -> None:
        ends = [scope.matrix.of(self._number(attributes, f"x{n}"), self._number(attributes, f"y{n}")) for n in (1, 2)]
        self._add(Line([Corner(*end) for end in ends], False), scope)

    def _polyline(self, attributes: Attributes, scope: Scope) -> None:
        numbers = numbers_of(attributes.get("points", ""))
        if numbers is None or len(numbers) % 2:
            raise refused(self.plan.name, f"points of a {self.kind} that are no pairs of numbers", self.line)
        path = [Corner(*scope.matrix.of(numbers[k], numbers[k + 1])) for k in range(0, len(numbers), 2)]
        closed = self.kind == "polygon" or (len(path) > 3 and path[0] == path[-1])
        if closed and len(path) > 1 and path[0] == path[-1]:
            path.pop()
        if len(path) > 1:
            self._add(Line(path, closed), scope)

    def _rectangle(self, attributes: Attributes, scope: Scope) -> None:
        x, y, w, h = (self._number(attributes, key) for key in ("x", "y", "width", "height"))
        if w <= 0.0 or h <= 0.0:
            return
        rx, ry = (self._number(attributes, key, -1.0) for key in ("rx", "ry"))
        rx, ry = (ry if rx < 0.0 else rx), (rx if ry < 0.0 else ry)
        rx, ry = min(max(rx, 0.0), w / 2), min(max(ry, 0.0), h / 2)
        arc = f"a{rx!r},{ry!r} 0 0 1" if rx and ry else ""
        rx, ry = (rx, ry) if arc else (0.0, 0.0)
        straight = (w - 2 * rx, 0.0), (0.0, h - 2 * ry), (2 * rx - w, 0.0), (0.0, 2 * ry - h)
        bent = (rx, ry), (-rx, ry), (-rx, -ry), (rx, -ry)
        data = f"M{x + rx!r},{y!r}"
        for (u, v), (p, q) in zip(straight, bent, strict=True):
            data += (f"l{u!r},{v!r}" if u or v else "") + (f"{arc} {p!r},{q!r}" if arc else "")
        self._path({"d": f"{data}z"}, scope)

    def _ellipse(self, attributes: Attributes, scope: Scope) -> None:
        x, y = self._number(attributes, "cx"), self._number(attributes, "cy")
        r = self._number(attributes, "r")
        rx, ry = self._number(attributes, "rx", r), self._number(attributes, "ry", r)
        if self.kind == "circle":
            rx = ry = r
        if rx <= 0.0 or ry <= 0.0:
            return
        matrix = scope.matrix.after(Matrix(rx, 0.0, 0.0, ry, x, y))
        if matrix.keeps_circles:
            radius = rx * scope.matrix.scale if rx == ry else matrix.scale
            self.plan.add_circle(scope.layer, Circle(*matrix.of(0.0, 0.0), radius))
            return
        halves = f"A{rx!r},{ry!r} 0 0 1"
        self._path({"d": f"M{x - rx!r},{y!r}{halves} {x + rx!r},{y!r}{halves} {x - rx!r},{y!r}z"}, scope)


def _page(attributes: Attributes, name: str, line: int) -> Page:
    """The size of the drawing from its width, height and the part of the plane that fills them.

    Raises ModelError for one that is stretched.
    """
    box = numbers_of(attributes.get("viewBox", ""))
    sides = [length_of(attributes.get(key, "")) for key in ("width", "height")]
    stated = [(number * UNITS[unit or "px"], unit) for number, unit in filter(None, sides) if number > 0.0]
    no_unit = "the drawing has no length in mm: 96 of its pixels are an inch"
    assumed = "" if any(unit not in ("", "px") for _, unit in stated) else no_unit
    if box is None or len(box) != 4 or not (box[2] > 0.0 and box[3] > 0.0):
        return Page(_decimal(PIXEL), max((length for length, _ in stated), default=0.0) / PIXEL, assumed)
    pairs = [(length, part) for length, part in zip(sides, box[2:], strict=True) if length and length[0] > 0.0]
    shares = [number * UNITS[unit or "px"] / part for (number, unit), part in pairs]
    return Page(_decimal(_scale(shares, attributes, name, line)), max(box[2:]), assumed)


def _scale(shares: Sequence[float], attributes: Attributes, name: str, line: int) -> float:
    """Length of a unit of the drawing [m], from what width and height say of it.  Raises ModelError if they differ."""
    fit = attributes.get("preserveAspectRatio", "")
    if fit.strip().startswith("none") and max(shares, default=1.0) > (1.0 + UNEQUAL) * min(shares, default=1.0):
        fault = "width and height stretch the drawing unequally (preserveAspectRatio none): circles are none"
        raise refused(name, f"{fault}; give both the proportions of its viewBox", line)
    return max(shares, default=PIXEL) if "slice" in fit else min(shares, default=PIXEL)


def _decimal(number: float) -> Decimal:
    """A length that decimals of a drawing have made, without the digits that rounding has put behind."""
    short = float(f"{number:.12g}")
    return Decimal(repr(short if math.isclose(short, number, rel_tol=1e-14) else number))
