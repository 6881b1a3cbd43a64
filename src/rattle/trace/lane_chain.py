"""Many calls of functions in turn, on every tile of a memory; and what lanes set aside until it pays to work on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.lib.stride_tricks import as_strided

# f(rows in (n_in, n), rows out (n_out, n)): column by column, for any n that is a multiple of 8 or of the width of a
# tile; arrays are float64, do not overlap, and each row is without gaps, at any distance from the next
Function = Callable[[np.ndarray, np.ndarray], None]
Call = tuple[Function, np.ndarray, np.ndarray]  # a function with its rows in and out


class Aside(NamedTuple):
    """A call that copies lanes that ask into columns aside; when these are full, calls work on all of them at once.

    What comes of it goes back to the lane, in any order: it only makes numbers larger.  So what few lanes need at a
    time costs as much as those few.  All rows are of the first tile.
    """

    asks: np.ndarray  # (n,) not 0 in lanes that ask
    copies: Sequence[tuple[np.ndarray, np.ndarray]]  # rows of lanes (k, n), and of columns
    lane: np.ndarray  # (n,) of each column
    taken: np.ndarray  # (1,) number of columns that are in use
    calls: Sequence[Call]
    larger: Sequence[tuple[np.ndarray, np.ndarray]]  # rows of columns (n,), and of lanes that become as large at least


Calls = Sequence[Call | Aside]


class Chain(Protocol):
    """Makes one call of many functions in turn, on each tile of a memory (tiles, rows, n), so many times.

    calls: with rows of the first tile; running: the row that is not 0 in lanes that still run.  A tile in which no lane
    runs (any more) is left alone.  What lanes that have stopped have set aside is done at the end.
    """

    def __call__(self, calls: Calls, memory: np.ndarray, running: int, times: int) -> Callable[[], None]: ...


def one_by_one(calls: Calls, memory: np.ndarray, running: int, times: int) -> Callable[[], None]:
    """The chain that Python makes."""
    tiles = [_Tile(memory, k, calls, running) for k in range(len(memory))]

    def call() -> None:
        for tile in tiles:
            tile.run(times)

    return call


class _Tile:
    """Calls on one tile."""

    def __init__(self, memory: np.ndarray, k: int, calls: Calls, running: int) -> None:
        self.steps: list[Callable[[], None]] = []
        self.asides: list[_Columns] = []
        self.running = memory[k, running]
        for call in calls:
            if isinstance(call, Aside):
                self.asides.append(_Columns(memory, k, call))
                self.steps.append(self.asides[-1].take)
            else:
                self.steps.append(_bound(memory, k, call))

    def run(self, times: int) -> None:
        for _ in range(times):
            if self.running.any():
                for step in self.steps:
                    step()
        if not self.running.all():
            for aside in self.asides:
                aside.empty()


class _Columns:
    """What lanes of one tile have set aside."""

    def __init__(self, memory: np.ndarray, k: int, aside: Aside) -> None:
        self.asks, self.lane, self.taken = (in_tile(memory, k, part) for part in (aside.asks, aside.lane, aside.taken))
        self.copies, self.larger = (
            [(in_tile(memory, k, a), in_tile(memory, k, b)) for a, b in pairs] for pairs in (aside.copies, aside.larger)
        )
        self.calls = [_bound(memory, k, part) for part in aside.calls]

    def take(self) -> None:
        """Copy the lanes that ask."""
        for lane in np.flatnonzero(self.asks):
            if self.taken[0] == len(self.lane):
                self.empty()
            column = int(self.taken[0])
            for rows, columns in self.copies:
                columns[:, column] = rows[:, lane]
            self.lane[column] = lane
            self.taken[0] += 1

    def empty(self) -> None:
        """Work on all columns."""
        if self.taken[0] > 0:
            for call in self.calls:
                call()
        for column in range(int(self.taken[0])):
            lane = int(self.lane[column])
            for rows, held in self.larger:
                if rows[column] > held[lane]:
                    held[lane] = rows[column]
        self.taken[0] = 0


def _bound(memory: np.ndarray, k: int, call: Call) -> Callable[[], None]:
    function, rows, out = call[0], in_tile(memory, k, call[1]), in_tile(memory, k, call[2])
    return lambda: function(rows, out)


def in_tile(memory: np.ndarray, k: int, rows: np.ndarray) -> np.ndarray:
    """Rows of tile k, from those of the first one."""
    start = (rows.ctypes.data - memory.ctypes.data) // 8
    return as_strided(memory.reshape(-1)[start + k * memory[0].size :], rows.shape, rows.strides)
