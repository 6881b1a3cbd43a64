"""Exact extremes of an output over all that the play of the joints allows.

Every pin may sit anywhere in its circle.  The block of a guide (length 2 a, height 2 b, walls at +-(b + c)) may be
moved across by e and turned by theta as long as its four corners stay between the walls:

    |e| <= room(theta) = b + c - a |sin theta| - b |cos theta|

a region with four curved sides that bow inwards, tips at (+-c, 0) and (0, +-theta_m), where
sin(theta_m + atan(b/a)) = (b + c)/hypot(a, b).  A block whose diagonal fits between the walls can turn over.
The output is followed uphill: pins to the place on their circle that the slope at the last place names, guides from
tip to tip, and where the slope asks for it along the sides.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from rattle.analyses.accuracy.displaced_pins import Displaced
from rattle.description.model import Joint

ROUNDS = 12
MOST_GUIDES = 3  # up to so many guides all combinations of their kinds of tips are starts
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def largest_turn(joint: Joint) -> float:
    """How far the block of a guide can turn either way [rad]; inf where it can turn over, 0 without a block."""
    if not joint.block:
        return 0.0
    a, b = 0.5 * joint.block[0], 0.5 * joint.block[1]
    if math.hypot(a, b) <= b + joint.clearance:
        return math.inf
    return math.asin((b + joint.clearance) / math.hypot(a, b)) - math.atan2(b, a)


def room(joint: Joint, turn: float) -> float:
    """How far the block of a guide can be moved across, either way, when it is turned [m]."""
    if not joint.block:
        return joint.clearance
    a, b = 0.5 * joint.block[0], 0.5 * joint.block[1]
    return max(b + joint.clearance - a * abs(math.sin(turn)) - b * abs(math.cos(turn)), 0.0)


def extreme(shown: Displaced, t: float, node: np.ndarray, sign: float, slope: np.ndarray) -> float:
    """Greatest (sign 1) or least (-1) output over all displacements; nan where a guide's block can turn over."""
    guides = [k for k, joint in enumerate(shown.joints) if joint.kind == "prismatic"]
    if any(largest_turn(shown.joints[k]) == math.inf for k in guides):
        return math.nan
    best = math.nan
    for turned in _kinds_of_tips(len(guides)):
        value = _climb(shown, t, node, sign, slope, dict(zip(guides, turned, strict=True)))
        if math.isnan(best) or sign * value > sign * best:
            best = value
    return best


def _kinds_of_tips(guides: int) -> Iterator[tuple[bool | None, ...]]:
    """For every guide whether to start at a tip where it is turned; None: where the slope says."""
    if guides <= MOST_GUIDES:
        yield from itertools.product((False, True), repeat=guides)
    else:
        yield (None,) * guides


def _climb(
    shown: Displaced, t: float, node: np.ndarray, sign: float, slope: np.ndarray, turned: dict[int, bool | None]
) -> float:
    """The extreme that is reached from one choice of tips."""
    best, at = math.nan, np.zeros_like(slope)
    for _ in range(ROUNDS):
        places = zip(shown.joints, slope, strict=True)
        e = np.array([_corner(joint, sign * y, turned.get(k)) for k, (joint, y) in enumerate(places)])
        value = shown.value(t, node, e)
        if math.isnan(value) or sign * value <= sign * best:
            break
        small = sign * (value - best) <= 1e-12 * (abs(best) + 1e-12)
        best, at = value, e
        if small:
            break
        slope = shown.gradient(t, node, e)
        if not np.isfinite(slope).all():
            return best
    if turned and not math.isnan(best):
        best = _along_sides(shown, t, node, sign, at, best, list(turned))
    return best


def _corner(joint: Joint, y: np.ndarray, turned: bool | None) -> np.ndarray:
    """Where y . e is largest for one joint; turned: at a tip of that kind."""
    if joint.kind != "prismatic":
        size = float(np.hypot(*y))
        return joint.clearance / size * y if size > 0.0 else np.zeros(2)
    most = largest_turn(joint)
    if turned is None:
        turned = most * abs(float(y[1])) > joint.clearance * abs(float(y[0]))
    if turned:
        return np.array([0.0, math.copysign(most, y[1])])
    return np.array([math.copysign(joint.clearance, y[0]), 0.0])


def _along_sides(
    shown: Displaced, t: float, node: np.ndarray, sign: float, e: np.ndarray, best: float, guides: list[int]
) -> float:
    """Go on along the curved sides of the guides where the slope at a tip leads there; pins follow."""
    for _ in range(ROUNDS):
        before = best
        slope = shown.gradient(t, node, e)
        if not np.isfinite(slope).all():
            return best
        for k in guides:
            found = _along_side(shown, t, node, sign, e, k, sign * slope[k])
            if found is not None and sign * found[0] > sign * best:
                best, e = found
        if best == before:
            return best
        slope = shown.gradient(t, node, e)
        moved = e.copy()
        for k, joint in enumerate(shown.joints):
            if k not in guides:
                moved[k] = _corner(joint, sign * slope[k], None)
        value = shown.value(t, node, moved)
        if sign * value > sign * best:
            best, e = value, moved
        if sign * (best - before) <= 1e-12 * (abs(best) + 1e-12):
            return best
    return best


def _along_side(
    shown: Displaced, t: float, node: np.ndarray, sign: float, e: np.ndarray, k: int, y: np.ndarray
) -> tuple[float, np.ndarray] | None:
    """The best place on the sides that one guide's place belongs to; None where the slope leads to none of them."""
    joint = shown.joints[k]
    if not joint.block:
        return None
    a, b, most = 0.5 * joint.block[0], 0.5 * joint.block[1], largest_turn(joint)
    across = math.copysign(1.0, e[k, 0]) if e[k, 0] != 0.0 else math.copysign(1.0, y[0])
    at = abs(float(e[k, 1]))
    side = math.copysign(1.0, e[k, 1]) if at > 0.0 else math.copysign(1.0, y[1])
    climb = side * y[1] + across * y[0] * (b * math.sin(at) - a * math.cos(at))  # along growing |theta|
    if (at == 0.0 and climb <= 0.0) or (at >= most * (1.0 - 1e-12) and climb >= 0.0):
        return None

    def placed(turn: float) -> np.ndarray:
        moved = e.copy()
        moved[k] = across * room(joint, turn), side * turn
        return moved

    low, high = 0.0, most
    one, two = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    f_one, f_two = (sign * shown.value(t, node, placed(turn)) for turn in (one, two))
    while high - low > 1e-7 * most:  # the output is flat at its extreme: its error is the square of this
        if f_one > f_two:
            high, two, f_two = two, one, f_one
            one = high - GOLDEN * (high - low)
            f_one = sign * shown.value(t, node, placed(one))
        else:
            low, one, f_one = one, two, f_two
            two = low + GOLDEN * (high - low)
            f_two = sign * shown.value(t, node, placed(two))
    turn = one if f_one > f_two else two
    value = sign * max(f_one, f_two)
    return (value, placed(turn)) if math.isfinite(value) else None
