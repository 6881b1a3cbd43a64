"""Runs of smooth motion, compliant contacts included."""

from __future__ import annotations

import math
from typing import Any, final

from rattle.analyses.dynamics.failure import explain
from rattle.analyses.dynamics.run import Run
from rattle.analyses.dynamics.soundness import set_floor
from rattle.equations.motion import OK, PAUSED
from rattle.jit import layout as at
from rattle.solvers import step_loop
from rattle.solvers.contacts.wear_sum import add_wear, keep_speeds
from rattle.solvers.dry_friction_modes import decide


@final
class SmoothRun(Run):
    """A run by an explicit stepper; starts and ends of contacts, and switches, are located on its dense output."""

    lands_on_instants = True

    def loop_arrays(self) -> dict[str, Any]:
        """Rows beside events, if contacts, friction or switches may make any."""
        arrays = self.system.arrays
        bends = any(len(arrays[name]) for name in ("contact", "dry", "switch"))
        return self.break_arrays() if bends else {}

    def begin(self, t: float) -> int:
        """Set the sides of switches, the derivative and the first step at t [s]; see `Run.begin`."""
        self.take_sides(t)
        status = step_loop.begin(self.workspace, t, self.t_end, self.rtol, self.atol, self.step or math.inf)
        set_floor(self.system, self.workspace, self.rtol, self.atol)
        self.pace(t)
        if self.wear:
            keep_speeds(self.workspace)
            step_loop.resume(self.workspace, t)
            add_wear(self.workspace, 0.0)
        return PAUSED if status == OK else int(status)

    def pace(self, t: float) -> None:
        """With fixed steps, choose equal ones from the time t [s] to the next instant of the timetable."""
        if not self.stepper.leaf.adaptive:
            ahead = min(self.ahead(), self.t_end) - t
            if ahead > 0.0:
                self.clock[at.H] = ahead / max(1, math.ceil(ahead / (self.step or math.inf) - 1e-9))

    def take_steps(self, t: float, chunk: int, outputs: int) -> int:
        """Up to `chunk` steps towards the time t [s]; see `Run.take_steps`."""
        h_max, out = self.step or math.inf, self.t_eval[:outputs]
        return int(step_loop.advance(self.workspace, t, self.rtol, self.atol, h_max, out, self.raw, chunk))

    def go_on(self, t: float, jolted: bool) -> int:
        """Continue at t [s] with the new right-hand side; see `Run.go_on`."""
        if len(self.workspace.dry):
            decide(self.workspace, t, self.workspace.state, -1, 1)
        step_loop.resume(self.workspace, t)
        self.pace(t)
        return PAUSED

    def remarks(self) -> tuple[str, ...]:
        """Nothing: trust says all."""
        return ()

    def about_peaks(self, impacts: bool) -> tuple[str, ...]:
        """Nothing: peaks are located within the steps."""
        return ()

    def explain(self, status: int) -> str:
        """Why the run cannot go on, in words; see `failure.explain`."""
        return explain(self.system, self.workspace, self.t_end, status, self.stepper, self.rtol)

    def suspect(self, status: int) -> str:
        """Nothing: there are no contacts that drivers could push together."""
        return ""
