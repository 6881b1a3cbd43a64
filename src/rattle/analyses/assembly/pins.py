"""Pins of joints with play at the start: which are held at their offsets, which follow from reactions, and where."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from rattle.analyses.assembly.loop_map import loop_map
from rattle.analyses.assembly.rank import free_motions, scaled_rows
from rattle.analyses.assembly.start_values import given_values
from rattle.description.model import GROUND, Joint, Model
from rattle.equations import start_columns as of
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.equations.placement import point_at
from rattle.equations.system import System, is_link

NUDGE = 1e-5  # of differences, as a share of the mechanism's size
DETERMINED = 1e-6  # share of a nudge by which a pin may move in its bush that joints and given values place
NO_OFFSET = 1e-9  # clearances below which an offset is none: the pin is where it is pressed


def with_play(model: Model) -> tuple[list[str], list[str]]:
    """Joints that are massless links, and those whose contacts hold the mechanism together."""
    joints = model.joints.items()
    return [name for name, joint in joints if is_link(joint)], [
        name for name, joint in joints if holds_by_contacts(joint)
    ]


def holds_by_contacts(joint: Joint) -> bool:
    """True if its contacts hold the mechanism together."""
    return joint.is_loose and not joint.passing


def pressed(model: Model, links: Iterable[str]) -> list[str]:
    """Those of some massless links whose offset is not given."""
    offsets, joints = model.initial.offsets, model.joints
    return [name for name in links if math.hypot(*offsets.get(name, (0.0, 0.0))) < NO_OFFSET * joints[name].clearance]


def undetermined(system: System, t: float, q: np.ndarray, joints: dict[str, Joint]) -> list[str]:
    """Joints, of those with contacts, whose pins have an offset or are not where other joints and given values say.

    Surfaces that only push touch, unless an angle is given for their bodies too.
    q: (3 nb,) positions [m, m, rad] near the start, which is at t [s].
    """
    model = system.model
    without = [name for name in joints if name not in model.initial.offsets]
    if not without or system.row_count > LARGE:
        return list(joints)
    workspace = system.workspace()
    open_by(workspace, t, q, np.zeros_like(q))
    fixed = np.eye(len(q))[~np.isnan(given_values(system, 0))]
    motions = free_motions(np.vstack([scaled_rows(system, workspace), fixed]))
    motions = motions * (NUDGE * system.size * np.tile([1.0, 1.0, 1.0 / system.size], system.body_count))
    driven = {driver.joint for driver in model.drivers.values()}
    turning = {joint.b.body for joint in model.joints.values() if joint.name in driven} | {GROUND}
    return [
        name
        for name, joint in joints.items()
        if name not in without or _touches(model, joint, turning) or _moves(system, q, motions, joint)
    ]


def _touches(model: Model, joint: Joint, turning: set[str]) -> bool:
    """True for surfaces that only push, one of whose bodies has no angle; turning: bodies whose angles drivers set."""
    bodies = {joint.a.body, joint.b.body} - turning
    return joint.one_sided is not None and any("angle" not in model.initial.bodies.get(body, {}) for body in bodies)


def _moves(system: System, q: np.ndarray, motions: np.ndarray, joint: Joint) -> bool:
    """True if its pin moves in the bush with some of the small motions (f, 3 nb) from positions q (3 nb,)."""
    for motion in motions:
        ahead, back = (
            point_at(system, q + way * motion, joint.b) - point_at(system, q + way * motion, joint.a)
            for way in (1.0, -1.0)
        )
        if np.abs(ahead - back).max() > DETERMINED * NUDGE * system.size:
            return True
    return False


def play_arrays(
    system: System, shut: System, held: list[str], every: list[str], missing: list[str], ideal: bool
) -> dict[str, np.ndarray]:
    """Arrays of the start of a mechanism with play: which pins are held, and where.

    shut: the mechanism without play; ideal: whether its start is known.  every: pins that can be held, first those that
    are; missing: those whose offset follows from reactions.
    """
    joints, offsets, number = system.model.joints, system.model.initial.offsets, list(system.joints)
    form = loop_map(system).arrays["start_form"].copy()
    form[of.WITHOUT_PLAY], form[of.HELD] = ideal, len(held)
    form[of.LINKS] = any(is_link(joints[name]) for name in held)
    form[of.OFFSETS] = any(name in offsets for name in held)
    form[of.PINS] = any(joints[name].one_sided is None for name in every)
    return {
        "start_form": form,
        "start_held": np.array(pin_places(system, every), dtype=float).reshape(-1, 4),
        "start_missing": np.array([(every.index(x), number.index(x)) for x in missing], np.int64).reshape(-1, 2),
        "start_first": np.array([shut.first_row(x) for x in missing], np.int64),
        "start_pressed": np.array([(joints[x].clearance, 0.0, 0.0) for x in missing], dtype=float).reshape(-1, 3),
    }


def pin_places(system: System, names: Iterable[str]) -> list[tuple[float, ...]]:
    """Of some joints: their point on A, and the offset of the pin, given or 0 [m]."""
    joints, offsets = system.model.joints, system.model.initial.offsets
    return [(*joints[name].a.at, *offsets.get(name, (0.0, 0.0))) for name in names]


def held_pins(system: System, closed: System, held: list[str]) -> np.ndarray:
    """`start_pins` of the mechanism with these joints closed: bushes that are moved, those of their drivers too."""
    model, number = system.model, {name: n for n, name in enumerate((GROUND, *system.bodies))}
    pins = [
        (number[model.joints[name].a.body], closed.first_value(owner), n)
        for n, name in enumerate(held)
        for owner in (name, *(key for key, driver in model.drivers.items() if driver.joint == name))
    ]  # both begin with the point on A
    return np.array(pins, np.int64).reshape(-1, 3)
