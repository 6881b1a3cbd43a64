"""Rank of the constraint rows: mobility, redundant joints, dead centres."""

from __future__ import annotations

import numpy as np

from rattle.analyses.assembly.computable import finite
from rattle.equations.dense import LARGE, dense_rows
from rattle.equations.schur import WEAK, factorise
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.jit.workspace import Workspace

RANK = 1e-9  # a singular value below this share of the largest counts as zero
TAKES_PART = 0.05  # share of a row in dependent rows from which its joint is named
NULL_PART = 1e-6  # entry of a null space below which it is rounding, and its row or coordinate takes no part
SAME_WAY = 1e-7  # singular value [-] of the drivers' rows of length 1 below which drivers move the same freedom
SINGULAR = 1e-3  # share of the largest singular value below which a position counts as singular: none is met exactly
UNLIKE = 1e9  # ratio of masses that leaves too few digits for the lighter body


def scaled_rows(system: System, workspace: Workspace) -> np.ndarray:
    """(nr, 3 nb) Phi_q [-] with angles times the size of the mechanism as lengths, every row scaled to length 1."""
    full, length = _rows_and_lengths(system, workspace)
    return finite(full / length[:, None])


def free_motions(rows: np.ndarray) -> np.ndarray:
    """(f, n) directions in which none of the rows (nr, n), each about as long as the others, changes."""
    if not len(rows):
        return np.eye(rows.shape[1])
    _, values, right = np.linalg.svd(finite(rows))
    return right[int((values > RANK * values[0]).sum()) :]


def row_lengths(system: System, workspace: Workspace) -> np.ndarray:
    """(nr,) lengths of the rows of Phi_q, by which `scaled_rows` divides; 1 for a row of zeros."""
    return _rows_and_lengths(system, workspace)[1]


def _rows_and_lengths(system: System, workspace: Workspace) -> tuple[np.ndarray, np.ndarray]:
    full = dense_rows(system, workspace)
    full[:, 2::3] /= system.size
    length = np.linalg.norm(full, axis=1)
    return full, np.where(length > 0, length, 1.0)


def rank(system: System, workspace: Workspace) -> int:
    """Number of independent rows at the state in the workspace."""
    if system.row_count == 0:
        return 0
    if system.row_count > LARGE:
        return system.row_count - int(workspace.redundant.sum())
    return rank_of(scaled_rows(system, workspace))


def rank_of(rows: np.ndarray) -> int:
    """Number of independent ones of these rows (nr, n), each about as long as the others."""
    values = np.linalg.svd(rows, compute_uv=False)
    return int((values > RANK * values[0]).sum()) if len(values) else 0


def independent(workspace: Workspace) -> bool:
    """True if all rows in the workspace are clearly independent: what their factor shows, without singular values."""
    workspace.power[at.PIVOT_SHARE] = 1.0
    return factorise(workspace) == 0 and bool(workspace.power[at.PIVOT_SHARE] > WEAK)


def left_null(system: System, workspace: Workspace, tolerance: float = RANK) -> np.ndarray:
    """(nr, k) left null space of `scaled_rows` [-]: reactions that balance each other without any load."""
    if system.row_count == 0 or system.row_count > LARGE:
        return np.zeros((system.row_count, 0))
    u, values, _ = np.linalg.svd(scaled_rows(system, workspace))
    values = np.concatenate([values, np.zeros(system.row_count - len(values))])
    return u[:, values <= tolerance * values[0]]


def nonunique_reactions(system: System, workspace: Workspace) -> tuple[str, ...]:
    """Names of joints and drivers whose reactions are not unique at the state in the workspace."""
    if system.row_count > LARGE:
        lost = np.flatnonzero(workspace.redundant[system.arrays["place"]])
        return tuple(dict.fromkeys(system.rows[r].owner for r in lost))
    free = left_null(system, workspace)
    taking_part = np.abs(free).max(axis=1, initial=0.0) > NULL_PART
    return tuple(dict.fromkeys(row.owner for row, takes in zip(system.rows, taking_part, strict=True) if takes))


def unsure_friction(system: System, free: np.ndarray) -> tuple[str, ...]:
    """Names of joints that rub by a reaction which is not unique; free: (nr, k) reactions that balance each other."""
    unsure, joints = np.abs(free).max(axis=1, initial=0.0) > NULL_PART, []
    for name, entry in zip(system.dry_joints, system.arrays["dry"], strict=True):
        friction, row = system.model.joints[name].friction, int(entry[at.DRY_ROW])
        if (friction is not None and friction.stated) or entry[at.DRY_FORM] == at.DRY_ROLLER:
            continue
        second_counts = entry[at.DRY_FORM] == at.DRY_PIN or (friction is not None and friction.reach > 0.0)
        if unsure[row] or (second_counts and unsure[entry[at.DRY_SECOND]]):
            joints.append(name)
    return tuple(joints)


