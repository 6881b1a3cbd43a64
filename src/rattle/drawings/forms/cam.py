"""Cams: the outline that their function gives, to scale, with a line from the centre, so that turning is seen.

Also the locking disc of a Geneva drive: the disc with its sector cut out, and the wheel with its hollow arcs.
"""

from __future__ import annotations

import math

from rattle.drawings.forms import drawing
from rattle.drawings.numbers import Number, call, cos, least_of, most_of, sin
from rattle.drawings.sheet import Colour, Frame, Part, Sheet

EVERY = 12  # of the points of an outline, those that a picture is made large enough for
MORE = 0.1  # of a face beyond where it touches, as a share of the largest reach of the outline


def _outline(sheet: Sheet, part: Part, end: int, key: str) -> None:
    """An outline on a body, filled if it is closed, then with a line from the centre to where it begins."""
    points = part.form.get(key, ())
    if len(points) < 2:
        return
    place = ("joints", part.name, key)
    frame, colour = Frame(part.at(end), sheet.angle(part.bodies[end])), f"body {part.bodies[end]}"
    closed = math.dist(points[0], points[-1]) < 1e-6 * max(abs(x) for point in points for x in point)
    fill = Colour(colour, 0.72) if closed else None
    sheet.path(frame, [sheet.given(*place)], z=2.0, line=colour, width=2.0, fill=fill, opacity=0.9)
    sheet.hold(frame, sheet.given(*place, every=EVERY))
    if closed:
        begins = [part.number(key, len(points) // 2, k) for k in (0, 1)]
        sheet.path(frame, [(0.0, 0.0), (begins[0], begins[1])], z=2.0, line=colour, width=1.4)


@drawing("cam", name_at=1.0)
def cam(sheet: Sheet, part: Part) -> None:
    """Draw one cam, with the roller that follows it, to scale, or with a dot for a point."""
    sheet.force_at(part, part.at(1))
    _outline(sheet, part, 0, "outline")
    rolls, body, point = part.fields.get("roller", 0.0) > 0.0, part.bodies[1], part.point(1)
    if rolls:
        radius, colour = part.number("fields", "roller"), f"body {body}"
        circle = [sheet.arc(point, radius)]
        sheet.path(body, circle, z=4.0, line=colour, width=1.8, fill=Colour(colour, 0.75), closed=True)
        sheet.path(body, [point, (point[0] + 0.8 * radius, point[1])], z=4.0, line=colour)
    sheet.dot(body, point, 2.6 if rolls else 4.0, z=4.0)


@drawing("flat-follower", name_at=1.0)
def flat_follower(sheet: Sheet, part: Part) -> None:
    """Draw one cam, and the face of its follower as far as the cam may touch it."""
    sheet.force_at(part, part.at(1))
    _outline(sheet, part, 0, "outline")
    face = Frame(part.at(1), sheet.angle(part.bodies[1]) + part.number("fields", "axis"))
    (x, y), centre = face.at, part.at(0)
    own = (centre.y - y) * cos(face.angle) - (centre.x - x) * sin(face.angle)
    size = (1.0 + MORE) * _largest(sheet, part)
    ends = [(0.0, least_of(own - size, 0.0)), (0.0, most_of(own + size, 0.0))]
    sheet.path(face, ends, z=3.0, line=f"body {part.bodies[1]}", width=4.0)
    sheet.dot(part.bodies[1], part.point(1), 2.0, z=3.0, width=1.0)


def _largest(sheet: Sheet, part: Part) -> Number:
    """The largest distance of an outline from its centre."""
    points = part.form.get("outline") or ()
    reaches = [call("hypot", *(part.number("outline", k, x) for x in (0, 1))) for k in range(0, len(points), EVERY)]
    return most_of(*reaches) if reaches else 0.1 * sheet.size


@drawing("locking-disc", name_at=0.0)
def locking_disc(sheet: Sheet, part: Part) -> None:
    """Draw one disc and its wheel."""
    _outline(sheet, part, 0, "outline")
    _outline(sheet, part, 1, "borne_outline")
