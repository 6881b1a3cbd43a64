"""Forces and couples of all elements on one body, each at the point at which it acts.

A port is a generalised force Q = (Fx, Fy, moment about the mass centre); at a point r from there it is the force F and
the couple  C = Q_phi - r x F.  The point is that of the element on the body; on body A of a joint with a line, and of
one whose bodies touch, it is that of B, which moves along the body.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.description.model import Joint, Vector
from rattle.questions.power.ports import GRAVITY, Ports
from rattle.questions.strength.known_motion import KnownMotion

Array = NDArray[np.float64]


class Wrench(NamedTuple):
    """What one element exerts on a body, in the directions of the ground."""

    element: str
    kind: str
    spot: Array  # (n, 2) where, from the mass centre of the body [m]
    force: Array  # (n, 2) [N]
    couple: Array  # (n,) [N m]
    fixed: Vector | None  # where in the frame of the body; None if that changes


def wrenches_on(motion: KnownMotion, body: str) -> list[Wrench]:
    """The forces of all elements but gravity on a body."""
    system = motion.system
    ports, number = Ports(system), 1 + system.bodies.index(body)
    centre = motion.place(body, (0.0, 0.0))
    acting = []
    for port in ports.list:
        element = ports.elements[port.element]
        if port.body != number or element.kind == GRAVITY:
            continue
        fixed, place = _where(motion, element.name, port.element, port.side, body)
        spot = place - centre
        generalised = motion.rows[:, port.column : port.column + 3]
        acting.append(_placed(element.name, element.kind, spot, generalised, fixed))
    return acting + _of_motors(motion, body, number)


def _placed(name: str, kind: str, spot: Array, generalised: Array, fixed: Vector | None) -> Wrench:
    """A generalised force (n, 3) at a spot."""
    force = generalised[:, :2]
    couple = generalised[:, 2] - (spot[:, 0] * force[:, 1] - spot[:, 1] * force[:, 0])
    return Wrench(name, kind, spot, force, couple, fixed)


def _where(motion: KnownMotion, name: str, element: int, side: int, body: str) -> tuple[Vector | None, Array]:
    """Where an element acts on body A (side 0) or B (side 1): in the frame of the body if it stays there; and (n, 2)

    where that is [m].
    """
    model = motion.system.model
    if element >= len(motion.system.joints):
        load = model.loads[name]
        fixed = load.b.at if side else load.a.at
        return fixed, motion.place(body, fixed)
    driver = model.drivers.get(name)
    if driver is not None and driver.point is not None:
        return driver.point.at, motion.place(body, driver.point.at)
    return at_joint(motion, model.joints[driver.joint if driver is not None else name], side, body)


def at_joint(motion: KnownMotion, joint: Joint, side: int, body: str) -> tuple[Vector | None, Array]:
    """The same of a joint."""
    touching = _touching_point(joint)
    if side == 1:
        return touching, motion.place(body, touching)
    if joint.line is None and not joint.leaf.touches:
        return joint.a.at, motion.place(body, joint.a.at)
    return None, motion.place(joint.b.body, touching)


def _touching_point(joint: Joint) -> Vector:
    """The point of B that its force goes through: where only one of its points can touch a surface, that one."""
    corners = list(joint.corners.values())
    return corners[0] if joint.leaf.touches and len(corners) == 1 else joint.b.at


def taken_together(motion: KnownMotion, body: str) -> list[str]:
    """Joints of a body that may touch at several points, whose forces are taken as one."""
    joints = motion.system.model.joints.values()
    return [
        joint.name
        for joint in joints
        if joint.leaf.touches and len(joint.corners) > 1 and body in (joint.a.body, joint.b.body)
    ]


def _of_motors(motion: KnownMotion, body: str, number: int) -> list[Wrench]:
    """What motors in place of drivers exert: a moment on B and back on A, or a force along the line of A."""
    acting = []
    for motor in motion.motors:
        joint = motion.system.model.joints[motor.joint]
        for side, end in enumerate((joint.a, joint.b)):
            if end.body != body:
                continue
            fixed, place = at_joint(motion, joint, side, body)
            sense = 1.0 if side else -1.0
            spot = place - motion.place(body, (0.0, 0.0))
            force, couple = sense * motor.force(motion), sense * motor.couple(motion)
            acting.append(Wrench(f"motor at {joint.name}", "motor", spot, force, couple, fixed))
    return acting
