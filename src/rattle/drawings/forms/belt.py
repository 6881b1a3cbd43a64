"""Belt: both pulleys to scale with their spokes, and the strands that touch them."""

from __future__ import annotations

import math

from rattle.description.model import GROUND
from rattle.drawings.forms import drawing
from rattle.drawings.numbers import Number, call, cos, sin
from rattle.drawings.sheet import Colour, Frame, Part, Sheet, Spot, between, polar

INNER = 0.82  # radius up to which spokes go, as a share of that of the pulley


@drawing("belt")
def belt(sheet: Sheet, part: Part) -> None:
    """Draw both pulleys of one belt and its strands."""
    radii = [part.number("fields", "radii", end) for end in (0, 1)]
    sheet.force_at(part, part.at(1))
    for end, (body, radius) in enumerate(zip(part.bodies, radii, strict=True)):
        frame, colour = Frame(part.at(end), sheet.angle(body)), f"body {body}"
        sheet.hold(body, sheet.arc(part.point(end), radius, count=25))
        circle = sheet.arc((0.0, 0.0), radius, count=97)
        sheet.path(frame, [circle], z=2.0, line=colour, width=1.8, fill=Colour(colour, 0.75), closed=True)
        sheet.path(frame, [sheet.arc((0.0, 0.0), INNER * radius, count=97)], z=2.0, line=colour, width=1.0)
        for k in range(3):
            spoke = [(0.0, 0.0), polar(INNER * radius, 2.0 * math.pi * k / 3.0)]
            sheet.path(frame, spoke, z=2.0, line=colour, width=1.0 if k else 2.4)
    for side in (1.0, -1.0):
        strand = _strand(part.at(0), part.at(1), radii, bool(part.fields["crossed"]), side)
        sheet.path(GROUND, strand, z=2.2, width=2.4)


def _strand(a: Spot, b: Spot, radii: list[Number], crossed: bool, side: float) -> list[Spot]:
    """The line that touches both pulleys on one side."""
    length, angle = between(a, b)
    far = 0.0 - radii[1] if crossed else radii[1]
    turn = angle + side * call("acos", (radii[0] - far) / length)
    return [Spot(at.x + r * cos(turn), at.y + r * sin(turn)) for at, r in ((a, radii[0]), (b, far))]
