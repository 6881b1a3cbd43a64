"""A mechanism as a drawing of its parts at the start: a layer for every body, the ground, and lines of guides.

Plates and cams have their own outline, wheels are circles, all other bodies the band around circles about their points.
A pin is two circles about the centre of its bush; their radii differ by its play.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from typing import TYPE_CHECKING, Any, NamedTuple

from rattle import registry
from rattle.description.model import Vector, is_ground
from rattle.equations.placement import pose
from rattle.exchange.outlines.bands import band
from rattle.exchange.outlines.edges import Circle, Corner, Outline
from rattle.exchange.outlines.mechanism import GROUND, SAME
from rattle.exchange.outlines.pins import pins_of
from rattle.results.columns import geometry

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

Spots = Mapping[str, Sequence[float]]
PIN = 0.006  # radius of a pin that the model does not state, as a share of the mechanism
LOOSEST = 3.0  # radius of a bush that the model does not state, in plays at least
WALL = 1.6  # half width of a bar, in radii of its largest circle
THIN = 0.012  # the same at least, as a share of the mechanism
BLOCK = 2.4  # length of a block that the model does not state, in widths
BEYOND = 0.6  # of a line of a guide to either side of its points, as a share of the mechanism
CORNER = 0.9  # cosine of the angle from which on a polyline has a corner, and is no curve there
DASH = math.radians(80.0)  # of a broken circle, four to a turn


class Drawn(NamedTuple):
    """A drawing; lengths in m."""

    outlines: list[tuple[str, Outline]]  # with their layers
    circles: list[tuple[str, Circle]]
    lines: list[tuple[str, Corner, Corner]]  # with a bulge: arcs, counter-clockwise
    layers: list[str]
    notes: list[str]  # what a reader of the drawing will not see
    digits: dict[float, Decimal]  # radii of pins, as the decimals of bush and play make them


def drawn(m: Mechanism) -> Drawn:
    """The parts of a mechanism, put together, before any run.  Raises ModelError, AssemblyError."""
    return _Draughtsman(m).drawn()


class _Draughtsman:
    """Draws."""

    def __init__(self, m: Mechanism) -> None:
        self.system, self.q = m.system, m.start.q
        self.form = geometry(self.system.model)
        self.size = self.system.extent or 1.0
        self.bodies = [name for name in self.form["bodies"] if not is_ground(name)]
        self.layers = {name: _layer_name(name, self.bodies) for name in self.bodies}
        self.aside = next(name for k in range(len(self.bodies) + 1) if (name := f"guides{k or ''}") not in self.bodies)
        self.sheet = Drawn([], [], [], [], [], {})

    def drawn(self) -> Drawn:
        """Everything."""
        sheet = self.sheet
        self._pins()
        for name in self.bodies:
            self._body(name)
        for name, joint in self.form["joints"].items():
            self._line_of(name, joint)
        sheet.layers.extend([*self.layers.values(), GROUND])
        if any(layer == self.aside for layer, *_ in (*sheet.outlines, *sheet.lines)):
            sheet.layers.append(self.aside)
        sheet.notes.extend(self._misread())
        sheet.notes.extend(self._not_drawn())
        return sheet

    # ------------------------------------------------------------ places
    def _layer(self, body: str) -> str:
        return GROUND if is_ground(body) else self.layers[body]

    def _at(self, body: str, spot: Sequence[float]) -> Vector:
        """A point of a body in the drawing."""
        x, y, angle = pose(self.system, self.q, body)
        c, s = math.cos(angle), math.sin(angle)
        return x + c * spot[0] - s * spot[1], y + s * spot[0] + c * spot[1]

    def _path(self, body: str, points: Sequence[Sequence[float]], about: Sequence[float] = (0.0, 0.0)) -> Outline:
        """An outline of corners in the frame of a body, about one of its points."""
        return tuple(Corner(*self._at(body, (about[0] + x, about[1] + y))) for x, y in points)

    # ------------------------------------------------------------ pins
    def _pins(self) -> None:
        for joint in self._of("pin"):
            bush, pin = self._radii(joint)
            centre = self._at(joint["bodies"][0], joint["points"][0])
            for body, radius in zip(joint["bodies"], (bush, pin), strict=True):
                ring = self._layer(body), Circle(*centre, radius)
                if ring not in self.sheet.circles:
                    self.sheet.circles.append(ring)

    def _of(self, form: str) -> Iterator[dict[str, Any]]:
        kinds = registry.kinds("joint")
        yield from (joint for joint in self.form["joints"].values() if kinds[joint["type"]].leaf.drawn_as == form)

    def _radii(self, joint: Mapping[str, Any]) -> tuple[float, float]:
        """Radius of the bush of a pin, and its own."""
        play = joint["clearance"] if joint["contact"] not in ("", "ideal") else 0.0
        bush = joint.get("bush_radius") or max(float(f"{PIN * self.size:.2g}"), LOOSEST * play)
        digits = Decimal(repr(float(bush))) - Decimal(repr(float(play)))
        pin = float(digits)
        self.sheet.digits[pin] = digits
        return float(bush), pin

    # ------------------------------------------------------------ bodies
    def _body(self, name: str) -> None:
        body, layer = self.form["bodies"][name], self.layers[name]
        rings = [self._path(name, ring) for ring in body.get("outline", ())] or self._cams(name)
        if not rings:
            rings = [self._block(name) or band([*self._around(name), *self._wheels(name)])]
        self.sheet.outlines.extend((layer, ring) for ring in rings)

    def _half(self, name: str) -> float:
        """Half the width of a bar."""
        own = [circle.radius for layer, circle in self.sheet.circles if layer == self.layers[name]]
        return max(WALL * max(own, default=0.0), THIN * self.size)

    def _around(self, name: str) -> list[Circle]:
        """Circles about the points of a body, or about its mass centre."""
        half, points = self._half(name), self.form["bodies"][name]["points"].values()
        own = [circle for layer, circle in self.sheet.circles if layer == self.layers[name]]
        spots = [self._at(name, spot) for spot in points] or [self._at(name, (0.0, 0.0))]
        return [Circle(*spot, half) for spot in (*spots, *(circle[:2] for circle in own))]

    def _wheels(self, name: str) -> list[Circle]:
        """Pitch circles of gears, rims of wheels, pinions and pulleys, rollers."""
        circles = []
        for joint in self.form["joints"].values():
            for radius, body, spot in _rims(joint):
                if body == name:
                    circles.append(Circle(*self._at(body, spot), radius))
        return circles

    def _cams(self, name: str) -> list[Outline]:
        """The outline of a cam or a locking disc; the first one, where a body has several."""
        for title, joint in self.form["joints"].items():
            for end, key in enumerate(("outline", "borne_outline")):
                points = joint.get(key, ())
                if joint["bodies"][end] != name or len(points) < 3:
                    continue
                if math.dist(points[0], points[-1]) > SAME * self.size:
                    continue
                path = self._path(name, points[:-1], joint["points"][end])
                self.sheet.notes.append(
                    f"{title}: a polyline of {len(path)} corners, within {_chordal(points):.2g} m of the curve"
                )
                return [path]
        return []

    def _block(self, name: str) -> Outline:
        """The rectangle of a body that slides in a guide and has one point; () for others."""
        points = self.form["bodies"][name]["points"]
        for joint in self._of("guide"):
            if joint["bodies"][1] != name or len(points) > 1:
                continue
            half = self._half(name)
            length, height = joint.get("block", (2.0 * BLOCK * half, 2.0 * half))[:2]
            length, height = max(length, 2.0 * half), max(height, 2.0 * half)
            turned = pose(self.system, self.q, joint["bodies"][0])[2] + joint["axis"]
            x, y = self._at(name, joint["points"][1])
            c, s = math.cos(turned), math.sin(turned)
            corners = [(i * length / 2, k * height / 2) for i, k in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            return tuple(Corner(x + c * u - s * v, y + s * u + c * v) for u, v in corners)
        return ()

    # ------------------------------------------------------------ what is beside bodies
    def _line_of(self, name: str, joint: Mapping[str, Any]) -> None:
        """The line of a guide, a slot, a rack, a rod; broken circles of wheels that stand."""
        a, b = (self._at(body, spot) for body, spot in zip(joint["bodies"], joint["points"], strict=True))
        kind = registry.kinds("joint")[joint["type"]].leaf.drawn_as
        if "axis" in joint or (kind in ("rack", "wheel", "surface") and "axis" in joint["fields"]):
            angle = pose(self.system, self.q, joint["bodies"][0])[2] + joint.get(
                "axis", joint["fields"].get("axis", 0.0)
            )
            along = math.cos(angle) * (b[0] - a[0]) + math.sin(angle) * (b[1] - a[1])
            half = joint["fields"].get("length", 0.0) / 2
            low, high = (
                (-half, half)
                if half
                else (min(0.0, along) - BEYOND * self.size / 2, max(0.0, along) + BEYOND * self.size / 2)
            )
            ends = [Corner(a[0] + x * math.cos(angle), a[1] + x * math.sin(angle)) for x in (low, high)]
            self.sheet.lines.append((self.aside, ends[0], ends[1]))
        elif kind == "rod" and math.dist(a, b) > 0.0:
            self.sheet.lines.append((self.aside, Corner(*a), Corner(*b)))
        for radius, body, spot in _rims(joint):
            if is_ground(body):
                self._broken_circle(Circle(*self._at(body, spot), radius))

    def _broken_circle(self, circle: Circle) -> None:
        for k in range(4):
            first = 0.5 * math.pi * k
            ends = [
                (circle.x + circle.radius * math.cos(angle), circle.y + circle.radius * math.sin(angle))
                for angle in (first, first + DASH)
            ]
            self.sheet.lines.append((self.aside, Corner(*ends[0], math.tan(DASH / 4)), Corner(*ends[1])))

    # ------------------------------------------------------------ what is not seen
    def _misread(self) -> Iterator[str]:
        """Pins with another play than a reader of the circles will find."""
        circles: dict[str, list[Circle]] = {}
        for layer, circle in self.sheet.circles:
            circles.setdefault(layer, []).append(circle)
        pins = pins_of(circles, {}, SAME * self.size, self.size).pins
        found = {(pin.bush.layer, pin.pin.layer, pin.bush.circle.radius, pin.pin.circle.radius) for pin in pins}
        for name, joint in self.form["joints"].items():
            if joint["clearance"] and joint in list(self._of("pin")):
                bush, pin = self._radii(joint)
                if bush > pin and (*map(self._layer, joint["bodies"]), bush, pin) not in found:
                    yield f"{name}: several pins about one centre; its play cannot be told from the circles"

    def _not_drawn(self) -> Iterator[str]:
        kinds = registry.kinds("joint")
        others = [name for name, joint in self.form["joints"].items() if kinds[joint["type"]].leaf.drawn_as != "pin"]
        if others:
            yield f"joints other than pins are lines at most: {', '.join(others[:8])}{' ...' * (len(others) > 8)}"
        if self.form["loads"] or self.form["drivers"]:
            yield "no loads and drivers: a drawing has none"


def _layer_name(body: str, bodies: Sequence[str]) -> str:
    """Layers are told apart without case: a body whose name another one has in other letters has its number behind."""
    alike = [name for name in bodies if name.lower() == body.lower()]
    return body if alike[0] == body and body.lower() != GROUND else f"{body}_{alike.index(body) + 1}"


def _rims(joint: Mapping[str, Any]) -> Iterator[tuple[float, str, Sequence[float]]]:
    """Radius, body and centre of the wheels of a joint."""
    fields, kind = joint["fields"], registry.kinds("joint")[joint["type"]].leaf.drawn_as
    if kind in ("gear", "belt"):
        radii = fields.get("radii", (0.0, 0.0))
    elif kind in ("rack", "wheel"):
        radii = (0.0, fields.get("radius", 0.0))
    elif kind in ("cam", "surface"):
        radii = (fields.get("radius", 0.0) if kind == "surface" else 0.0, fields.get("roller", 0.0))
    else:
        return
    for radius, body, spot in zip(radii, joint["bodies"], joint["points"], strict=True):
        if radius > 0.0:
            yield radius, body, spot


def _chordal(points: Sequence[Sequence[float]]) -> float:
    """How far a curve is from the chords between its points: a quarter of what half as many points would leave."""
    worst = 0.0
    for (ax, ay), (bx, by), (cx, cy) in zip(points[::2], points[1::2], points[2::2], strict=False):
        chord, sides = math.hypot(cx - ax, cy - ay), (math.hypot(bx - ax, by - ay), math.hypot(cx - bx, cy - by))
        along = (bx - ax) * (cx - bx) + (by - ay) * (cy - by)
        if along > CORNER * sides[0] * sides[1] > 0.0:
            worst = max(worst, abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / chord)
    return worst / 4.0
