"""Gears and racks to scale.  A model knows pitch circles, not teeth: their number is that of the picture.

It is chosen so that teeth mesh; where no number does, marks on the pitch circles stand for them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from rattle.drawings.forms import drawing, form_of
from rattle.drawings.numbers import Number, Value, call, cos, least_of, sin
from rattle.drawings.sheet import Colour, Frame, Part, Sheet, Spot, polar

DEPTH = 0.3  # height of a tooth on either side of the pitch circle, as a share of the pitch
ROOT = 1.15 * DEPTH  # depth of the gaps, same share
RIM = 3.0  # height of the rim of a ring, in heights of teeth
FEWEST, MOST = 18, 36  # teeth on the smallest wheel
MARKS = 16  # on the smallest wheel where teeth do not mesh
MANY = 1000  # teeth or marks on a wheel: more would lie closer than lines are wide
BEYOND = 1.5  # of a rack beyond the ways of its pinion, in radii
LONGEST = 400  # teeth of a rack
CLOSE = 0.01  # of a tooth, within which a number of teeth is whole
TURN = 2.0 * math.pi


class Wheel(NamedTuple):
    """A wheel of a gear pair, or the pinion of a rack; equal ones are drawn once."""

    body: str
    centre: tuple[float, float]  # in the frame of its body, as written [m]
    radius: float
    ring: bool


@dataclass
class Meshed:
    """A wheel as it is drawn."""

    at: Spot
    body: str
    ring: bool
    radius: Number
    centre: tuple[Number, Number]
    phase: Value | None = None  # angle of a tooth in the frame of its body


class Teeth(NamedTuple):
    """What all wheels and racks of a mechanism share."""

    pitch: Number  # of the teeth [m]
    whole: Number  # 1 where whole numbers of them fit all wheels
    wheels: dict[Wheel, Meshed]
    owners: dict[Wheel, str]  # the joint that draws each


def wheels_of(part: Part) -> list[tuple[int, Wheel, Number]]:
    """The wheels of a gear pair, or the pinion of a rack: end of the joint, wheel, radius."""
    radii = part.fields["radii"] if "radii" in part.fields else (0.0, part.fields.get("radius", 0.0))
    return [
        (
            end,
            Wheel(body, (point[0], point[1]), radius, not end and bool(part.fields.get("internal"))),
            part.number("fields", "radii", end) if "radii" in part.fields else part.number("fields", "radius"),
        )
        for end, (body, point, radius) in enumerate(zip(part.bodies, part.form["points"], radii, strict=True))
        if radius > 0.0
    ]


def _teeth(sheet: Sheet) -> Teeth:
    """Pitch and phase of all wheels, so that teeth of one lie in the gaps of the other at the start."""
    if "teeth" not in sheet.shared:
        every = [
            Part(sheet, name, "joint", form, False)
            for name, form in sheet.geometry["joints"].items()
            if form_of("joint", form["type"]) in ("gear", "rack")
        ]
        sheet.shared["teeth"] = _meshing(sheet, every)
    teeth: Teeth = sheet.shared["teeth"]
    return teeth


def _meshing(sheet: Sheet, toothed: Sequence[Part]) -> Teeth:
    wheels: dict[Wheel, Meshed] = {}
    owners: dict[Wheel, str] = {}
    for part in toothed:
        for end, wheel, radius in wheels_of(part):
            if wheel not in wheels:
                wheels[wheel] = Meshed(part.at(end), wheel.body, wheel.ring, radius, part.point(end))
                owners[wheel] = part.name
    written = [wheel.radius for wheel in wheels]
    count = next((n for n in range(FEWEST, MOST + 1) if _fits(written, n)), 0)
    least = least_of(*(wheel.radius for wheel in wheels.values()))
    pitch = TURN / (count or MARKS) * least
    whole = _all_whole([wheel.radius / least * float(count) for wheel in wheels.values()]) if count else 0.0 * least
    for part in toothed:
        _turn(sheet, [wheels[wheel] for _, wheel, _ in wheels_of(part)], pitch)
    return Teeth(pitch, whole, wheels, owners)


def _turn(sheet: Sheet, meshed: Sequence[Meshed], pitch: Number) -> None:
    """Give the wheels of one joint, two of a pair or a pinion, the phases that they do not have yet."""
    settled = sorted(meshed, key=lambda wheel: wheel.phase is None)  # a wheel that others have turned comes first
    for n, wheel in enumerate(settled):
        if wheel.phase is None:
            wheel.phase = _meshed(sheet, settled[0], wheel, pitch) if n else 0.0


def _fits(radii: Sequence[float], count: int) -> bool:
    teeth = [radius / min(radii) * count for radius in radii]
    return max(teeth) <= MANY and all(abs(number - round(number)) < CLOSE for number in teeth)


def _all_whole(teeth: Sequence[Number]) -> Number:
    """1 where all of these are whole numbers."""
    whole: Number = abs(teeth[0] - call("round", teeth[0])) < CLOSE
    for number in teeth[1:]:
        whole = whole * (abs(number - call("round", number)) < CLOSE)
    return whole


def _meshed(sheet: Sheet, first: Meshed, second: Meshed, pitch: Number) -> Number:
    """The angle of a tooth of the second wheel that lies in a gap of the first."""
    inside = first.ring or second.ring
    way = call("atan2", second.at.y - first.at.y, second.at.x - first.at.x)  # to where they touch
    if second.ring:
        way = way + math.pi
    share = (way - sheet.angle(first.body) - (first.phase or 0.0)) * first.radius / pitch  # teeth up to there
    there = way + (0.0 if inside else math.pi) - sheet.angle(second.body)
    if inside:
        return sheet.first(there - share * pitch / second.radius)
    return sheet.first(there + (share + 0.5) * pitch / second.radius)


@drawing("gear")
def gear(sheet: Sheet, part: Part) -> None:
    """Draw those wheels of one pair that no joint before it has."""
    sheet.force_at(part, _where_circles_touch(part))
    _wheels(sheet, part)


def _where_circles_touch(part: Part) -> Spot:
    (x, y), (x2, y2), radius = part.at(0), part.at(1), part.number("fields", "radii", 0)
    share = radius / call("max", call("hypot", x2 - x, y2 - y), 1e-12)
    return Spot(x + share * (x2 - x), y + share * (y2 - y))


def _wheels(sheet: Sheet, part: Part) -> None:
    teeth = _teeth(sheet)
    for _, wheel, _ in wheels_of(part):
        if teeth.owners[wheel] == part.name:
            _wheel(sheet, teeth.wheels[wheel], teeth)


def _wheel(sheet: Sheet, wheel: Meshed, teeth: Teeth) -> None:
    radius, depth, colour = wheel.radius, DEPTH * teeth.pitch, f"body {wheel.body}"
    angle = sheet.angle(wheel.body)
    body, meshed = Frame(wheel.at, angle), Frame(wheel.at, angle + (wheel.phase or 0.0))
    count = call("max", call("round", TURN * radius / teeth.pitch), 3.0)
    drawn = call("min", count, float(MANY))
    step, fill = TURN / count, Colour(colour, 0.72)
    tip, root = (radius - depth, radius + ROOT * teeth.pitch) if wheel.ring else (
        radius + depth, radius - ROOT * teeth.pitch)  # fmt: skip
    tooth = [polar(r, share * step) for share, r in ((-0.36, root), (-0.13, tip), (0.13, tip), (0.36, root))]
    outline = [sheet.repeated(drawn, tooth, turn=step)]
    rim = radius + RIM * depth
    circle, outer = [sheet.arc((0.0, 0.0), radius, count=97)], [sheet.arc((0.0, 0.0), rim, count=97)]
    for edge, frame, own, when in (
        (outline, meshed, 0.0 - (wheel.phase or 0.0), teeth.whole),
        (circle, body, 0.0, 1.0 - teeth.whole),
    ):
        thirds = [own + math.pi * (2 * k + 1) / 3 for k in range(3)]  # directions of holes in the frame of the body
        holes = [[sheet.arc(polar(0.56 * radius, third), 0.17 * radius, count=25)] for third in thirds]
        rings = [outer, edge] if wheel.ring else [edge, *holes]
        sheet.path(frame, *rings, z=2.0, line=colour, width=1.4, fill=fill, opacity=0.8, closed=True, when=when)
    spoke = (radius + 1.5 * depth, rim) if wheel.ring else (0.0, 0.8 * radius)
    sheet.path(body, [(end, 0.0) for end in spoke], z=2.0, line=colour, width=1.6)
    mark = sheet.repeated(drawn, [(radius - depth, 0.0), (radius + depth, 0.0), None],
                          turn=step)  # fmt: skip
    sheet.path(body, [mark], z=2.0, line=colour, when=1.0 - teeth.whole)
    reach = rim if wheel.ring else radius + depth
    sheet.hold(wheel.body, sheet.arc(wheel.centre, reach, count=25))


@drawing("rack", name_at=1.0)
def rack(sheet: Sheet, part: Part) -> None:
    """Draw the teeth of one rack towards its pinion, as far as this goes, and the pinion as a gear."""
    _wheels(sheet, part)
    teeth = _teeth(sheet)
    ((_, wheel, radius),) = wheels_of(part)
    pinion, axis = teeth.wheels[wheel], part.number("fields", "axis")
    a, b = (sheet.angle(body) for body in part.bodies)
    frame, (x, y), (x2, y2) = Frame(part.at(0), a + axis), part.at(0), part.at(1)
    way = (x2 - x) * cos(frame.angle) + (y2 - y) * sin(frame.angle)
    sheet.force_at(part, Spot(x2 - radius * sin(frame.angle), y2 + radius * cos(frame.angle)))
    least, most = sheet.range(way)
    low, high = least - BEYOND * radius, most + BEYOND * radius
    step = teeth.pitch * call("max", (high - low) / (teeth.pitch * float(LONGEST)), 1.0)
    # a tooth at the start lies in a gap of the pinion
    turned = (pinion.phase or 0.0) + b - a - axis - 0.5 * math.pi
    tooth = sheet.first(way - radius * turned)
    start = tooth + step * call("ceil", (low - tooth) / step)
    count = call("max", call("ceil", (high - step - start) / step), 0.0)
    h, colour = DEPTH * step, f"body {part.bodies[0]}"
    pattern = [
        (start + share * step, way_up * h) for share, way_up in ((0.14, 1.0), (0.37, -1.0), (0.63, -1.0), (0.86, 1.0))
    ]
    line = [(low, 2.4 * h), (low, h), sheet.repeated(count, pattern, shift=step), (high, h), (high, 2.4 * h)]
    sheet.path(frame, line, z=1.8, line=colour, width=1.4, fill=Colour(colour, 0.72), closed=True)
