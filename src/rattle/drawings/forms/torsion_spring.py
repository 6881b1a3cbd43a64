"""Torsion spring: a spiral about the point of B that goes with A at its outer and with B at its inner end."""

from __future__ import annotations

import math

from rattle.drawings.forms import drawing
from rattle.drawings.sheet import Frame, Part, Sheet

TURNS = 2.5
RADIUS = 0.05  # as a share of the mechanism's size


@drawing("torsion-spring", name_at=1.0)
def torsion_spring(sheet: Sheet, part: Part) -> None:
    """Draw one torsion spring."""
    outer, inner = (sheet.angle(body) for body in part.bodies)
    radius, end = RADIUS * sheet.size, 2.0 * math.pi * TURNS + outer
    spiral = sheet.arc((0.0, 0.0), 0.25 * radius, inner, end, last=radius, count=91)
    sheet.path(Frame(part.at(1), 0.0), [spiral], z=4.5, line="metal", width=1.6)
