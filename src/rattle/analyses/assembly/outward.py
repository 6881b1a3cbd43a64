"""The ways by joints from the ground outwards, along which bodies are placed."""

from __future__ import annotations

import heapq
import itertools
from typing import Any

from rattle.description.model import GROUND, Joint, Model, is_ground
from rattle.equations.system import System


def outward(model: Model, islands: bool = False) -> list[tuple[str, str, Joint]]:
    """(body, its parent, joint between them) from the ground outwards: bodies behind few loose joints first, then few.

    A joint is loose if it does not determine the position of B: one with clearance, a line to slide along, a rod.
    islands: and then from bodies outwards that no joints lead to; these have no parent, and stand where they are given.
    """
    driven = {driver.joint for driver in model.drivers.values()}
    near = _joints_of_bodies(model)
    order: list[tuple[str, str, Joint]] = []
    done = set()
    number = itertools.count()
    grounds = [GROUND, *(name for name in model.bodies if is_ground(name))]
    queue: list[Any] = [(0, 0, next(number), name, "", None) for name in grounds]
    far = len(model.joints) + 1  # more than any way is loose: what a root leads to comes before the next
    for n, root in enumerate(_places_given_first(model) if islands else [], 1):
        queue.append((n * far, 0, next(number), root, "", None))
    while queue:
        slack, depth, _, body, parent, via = heapq.heappop(queue)
        if body in done:
            continue
        done.add(body)
        if via is not None:
            order.append((body, parent, via))
        for joint in near.get(body, ()):
            other = joint.b.body if joint.a.body == body else joint.a.body
            if other not in done:
                loose = _is_open(joint) or (joint.name not in driven and leaves_place(joint))
                heapq.heappush(queue, (slack + loose, depth + 1, next(number), other, body, joint))
    return order


def _is_open(joint: Joint) -> bool:
    """True if it has a contact that is not closed from the start."""
    return joint.contact is not None and not joint.contact.closed


def _joints_of_bodies(model: Model) -> dict[str, list[Joint]]:
    """By body, the joints that place it or what hangs on it."""
    near: dict[str, list[Joint]] = {}
    for joint in model.joints.values():
        if joint.places:
            near.setdefault(joint.a.body, []).append(joint)
            near.setdefault(joint.b.body, []).append(joint)
    return near


def ways_outward(system: System, islands: bool = False) -> list[tuple[str, str, Joint]]:
    """`outward` of a system."""
    joints = system.model.joints
    ways = system.fact(
        ("outward", islands),
        lambda: [(body, parent, joint.name) for body, parent, joint in outward(system.model, islands)],
    )
    return [(body, parent, joints[name]) for body, parent, name in ways]


def _places_given_first(model: Model) -> list[str]:
    """Bodies, those first of which x and y are given."""
    return sorted(model.bodies, key=lambda body: -len({"x", "y"} & model.initial.bodies.get(body, {}).keys()))


def leaves_place(joint: Joint) -> bool:
    """True if the joint, even without clearance, does not determine the position of its B on its A."""
    return joint.line is not None or joint.distance > 0.0
