"""Motions of an assembly as drivers: the angle of marker J relative to marker I about the z axis of I, or its z in I.

With alpha, s as in `joints`:  phi_q - phi_p = s (theta(t)) + alpha_I - alpha_J + 2 pi k, with the k of the position
drawn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rattle.exchange.asmt.assembly import GROUND, Assembly, Joint, Motion
from rattle.exchange.asmt.joints import Bodies, sense
from rattle.exchange.asmt.motion_text import MotionTextError, model_expression
from rattle.exchange.asmt.plane import Plane, slides
from rattle.exchange.asmt.space import column
from rattle.exchange.refusal import refused
from rattle.language.expression import ExpressionError, Number, parse, replaced, value

SMALL = 1e-14  # [rad]: an offset of rounding is none


def driver_entry(
    assembly: Assembly, plane: Plane, motion: Motion, joints: Sequence[str], flat: Bodies, bodies: Sequence[str]
) -> dict[str, Any] | None:
    """The table of a driver; None for a motion that holds nothing.  joints, bodies: their names in the model.

    Raises ModelError for a motion that the mechanism does not have in the plane.
    """
    if motion.kind == "AllowRotation":
        return None
    expression, at_start = _expression(assembly, motion)
    if motion.kind == "TranslationalMotion":
        if motion.joint < 0 or not slides(assembly.joints[motion.joint], assembly, plane):
            raise refused(assembly.file, f"motion {motion.name}: it slides what cannot slide in the plane", motion.line)
        return {"joint": joints[motion.joint], "position": expression}
    index = motion.joint if motion.joint >= 0 else _joint_between(assembly, motion, plane)
    if index is not None and not _turns(assembly.joints[index], assembly, plane):
        fault = f"motion {motion.name}: it turns a joint that cannot turn in the plane"
        raise refused(assembly.file, fault, motion.line)
    a, b = flat(motion.i.part), flat(motion.j.part)
    s = sense(a, motion.i)
    offset = a.direction(column(motion.i.frame.axes, 0)) - b.direction(column(motion.j.frame.axes, 0))
    if index is not None:
        turns = round((b.angle - a.angle - offset - s * at_start) / math.tau)
        forward = 1.0 if assembly.joints[index].i.part == motion.i.part else -1.0
        angle = _with_offset(expression, forward * s, forward * (offset + math.tau * turns))
        return {"joint": joints[index], "angle": angle}
    if GROUND not in (motion.i.part, motion.j.part):
        fault = f"motion {motion.name}: it turns two parts that no joint holds together"
        raise refused(assembly.file, fault, motion.line)
    return _body_angle(motion, (s, offset, at_start), expression, flat, bodies)


def _body_angle(
    motion: Motion, numbers: tuple[float, float, float], expression: str, flat: Bodies, bodies: Sequence[str]
) -> dict[str, Any]:
    """A body that is turned in the ground, without a joint there."""
    s, offset, at_start = numbers
    moved = motion.j.part if motion.i.part == GROUND else motion.i.part
    sign = 1.0 if moved == motion.j.part else -1.0
    base = flat(GROUND).angle + sign * offset
    turns = round((flat(moved).angle - base - sign * s * at_start) / math.tau)
    angle = _with_offset(expression, sign * s, base + math.tau * turns)
    return {"body": bodies[moved], "coordinate": "angle", "angle": angle}


def _turns(joint: Joint, assembly: Assembly, plane: Plane) -> bool:
    """True of a joint that turns about a normal of the plane."""
    return joint.kind in ("RevoluteJoint", "CylindricalJoint") and not slides(joint, assembly, plane)


def _joint_between(assembly: Assembly, motion: Motion, plane: Plane) -> int | None:
    """The joint in which the two parts turn that a motion names by markers; None if there is none."""
    parts = {motion.i.part, motion.j.part}
    for n, joint in enumerate(assembly.joints):
        if {joint.i.part, joint.j.part} == parts and _turns(joint, assembly, plane):
            return n
    return None


def _expression(assembly: Assembly, motion: Motion) -> tuple[str, float]:
    """A motion over t, and its value at t = 0."""
    of = f"motion {motion.name}: "
    try:
        text = model_expression(motion.expression, assembly.times[0])
        node = parse(text)
        return text, value(replaced(node, {"t": Number(0.0, 0)}), {})
    except (MotionTextError, ExpressionError) as error:
        raise refused(assembly.file, of + str(error), motion.line) from None


def _with_offset(expression: str, sign: float, offset: float) -> str:
    """offset + sign * expression."""
    plain = expression if sign > 0.0 else f"-({expression})"
    if abs(offset) < SMALL:
        return plain
    return f"{offset!r} {'+' if sign > 0.0 else '-'} ({expression})"
