"""Joints of limited travel, such as slots, where a model leaves their ends out: what a result has to say about that."""

from __future__ import annotations

import math

import numpy as np

from rattle.description.model import Model
from rattle.equations.system import System, has_contacts
from rattle.jit import layout as at


def past_ends(system: System, t: np.ndarray, raw: np.ndarray) -> tuple[str, ...]:
    """Notes on joints without contacts whose point has gone farther than their travel.

    t (n,) [s] and raw (n, width), see `results.columns`.  A joint without contacts has no ends.
    """
    notes = []
    first = at.PER_BODY * system.body_count
    for name, joint in system.model.joints.items():
        travel = joint.leaf.travel(joint.fields)
        if not math.isfinite(travel) or joint.line is None or has_contacts(joint) or not len(t):
            continue
        c = first + at.PER_JOINT * system.joints.index(name)
        turned: float | np.ndarray = 0.0
        if joint.a.body != "ground":
            turned = raw[:, at.PER_BODY * system.bodies.index(joint.a.body) + at.PLACE + 2]
        axis = turned + joint.line
        along = np.abs(raw[:, c + at.EX] * np.cos(axis) + raw[:, c + at.EY] * np.sin(axis))
        beyond = np.flatnonzero(along > travel * (1.0 + 1e-9))
        if len(beyond):
            notes.append(
                f"joint '{name}' goes beyond its ends, by up to {float(along.max()) - travel:.3g} m, first at"
                f" t = {float(t[beyond[0]]):.4g} s: without contacts it has none; give it a clearance and a contact"
            )
    return tuple(notes)


def left_out(model: Model) -> str:
    """What an equilibrium leaves out: the ends of joints of limited travel, and their play; "" if there are none."""
    names = [f"'{name}'" for name, one in model.joints.items() if math.isfinite(one.leaf.travel(one.fields))]
    if not names:
        return ""
    return f"the ends of {', '.join(names)} and the play there are left out: check that the pin stays inside"
