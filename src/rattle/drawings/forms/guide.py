"""Prismatic joint: a block on a line of A, hatched if A is the ground; between moving bodies a cylinder with its rod.

A is a barrel if all its points are on the line: a tube that holds them and the piston, from which the rod, B, comes
out.  With play the line becomes two walls.
"""

from __future__ import annotations

from typing import NamedTuple

from rattle.description.model import is_ground
from rattle.drawings.forms import drawing
from rattle.drawings.numbers import Number, Value, call, cos, least_of, most_of, sin
from rattle.drawings.sheet import Colour, Frame, Part, Sheet, Spot, box

STRAIGHT = 0.01  # share of the mechanism's size within which points are on the line
BORE, PISTON, ROD = 0.026, 0.032, 0.009  # half the barrel's height, the piston's length, half the rod's: same share
BLOCK = 0.12, 0.07  # length and height of a block without sizes of its own: same share
OUT = 0.55  # a barrel without points of its own holds so much of the rod


class Line(NamedTuple):
    """The line of a guide or slot."""

    frame: Frame  # its origin at the point of A
    axis: Number  # its angle in A

    def coordinate(self, spot: Spot) -> Number:
        """How far along the line a point is."""
        dx, dy = spot.x - self.frame.at.x, spot.y - self.frame.at.y
        return dx * cos(self.frame.angle) + dy * sin(self.frame.angle)

    def aside(self, spot: Spot) -> Number:
        """How far from the line a point is."""
        dx, dy = spot.x - self.frame.at.x, spot.y - self.frame.at.y
        return abs(dy * cos(self.frame.angle) - dx * sin(self.frame.angle))


def line_of(sheet: Sheet, part: Part) -> Line:
    """The line of a guide or slot."""
    axis = part.number("axis")
    return Line(Frame(part.at(0), sheet.angle(part.bodies[0]) + axis), axis)


def carried(sheet: Sheet, part: Part, line: Line, low: Number, high: Number) -> None:
    """Where A is a body, it reaches up to both ends of the line that it carries."""
    (x, y), body = part.point(0), part.bodies[0]
    if not is_ground(body):
        sheet.reach_up_to(body, *((x + end * cos(line.axis), y + end * sin(line.axis)) for end in (low, high)))


def stop_walls(sheet: Sheet, part: Part, line: Line, before: Value, half: Value, when: Value | None = None) -> None:
    """Stops of the position as walls across the line, as far before B's point as the block reaches."""
    for k, end in part.stops:
        x = end + (before if k else -before)
        sheet.path(line.frame, [(x, -half), (x, half)], z=3.6, width=3.5, butt=True, when=when)


@drawing("guide", name_at=1.0)
def guide(sheet: Sheet, part: Part) -> None:
    """Draw one guide with its block, or a cylinder."""
    a, b = part.bodies
    line = line_of(sheet, part)
    sheet.force_at(part, part.at(1))
    as_guide: Value = 1.0
    if not is_ground(a) and not sheet.rings(a):
        barrel = _straight(sheet, line, a)
        as_guide = 1.0 - barrel
        rod = barrel * _straight(sheet, line, b) if not is_ground(b) and not sheet.rings(b) else None
        _cylinder(sheet, part, line, barrel, rod)
        sheet.draws(a, barrel)
        if rod is not None:
            sheet.draws(b, rod)
    _guide(sheet, part, line, as_guide)


def _straight(sheet: Sheet, line: Line, body: str) -> Number:
    """1 if all points of a body are on the line at the first instant."""
    off = [line.aside(sheet.at(body, point)) for point in sheet.points(body)]
    return sheet.first(most_of(0.0 * sheet.size, *off)) < STRAIGHT * sheet.size


def _block_size(sheet: Sheet, part: Part, usual: tuple[float, float]) -> tuple[Number, Number]:
    """Length and height of a block; usual: as shares of the mechanism's size."""
    if part.form.get("block"):
        return part.number("block", 0), part.number("block", 1)
    return usual[0] * sheet.size, usual[1] * sheet.size


def _guide(sheet: Sheet, part: Part, line: Line, when: Value) -> None:
    a, b = part.bodies
    length, height = _block_size(sheet, part, BLOCK)
    least, most = sheet.range(line.coordinate(part.at(1)))
    stops = [end for _, end in part.stops]
    low, high = least_of(least, *stops) - 0.85 * length, most_of(most, *stops) + 0.85 * length
    half = 0.5 * height + part.number("clearance")
    stop_walls(sheet, part, line, 0.5 * length, 0.7 * height, when)
    for side in (-1.0, 1.0) if part.form["clearance"] else (0.0,):
        ends = [(low, side * half), (high, side * half)]
        if is_ground(a):
            start, end = ends if side <= 0 else ends[::-1]
            sheet.wall(line.frame, start, end, line="grey", width=1.8)
        else:
            sheet.path(line.frame, ends, z=1.0, line="grey", width=1.8, when=when)
    carried(sheet, part, line, low, high)
    sheet.hold(line.frame, *box(low, high, half))
    # the block turns with B, which keeps its angle to A as far as the play lets it
    angles = [sheet.angle(body) for body in (a, b)]
    block = Frame(part.at(1), angles[1] + line.axis - sheet.first(angles[1] - angles[0]))
    colour = f"body {a if is_ground(b) else b}"
    corners = box(-0.5 * length, 0.5 * length, 0.5 * height)
    sheet.path(block, corners, z=2.4, line=colour, width=1.8, fill=Colour(colour, 0.72), closed=True, when=when)


def _cylinder(sheet: Sheet, part: Part, line: Line, when: Number, with_rod: Number | None) -> None:
    """Barrel A, piston and rod B."""
    a, b = part.bodies
    piston = line.coordinate(part.at(1))
    length, height = _block_size(sheet, part, (PISTON, 2.0 * BORE))
    half = 0.5 * height + part.number("clearance")
    own = [sheet.first(line.coordinate(sheet.at(a, point))) for point in sheet.points(a)] or [0.0 * sheet.size]
    tips = [line.coordinate(sheet.at(b, point)) for point in sheet.points(b)]
    stops = [end for _, end in part.stops]
    least, most = sheet.range(piston)
    low = least_of(*own, least - 0.8 * length, *(end - 0.5 * length for end in stops))
    high = most_of(*own, most + 0.8 * length, *(end + 0.5 * length for end in stops))
    near, far = least_of(piston, *tips), most_of(piston, *tips)
    # a barrel of which no point says where it ends holds a part of the rod
    short = most_of(*own) - least_of(*own) < 0.1 * sheet.size
    longer = most_of(high, OUT * sheet.range(far)[0])
    high = call("if", short, longer, high)
    barrel = box(low - 0.3 * half, high + 0.3 * half, half)
    stop_walls(sheet, part, line, 0.5 * length, half, when)
    line_of_a, line_of_b = f"body {a}", f"body {b}"
    sheet.path(line.frame, barrel, z=3.2, line=None, fill=Colour(line_of_a, 0.7), when=when)
    if with_rod is not None:
        rod = box(near, far, ROD * sheet.size)
        fill = Colour(line_of_b, 0.35)
        sheet.path(line.frame, rod, z=3.21, line=line_of_b, fill=fill, closed=True, when=with_rod)
    head = box(piston - 0.5 * length, piston + 0.5 * length, 0.5 * height)
    sheet.path(line.frame, head, z=3.22, line=line_of_b, fill=Colour(line_of_b, 0.25), closed=True, when=when)
    sheet.path(line.frame, barrel, z=3.23, line=line_of_a, width=2.0, closed=True, when=when)
