"""Singular positions of a driven mechanism: dead centres that end its motion, branch points that it passes."""

from __future__ import annotations

import math

import numpy as np

from rattle.analyses.assembly.rank import describe_rank_loss, left_null, scaled_rows
from rattle.analyses.dynamics.singular_passages import Passage
from rattle.analyses.undefined import driver_left_a_table
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.equations.motion import drive
from rattle.questions.kinematics.sweep import Sweep
from rattle.results.columns import motion
from rattle.results.event import Event
from rattle.solvers.positions import position_sweep as swept
from rattle.solvers.singular_passage import NEAR

FIRST_LOOK = 1e-3  # share of the time beside a branch point at which the root is first looked at
BEYOND = (0.0, 1e-12, 1e-9, 1e-6)  # [of the time, at least of 1 s] after the end, where drivers are looked at
WEAK = 1e-3  # [-] singular value of scaled rows below which constraints count as dependent near a singular position
TAKES_PART = 0.05  # [-] share in the loss of rank from which a joint is named
END = 1e-6  # [of the time, at least of 1 s] before the end of the motion: what is passed there is that end
SAME = 1e-9  # [of the time, at least of 1 s] between roots that are one
ROOT = 1e-14  # [of the time] to which a root is located: rounding
LOOKS = 3  # each puts the next where a straight line has the root NEAR


def why_stuck(sweep: Sweep) -> str:
    """Why a sweep cannot go on, in words."""
    system, workspace = sweep.system, sweep.workspace
    t = float(sweep.clock[swept.NOW])
    for ahead in BEYOND:
        drive(workspace, t + ahead * max(1.0, abs(t)))
        for name in system.model.drivers:
            slot = system.driver_slot(name)
            if not np.isfinite(workspace.values[slot : slot + 3]).all():
                if left := driver_left_a_table(system, workspace, name, t + ahead * max(1.0, abs(t))):
                    return left
                return f"the function of driver '{name}' has no finite value after t = {t:.10g} s; check its domain"
    open_by(workspace, t, sweep.node[swept.Q], sweep.node[swept.V])
    where = describe_rank_loss(system, workspace)
    if where:
        return f"no position beyond t = {t:.10g} s: {where}"
    return f"no continuation at t = {t:.10g} s: a driver's function jumps there or is too fast to follow; smooth it"


def blocking(sweep: Sweep) -> str:
    """The joint or driver with the largest part in the loss of rank."""
    open_by(sweep.workspace, float(sweep.clock[swept.NOW]), sweep.node[swept.Q], sweep.node[swept.V])
    free = left_null(sweep.system, sweep.workspace, WEAK)
    if free.shape[1] == 0:
        return ""
    return sweep.system.rows[int(np.abs(free).max(axis=1).argmax())].owner


def branch_points(
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
        instant = _locate(first, times, raw, rows, min(low, high), max(low, high))
        if stuck and abs(high - sweep.clock[swept.NOW]) < END * max(1.0, abs(high)):
            continue  # the approach to the end of the motion
        if instant is None or any(abs(instant - event.t) < SAME * max(1.0, abs(instant)) for event in events):
            continue
        near = _at(first, times, raw, instant)
        open_by(near.workspace, instant, near.node[swept.Q_NEW], near.node[swept.V_NEW])
        free = left_null(system, near.workspace, WEAK)
        share = np.abs(free).max(axis=1, initial=0.0)
        owners = list(dict.fromkeys(system.rows[int(r)].owner for r in np.argsort(-share) if share[r] > TAKES_PART))
        events.append(Event(instant, owners[0] if owners else "", "branch point"))
        notes.append(
            f"branch point at t = {instant:.9g} s: constraints of {', '.join(owners[:6])} lose rank,"
            " another motion starts there; the smooth one was followed, forces are not determined at that instant"
        )
    return events, notes


def passed_there(first: Sweep, times: np.ndarray, raw: np.ndarray, events: list[Event]) -> tuple[Passage, ...]:
    """The branch points among the events, with the times around them in which forces are not to be trusted."""
    passed = []
    for event in events:
        if event.kind == "branch point":
            half = _reach(first, times, raw, event.t)
            passed.append(Passage(event.t, (), event.t - half, event.t + half))
    return tuple(passed)


def _reach(first: Sweep, times: np.ndarray, raw: np.ndarray, t: float) -> float:
    """Time [s] from a branch point at t [s] to where the root, a straight line there, is NEAR."""
    low, high = float(min(times[0], times[-1])), float(max(times[0], times[-1]))
    room = max(high - t, t - low)
    side = 1.0 if high - t >= t - low else -1.0
    half = FIRST_LOOK * room
    for _ in range(LOOKS):
        aside = _at(first, times, raw, t + side * half)
        _, root, _, _ = swept.closed_at(aside.workspace, t + side * half, aside.node, first.system.size)
        half = min(half * NEAR / root, room) if root > 0.0 else min(2.0 * half, room)
    return half


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
    sweep = first.fork()
    k = int(np.searchsorted(times[: len(raw)], t, side="right")) - 1
    while k > 0 and times[k] > sweep.clock[swept.NOW]:
        sweep.node[swept.Q_NEW : swept.Q_OLD] = motion(first.system, raw[k])
        _, root, _, _ = swept.closed_at(sweep.workspace, times[k], sweep.node, first.system.size)
        if root > 2 * swept.WEAK_ROOT:
            sweep.node[: swept.Q_NEW] = sweep.node[swept.Q_NEW : swept.Q_OLD]
            sweep.clock[:] = times[k], math.inf, 0.0, root, root, times[k]
            break
        k -= 1
    sweep.go(np.array([t]), False)
    return sweep


def _locate(
    first: Sweep, times: np.ndarray, raw: np.ndarray, rows: np.ndarray, low: float, high: float
) -> float | None:
    """Root [s] of the determinant of the independent rows between two times [s], by false position (Illinois)."""

    def determinant(t: float) -> float:
        sweep = _at(first, times, raw, t)
        open_by(sweep.workspace, t, sweep.node[swept.Q_NEW], sweep.node[swept.V_NEW])
        return float(np.linalg.det(scaled_rows(first.system, sweep.workspace)[rows]))

    f_low, f_high = determinant(low), determinant(high)
    if not f_low * f_high < 0.0:
        return None
    side = 0
    for _ in range(60):
        t = (low * f_high - high * f_low) / (f_high - f_low)
        if not low < t < high or high - low < ROOT * max(abs(low), abs(high)):
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
