"""Time integration of many samples of one smooth model side by side.

Samples stand in the columns (lanes) of arrays.  Every lane has its own time, step, error and end; a lane that is done
takes the next sample.  All arithmetic is that of graphs, or elementwise and exact as IEEE 754 says: a sample gives the
same bits whatever stands beside it, for any width, order of samples and number of threads.

A sample whose assumptions fail, or whose motion cannot be trusted, ends with a `Status` and without values.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from rattle.trace.lane_batch import Batch, Tallies
from rattle.trace.lane_control import Status
from rattle.trace.lane_program import EIGHT, Program
from rattle.trace.lane_start import Stock

WIDTH = 1024  # so many that Python's part between two looks is small; a tile is what must fit into the cache
LOOKS = 16  # steps between two looks; a lane that is through waits for half of them
STOCK = 1024  # samples made ready at once

Progress = Callable[[int, int], None]  # samples done, samples in all


class Outcome(NamedTuple):
    """What became of N samples."""

    values: np.ndarray  # (reductions, N) [SI], nan where the status is not DONE
    status: np.ndarray  # (N,) int8, see `Status`
    steps: np.ndarray  # (N,) int32, accepted steps
    tallies: Tallies  # of all


class _Work:
    """Samples handed out in order to threads, and what comes back."""

    def __init__(self, parameters: np.ndarray, values: int, progress: Progress | None) -> None:
        count = parameters.shape[1]
        self.parameters, self.count = parameters, count
        self.outcome = Outcome(
            np.full((values, count), np.nan), np.zeros(count, dtype=np.int8), np.zeros(count, dtype=np.int32), Tallies()
        )
        self.tallies, self.broken = Tallies(), False
        self._next, self._done, self._progress, self._lock = 0, 0, progress, threading.Lock()

    def take(self, most: int) -> range:
        """Numbers of the next samples, at most so many."""
        with self._lock:
            first = self._next
            self._next = min(self.count, first + most)
            return range(first, self._next)

    def finish(
        self, samples: np.ndarray, status: np.ndarray, steps: np.ndarray | int, values: np.ndarray | None
    ) -> None:
        """Note how samples ended; values: of those that are done, in order."""
        self.outcome.status[samples], self.outcome.steps[samples] = status, steps
        if values is not None:
            self.outcome.values[:, samples[status == Status.DONE]] = values
        if self._progress is not None and len(samples):
            with self._lock:
                self._done += len(samples)
                self._progress(self._done, self.count)

    def spend(self, tallies: Tallies) -> None:
        """Note what samples took."""
        with self._lock:
            self.tallies = self.tallies.plus(tallies)


def run(
    program: Program, parameters: np.ndarray, *, width: int = WIDTH, looks: int = LOOKS, threads: int = 1,
    progress: Progress | None = None,
) -> Outcome:  # fmt: skip
    """Integrate the samples of parameters (np, N) from 0 to the end of the program.

    width: number of lanes of each thread, at most; looks: steps after which lanes that are through take new samples.
    progress is called from the threads, one at a time.
    """
    work = _Work(np.asarray(parameters, dtype=float), len(program.ledger.reductions), progress)
    share = -(-work.count // (EIGHT * threads)) * EIGHT
    sizes = min(width, share), min(STOCK, share), looks

    def halt() -> None:
        work.broken = True

    at_once([lambda: _integrate(program, work, *sizes)] * threads, halt)
    return work.outcome._replace(tallies=work.tallies)


def at_once(jobs: Sequence[Callable[[], None]], halt: Callable[[], None]) -> None:
    """Do all jobs, on as many threads; one job here.  halt: makes the others end if one of them raises."""
    if len(jobs) == 1:
        jobs[0]()
        return
    with ThreadPoolExecutor(len(jobs)) as pool:
        waiting = [pool.submit(job) for job in jobs]
        try:
            for job in waiting:
                job.result()
        except BaseException:
            halt()
            raise


def _integrate(program: Program, work: _Work, width: int, stock_size: int, looks: int) -> None:
    """Take samples until there are none left."""
    batch, stock, shelf = Batch(program, width, looks), Stock(program, stock_size), _Shelf()
    tallies = Tallies()
    with np.errstate(all="ignore"):
        while not work.broken:
            idle = np.flatnonzero(batch.sample < 0)
            if len(idle):
                tallies = tallies.plus(Tallies(_fill(batch, idle, stock, shelf, work)))
                if (batch.sample < 0).all():
                    break
            through = batch.step()
            if len(through):
                status, steps, values, spent = batch.ended(through)
                tallies = tallies.plus(spent)
                work.finish(batch.sample[through], status, steps, values[:, status == Status.DONE])
                batch.sample[through] = -1
    work.spend(tallies)


class _Shelf:
    """Columns of the stock that no lane has taken yet, and their samples."""

    def __init__(self) -> None:
        self.columns = self.samples = np.zeros(0, dtype=np.int64)


def _fill(batch: Batch, idle: np.ndarray, stock: Stock, shelf: _Shelf, work: _Work) -> int:
    """Give samples to idle lanes while there are any; returns the number of right-hand sides that it took."""
    spent = 0
    while len(idle):
        if not len(shelf.columns):
            numbers = work.take(stock.n)
            if not numbers:
                break
            samples = np.arange(numbers.start, numbers.stop)
            status = stock.fill(work.parameters[:, numbers.start : numbers.stop])
            spent += stock.evaluations * len(samples)
            failed = status != Status.DONE
            if failed.any():
                work.finish(samples[failed], status[failed], 0, None)
            shelf.columns = np.flatnonzero(~failed)
            shelf.samples = samples[~failed]
        count = min(len(idle), len(shelf.columns))
        batch.take(idle[:count], stock, shelf.columns[:count], shelf.samples[:count])
        idle, shelf.columns, shelf.samples = idle[count:], shelf.columns[count:], shelf.samples[count:]
    return spent
