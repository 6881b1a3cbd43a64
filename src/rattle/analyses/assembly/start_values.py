"""Given start values: kept as far as joints and drivers allow; how, see `equations.kept_values`."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from rattle.analyses.assembly.computable import not_finite
from rattle.analyses.assembly.loops import loops
from rattle.equations.kept_values import NOT_FINITE, keep_given_rates
from rattle.equations.system import System
from rattle.jit.workspace import Workspace

KEYS = (("x", "y", "angle"), ("vx", "vy", "omega"))


def given_values(system: System, turn: int) -> np.ndarray:
    """(3 nb,) given positions [m, m, rad] (turn 0) or rates [m/s, m/s, rad/s] (turn 1), nan if not given."""
    bodies, wanted = system.model.initial.bodies, list[float]()
    for name in system.bodies:
        values = bodies.get(name, {})
        wanted += [values.get(key, math.nan) for key in KEYS[turn]]
    return np.array(wanted)


def left_at_zero(system: System, now: np.ndarray, wanted: np.ndarray) -> list[int]:
    """Angles that are not given and that assembly leaves at 0, because no loop could need another one."""
    model = system.model
    if any(driver.point is not None and not driver.moves_ground for driver in model.drivers.values()):
        return []
    closing = {name for joint, path in loops(model) for name in (joint.name, *path)}
    moved = {body for name in closing for body in (model.joints[name].a.body, model.joints[name].b.body)}
    return [
        3 * n + 2
        for n, body in enumerate(system.bodies)
        if body not in moved and np.isnan(wanted[3 * n + 2]) and now[3 * n + 2] == 0.0
    ]


Places: TypeAlias = dict[str, tuple[float, float, float]]  # of bodies by name: x, y [m], angle [rad]


def places(system: System, q: np.ndarray) -> Places:
    """Positions (3 nb,) as x, y [m] and angle [rad] of every body, for starts that are looked for near them."""
    return {name: (x, y, angle) for name, (x, y, angle) in zip(system.bodies, q.reshape(-1, 3).tolist(), strict=True)}


def change_of_given(system: System, q: np.ndarray, wanted: np.ndarray) -> float:
    """Sum of the squared changes of given positions, angles in rad and lengths in sizes of the mechanism."""
    change = q - wanted
    change[0::3] /= system.size
    change[1::3] /= system.size
    squares = change * change
    return float(squares[squares == squares].sum())


def keep_rates(
    system: System, workspace: Workspace, t: float, q: np.ndarray, v: np.ndarray, wanted: np.ndarray
) -> np.ndarray:
    """Rates (3 nb,) [m/s, m/s, rad/s] near v that satisfy the constraints and keep given ones as far as possible."""
    rates = v.copy()
    if keep_given_rates(workspace, t, q, rates, wanted, system.size) == NOT_FINITE:
        raise not_finite()
    return rates
