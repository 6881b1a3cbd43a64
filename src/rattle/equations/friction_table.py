"""Friction of joints without play as flat arrays: the row of the free coordinate, the normal force, the law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rattle import registry
from rattle.description.model import Joint, Model, before_function
from rattle.jit import layout as at


def friction_table(
    model: Model, number: Mapping[str, int], values: list[float], joints: Sequence[Sequence[int]],
    contacts: Sequence[Sequence[int]],
) -> list[tuple[int, ...]]:  # fmt: skip
    """One entry per joint without play that has friction, two of a rod, see `layout`; parameters go to `values`.

    number: of every body; joints, contacts: their entries in the arrays of these names.
    """
    states = sum(entry[at.STATES] for entry in contacts)
    owners = [entry[at.OWNER] for entry in contacts]
    table: list[tuple[int, ...]] = []
    for n, joint in enumerate(model.joints.values()):
        friction = joint.friction
        if friction is None:
            continue
        a, b, first = number[joint.a.body], number[joint.b.body], joints[n][at.FIRST_ROW]
        second = first + min(1, len(joint.rows) - 1)
        form, rods = _form(joint), len(table)
        for pin, (kernel, line) in enumerate(_rows(joint)):
            place = len(values)
            values += [*joint.a.at, *joint.b.at, *line, *[0.0] * (at.DRY_ARM - at.POINTS - len(line))]
            values += [friction.arm, friction.reach]
            law, own = -1, 0
            if friction.law is None:
                values += [friction.mu, friction.mu_static]
            else:
                kind = registry.kinds("friction")[friction.law.kind]
                law, own = kind.tag, kind.leaf.states
                values += kind.leaf.pack(friction.law.values)
            by = rods + 1 - pin if form == at.DRY_ROD else second
            column = at.JOINT_TANGENT if pin == 0 else at.JOINT_NORMAL
            if form == at.DRY_ROLLER:
                by, column = owners.index(n), at.EFFORT
            table.append((n, a, b, kernel, place, first, form, law, states, own, by, column, int(friction.stated)))
            states += own
    return table


def _form(joint: Joint) -> int:
    """How the normal force follows from what the joint bears."""
    if joint.leaf.touches:
        return at.DRY_ROLLER
    if joint.leaf.tangents:
        return at.DRY_ROD if len(joint.leaf.tangents) > 1 else at.DRY_SURFACE
    return at.DRY_GUIDE if joint.line is not None else at.DRY_PIN


def _rows(joint: Joint) -> list[tuple[int, tuple[float, ...]]]:
    """Kernels of the rows along which a joint rubs, and what these take after its points."""
    first = len(registry.kinds("joint"))
    if not joint.leaf.tangents:
        driver = registry.kinds("driver")[joint.motor.driver]
        return [(first + driver.tag, before_function(joint, driver))]
    tangents = registry.kinds("tangent")
    return [(first + len(registry.kinds("driver")) + tangents[name].tag, ()) for name in joint.leaf.tangents]
