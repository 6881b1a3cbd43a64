"""A run from start to end: pieces between switches, outputs, and why it ended; each step loop has its own class."""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.peak_values import peak_arrays
from rattle.analyses.dynamics.soundness import (
    audit_arrays,
    too_slow,
    why_unsound,
)
from rattle.analyses.timetable import Jolt, timetable
from rattle.elements.custom import load_law
from rattle.equations.motion import DONE, PAUSED
from rattle.equations.state import state_layout
from rattle.equations.system import System
from rattle.interfaces.steppers import StepperKind
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.progress_bar import progress_bar
from rattle.registry import Kind
from rattle.results.columns import width
from rattle.solvers import run_loop, step_state
from rattle.solvers.contacts.penetration import ESCAPED
from rattle.solvers.contacts.wear_sum import wear_arrays
from rattle.solvers.output_row import record
from rattle.solvers.singular_passage import passage_arrays
from rattle.solvers.step_audit import UNSOUND
from rattle.solvers.stepper import tableau_of
from rattle.value_types import Plain

stop = threading.Event()  # when set, all runs of the process end where they are, as after Ctrl-C
MOST_NUMBERS = 8_000_000  # of output rows beside events that a run keeps: 64 MB
SHORTEST_RUN = 1e-300  # time that may be divided by, where a run ends at its start [s]
CHUNK = 2000  # steps between two checks of progress and of Ctrl-C


class How(NamedTuple):
    """Settings of a run's steps."""

    stepper: Kind[StepperKind]
    rtol: float
    atol: float  # [m, rad, m/s, rad/s]
    step: float | None  # [s]; the largest of an adaptive stepper, None for any
    ports: bool = False  # output rows go on with the ports of all elements, see `solvers.ports`
    wear: bool = False  # sliding of worn contacts is summed in their bins, see `solvers.contacts.wear_sum`


