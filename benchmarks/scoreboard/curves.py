"""Time against error: what is measured of a program, and the time at an error that others reach, too."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

SHORTEST, LONGEST = 0.01, 0.4  # [s] a sample repeats quick work; no finer setting follows one that took longer
SAMPLES = 3


class Way(NamedTuple):
    """One way to solve a case with one program: settings from coarse to fine, each ready to be solved."""

    program: str
    name: str
    settings: Sequence[tuple[str, Callable[[], Callable[[], np.ndarray]]]]  # name, what makes the call that is timed


class Point(NamedTuple):
    """What one setting took and missed by."""

    program: str
    setting: str
    error: float
    seconds: float


class Case(NamedTuple):
    """What is solved: `truth` is what every way must return; what each program leaves out stands in `about`."""

    key: str
    title: str
    about: str
    unit: str
    truth: np.ndarray
    ways: Sequence[Way]


def seconds_of(solve: Callable[[], np.ndarray]) -> float:
    """Processor time of a call [s], the best of several; quick ones are repeated inside of a sample."""
    start = time.process_time()
    solve()
    once = time.process_time() - start
    if once > LONGEST:
        return once
    calls = max(1, math.ceil(SHORTEST / max(once, 1e-6)))
    best = math.inf
    for _ in range(SAMPLES):
        start = time.process_time()
        for _ in range(calls):
            solve()
        best = min(best, (time.process_time() - start) / calls)
    return best


def points_of(case: Case, programs: Iterable[str]) -> list[Point]:
    """All settings of the programs that are here, measured."""
    found = []
    for way in case.ways:
        if way.program not in programs:
            continue
        for setting, make in way.settings:
            solve = make()
            try:
                error = float(np.abs(solve() - case.truth).max())
            except (ValueError, RuntimeError):  # a program that gives up at this setting
                continue
            if not math.isfinite(error):
                continue
            seconds = seconds_of(solve)
            found.append(Point(way.program, f"{way.name}, {setting}", max(error, 1e-16), seconds))
            if seconds > LONGEST:
                break
    return found


def front(points: Iterable[Point]) -> list[Point]:
    """Points that no other one beats in both, from the largest error to the smallest."""
    kept: list[Point] = []
    for one in sorted(points, key=lambda point: (point.seconds, point.error)):
        if not kept or one.error < kept[-1].error:
            kept.append(one)
    return kept


def seconds_at(points: Iterable[Point], error: float) -> float | None:
    """Time at an error, between two points of the front in logarithms; None where no setting is as accurate.

    A program whose coarsest setting is more accurate is charged with this one.
    """
    best = front(points)
    if not best or best[-1].error > error:
        return None
    if best[0].error <= error:
        return best[0].seconds
    errors = np.log([point.error for point in best])[::-1]
    return float(np.exp(np.interp(math.log(error), errors, np.log([point.seconds for point in best])[::-1])))
