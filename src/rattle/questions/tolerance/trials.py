"""Samples of one task at values that a study chooses as it goes: what can be prepared is prepared once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rattle.analyses import arguments
from rattle.questions.ensemble.plans import Given
from rattle.questions.ensemble.runs import Samples
from rattle.questions.ensemble.store import Memory
from rattle.questions.ensemble.work import how, run_here
from rattle.studies.runs.progress import Bar
from rattle.studies.runs.runner import Runner, cores
from rattle.studies.runs.task import Task


@dataclass(frozen=True, eq=False, repr=False)
class Tried(Samples):
    """Samples whose values a study has chosen."""

    def numbers(self, output: str) -> dict[str, float]:
        """Least and greatest value of an output [SI]."""
        values = self[output]
        finite = values[np.isfinite(values)]
        return {"least": float(finite.min()), "most": float(finite.max())} if len(finite) else {}


class Trials:
    """Runs batches of samples of a task on the threads of this process."""

    def __init__(self, task: Task, threads: int | None = None, progress: bool = False, what: str = "tolerance") -> None:
        self.task = task
        self.count = 0  # samples that were run
        self._runner = Runner(task)
        self._threads = cores() if threads is None else arguments.whole("threads", threads, 1)
        self._bar = what if progress else ""

    @property
    def side_by_side(self) -> bool:
        """True if samples run side by side."""
        return self._runner.side_by_side

    def run(self, values: np.ndarray) -> Tried:
        """Samples with values (k, n) [SI] of the parameters that differ.  Raises KeyboardInterrupt."""
        plan = Given(self.task.names, np.asarray(values, dtype=float))
        store = Memory(plan.names, self.task.texts, plan.count)
        bar = Bar(plan.count, self._bar) if self._bar else None
        try:
            run_here(self._runner, plan, store, self._threads, bar)
        finally:
            if bar is not None:
                bar.close()
        self.count += plan.count
        where = f"on {self._threads} thread{'s' if self._threads > 1 else ''}"
        return Tried(self.task, plan, store, how(store, where), False)

    def outputs(self, values: np.ndarray) -> np.ndarray:
        """(n,) the first output [SI] at values (k, n) [SI], nan where there is none."""
        samples = self.run(values)
        return samples[samples.outputs[0]]
