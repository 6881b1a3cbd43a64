"""Pins in their bushes and blocks in their guides, magnified: how they lie in their play, and the force there.

Each is a picture of its own, in which 1 is its width and the middle is 0.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rattle.description.model import GROUND
from rattle.drawings.arrows import Style, straight, stretched
from rattle.drawings.numbers import Number, Value, call, cos, most_of, sin
from rattle.drawings.sheet import Colour, Frame, Part, Sheet, Spot, box

BUSH, PIN = 0.4, 0.56  # radius of a bush; of its pin, as a share of that
OUT = 1.35  # clearances from the middle at which a pin that left its bush stays
TRAIL = 0.012  # of the motion, whose path is drawn behind the centre of a pin
PLAY = 0.13  # play of a block or of a pin between walls
BLOCK = 0.28, 0.16  # half the length and the height of a block
BETWEEN = 0.2  # radius of a pin between walls
REACH, HATCH = 0.44, 7.0  # half the length of a wall, and its hatches [pixels]
USUAL, LONG, MOST = 0.8, 0.3, 1.25  # share of all instants with a usual force, its arrow, and when one is cut


def draw_magnified(sheet: Sheet, parts: Iterable[tuple[Part, str]]) -> list[dict[str, Any]]:
    """Pictures of joints with play, with what their play is: `circle`, `walls`, or `slot` for a pin between walls."""
    draw = {"circle": _pin, "walls": _block, "slot": _pin_between_walls}
    return [
        {"joint": part.name, "drawn": sheet.apart(draw[play], sheet, part)}
        for part, play in sorted(parts, key=lambda each: each[1] != "circle")
    ]


def _pin(sheet: Sheet, part: Part) -> None:
    c = part.number("clearance")
    ex, ey = (sheet.tape.node("pin", f"{part.name}.{axis}") for axis in ("ex", "ey"))
    scale = (1.0 - PIN) * BUSH / c
    far = most_of(call("hypot", ex, ey) / (OUT * c), 1.0)
    at = Spot(scale * ex / far, scale * ey / far)
    _circle(sheet, sheet.spot(0.0, 0.0), BUSH + 4.0 * sheet.pixel, line=None, fill="steel")
    _circle(sheet, sheet.spot(0.0, 0.0), BUSH, line="metal", fill="paper", width=1.4)
    pulls = sheet.curve(f"{part.name}.normal") < 0.0 if part.form["contact"] == "massless-link" else None
    states: list[tuple[str, str, Value | None]] = [("black", "metal", None)]
    if pulls is not None:
        states = [("black", "metal", 1.0 - pulls), ("red", "red", pulls)]
    for line, fill, when in states:
        _circle(sheet, at, PIN * BUSH, line=line, fill=fill, width=1.8, opacity=0.35, when=when)
    _circle(sheet, sheet.spot(0.0, 0.0), scale * c, line="grey", width=0.8, dash=(2.0, 3.0))
    sheet.path(GROUND, [sheet.trail(part.name, TRAIL, scale), at], z=1.0, line="sky", width=2.0)
    for line, _, when in states:
        sheet.dot(GROUND, at, 3.0, z=1.0, line=line, fill=line, when=when)
        _force(sheet, part, at, line, when)


def _circle(sheet: Sheet, middle: Spot, radius: Value, **style: Any) -> None:
    sheet.path(GROUND, [sheet.arc(middle, radius)], z=1.0, closed=True, **style)


def _force(sheet: Sheet, part: Part, at: Spot, colour: str, when: Value | None = None) -> None:
    fx, fy = (sheet.curve(f"{part.name}.{axis}") for axis in ("fx", "fy"))
    usual = sheet.usual(USUAL, call("hypot", fx, fy))
    straight(sheet, at, stretched(sheet, fx, fy, usual, (LONG, MOST)), Style(colour, 2.6, 1.0), when)


def _walls(sheet: Sheet, part: Part, half: float) -> tuple[Number, Spot, Number]:
    """Walls so far from a block or pin; angle of the guide, where the middle is, and how many times it is magnified."""
    c, axis = part.number("clearance"), sheet.angle(part.bodies[0]) + part.number("axis")
    scale = PLAY / c
    ex, ey = (sheet.curve(f"{part.name}.{way}") for way in ("ex", "ey"))
    off = scale * (ey * cos(axis) - ex * sin(axis))
    for side in (-1.0, 1.0):
        ends = [(side * way * REACH, side * (half + PLAY)) for way in (1.0, -1.0)]
        sheet.wall(Frame(sheet.spot(0.0, 0.0), axis), *ends, z=1.0, stroke=HATCH * sheet.pixel, line="metal", width=1.6)
    return axis, Spot(-off * sin(axis), off * cos(axis)), scale


def _block(sheet: Sheet, part: Part) -> None:
    long, half = BLOCK
    axis, middle, scale = _walls(sheet, part, half)
    length = part.number("block", 0) if part.form.get("block") else 4.0 * part.number("clearance")
    angles = [sheet.angle(body) for body in part.bodies]
    tilt = angles[1] - angles[0] - sheet.first(angles[1] - angles[0])
    frame = Frame(middle, axis + call("atan2", 0.5 * scale * tilt * length, long))
    sheet.path(frame, box(-long, long, half), z=1.0, width=1.8, fill="metal", opacity=0.35, closed=True)
    sheet.dot(GROUND, middle, 3.0, z=1.0, fill="black")
    _force(sheet, part, middle, "black")


def _pin_between_walls(sheet: Sheet, part: Part) -> None:
    _, middle, _ = _walls(sheet, part, BETWEEN)
    _circle(sheet, middle, BETWEEN, width=1.8, fill=Colour("steel"))
    sheet.dot(GROUND, middle, 3.0, z=1.0, fill="black")
    _force(sheet, part, middle, "black")
