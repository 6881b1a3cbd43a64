"""What a result has to say about places that no row or contact holds.

Joints of limited travel, such as slots, or with stops, where their ends are left out; gears whose centres move apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from rattle.description.coordinates import COINCIDENT
from rattle.description.model import Joint, Model, Point
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.results.display import quantity

BEYOND = 1e-9  # share of a travel, or of the size or 1 rad beside it, by which rounding may pass an end
UNFIT = 1e-4  # share of the distance that a joint needs by which another one is noted
PARTS = 8  # of an interval between two instants, in which a coordinate is followed


def places(system: System, raw: np.ndarray) -> np.ndarray:
    """Positions (n, nb, 3) [m, m, rad] of all bodies, a view of output rows (n, width); see `results.columns`."""
    rows = raw[:, : at.PER_BODY * system.body_count].reshape(len(raw), system.body_count, at.PER_BODY)
    return rows[:, :, at.PLACE : at.PLACE + 3]


def rates(system: System, raw: np.ndarray) -> np.ndarray:
    """Rates (n, nb, 3) [m/s, m/s, rad/s] of all bodies, a view of output rows (n, width)."""
    rows = raw[:, : at.PER_BODY * system.body_count].reshape(len(raw), system.body_count, at.PER_BODY)
    return rows[:, :, at.RATE : at.RATE + 3]


def out_of_place(system: System, t: np.ndarray, q: np.ndarray) -> tuple[str, ...]:
    """Notes on joints of doubtful fields, or whose points are where they should not be, which the model does not hold.

    t: (n,) [s].  q: (n, nb, 3) [m, m, rad] positions of all bodies.
    """
    return (
        *(f"joint '{name}': {doubt}" for name, doubt in doubts_of_fields(system.model)),
        *past_ends(system, t, q),
        *unfit(system, t, q),
    )


def doubts_of_fields(model: Model) -> Iterator[tuple[str, str]]:
    """Joints of doubtful fields, and what is doubtful, in words."""
    doubts = ((name, joint.leaf.doubt(joint.fields)) for name, joint in model.joints.items())
    return (pair for pair in doubts if pair[1])


def fits(system: System, q: np.ndarray) -> Iterator[tuple[str, Joint, Any, np.ndarray]]:
    """Joints whose points have to be at a distance that no row holds, their `Fit`, and their distances (n,) [m]."""
    for name, joint in system.model.joints.items():
        fit = joint.leaf.fit(joint.fields)
        if fit is None:
            continue
        (ax, ay, turned), (bx, by, _) = (_path(system, q, point) for point in (joint.a, joint.b))
        if fit.line is None:
            yield name, joint, fit, np.hypot(bx - ax, by - ay)
        else:
            axis = turned + fit.line
            yield name, joint, fit, (bx - ax) * np.sin(axis) - (by - ay) * np.cos(axis)


def distance_of(system: System, q: np.ndarray, joint: Joint) -> np.ndarray:
    """Distance (n,) [m] of the two points of a joint at positions q (n, nb, 3)."""
    (ax, ay, _), (bx, by, _) = (_path(system, q, point) for point in (joint.a, joint.b))
    apart: np.ndarray = np.hypot(bx - ax, by - ay)
    return apart


def unfit(system: System, t: np.ndarray, q: np.ndarray) -> tuple[str, ...]:
    """Notes on joints whose points are not at the distance that they need: t (n,) [s], q (n, nb, 3) [m, m, rad]."""
    notes = []
    for name, _, fit, distance in fits(system, q):
        off = fit.missed(distance)
        apart = np.flatnonzero(off > UNFIT * abs(fit.distance))
        if len(apart):
            k = int(np.nanargmax(off))
            needed, there = (f"{length:.6g} m" for length in (fit.distance, float(distance[k])))
            notes.append(
                f"joint '{name}': {fit.why.format(needed)}; it is {there} at t = {float(t[k]):.4g} s. Nothing holds it,"
                f" and the joint acts as if it were right (first at t = {float(t[apart[0]]):.4g} s)"
            )
    return tuple(notes)


def past_ends(system: System, t: np.ndarray, q: np.ndarray) -> tuple[str, ...]:
    """Notes on joints without contacts whose point has gone farther than their travel.

    t: (n,) [s].  q: (n, nb, 3) [m, m, rad] positions of all bodies.  A joint without contacts has no ends.
    """
    notes = []
    for name, joint in system.model.joints.items():
        travel = joint.leaf.travel(joint.fields)
        if not math.isfinite(travel) or joint.line is None or joint.is_loose:
            continue
        (ax, ay, turned), (bx, by, _) = (_path(system, q, point) for point in (joint.a, joint.b))
        axis = turned + joint.line
        along = np.abs((bx - ax) * np.cos(axis) + (by - ay) * np.sin(axis))
        beyond = np.flatnonzero(along > travel * (1.0 + BEYOND))
        if len(beyond):
            notes.append(
                f"joint '{name}' goes beyond its ends, by up to {float(np.nanmax(along)) - travel:.3g} m, first at"
                f" t = {float(t[beyond[0]]):.4g} s: without contacts it has none; a run with a clearance and a contact"
                " there has them"
            )
    return tuple(notes)


def without_stops(model: Model) -> Model:
    """The same mechanism without stops."""
    return replace(model, joints={name: replace(joint, stop=None) for name, joint in model.joints.items()})


def past_stops(system: System, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> tuple[str, ...]:
    """Notes on joints whose coordinate goes beyond a stop, which acts in a run in time only.

    t: (n,) [s].  q, v: (n, nb, 3) positions [m, m, rad] of all bodies and their rates.  Between instants the coordinate
    is the cubic with its rates.
    """
    notes = []
    for name, joint in system.model.joints.items():
        if joint.stop is None or not len(t):
            continue
        x, rate = _coordinate(system, joint, q, v)
        fine, values = followed(t, x, rate)
        for sense, end in ((1.0, joint.stop.minimum), (-1.0, joint.stop.maximum)):
            slight = BEYOND * (abs(end) + 1.0 if joint.stops_angle else abs(end) + system.size)
            depth, since = farthest(fine, sense * (end - values), slight) if math.isfinite(end) else (0.0, 0.0)
            if depth == 0.0:
                continue
            word = "min" if sense > 0.0 else "max"
            far = f"{math.degrees(depth):.3g} deg" if joint.stops_angle else f"{depth:.3g} m"
            notes.append(
                f"joint '{name}' goes beyond its stop ({word}), by up to {far}, first at t = {since:.4g} s: stops"
                " act in runs in time and in equilibria only"
            )
    return tuple(notes)


def farthest(t: np.ndarray, beyond: np.ndarray, slight: float) -> tuple[float, float]:
    """The largest of values (n,) at t (n,) and when they first pass zero [s]; zeros if none is more than `slight`."""
    if not (beyond > slight).any():
        return 0.0, 0.0
    first = int(np.argmax(beyond > slight))
    since = float(t[first])
    if first > 0 and beyond[first - 1] < 0.0:
        since -= float((t[first] - t[first - 1]) * beyond[first] / (beyond[first] - beyond[first - 1]))
    return float(np.nanmax(beyond)), since


def followed(t: np.ndarray, x: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Instants [s] and values between those given, (n,) each, by the cubics with these rates."""
    h, s = np.diff(t)[:, None], np.arange(PARTS) / PARTS
    left, right = x[:-1, None], x[1:, None]
    a, b = rate[:-1, None] * h - (right - left), (right - left) - rate[1:, None] * h
    values = (1.0 - s) * left + s * right + s * (1.0 - s) * ((1.0 - s) * a + s * b)
    return np.append((t[:-1, None] + s * h).ravel(), t[-1]), np.append(values.ravel(), x[-1])


