"""Bodies that turn together: tied by joints that fix their angles, and by drivers that set them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.start_values import given_values
from rattle.description.model import GROUND, Model, driven_ends
from rattle.equations.motion import drive
from rattle.equations.system import System
from rattle.jit.workspace import Workspace


class Tie(NamedTuple):
    """A body whose angle follows from that of another one."""

    to: str
    origin: str  # the body that it follows; "" for none
    joint: str  # that fixes the angle between them, or ""
    driver: str  # that sets it, or ""
    sign: int  # 1 where the angle is that of `to` relative to `origin`, -1 where it is the other way
    group: str  # the first body of those that turn together


def _ties(model: Model) -> Iterator[tuple[str, str, str, str]]:
    """(A, B, joint, driver) for all that says what angle B has relative to A."""
    for joint in model.joints.values():
        if joint.kept_angle is not None:
            yield joint.a.body, joint.b.body, joint.name, ""
    for name, driver in model.drivers.items():
        if driver.sets_angle:
            a, b, _ = driven_ends(model, driver)
            yield a.body, b.body, "", name


def tied_ways(model: Model) -> list[Tie]:
    """The ground and all bodies, groups one after the other; each follows one that stands before it."""
    near: dict[str, list[tuple[str, str, str, int]]] = {}
    for a, b, joint, driver in _ties(model):
        near.setdefault(a, []).append((b, joint, driver, 1))
        near.setdefault(b, []).append((a, joint, driver, -1))
    ties: dict[str, Tie] = {}
    for first in (GROUND, *model.bodies):
        if first in ties:
            continue
        ties[first], open_ = Tie(first, "", "", "", 1, first), [first]
        while open_:
            body = open_.pop()
            for other, joint, driver, sign in near.get(body, ()):
                if other not in ties:
                    ties[other] = Tie(other, body, joint, driver, sign, first)
                    open_.append(other)
    return list(ties.values())


def passed_ways(model: Model) -> tuple[list[Tie], list[str]]:
    """Bodies to which given angles, and that of the ground, are passed on, in this order; and those without one."""
    determined = {GROUND, *(name for name, values in model.initial.bodies.items() if "angle" in values)}
    ties, passed = list(_ties(model)), list[Tie]()
    for _ in range(len(ties)):
        for a, b, joint, driver in ties:
            if (a in determined) != (b in determined):
                to, origin, sign = (b, a, 1) if a in determined else (a, b, -1)
                passed.append(Tie(to, origin, joint, driver, sign, ""))
                determined.add(to)
    return passed, [name for name in model.bodies if name not in determined]


def groups(model: Model, functions: Mapping[str, float]) -> dict[str, tuple[str, float]]:
    """Of every body, and of the ground, the group that turns with it, and how far it is ahead of its group [rad].

    functions: value of every driver's function [rad or m].
    """
    turning: dict[str, tuple[str, float]] = {}
    for tie in tied_ways(model):
        ahead = 0.0
        if tie.origin:
            angle = functions[tie.driver] if tie.driver else model.joints[tie.joint].kept_angle
            ahead = turning[tie.origin][1] + tie.sign * (angle or 0.0)
        turning[tie.to] = tie.group, ahead
    return turning


def driver_functions(system: System, t: float, workspace: Workspace | None = None) -> dict[str, float]:
    """The value of every driver's function at t [s] [rad or m]; 0 where it has none.

    workspace: one in which they have been evaluated at t.
    """
    if not system.model.drivers:
        return {}
    if workspace is None:
        workspace = system.workspace()
        drive(workspace, t)
    values = {name: float(workspace.values[system.driver_slot(name)]) for name in system.model.drivers}
    return {name: value if math.isfinite(value) else 0.0 for name, value in values.items()}


def groups_at(system: System, t: float, workspace: Workspace | None = None) -> dict[str, tuple[str, float]]:
    """Of every body, and of the ground, the group that turns with it at t [s], and how far it is ahead of it [rad].

    workspace: one in which the functions of drivers have been evaluated at t.
    """
    return groups(system.model, driver_functions(system, t, workspace))


def given_in_one_turn(system: System, t: float, workspace: Workspace | None = None) -> np.ndarray:
    """(3 nb,) given positions [m, m, rad], nan if not given; angles of bodies that turn together are in one turn.

    It is that of the first of them, or that in which a driver holds them at t [s].  workspace: see `groups_at`.
    """
    wanted, tied = given_values(system, 0), groups_at(system, t, workspace)
    first, ahead = tied[GROUND]
    turns = {first: -ahead}
    for n, body in enumerate(system.bodies):
        angle = float(wanted[3 * n + 2])
        if math.isnan(angle):
            continue
        group, ahead = tied[body]
        kept = turns.setdefault(group, angle - ahead) + ahead
        wanted[3 * n + 2] += math.tau * round((kept - angle) / math.tau)
    return wanted
