"""Event-driven runs with set-valued contacts."""

from __future__ import annotations

from typing import Any, final

from rattle.analyses.dynamics.contact_trouble import (
    against,
    contact_trouble,
    dead_end,
    firm_joints,
    joints_of,
    shared_forces,
)
from rattle.analyses.dynamics.failure import explain
from rattle.analyses.dynamics.run import Run
from rattle.equations import unilateral
from rattle.equations.motion import STEP_TOO_SMALL
from rattle.jit import layout as at
from rattle.solvers.nonsmooth import event_driven
from rattle.solvers.nonsmooth.contact_arrays import contact_arrays
from rattle.solvers.peaks.samples import stage_shares
from rattle.solvers.step_audit import UNSOUND
from rattle.solvers.stepper import TIME_STEPPING, stepper_of

LEAST_SAID = 1e-3  # the same, below which its digits depend on the tolerance
NEARLY_LOCKED = 0.2  # share of its response without friction that a sliding contact keeps, below which it is said


@final
class EventDrivenRun(Run):
    """A run in which every impact, release, stick and slip is located; closed contacts act as constraints."""

    loop = at.RUNS_BY_EVENTS

    def loop_arrays(self) -> dict[str, Any]:
        """Arrays of set-valued contacts; forces of closed contacts are part of the equations of motion."""
        return contact_arrays(self.system, stage_shares(self.tableau)) | self.break_arrays()

    def remarks(self) -> tuple[str, ...]:
        """Notes on jams that were passed and on forces that are not unique."""
        said = shared_forces(self.system, self.workspace)
        count = int(self.workspace.course[at.JAMS])
        if not count:
            return said
        names = ", ".join(joints_of(self.system, self.workspace.jammed == 1))
        first = f"the first at t = {self.workspace.course[at.FIRST_JAM]:.9g} s at {names}"
        number = f"{count} impacts" if count > 1 else "1 impact"
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
        passed = "" if self.workspace.course[at.MAY_PASS] else ', or jam = "impact" in the contact'
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
