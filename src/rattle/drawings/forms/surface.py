"""Surfaces: a line with hatches on the side that bears, a segment, or a disc, to scale; what of B touches it.

Where they touch, a dot, and the cone within which the force may be: by atan(mu) to either side of the normal.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rattle.description.model import is_ground
from rattle.drawings.forms import drawing
from rattle.drawings.numbers import Number, Value, call, cos, least_of, most_of, sin
from rattle.drawings.sheet import Colour, Frame, Part, Piece, Sheet, Spot, between

BEYOND = 0.12  # of a line beyond the ways of what touches it, as a share of the mechanism's size
SHELL = 1.06  # outer radius of a hollow by its own
CONE = 0.07  # length of a cone, same share as BEYOND
HALF = 0.5 * math.pi


@drawing("surface", name_at=0.0)
def surface(sheet: Sheet, part: Part) -> None:
    """Draw one surface and what touches it."""
    spots = _spots(part)
    if part.fields.get("radius", 0.0) > 0.0:
        _disc(sheet, part)
        touching = {label: _on_disc(sheet, part, spot) for label, spot in spots.items()}
        if part.fields.get("outline") and not part.fields.get("hollow"):
            touching = {"": _on_edges(sheet, part)}
    else:
        frame = Frame(part.at(0), sheet.angle(part.bodies[0]) + part.number("fields", "axis"))
        _line(sheet, part, frame)
        touching = {label: _on_line(part, frame, spot) for label, spot in spots.items()}
    _borne(sheet, part)
    _touching(sheet, part, touching)


def _corner(part: Part, label: str) -> tuple[Number, Number]:
    return part.number("corners", label, 0), part.number("corners", label, 1)


def _spots(part: Part) -> dict[str, Spot]:
    """What of B touches, by its name: corners, or its point."""
    corners = {label: part.sheet.at(part.bodies[1], _corner(part, label)) for label in part.form.get("corners", {})}
    return corners or {"": part.at(1)}


def _on_the_same_line(sheet: Sheet, part: Part) -> list[Part]:
    """All surfaces whose endless line is that of this one, which is drawn once, by the first of them."""

    def place(form: Mapping[str, Any]) -> tuple[object, ...]:
        fields = form["fields"]
        return form["bodies"][0], tuple(form["points"][0]), fields["axis"], fields["radius"], fields["length"]

    surfaces = {name: form for name, form in sheet.geometry["joints"].items() if form["type"] == part.form["type"]}
    same = [name for name, form in surfaces.items() if place(form) == place(part.form)]
    return [Part(sheet, name, "joint", surfaces[name], False) for name in same]


def _along(frame: Frame, spot: Spot) -> Number:
    dx, dy = spot.x - frame.at.x, spot.y - frame.at.y
    return dx * cos(frame.angle) + dy * sin(frame.angle)


def _line(sheet: Sheet, part: Part, frame: Frame) -> None:
    """The line as far as it is needed, or the segment; a segment that bears on both sides has no hatches."""
    body, rolls = part.bodies[0], part.fields.get("roller", 0.0) > 0.0
    colour: Colour | str = "grey" if is_ground(body) else f"body {body}"
    if part.fields.get("length", 0.0) > 0.0:
        half = 0.5 * part.number("fields", "length")
        low, high = -half, half
    else:
        same = _on_the_same_line(sheet, part)
        if same[0].name != part.name:
            return
        ways = [sheet.range(_along(frame, spot)) for each in same for spot in _spots(each).values()]
        room = BEYOND * sheet.size + most_of(*(each.number("fields", "roller") for each in same))
        low = least_of(0.0 * sheet.size, *(least for least, _ in ways)) - room
        high = most_of(0.0 * sheet.size, *(most for _, most in ways)) + room
    ends: list[Piece] = [(low, 0.0), (high, 0.0)]
    if rolls and part.fields.get("length", 0.0) > 0.0:
        sheet.path(frame, ends, z=1.0, line=colour, width=3.5)
    else:
        sheet.wall(frame, (low, 0.0), (high, 0.0), line=colour, width=1.8)
    sheet.hold(frame, *ends)


def _disc(sheet: Sheet, part: Part) -> None:
    """The disc of A, or the shell of its hollow, with a line that shows how it turns."""
    body, point, radius = part.bodies[0], part.point(0), part.number("fields", "radius")
    colour, line = ("steel", "grey") if is_ground(body) else (f"body {body}", f"body {body}")
    ring: list[Piece] = [sheet.arc(point, radius, count=97)]
    if part.fields.get("hollow"):
        shell: list[Piece] = [sheet.arc(point, SHELL * radius, count=97)]
        sheet.path(body, shell, ring, z=1.0, line=line, width=1.2, fill=Colour(colour, 0.7), closed=True)
        sheet.hold(body, *shell)
    else:
        sheet.path(body, ring, z=1.2, line=line, width=1.8, fill=Colour(colour, 0.72), closed=True)
        sheet.hold(body, *ring)
        if not is_ground(body):
            sheet.path(body, [point, (point[0] + 0.8 * radius, point[1])], z=1.3, line=colour)
        sheet.dot(body, point, 2.6, z=1.3)


def _borne(sheet: Sheet, part: Part) -> None:
    """The disc of B, or dots at its corners."""
    body = part.bodies[1]
    if part.fields.get("roller", 0.0) > 0.0:
        point, radius, colour = part.point(1), part.number("fields", "roller"), f"body {body}"
        circle: list[Piece] = [sheet.arc(point, radius, count=73)]
        sheet.path(body, circle, z=3.4, line=colour, width=1.8, fill=Colour(colour, 0.75), closed=True)
        sheet.path(body, [point, (point[0] + 0.8 * radius, point[1])], z=3.4, line=colour)
        sheet.dot(body, point, 2.6, z=3.5)
        sheet.hold(body, *circle)
        return
    for label in part.form.get("corners", {}):
        sheet.dot(body, _corner(part, label), 2.4, z=4.0, width=1.0)


def _on_line(part: Part, frame: Frame, spot: Spot) -> Frame:
    """Where a corner or disc touches a line, or would; x along the line, y to the free side."""
    radius: Value = part.number("fields", "roller") if part.fields.get("roller", 0.0) > 0.0 else 0.0
    return Frame(Spot(spot.x + radius * sin(frame.angle), spot.y - radius * cos(frame.angle)), frame.angle)


def _on_disc(sheet: Sheet, part: Part, spot: Spot) -> Frame:
    """The same of a disc, or of its hollow, where B is on the other side."""
    centre, radius = part.at(0), part.number("fields", "radius")
    _, angle = between(centre, spot)
    place = Spot(centre.x + radius * cos(angle), centre.y + radius * sin(angle))
    return Frame(place, angle + HALF if part.fields.get("hollow") else angle - HALF)


def _on_edges(sheet: Sheet, part: Part) -> Frame:
    """Where an outline touches a disc, by the force there: its normal part goes through the centre of the disc."""
    fx, fy, normal, along = (sheet.curve(f"{part.name}.{key}") for key in ("fx", "fy", "normal", "tangential"))
    angle = call("atan2", fy, fx) + call("atan2", along, normal)
    centre, radius = part.at(0), part.number("fields", "radius")
    return Frame(Spot(centre.x + radius * cos(angle), centre.y + radius * sin(angle)), angle - HALF)


def _touching(sheet: Sheet, part: Part, touching: dict[str, Frame]) -> None:
    """Dots and cones where a force acts; the force of several corners acts where their sum does."""
    several = len(touching) > 1
    weights: list[tuple[Number, Spot]] = []
    for label, frame in touching.items():
        pressing = sheet.curve(f"{part.name}.{label}.normal" if several else f"{part.name}.normal")
        weights.append((pressing, frame.at))
        if part.form.get("mu", 0.0) > 0.0:
            long, wide = CONE * sheet.size, CONE * part.number("mu") * sheet.size
            cone: list[Piece] = [(0.0, 0.0), (-wide, long), (wide, long)]
            sheet.path(frame, cone, z=4.6, line=None, fill=Colour("red", 0.6), opacity=0.4, closed=True, when=pressing)
        sheet.dot(frame, (0.0, 0.0), 3.0, z=5.2, line="red", fill="red", width=0.0, when=pressing)
    if not several:
        sheet.force_at(part, weights[0][1])
        return
    total = sum((pressing for pressing, _ in weights[1:]), weights[0][0])
    x, y = (
        sum((pressing * spot[k] for pressing, spot in weights[1:]), weights[0][0] * weights[0][1][k]) for k in (0, 1)
    )
    first = weights[0][1]
    sheet.force_at(part, Spot(call("if", total, x / total, first.x), call("if", total, y / total, first.y)))
