"""Friction of joints without play as flat arrays: the row of the free coordinate, the normal force, the law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rattle import registry
from rattle.description.model import Model, before_function
from rattle.jit import layout as at


def friction_table(
    model: Model, number: Mapping[str, int], values: list[float], joints: Sequence[Sequence[int]], states: int
) -> list[tuple[int, ...]]:
    """One entry per joint without play that has friction, see `layout`; parameters are appended to `values`.

    number: of every body; joints: their entries in the array `joint`; states: of elements before these.
    """
    found: list[tuple[int, ...]] = []
    for n, joint in enumerate(model.joints.values()):
        friction, motor = joint.friction, joint.leaf.motor
        if friction is None:
            continue
        kernel, place = len(registry.kinds("joint")), len(values)
        line: tuple[float, ...] = ()
        if joint.leaf.tangent:
            kernel += len(registry.kinds("driver")) + registry.kinds("tangent")[joint.leaf.tangent].tag
        else:
            driver = registry.kinds("driver")[motor.driver]
            kernel, line = kernel + driver.tag, before_function(joint, driver)
        values += [*joint.a.at, *joint.b.at, *line, *[0.0] * (at.DRY_ARM - at.POINTS - len(line))]
        values += [friction.arm, friction.reach]
        law, own = -1, 0
        if friction.law is None:
            values += [friction.mu, friction.mu_static]
        else:
            kind = registry.kinds("friction")[friction.law.kind]
            law, own = kind.tag, kind.leaf.states
            values += kind.leaf.pack(friction.law.values)
        form = at.DRY_GUIDE if joint.line is not None else at.DRY_PIN
        form = at.DRY_SURFACE if joint.leaf.tangent else form
        a, b = number[joint.a.body], number[joint.b.body]
        first = joints[n][at.FIRST_ROW]
        second = first + min(1, len(joint.leaf.rows) - 1)
        found.append((n, a, b, kernel, place, first, form, law, states, own, second))
        states += own
    return found
