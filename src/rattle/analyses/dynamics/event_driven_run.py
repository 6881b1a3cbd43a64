"""Event-driven runs with set-valued contacts."""

from __future__ import annotations

import math
from typing import Any, final

import numpy as np

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.contact_trouble import (
    against,
    closed_joints,
    contact_trouble,
    dead_end,
    firm_joints,
    shared_forces,
)
from rattle.analyses.dynamics.failure import explain
from rattle.analyses.dynamics.run import How, Run
from rattle.analyses.dynamics.soundness import set_floor
from rattle.equations import unilateral
from rattle.equations.motion import OK, PAUSED, STEP_TOO_SMALL
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.solvers import step_loop
from rattle.solvers.nonsmooth import event_driven, jams
from rattle.solvers.nonsmooth.contact_arrays import contact_arrays
from rattle.solvers.peaks.samples import stage_shares
from rattle.solvers.step_audit import UNSOUND
from rattle.solvers.stepper import TIME_STEPPING, stepper_of

LEAST_SAID = 1e-3  # the same, below which its digits depend on the tolerance
NEARLY_LOCKED = 0.2  # share of its response without friction that a sliding contact keeps, below which it is said


@final
class EventDrivenRun(Run):
    """A run in which every impact, release, stick and slip is located; closed contacts act as constraints."""

    lands_on_instants = True
    may_pass = False  # jams are passed by an impact without collision

    def __init__(self, system: System, start: Assembled, t_eval: np.ndarray, t_end: float, how: How) -> None:
        super().__init__(system, start, t_eval, t_end, how)
        self.jams: list[tuple[float, str]] = []  # times [s] at which friction locked, and the closed contacts

    def loop_arrays(self) -> dict[str, Any]:
        """Arrays of set-valued contacts; forces of closed contacts are part of the equations of motion."""
        return contact_arrays(self.system, stage_shares(self.tableau)) | self.break_arrays()

    def begin(self, t: float) -> int:
        """Find the modes of closed contacts and apply impacts at the start t [s]; see `Run.begin`."""
        self.take_sides(t)
        values, contact = self.workspace.values, self.system.arrays["contact"]
        rigid = contact[contact[:, at.IMPACT] == 1]
        self.may_pass = bool((values[rigid[:, at.NORMAL_P] + at.JAM] > 0.0).any())
        self.workspace.stuck[:] = 0.0
        self.workspace.stuck[at.EVENT_AT] = -math.inf
        self.clock[at.T] = t
        status = int(event_driven.start(self.workspace, t))
        if status == unilateral.NO_SOLUTION and self.may_pass:
            status = OK if self.pass_jam(status, late=False) == PAUSED else status
        if status != OK:
            return status
        self.take_sides(t)
        status = int(step_loop.begin(self.workspace, t, self.t_end, self.rtol, self.atol, self.step or math.inf))
        set_floor(self.system, self.workspace, self.rtol, self.atol)
        return PAUSED if status == OK else status

    def take_steps(self, t: float, chunk: int, outputs: int) -> int:
        """Up to `chunk` steps towards the time t [s]; see `Run.take_steps`."""
        h_max, out = self.step or math.inf, self.t_eval[:outputs]
        m = self.workspace
        status = int(step_loop.advance(m, t, self.rtol, self.atol, h_max, out, self.raw, chunk))
        if status in (unilateral.NO_SOLUTION, unilateral.LOCKED, STEP_TOO_SMALL) and self.may_pass:
            return self.pass_jam(status, late=status == unilateral.NO_SOLUTION)
        return status

    def pass_jam(self, status: int, late: bool) -> int:
        """Pass a position at which friction locks by an impact without collision; PAUSED, or a failure status.

        late: the state is that of an event whose new modes were not found.
        """
        t, handle = float(self.clock[at.T]), self.workspace
        if self.jams and t - self.jams[-1][0] <= 1e-9 * self.t_end:  # again at the same place: it does not help
            return status
        names = ", ".join(closed_joints(self.system, self.workspace))
        if jams.pass_jam(handle, t, int(late)) != OK:
            return status
        self.jams.append((t, names))
        self.clock[at.H] = max(float(self.clock[at.H]), 1e-6 * (self.t_end - t))
        return self.go_on(t, True)

    def go_on(self, t: float, jolted: bool) -> int:
        """Find the modes of closed contacts anew at t [s]; see `Run.go_on`."""
        status = int(event_driven.go_on(self.workspace, t, 1 if jolted else 0))
        if status != OK:
            return status
        step_loop.resume(self.workspace, t)
        return PAUSED

    def remarks(self) -> tuple[str, ...]:
        """Notes on jams that were passed and on forces that are not unique."""
        said = shared_forces(self.system, self.workspace)
        if not self.jams:
            return said
        first = f"the first at t = {self.jams[0][0]:.9g} s at {self.jams[0][1]}"
        number = f"{len(self.jams)} impacts" if len(self.jams) > 1 else "1 impact"
        return (*said, f"friction locked contacts (Painleve), passed by {number} without collision, {first}")

    def about_peaks(self, impacts: bool) -> tuple[str, ...]:
        """How near friction has come to locking a contact, where forces grow without bound."""
        share, when, joint = self.nearest_lock()
        if not 0.0 < share < NEARLY_LOCKED:
            return ()
        near = f"{100 * share:.2g} %" if share > LEAST_SAID else f"less than {100 * LEAST_SAID:g} %"
        grows = f"is {1 / share:.2g} times that without friction" if share > LEAST_SAID else "grows without bound"
        return (
            f"friction in {joint} comes within {near} of locking it (Painleve paradox), at t = {when:.4g} s: its force"
            f" of lasting contact {grows} there, and beyond that a rigid contact has none; an elastic contact tells it",
        )

    def nearest_lock(self) -> tuple[float, float, str]:
        """Least share of its response that a sliding contact keeps [-], when [s], and its joint."""
        share, when, contact = (float(self.workspace.held[k]) for k in (at.LOCK_SHARE, at.LOCK_AT, at.LOCK_CONTACT))
        owner = int(self.system.arrays["contact"][int(contact), at.OWNER])
        return share, when, self.system.joints[owner]

    def locked(self) -> tuple[str, float] | None:
        """The joint whose contact keeps less than `LEAST_SAID` of its response, and when [s]: the rest is chance."""
        share, when, joint = self.nearest_lock()
        return (joint, when) if 0.0 < share < LEAST_SAID else None

    def explain(self, status: int) -> str:
        """Why the run cannot go on, in words; contact problems are named."""
        t = float(self.clock[at.T])
        if status == unilateral.CHATTER:
            return self.chatter(t)
        passed = "" if self.may_pass else ', or jam = "impact" in the contact'
        what = contact_trouble(self.system, self.workspace, t, status, passed)
        return what or explain(self.system, self.workspace, self.t_end, status, self.stepper, self.rtol)

    def suspect(self, status: int) -> str:
        """A dead end, if a contact that is pressed together hardly gives way."""
        if status not in (UNSOUND, unilateral.NO_SOLUTION, unilateral.LOCKED, STEP_TOO_SMALL):
            return ""
        t = float(self.clock[at.T])
        if end := dead_end(self.system, self.workspace, t):
            return end
        names = ", ".join(firm_joints(self.system, self.workspace, t))
        return against(self.system, f" {names}") if names else ""

    def chatter(self, t: float) -> str:
        """Message on contacts that change without end at t [s], with the last one."""
        other = f"method {stepper_of(TIME_STEPPING)}"
        stuck = self.workspace.stuck
        joint = self.system.joints[self.system.arrays["contact"][int(stuck[at.EVENT_WHO]), at.OWNER]]
        if stuck[at.EVENTS_IN_A_ROW] > event_driven.MOST_IN_A_ROW:
            row, close = stuck[at.EVENTS_IN_A_ROW], event_driven.CROWDED * self.t_end
            return (
                f"{row:.0f} events in a row, each within {close:.2g} s of the one before, up to t = {t:.9g} s, last at"
                f" joint '{joint}': contacts change faster than a run"
                f" can follow; try a smaller restitution, a compliant contact or {other}"
            )
        return f"contacts change without end at t = {t:.9g} s, last at joint '{joint}'; try {other}"
