"""Given start values: kept as far as joints and drivers allow.

Positions and rates change in two stages: first the given values, by the least change that the constraints require,
then all others by the least change still needed; both are weighted by mass.  With G the columns of the given values,
O the others, P the left null space of Phi_q O, and r the way back to the given values:
min |e|, P^T Phi_q (G (r + e)) = -P^T Phi;   then   Phi_q (G (r + e) + O o) = -Phi.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.analyses.assembly.computable import finite
from rattle.equations.closure import close_position, open_by
from rattle.equations.dense import dense_rows
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace

KEYS = (("x", "y", "angle"), ("vx", "vy", "omega"))
NOISE = 1e-15  # share of the terms of a residual that is rounding
RANK = 1e-10  # share of the largest singular value below which columns are dependent
EASY = 1e4  # by how much more coordinates without mass move than the inverse root of their fictitious mass says
ROUNDS = 40  # of Newton's method


def given_values(system: System, turn: int) -> np.ndarray:
    """(3 nb,) given positions [m, m, rad] (turn 0) or rates [m/s, m/s, rad/s] (turn 1), nan if not given."""
    given = np.full(3 * system.body_count, math.nan)
    for name, values in system.model.initial.bodies.items():
        n = system.bodies.index(name)
        for k, key in enumerate(KEYS[turn]):
            given[3 * n + k] = values.get(key, math.nan)
    return given


def places(system: System, q: np.ndarray) -> dict[str, tuple[float, float, float]]:
    """Positions (3 nb,) as x, y [m] and angle [rad] of every body, for starts that are looked for near them."""
    return {name: (x, y, angle) for name, (x, y, angle) in zip(system.bodies, q.reshape(-1, 3).tolist(), strict=True)}


def change_of_given(system: System, q: np.ndarray, given: np.ndarray) -> float:
    """Sum of the squared changes of given positions, angles in rad and lengths in sizes of the mechanism."""
    change = (q - given) / np.tile([system.size, system.size, 1.0], system.body_count)
    return float(np.nansum(change * change))


# ---------------------------------------------------------------- least change in two stages
def least_change(
    system: System, jacobian: np.ndarray, wanted: np.ndarray, known: np.ndarray, noise: np.ndarray
) -> np.ndarray:
    """(3 nb,) change x [m, m, rad or their rates] with jacobian @ x = wanted; `known` coordinates change least.

    jacobian: (nr, 3 nb); wanted: (nr,); known: (3 nb,) True for given values.
    noise: (nr,) rounding error of `wanted`; combinations of rows that are not larger do not change known coordinates.
    """
    root = np.sqrt(system.arrays["weight"][1:].ravel())
    for i, k in system.arrays["massless"]:
        root[3 * i - 3 + k] *= EASY
    change = np.zeros(len(root))
    others = jacobian[:, ~known]
    if known.any():
        scale = np.tile([1.0, 1.0, 1.0 / system.size], system.body_count)
        left = np.eye(len(wanted))
        if others.size:
            u, values, _ = np.linalg.svd(finite(others * scale[~known]))
            values = (
                np.concatenate([values, np.zeros(len(wanted) - len(values))]) if len(values) < len(wanted) else values
            )
            left = u[:, values[: len(wanted)] <= RANK * max(values[0], 1e-300)]
        asked = left.T @ wanted
        asked[np.abs(asked) <= np.abs(left.T) @ noise] = 0.0
        change[known] = _shortest(left.T @ jacobian[:, known], asked, root[known])
    rest = wanted - jacobian[:, known] @ change[known]
    if others.shape[1]:
        change[~known] = _shortest(others, rest, root[~known])
    return change


def _shortest(matrix: np.ndarray, side: np.ndarray, root: np.ndarray) -> np.ndarray:
    """Least x, weighted by 1 / root^2, with matrix @ x = side in the sense of least squares."""
    if not side.any() or not matrix.size:
        return np.zeros(len(root))
    length = np.linalg.norm(matrix * root, axis=1)
    length = np.where(length > 0.0, length, 1.0)[:, None]
    found: np.ndarray = root * np.linalg.lstsq(matrix * root / length, side / length[:, 0], rcond=RANK)[0]
    return found


def keep_positions(system: System, workspace: Workspace, t: float, q: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Closed positions near q that keep the given values as far as joints allow; q if none are found.

    q: (3 nb,) closed positions [m, m, rad]; given: (3 nb,), nan if not given.
    """
    known = ~np.isnan(given)
    if not known.any() or np.abs(q - given)[known].max() <= 1e-14 * max(1.0, system.size):
        return q
    made, still = q.copy(), np.zeros_like(q)
    size = np.tile([system.size, system.size, 1.0], system.body_count)
    for _ in range(ROUNDS):
        open_by(workspace, t, made, still)
        jacobian = dense_rows(system, workspace)
        there = np.where(known, given - made, 0.0)
        wanted = -workspace.rows[:, at.RES] - jacobian @ there
        noise = NOISE * (np.abs(jacobian) @ np.abs(made) + system.size)
        step = there + least_change(system, jacobian, wanted, known, noise)
        step *= min(1.0, 0.5 / max(float(np.abs(step / size).max()), 1e-300))
        made += step
        if np.abs(step / size).max() < 1e-14:
            break
    exact = made.copy()
    gap = close_position(workspace, t, made, np.empty_like(made), 1e-12 * system.size, 30)[0]
    if not gap <= 1e-9 * system.size:
        return q
    if float(open_by(workspace, t, exact, still)) <= 1e-14 * max(1.0, system.size):
        made = exact
    nearer = _distance(system, made - given, known) < _distance(system, q - given, known)
    return made if nearer else q


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


def _distance(system: System, change: np.ndarray, known: np.ndarray) -> float:
    return float(np.linalg.norm((change / np.sqrt(system.arrays["weight"][1:].ravel()))[known]))


def keep_rates(
    system: System, workspace: Workspace, t: float, q: np.ndarray, v: np.ndarray, given: np.ndarray
) -> np.ndarray:
    """Rates (3 nb,) [m/s, m/s, rad/s] near v that satisfy the constraints and keep given ones as far as possible."""
    known = ~np.isnan(given)
    made = np.where(known, given, v)
    open_by(workspace, t, q, made)  # Phi_q and nu follow from the positions
    jacobian, nu = dense_rows(system, workspace), workspace.rows[:, at.NU].copy()
    sizes = np.abs(jacobian)
    for _ in range(2):
        wanted = nu - jacobian @ made
        noise = 8.0 * NOISE * (sizes @ np.abs(made) + np.abs(nu))
        if (np.abs(wanted) <= noise).all():
            break
        made = made + least_change(system, jacobian, wanted, known, noise)
    return made
