"""Actuator between two points: a cylinder whose barrel hangs at A and whose rod leads to B."""

from __future__ import annotations

from rattle.drawings.forms import drawing
from rattle.drawings.forms.guide import BORE, ROD
from rattle.drawings.sheet import Colour, Frame, Part, Sheet, between, box

BARREL = 0.6  # of the shortest length


@drawing("actuator")
def actuator(sheet: Sheet, part: Part) -> None:
    """Draw one actuator."""
    sheet.feet(part)
    length, angle = between(part.at(0), part.at(1))
    frame, end = Frame(part.at(0), angle), BARREL * sheet.range(length)[0]
    rod, barrel = box(end, length, ROD * sheet.size), box(0.0, end, 0.8 * BORE * sheet.size)
    sheet.path(frame, rod, z=3.4, line=None, fill="grey")
    sheet.path(frame, barrel, z=3.4, width=1.6, fill=Colour("metal", 0.5), closed=True)
    for end_of_it, body in enumerate(part.bodies):
        sheet.dot(body, part.point(end_of_it), 3.6, z=3.5, width=1.5)
