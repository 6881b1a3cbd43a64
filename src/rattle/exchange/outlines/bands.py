"""The band that is stretched around circles: the shape of a link of which only its pins are known."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.exchange.outlines.edges import Circle, Corner, Outline, arc_bulge

TURN = 2.0 * math.pi
SAME = 1e-9  # of the radius of a circle: one that stands out of it by less is within it


def band(circles: Sequence[Circle]) -> Outline:
    """The convex outline of circles, of straight edges and arcs, counter-clockwise.

    It goes around from one circle to the next as a gift is wrapped: the next one is that whose common tangent turns
    least.
    """
    circles = _apart(circles)
    if len(circles) == 1:
        return circles[0].outline
    first = max(circles, key=lambda circle: (circle.x + circle.radius, circle.radius))
    corners: list[Corner] = []
    now, way = first, 0.5 * math.pi  # the direction in which the band leaves now
    turned = 0.0
    while turned < TURN - 1e-12:
        circle, turn = min(
            ((other, _turn(now, other, way)) for other in circles if other is not now), key=lambda pair: pair[1]
        )
        turn = min(turn, TURN - turned)
        sweep, start = turn, way - 0.5 * math.pi
        at = now.x + now.radius * math.cos(start), now.y + now.radius * math.sin(start)
        if sweep > 1e-12 and now.radius > 0.0:
            corners.append(Corner(*at, arc_bulge(sweep)))
            end = start + sweep
            at = now.x + now.radius * math.cos(end), now.y + now.radius * math.sin(end)
        turned += turn
        way += turn
        if turned < TURN - 1e-12:
            corners.append(Corner(*at))
            now = circle
        if len(corners) > 4 * len(circles) + 4:  # rounding: circles that all but touch the band
            break
    if now is not first:
        corners.append(Corner(*at))  # rounding: the band is on its way back to where it began
    elif len(corners) > 1 and corners[0].bulge and corners[-1].bulge:
        sweep = 4.0 * (math.atan(corners[0].bulge) + math.atan(corners[-1].bulge))
        corners = [*corners[1:-1], corners[-1]._replace(bulge=arc_bulge(sweep))]
    return tuple(corners)


def _apart(circles: Sequence[Circle]) -> list[Circle]:
    """Circles that are not within another one."""
    kept: list[Circle] = []
    for circle in sorted(circles, key=lambda circle: -circle.radius):
        if all(math.dist(circle[:2], other[:2]) + circle.radius > other.radius * (1.0 + SAME) for other in kept):
            kept.append(circle)
    return kept


def _turn(now: Circle, other: Circle, way: float) -> float:
    """By how much the direction of the band turns before it leaves for another circle, 0 to a turn.

    With its direction w the band is a common tangent where n.(c - c0) = r0 - r, n = w turned by -90 deg.
    """
    distance = math.dist(now[:2], other[:2])
    angle = math.atan2(other.y - now.y, other.x - now.x)
    sine = max(-1.0, min(1.0, (now.radius - other.radius) / distance))
    turn = (angle + math.asin(sine) - way) % TURN
    return 0.0 if turn > TURN - 1e-9 else turn
