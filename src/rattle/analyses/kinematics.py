"""Kinematics and inverse dynamics: motion of a fully driven mechanism, position by position, and its forces."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rattle import registry
from rattle.analyses import arguments
from rattle.analyses.assembly.assembly import Assembled, assemble
from rattle.analyses.assembly.rank import describe_rank_loss, left_null, nonunique_reactions, scaled_rows
from rattle.analyses.timetable import jump_notes, timetable
from rattle.description.model import before_function
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.equations.motion import drive
from rattle.equations.system import System
from rattle.errors import AssemblyError, ModelError, Problem, SolverError, suggest
from rattle.jit import functions
from rattle.jit.workspace import Workspace
from rattle.results.build import build_result
from rattle.results.columns import columns, motion, motion_columns, motion_width, width
from rattle.results.event import Event
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.solvers.positions import position_sweep as swept

log = logging.getLogger("rattle")

SPOTS = 256
PIECE = 40_000  # rows times positions that are computed between two checks for Ctrl-C


@dataclass
class Sweep:
    """The state of one sweep over the positions: where it stands, and what it has met."""

    system: System
    workspace: Workspace
    node: np.ndarray  # (9, 3 nb), see solvers.position_sweep
    clock: np.ndarray
    tally: np.ndarray
    spots: np.ndarray
    probe: np.ndarray  # (k, 5) motors whose effort replaces that of a driver
    line: np.ndarray

    def go(self, times: np.ndarray, forces: bool) -> np.ndarray:
        """Output rows (k, width) [SI] at the first k of the times [s], as far as they can be reached."""
        count = (width(self.system) + 2 * len(self.probe)) if forces else motion_width(self.system)
        raw = np.zeros((len(times), count))
        done, onward = 0, 0.0
        size = max(2, PIECE // max(1, self.system.row_count))
        while done < len(times):  # in pieces, so that Ctrl-C works
            part = slice(done, done + size)
            self.tally[swept.COUNT] = 0
            swept.sweep(
                self.workspace, times[part], raw[part], self.node, self.clock, self.tally, self.spots,
                self.system.size, forces, self.probe, self.line, onward,
            )  # fmt: skip
            done += int(self.tally[swept.COUNT])
            if self.tally[swept.COUNT] < len(times[part]):
                break
            if done < len(times):
                onward = 1.0 if times[done] >= times[done - 1] else -1.0
        self.tally[swept.COUNT] = done
        return raw[:done]

    def fork(self) -> Sweep:
        """A copy that goes on from the same place and leaves this sweep unchanged."""
        return replace(
            self, node=self.node.copy(), clock=self.clock.copy(), tally=np.zeros(4, np.int64), spots=np.zeros((0, 2))
        )


def begin(
    system: System, start: Assembled, motors: Sequence[tuple[int, str]] = (), shift: np.ndarray | None = None
) -> Sweep:
    """A sweep that stands at an assembled start.

    motors: (constraint row of a driver, joint whose motor does its work).  shift: (n,) parameters [SI] to be used
    instead of the system's.  Raises ModelError if degrees of freedom are left.
    """
    radius = np.array(
        [max([math.hypot(*at) for at in body.points.values()] + [0.0]) for body in system.model.bodies.values()]
    )
    weight = np.ones_like(system.arrays["weight"])
    weight[0] = 0.0
    weight[1:, 2] = 1.0 / np.where(radius > 0.0, radius, system.size) ** 2
    values = list(system.arrays["values"] if shift is None else shift)
    probe = []
    for row, name in motors:
        joint = system.model.joints[name]
        number = {"ground": 0, **{body: n + 1 for n, body in enumerate(system.bodies)}}
        driver = registry.kinds("driver")[joint.leaf.motor.driver]
        tag = len(registry.kinds("joint")) + driver.tag
        probe.append((tag, number[joint.a.body], number[joint.b.body], len(values), row))
        values += [*joint.a.at, *joint.b.at, *before_function(joint, driver), 0.0, 0.0, 0.0]
    arrays = {**system.arrays, "weight": weight, "values": np.array(values, dtype=float)}
    workspace = replace(system, arrays=arrays).workspace(also=[one[0] for one in probe])
    node = np.zeros((9, 3 * system.body_count))
    made = Sweep(
        system, workspace, node, np.array([start.t, math.inf, 0.0, 1.0, 1.0, start.t]), np.zeros(4, np.int64),
        np.zeros((SPOTS, 2)), np.array(probe, np.int64).reshape(-1, 5), np.zeros((1, 9)),
    )  # fmt: skip
    node[swept.Q_NEW], node[swept.V_NEW] = start.q, start.v
    for _ in range(2):  # the second pass uses the rates found by the first
        _, root, _, _ = swept.closed_at(workspace, start.t, node, system.size)
    node[: swept.Q_NEW] = node[swept.Q_NEW : swept.Q_OLD]
    made.clock[swept.ROOT] = made.clock[swept.ROOT_BEFORE] = root
    return made


def require_driven(system: System, start: Assembled, what: str) -> None:
    """Raise ModelError with the degrees of freedom that are left, unless the drivers determine every position."""
    workspace = system.workspace()
    open_by(workspace, start.t, start.q, start.v)
    rows = scaled_rows(system, workspace)
    _, values, right = np.linalg.svd(rows)
    independent = int((values > 1e-9 * values[0]).sum()) if len(values) else 0
    left = 3 * system.body_count - independent
    if left == 0:
        return
    if (
        system.row_count >= 3 * system.body_count
        and left_null(system, workspace).shape[1] <= 1 + system.row_count - 3 * system.body_count
    ):
        where = describe_rank_loss(system, workspace)
        raise ModelError([Problem(("initial",), f"{what} cannot start at t = {start.t:g} s: {where}")])
    free = np.abs(right[independent:]).reshape(left, -1, 3).max(axis=(0, 2))
    movers = [name for name, share in zip(system.bodies, free, strict=True) if share > 1e-6]
    loose = _loose(system)
    dof = f"{left} degrees of freedom are left" if left > 1 else "1 degree of freedom is left"
    names = ", ".join(movers[:8]) + (" ..." if len(movers) > 8 else "")
    text = f"{what} needs drivers that determine every position; {dof} (can still move: {names})."
    if loose:
        text += f" There is clearance in {loose}: close it with ideal() or --ideal."
    else:
        text += f" Add {'a driver' if left == 1 else f'{left} drivers'}, or use simulate or equilibrium."
    raise ModelError([Problem(("drivers",), text)])


def _loose(system: System) -> str:
    """Names of the joints with open clearance."""
    joints = system.model.joints.items()
    return ", ".join(name for name, one in joints if one.contact and one.clearance and not one.contact.closed)


def analyse(
    system: System, start: Assembled | None, t_eval: float | Sequence[float] | np.ndarray, *, forces: bool,
    effort_at: str | Mapping[str, str] | None = None, strict: bool = False,
) -> Result:  # fmt: skip
    """Kinematics, or with `forces` inverse dynamics, at the times t_eval [s].

    See `Mechanism.kinematics` and `Mechanism.inverse_dynamics`, which also say what is raised.
    """
    began = time.perf_counter()
    times = instants(t_eval)
    what = "inverse dynamics" if forces else "kinematics"
    functions.start()
    if start is None:
        try:
            start = assemble(system, float(times[0]))
        except AssemblyError as error:
            loose = _loose(system)
            hint = f" There is clearance in {loose}: close it with ideal() or --ideal." if loose else ""
            raise AssemblyError(f"{error}{hint}") from None
    if system.row_count <= LARGE:
        require_driven(system, start, what)
    jumps = timetable(system, min(start.t, float(times[0])), float(times[-1])).jumps
    motors = _motors(system, effort_at)
    arguments.require_room(len(times), width(system))
    sweep = begin(system, start, motors)
    if times[0] != start.t:  # the start values are given for t = 0: begin there
        if not len(sweep.go(times[:1], False)):
            raise AssemblyError(f"the first position cannot be reached: {why_stuck(sweep)}")
        sweep.tally[:] = 0
        sweep.clock[swept.GAP] = 0.0
    first = sweep.fork()
    raw = sweep.go(times, forces)
    reached = times[: len(raw)]
    message = why_stuck(sweep) if len(raw) < len(times) else ""
    events, notes = _branch_points(first, sweep, times, raw, bool(message))
    notes = [*start.notes, *notes, *_without_effort(sweep, reached, raw, motors)]
    if message:
        ends = float(sweep.clock[swept.NOW])
        events.append(Event(ends, _blocking(sweep), "dead centre" if "dead centre" in message else "end"))
    notes += jump_notes([jump for jump in jumps if len(reached) and jump.t <= reached[-1]], forces)
    result = _result(sweep, reached, raw, forces, motors, message, events, notes, time.perf_counter() - began)
    if message:
        log.warning(message)
        if strict:
            raise SolverError(message, result)
    return result


def _without_effort(sweep: Sweep, t: np.ndarray, raw: np.ndarray, motors: list[tuple[int, str]]) -> list[str]:
    """A note for every motor that cannot do the work of its driver at some instants: how many, and when."""
    notes = []
    for n, (row, joint) in enumerate(motors):
        dead = ~np.isfinite(raw[:, width(sweep.system) + 2 * n])
        if dead.any():
            listed = ", ".join(f"{one:.6g}" for one in t[dead][:4]) + (" ..." if dead.sum() > 4 else "")
            effort = sweep.system.model.joints[joint].leaf.motor.effort
            notes.append(
                f"{joint}.{effort}: none at {int(dead.sum())} of {len(t)} instants (t = {listed} s): '{joint}' is at a"
                f" dead centre there, where no effort of it does the work of driver '{sweep.system.rows[row].owner}';"
                " forces and efforts are nan at these instants and grow without bound next to them"
            )
    return notes


def instants(t_eval: float | Sequence[float] | np.ndarray) -> np.ndarray:
    """t_eval [s] as an array (n,).  Raises ValueError unless the times are increasing and finite."""
    times = np.atleast_1d(arguments.instants(t_eval))
    if times.ndim != 1 or len(times) == 0 or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise ValueError("t_eval must be one time or increasing finite times in s")
    return times


def _motors(system: System, effort_at: str | Mapping[str, str] | None) -> list[tuple[int, str]]:
    """(constraint row of the driver, joint) for every driver whose work is done by a motor at another joint."""
    if effort_at is None:
        return []
    drivers, joints = list(system.model.drivers), system.model.joints
    if isinstance(effort_at, str):
        if len(drivers) != 1:
            raise ValueError(f"effort_at: give the driver that is replaced, as {{'{drivers[0]}': '{effort_at}'}}")
        effort_at = {drivers[0]: effort_at}
    found = []
    for driver, joint in effort_at.items():
        if driver not in drivers:
            raise ValueError(f"effort_at: no driver '{driver}'{suggest(driver, drivers)}")
        if joint not in joints:
            raise ValueError(f"effort_at: no joint '{joint}'{suggest(joint, joints)}")
        if joints[joint].leaf.motor is None:
            known = " or ".join(name for name, one in registry.kinds("joint").items() if one.leaf.motor)
            raise ValueError(
                f"effort_at: a {joints[joint].kind} joint has no degree of freedom for a motor; expected {known}"
            )
        found.append((system.first_row(driver), joint))
    if len({joint for _, joint in found}) < len(found):
        raise ValueError("effort_at: one joint cannot do the work of two drivers")
    return found


# ---------------------------------------------------------------- what happened
def why_stuck(sweep: Sweep) -> str:
    """Why a sweep cannot go on, in words."""
    system, workspace = sweep.system, sweep.workspace
    t = float(sweep.clock[swept.NOW])
    for ahead in (0.0, 1e-12, 1e-9, 1e-6):
        drive(workspace, t + ahead * max(1.0, abs(t)))
        for name in system.model.drivers:
            slot = system.driver_slot(name)
            if not np.isfinite(workspace.values[slot : slot + 3]).all():
                return f"the function of driver '{name}' has no finite value after t = {t:.10g} s; check its domain"
    open_by(workspace, t, sweep.node[swept.Q], sweep.node[swept.V])
    where = describe_rank_loss(system, workspace)
    if where:
        return f"no position beyond t = {t:.10g} s: {where}"
    return f"no continuation at t = {t:.10g} s: a driver's function jumps there or is too fast to follow; smooth it"


def _blocking(sweep: Sweep) -> str:
    """The joint or driver with the largest part in the loss of rank."""
    open_by(sweep.workspace, float(sweep.clock[swept.NOW]), sweep.node[swept.Q], sweep.node[swept.V])
    free = left_null(sweep.system, sweep.workspace, 1e-3)
    if free.shape[1] == 0:
        return ""
    return sweep.system.rows[int(np.abs(free).max(axis=1).argmax())].owner


def _branch_points(
    first: Sweep, sweep: Sweep, times: np.ndarray, raw: np.ndarray, stuck: bool
) -> tuple[list[Event], list[str]]:
    """Events and notes of positions that the motion passed and from which another motion starts."""
    system = sweep.system
    events: list[Event] = []
    if system.row_count > LARGE:
        return events, []
    rows = _independent(first)
    notes = []
    for low, high in sweep.spots[: sweep.tally[swept.FOUND]]:
        found = _locate(first, times, raw, rows, min(low, high), max(low, high))
        if stuck and abs(high - sweep.clock[swept.NOW]) < 1e-6 * max(1.0, abs(high)):
            continue  # the approach to the end of the motion
        if found is None or any(abs(found - event.t) < 1e-9 * max(1.0, abs(found)) for event in events):
            continue
        near = _at(first, times, raw, found)
        open_by(near.workspace, found, near.node[swept.Q_NEW], near.node[swept.V_NEW])
        free = left_null(system, near.workspace, 1e-3)
        share = np.abs(free).max(axis=1, initial=0.0)
        owners = list(dict.fromkeys(system.rows[int(r)].owner for r in np.argsort(-share) if share[r] > 0.05))
        events.append(Event(found, owners[0] if owners else "", "branch point"))
        notes.append(
            f"branch point at t = {found:.9g} s: constraints of {', '.join(owners[:6])} lose rank,"
            " another motion starts there; the smooth one was followed, forces are not determined at that instant"
        )
    return events, notes


def _independent(first: Sweep) -> np.ndarray:
    """Indices of the constraint rows that determine the position at the start; the others are redundant."""
    from scipy.linalg import qr

    open_by(first.workspace, float(first.clock[swept.NOW]), first.node[swept.Q], first.node[swept.V])
    count = 3 * first.system.body_count
    if first.system.row_count == count:
        return np.arange(count)
    order = qr(scaled_rows(first.system, first.workspace).T, mode="r", pivoting=True)[1]
    return np.sort(order[:count])


def _at(first: Sweep, times: np.ndarray, raw: np.ndarray, t: float) -> Sweep:
    """The sweep at time t [s] (in the rows Q_NEW, V_NEW of its node), restarted from the last output before t."""
    made = first.fork()
    k = int(np.searchsorted(times[: len(raw)], t, side="right")) - 1
    while k > 0 and times[k] > made.clock[swept.NOW]:
        made.node[swept.Q_NEW : swept.Q_OLD] = motion(first.system, raw[k])
        _, root, _, _ = swept.closed_at(made.workspace, times[k], made.node, first.system.size)
        if root > 2 * swept.WEAK_ROOT:
            made.node[: swept.Q_NEW] = made.node[swept.Q_NEW : swept.Q_OLD]
            made.clock[:] = times[k], math.inf, 0.0, root, root, times[k]
            break
        k -= 1
    made.go(np.array([t]), False)
    return made


def _locate(
    first: Sweep, times: np.ndarray, raw: np.ndarray, rows: np.ndarray, low: float, high: float
) -> float | None:
    """Root [s] of the determinant of the independent rows between two times [s], by false position (Illinois)."""

    def determinant(t: float) -> float:
        made = _at(first, times, raw, t)
        open_by(made.workspace, t, made.node[swept.Q_NEW], made.node[swept.V_NEW])
        return float(np.linalg.det(scaled_rows(first.system, made.workspace)[rows]))

    f_low, f_high = determinant(low), determinant(high)
    if not f_low * f_high < 0.0:
        return None
    side = 0
    for _ in range(60):
        t = (low * f_high - high * f_low) / (f_high - f_low)
        if not low < t < high or high - low < 1e-14 * max(abs(low), abs(high)):
            break
        f = determinant(t)
        if f == 0.0:
            return t
        if f * f_low < 0.0:
            high, f_high = t, f
            f_low *= 0.5 if side == 1 else 1.0
            side = 1
        else:
            low, f_low = t, f
            f_high *= 0.5 if side == -1 else 1.0
            side = -1
    return (low * f_high - high * f_low) / (f_high - f_low)


# ---------------------------------------------------------------- the result
def _result(
    sweep: Sweep, t: np.ndarray, raw: np.ndarray, forces: bool, motors: list[tuple[int, str]], message: str,
    events: list[Event], notes: list[str], wall: float,
) -> Result:  # fmt: skip
    system, model = sweep.system, sweep.system.model
    nonunique: tuple[str, ...] = ()
    if forces:
        data, names, units = columns(system, raw[:, : width(system)])
        replaced = {system.rows[row].owner for row, _ in motors}
        drop = {f"energy.{key}" for key in ("work", "dissipated", "balance")}
        keep = [k for k, name in enumerate(names) if name not in drop and name.partition(".")[0] not in replaced]
        data, names = data[:, keep], [names[k] for k in keep]
        for n, (_, joint) in enumerate(motors):
            _, effort, unit = model.joints[joint].leaf.motor
            names += [f"{joint}.{effort}", f"{joint}.power"]
            units |= {f"{joint}.{effort}": unit, f"{joint}.power": "W"}
            data = np.column_stack([data, raw[:, width(system) + 2 * n : width(system) + 2 * n + 2]])
        if system.row_count > 3 * system.body_count:
            open_by(sweep.workspace, float(sweep.clock[swept.NOW]), sweep.node[swept.Q], sweep.node[swept.V])
            nonunique = nonunique_reactions(system, sweep.workspace)
        data = np.ascontiguousarray(data)
    else:
        names, units = motion_columns(system)
        data = raw
    trust = Trust(
        drift=float(sweep.clock[swept.GAP]), energy_balance=math.nan, t_end=float(t[-1]) if len(t) else 0.0,
        horizon=float(t[-1]) if len(t) else 0.0, nonunique=nonunique, notes=tuple(notes),
    )  # fmt: skip
    stats = {
        "positions": len(t),
        "steps": int(sweep.tally[swept.STEPS]),
        "iterations": int(sweep.tally[swept.NEWTON]),
        "wall_time": wall,
    }
    return build_result(
        model, "inverse dynamics" if forces else "kinematics", t=t, data=data, names=names, units=units, trust=trust,
        stats=stats, events=events, message=message,
    )  # fmt: skip
