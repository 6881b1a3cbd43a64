"""A batch of samples after the other: side by side where that can vouch, one by one on threads otherwise."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rattle.analyses.dynamics.run import stop
from rattle.errors import AssemblyError, ModelError, SolverError, TraceError
from rattle.results.reductions import MAY_LACK
from rattle.studies.runs.reasons import alike
from rattle.studies.runs.side_by_side import SideBySide
from rattle.studies.runs.task import Sample, Task
from rattle.trace.lane_batch import Tallies

log = logging.getLogger("rattle")

Progress = Callable[[int, int], None]  # samples done, samples in all


@dataclass(eq=False)
class Batch:
    """What became of n samples."""

    values: np.ndarray  # (outputs, n) [SI], nan where there is none
    curves: np.ndarray  # (histories, n, instants) [SI], nan likewise
    messages: dict[int, str] = field(default_factory=dict)  # of samples without all their numbers, by their place
    unread: dict[int, str] = field(default_factory=dict)  # why forces of rigid contacts are no numbers, by their place
    lacking: list[int] = field(default_factory=list)  # places of those that were run
    generic: list[int] = field(default_factory=list)  # places of samples that ran one by one
    reasons: dict[str, int] = field(default_factory=dict)  # why those could not run side by side, and how many
    steps: int = 0
    tallies: Tallies = field(default_factory=Tallies)  # of those that ran side by side


class Runner:
    """Runs samples of one task; what can be prepared is prepared once.

    Sample i gives the same bits in whatever batch it runs and on how many threads.
    """

    def __init__(self, task: Task) -> None:
        self.task = task
        self.why = ""  # why no samples run side by side, "" if they do
        try:
            self._together: SideBySide | None = SideBySide(task)
        except TraceError as error:
            self._together, self.why = None, str(error)

    @property
    def side_by_side(self) -> bool:
        """True if samples run side by side."""
        return self._together is not None

    def run(self, values: np.ndarray, threads: int = 1, progress: Progress | None = None) -> Batch:
        """Run samples with values (k, n) [SI] of the parameters that differ.

        progress is called with the samples done and all.  Raises KeyboardInterrupt if the user stops it.
        """
        values = np.asarray(values, dtype=float)
        count = values.shape[1]
        shape = len(self.task.histories), count, len(self.task.history_times)
        batch = Batch(np.full((len(self.task.outputs), count), np.nan), np.full(shape, np.nan))
        waiting = np.arange(count)
        if self._together is not None and count:
            together = self._together.run(values, min(threads, count), progress)
            batch.values, batch.messages = together.values, together.messages
            waiting = np.setdiff1d(np.flatnonzero(together.open), list(together.messages))
            batch.reasons, batch.steps, batch.tallies = together.reasons, together.steps, together.tallies
        batch.generic = waiting.tolist()
        with _told_once():
            for done, (n, outcome) in enumerate(_one_by_one(self.task, values, batch.generic, threads), 1):
                if isinstance(outcome, str):
                    batch.messages[n] = outcome
                else:
                    batch.values[:, n], batch.curves[:, n] = outcome.outputs, outcome.curves
                    batch.unread |= {n: "; ".join(outcome.unread)} if outcome.unread else {}
                if progress is not None:
                    progress(count - len(waiting) + done, count)
        self._finish(batch)
        return batch

    def _finish(self, batch: Batch) -> None:
        """Say which outputs have no finite value though they should; nan of a `first` or of a contact says: never."""
        values, outputs = batch.values, self.task.outputs
        values[:, list(batch.messages)] = np.nan
        values[~np.isfinite(values)] = np.nan
        counted = np.array(
            [not any(part.kind in MAY_LACK for part in output.reductions) for output in outputs], dtype=bool
        )
        unread = np.isin(np.arange(values.shape[1]), list(batch.unread))
        lacks = np.isnan(values) & (counted[:, None] | unread)
        batch.lacking = [n for n in np.flatnonzero(lacks.any(axis=0)).tolist() if n not in batch.messages]
        for n in batch.lacking:
            plain = "no finite value: " + ", ".join(outputs[k].text for k in np.flatnonzero(lacks[:, n]))
            batch.messages[n] = batch.unread.get(n, plain)


def cores() -> int:
    """Threads to use unless the user says: one per core of this process, at most 8."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(8, usable)


def _one_by_one(task: Task, values: np.ndarray, places: list[int], threads: int) -> Iterator[tuple[int, Sample | str]]:
    """Outputs and curves of samples, or why they have none, as they come; the first alone, because it compiles."""
    waiting = iter(places)
    for n in waiting:
        yield n, _one(task, values[:, n])
        break
    if threads == 1 or len(places) < 3:
        for n in waiting:
            yield n, _one(task, values[:, n])
        return
    pool = ThreadPoolExecutor(threads)
    running: dict[Any, int] = {}
    try:
        while True:
            while len(running) < 2 * threads and (n := next(waiting, -1)) >= 0:
                running[pool.submit(_one, task, values[:, n])] = n
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                yield running.pop(future), future.result()
    except BaseException:
        stop.set()  # ends the runs in the other threads
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        stop.clear()


def _one(task: Task, values: np.ndarray) -> Sample | str:
    """The outputs and curves [SI] of a sample, or why it has none."""
    try:
        return task.run(values)
    except ModelError as error:
        return "; ".join(str(problem) for problem in error.problems)
    except (AssemblyError, SolverError) as error:
        return str(error)


# ---------------------------------------------------------------- what is said
@contextmanager
def _told_once() -> Iterator[None]:
    """Let pass what is said of the model once for all samples; why a sample failed is in its message."""
    once = _Once()
    log.addFilter(once)
    try:
        yield
    finally:
        log.removeFilter(once)


class _Once(logging.Filter):
    def __init__(self) -> None:
        super().__init__()
        self._known: set[str] = set()
        self._lock = threading.Lock()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether to let it pass."""
        text = alike(record.getMessage())  # its numbers differ from sample to sample
        with self._lock:
            new = record.levelno < logging.ERROR and text not in self._known
            self._known.add(text)
        return new
