"""Drivers that the joints contradict: dependent constraint rows whose right-hand sides are inconsistent.

If rows are dependent, N^T Phi_q = 0, a motion exists only if also N^T nu = 0 and N^T gamma = 0, now and later.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rattle.analyses.assembly.rank import RANK, independent, left_null, row_lengths, scaled_rows
from rattle.equations.closure import close_position, close_rate, open_by
from rattle.equations.system import System, compile_system
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.jit.workspace import Workspace

NOISE = 1e-9  # share of the terms of N^T nu that is rounding
SHAKE = 1e-3  # displacement along the joints' degrees of freedom, after which a singular position is left
LEAST = 1e-12  # share of the largest right-hand side that is rounding of any of them
TAKES_PART = 1e-6  # entry of a null space above which its row takes part
SHORT = 0.1  # longest step towards a later instant [rad, mechanism sizes]
CLOSED = 1e-9  # largest gap, in sizes of the mechanism, with which positions count as closed
ENOUGH = 1e-12  # the same at which closing them ends
ROUNDS = 30  # of closing positions that are near
FAR_ROUNDS = 60  # of closing them where a driver less leaves more ways to go
MOST_STEPS = 200
LATER = 8  # instants examined after the start; the nearest is span / 2^LATER away


def contradicted(system: System, workspace: Workspace, t: float, q: np.ndarray, v: np.ndarray, span: float) -> str:
    """In words, the drivers that joints or other drivers contradict at the state (t, q, v) or soon after; "" if none.

    workspace: for its positions.  t: [s]; q, v: (3 nb,) [m, rad], [m/s, rad/s]; span: how far to look ahead [s].
    A dead centre is not a contradiction: from another position the driver works.
    """
    if not system.model.drivers:
        return ""
    open_by(workspace, t, q, v)
    if independent(workspace):
        return ""
    null = left_null(system, workspace)
    if not null.shape[1] or not (null := _with_drivers(system, null)).shape[1]:
        return ""
    owners = _at_odds(system, workspace, null)
    if not owners:
        return _later(system, workspace, t, q.copy(), v.copy(), span) if np.isfinite(span) and span > 0.0 else ""
    return _in_words(system, owners) if _structural(system, t, q) else ""


def _with_drivers(system: System, null: np.ndarray) -> np.ndarray:
    """The columns of a null space in which drivers take part."""
    driving = np.array([row.driver for row in system.rows])
    return null[:, np.abs(null[driving]).max(axis=0, initial=0.0) > TAKES_PART]


def _at_odds(system: System, workspace: Workspace, null: np.ndarray) -> tuple[str, ...]:
    """Owners of dependent rows with inconsistent right-hand sides, at the state in the workspace."""
    rows, length = workspace.rows, row_lengths(system, workspace)
    for column in (at.NU, at.GAMMA):
        side = rows[:, column] / length
        for k in range(null.shape[1]):
            terms = null[:, k] * side
            if abs(terms.sum()) > NOISE * np.abs(terms).sum() + LEAST * np.abs(side).max(initial=0.0):
                return _taking_part(system, null[:, k : k + 1])
    return ()


def _structural(system: System, t: float, q: np.ndarray) -> bool:
    """True if drivers remain among the dependent rows after a small displacement that the joints allow."""
    workspace = system.workspace()
    open_by(workspace, t, q, np.zeros_like(q))
    driving = np.array([row.driver for row in system.rows])
    near = q.copy()
    if not driving.all():
        joints = compile_system(replace(system.model, drivers={})).workspace()
        scale = np.tile([system.size, system.size, 1.0], system.body_count)
        _, values, right = np.linalg.svd(scaled_rows(system, workspace)[~driving])
        free = right[int((values > RANK * values[0]).sum()) :]
        near += SHAKE * scale * (free.T @ np.random.default_rng(0).uniform(0.5, 1.0, len(free)))
        if not _closes(system, joints, t, near):
            return False
    open_by(workspace, t, near, np.zeros_like(q))
    return bool(_with_drivers(system, left_null(system, workspace)).shape[1])


def _later(system: System, workspace: Workspace, t: float, q: np.ndarray, v: np.ndarray, span: float) -> str:
    """`contradicted` at some later instants, as far as the positions can be followed."""
    scale = np.tile([1.0 / system.size, 1.0 / system.size, 1.0], system.body_count)
    now, steps = t, 0
    for k in range(LATER, -1, -1):
        mark = t + span * 2.0**-k
        while now < mark:
            if steps == MOST_STEPS:
                return ""
            ahead = min(mark, now + SHORT / max(float(np.abs(scale * v).max()), TINY))
            owners = _taking_part(system, _with_drivers(system, left_null(system, workspace)))
            q += (ahead - now) * v
            if not _closes(system, workspace, ahead, q):
                return (
                    f"{_in_words(system, owners)} (at t = {ahead:.4g} s)"
                    if _closes_without(system, owners, ahead, q)
                    else ""
                )
            close_rate(workspace, ahead, q, v)
            now, steps = ahead, steps + 1
        contradiction = contradicted(system, workspace, now, q, v, 0.0)
        if contradiction:
            return f"{contradiction} (at t = {now:.4g} s)"
    return ""


def _closes(system: System, workspace: Workspace, t: float, q: np.ndarray, rounds: int = ROUNDS) -> bool:
    """True if positions q (3 nb,), which are moved for that, close at t [s] under the constraints of a workspace."""
    gap = close_position(workspace, t, q, np.empty_like(q), ENOUGH * system.size, rounds)[0]
    return bool(gap <= CLOSED * system.size)


def _closes_without(system: System, owners: tuple[str, ...], t: float, q: np.ndarray) -> bool:
    """True if the positions close at t without one of the drivers among the owners."""
    for name in system.model.drivers:
        if name in owners:
            drivers = {other: driver for other, driver in system.model.drivers.items() if other != name}
            workspace, near = compile_system(replace(system.model, drivers=drivers)).workspace(), q.copy()
            if _closes(system, workspace, t, near, FAR_ROUNDS):
                return True
    return False


def _taking_part(system: System, null: np.ndarray) -> tuple[str, ...]:
    """Owners of all dependent rows."""
    size = np.abs(null).max(axis=1, initial=0.0)
    return tuple(dict.fromkeys(system.rows[int(r)].owner for r in np.argsort(-size) if size[r] > TAKES_PART))


def _in_words(system: System, owners: tuple[str, ...]) -> str:
    drivers = [f"'{name}'" for name in system.model.drivers if name in owners]
    joints = ", ".join(f"'{name}'" for name in system.model.joints if name in owners)
    if not drivers:
        return ""
    if len(drivers) > 1:
        listed = f"{', '.join(drivers[:-1])} and {drivers[-1]}"
        many = f"remove {'one' if len(drivers) == 2 else 'some'} of them"
        between = f" (through joints {joints})" if joints else ""
        return f"drivers {listed} drive the same degree of freedom{between} with functions that disagree; {many}"
    return (
        f"driver {drivers[0]} is contradicted by joints {joints}: they leave its degree of freedom no motion"
        " (one driver too many); remove it, or free a joint"
    )
