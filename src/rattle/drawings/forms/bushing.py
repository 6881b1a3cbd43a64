"""Bushing: rubber between a sleeve on A and a pin on B, whose marks show how it is displaced and twisted."""

from __future__ import annotations

import math

from rattle.drawings.forms import drawing
from rattle.drawings.sheet import Colour, Frame, Part, Sheet, polar

OUTER, INNER = 0.034, 0.015  # radii of sleeve and pin, as shares of the mechanism's size
ROUND = 2.0 * math.pi


@drawing("bushing", name_at=0.0)
def bushing(sheet: Sheet, part: Part) -> None:
    """Draw one bushing."""
    sheet.feet(part)
    sleeve, pin = (Frame(part.at(end), sheet.angle(body)) for end, body in enumerate(part.bodies))
    outer, inner = OUTER * sheet.size, INNER * sheet.size
    rubber = sheet.arc((0.0, 0.0), outer, 0.0, ROUND, count=49)
    sheet.path(sleeve, [rubber], z=3.0, line="metal", width=2.0, fill=Colour("grey", 0.45), closed=True)
    core = sheet.arc((0.0, 0.0), inner, 0.0, ROUND, count=33)
    sheet.path(pin, [core], z=3.2, line="grey", width=1.6, fill="paper", closed=True)
    sheet.path(sleeve, [polar(outer, 0.0), polar(0.75 * outer, 0.0)], z=3.3, line="metal", width=2.0, butt=True)
    sheet.path(pin, [(0.0, 0.0), polar(inner, 0.0)], z=3.4, line="grey", width=1.6, butt=True)