class Run(ABC):
    """One run from start to end with fixed settings, in smooth pieces between the instants of the timetable."""

    loop: ClassVar[int]  # RUNS_SMOOTHLY, RUNS_BY_EVENTS or RUNS_EQUAL_STEPS of `layout`

    def __init__(self, system: System, start: Assembled, t_eval: np.ndarray, t_end: float, how: How) -> None:
        self.system, self.start, self.t_eval, self.t_end = system, start, t_eval, t_end
        self.stepper, self.rtol, self.atol, self.step, self.ports, self.wear = how
        self.table = timetable(system, start.t, t_end)
        self.workspace = self.prepare()
        self.clock, self.tally = self.workspace.clock, self.workspace.tally
        self.raw = np.zeros((len(t_eval), width(system, self.ports)))
        self.crossings: list[np.ndarray] = []
        self.contacts: list[np.ndarray] = []
        self.breaks: list[tuple[np.ndarray, np.ndarray]] = []  # times (k,) [s] and output rows, see `solvers.breaks`
        self.room = MOST_NUMBERS  # for numbers in them; negative: there were too many
        self.pairs_only = False  # rows within contacts are left out
        self.first_sign = np.ones(len(system.watched))
        self.message = ""
        self.most_steps: int | None = None
        self.interrupted = False
        self.wall = 0.0
        self.notes: tuple[str, ...] = ()  # notes known before the run starts

    # ---------------------------------------------------------------- what each kind of run defines
    @abstractmethod
    def loop_arrays(self) -> dict[str, np.ndarray]:
        """Workspace arrays of this step loop, besides those of every run."""

    @abstractmethod
    def remarks(self) -> tuple[str, ...]:
        """Notes for the result on what happened during the run."""

    @abstractmethod
    def about_peaks(self, impacts: bool) -> tuple[str, ...]:
        """Notes for the result on its largest forces; impacts: True if there were any."""

    def locked(self) -> tuple[str, float] | None:
        """A joint that friction nearly locks, and when [s]: forces grow without bound there, so trust ends."""
        return None

    @abstractmethod
    def explain(self, status: int) -> str:
        """Why the run cannot go on, in words, if its steps are sound."""

    @abstractmethod
    def suspect(self, status: int) -> str:
        """What else may have stopped the run, in words; "" if nothing."""

    # ---------------------------------------------------------------- what all runs share
    def prepare(self) -> Workspace:
        """The workspace of the run."""
        y = start_state(self.system, self.start)
        arrays: dict[str, np.ndarray | tuple[Plain, ...]] = {}
        arrays |= step_state.step_loop_arrays(y, len(self.system.watched))
        states = state_layout(self.system).states
        of_elements = states.stop - states.start
        films = bool((self.system.arrays["contact"][:, at.FILM_LAW] >= 0).any())
        integrator = step_state.integrator(self.stepper, films)
        self.tableau = tableau_of(integrator)  # of an explicit method, otherwise None
        arrays |= step_state.stepper_arrays(integrator, self.system.body_count, of_elements, len(y))
        arrays |= audit_arrays(self.system, self.stepper.leaf.energy_limit)
        if self.wear:
            arrays |= wear_arrays(self.system)
        if self.ports:
            arrays["port_work"] = np.zeros((len(self.system.joints), at.width("port_work")))
        peaks = peak_arrays(self.system, self.tableau, not self.wear)
        arrays |= passage_arrays(len(y), self.system.row_count, len(peaks["peaks"]))
        arrays |= self.table.arrays
        arrays["course"] = step_state.course(self.loop, self.system.extent)
        return self.system.workspace((), **arrays, **self.loop_arrays(), **peaks)

    def break_arrays(self, steps: int = CHUNK) -> dict[str, np.ndarray]:
        """Room for the rows beside an instant, and beside the events of so many steps; none for rows of another kind.

        steps: 0 where only expressions of time may bend the curves.
        """
        if not steps and not self.table.arrays:
            return {}
        rows = 0 if self.ports or self.wear else 2 * steps + 2
        return {"break_rows": np.zeros((rows, width(self.system))), "break_times": np.zeros(rows + 1)}

    def begin(self, t: float) -> int:
        """Prepare steps from the time t [s] and the state in the workspace; returns PAUSED, or a failure status."""
        how = self.rtol, self.atol, self.step or math.inf
        return int(run_loop.begin(self.workspace, t, self.t_end, *how, self.t_eval, self.raw))

    def advance(self, t: float, chunk: int) -> int:
        """Up to `chunk` steps towards the time t [s]; returns PAUSED before t, DONE at t, or the status of a failure.

        Steps end at the instants at which expressions switch.
        """
        how = self.rtol, self.atol, self.step or math.inf
        return int(run_loop.advance(self.workspace, t, self.t_end, *how, self.t_eval, self.raw, chunk))

    @property
    def piece(self) -> int:
        """Index of the present smooth piece of the run."""
        return int(self.workspace.course[at.PIECE])

    @property
    def jolts(self) -> list[Jolt]:
        """The jumps of drivers that are passed, with what they took."""
        rows = self.workspace.driver_jump[: int(self.workspace.course[at.JOLTS])].tolist()
        return [
            Jolt(jump, row[at.JUMP_IMPULSE], row[at.JUMP_WORK])
            for jump, row in zip(self.table.jumps, rows, strict=False)
        ]

    def take_breaks(self) -> None:
        """Keep the rows that steps have written beside events, and make room for others."""
        times = self.workspace.break_times
        if len(times) and (count := int(times[0])):
            self.keep_breaks(times[1 : 1 + count].copy(), self.workspace.break_rows[:count].copy())
        if len(times):
            times[0] = 0.0

    def keep_breaks(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Keep output rows (k, width) at times (k,) [s], unless there are too many in all: some would be taken for all.

        Those in contacts, which stand alone, are the first to be left out.
        """
        if self.room < 0:
            return
        if self.pairs_only:
            times, rows = in_pairs(times, rows)
        self.room -= rows.size
        self.breaks.append((times, rows))
        if self.room < 0 and not self.pairs_only:
            self.pairs_only = True
            self.breaks = [in_pairs(*part) for part in self.breaks]
            self.room = MOST_NUMBERS - sum(part[1].size for part in self.breaks)
        if self.room < 0:
            self.breaks = []

    def record_first(self, y: np.ndarray) -> None:
        """Write the output at the start, if one is due, from the state y [SI]."""
        if len(self.t_eval) and self.t_eval[0] <= self.start.t:
            record(self.workspace, self.start.t, y, self.raw[0])
            self.tally[at.OUTPUTS] = 1

    def trouble(self, status: int) -> str:
        """Why the run cannot go on, in words."""
        if status == UNSOUND:
            return why_unsound(self)
        what = self.explain(status)  # before `suspect`, which changes the workspace
        return "; or ".join(text for text in (what, self.suspect(status)) if text)

    def chunk(self) -> int:
        """Steps to take before the next check of progress and of Ctrl-C: not more than the user still allows."""
        most = CHUNK if functions.jit_runs() else 20
        if self.most_steps is None:
            return most
        return max(1, min(most, self.most_steps - int(self.tally[at.STEPS])))

    def go(self, progress: bool = False, what: str = "simulate") -> None:
        """Take steps to the end, or until the run cannot go on; then `message` says why."""
        m, tally = self.workspace, self.tally
        began = time.perf_counter()
        load_law.forget()
        bar = bar_over_time(self.t_end, what) if progress else None
        try:
            status = self.begin(self.start.t)
            mark = (0, self.start.t)
            self.first_sign[:] = m.sign
            while status == PAUSED:
                if stop.is_set():
                    raise KeyboardInterrupt
                status = self.advance(self.t_end, self.chunk())
                self.crossings.append(m.crossings[: tally[at.FOUND]].copy())
                self.contacts.append(m.events[: tally[at.EVENT_COUNT]].copy())
                self.take_breaks()
                tally[at.FOUND] = tally[at.EVENT_COUNT] = 0
                if bar is not None:
                    bar.update(self.clock[at.T] - bar.n)
                if status == PAUSED:
                    self.message, mark = too_slow(self, mark)
                    if self.message:
                        break
            if status not in (DONE, PAUSED):
                # by the gaps in the workspace, which outputs overwrite
                lost = self.trouble(status) if status == ESCAPED else ""
                if not tally[at.OUTPUTS]:
                    self.record_first(start_state(self.system, self.start))
                self.message = lost or self.trouble(status)
        except KeyboardInterrupt:
            self.interrupted = True
            reached = self.clock[at.T]
            self.message = f"stopped by the user at t = {reached:.6g} s; the result holds what was computed before"
        finally:
            if bar is not None:
                bar.close()
            self.wall = time.perf_counter() - began


def in_pairs(times: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Those of the rows (k, width) at times (k,) [s] whose time stands twice."""
    same = np.diff(times) == 0.0
    pairs = np.append(same, False) | np.append(False, same)
    return times[pairs], rows[pairs]


def start_state(system: System, start: Assembled) -> np.ndarray:
    """The state vector y [SI] at the start, see `equations.state`."""
    layout = state_layout(system)
    y = np.zeros(layout.size)
    y[layout.motion] = np.concatenate([start.q, start.v])
    y[layout.own_states] = [state.start for state in system.model.states.values()]
    return y


def pulls(run: Run, reached: float) -> tuple[dict[str, float], dict[str, float | None], dict[str, np.ndarray]]:
    """Share of time [-], first time [s] and intervals (n, 2) [s] with N < 0, for every joint with a massless link.

    reached: time at which the run ended [s].
    """
    crossings = np.concatenate(run.crossings) if run.crossings else np.zeros((0, 3))
    pulled: dict[str, float] = {}
    first: dict[str, float | None] = {}
    intervals = {}
    span = max(reached - run.start.t, SHORTEST_RUN)
    for n, name in enumerate(run.system.watched):
        mine = crossings[crossings[:, at.CROSSING_FORCE] == n]
        times = list(mine[:, at.CROSSING_T])
        if run.first_sign[n] < 0:
            times.insert(0, run.start.t)
        if len(times) % 2:
            times.append(reached)
        pairs = np.array(times).reshape(-1, 2)
        intervals[name] = pairs
        pulled[name] = float((pairs[:, 1] - pairs[:, 0]).sum() / span)
        first[name] = float(pairs[0, 0]) if len(pairs) else None
    return pulled, first, intervals


def bar_over_time(t_end: float, what: str = "simulate") -> Any:
    """A progress bar over the times of a run to t_end [s]; it appears if the run takes longer than a second."""
    form = "{l_bar}{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]"
    return progress_bar(t_end, what, unit="s", bar_format=form, delay=1.0)
