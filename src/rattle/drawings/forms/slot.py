"""Pin in a slot with rounded or open ends, of its given length or else a little longer than the pin moves.

A kind whose slot is a curve gives its middle as the outline of the joint.
"""

from __future__ import annotations

import math

from rattle.description.model import is_ground
from rattle.drawings.forms import drawing
from rattle.drawings.forms.guide import carried, line_of, stop_walls
from rattle.drawings.numbers import Number
from rattle.drawings.sheet import Frame, Part, Piece, Sheet, box

MORE = 0.06  # of a slot without ends beyond the ways of its pin, as a share of the mechanism's size
HALF = 0.02  # half its height where no size is known, same share
QUARTER = 0.5 * math.pi


@drawing("slot", name_at=1.0)
def slot(sheet: Sheet, part: Part) -> None:
    """Draw one slot and its pin."""
    clearance = part.number("clearance")
    half = part.number("bush_radius") if part.form.get("bush_radius") else HALF * sheet.size + clearance
    pin = half - clearance
    sheet.force_at(part, part.at(1))
    if len(part.form.get("outline", ())) > 1:
        _curved(sheet, part, sheet.around(sheet.given("joints", part.name, "outline"), half))
    else:
        _straight(sheet, part, half, pin)
    sheet.path(part.bodies[1], [sheet.arc(part.point(1), pin)], z=5.0, width=1.5, fill="steel", closed=True)


def _curved(sheet: Sheet, part: Part, edge: Piece) -> None:
    frame = Frame(part.at(0), sheet.angle(part.bodies[0]))
    sheet.path(frame, [edge], z=4.0, line="grey", width=1.8, fill="paper", opacity=0.85, closed=True)
    sheet.hold(frame, edge)
    if not is_ground(part.bodies[0]):
        (x, y), last = part.point(0), len(part.form["outline"]) - 1
        ends = ((x + part.number("outline", k, 0), y + part.number("outline", k, 1)) for k in (0, last))
        sheet.reach_up_to(part.bodies[0], *ends)


def _straight(sheet: Sheet, part: Part, half: Number, pin: Number) -> None:
    line = line_of(sheet, part)
    if "travel" in part.form:
        high = part.number("travel")
        low = 0.0 - high
    else:
        least, most = sheet.range(line.coordinate(part.at(1)))
        low, high = least - MORE * sheet.size, most + MORE * sheet.size
    open_ends = part.fields.get("open", 0.0)  # 1 start, 2 end, 3 both
    right, left = open_ends >= 2.0, open_ends in (1.0, 3.0)
    round_right = sheet.arc((high, 0.0), half, -QUARTER, QUARTER, count=19)
    round_left = sheet.arc((low, 0.0), half, QUARTER, 3.0 * QUARTER, count=19)
    if is_ground(part.bodies[0]):
        sheet.wall(line.frame, (low, 0.0 - half), (high, 0.0 - half), line="grey", width=1.6)
    stop_walls(sheet, part, line, pin, 1.3 * half)
    ends_right: list[Piece] = [(high, 0.0 - half), None, (high, half)] if right else [round_right]
    ends_left: list[Piece] = [(low, half), None, (low, 0.0 - half)] if left else [round_left]
    area: list[Piece] = [piece for piece in (*ends_right, *ends_left) if piece is not None]
    sheet.path(line.frame, area, z=4.0, line=None, fill="paper", opacity=0.85)
    edge = [*ends_right, *ends_left, (high, 0.0 - half)]
    sheet.path(line.frame, edge, z=4.0, line="grey", width=1.8)
    carried(sheet, part, line, low, high)
    sheet.hold(line.frame, *box(low - half, high + half, half))
