"""Runs of smooth motion, compliant contacts included."""

from __future__ import annotations

from typing import final

import numpy as np

from rattle.analyses.dynamics.failure import explain
from rattle.analyses.dynamics.run import Run
from rattle.jit import layout as at


@final
class SmoothRun(Run):
    """A run by an explicit stepper; starts and ends of contacts, and switches, are located on its dense output."""

    loop = at.RUNS_SMOOTHLY

    def loop_arrays(self) -> dict[str, np.ndarray]:
        """Rows beside events, if contacts, friction or switches may make any."""
        arrays = self.system.arrays
        bends = any(len(arrays[name]) for name in ("contact", "dry", "switch"))
        return self.break_arrays() if bends else self.break_arrays(steps=0)

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
