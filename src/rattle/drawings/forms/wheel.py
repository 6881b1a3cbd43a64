"""A wheel on its line to scale: a disc with holes and a spoke, so that turning is seen, on a line as long as its way.

The line is hatched on its right, on the side where the wheel is not.
"""

from __future__ import annotations

import math

from rattle.description.model import is_ground
from rattle.drawings.forms import drawing
from rattle.drawings.numbers import Number, cos, sin
from rattle.drawings.sheet import Colour, Frame, Part, Sheet, Spot, polar

BEYOND = 1.5  # of the line beyond the ways of the wheel, in radii
HOLES = 3
STROKE = 0.25  # length of a hatch, in radii


def disc(sheet: Sheet, part: Part, radius: Number) -> None:
    """A disc about the point of B, with holes and a spoke."""
    body = part.bodies[1]
    frame, colour = Frame(part.at(1), sheet.angle(body)), f"body {body}"
    turns = [math.pi * (2 * k + 1) / HOLES for k in range(HOLES)]
    holes = [[sheet.arc(polar(0.56 * radius, turn), 0.17 * radius, count=25)] for turn in turns]
    rim = [sheet.arc((0.0, 0.0), radius, count=97)]
    sheet.path(frame, rim, *holes, z=2.0, line=colour, width=1.8, fill=Colour(colour, 0.72), opacity=0.8, closed=True)
    sheet.path(frame, [(0.0, 0.0), (0.92 * radius, 0.0)], z=2.0, line=colour, width=1.6)
    sheet.hold(body, sheet.arc(part.point(1), radius, count=25))


@drawing("wheel", name_at=1.0)
def wheel(sheet: Sheet, part: Part) -> None:
    """Draw one wheel, and its line as far as the wheel goes."""
    radius, axis = part.number("fields", "radius"), part.number("fields", "axis")
    line, (x, y), (x2, y2) = Frame(part.at(0), sheet.angle(part.bodies[0]) + axis), part.at(0), part.at(1)
    way = (x2 - x) * cos(line.angle) + (y2 - y) * sin(line.angle)
    sheet.force_at(part, Spot(x2 + radius * sin(line.angle), y2 - radius * cos(line.angle)))
    least, most = sheet.range(way)
    start, end = (least - BEYOND * radius, 0.0), (most + BEYOND * radius, 0.0)
    colour = "black" if is_ground(part.bodies[0]) else f"body {part.bodies[0]}"
    height = 1.8 if is_ground(part.bodies[0]) else 3.1  # on the body that carries it
    sheet.wall(line, start, end, z=height, stroke=STROKE * radius, line=colour, width=1.8)
    disc(sheet, part, radius)
    sheet.dot(part.bodies[1], part.point(1), 2.6)
