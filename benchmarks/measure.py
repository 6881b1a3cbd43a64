"""Fair timing: things that are compared take turns in one run, medians are kept, ratios are shown."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

Sampler = Callable[[], float]  # does the work once and says how long it took [s]


class Row(NamedTuple):
    """One line of the table. Times in seconds; `ratio` is ours divided by the yardstick's."""

    measure: str
    ours: float
    yardstick: str = ""
    theirs: float | None = None
    aim: str = ""
    seconds: bool = True

    @property
    def ratio(self) -> float | None:
        """How many times as long as the yardstick."""
        return self.ours / self.theirs if self.theirs else None


def timed(work: Callable[[], object]) -> Sampler:
    """Sampler for the wall time of `work`."""

    def sample() -> float:
        start = time.perf_counter()
        work()
        return time.perf_counter() - start

    return sample


def interleave(samplers: Mapping[str, Sampler], repeats: int) -> dict[str, float]:
    """Median of each sampler [s]; they take turns, so that a slow spell of the machine meets all of them.

    The first round warms caches up and is not counted.
    """
    samples: dict[str, list[float]] = {name: [] for name in samplers}
    for turn in range(repeats + 1):
        for name, sample in samplers.items():
            value = sample()
            if turn:
                samples[name].append(value)
    return {name: statistics.median(values) for name, values in samples.items()}


def spell(seconds: float) -> str:
    """A time with a fitting unit: 2.5e-7 -> "0.25 us"."""
    for size, unit in ((1.0, "s"), (1e-3, "ms")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3g} us"


def show(rows: Iterable[Row]) -> None:
    """Print rows as a table."""
    cells = [("", "rattle", "yardstick", "", "ratio", "aim")]
    for row in rows:
        ours = spell(row.ours) if row.seconds else f"{row.ours:.3f}"
        theirs = "" if row.theirs is None else spell(row.theirs)
        cells.append((row.measure, ours, theirs, row.yardstick, f"{row.ratio:.3g}" if row.ratio else "", row.aim))
    widths = [max(len(line[k]) for line in cells) for k in range(len(cells[0]))]
    for line in cells:
        print("  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip(), flush=True)
