"""Spring with coils, damper as a dashpot, both side by side; a short wall where it is held by the ground."""

from __future__ import annotations

import math

from rattle.description.model import is_ground
from rattle.drawings.forms import drawing
from rattle.drawings.numbers import Number, Value
from rattle.drawings.sheet import Colour, Frame, Part, Piece, Sheet, between

HALF = 0.025  # half the width, as a share of the mechanism's size
COILS = 9
LONG = 0.7 / COILS  # of a coil, as a share of the spring's length
HALF_TURN = 0.5 * math.pi


@drawing("spring")
def spring(sheet: Sheet, part: Part) -> None:
    """Draw one spring, damper or both."""
    half, fields = HALF * sheet.size, part.fields
    length, angle = between(part.at(0), part.at(1))
    frame = Frame(part.at(0), angle, length)  # along as shares of the length
    stiff = "fields" not in part.form or fields.get("stiffness", 1.0) != 0.0
    damped = "fields" in part.form and fields.get("damping", 1.0) != 0.0
    if stiff and damped:
        _coils(sheet, frame, 0.7 * half, half)
        ends: list[Piece] = [(0.0, 0.0), (0.12, 0.0), None, (0.12, -half), (0.12, half), None]
        ends += [(0.88, -half), (0.88, half), None, (0.88, 0.0), (1.0, 0.0)]
        sheet.path(frame, [*ends, None, *_dashpot(0.6 * half, 0.0 - half)], z=2.0, line="grey", width=1.5, butt=True)
    elif stiff:
        _coils(sheet, frame, half, 0.0)
        sheet.path(frame, [(0.0, 0.0), (0.12, 0.0), None, (0.88, 0.0), (1.0, 0.0)], z=2.0, line="metal", width=2.0)
    else:
        pot = [(0.0, 0.0), *_dashpot(0.6 * half, 0.0), (1.0, 0.0)]
        sheet.path(frame, pot, z=2.0, line="grey", width=1.5, butt=True)
    for end, (body, turn) in enumerate(zip(part.bodies, (-HALF_TURN, HALF_TURN), strict=True)):
        if is_ground(body):  # hatched behind, as it lies at the start
            held = Frame(part.at(end), sheet.first(angle) - turn)
            sheet.wall(held, (1.6 * half, 0.0), (-1.6 * half, 0.0), stroke=0.4 * half)
        sheet.dot(body, part.point(end), 2.6, z=2.0, line="grey", width=1.2)


def _coils(sheet: Sheet, frame: Frame, half: Number, shift: Value) -> None:
    """Coils seen from the side, those in front darker than those behind, moved to one side."""
    low, high, middle = shift - half, shift + half, 0.15 + 0.5 * LONG
    for colour, from_y, to_y, first in ((Colour("metal", 0.45), high, low, middle), ("metal", low, high, 0.15)):
        stroke: list[Piece] = [(first, from_y), (first + 0.5 * LONG, to_y), None]
        copies = sheet.repeated(COILS, stroke, shift=LONG)
        sheet.path(frame, [copies], z=2.0, line=colour, width=2.0)
    ends: list[Piece] = [(0.12, shift), (0.15, low), None, (0.85, low), (0.88, shift)]
    sheet.path(frame, ends, z=2.0, line="metal", width=2.0)


def _dashpot(half: Number, shift: Value) -> list[Piece]:
    """A pot, open to the right, and the plunger in it, moved to one side."""
    low, high = shift - half, shift + half
    pot: list[Piece] = [(0.65, high), (0.35, high), (0.35, low), (0.65, low)]
    plunger: list[Piece] = [(0.55, shift + 0.8 * half), (0.55, shift - 0.8 * half)]
    return [(0.12, shift), (0.35, shift), None, *pot, None, *plunger, None, (0.55, shift), (0.88, shift)]
