"""Revolute joint: a circle, dark if it is driven, with a ring if it has play and a foot on the ground.

Stops of its angle are short dark marks.
"""

from __future__ import annotations

import math

from rattle.description.model import is_ground
from rattle.drawings.forms import drawing
from rattle.drawings.numbers import Value, call
from rattle.drawings.sheet import Frame, Part, Sheet, polar

STOP = 0.09  # radius at which stops are marked, as a share of the mechanism's size


@drawing("pin", name_at=0.0)
def pin(sheet: Sheet, part: Part) -> None:
    """Draw one pin."""
    body, point = part.bodies[0], part.point(0)
    sheet.feet(part)
    if part.form["contact"] != "ideal":
        sheet.dot(body, point, 8.5, line="grey", width=1.3, when=part.number("clearance"))
    sheet.dot(body, point, 4.6, width=1.8, fill="black" if part.driven else "paper")
    if part.stops:
        _stops(sheet, part)


def _stops(sheet: Sheet, part: Part) -> None:
    """Stops of the angle: marks in the directions that the farthest point of B has there, and the arc between them."""
    a, b, sense = (0, 1, 1.0) if not is_ground(part.bodies[1]) else (1, 0, -1.0)
    names, other = sheet.geometry["bodies"][part.bodies[b]]["points"], part.form["points"][b]
    own: Value = 0.0
    if names:
        far = max(range(len(names)), key=lambda k: math.dist([*names.values()][k], other))
        (x, y), (x0, y0) = sheet.points(part.bodies[b])[far], part.point(b)
        own = call("atan2", y - y0, x - x0)
    frame, radius = Frame(part.at(a), sheet.angle(part.bodies[a]) + own), STOP * sheet.size
    ends = [sense * end for _, end in part.stops]
    for end in ends:
        mark = [polar(0.5 * radius, end), polar(1.2 * radius, end)]
        sheet.path(frame, mark, z=3.6, width=3.5, butt=True)
    if len(ends) == 2:
        sheet.path(frame, [sheet.arc((0.0, 0.0), radius, *ends)], z=2.5, line="grey", width=1.0)
