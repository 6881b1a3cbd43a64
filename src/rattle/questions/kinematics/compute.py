"""Kinematics and inverse dynamics: motion of a fully driven mechanism, position by position, and its forces."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.assembly.assembly import Assembled, assemble
from rattle.analyses.assembly.rank import RANK, describe_rank_loss, left_null, nonunique_reactions, scaled_rows
from rattle.analyses.dynamics.report import leave_out
from rattle.analyses.dynamics.singular_passages import Passage
from rattle.analyses.grip import grip_notes
from rattle.analyses.history import require_known_torques, require_no_states, run_backwards
from rattle.analyses.passed_surfaces import past_surfaces
from rattle.analyses.timetable import jump_notes, timetable
from rattle.analyses.travel import out_of_place, past_stops, places, rates, with_stops, without_stops
from rattle.analyses.undefined import undefined
from rattle.description.model import Model
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.equations.motion import loads, place
from rattle.equations.system import System, compile_system, is_link
from rattle.errors import AssemblyError, InputError, ModelError, Problem, SolverError
from rattle.jit import functions
from rattle.questions.kinematics.motors import motors_at, without_effort
from rattle.questions.kinematics.singular_positions import blocking, branch_points, passed_there, why_stuck
from rattle.questions.kinematics.sweep import Sweep, begin, unjoined
from rattle.results.build import build_result
from rattle.results.columns import columns, motion, motion_columns, width
from rattle.results.event import Breaks, Event
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.solvers.positions import position_sweep as swept

log = logging.getLogger("rattle")
MOVES = 1e-6  # [-] share of a body in a free motion above which it is named: what is less is rounding
BESIDE = 1e-9  # share of the span at which the values on either side of a switch are taken
MOST_NUMBERS = 8_000_000  # of rows beside switches


def require_driven(system: System, start: Assembled, what: str) -> None:
    """Raise ModelError with the degrees of freedom that are left, unless the drivers determine every position."""
    workspace = system.workspace()
    open_by(workspace, start.t, start.q, start.v)
    rows = scaled_rows(system, workspace)
    _, values, right = np.linalg.svd(rows)
    independent = int((values > RANK * values[0]).sum()) if len(values) else 0
    alone = unjoined(system) if what == "kinematics" else []
    left = 3 * (system.body_count - len(alone)) - independent
    if left == 0:
        return
    if (
        system.row_count >= 3 * system.body_count
        and left_null(system, workspace).shape[1] <= 1 + system.row_count - 3 * system.body_count
    ):
        where = describe_rank_loss(system, workspace)
        raise ModelError([Problem(("initial",), f"{what} cannot start at t = {start.t:g} s: {where}")])
    free = np.abs(right[independent:]).reshape(-1, system.body_count, 3).max(axis=(0, 2))
    movers = [name for name, share in zip(system.bodies, free, strict=True) if share > MOVES and name not in alone]
    dof = f"{left} degrees of freedom are left" if left > 1 else "1 degree of freedom is left"
    names = ", ".join(movers[:8]) + (" ..." if len(movers) > 8 else "")
    text = f"{what} needs drivers that determine every position; {dof} (can still move: {names})."
    raise ModelError([Problem(("drivers",), f"{text} {_remedy(system, left)}")])


def _remedy(system: System, left: int) -> str:
    """What to do about degrees of freedom that are left."""
    if passing := ", ".join(name for name, joint in system.model.joints.items() if joint.passing):
        return f"What holds only where bodies touch ({passing}) is followed by a run in time: use simulate."
    if loose := _loose(system):
        return f"There is {loose}: close it with ideal() or --ideal."
    return f"Add {'a driver' if left == 1 else f'{left} drivers'}, or use simulate or equilibrium."


def _loose(system: System) -> str:
    """Where there is open clearance, or contact on one side only, in words; "" if nowhere."""
    joints = [joint for joint in system.model.joints.values() if joint.is_loose or is_link(joint)]
    play = ", ".join(joint.name for joint in joints if joint.clearance > 0.0)
    sided = ", ".join(joint.name for joint in joints if not joint.clearance > 0.0)
    parts = [f"clearance in {play}" if play else "", f"contact on one side only in {sided}" if sided else ""]
    return " and ".join(part for part in parts if part)


def _without_stretch(system: System) -> System:
    """The system with belts that cannot stretch; itself if there are none."""
    joints = dict(system.model.joints)
    stiff = [
        name
        for name, joint in joints.items()
        if joint.is_loose and joint.one_sided and joint.one_sided.stiff_in_kinematics
    ]
    if not stiff:
        return system
    joints |= {name: replace(joints[name], contact=None) for name in stiff}
    return compile_system(replace(system.model, joints=joints))


def analyse(
    system: System, start: Assembled | None, t_eval: float | Sequence[float] | np.ndarray, *, forces: bool,
    effort_at: str | Mapping[str, str] | None = None, strict: bool = False,
) -> Result:  # fmt: skip
    """Kinematics, or with `forces` inverse dynamics, at the times t_eval [s].

    See `Mechanism.kinematics` and `Mechanism.inverse_dynamics`, which also say what is raised.
    """
    began = time.perf_counter()
    times, original = instants(t_eval), system
    system, start = _as_driven(system, start)
    what = "inverse dynamics" if forces else "kinematics"
    require_no_states(system.model, what)
    functions.start()
    if forces:
        require_known_torques(system, what)
    if start is None:
        start = _assembled(system, float(times[0]))
    if system.row_count <= LARGE:
        require_driven(system, start, what)
    table = timetable(system, min(start.t, float(times[0])), float(times[-1]))
    motors = _motors(system, effort_at)
    arguments.require_room(len(times), width(system))
    sweep = _begun(system, start, motors, times)
    first = sweep.fork()
    raw = sweep.go(times, forces)
    reached = times[: len(raw)]
    message = why_stuck(sweep) if len(raw) < len(times) else ""
    events, branches = branch_points(first, sweep, times, raw, bool(message))
    passed = passed_there(first, times, raw, events) if forces else ()
    notes = [*start.notes, *([] if forces else _left_alone(system)), *branches]
    notes += without_effort(sweep, reached, raw, motors)
    notes += out_of_place(system, reached, places(system, raw))
    notes += past_stops(original, reached, places(system, raw), rates(system, raw))
    notes += past_surfaces(system, reached, places(system, raw), rates(system, raw))
    notes += run_backwards(system, reached, raw)
    notes += _without_value(sweep, reached, raw) if forces else []
    notes += jump_notes([jump for jump in table.jumps if len(reached) and jump.t <= reached[-1]], forces)
    if message:
        events.append(_end(sweep, message))
    spent = time.perf_counter() - began
    sides = _sides(first, reached, table.instants, forces)
    result = _result(original.model, sweep, reached, raw, forces, motors, message, events, notes, spent, sides, passed)
    if message:
        if strict:
            raise SolverError(message, result)
        log.warning(message)
    return result


def rows_with_ports(
    system: System, start: Assembled | None, times: np.ndarray, effort_at: str | Mapping[str, str] | None
) -> tuple[System, np.ndarray, tuple[str, ...]]:
    """Inverse dynamics at increasing times (n,) [s] once more, with the forces of all elements: the system that is

    followed, its rows (n, width with ports, then effort and power of each motor) [SI], and the joints of the motors.
    Raises SolverError where the motion does not come that far.
    """
    functions.start()
    system, start = _as_driven(system, start)
    motors = _motors(system, effort_at)
    sweep = _begun(system, start if start is not None else _assembled(system, float(times[0])), motors, times)
    sweep.ports = True
    rows = sweep.go(times, True)
    if len(rows) < len(times):
        raise SolverError(why_stuck(sweep), None)
    return system, rows, tuple(joint for _, joint in motors)


def _as_driven(system: System, start: Assembled | None) -> tuple[System, Assembled | None]:
    """The system without stops, which do not hold what drivers move, and with belts that cannot stretch; its start."""
    if with_stops(system.model):
        system = compile_system(without_stops(system.model))
    stiff = _without_stretch(system)
    return stiff, start if stiff is system else None


def _motors(system: System, effort_at: str | Mapping[str, str] | None) -> list[tuple[int, str]]:
    """`motors_at`.  Raises ModelError where joints rub."""
    motors = motors_at(system, effort_at)
    if motors and system.dry_joints:
        words = "a motor elsewhere (effort_at) changes the reactions by which joints rub; drive that joint itself"
        raise ModelError([Problem(("joints", system.dry_joints[0], "friction"), words)])
    return motors


def _assembled(system: System, t: float) -> Assembled:
    """The start at t [s].  Raises AssemblyError, which says where there is play if there is."""
    try:
        return assemble(system, t)
    except AssemblyError as error:
        loose = _loose(system)
        if not loose:
            raise
        words = str(error).removesuffix(".")
        raise AssemblyError(f"{words}. There is {loose}: close it with ideal() or --ideal.") from None


def _begun(system: System, start: Assembled, motors: Sequence[tuple[int, str]], times: np.ndarray) -> Sweep:
    """A sweep that has come to the first of the times (n,) [s].  Raises AssemblyError."""
    sweep = begin(system, start, motors)
    if times[0] != start.t:  # the start values are given for t = 0: begin there
        if not len(sweep.go(times[:1], False)):
            raise AssemblyError(f"the first position cannot be reached: {why_stuck(sweep)}")
        sweep.tally[:] = 0
        sweep.clock[swept.GAP] = 0.0
    return sweep


def _end(sweep: Sweep, message: str) -> Event:
    """The event at which a sweep cannot go on; message: why."""
    ends = float(sweep.clock[swept.NOW])
    return Event(ends, blocking(sweep), "dead centre" if "dead centre" in message else "end")


def _left_alone(system: System) -> list[str]:
    """A note on bodies that nothing holds."""
    alone = ", ".join(map(repr, unjoined(system)))
    return [f"no joint and no driver holds {alone}: kinematics leaves it where it is"] if alone else []


def _sides(
    first: Sweep, times: np.ndarray, instants: np.ndarray, forces: bool
) -> tuple[np.ndarray, np.ndarray] | None:  # fmt: skip
    """Times (2 k,) [s] and output rows just before and just after the instants at which expressions switch."""
    if len(times) < 2:
        return None
    beside = BESIDE * float(times[-1] - times[0])
    inside = instants[(instants > times[0] + beside) & (instants <= times[-1])]
    if not len(inside) or 2 * len(inside) * width(first.system) > MOST_NUMBERS:
        return None
    pairs = np.ravel([inside - beside, np.minimum(inside + beside, times[-1])], order="F")
    every = np.union1d(times, pairs)  # the outputs lead on from one to the next
    rows = first.fork().go(every, forces)
    if len(rows) < len(every):
        return None
    return np.repeat(inside, 2), rows[np.searchsorted(every, pairs)]


def _without_value(sweep: Sweep, t: np.ndarray, raw: np.ndarray) -> list[str]:
    """A note if forces are not finite because a load or an expression is not: which, why, and how often."""
    system, workspace = sweep.system, sweep.workspace
    lost = ~np.isfinite(raw[:, : width(system)]).all(axis=1)
    if not lost.any():
        return []
    k = int(np.argmax(lost))
    q, v, _ = motion(system, raw[k])
    place(workspace, q, v)
    loads(workspace, float(t[k]))
    why = undefined(system, workspace, float(t[k]))
    return [f"{why}; no forces at {int(lost.sum())} of {len(t)} instants"] if why else []


def instants(t_eval: float | Sequence[float] | np.ndarray) -> np.ndarray:
    """t_eval [s] as an array (n,).  Raises InputError unless the times are increasing and finite."""
    times = np.atleast_1d(arguments.instants(t_eval))
    if times.ndim != 1 or len(times) == 0 or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise InputError("t_eval must be one time or increasing finite times in s")
    return times


# ---------------------------------------------------------------- the result
def _result(
    model: Model, sweep: Sweep, t: np.ndarray, raw: np.ndarray, forces: bool, motors: list[tuple[int, str]],
    message: str, events: list[Event], notes: list[str], wall: float, sides: tuple[np.ndarray, np.ndarray] | None,
    passed: tuple[Passage, ...],
) -> Result:  # fmt: skip
    nonunique: tuple[str, ...] = ()
    data, names, units = _curves(model, sweep, raw, forces, motors)
    if forces and sweep.system.row_count > 3 * sweep.system.body_count:
        open_by(sweep.workspace, float(sweep.clock[swept.NOW]), sweep.node[swept.Q], sweep.node[swept.V])
        nonunique = nonunique_reactions(sweep.system, sweep.workspace)
    if forces:
        notes = [*notes, *grip_notes(sweep.system, t, places(sweep.system, raw), data, names)]
        leave_out(sweep.system, passed, t, data, {name: units.get(name, "") for name in names})
    breaks = None if sides is None else Breaks(sides[0], _curves(model, sweep, sides[1], forces, motors)[0])
    trust = Trust(
        drift=float(sweep.clock[swept.GAP]), energy_balance=math.nan, t_end=float(t[-1]) if len(t) else 0.0,
        horizon=float(t[-1]) if len(t) else 0.0, nonunique=nonunique, notes=tuple(notes),
        singular=tuple(passage.t for passage in passed),
    )  # fmt: skip
    stats = {
        "positions": len(t),
        "steps": int(sweep.tally[swept.STEPS]),
        "iterations": int(sweep.tally[swept.NEWTON]),
        "wall_time": wall,
    }
    return build_result(
        model, "inverse dynamics" if forces else "kinematics", t=t, data=data, names=names, units=units, trust=trust,
        stats=stats, events=events, message=message, breaks=breaks,
    )  # fmt: skip


def _curves(
    model: Model, sweep: Sweep, raw: np.ndarray, forces: bool, motors: list[tuple[int, str]]
) -> tuple[np.ndarray, list[str], dict[str, str]]:
    """Columns of a result from raw rows, their names and SI units."""
    system = sweep.system
    if forces:
        data, names, units = columns(system, raw[:, : width(system)])
        replaced = {system.rows[row].owner for row, _ in motors}
        drop = {f"energy.{key}" for key in ("work", "dissipated", "balance")}
        keep = [k for k, name in enumerate(names) if name not in drop and name.partition(".")[0] not in replaced]
        data, names = data[:, keep], [names[k] for k in keep]
        for n, (_, joint) in enumerate(motors):
            _, effort, unit = model.joints[joint].motor
            names += [f"{joint}.{effort}", f"{joint}.power"]
            units |= {f"{joint}.{effort}": unit, f"{joint}.power": "W"}
            data = np.column_stack([data, raw[:, width(system) + 2 * n : width(system) + 2 * n + 2]])
        return np.ascontiguousarray(data), names, units
    names, units = motion_columns(system)
    return raw, names, units
