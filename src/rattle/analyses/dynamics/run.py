"""One run from a start to its end: steps, switches on the way, outputs, and why it ended."""

from __future__ import annotations

import math
import threading
import time
from typing import Any

import numpy as np

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.failure import explain
from rattle.analyses.dynamics.peak_values import peak_arrays
from rattle.analyses.dynamics.soundness import (
    audit_arrays,
    set_floor,
    too_slow,
    why_unsound,
)
from rattle.analyses.timetable import Jolt, timetable
from rattle.elements.custom import load_law
from rattle.equations.motion import DONE, OK, PAUSED
from rattle.equations.state import state_layout
from rattle.equations.system import System
from rattle.jit import functions
from rattle.jit.workspace import Workspace
from rattle.language.switching import SAME
from rattle.results.columns import width
from rattle.solvers import step_loop, step_state
from rattle.solvers.gap_search import ESCAPED
from rattle.solvers.nonsmooth.jolts import jolt, speeds
from rattle.solvers.output_row import record
from rattle.solvers.state_switches import choose_sides
from rattle.solvers.step_audit import UNSOUND

stop = threading.Event()  # set: all runs of the process end where they are, as after Ctrl-C in each of them
GLANCE = 1e-6  # share of a run by which it is looked ahead for the side of a switching function that is zero
CHUNK = 2000  # steps between two looks at the clock and the keyboard


class Run:
    """One run from start to end with fixed settings."""

    def __init__(
        self,
        system: System,
        start: Assembled,
        t_eval: np.ndarray,
        t_end: float,
        method: str,
        rtol: float,
        atol: float,
        step: float | None,
    ) -> None:
        self.system, self.start, self.t_eval, self.t_end = system, start, t_eval, t_end
        self.method, self.rtol, self.atol, self.step = method, rtol, atol, step
        self.table = timetable(system, start.t, t_end)
        self.piece = 0  # smooth pieces of the run that are over
        self.jolts: list[Jolt] = []
        self.workspace = self.prepare()
        self.clock, self.tally = self.workspace.clock, self.workspace.tally
        self.raw = np.zeros((len(t_eval), width(system)))
        self.crossings: list[np.ndarray] = []
        self.contacts: list[np.ndarray] = []
        self.first_sign = np.ones(len(system.watched))
        self.message = ""
        self.most_steps: int | None = None
        self.interrupted = False
        self.wall = 0.0
        self.notes: tuple[str, ...] = ()  # what is known before it starts

    def prepare(self) -> Workspace:
        """Workspace of the run."""
        arrays = step_state.step_loop_arrays(start_state(self.system, self.start), len(self.system.watched))
        arrays |= step_state.stepper_arrays(self.method)
        return self.system.workspace(**arrays, **audit_arrays(self.system, self.method), **peak_arrays(self.system))

    def begin(self, t: float) -> int:
        """Get ready for steps from the time t [s] and the state at hand; returns PAUSED, or what forbids it."""
        self.take_sides(t)
        status = step_loop.begin(self.workspace, t, self.t_end, self.rtol, self.atol, self.step or math.inf)
        set_floor(self.system, self.workspace, self.rtol, self.atol)
        self.pace(t)
        return PAUSED if status == OK else int(status)

    def take_sides(self, t: float) -> None:
        """Every switch takes the side that it has from the time t [s] on."""
        self.piece = self.table.piece_at(t)
        self.table.take(self.workspace.code, self.piece)
        if len(self.workspace.switch):
            choose_sides(self.workspace, t, GLANCE * (self.t_end - t))

    def pace(self, t: float) -> None:
        """rk4: equal steps from the time t [s] to the next instant known beforehand."""
        if self.method == "rk4":
            ahead = min(self.ahead(), self.t_end) - t
            if ahead > 0.0:
                self.clock[step_state.H] = ahead / max(1, math.ceil(ahead / (self.step or math.inf) - 1e-9))

    def ahead(self) -> float:
        """The next instant at which an expression of time switches [s]; inf if there is none."""
        instants = self.table.instants
        return float(instants[self.piece]) if self.piece < len(instants) else math.inf

    def advance(self, t: float, chunk: int) -> int:
        """Some steps towards the time t [s]; returns PAUSED while it is ahead, DONE, or the status of a trouble.

        Steps end on the instants at which expressions switch.
        """
        instant = self.ahead()
        if instant > t:
            return self.take_steps(t, chunk, len(self.t_eval))
        status = self.take_steps(instant, chunk, self.outputs_before(instant))
        if status == DONE:
            status = self.switch(instant)
        return DONE if status == PAUSED and self.clock[step_state.T] >= t and self.ahead() > t else status

    def outputs_before(self, t: float) -> int:
        """Number of outputs before the time t [s]; what is recorded at an instant is that of the right side."""
        return int(np.searchsorted(self.t_eval, t - SAME * self.t_end))

    def take_steps(self, t: float, chunk: int, outputs: int) -> int:
        """Some steps towards the time t [s] on the sides at hand, with the first outputs; returns as `advance`."""
        return int(
            step_loop.advance(
                self.workspace, t, self.rtol, self.atol, self.step or math.inf,
                self.t_eval[:outputs], self.raw, chunk,
            )
        )  # fmt: skip

    def switch(self, t: float) -> int:
        """Expressions switch at t [s]: sides of the next piece, a jolt where a driver jumps; PAUSED or a trouble."""
        handle, nr = self.workspace, self.system.row_count
        before, after, percussion = np.zeros((3, nr))
        jumps = [jump for jump in self.table.jumps if jump.t == t]
        if jumps:
            speeds(handle, t, before)
        self.piece += 1
        self.table.take(self.workspace.code, self.piece)
        if jumps:
            speeds(handle, t, after)
            status = int(jolt(handle, t, before, percussion))
            if status != OK:
                return status
            work = -0.5 * percussion * (before + after)
            for jump in jumps:
                row = self.system.first_row(jump.driver)
                self.jolts.append(Jolt(jump, -float(percussion[row]), float(work[row])))
        status = self.go_on(t, bool(jumps))
        if status == PAUSED:
            self.record_now(t)
            self.pace(t)
        return status

    def go_on(self, t: float, jolted: bool) -> int:
        """Get ready to go on from t [s] after expressions have switched there; PAUSED or a trouble."""
        step_loop.resume(self.workspace, t)
        return PAUSED

    def record_now(self, t: float) -> None:
        """Write the outputs at the instant t [s], those of its right side."""
        k = int(self.tally[step_state.OUTPUTS])
        while k < len(self.t_eval) and self.t_eval[k] <= t + SAME * self.t_end:
            record(self.workspace, t, self.workspace.state, self.raw[k])
            k += 1
        self.tally[step_state.OUTPUTS] = k

    def remarks(self) -> tuple[str, ...]:
        """What happened on the way that a result has to say."""
        return ()

    def trouble(self, status: int) -> str:
        """Why the run cannot go on."""
        if status == UNSOUND:
            return why_unsound(self)
        return explain(self.system, self.workspace, self.t_end, status, self.method, self.rtol)

    def go(self, progress: bool = False, what: str = "simulate") -> None:
        """Take steps to the end, or to where the run cannot go on (then `message` says why)."""
        m, tally = self.workspace, self.tally
        began = time.perf_counter()
        load_law.forget()
        bar = progress_bar(self.t_end, what) if progress else None
        try:
            status = self.begin(self.start.t)
            mark = (0, self.start.t)
            self.first_sign[:] = m.sign
            if status == PAUSED and self.method != "moreau" and len(self.t_eval) and self.t_eval[0] <= self.start.t:
                record(m, self.start.t, m.state, self.raw[0])
                tally[step_state.OUTPUTS] = 1
            while status == PAUSED:
                if stop.is_set():
                    raise KeyboardInterrupt
                status = self.advance(self.t_end, CHUNK if functions.jit_runs() else 20)
                self.crossings.append(m.crossings[: tally[step_state.FOUND]].copy())
                self.contacts.append(m.events[: tally[step_state.EVENT_COUNT]].copy())
                tally[step_state.FOUND] = tally[step_state.EVENT_COUNT] = 0
                if bar is not None:
                    bar.update(self.clock[step_state.T] - bar.n)
                if status == PAUSED:
                    self.message, mark = too_slow(self, mark)
                    if self.message:
                        break
            if status not in (DONE, PAUSED):
                lost = (
                    self.trouble(status) if status == ESCAPED else ""
                )  # told by the gaps at hand, which go with outputs
                if not tally[step_state.OUTPUTS] and len(self.t_eval) and self.t_eval[0] <= self.start.t:
                    record(m, self.start.t, start_state(self.system, self.start), self.raw[0])
                    tally[step_state.OUTPUTS] = 1
                self.message = lost or self.trouble(status)
        except KeyboardInterrupt:
            self.interrupted = True
            reached = self.clock[step_state.T]
            self.message = f"stopped by the user at t = {reached:.6g} s; the result holds what was computed before"
        finally:
            if bar is not None:
                bar.close()
            self.wall = time.perf_counter() - began


