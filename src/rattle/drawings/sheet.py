"""What a drawing is written on: primitives in frames that move, and what of them a picture has to hold.

A list of primitives (`Sheet.written`) is plain data, see docs/scene.md.  Places are numbers of a tape (`numbers.py`) in
metres; widths of lines and radii of dots are pixels of a page, three quarters of a point on paper.  Colours are names:
black, grey, metal, steel, paper, red, green, pink, sky, or `body NAME`, mixed with a share of paper.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import filterfalse
from typing import Any, NamedTuple

from rattle.description.model import is_ground
from rattle.drawings.numbers import Number, Tape, Value, call, cos, sin

Piece = tuple[Value, Value] | dict[str, Any] | None  # of a path: a point, see `Sheet.arc` and the like, or a gap
TURN = 2.0 * math.pi
FOOT = 0.05, 9.0, 26.0  # size of a foot: share of the mechanism's size, least and most [pixels]
HATCH = 8.0  # length of a hatch of a wall [pixels]
BAR = 0.026, 5.0, 15.0  # width of a bar: the same


class Spot(NamedTuple):
    """A point in the world, now [m]."""

    x: Number
    y: Number


class Frame(NamedTuple):
    """Axes that move: origin [m], angle [rad], and by how much lengths along x are larger."""

    at: Spot
    angle: Value
    stretch: Value = 1.0


class Colour(NamedTuple):
    """A colour by name; paper: the share of paper in it."""

    name: str
    paper: float = 0.0


class Part:
    """A joint or load that is drawn.  `form` is its entry in the geometry: what is decided while drawing."""

    def __init__(self, sheet: Sheet, name: str, family: str, form: Mapping[str, Any], driven: bool) -> None:
        self.sheet, self.name, self.family, self.form, self.driven = sheet, name, family, form, driven
        self.bodies: tuple[str, str] = (form["bodies"][0], form["bodies"][1])
        self.fields: Mapping[str, Any] = form.get("fields", {})

    def number(self, *place: str | int) -> Number:
        """A number of its entry in the geometry."""
        return self.sheet.tape.node("of", self.family + "s", self.name, *place)

    def point(self, end: int) -> tuple[Number, Number]:
        """Its point on A (end 0) or B in the frame of that body."""
        return self.number("points", end, 0), self.number("points", end, 1)

    def at(self, end: int) -> Spot:
        """Its point on A (end 0) or B in the world."""
        return self.sheet.at(self.bodies[end], self.point(end))

    @property
    def stops(self) -> list[tuple[int, Number]]:
        """Its stops: 0 for the least coordinate and 1 for the largest, and where it is."""
        ends = enumerate(self.form.get("stop", ()))
        return [(k, self.number("stop", k)) for k, end in ends if end is not None]


class Sheet:
    """The primitives of a mechanism."""

    def __init__(self, geometry: Mapping[str, Any]) -> None:
        self.geometry = geometry
        self.tape = Tape()
        self.size = self.tape.node("size")
        self.pixel = self.tape.node("pixel")
        self.side = self.tape.node("side")
        self.drawn: list[dict[str, Any]] = []
        self.within: list[dict[str, Any]] = []  # what a picture has to hold
        self.forces: dict[str, Spot] = {}  # where the forces of joints act
        self.held: dict[str, list[Piece]] = {}  # points up to which bodies are drawn
        self.instead: dict[str, Number] = {}  # positive where a body is drawn by a joint
        self.shared: dict[str, Any] = {}  # what drawings of one form find once for all
        self.layers: dict[str, Any] = {}  # what is drawn over it, by name

    # ------------------------------------------------------------ numbers
    def number(self, value: Value) -> Number:
        """A value as a number of the tape."""
        return Number(self.tape, self.tape.of(value))

    def spot(self, x: Value, y: Value) -> Spot:
        """A place in the world [m]."""
        return Spot(self.number(x), self.number(y))

    def at(self, body: str, point: tuple[Value, Value]) -> Spot:
        """Where a point of a body is in the world."""
        return Spot(*(self.tape.node(name, body, *point) for name in ("x", "y")))

    def angle(self, body: str) -> Number:
        """The angle of a body."""
        return self.tape.node("angle", body)

    def curve(self, name: str) -> Number:
        """A curve of the result now, 0 where there is none."""
        return self.tape.node("curve", name)

    def first(self, value: Number) -> Number:
        """A number at the first instant."""
        return self.tape.node("first", value)

    def range(self, value: Number) -> tuple[Number, Number]:
        """The least and the largest of a number over all instants."""
        return self.tape.node("least", value), self.tape.node("most", value)

    def usual(self, share: float, *values: Number) -> Number:
        """The size that this share of what several numbers are at all instants does not exceed."""
        return self.tape.node("usual", share, *values)

    def points(self, body: str) -> list[tuple[Number, Number]]:
        """The named points of a body in its frame."""
        names = self.geometry["bodies"].get(body, {}).get("points", ())
        return [self._pair("bodies", body, "points", name) for name in names]

    def rings(self, body: str) -> int:
        """How many outlines a body has: its own and those of its holes."""
        return len(self.geometry["bodies"].get(body, {}).get("outline", ()))

    def _pair(self, *place: str | int) -> tuple[Number, Number]:
        return self.tape.node("of", *place, 0), self.tape.node("of", *place, 1)

    # ------------------------------------------------------------ pieces of paths
    def arc(
        self, centre: tuple[Value, Value], radius: Value, start: Value = 0.0, end: Value = TURN, *,
        last: Value | None = None, count: int = 49,
    ) -> Piece:  # fmt: skip
        """An arc of `count` points from one angle to another; last: its radius at the end, of a spiral."""
        values = (*centre, radius, radius if last is None else last, start, end)
        return {"arc": [self.tape.of(value) for value in values], "count": count}

    def given(self, *place: str | int, every: int = 1) -> Piece:
        """Points that stand in the geometry; every: so many of them."""
        return {"of": list(place), "every": every}

    def trail(self, joint: str, share: float, scale: Value) -> Piece:
        """Where a pin was in its bush, for such a share of the motion up to now, so many times as large."""
        return {"trail": joint, "share": share, "scale": self.tape.of(scale)}

    def around(self, path: Piece, half: Value) -> Piece:
        """What lies so far from a path to either side, with round ends."""
        return {"around": self._written([path]), "half": self.tape.of(half)}

    def repeated(self, count: Value, path: Sequence[Piece], *, shift: Value = 0.0, turn: Value = 0.0) -> Piece:
        """Copies of a path, each so far along x from the one before, or turned so far about the origin."""
        counted, shifted, turned = (self.tape.of(value) for value in (count, shift, turn))
        return {"copies": counted, "shift": shifted, "turn": turned, "path": self._written(path)}

    def _written(self, path: Sequence[Piece]) -> list[Any]:
        return [[self.tape.of(x) for x in piece] if isinstance(piece, tuple) else piece for piece in path]

    # ------------------------------------------------------------ primitives
    def path(
        self, frame: Frame | str, *rings: Sequence[Piece], z: float, line: Colour | str | None = "black",
        width: float = 1.2, fill: Colour | str | None = None, opacity: float = 1.0, closed: bool = False,
        butt: bool = False, dash: Sequence[float] = (), when: Value | None = None,
    ) -> None:  # fmt: skip
        """Paths with a line of so many pixels along them and perhaps filled; the further ones are holes.

        dash: lengths of strokes and gaps [pixels] of a broken line.
        """
        style = {"line": _colour(line), "width": width, "fill": _colour(fill), "opacity": opacity}
        broken = {"dash": list(dash)} if dash else {}
        self._add("path", frame, z, when, rings=[self._written(ring) for ring in rings], **style, closed=closed,
                  butt=butt, **broken)  # fmt: skip

    def dot(
        self, frame: Frame | str, point: tuple[Value, Value], radius: float, *, z: float = 5.0, width: float = 1.4,
        line: Colour | str = "black", fill: Colour | str = "paper", square: bool = False, when: Value | None = None,
    ) -> None:  # fmt: skip
        """A mark of so many pixels; square: with four corners, and no line."""
        style = {"line": _colour(line), "width": width, "fill": _colour(fill)}
        self._add("dot", frame, z, when, path=self._written([point]), radius=radius, square=square, **style)

    def wall(
        self, frame: Frame | str, start: tuple[Value, Value], end: tuple[Value, Value], *, z: float = 1.0,
        stroke: Number | None = None, line: Colour | str = "black", width: float = 1.4, when: Value | None = None,
    ) -> None:  # fmt: skip
        """A line of the ground, hatched on its right hand; stroke: length of a hatch, by default 8 pixels."""
        style = {"line": _colour(line), "width": width}
        self._add(
            "wall",
            frame,
            z,
            when,
            path=self._written([start, end]),
            stroke=self.tape.of(HATCH * self.pixel if stroke is None else stroke),
            **style,
        )

    def text(
        self, frame: Frame | str, point: tuple[Value, Value], text: str, *, z: float = 6.5,
        line: Colour | str = "black", bold: bool = False, when: Value | None = None,
    ) -> None:  # fmt: skip
        """A name beside a point, on a little paper."""
        self._add("text", frame, z, when, path=self._written([point]), text=text, line=_colour(line), bold=bold)

    def foot(self, ground: str, point: tuple[Value, Value]) -> None:
        """The usual symbol of a fixed pivot on the ground, or on a point of it that moves."""
        x, y = point
        s = self._clamped(FOOT)
        corners: list[Piece] = [(x, y), (x - 0.62 * s, y - s), (x + 0.62 * s, y - s)]
        self.path(ground, corners, z=2.1, fill=Colour("steel", 0.3), width=1.3, closed=True)
        self.wall(ground, (x - s, y - s), (x + s, y - s), z=2.1, stroke=0.34 * s, width=1.3)

    def _clamped(self, size: tuple[float, float, float]) -> Number:
        """A share of the mechanism's size that is neither too small nor too large on its picture [m]."""
        share, least, most = size
        return call("min", call("max", share * self.size, least * self.pixel), most * self.pixel)

    def feet(self, part: Part) -> None:
        """Feet of those ends of a part that are on the ground."""
        for end, body in enumerate(part.bodies):
            if is_ground(body):
                self.foot(body, part.point(end))

    def bodies(self) -> None:
        """Bars through two points, plates through more with round corners; outlines as they are, with their holes."""
        half = 0.5 * self._clamped(BAR)
        for body in filterfalse(is_ground, self.geometry["bodies"]):
            line, fill = f"body {body}", Colour(f"body {body}", 0.6)
            rings: list[list[Piece]] = [[self.given("bodies", body, "outline", k)] for k in range(self.rings(body))]
            points: list[Piece] = [*self.points(body), (0.0, 0.0)]
            self.hold(body, *points, *(piece for ring in rings for piece in ring))
            corners = [*points[:-1], *self.held.get(body, ())]
            if len(corners) < 2:
                corners = points
            is_bar = not rings and len(corners) == 2
            grown = {"grown": self._written(corners), "half": self.tape.of(half)}
            when = 1.0 - self.instead[body] if body in self.instead else None
            self.path(body, *(rings or [[grown]]), z=3.0 if is_bar else 2.9, line=line, width=1.6, fill=fill,
                      opacity=1.0 if is_bar else 0.77, closed=True, when=when)  # fmt: skip
            self.drawn[-1]["body"] = body

    def _add(self, kind: str, frame: Frame | str, z: float, when: Value | None, **more: Any) -> None:
        condition = {} if when is None else {"when": self.tape.of(when)}
        self.drawn.append({"draw": kind, "frame": self._frame(frame), "z": z, **more, **condition})

    def _frame(self, frame: Frame | str) -> str | list[int]:
        if isinstance(frame, str):
            return frame
        return [self.tape.of(value) for value in (*frame.at, frame.angle, frame.stretch)]

    # ------------------------------------------------------------ what else is asked of a drawing
    def hold(self, frame: Frame | str, *path: Piece) -> None:
        """A picture of the mechanism has to hold this path."""
        self.within.append({"frame": self._frame(frame), "path": self._written(path)})

    def reach_up_to(self, body: str, *points: tuple[Value, Value]) -> None:
        """A body is drawn up to these points of its frame."""
        self.held.setdefault(body, []).extend(points)

    def draws(self, body: str, when: Number) -> None:
        """Where `when` is positive a joint draws this body itself."""
        self.instead[body] = call("max", self.instead.get(body, 0.0), when)

    def force_at(self, part: Part, spot: Spot) -> None:
        """Where the force of a joint acts; without it at its point on A."""
        self.forces[part.name] = spot

    def apart(self, draw: Callable[..., None], *which: Any) -> list[dict[str, Any]]:
        """What a function draws, for a layer of its own; which: what it is called with."""
        own, self.drawn = self.drawn, []
        draw(*which)
        own, self.drawn = self.drawn, own
        return in_order(own)

    def written(self) -> dict[str, Any]:
        """The list as plain data."""
        drawn = in_order(self.drawn)
        return {"numbers": self.tape.nodes, "drawn": drawn, "within": self.within, **self.layers}


def in_order(drawn: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Primitives from the back to the front."""
    return sorted(drawn, key=lambda primitive: float(primitive["z"]))


def box(low: Value, high: Value, half: Value) -> list[Piece]:
    """Corners of a box from low to high along x."""
    lower = 0.0 - half
    return [(low, lower), (high, lower), (high, half), (low, half)]


def polar(radius: Value, angle: Value) -> tuple[Value, Value]:
    """A point at a distance and an angle from the origin."""
    return radius * cos(angle), radius * sin(angle)


def between(a: Spot, b: Spot) -> tuple[Number, Number]:
    """The distance of two points, and the angle from the first to the second."""
    dx, dy = b.x - a.x, b.y - a.y
    return call("max", call("hypot", dx, dy), 1e-12), call("atan2", dy, dx)


def _colour(colour: Colour | str | None) -> list[Any] | None:
    return None if colour is None else [*(Colour(colour) if isinstance(colour, str) else colour)]
