"""Which values of one load dry friction in the joints holds at rest, at one position of one degree of freedom."""

from __future__ import annotations

import math

import numpy as np

from rattle import registry
from rattle.analyses.load_forces import gravity_over, load_forces
from rattle.analyses.travel import with_stops, without_stops
from rattle.equations.dense import dense_rows
from rattle.equations.placement import point_at
from rattle.equations.system import System, compile_system
from rattle.errors import InputError, suggest
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.questions.equilibrium.compute import position_at
from rattle.questions.equilibrium.position import Equilibrium
from rattle.questions.holds.holding_range import HoldingRange
from rattle.questions.holds.impending_motion import yields_more
from rattle.questions.holds.one_motion import Impending, Sought, evaluated, impending, one_motion, require_answerable
from rattle.questions.holds.resting_bodies import require_rigid, rests_on_surfaces, surfaces_range

GRAVITY = "gravity"  # the name by which it is asked for


def holding_range(system: System, name: str, t: float, at_rest: Equilibrium | None) -> HoldingRange:
    """The interval of values of a load, or of the effort of a driver, that friction holds; see `Mechanism.holds`."""
    original, system, t, q = position_asked(system, t, at_rest)
    workspace = evaluated(system, t, q)
    sought = _sought(system, workspace, name, t, q)
    if rests_on_surfaces(system.model):
        return surfaces_range(system, sought, t, q, left_out(original))
    motion = one_motion(system, workspace, sought)
    low, high = (impending(system, workspace, motion, sense) for sense in (-1.0, 1.0))
    doubtful = sorted({joint for end in (low, high) for joint in _doubtful(system, end)})
    return HoldingRange(
        sought.name, sought.unit, sought.value, low.load, high.load, motion.free,
        (low.limit.jams_at, high.limit.jams_at), t, q, (*left_out(original), *_doubts(doubtful)),
    )  # fmt: skip


def position_asked(system: System, t: float, at_rest: Equilibrium | None) -> tuple[System, System, float, np.ndarray]:
    """The mechanism as given and without stops, its time [s] and position (3 nb,) [m, m, rad].

    Raises ModelError, AssemblyError, ValueError if friction holds nothing there or nothing is known of it.
    """
    functions.start()
    if rests_on_surfaces(system.model):
        require_rigid(system)
    else:
        require_answerable(system)
    bare = compile_system(without_stops(system.model)) if with_stops(system.model) else system
    if at_rest is None:
        return system, bare, t, position_at(bare, t)
    if len(at_rest.q) != 3 * bare.body_count:
        raise InputError("at: this equilibrium belongs to another mechanism")
    return system, bare, at_rest.t, at_rest.q


def _sought(system: System, workspace: Workspace, name: str, t: float, q: np.ndarray) -> Sought:
    """The load or driver of that name.  Raises InputError."""
    model = system.model
    if name in model.drivers:
        effort = model.drivers[name].leaf.effort
        row = system.first_row(name)
        return Sought(f"{name}.{effort[0]}", dense_rows(system, workspace)[row], effort[1], math.nan, row)
    if name == GRAVITY and name not in model.loads:
        mass = system.arrays["mass"][1:, :1]
        weight = np.zeros((system.body_count, 3))
        weight[:, :2] = mass * gravity_over(system, np.array([t]))[0]
        return _scaled(name, weight.ravel(), "", 1.0)
    if name not in model.loads:
        names = [*model.loads, *model.drivers, GRAVITY]
        raise InputError(f"no load or driver '{name}'{suggest(name, names)}")
    return _sought_load(system, name, t, q)


def _sought_load(system: System, name: str, t: float, q: np.ndarray) -> Sought:
    """The load of that name, with its value in the unit in which it acts.  Raises InputError."""
    model = system.model
    load, force = model.loads[name], load_forces(system, t, q, np.zeros_like(q))[name]
    end = force[0 if load.b.body == "ground" else 1 + system.bodies.index(load.b.body)]
    kind = registry.kinds("load")[load.kind] if load.law is None else None
    record = kind.leaf.record if kind else None
    acts = next((field.unit for field in kind.fields.values() if field.live), "") if kind and record is None else ""
    if record is None:
        value = {"N": float(np.hypot(*end[:2])), "N*m": float(end[2])}.get(acts, 1.0)
        return _scaled(name, force[1:].ravel(), acts if acts in ("N", "N*m") else "", value)
    value = record.power * float(end[2])
    if record.unit == "N":
        line = point_at(system, q, load.b) - point_at(system, q, load.a)
        value = math.copysign(float(np.hypot(*end[:2])), record.power * float(line @ end[:2]))
    return _scaled(name, force[1:].ravel(), record.unit, value)


def _scaled(name: str, force: np.ndarray, unit: str, value: float) -> Sought:
    """A load of that force (3 nb,) at its present value."""
    if not force.any() or value == 0.0:
        raise InputError(
            f"'{name}' exerts nothing at this position, so it has no direction; give it a value there, of any size"
        )
    return Sought(name, force / value, unit, value, -1)


def _doubtful(system: System, motion: Impending) -> list[str]:
    """Joints whose friction need not be at its limit for the load to be largest."""
    x = motion.limit.x
    if not np.isfinite(x).all() or not x.any():
        return []
    held = [name for name, law in zip(system.dry_joints, system.arrays["dry"][:, at.DRY_LAW], strict=True) if law < 0]
    return [name for name, less in zip(held, yields_more(motion.rubbing, x), strict=True) if less]


def _doubts(doubtful: list[str]) -> tuple[str, ...]:
    """A note on such joints."""
    if not doubtful:
        return ()
    words = "would let the other joints hold more: just outside the interval rest and motion are both possible"
    return (f"less friction in {', '.join(doubtful)} than its limit {words}",)


def left_out(system: System) -> tuple[str, ...]:
    """What of the model is left out where friction holds, in words."""
    notes, stops = [], with_stops(system.model)
    if stops:
        notes.append(f"the stops of {stops} are left out")
    creeping = [
        name for name, joint in system.model.joints.items() if joint.friction and joint.friction.law is not None
    ]
    if creeping:
        notes.append(f"friction in {', '.join(creeping)} is left out: its law does not hold at rest")
    return tuple(notes)
