"""Joints of limited travel, such as slots, where a model leaves their ends out: what a result has to say about that."""

from __future__ import annotations

import math

import numpy as np

from rattle.description.model import Model, Point
from rattle.equations.system import System
from rattle.jit import layout as at


def places(system: System, raw: np.ndarray) -> np.ndarray:
    """Positions (n, nb, 3) [m, m, rad] of all bodies, a view of output rows (n, width); see `results.columns`."""
    rows = raw[:, : at.PER_BODY * system.body_count].reshape(len(raw), system.body_count, at.PER_BODY)
    return rows[:, :, at.PLACE : at.PLACE + 3]


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
        beyond = np.flatnonzero(along > travel * (1.0 + 1e-9))
        if len(beyond):
            notes.append(
                f"joint '{name}' goes beyond its ends, by up to {float(np.nanmax(along)) - travel:.3g} m, first at"
                f" t = {float(t[beyond[0]]):.4g} s: without contacts it has none; a run with a clearance and a contact"
                " there has them"
            )
    return tuple(notes)


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
    return ", ".join(f"'{name}'" for name, one in model.joints.items() if math.isfinite(one.leaf.travel(one.fields)))


def left_out(model: Model) -> str:
    """What an equilibrium leaves out: the ends of joints of limited travel, and their play; "" if there are none."""
    names = with_ends(model)
    return f"the ends of {names} and the play there are left out" if names else ""