def _coordinate(system: System, joint: Joint, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The coordinate of a joint (n,) [m or rad] and its rate."""
    (ax, ay, a), (bx, by, b) = (_path(system, q, point) for point in (joint.a, joint.b))
    (avx, avy, aw), (bvx, bvy, bw) = (_speed(system, q, v, point) for point in (joint.a, joint.b))
    if joint.held_by_stops:
        length = np.hypot(bx - ax, by - ay)
        return length, ((bx - ax) * (bvx - avx) + (by - ay) * (bvy - avy)) / np.maximum(length, COINCIDENT)
    if joint.line is None:
        return b - a, bw - aw
    c, s = np.cos(a + joint.line), np.sin(a + joint.line)
    across = c * (by - ay) - s * (bx - ax)
    return c * (bx - ax) + s * (by - ay), c * (bvx - avx) + s * (bvy - avy) + aw * across


def _speed(system: System, q: np.ndarray, v: np.ndarray, point: Point) -> np.ndarray:
    """Velocity of a point of a body, or of the ground, and rate of the angle of the body: (3, n) [m/s, m/s, rad/s]."""
    if point.body == "ground":
        return np.zeros((3, len(q)))
    vx, vy, w = v[:, system.bodies.index(point.body)].T
    angle = q[:, system.bodies.index(point.body), 2]
    c, s = np.cos(angle), np.sin(angle)
    px, py = point.at
    return np.array([vx - w * (s * px + c * py), vy + w * (c * px - s * py), w])


def _path(system: System, q: np.ndarray, point: Point) -> np.ndarray:
    """Place of a point of a body, or of the ground, and angle of the body: (3, n) [m, m, rad]."""
    px, py = point.at
    if point.body == "ground":
        return np.tile([[px], [py], [0.0]], len(q))
    x, y, angle = q[:, system.bodies.index(point.body)].T
    c, s = np.cos(angle), np.sin(angle)
    return np.array([x + c * px - s * py, y + s * px + c * py, angle])


def with_ends(model: Model) -> str:
    """Names of the joints of limited travel, in quotes; "" if there are none."""
    return ", ".join(
        f"'{name}'" for name, joint in model.joints.items() if math.isfinite(joint.leaf.travel(joint.fields))
    )


def with_stops(model: Model) -> str:
    """Names of the joints with stops, in quotes; "" if there are none."""
    return ", ".join(f"'{name}'" for name, joint in model.joints.items() if joint.stop is not None)


def with_friction(model: Model) -> str:
    """Names of the joints whose own friction holds at rest, in quotes; "" if there are none."""
    rubbing = (
        name
        for name, joint in model.joints.items()
        if (joint.friction and joint.friction.law is None)
        or (joint.leaf.touches and joint.contact is not None and joint.contact.rigid and joint.contact.mu > 0.0)
    )
    return ", ".join(f"'{name}'" for name in rubbing)


def stop_lines(model: Model) -> list[str]:
    """The stops of every joint that has them, in words."""
    lines = []
    for name, joint in model.joints.items():
        if joint.stop is None:
            continue
        unit = ("rad", "deg") if joint.stops_angle else ("m", "m")
        ends = (("from", joint.stop.minimum), ("to", joint.stop.maximum))
        limits = " ".join(f"{word} {quantity(end, unit[0], 6, unit[1])}" for word, end in ends if math.isfinite(end))
        alone = ", no row: free between its ends" if joint.held_by_stops else ""
        lines.append(f"{name} {limits}, {joint.stop.contact.title}{alone}")
    return lines


def left_out(model: Model) -> str:
    """What an equilibrium leaves out: the ends of joints of limited travel, and their play; "" if there are none."""
    names = with_ends(model)
    return f"the ends of {names} and the play there are left out" if names else ""
