"""One degree of freedom at rest with friction in joints: the motion that is left, and where it is impending.

    Q + p B + W^T tau - Phi_q^T lambda = 0,   |tau_n| <= mu_n arm_n N_n(lambda)          p: value of the load sought

With z, the motion that joints and drivers leave, and z . B = 1: p = -z . Q - (W z) . tau.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.rank import RANK, unsure_friction
from rattle.analyses.history import require_known_torques, require_loads_without_states
from rattle.analyses.undefined import undefined
from rattle.equations.dense import dense_rows
from rattle.equations.motion import drive, solve_motion
from rattle.equations.system import System, is_link
from rattle.errors import InputError, ModelError, Problem
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.questions.holds.impending_motion import NOTHING, Limit, Rubbing, limit

STILL = 1e-9  # share of the whole motion below which a joint does not move in it
NO_WORK = 1e-9  # [-] cosine between a load and the motion below which it does no work in it: rounding
MOST_STILL = 6  # joints with friction that do not move in the motion, whose friction is tried both ways


class Sought(NamedTuple):
    """The load whose value is sought."""

    name: str
    direction: np.ndarray  # (3 nb,) generalised force per unit of its value
    unit: str  # of the value; "" if it is a factor
    value: float  # the present one; nan of a driver
    row: int  # constraint row that it replaces; -1: none


class Motion(NamedTuple):
    """The one motion, and what it takes to know all reactions."""

    scale: np.ndarray  # (3 nb,) 1, and 1 / size of the mechanism for angles [-, -, 1/m]
    z: np.ndarray  # (3 nb,) rates [m/s, m/s, rad/s] when the load moves at 1
    force: np.ndarray  # (3 nb,) all loads but the one sought [N, N m]
    direction: np.ndarray  # (3 nb,) of the load sought
    inverse: np.ndarray  # (rows, 3 nb) multipliers by the forces that they balance
    coordinate: np.ndarray  # (n, 3 nb) rows w of the joints with friction
    rows: np.ndarray  # (n, 2) multipliers of each by which it rubs; the only one twice
    across: np.ndarray  # (n, n) what pins of rods bear across the rod, by the friction of all [1/m]; 0 of others

    @property
    def free(self) -> float:
        """Value of the load that balances without friction."""
        return 0.0 - float(self.z @ self.force)


class Impending(NamedTuple):
    """Motion about to begin in one sense."""

    rubbing: Rubbing
    limit: Limit
    load: float  # value of the load; inf or -inf if it jams


def require_answerable(system: System) -> None:
    """Raise ModelError if no joint has friction that holds, or if something has no reactions at rest."""
    require_loads_without_states(system.model, "equilibrium with friction")
    require_known_torques(system, "equilibrium with friction")
    holding = [name for name, joint in system.model.joints.items() if joint.friction and joint.friction.law is None]
    if not holding:
        creeping = [name for name, joint in system.model.joints.items() if joint.friction]
        words = (
            "their laws of friction creep under any load, and bristles bend: none holds; give them friction = MU"
            if creeping
            else "no joint without play has friction; give one friction = MU, or a table with mu and pin_radius"
        )
        raise ModelError([Problem(("joints", *creeping[:1]), words)])
    joints = [system.joints[n] for n in system.arrays["contact"][:, at.OWNER]]
    loose = [name for name, joint in system.model.joints.items() if joint.is_loose or is_link(joint)]
    for name in (*loose, *joints):
        if system.model.joints[name].stop is None or name in loose:
            words = "what friction holds is known of joints without play and contacts; close it with ideal() or --ideal"
            raise ModelError([Problem(("joints", name), words)])


def evaluated(system: System, t: float, q: np.ndarray) -> Workspace:
    """A workspace with rows and loads at rest at q (3 nb,) [m, m, rad].  Raises InputError."""
    workspace = system.workspace()
    drive(workspace, t)
    solve_motion(workspace, t, q, np.zeros_like(q))
    if not np.isfinite(workspace.force).all():
        raise InputError(f"loads have no finite value there: {undefined(system, workspace, t)}")
    return workspace


def one_motion(system: System, workspace: Workspace, sought: Sought | None) -> Motion:
    """The motion that is left, along which the load works; None: a force along the motion itself, of value zero.

    Raises InputError, ModelError.
    """
    scale = np.ones(3 * system.body_count)
    scale[2::3] = 1.0 / system.size
    kept = np.arange(system.row_count) != (sought.row if sought is not None else -1)
    rows = dense_rows(system, workspace)[kept]
    length = np.linalg.norm(rows * scale, axis=1)
    u, values, right = np.linalg.svd(rows * scale / length[:, None])
    rank = int((values > RANK * values.max(initial=0.0)).sum())
    dof = len(scale) - rank
    if dof != 1:
        raise InputError(_freedom(system, sought, dof))
    _require_unique(system, u[:, rank:], np.flatnonzero(kept))
    z = scale * right[rank]
    sought = sought or Sought("", right[rank] / scale, "N", 0.0, -1)
    worth = float(z @ sought.direction)
    if abs(worth) <= NO_WORK * float(np.linalg.norm(z / scale) * np.linalg.norm(sought.direction * scale)):
        raise InputError(
            f"'{sought.name}' does no work in the motion that is left at this position (a dead centre, or a load across"
            " the motion): friction or not, no value of it moves the mechanism"
        )
    pinv = (u[:, :rank] / values[:rank]) @ right[:rank]  # of the transposed rows
    inverse = np.zeros((system.row_count, len(scale)))
    inverse[kept] = pinv / length[:, None] * scale
    force = workspace.force[1:].ravel() - (0.0 if sought.row >= 0 else sought.value * sought.direction)
    held = [n for n in range(len(system.dry_joints)) if system.arrays["dry"][n, at.DRY_LAW] < 0]
    dry = system.arrays["dry"][held]
    second = np.where(dry[:, at.DRY_FORM] == at.DRY_ROD, dry[:, at.DRY_ROW], dry[:, at.DRY_SECOND])
    return Motion(
        scale, z / worth, force, sought.direction, inverse, _coordinates(system, workspace)[held],
        np.column_stack([dry[:, at.DRY_ROW], second]), _across(system, workspace)[np.ix_(held, held)],
    )  # fmt: skip


def _require_unique(system: System, loose: np.ndarray, kept: np.ndarray) -> None:
    """Raise ModelError if a reaction by which a joint rubs is not unique.

    loose: (rows, k) reactions that balance each other, of the rows `kept`.
    """
    free = np.zeros((system.row_count, loose.shape[1]))
    free[kept] = loose
    reason = "its reaction is not unique (redundant constraints), so neither is its friction; replace a joint by one"
    names = unsure_friction(system, free)
    if names:
        raise ModelError([Problem(("joints", name, "friction"), f"{reason} that holds less") for name in names])


def _freedom(system: System, sought: Sought | None, dof: int) -> str:
    """In words, why there is no answer with that many degrees of freedom."""
    if dof > 1:
        return (
            f"{dof} degrees of freedom are left, and with more than one what friction holds is no interval:"
            f" hold {'the others' if dof > 2 else 'the other'} with a driver, or simulate from rest"
        )
    if sought is None:
        return "joints and drivers leave no degree of freedom: nothing can move"
    names = " or ".join(f"'{name}'" for name in system.model.drivers)
    more = f"; ask for the effort of {names}" if names and sought.row < 0 else ""
    return f"joints and drivers leave no degree of freedom, so that every value of '{sought.name}' is held{more}"


def _across(system: System, workspace: Workspace) -> np.ndarray:
    """(n, n) what all joints with friction bear across rods by their own friction [1/m]."""
    dry = system.arrays["dry"]
    across = np.zeros((len(dry), len(dry)))
    for n in np.flatnonzero(dry[:, at.DRY_FORM] == at.DRY_ROD):
        across[n, n], across[n, dry[n, at.DRY_SECOND]] = workspace.dry_rows[n, at.NU], -workspace.dry_rows[n, at.NU]
    return across


def _coordinates(system: System, workspace: Workspace) -> np.ndarray:
    """(joints, 3 nb) rows w of the free coordinates of all joints with friction, from the workspace."""
    rows = np.zeros((len(system.dry_joints), system.body_count + 1, 3))
    for n, entry in enumerate(system.arrays["dry"]):
        rows[n, entry[at.DRY_A]] += workspace.dry_rows[n, at.AX : at.AP + 1]
        rows[n, entry[at.DRY_B]] += workspace.dry_rows[n, at.BX : at.BP + 1]
    return rows[:, 1:].reshape(len(rows), -1)


def impending(system: System, workspace: Workspace, motion: Motion, sense: float, far: bool = True) -> Impending:
    """Motion about to begin with the load (sense 1) or against it (-1).

    Joints that do not move in it rub the way that holds most.  far: also find with how much friction it would jam.
    """
    dry = system.arrays["dry"]
    dry = dry[dry[:, at.DRY_LAW] < 0]
    p, values = dry[:, at.DRY_P], workspace.values
    arm = values[p + at.DRY_ARM]
    rods = dry[:, at.DRY_FORM] == at.DRY_ROD
    reach = np.where(rods | (dry[:, at.DRY_FORM] == at.DRY_PIN), math.nan, values[p + at.DRY_REACH])
    held, stated = np.flatnonzero(system.arrays["dry"][:, at.DRY_LAW] < 0), dry[:, at.DRY_STATED] == 1
    press = np.where(dry[:, at.DRY_FORM] == at.DRY_SURFACE, workspace.dry_rows[held, at.NU], 1.0)[:, None]
    rate = motion.coordinate @ motion.z
    largest = float(np.linalg.norm(motion.z / motion.scale)) * np.linalg.norm(motion.coordinate * motion.scale, axis=1)
    still = np.flatnonzero(np.abs(rate) <= STILL * largest)
    rate[still] = 0.0
    beside = np.stack([np.ones(len(rods)), ~rods], axis=1)  # across a rod there is nothing but friction
    others, alone = motion.inverse @ motion.force, motion.free * (motion.inverse @ motion.direction)
    rounding = NOTHING * float(np.abs(others).max(initial=0.0) + np.abs(alone).max(initial=0.0))
    best: Impending | None = None
    for signs in itertools.product((1.0, -1.0), repeat=min(len(still), MOST_STILL)):
        way, slip = np.sign(rate), np.abs(rate) * arm
        way[still[:MOST_STILL]] = signs
        acting = sense * (slip[:, None] * motion.direction - (way * arm)[:, None] * motion.coordinate)
        response = np.moveaxis((acting @ motion.inverse.T)[:, motion.rows] * press * beside, 0, 2)
        response[:, 1] -= sense * motion.across * (way * arm)
        bare = (others + alone)[motion.rows] * press * beside
        response[stated], bare[stated] = 0.0, (1.0, 0.0)  # N = 1, whatever the joint bears
        rubbing = Rubbing(values[p + at.DRY_MU_STATIC], reach, bare, response, slip, rounding)
        at_limit = limit(rubbing, far)
        more = math.inf if np.isinf(at_limit.x).any() else float(slip @ at_limit.x)
        if best is None or more > abs(best.load - motion.free):
            best = Impending(rubbing, at_limit, motion.free + sense * more)
    assert best is not None
    return best
