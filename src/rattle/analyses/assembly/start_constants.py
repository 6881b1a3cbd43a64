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
    """The model with constants [m or rad] of joints whose rows count from the start; one number for all of a joint."""
    joints = dict(model.joints)
    for name, values in constants.items():
        joint = joints[name]
        each = values if isinstance(values, tuple) else (values,) * joint.from_start
        joints[name] = replace(joint, constants=each)
    return replace(model, joints=joints)


def constants_of(model: Model) -> dict[str, tuple[float, ...]]:
    """Constants [m or rad] that the start of a model has set, by joint."""
    return {name: joint.constants for name, joint in model.joints.items() if joint.from_start}


def flat(constants: Mapping[str, tuple[float, ...]]) -> list[float]:
    """All constants [m or rad] in the order of the joints."""
    return [value for each in constants.values() for value in each]


def without_counting(model: Model) -> Model:
    """The model without the rows that count from the start: what determines the positions there."""
    joints = {
        name: replace(joint, counts=False, constants=()) if joint.from_start else joint
        for name, joint in model.joints.items()
        if not joint.from_start or joint.leaf.placing
    }
    return replace(model, joints=joints)


def counting_rows(system: System) -> dict[str, range]:
    """The rows of every joint that count from the start."""
    rows = {}
    for name in constants_of(system.model):
        joint, first = system.model.joints[name], system.first_row(name)
        rows[name] = range(first + joint.leaf.placing, first + len(joint.rows))
    return rows


def constants_at(system: System, q: np.ndarray) -> dict[str, tuple[float, ...]]:
    """Constants [m or rad], by joint, with which its rows vanish at q (3 nb,) [m, m, rad].

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
        joint, values = joints[name], tuple(residual[counting.start : counting.stop].tolist())
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
