"""Massless rod: a thin bar between two pins."""

from __future__ import annotations

from rattle.drawings.forms import drawing
from rattle.drawings.sheet import GROUND, Part, Sheet


@drawing("rod")
def rod(sheet: Sheet, part: Part) -> None:
    """Draw one rod."""
    sheet.feet(part)
    sheet.path(GROUND, [part.at(0), part.at(1)], z=2.0, line="grey", width=2.6)
    for end in (0, 1):
        sheet.dot(part.bodies[end], part.point(end), 4.0, width=1.6)
