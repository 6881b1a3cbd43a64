"""Bodies placed by their joints, from the ground outwards: positions from angles."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rattle.description.model import Joint, Model, driven_ends
from rattle.equations.motion import drive
from rattle.equations.placement import turned
from rattle.equations.start_near import ABOUT_POINT, ALONG_LINE, FIXED
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace


def outward(model: Model, islands: bool = False) -> list[tuple[str, str, Joint]]:
    """(body, its parent, joint between them) from the ground outwards: bodies behind few loose joints first, then few.

    A joint is loose if it does not determine the position of B: one with clearance, a line to slide along, a rod.
    islands: and then from bodies outwards that no joints lead to; these have no parent, and stand where they are given.
    """
    driven = {driver.joint for driver in model.drivers.values()}
    near: dict[str, list[Joint]] = {}
    for joint in model.joints.values():
        if joint.leaf.places:
            near.setdefault(joint.a.body, []).append(joint)
            near.setdefault(joint.b.body, []).append(joint)
    order: list[tuple[str, str, Joint]] = []
    done = set()
    number = itertools.count()
    queue: list[Any] = [(0, 0, next(number), "ground", "", None)]
    roots = _places_given_first(model) if islands else []
    while True:
        if not queue:
            root = next((body for body in roots if body not in done), None)
            if root is None:
                return order
            queue.append((0, 0, next(number), root, "", None))
        slack, depth, _, body, parent, via = heapq.heappop(queue)
        if body in done:
            continue
        done.add(body)
        if via is not None:
            order.append((body, parent, via))
        for joint in near.get(body, ()):
            other = joint.b.body if joint.a.body == body else joint.a.body
            if other not in done:
                loose = joint.contact is not None and not joint.contact.closed
                loose |= joint.name not in driven and leaves_place(joint)
                heapq.heappush(queue, (slack + loose, depth + 1, next(number), other, body, joint))


def ways_outward(system: System, islands: bool = False) -> list[tuple[str, str, Joint]]:
    """`outward` of a system."""
    joints = system.model.joints
    found = system.fact(
        ("outward", islands), lambda: [(body, parent, one.name) for body, parent, one in outward(system.model, islands)]
    )
    return [(body, parent, joints[name]) for body, parent, name in found]


def _places_given_first(model: Model) -> list[str]:
    """Bodies, those first of which x and y are given."""
    return sorted(model.bodies, key=lambda body: -len({"x", "y"} & model.initial.bodies.get(body, {}).keys()))


def leaves_place(joint: Joint) -> bool:
    """True if the joint, even without clearance, does not determine the position of its B on its A."""
    return joint.line is not None or joint.distance > 0.0


def passed_angles(model: Model, functions: dict[str, float]) -> tuple[dict[str, float], list[str]]:
    """Angle [rad] of every body: given, passed on by joints that fix it, or else of a start near by, or 0.

    And the bodies that have neither of the first two.

    functions: value of every driver's function [rad or m].
    """
    angles = {name: values["angle"] for name, values in model.initial.bodies.items() if "angle" in values}
    angles["ground"] = 0.0
    passed: list[tuple[str, str, float]] = []
    for joint in model.joints.values():
        if joint.kept_angle is not None:
            passed.append((joint.a.body, joint.b.body, joint.kept_angle))
    for name, driver in model.drivers.items():
        if driver.sets_angle:
            a, b, _ = driven_ends(model, driver)
            passed.append((a.body, b.body, functions[name]))
    for _ in range(len(passed)):
        for one, other, angle in passed:
            if one in angles and other not in angles:
                angles[other] = angles[one] + angle
            elif other in angles and one not in angles:
                angles[one] = angles[other] - angle
    free = [name for name in model.bodies if name not in angles]
    near = model.initial.near
    return {**{name: near[name][2] if name in near else 0.0 for name in free}, **angles}, free


def place_positions(
    system: System, angles: dict[str, float], offsets: Mapping[str, Any], functions: dict[str, float]
) -> np.ndarray:
    """Positions (3 nb,) [m, m, rad] with given angles [rad] and offsets of joints [m], from the ground outwards.

    functions: value of every driver's function [rad or m].  Given x and y of bodies are kept.
    """
    model = system.model
    at: dict[str, np.ndarray] = {"ground": np.zeros(2)}
    driven = {driver.joint: name for name, driver in model.drivers.items() if driver.joint}
    given = {
        name: np.array([one.get("x", math.nan), one.get("y", math.nan)]) for name, one in model.initial.bodies.items()
    }
    for body, parent, joint in ways_outward(system, islands=True):
        if parent not in at:
            at[parent] = np.nan_to_num(given.get(parent, np.zeros(2)))
        wanted = given.get(body, np.full(2, math.nan))
        arm_a, arm_b = turned(angles[joint.a.body], joint.a.at), turned(angles[joint.b.body], joint.b.at)
        gap = np.array(offsets.get(joint.name, (0.0, 0.0)))  # point of B minus point of A
        sign = 1.0 if body == joint.b.body else -1.0
        own, other = (arm_b, arm_a) if body == joint.b.body else (arm_a, arm_b)
        if joint.line is not None:
            axis = angles[joint.a.body] + joint.line
            u = np.array([math.cos(axis), math.sin(axis)])
            where = wanted + own - at[parent] - other
            known = ~np.isnan(wanted)
            if known.all():
                along = float(u @ where) * sign
            elif known.any() and abs(u[known][0]) > 1e-6:
                along = float(where[known][0] / u[known][0]) * sign
            else:
                along = _out_of_cams(model, at, angles, body, at[parent] + other - own, sign * u)
            gap = u * (functions[driven[joint.name]] if joint.name in driven else along)
        elif joint.distance > 0.0:
            where = (wanted + own - at[parent] - other) * sign
            distance = float(np.hypot(*where))
            gap = joint.distance * (where / distance if distance > 0.0 else np.array([0.0, -1.0]))
        place_at = at[parent] + other + sign * gap - own
        at[body] = np.where(np.isnan(wanted), place_at, wanted)
    q = np.zeros(3 * system.body_count)
    for n, name in enumerate(system.bodies):
        x, y = at[name] if name in at else np.nan_to_num(given.get(name, np.zeros(2)))
        q[3 * n : 3 * n + 3] = x, y, angles[name]
    return q


def _out_of_cams(
    model: Model, at: Mapping[str, np.ndarray], angles: Mapping[str, float], body: str, start: np.ndarray, u: np.ndarray
) -> float:
    """Travel [m] along u at which a body that slides is out of the cam that it follows; 0 if it begins outside.

    start: (2,) its position [m] without travel.  Near the centre of a cam no row says which way is out.
    """
    for joint in model.joints.values():
        own, other = (joint.a, joint.b) if joint.a.body == body else (joint.b, joint.a)
        if joint.leaf.places or joint.distance <= 0.0 or own.body != body or other.body not in at:
            continue
        arm = start + turned(angles[body], own.at) - at[other.body] - turned(angles[other.body], other.at)
        inside, ahead = joint.distance**2 - float(arm @ arm), float(arm @ u)
        if inside > 0.0:
            return math.sqrt(ahead * ahead + inside) - ahead
    return 0.0


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


def first_guess(system: System, t: float = 0.0) -> np.ndarray:
    """Positions (3 nb,) [m, m, rad] at time t [s] with which the search for closed ones begins."""
    functions = driver_functions(system, t)
    return place_positions(system, passed_angles(system.model, functions)[0], system.model.initial.offsets, functions)


def ways_of_kernels(system: System) -> np.ndarray:
    """`ways_outward` as `equations.start_near` reads them (n, 6)."""

    def find() -> np.ndarray:
        number = {name: n for n, name in enumerate(("ground", *system.bodies))}
        first = dict(zip(system.joints, system.arrays["joint"][:, at.FIRST_P].tolist(), strict=True))
        ways = [
            (*(number[name] for name in (body, parent, joint.a.body, joint.b.body)), first[joint.name], free(joint))
            for body, parent, joint in ways_outward(system)
        ]
        return np.array(ways, dtype=np.int64).reshape(-1, 6)

    def free(joint: Joint) -> int:
        return FIXED if not leaves_place(joint) else ALONG_LINE if joint.line is not None else ABOUT_POINT

    return system.fact("ways of kernels", find)
