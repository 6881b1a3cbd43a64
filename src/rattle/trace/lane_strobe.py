"""Samples side by side, seen at instants of their own: as a stroboscope shows what turns at different speeds."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable

import numpy as np

from rattle.trace.lane_batch import Batch
from rattle.trace.lane_control import Status
from rattle.trace.lane_program import EIGHT, Program
from rattle.trace.lane_start import Stock
from rattle.trace.lanes import WIDTH, at_once

LOOKS = 16  # steps between two looks; lanes that have come to an instant wait for half of them


class Strobe:
    """n samples at p instants each.  What has been seen stays, also if it is stopped."""

    def __init__(self, program: Program, parameters: np.ndarray, times: np.ndarray) -> None:
        """parameters: (np, n) [SI]; times: (n, p) [s], rising from above 0 to the end of the program at most."""
        self.program, self.parameters, self.times = program, parameters, times
        self.values = np.full((len(program.ledger.reductions), *times.shape), np.nan)  # of the reductions, [SI]
        self.status = np.full(len(times), Status.TOO_MANY_STEPS, dtype=np.int8)  # DONE once all are seen
        self._broken, self._lock = False, threading.Lock()

    def run(self, threads: int = 1, progress: Callable[[int], None] | None = None) -> None:
        """Follow all samples; progress is called with numbers of samples all of which is seen, from the threads, one at
        a time."""
        shares = [share for share in np.array_split(np.arange(len(self.times)), max(1, threads)) if len(share)]
        at_once([functools.partial(self._follow, share, progress) for share in shares], self._halt)

    def _halt(self) -> None:
        self._broken = True

    def _follow(self, samples: np.ndarray, progress: Callable[[int], None] | None) -> None:
        width = min(WIDTH, -(-len(samples) // EIGHT) * EIGHT)
        batch, stock = Batch(self.program, width, LOOKS), Stock(self.program, width)
        seen, begun = np.zeros(len(self.times), dtype=np.int64), 0
        with np.errstate(all="ignore"):
            while not self._broken:
                idle = np.flatnonzero(batch.sample < 0)
                if len(idle) and begun < len(samples):
                    some = samples[begun : begun + len(idle)]
                    begun += len(some)
                    self._begin(batch, stock, idle, some)
                if (batch.sample < 0).all():
                    if begun == len(samples):
                        break
                    continue
                through = batch.step()
                if len(through) and (ended := self._look(batch, through, seen)) and progress is not None:
                    with self._lock:
                        progress(ended)

    def _begin(self, batch: Batch, stock: Stock, idle: np.ndarray, samples: np.ndarray) -> None:
        """Put samples into idle lanes."""
        self.status[samples] = stock.fill(self.parameters[:, samples])
        sound = np.flatnonzero(self.status[samples] == Status.DONE)
        lanes = idle[: len(sound)]
        batch.take(lanes, stock, sound, samples[sound])
        batch.go_on(lanes, self.times[samples[sound], 0])

    def _look(self, batch: Batch, through: np.ndarray, seen: np.ndarray) -> int:
        """Note what lanes show that have come to an instant, and let them go on; how many have shown all."""
        status, _, values, _ = batch.ended(through)
        samples, good = batch.sample[through], status == Status.DONE
        self.values[:, samples[good], seen[samples[good]]] = values[:, good]
        seen[samples[good]] += 1
        self.status[samples] = status
        goes_on = good & (seen[samples] < self.times.shape[1])
        batch.sample[through[~goes_on]] = -1
        further = samples[goes_on]
        batch.go_on(through[goes_on], self.times[further, seen[further]])
        return int((good & ~goes_on).sum())