def drivers_on_one_dof(system: System, workspace: Workspace) -> tuple[str, ...]:
    """Names of drivers that move the same degree of freedom, at the state in the workspace."""
    if len(system.model.drivers) < 2 or system.row_count > LARGE:
        return ()
    names = [row.owner for row in system.rows if row.driver]
    u, values, _ = np.linalg.svd(_driven(system, workspace))
    values = np.concatenate([values, np.zeros(max(0, len(names) - len(values)))])
    taking_part = np.abs(u[:, values <= SAME_WAY]).max(axis=1, initial=0.0) > NULL_PART
    return tuple(name for name, takes in zip(names, taking_part, strict=True) if takes)


def drivers_without_dof(system: System, workspace: Workspace) -> list[tuple[str, int]]:
    """Drivers, with their rows, if the joints leave no degree of freedom at the state in the workspace; else none."""
    if _driven(system, workspace).shape[
        1
    ]:  # at a dead centre a driver moves nothing either, but from another position it does
        return []
    return [(row.owner, r) for r, row in enumerate(system.rows) if row.driver]


def _driven(system: System, workspace: Workspace) -> np.ndarray:
    """(drivers, degrees of freedom) rows of the drivers in the directions that the joints leave free."""
    full = scaled_rows(system, workspace)
    driving = np.array([row.driver for row in system.rows])
    along: np.ndarray = full[driving] @ free_motions(full[~driving]).T
    return along


def unlike_masses(system: System) -> str:
    """In words, which masses differ too much for double precision; "" if none."""
    masses = {name: body.mass for name, body in system.model.bodies.items() if body.mass > 0.0}
    if not masses:
        return ""
    heavy, light = max(masses, key=lambda name: masses[name]), min(masses, key=lambda name: masses[name])
    ratio = masses[heavy] / masses[light]
    if ratio <= UNLIKE:
        return ""
    return f"'{heavy}' has {ratio:.2g} times the mass of '{light}', too much for double precision; reduce the ratio"


def loose_without_mass(system: System, workspace: Workspace, tolerance: float = RANK) -> tuple[tuple[str, bool], ...]:
    """Bodies that can move, at the state in the workspace, without any mass moving, and whether they only turn.

    tolerance: share [-] of the largest singular value below which a singular value counts as zero.
    """
    massless = system.arrays["massless"]
    if not len(massless) or len(massless) > LARGE:
        return ()
    rows, bodies = workspace.rows, system.arrays["row_body"]
    columns = np.zeros((system.row_count, len(massless)))
    for n, (i, k) in enumerate(massless):
        on_a, on_b = bodies[:, at.ROW_A] == i, bodies[:, at.ROW_B] == i
        columns[:, n] = (rows[:, at.AX + k] * on_a + rows[:, at.BX + k] * on_b) / (system.size if k == 2 else 1.0)
    _, values, v = np.linalg.svd(columns)
    values = np.concatenate([values, np.zeros(len(massless) - min(len(massless), len(values)))])[: len(massless)]
    shares = np.abs(v[values <= tolerance * max(values[0], TINY)]).max(axis=0, initial=0.0)
    moving: dict[int, list[int]] = {}
    for (i, k), share in zip(massless.tolist(), shares, strict=True):
        if share > NULL_PART:
            moving.setdefault(i, []).append(k)
    return tuple((system.bodies[i - 1], which == [2]) for i, which in moving.items())


def joints_losing_rank(system: System, workspace: Workspace, tolerance: float = SINGULAR) -> tuple[str, ...]:
    """Joints and drivers whose rows are dependent at the state in the workspace, those with the largest part first.

    tolerance: share [-] of the largest singular value below which a singular value counts as zero.
    """
    free = left_null(system, workspace, tolerance)
    if free.shape[1] == 0:
        return ()
    share = np.abs(free).max(axis=1)
    owners: dict[str, float] = {}
    for row, value in zip(system.rows, share, strict=True):
        owners[row.owner] = max(owners.get(row.owner, 0.0), float(value))
    return tuple(name for name, value in sorted(owners.items(), key=lambda item: -item[1]) if value > TAKES_PART)


def describe_rank_loss(system: System, workspace: Workspace, tolerance: float = SINGULAR) -> str:
    """In words, which joints block the motion at the state in the workspace; "" if all rows are independent.

    tolerance: share [-] of the largest singular value below which a singular value counts as zero.
    """
    names = joints_losing_rank(system, workspace, tolerance)
    if not names:
        return ""
    drivers = [name for name in names if name in system.model.drivers]
    if drivers:
        driver = system.model.drivers[drivers[0]]
        return (
            f"driver '{drivers[0]}' on {driver.on} is at a dead centre (its force no longer moves the mechanism;"
            f" constraints of {', '.join(names[:6])} lose rank). Drive another joint, or keep the driver away from it."
        )
    return (
        f"a singular position: constraints of {', '.join(names[:6])} lose rank."
        " Start from another position, or change the lengths slightly."
    )
