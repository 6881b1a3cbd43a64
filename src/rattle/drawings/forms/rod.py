"""Massless rod: a thin bar between two pins.  Without a length it is a rope, which sags where it is slack."""

from __future__ import annotations

from rattle.description.model import GROUND
from rattle.drawings.forms import drawing
from rattle.drawings.numbers import Value, call, most_of, sin
from rattle.drawings.sheet import Part, Piece, Sheet, Spot, between

PARTS = 24  # of a slack rope
SAG = 0.9  # depth of a parabola as a share of that of two straight lines of the same length, from 0.87 to 1


@drawing("rod")
def rod(sheet: Sheet, part: Part) -> None:
    """Draw one rod or rope."""
    sheet.feet(part)
    if part.form.get("coordinate") == "distance":
        sheet.force_at(part, part.at(1))
        _between_its_ends(sheet, part)
    else:
        sheet.path(GROUND, [part.at(0), part.at(1)], z=2.0, line="grey", width=2.6)
    for end in (0, 1):
        sheet.dot(part.bodies[end], part.point(end), 4.0, width=1.6)


def _between_its_ends(sheet: Sheet, part: Part) -> None:
    """A rope as long as its largest distance, or a dashed line where only a least distance is kept."""
    a, b = part.at(0), part.at(1)
    longest = next((end for k, end in part.stops if k == 1), None)
    if longest is None:
        sheet.path(GROUND, [a, b], z=2.0, line="grey", width=1.6, dash=(5.0, 3.0))
        return
    length, _ = between(a, b)
    depth = SAG * 0.5 * longest * sin(call("acos", length / most_of(longest, length)))
    rope: list[Piece] = [_hanging(a, b, k / PARTS, depth) for k in range(PARTS + 1)]
    sheet.path(GROUND, rope, z=2.0, line="grey", width=2.0)
    sheet.hold(GROUND, *rope)


def _hanging(a: Spot, b: Spot, share: float, depth: Value) -> Spot:
    """A point of a rope that hangs down between two points."""
    low = 4.0 * share * (1.0 - share) * depth
    return Spot((1.0 - share) * a.x + share * b.x, (1.0 - share) * a.y + share * b.y - low)
