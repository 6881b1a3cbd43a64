"""Given start values: kept as far as joints and drivers allow; how, see `equations.kept_values`."""

from __future__ import annotations

import math

import numpy as np

from rattle.analyses.assembly.computable import not_finite
from rattle.equations.closure import close_position
from rattle.equations.kept_values import MOVED, NOT_FINITE, keep_given, keep_given_rates
from rattle.equations.system import System
from rattle.jit.workspace import Workspace

KEYS = (("x", "y", "angle"), ("vx", "vy", "omega"))


def given_values(system: System, turn: int) -> np.ndarray:
    """(3 nb,) given positions [m, m, rad] (turn 0) or rates [m/s, m/s, rad/s] (turn 1), nan if not given."""
    bodies, given = system.model.initial.bodies, list[float]()
    for name in system.bodies:
        values = bodies.get(name, {})
        given += [values.get(key, math.nan) for key in KEYS[turn]]
    return np.array(given)


def places(system: System, q: np.ndarray) -> dict[str, tuple[float, float, float]]:
    """Positions (3 nb,) as x, y [m] and angle [rad] of every body, for starts that are looked for near them."""
    return {name: (x, y, angle) for name, (x, y, angle) in zip(system.bodies, q.reshape(-1, 3).tolist(), strict=True)}


def change_of_given(system: System, q: np.ndarray, given: np.ndarray) -> float:
    """Sum of the squared changes of given positions, angles in rad and lengths in sizes of the mechanism."""
    change = q - given
    change[0::3] /= system.size
    change[1::3] /= system.size
    squares = change * change
    return float(squares[squares == squares].sum())


# ---------------------------------------------------------------- keeping them
def keep_positions(system: System, workspace: Workspace, t: float, q: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Closed positions near q that keep the given values as far as joints allow; q if none are found.

    q: (3 nb,) closed positions [m, m, rad]; given: (3 nb,), nan if not given.
    """
    made = q.copy()
    found = keep_given(workspace, t, made, given, system.size)
    if found == NOT_FINITE:
        raise not_finite()
    return made if found == MOVED else q


def keep_places(system: System, workspace: Workspace, t: float, q: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Closed positions (3 nb,) [m, m, rad] with all given values, if q misses a given x or y and they exist; else q.

    A massless link may stand on either side of its bush: the side on which the user placed the body is preferred to the
    one to which its force presses it.  Angles alone do not decide: usually they are those of the ideal mechanism.
    """
    known, near = ~np.isnan(given), 1e-9 * system.size
    places = known & (np.arange(len(q)) % 3 < 2)
    if not (np.abs(q - given)[places] > near).any():
        return q
    made = np.where(known, given, q)
    if not close_position(workspace, t, made, np.empty_like(made), 1e-12 * system.size, 60)[0] <= near:
        return q
    made = keep_positions(system, workspace, t, made, given)
    return made if (np.abs(made - given)[known] <= near).all() else q


def keep_rates(
    system: System, workspace: Workspace, t: float, q: np.ndarray, v: np.ndarray, given: np.ndarray
) -> np.ndarray:
    """Rates (3 nb,) [m/s, m/s, rad/s] near v that satisfy the constraints and keep given ones as far as possible."""
    made = v.copy()
    if keep_given_rates(workspace, t, q, made, given, system.size) == NOT_FINITE:
        raise not_finite()
    return made
