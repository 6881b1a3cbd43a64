"""Clutch: an arrow in its sense around the middle of the driven body, black while it is locked."""

from __future__ import annotations

import math

from rattle.description.model import is_ground
from rattle.drawings.forms import drawing
from rattle.drawings.numbers import Number
from rattle.drawings.sheet import Frame, Part, Sheet, polar


def hub(bodies: list[str]) -> str:
    """The body around which the arrow is drawn: B, or A if B is the ground."""
    a, b = bodies
    return a if is_ground(b) else b


@drawing("clutch", name_at=1.0)
def clutch(sheet: Sheet, part: Part) -> None:
    """Draw one clutch; several around one body have arrows of different radii."""
    joints, body = sheet.geometry["joints"], hub(part.form["bodies"])
    others = [name for name, form in joints.items() if "sense" in form and hub(form["bodies"]) == body]
    radius, sense = (0.045 + 0.024 * others.index(part.name)) * sheet.size, float(part.form["sense"])
    frame = Frame(sheet.at(body, (0.0, 0.0)), 0.0)
    start, end, tip = ((0.5 + sense * turn) * math.pi for turn in (-1.6, -0.15, -0.03))
    head = [polar(1.22 * radius, end), polar(radius, tip), polar(0.78 * radius, end)]
    locked = sheet.curve(f"{part.name}.locked") > 0.5

    def arrow(colour: str, width: float, when: Number) -> None:
        sheet.path(frame, [sheet.arc((0.0, 0.0), radius, start, end)], z=6.0, line=colour, width=width, when=when)
        sheet.path(frame, head, z=6.0, line=None, fill=colour, when=when)

    arrow("grey", 1.6, 1.0 - locked)
    arrow("black", 3.0, locked)
