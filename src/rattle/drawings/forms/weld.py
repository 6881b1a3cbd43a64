"""Fixed joint: a dark square, hatched below if it is on the ground."""

from __future__ import annotations

from rattle.description.model import is_ground
from rattle.drawings.forms import drawing
from rattle.drawings.sheet import Part, Sheet

HALF = 0.045  # of the hatched line, as a share of the mechanism's size


@drawing("weld", name_at=0.0)
def weld(sheet: Sheet, part: Part) -> None:
    """Draw one fixed joint."""
    sheet.dot(part.bodies[0], part.point(0), 5.0, fill="black", square=True)
    for end, body in enumerate(part.bodies):
        if not is_ground(body):
            continue
        x, y = part.point(end)
        half = HALF * sheet.size
        sheet.wall(body, (x - half, y), (x + half, y))