def start_state(system: System, start: Assembled) -> np.ndarray:
    """y at the start, see `equations.state`."""
    motion = np.concatenate([start.q, start.v])
    return np.concatenate([motion, np.zeros(state_layout(system).size - len(motion))])


def pulls(run: Run, reached: float) -> tuple[dict[str, float], dict[str, float | None], dict[str, np.ndarray]]:
    """Share of time, first time and intervals with N < 0 for every joint held by a massless link."""
    crossings = np.concatenate(run.crossings) if run.crossings else np.zeros((0, 3))
    pulled: dict[str, float] = {}
    first: dict[str, float | None] = {}
    intervals = {}
    span = max(reached - run.start.t, 1e-300)
    for n, name in enumerate(run.system.watched):
        mine = crossings[crossings[:, 1] == n]
        times = list(mine[:, 0])
        if run.first_sign[n] < 0:
            times.insert(0, run.start.t)
        if len(times) % 2:
            times.append(reached)
        pairs = np.array(times).reshape(-1, 2)
        intervals[name] = pairs
        pulled[name] = float((pairs[:, 1] - pairs[:, 0]).sum() / span)
        first[name] = float(pairs[0, 0]) if len(pairs) else None
    return pulled, first, intervals


def progress_bar(t_end: float, what: str = "simulate") -> Any:
    """A progress bar that appears when a run takes longer than a second."""
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]"
    return tqdm(total=t_end, unit="s", desc=what, bar_format=form, delay=1.0)
