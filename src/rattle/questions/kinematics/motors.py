"""Motors in place of drivers: the joint that does the work of a driver, and where it cannot."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rattle import registry
from rattle.equations.system import System
from rattle.errors import InputError, suggest
from rattle.questions.kinematics.sweep import Sweep
from rattle.results.columns import width


def motors_at(system: System, effort_at: str | Mapping[str, str] | None) -> list[tuple[int, str]]:
    """(constraint row of the driver, joint) for every driver whose work is done by a motor at another joint."""
    if effort_at is None:
        return []
    drivers, joints = list(system.model.drivers), system.model.joints
    if isinstance(effort_at, str):
        if len(drivers) != 1:
            raise InputError(f"effort_at: give the driver that is replaced, as {{'{drivers[0]}': '{effort_at}'}}")
        effort_at = {drivers[0]: effort_at}
    motors = []
    for driver, joint in effort_at.items():
        if driver not in drivers:
            raise InputError(f"effort_at: no driver '{driver}'{suggest(driver, drivers)}")
        if joint not in joints:
            raise InputError(f"effort_at: no joint '{joint}'{suggest(joint, joints)}")
        if joints[joint].leaf.motor is None:
            kinds = " or ".join(name for name, kind in registry.kinds("joint").items() if kind.leaf.motor)
            raise InputError(
                f"effort_at: a {joints[joint].kind} joint has no degree of freedom for a motor; expected {kinds}"
            )
        motors.append((system.first_row(driver), joint))
    if len({joint for _, joint in motors}) < len(motors):
        raise InputError("effort_at: one joint cannot do the work of two drivers")
    return motors


def without_effort(sweep: Sweep, t: np.ndarray, raw: np.ndarray, motors: list[tuple[int, str]]) -> list[str]:
    """A note for every motor that cannot do the work of its driver at some instants: how many, and when."""
    notes = []
    for n, (row, joint) in enumerate(motors):
        dead = ~np.isfinite(raw[:, width(sweep.system) + 2 * n])
        if dead.any():
            listed = ", ".join(f"{instant:.6g}" for instant in t[dead][:4]) + (" ..." if dead.sum() > 4 else "")
            effort = sweep.system.model.joints[joint].motor.effort
            notes.append(
                f"{joint}.{effort}: none at {int(dead.sum())} of {len(t)} instants (t = {listed} s): '{joint}' is at a"
                f" dead centre there, where no effort of it does the work of driver '{sweep.system.rows[row].owner}';"
                " forces and efforts are nan at these instants and grow without bound next to them"
            )
    return notes
