"""Runs with set-valued contacts by Moreau-Jean time stepping."""

from __future__ import annotations

from typing import final

import numpy as np

from rattle.analyses.dynamics.contact_trouble import against, contact_trouble, shared_forces
from rattle.analyses.dynamics.failure import explain
from rattle.analyses.dynamics.run import Run
from rattle.equations.motion import NOT_FINITE
from rattle.jit import layout as at
from rattle.results.columns import width
from rattle.solvers.contacts.penetration import ESCAPED
from rattle.solvers.nonsmooth.contact_arrays import contact_arrays

PEAKS = "{method}: peaks are the largest of its steps{more}"
OF_IMPACTS = "; in the step of an impact a force is its impulse over the step"


@final
class MoreauJeanRun(Run):
    """A run in equal steps, in which contacts act by their impulses over a step and no events are located."""

    loop = at.RUNS_EQUAL_STEPS

    def loop_arrays(self) -> dict[str, np.ndarray]:
        """Arrays of set-valued contacts, and rows beside instants at which expressions of time switch."""
        row = {"port_row": np.zeros(width(self.system, True))} if self.ports else {}
        return contact_arrays(self.system) | row | self.break_arrays(steps=0)

    def remarks(self) -> tuple[str, ...]:
        """Notes on forces that are not unique."""
        return shared_forces(self.system, self.workspace)

    def about_peaks(self, impacts: bool) -> tuple[str, ...]:
        """Note that peaks are those of whole steps."""
        return (PEAKS.format(method=self.stepper.leaf.title, more=OF_IMPACTS if impacts else ""),)

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
