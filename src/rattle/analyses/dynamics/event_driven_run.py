"""Event-driven runs with set-valued contacts."""

from __future__ import annotations

from typing import final

import numpy as np

from rattle.analyses.dynamics.contact_trouble import (
    JAM,
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
SENTENCES = {  # of notes, also in pages
    "jams": "friction locked contacts (Painleve), passed by {number} without collision, the first at t = {t:.9g} s at"
    " {joints}",
    "nearly_locked": "friction in {joint} comes within {near} of locking it (Painleve paradox), at t = {t:.4g} s: its"
    " force of lasting contact {grows} there, and beyond that a rigid contact has none; an elastic contact tells it",
    "near": "{percent:.2g} %",
    "nearer": "less than {percent:g} %",
    "grows": "is {times:.2g} times that without friction",
    "unbound": "grows without bound",
    "in_a_row": "{count:.0f} events in a row, each within {close:.2g} s of the one before, up to t = {t:.9g} s, last at"
    " joint '{joint}': contacts change faster than a run can follow; try a smaller restitution, a compliant contact or"
    " {other}",
    "chatter": "contacts change without end at t = {t:.9g} s, last at joint '{joint}'; try {other}",
}


@final
class EventDrivenRun(Run):
    """A run in which every impact, release, stick and slip is located; closed contacts act as constraints."""

    loop = at.RUNS_BY_EVENTS

    def loop_arrays(self) -> dict[str, np.ndarray]:
        """Arrays of set-valued contacts; forces of closed contacts are part of the equations of motion."""
        return contact_arrays(self.system, stage_shares(self.tableau)) | self.break_arrays()

    def remarks(self) -> tuple[str, ...]:
        """Notes on jams that were passed and on forces that are not unique."""
        notes = shared_forces(self.system, self.workspace)
        count = int(self.workspace.course[at.JAMS])
        if not count:
            return notes
        names = ", ".join(joints_of(self.system, self.workspace.jammed == 1))
        number, first = f"{count} impacts" if count > 1 else "1 impact", self.workspace.course[at.FIRST_JAM]
        return (*notes, SENTENCES["jams"].format(number=number, t=first, joints=names))

    def about_peaks(self, impacts: bool) -> tuple[str, ...]:
        """How near friction has come to locking a contact, where forces grow without bound."""
        share, when, joint = self.nearest_lock()
        if not 0.0 < share < NEARLY_LOCKED:
            return ()
        near, grows = SENTENCES["nearer"].format(percent=100 * LEAST_SAID), SENTENCES["unbound"]
        if share > LEAST_SAID:
            near, grows = SENTENCES["near"].format(percent=100 * share), SENTENCES["grows"].format(times=1 / share)
        return (SENTENCES["nearly_locked"].format(joint=joint, near=near, t=when, grows=grows),)

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
        passed = "" if self.workspace.course[at.MAY_PASS] else JAM
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
            return SENTENCES["in_a_row"].format(count=row, close=close, t=t, joint=joint, other=other)
        return SENTENCES["chatter"].format(t=t, joint=joint, other=other)
