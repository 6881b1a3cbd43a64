"""Runs with set-valued contacts by Moreau-Jean time stepping."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, final

import numpy as np

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.contact_trouble import against, contact_trouble, shared_forces
from rattle.analyses.dynamics.failure import explain
from rattle.analyses.dynamics.run import How, Run
from rattle.analyses.dynamics.soundness import set_floor
from rattle.equations.motion import NOT_FINITE, PAUSED
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.results.columns import width
from rattle.solvers.contacts.penetration import ESCAPED
from rattle.solvers.nonsmooth import moreau_jean
from rattle.solvers.nonsmooth.contact_arrays import contact_arrays


class Leg(NamedTuple):
    """Equal steps of Moreau-Jean up to an instant, counted as if the run had taken such steps from its start."""

    start: float  # [s]
    end: float  # [s]
    h: float  # step [s]
    steps: int  # number of steps of the run at `end`


@final
class MoreauJeanRun(Run):
    """A run in equal steps, in which contacts act by their impulses over a step and no events are located."""

    lands_on_instants = False

    def __init__(self, system: System, start: Assembled, t_eval: np.ndarray, t_end: float, how: How) -> None:
        super().__init__(system, start, t_eval, t_end, how)
        self.leg = Leg(start.t, start.t, 0.0, 0)

    def loop_arrays(self) -> dict[str, Any]:
        """Arrays of set-valued contacts."""
        row = {"port_row": np.zeros(width(self.system, True))} if self.ports else {}
        return contact_arrays(self.system) | row

    def begin(self, t: float) -> int:
        """Project the start at t [s] onto the constraints; see `Run.begin`."""
        self.take_sides(t)
        self.leg = Leg(t, t, 0.0, 0)
        moreau_jean.start(self.workspace, t)
        set_floor(self.system, self.workspace, self.rtol, self.atol)
        return PAUSED

    def take_steps(self, t: float, chunk: int, outputs: int) -> int:
        """Up to `chunk` steps towards the time t [s]; see `Run.take_steps`."""
        if t != self.leg.end:
            now, done = self.leg.end, int(self.tally[at.STEPS])
            count = max(1, math.ceil((t - now) / (self.step or self.t_end) * (1 - 1e-12)))
            h = (t - now) / count
            self.leg = Leg(now - done * h, t, h, done + count)
        out = self.t_eval[: len(self.t_eval) if t >= self.t_end else outputs]
        m, leg = self.workspace, self.leg
        return int(moreau_jean.advance(m, leg.start, leg.h, leg.steps, out, self.raw, chunk))

    def go_on(self, t: float, jolted: bool) -> int:
        """Nothing: the next step finds what has changed at t [s]; see `Run.go_on`."""
        return PAUSED

    def remarks(self) -> tuple[str, ...]:
        """Notes on forces that are not unique."""
        return shared_forces(self.system, self.workspace)

    def about_peaks(self, impacts: bool) -> tuple[str, ...]:
        """Note that peaks are those of whole steps."""
        more = "; in the step of an impact a force is its impulse over the step" if impacts else ""
        return (f"{self.stepper.leaf.title}: peaks are the largest of its steps{more}",)

    def explain(self, status: int) -> str:
        """Why the run cannot go on, in words; contact problems are named."""
        t = float(self.clock[at.T])
        if status == NOT_FINITE:
            return f"the motion diverged at t = {t:.6g} s with the step of {self.step:.3g} s; try a smaller step"
        if what := contact_trouble(self.system, self.workspace, t, status, ""):
            return what
        return explain(self.system, self.workspace, self.t_end, status, self.stepper, self.rtol)

    def suspect(self, status: int) -> str:
        """A dead end, in which bodies sink into each other."""
        return against(self.system, "") if status == ESCAPED else ""
