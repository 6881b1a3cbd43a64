"""The run of a result once more, step by step, with the ports at the points of Gauss in every step.

Runs are deterministic, and outputs do not change their steps.  So one run goes ahead and finds where steps end, which
is also where contacts, switches and impacts are, and a second one follows with outputs inside these steps, where all
is smooth.  Rows of time stepping hold mean values of whole steps; one of each is enough.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.analyses.dynamics.methods import new_run
from rattle.analyses.dynamics.run import How, Run
from rattle.elements.custom import load_law
from rattle.equations.motion import DONE, PAUSED
from rattle.equations.state import LOSS, STORED, state_layout
from rattle.errors import InputError, SolverError, suggest
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.mechanism import Mechanism
from rattle.registry import kinds
from rattle.solvers.stepper import TIME_STEPPING
from rattle.value_types import Tree

Array = NDArray[np.float64]
GAUSS = 8  # points in a step in which all is smooth
BATCH = 256  # steps between which the second run follows


class Steps(NamedTuple):
    """Some steps of a run; of each the part within the window."""

    start: Array  # (n,) [s]
    end: Array
    rows: Array  # (n, points, columns)
    impulses: Array  # (joints, 6) change of `port_work` in all of them [J]
    moved: Array  # (n, joints) energy [J] that contacts which ended had stored and lost then; see `_Ahead`
    closed: NDArray[np.bool_]  # (n, joints) True where contacts ended


class Settings(NamedTuple):
    """What determines the steps of a run besides its mechanism, and where powers are taken in a step."""

    how: How
    t_end: float  # [s]
    points: Array  # from -1 to 1
    weights: Array


def settings_of(ran: Tree) -> Settings:
    """Settings of a run from the provenance of its result."""
    method, steppers = ran["method"], kinds("stepper")
    if method not in steppers:
        raise InputError(f"the run used a method that is not known here, '{method}'{suggest(method, steppers)}")
    how = How(steppers[method], ran["rtol"], ran["atol"], ran.get("step"), True)
    whole = how.stepper.leaf.loop == TIME_STEPPING  # rows hold mean values of whole steps
    return Settings(how, ran["t_end"], *np.polynomial.legendre.leggauss(1 if whole else GAUSS))


def rows_at(m: Mechanism, settings: Settings, t: Array) -> Array:
    """Rows (n, columns) with ports at increasing instants (n,) [s]."""
    functions.start()
    run = new_run(m.system, m.start, t, settings.t_end, settings.how)
    _forward(run, float(t[-1]))
    reached = int(run.tally[at.OUTPUTS])
    if reached < len(t):
        raise SolverError(f"the run ends at t = {run.clock[at.T]:.6g} s, before t = {t[-1]:.6g} s", None)
    return run.raw


def steps_between(m: Mechanism, settings: Settings, t0: float, t1: float) -> Iterator[Steps]:
    """The steps of the run from t0 to t1 [s], in batches."""
    functions.start()
    nothing = np.zeros(0)
    ahead = _Ahead(new_run(m.system, m.start, nothing, settings.t_end, settings.how))
    behind = new_run(m.system, m.start, nothing, settings.t_end, settings.how)
    status = behind.begin(behind.start.t)
    if t0 > ahead.run.start.t:
        ahead.impulses()  # those at the start are before the window
    while ahead.status == PAUSED and ahead.time < t1:
        ends, impulses, moved, closed = ahead.go(t0, t1)
        start, end = np.clip(ends[:-1], t0, t1), np.clip(ends[1:], t0, t1)
        inside = end > start
        middle, half = 0.5 * (start + end)[inside], 0.5 * (end - start)[inside]
        behind.t_eval = _within(middle, half, settings.points)
        behind.raw = np.zeros((len(behind.t_eval), behind.raw.shape[1]))
        behind.tally[at.OUTPUTS] = 0
        while status == PAUSED and behind.tally[at.STEPS] < ahead.run.tally[at.STEPS]:
            status = _advance(behind, int(ahead.run.tally[at.STEPS] - behind.tally[at.STEPS]))
        if ahead.status not in (PAUSED, DONE) and status == PAUSED:
            status = _advance(behind, 1)  # towards the event at which the run ends, part of a step that is not counted
        if behind.clock[at.T] != ahead.time or behind.tally[at.OUTPUTS] != len(behind.t_eval):
            raise SolverError(f"the run could not be repeated: it differs before t = {ahead.time:.9g} s", None)
        if not inside.any():
            continue
        rows = behind.raw.reshape(-1, len(settings.points), behind.raw.shape[1])
        yield Steps(start[inside], end[inside], rows, impulses, moved[inside], closed[inside])


def points_of(steps: Steps, points: Array) -> Array:
    """The times [s] of the rows of some steps, one after the other; points: from -1 to 1."""
    return _within(0.5 * (steps.start + steps.end), 0.5 * (steps.end - steps.start), points)


def _within(middle: Array, half: Array, points: Array) -> Array:
    return np.ravel(middle[:, None] + half[:, None] * points)


class _Ahead:
    """The run that goes ahead, one step at a time."""

    def __init__(self, run: Run) -> None:
        self.run = run
        load_law.forget()
        self.status = int(run.begin(run.start.t))
        layout = state_layout(run.system)
        accounts = [layout.account(n).start for n in range(len(layout.contacts))]
        rigid = run.system.arrays["contact"][:, at.IMPACT] == 1
        self._elastic = np.array([first for first, hard in zip(accounts, rigid, strict=True) if not hard], np.int64)
        self._owner = run.system.arrays["contact"][~rigid, at.OWNER]
        self._work = np.zeros_like(run.workspace.port_work)

    @property
    def time(self) -> float:
        """The time that is reached [s]."""
        return float(self.run.clock[at.T])

    def impulses(self) -> Array:
        """Work of impulses since the last call (joints, 6) [J]."""
        now = self.run.workspace.port_work.copy()
        change: Array = now - self._work
        self._work = now
        return change

    def go(self, t0: float, t1: float) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
        """Take a batch of steps: their ends [s], the first with its start; work of impulses after t0 up to t1, and what
        contacts have lost in steps in which some ended (steps, joints) [J]."""
        ends, state, nj = [self.time], self.run.workspace.state, len(self.run.system.joints)
        moved, closed = np.zeros((BATCH, nj)), np.zeros((BATCH, nj), bool)
        work = np.zeros_like(self._work)
        while self.status == PAUSED and len(ends) <= BATCH and ends[-1] < t1:
            before = state[self._elastic + STORED], state[self._elastic + LOSS]
            count = self.run.tally[at.STEPS]
            self.status = _advance(self.run, 1)
            if self.run.tally[at.STEPS] == count:
                continue
            over = (state[self._elastic + STORED] == 0.0) & (before[0] != 0.0)
            if over.any():
                lost = state[self._elastic + LOSS] - before[1]
                k = len(ends) - 1
                for n in set(self._owner[over].tolist()):
                    closed[k, n], moved[k, n] = True, lost[self._owner == n].sum()
            ends.append(self.time)
            change = self.impulses()
            if t0 < ends[-1] <= t1 * (1.0 + 1e-15):
                work += change
        if self.time > ends[-1]:  # the run ends within a step, at an event
            ends.append(self.time)
        return np.array(ends), work, moved[: len(ends) - 1], closed[: len(ends) - 1]


def _advance(run: Run, steps: int) -> int:
    """Take steps towards the end of the run; returns PAUSED, DONE or the status of a failure."""
    status = int(run.advance(run.t_end, steps))
    run.tally[at.FOUND] = run.tally[at.EVENT_COUNT] = 0
    return status


def _forward(run: Run, t: float) -> None:
    """Take steps until t [s] is passed, or the run ends; rows of outputs are in `raw`."""
    load_law.forget()
    status = run.begin(run.start.t)
    if status == PAUSED and not run.tally[at.OUTPUTS]:
        run.record_first(run.workspace.state)
    while status == PAUSED and run.clock[at.T] < t:
        status = _advance(run, 64)
    if status == DONE:
        return
