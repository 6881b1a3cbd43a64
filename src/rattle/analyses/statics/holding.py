"""Which values of one load dry friction in the joints holds at rest, at one position of one degree of freedom.

    Q + p B + W^T tau - Phi_q^T lambda = 0,   |tau_n| <= mu_n arm_n N_n(lambda)          p: value of the load

With z, the motion that joints and drivers leave, and z . B = 1: p = -z . Q - (W z) . tau.  The ends of the interval are
where motion is impending in either sense (`impending_motion`).
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from rattle import registry
from rattle.analyses.assembly.rank import RANK
from rattle.analyses.clutches import require_known_torques
from rattle.analyses.load_forces import load_forces
from rattle.analyses.own_states import require_loads_without_states
from rattle.analyses.statics.equilibria import position_at
from rattle.analyses.statics.equilibrium import Equilibrium
from rattle.analyses.statics.holding_range import HoldingRange
from rattle.analyses.statics.impending_motion import NOTHING, Limit, Rubbing, limit, yields_more
from rattle.analyses.travel import with_stops, without_stops
from rattle.analyses.undefined import undefined
from rattle.equations.dense import dense_rows
from rattle.equations.motion import drive, solve_motion
from rattle.equations.placement import point_at
from rattle.equations.system import System, compile_system, is_link
from rattle.errors import ModelError, Problem, suggest
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace

GRAVITY = "gravity"  # the name by which it is asked for
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

    z: np.ndarray  # (3 nb,) rates [m/s, m/s, rad/s] when the load moves at 1
    force: np.ndarray  # (3 nb,) all loads but the one sought [N, N m]
    direction: np.ndarray  # (3 nb,) of the load sought
    inverse: np.ndarray  # (rows, 3 nb) multipliers by the forces that they balance
    coordinate: np.ndarray  # (n, 3 nb) rows w of the joints with friction
    row: np.ndarray  # (n,) first multiplier of each


def holding_range(system: System, name: str, t: float, at_rest: Equilibrium | None) -> HoldingRange:
    """The interval of values of a load, or of the effort of a driver, that friction holds; see `Mechanism.holds`."""
    functions.start()
    require_answerable(system)
    stops = with_stops(system.model)
    system = compile_system(without_stops(system.model)) if stops else system
    t = t if at_rest is None else at_rest.t
    q = position_at(system, t) if at_rest is None else at_rest.q
    if len(q) != 3 * system.body_count:
        raise ValueError("at: this equilibrium belongs to another mechanism")
    workspace = system.workspace()
    drive(workspace, t)
    solve_motion(workspace, t, q, np.zeros_like(q))
    if not np.isfinite(workspace.force).all():
        raise ValueError(f"loads have no finite value there: {undefined(system, workspace, t)}")
    sought = _sought(system, workspace, name, t, q)
    motion = _motion(system, workspace, sought)
    free = 0.0 - float(motion.z @ motion.force)
    found = {sense: _limit(system, workspace, motion, free, sense) for sense in (-1.0, 1.0)}
    low, high = (free + sense * _more(rubbing, one) for sense, (rubbing, one) in found.items())
    doubtful = sorted({name for rubbing, one in found.values() for name in _doubtful(system, rubbing, one)})
    return HoldingRange(
        sought.name, sought.unit, sought.value, low, high, free, (found[-1.0][1].jams_at, found[1.0][1].jams_at),
        t, q, _notes(system, stops, doubtful),
    )  # fmt: skip


def require_answerable(system: System) -> None:
    """Raise ModelError if no joint has friction that holds, or if something has no reactions at rest."""
    require_loads_without_states(system.model, "equilibrium with friction")
    require_known_torques(system, "equilibrium with friction")
    holding = [name for name, one in system.model.joints.items() if one.friction and one.friction.law is None]
    if not holding:
        creeping = [name for name, one in system.model.joints.items() if one.friction]
        said = (
            "their laws of friction creep under any load, and bristles bend: none holds; give them friction = MU"
            if creeping
            else "no joint without play has friction; give one friction = MU, or a table with mu and pin_radius"
        )
        raise ModelError([Problem(("joints", *creeping[:1]), said)])
    joints = [system.joints[n] for n in system.arrays["contact"][:, at.OWNER]]
    loose = [name for name, one in system.model.joints.items() if one.is_loose or is_link(one)]
    for name in (*loose, *joints):
        if system.model.joints[name].stop is None or name in loose:
            said = "what friction holds is known of joints without play and contacts; close it with ideal() or --ideal"
            raise ModelError([Problem(("joints", name), said)])


def _sought(system: System, workspace: Workspace, name: str, t: float, q: np.ndarray) -> Sought:
    """The load or driver of that name.  Raises ValueError."""
    model = system.model
    if name in model.drivers:
        effort = registry.kinds("driver")[model.drivers[name].kind].leaf.effort
        row = system.first_row(name)
        return Sought(f"{name}.{effort[0]}", dense_rows(system, workspace)[row], effort[1], math.nan, row)
    if name == GRAVITY and name not in model.loads:
        mass = system.arrays["mass"][1:, :1]
        weight = np.zeros((system.body_count, 3))
        weight[:, :2] = mass * system.arrays["gravity"]
        return _scaled(name, weight.ravel(), "", 1.0)
    if name not in model.loads:
        known = [*model.loads, *model.drivers, GRAVITY]
        raise ValueError(f"no load or driver '{name}'{suggest(name, known)}")
    load, force = model.loads[name], load_forces(system, t, q, np.zeros_like(q))[name]
    end = force[0 if load.b.body == "ground" else 1 + system.bodies.index(load.b.body)]
    record = getattr(registry.kinds("load")[load.kind].leaf, "record", None) if load.law is None else None
    if load.kind == "force":
        value, unit = float(np.hypot(*end[:2])), "N"
    elif load.kind == "torque":
        value, unit = float(end[2]), "N*m"
    elif record is not None and record.unit == "N*m":
        value, unit = record.power * float(end[2]), "N*m"
    elif record is not None:
        line = point_at(system, q, load.b) - point_at(system, q, load.a)
        value, unit = math.copysign(float(np.hypot(*end[:2])), record.power * float(line @ end[:2])), "N"
    else:
        value, unit = 1.0, ""
    return _scaled(name, force[1:].ravel(), unit, value)


def _scaled(name: str, force: np.ndarray, unit: str, value: float) -> Sought:
    """A load of that force (3 nb,) at its present value."""
    if not force.any() or value == 0.0:
        raise ValueError(
            f"'{name}' exerts nothing at this position, so it has no direction; give it a value there, of any size"
        )
    return Sought(name, force / value, unit, value, -1)


def _motion(system: System, workspace: Workspace, sought: Sought) -> Motion:
    """The motion that is left, along which the load works.  Raises ValueError, ModelError."""
    scale = np.ones(3 * system.body_count)
    scale[2::3] = 1.0 / system.size
    kept = np.arange(system.row_count) != sought.row
    rows = dense_rows(system, workspace)[kept]
    length = np.linalg.norm(rows * scale, axis=1)
    u, values, right = np.linalg.svd(rows * scale / length[:, None])
    rank = int((values > RANK * values.max(initial=0.0)).sum())
    dof = len(scale) - rank
    if dof != 1:
        raise ValueError(_freedom(system, sought, dof))
    _require_unique(system, u[:, rank:], np.flatnonzero(kept))
    z = scale * right[rank]
    worth = float(z @ sought.direction)
    if abs(worth) <= 1e-9 * float(np.linalg.norm(z / scale) * np.linalg.norm(sought.direction * scale)):
        raise ValueError(
            f"'{sought.name}' does no work in the motion that is left at this position (a dead centre, or a load across"
            " the motion): friction or not, no value of it moves the mechanism"
        )
    pinv = (u[:, :rank] / values[:rank]) @ right[:rank]  # of the transposed rows
    inverse = np.zeros((system.row_count, len(scale)))
    inverse[kept] = pinv / length[:, None] * scale
    force = workspace.force[1:].ravel() - (0.0 if sought.row >= 0 else sought.value * sought.direction)
    held = [n for n in range(len(system.dry_joints)) if system.arrays["dry"][n, at.DRY_LAW] < 0]
    return Motion(
        z / worth, force, sought.direction, inverse, _coordinates(system, workspace)[held],
        system.arrays["dry"][held, at.DRY_ROW],
    )  # fmt: skip


def _require_unique(system: System, loose: np.ndarray, kept: np.ndarray) -> None:
    """Raise ModelError if a reaction by which a joint rubs is not unique.

    loose: (rows, k) reactions that balance each other, of the rows `kept`.
    """
    unsure = set(kept[np.abs(loose).max(axis=1, initial=0.0) > 1e-6].tolist())
    for name, entry in zip(system.dry_joints, system.arrays["dry"], strict=True):
        joint, row = system.model.joints[name], int(entry[at.DRY_ROW])
        moment_counts = entry[at.DRY_FORM] == at.DRY_PIN or (joint.friction is not None and joint.friction.reach > 0.0)
        if row in unsure or (moment_counts and row + 1 in unsure):
            said = "its reaction is not unique (redundant constraints), so neither is its friction; replace a joint"
            raise ModelError([Problem(("joints", name, "friction"), f"{said} by one that holds less")])


def _freedom(system: System, sought: Sought, dof: int) -> str:
    """In words, why there is no answer with that many degrees of freedom."""
    if dof > 1:
        return (
            f"{dof} degrees of freedom are left, and with more than one the loads that friction holds are no interval:"
            f" hold {'the others' if dof > 2 else 'the other'} with a driver, or simulate from rest"
        )
    names = " or ".join(f"'{name}'" for name in system.model.drivers)
    more = f"; ask for the effort of {names}" if names and sought.row < 0 else ""
    return f"joints and drivers leave no degree of freedom, so that every value of '{sought.name}' is held{more}"


def _coordinates(system: System, workspace: Workspace) -> np.ndarray:
    """(joints, 3 nb) rows w of the free coordinates of all joints with friction, from the workspace."""
    found = np.zeros((len(system.dry_joints), system.body_count + 1, 3))
    for n, entry in enumerate(system.arrays["dry"]):
        found[n, entry[at.DRY_A]] += workspace.dry_rows[n, at.AX : at.AP + 1]
        found[n, entry[at.DRY_B]] += workspace.dry_rows[n, at.BX : at.BP + 1]
    return found[:, 1:].reshape(len(found), -1)


def _limit(system: System, workspace: Workspace, motion: Motion, free: float, sense: float) -> tuple[Rubbing, Limit]:
    """The limit of motion in one sense; joints that do not move rub the way that holds most."""
    dry = system.arrays["dry"]
    dry = dry[dry[:, at.DRY_LAW] < 0]
    p, values = dry[:, at.DRY_P], workspace.values
    arm = values[p + at.DRY_ARM]
    reach = np.where(dry[:, at.DRY_FORM] == at.DRY_PIN, math.nan, values[p + at.DRY_REACH])
    rate = motion.coordinate @ motion.z
    size = np.abs(motion.coordinate) @ np.abs(motion.z)
    still = np.flatnonzero(np.abs(rate) <= 1e-9 * size)
    rate[still] = 0.0
    rows = np.stack([motion.row, motion.row + 1], axis=1)
    bare = (motion.inverse @ (motion.force + free * motion.direction))[rows]
    sizes = np.abs(motion.inverse @ motion.force).max(initial=0.0) + abs(free) * np.abs(
        motion.inverse @ motion.direction
    ).max(initial=0.0)
    best: tuple[Rubbing, Limit] | None = None
    for signs in itertools.product((1.0, -1.0), repeat=min(len(still), MOST_STILL)):
        way = np.sign(rate)
        way[still[:MOST_STILL]] = signs
        slip = np.abs(rate) * arm
        acting = sense * (slip[:, None] * motion.direction - (way * arm)[:, None] * motion.coordinate)
        response = np.moveaxis((acting @ motion.inverse.T)[:, rows], 0, 2)
        one = Rubbing(values[p + at.DRY_MU_STATIC], reach, bare, response, slip, NOTHING * sizes)
        found = limit(one)
        if best is None or _more(one, found) > _more(*best):
            best = one, found
    assert best is not None
    return best


def _more(rubbing: Rubbing, found: Limit) -> float:
    """By how much the load differs at its limit from the one without friction."""
    unbounded = np.isinf(found.x).any()
    return math.inf if unbounded else float(rubbing.slip @ found.x)


def _doubtful(system: System, rubbing: Rubbing, found: Limit) -> list[str]:
    """Joints whose friction need not be at its limit for the load to be largest."""
    if not np.isfinite(found.x).all() or not found.x.any():
        return []
    held = [name for name, law in zip(system.dry_joints, system.arrays["dry"][:, at.DRY_LAW], strict=True) if law < 0]
    return [name for name, less in zip(held, yields_more(rubbing, found.x), strict=True) if less]


def _notes(system: System, stops: str, doubtful: list[str]) -> tuple[str, ...]:
    """What the interval leaves out."""
    notes = []
    if stops:
        notes.append(f"the stops of {stops} are left out")
    creeping = [name for name, one in system.model.joints.items() if one.friction and one.friction.law is not None]
    if creeping:
        notes.append(f"friction in {', '.join(creeping)} is left out: its law does not hold at rest")
    if doubtful:
        notes.append(
            f"less friction in {', '.join(doubtful)} than its limit would let the other joints hold more: just outside"
            " the interval rest and motion are both possible"
        )
    return tuple(notes)
