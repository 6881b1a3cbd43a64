"""The mechanism that a drawing is: a layer is a body, circles of two layers about one centre are a pin."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rattle.errors import InputError, ModelError
from rattle.exchange.imported import Assumptions, Imported
from rattle.exchange.names import Names
from rattle.exchange.outlines.pins import Centres, Pin, pins_of
from rattle.exchange.outlines.plan import Plan
from rattle.exchange.outlines.shapes import Shape, Traced, shape_of, trace
from rattle.exchange.refusal import refused

SAME = 1e-6  # distance of places that are one, as a share of the drawing
DIGITS = 1e-12  # distance that rounding leaves, same share
THICKNESS, STEEL = 0.01, 7850.0  # of plates [m], [kg/m^3]
GROUND = "ground"
MOST_BODIES = 100
MOST_TESTS = 10_000_000  # see `Traced.tests`, of all layers together
MOST_NOTES = 40  # of one kind, by name
CONTACT = "impact"  # of pins with play: the model that needs no more than their play


def mechanism_of(plan: Plan, assumptions: Assumptions, source: str) -> Imported:
    """The tables of a model file of a drawing, and what was assumed and left out.

    Bodies have the frame of the drawing and start as drawn.  Raises ModelError if no layer is a body.
    """
    try:
        return _mechanism_of(plan, assumptions, source)
    except ModelError:
        raise
    except InputError as error:
        raise refused(plan.name, str(error)) from None


def _mechanism_of(plan: Plan, assumptions: Assumptions, source: str) -> Imported:
    """The same; raises InputError where a layer is no body, in words without the file."""
    size = plan.size
    tolerance = SAME * size
    traced = [trace(layer, tolerance) for layer in plan.layers.values()]
    bodies = [layer for layer in traced if _is_ground(layer.name) or layer.circles or layer.outlines]
    if len(bodies) > MOST_BODIES + 1:
        raise InputError(f"more than {MOST_BODIES} layers with closed outlines; draw one mechanism")
    if all(_is_ground(layer.name) for layer in bodies):
        raise InputError(
            "no layer is a body; draw every body on a layer of its own, as a closed outline or with the"
            " circles of its pins"
        )
    if sum(layer.tests for layer in bodies) > MOST_TESTS:
        raise InputError("too many outlines and circles; keep what bounds bodies, their pins and holes")
    rims = {layer.name: None if _is_ground(layer.name) else layer.rim for layer in bodies}
    centres = pins_of({layer.name: layer.circles for layer in bodies}, rims, tolerance, size)
    return _Writer(plan, assumptions, bodies, centres).imported(
        source, [note for layer in traced for note in layer.notes]
    )


def _is_ground(layer: str) -> bool:
    return layer.lower() == GROUND


class _Writer:
    """Writes the tables."""

    def __init__(self, plan: Plan, assumptions: Assumptions, bodies: Sequence[Traced], centres: Centres) -> None:
        self.plan, self.centres = plan, centres
        self.thickness, self.density = assumptions.thickness or THICKNESS, assumptions.density or STEEL
        self.stated = assumptions
        self.near = DIGITS * plan.length(plan.size)
        self.layers = {layer.name: layer for layer in bodies}
        self.known = Names()
        self.names = {
            layer.name: GROUND if _is_ground(layer.name) else self.known.new(layer.name, "body") for layer in bodies
        }
        self.letters = [self.known.new(letter, "joint") for letter in _letters(len(centres.at))]
        self.points: dict[str, dict[str, list[float]]] = {name: {} for name in self.names.values()}
        self.assumed: list[str] = []

    def imported(self, source: str, notes: Sequence[str]) -> Imported:
        """Everything."""
        joints = self._joints()
        self._holes()
        bodies = {self.names[name]: self._body(layer) for name, layer in self.layers.items() if not _is_ground(name)}
        document: dict[str, Any] = {"format": 1, "name": Path(self.plan.name).stem}
        if self.points.get(GROUND):
            document["ground"] = {"points": self.points[GROUND]}
        document["bodies"] = bodies
        if joints:
            document["joints"] = joints
        document["initial"] = {
            name: dict(zip(("x", "y", "angle"), (*body["center"], 0.0), strict=True)) for name, body in bodies.items()
        }
        left_out = [*_counted(notes), *self.centres.notes]
        if any(_is_ground(layer.name) and layer.outlines for layer in self.layers.values()):
            left_out.append("outlines of the ground, which has no mass")
        left_out += [what if n == 1 else f"{n} {what}" for what, n in self.plan.left_out.items()]
        return Imported(
            document,
            source,
            tuple(self._taken()),
            (*self.plan.assumed, *self._assumed(), *self.assumed),
            tuple(_shortened(left_out)),
        )

    # ------------------------------------------------------------ joints and points
    def _joints(self) -> dict[str, dict[str, Any]]:
        joints: dict[str, dict[str, Any]] = {}
        for pin in self.centres.pins:
            letter = self.letters[pin.place]
            for ring in (pin.bush, pin.pin):
                self._point(ring.layer, letter, self.centres.at[pin.place])
            ends = [f"{self.names[ring.layer]}.{letter}" for ring in (pin.bush, pin.pin)]
            joints[self.known.new(letter, "joint") if letter in joints else letter] = {
                "type": "revolute",
                "connect": ends,
                **self._play(pin),
            }
        return joints

    def _play(self, pin: Pin) -> dict[str, Any]:
        """Clearance and contact of a pin; nothing without play."""
        bush, radius = pin.bush.circle.radius, pin.pin.circle.radius
        play = self.plan.difference(bush, radius)
        if bush - radius <= SAME * 1e-3 * bush:
            return {}
        if not pin.fits:
            layers = f"{pin.bush.layer} and {pin.pin.layer}"
            self.assumed.append(
                f"circles of {layers} with radii {bush:g} and {radius:g} are no bush with its pin: no play"
            )
            return {}
        return {"clearance": play, "contact": {"model": CONTACT, "bush_radius": self.plan.length(bush)}}

    def _holes(self) -> None:
        """Circles alone are named points."""
        numbers: Counter[str] = Counter()
        for layer, circle in self.centres.alone:
            numbers[layer] += 1
            self._point(layer, f"H{numbers[layer]}", circle[:2])

    def _point(self, layer: str, name: str, spot: tuple[float, float]) -> None:
        self.points[self.names[layer]][name] = [self.plan.length(x) for x in spot]

    # ------------------------------------------------------------ bodies
    def _body(self, layer: Traced) -> dict[str, Any]:
        pins = [ring.circle for pin in self.centres.pins for ring in (pin.bush, pin.pin) if ring.layer == layer.name]
        shape = shape_of(layer, pins)
        self.assumed += shape.assumed
        unit = float(self.plan.metres)
        area, second = shape.figure.area * unit**2, shape.figure.second * unit**4
        if not (area > 0.0 and second > 0.0 and math.isfinite(second)):
            raise InputError(f"layer {layer.name}: its outline has no area, or one that is out of range")
        per_area = self.thickness * self.density
        points = self.points[self.names[layer.name]]
        numbers = {"mass": per_area * area, "center": self._centre(shape, points), "inertia": per_area * second}
        return {**self._rings(shape), **numbers, "points": points}

    def _centre(self, shape: Shape, points: Mapping[str, list[float]]) -> list[float]:
        """The mass centre; a point of the body where rounding alone keeps the two apart."""
        (centre,) = self._metres([shape.figure.centre])
        near = self.near
        return next((spot for spot in points.values() if math.dist(spot, centre) <= near), centre)

    def _rings(self, shape: Shape) -> dict[str, Any]:
        rings: dict[str, Any] = {"polygon": self._metres(shape.polygon)} if shape.polygon else {}
        return {**rings, "holes": list(map(self._metres, shape.holes))} if shape.holes else rings

    def _metres(self, ring: Sequence[tuple[float, float]]) -> list[list[float]]:
        return [[self.plan.length(x), self.plan.length(y)] for x, y in ring]

    # ------------------------------------------------------------ words
    def _taken(self) -> Iterator[str]:
        for layer, name in self.names.items():
            written = "" if name in (layer, GROUND) else f", here {name}"
            yield f"layer {layer}{written}"
        for pin in self.centres.pins:
            play = (
                f", play {self.plan.difference(pin.bush.circle.radius, pin.pin.circle.radius):g} m"
                if self._is_loose(pin)
                else ""
            )
            yield f"pin {self.letters[pin.place]} of {pin.bush.layer} and {pin.pin.layer}{play}"

    def _is_loose(self, pin: Pin) -> bool:
        return pin.fits and pin.bush.circle.radius - pin.pin.circle.radius > SAME * 1e-3 * pin.bush.circle.radius

    def _assumed(self) -> Iterator[str]:
        words = []
        if self.stated.thickness is None:
            words.append(f"plates {self.thickness * 1e3:g} mm thick")
        if self.stated.density is None:
            words.append(f"of steel, density {self.density:g} kg/m^3")
        if words:
            yield " ".join(words)
        if any(map(self._is_loose, self.centres.pins)):
            yield f"contact of pins with play: {CONTACT}, with its usual restitution and no friction"
        yield "no gravity and no driver"


# ---------------------------------------------------------------- names
def _letters(number: int) -> Iterator[str]:
    """Names of centres: A, B, ... Z, A1, ..."""
    for k in range(number):
        turn, letter = divmod(k, 26)
        yield f"{chr(65 + letter)}{turn or ''}"


def _counted(notes: Sequence[str]) -> list[str]:
    return [what if n == 1 else f"{n} {what}" for what, n in Counter(notes).items()]


def _shortened(notes: Sequence[str]) -> list[str]:
    more = len(notes) - MOST_NOTES
    return [*notes[:MOST_NOTES], *([f"and {more} more"] if more > 0 else [])]
