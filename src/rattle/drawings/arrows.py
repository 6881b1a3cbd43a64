"""Arrows, and those of the forces and moments in a motion: of joints on their second body, of loads, of drivers.

The arrow of a usual force has a length that can be seen, whatever the size of the picture; one that would be much
longer is cut and has two heads.  A moment is an arc, whose length is its share of the usual moment.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from rattle.drawings.numbers import Number, Value, call, cos, least_of, most_of, sin
from rattle.drawings.sheet import Frame, Part, Sheet, Spot, polar

HEAD, HALF = 11.0, 0.42  # length of a head at most [pixels], half its width as a share of the length
LEAST = 2.0  # length of the shortest arrow that is drawn [pixels]
ACROSS = 0.75  # length of the head of an arc at most, in its radius
LONG = 0.17  # of the arrow of a usual force, as a share of the shorter side of the picture
MOST = 1.7  # times that length at which an arrow is cut
USUAL = 0.96  # share of all instants whose forces are no larger than the usual one
RADIUS = 22.0  # of the arc of a moment [pixels]
FEWEST, WIDEST = 0.5, 1.5 * math.pi  # angle of an arc that is drawn, and of the longest [rad]
SPOT, SMALL = (12.0, -2.0), 9.0  # middle and radius of the arc of the scale [pixels]
STEP = 0.45  # least share of the usual force that the scale shows
UP = 0.5 * math.pi
# what the scales of arrows are of
OF_JOINTS, OF_LOADS, OF_TURNS = "joint, on its second body", "spring, bushing, actuator", "driver, load"


class Style(NamedTuple):
    """How an arrow looks."""

    line: str
    width: float = 2.4  # [pixels]
    z: float = 6.0
    dash: Sequence[float] = ()
    both: bool = False  # with a head at each end


class Way(NamedTuple):
    """An arrow as far as it goes [m]."""

    x: Value
    y: Value
    cut: Number | None = None  # positive where it would be longer


def straight(sheet: Sheet, start: Spot, way: Way, style: Style, when: Value | None = None) -> None:
    """An arrow; where it is cut it has two heads."""
    x, y = sheet.number(way.x), sheet.number(way.y)
    length, angle = call("hypot", x, y), call("atan2", y, x)
    frame, head = Frame(start, angle), least_of(HEAD * sheet.pixel, 0.55 * length + 2.0 * sheet.pixel)
    seen = length > LEAST * sheet.pixel
    if when is not None:
        seen = seen * when
    from_x: Value = 0.7 * head if style.both else 0.0
    more: dict[str, Any] = {"z": style.z, "line": style.line, "width": style.width, "butt": True, "dash": style.dash}
    sheet.path(frame, [(from_x, 0.0), (length - 0.7 * head, 0.0)], when=seen, **more)
    _head(sheet, frame, (length, 0.0), (length - head, HALF * head), style, seen)
    if style.both:
        _head(sheet, frame, (0.0, 0.0), (head, HALF * head), style, seen)
    if way.cut is not None:
        back = length - 0.75 * head
        _head(sheet, frame, (back, 0.0), (back - head, HALF * head), style, seen * way.cut)


def _head(
    sheet: Sheet, frame: Frame, tip: tuple[Value, Value], corner: tuple[Value, Value], style: Style, when: Value
) -> None:
    """A head along x of a frame; corner: one of its two others."""
    x, y = corner
    sheet.path(frame, [tip, corner, (x, 0.0 - y)], z=style.z, line=None, fill=style.line, when=when)


def turning(
    sheet: Sheet, centre: Spot, radius: Value, angles: tuple[Value, Value], style: Style, when: Value | None = None
) -> None:
    """An arc with a head at its end, and perhaps at its start; angles: where it starts, and how far it turns [rad]."""
    frame, (start, sweep) = Frame(centre, 0.0), angles
    wide, sense = sheet.number(radius), call("if", sheet.number(sweep), 1.0, -1.0)
    head = least_of(HEAD * sheet.pixel, ACROSS * wide)
    turn, end = sense * head / wide, start + sweep
    ends = (start + 0.6 * turn if style.both else start, end - 0.6 * turn)
    arc = sheet.arc((0.0, 0.0), wide, *ends, count=33)
    more: dict[str, Any] = {"z": style.z, "line": style.line, "width": style.width, "butt": True, "dash": style.dash}
    sheet.path(frame, [arc], when=when, **more)
    for tip, back in ((end, end - turn), (start, start + turn)) if style.both else ((end, end - turn),):
        corners = [polar(wide + side * head, back) for side in (HALF, -HALF)]
        sheet.path(frame, [polar(wide, tip), *corners], z=style.z, line=None, fill=style.line, when=when)


def stretched(sheet: Sheet, x: Value, y: Value, usual: Number, longest: tuple[Value, float]) -> Way:
    """A force as an arrow; longest: the length of a usual one, and how many times that an arrow has at most."""
    long, most = longest
    size = call("hypot", sheet.number(x), sheet.number(y))
    share = call("if", usual, least_of(long / usual, most * long / size), 0.0)
    return Way(x * share, y * share, size > most * usual)


# ---------------------------------------------------------------- of a motion
class _Force(NamedTuple):
    """A force that acts at a place."""

    at: Spot
    x: Number
    y: Number
    when: Number | None = None


def draw_forces(sheet: Sheet, parts: Sequence[Part], drivers: Mapping[str, str]) -> list[dict[str, Any]]:
    """Write all arrows; returns their scales.  parts: joints and loads; drivers: the joint of each by its name."""
    joints = [part for part in parts if part.family == "joint"]
    loads = [part for part in parts if part.family == "load"]
    driven = [(name, part) for name, joint in drivers.items() for part in joints if part.name == joint]
    return _straight_ones(sheet, joints, loads, driven) + _turning_ones(sheet, loads, driven)


def _straight_ones(
    sheet: Sheet, joints: Sequence[Part], loads: Sequence[Part], driven: Sequence[tuple[str, Part]]
) -> list[dict[str, Any]]:
    """Write the forces, those of joints apart from all others; returns their scales."""
    own = [(f, "black") for part in joints for f in _of_joint(sheet, part, pulls=False)]
    own += [(f, "red") for part in joints for f in _of_joint(sheet, part, pulls=True)]
    other = [f for part in loads if part.form.get("coordinate") == "length" for f in _of_load(sheet, part)]
    other += [
        _Force(part.at(1), sheet.curve(f"{part.name}.fx"), sheet.curve(f"{part.name}.fy"))
        for part in loads
        if {"fx", "fy"}.issubset(part.form.get("quantities", ()))
    ]
    other += [_along(sheet, part, name) for name, part in driven if "axis" in part.form]
    sizes = [_sizes(f for f, _ in own), _sizes(other)]
    usual = sheet.usual(USUAL, *sizes[0], *sizes[1])
    for force, colour in [*own, *((f, "green") for f in other)]:
        way = stretched(sheet, force.x, force.y, usual, (LONG * sheet.side, MOST))
        straight(sheet, force.at, way, Style(colour), force.when)
    titles = ((OF_JOINTS, "black"), (OF_LOADS, "green"))
    return [_scale(sheet, usual, some, *words) for some, words in zip(sizes, titles, strict=True) if some]


def _turning_ones(sheet: Sheet, loads: Sequence[Part], driven: Sequence[tuple[str, Part]]) -> list[dict[str, Any]]:
    """Write the moments; returns their scale, if there are any."""
    turns = [
        (part, part.number("fields", "torque"))
        for part in loads
        if part.form.get("coordinate") != "length" and part.fields.get("torque")
    ]
    turns += [(part, sheet.curve(f"{name}.torque")) for name, part in driven]
    turn = sheet.usual(USUAL, *(moment for _, moment in turns))
    for part, moment in turns:
        _moment(sheet, part.at(1), call("if", turn, moment / turn, 0.0), RADIUS * sheet.pixel)
    return [_scale_of_moments(sheet, turn, [moment for _, moment in turns])] if turns else []


def _sizes(forces: Iterable[_Force]) -> list[Number]:
    """Sizes of forces; one that is drawn in two ways has one."""
    every = (call("hypot", force.x, force.y) for force in forces)
    return [*{size.place: size for size in every}.values()]


def _of_joint(sheet: Sheet, part: Part, *, pulls: bool) -> list[_Force]:
    """The force of a joint; pulls: where a massless link pulls, so that a pin would leave its bush."""
    link = part.form.get("contact") == "massless-link"
    if pulls and not link:
        return []
    pulling = sheet.curve(f"{part.name}.normal") < 0.0 if link else None
    when = None if pulling is None else pulling if pulls else 1.0 - pulling
    at = sheet.forces.get(part.name) or part.at(0)
    return [_Force(at, sheet.curve(f"{part.name}.fx"), sheet.curve(f"{part.name}.fy"), when)]


def _of_load(sheet: Sheet, part: Part) -> list[_Force]:
    """The force of a load that acts along the line between its points, on both of them."""
    a, b = part.at(0), part.at(1)
    angle = call("atan2", b.y - a.y, b.x - a.x)
    size = float(part.form.get("power", 1.0)) * sheet.curve(f"{part.name}.force")
    x, y = size * cos(angle), size * sin(angle)
    return [_Force(b, x, y), _Force(a, -x, -y)]


def _along(sheet: Sheet, joint: Part, driver: str) -> _Force:
    """The force of a driver along the line of its joint."""
    angle, size = sheet.angle(joint.bodies[0]) + joint.number("axis"), sheet.curve(f"{driver}.force")
    return _Force(joint.at(1), size * cos(angle), size * sin(angle))


def _moment(sheet: Sheet, at: Spot, share: Number, radius: Value) -> None:
    sweep = most_of(least_of(math.pi * share, WIDEST), -WIDEST)
    turning(sheet, at, radius, (UP, sweep), Style("pink", 2.6), abs(sweep) > FEWEST)


def _scale(sheet: Sheet, usual: Number, sizes: Sequence[Number], text: str, colour: str) -> dict[str, Any]:
    """The arrow of a round force, and what is said of it; in a picture whose pixel is 1."""
    step = call("nice", STEP * usual)
    long = LONG * sheet.side * step / usual
    drawn = sheet.apart(lambda: straight(sheet, sheet.spot(0.0, 0.0), Way(long, 0.0), Style(colour)))
    return _told(sheet, sizes, step, long) | {"text": text, "unit": "N", "line": [colour, 0.0], "drawn": drawn}


def _scale_of_moments(sheet: Sheet, usual: Number, moments: Sequence[Number]) -> dict[str, Any]:
    step = call("nice", STEP * usual)
    drawn = sheet.apart(lambda: _moment(sheet, sheet.spot(*SPOT), step / usual, SMALL))
    words = {"text": OF_TURNS, "unit": "N*m", "line": ["pink", 0.0], "drawn": drawn}
    return _told(sheet, moments, step, sheet.number(2.0 * SPOT[0])) | words


def _told(sheet: Sheet, sizes: Sequence[Number], step: Number, width: Number) -> dict[str, Any]:
    """Places of the force or moment that a scale shows, of its width, and of what is positive where it is needed."""
    return {"step": step.place, "wide": width.place, "when": sheet.usual(1.0, *sizes).place}
