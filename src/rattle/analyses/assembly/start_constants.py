"""Constants that the start sets, as of gears: their rows say how bodies go on from where they were put together.

The start of such a mechanism is found without these rows; the constant of each is then what makes it vanish there, and
belongs to the mechanism from then on.  Rates at the start do satisfy the rows.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from rattle.analyses.assembly.searching import first_guess
from rattle.analyses.travel import fits
from rattle.description.model import Model
from rattle.equations.closure import open_by
from rattle.equations.placement import point_at
from rattle.equations.system import System, compile_system
from rattle.errors import AssemblyError
from rattle.jit import layout as at

FITS = 1e-6  # share by which the distance may be missed that a joint cannot do without


def with_constants(model: Model, constants: Mapping[str, float | tuple[float, ...]]) -> Model:
    """The model with constants [m or rad] of what counts from the start; one number for all of a joint or driver."""
    joints, drivers = dict(model.joints), dict(model.drivers)
    for name, values in constants.items():
        count = joints[name].from_start if name in joints else drivers[name].leaf.from_start
        each = values if isinstance(values, tuple) else (values,) * count
        if name in joints:
            joints[name] = replace(joints[name], constants=each)
        else:
            drivers[name] = replace(drivers[name], constants=each)
    return replace(model, joints=joints, drivers=drivers)


def constants_of(model: Model) -> dict[str, tuple[float, ...]]:
    """Constants [m or rad] that the start of a model has set, by joint and driver."""
    joints = {name: joint.constants for name, joint in model.joints.items() if joint.from_start}
    return joints | {name: driver.constants for name, driver in model.drivers.items() if driver.leaf.from_start}


def flat(constants: Mapping[str, tuple[float, ...]]) -> list[float]:
    """All constants [m or rad] in the order of the joints and drivers."""
    return [value for each in constants.values() for value in each]


def without_counting(model: Model) -> Model:
    """The model without the rows that count from the start: what determines the positions there."""
    joints = {
        name: replace(joint, counts=False, constants=()) if joint.from_start else joint
        for name, joint in model.joints.items()
        if not joint.from_start or joint.leaf.placing
    }
    drivers = {name: driver for name, driver in model.drivers.items() if not driver.leaf.from_start}
    return replace(model, joints=joints, drivers=drivers)


def counting_rows(system: System) -> dict[str, range]:
    """The rows of every joint and driver that count from the start."""
    joints, drivers, rows = system.model.joints, system.model.drivers, {}
    for name in constants_of(system.model):
        first = system.first_row(name)
        if name in drivers:
            rows[name] = range(first, first + len(drivers[name].leaf.rows))
        else:
            rows[name] = range(first + joints[name].leaf.placing, first + len(joints[name].rows))
    return rows


def constants_at(system: System, q: np.ndarray) -> dict[str, tuple[float, ...]]:
    """Constants [m or rad], by joint and driver, with which its rows vanish at q (3 nb,) [m, m, rad].

    system: with all of these constants 0.
    """
    joints = system.model.joints
    if any(joint.from_start and joint.is_loose for joint in joints.values()):  # the rows that contacts stand for
        rows = {name: replace(joint, contact=None) if joint.from_start else joint for name, joint in joints.items()}
        system = compile_system(replace(system.model, joints=rows))
    workspace = system.workspace()
    open_by(workspace, 0.0, q, np.zeros_like(q))
    residual = workspace.rows[:, at.RES]
    constants = {}
    for name, counting in counting_rows(system).items():
        values = tuple(residual[counting.start : counting.stop].tolist())
        if name not in joints:
            constants[name] = values
            continue
        joint = joints[name]
        x, y = point_at(system, q, joint.b) - point_at(system, q, joint.a)
        constants[name] = joint.leaf.start_constants(values, (float(x), float(y)))
    return constants


def as_guessed(model: Model) -> tuple[System, np.ndarray]:
    """The system of a model that cannot be put together, and the first guess (3 nb,) of positions, where gears mesh."""
    system = compile_system(with_constants(model, dict.fromkeys(constants_of(model), 0.0)))
    q = first_guess(system)
    return compile_system(with_constants(model, constants_at(system, q))), q


def require_fit(system: System, q: np.ndarray) -> None:
    """Raise AssemblyError if the points of a joint are not at the distance that it needs, apart from clearances."""
    play = sum(joint.clearance for joint in system.model.joints.values() if joint.contact and not joint.contact.closed)
    for name, _, fit, distance in fits(system, q.reshape(1, -1, 3)):
        if fit.needed and float(fit.missed(distance)[0]) > FITS * abs(fit.distance) + play:
            raise AssemblyError(
                f"joint '{name}': {fit.why.format(f'{fit.distance:.9g} m')}, at the start it is {distance[0]:.9g} m:"
                " change the radii, or the points or [initial] values that place the centres"
            )
