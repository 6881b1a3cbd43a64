"""Curves of an ensemble at common instants, kept or run again, for the band in which they lie."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.dynamics.run import stop
from rattle.errors import AssemblyError, ModelError, SolverError, suggest
from rattle.results.result import UnknownName
from rattle.studies.ensemble.pieces import FAILED, WAITING
from rattle.studies.ensemble.samples import Samples
from rattle.studies.runs.runner import cores
from rattle.studies.runs.task import HISTORY_POINTS, Task

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Band:
    """A curve of members of an ensemble."""

    curve: str
    unit: str  # SI
    t: np.ndarray  # (k,) [s]
    members: np.ndarray  # (n, k) [SI]
    nominal: np.ndarray | None  # (k,) without deviations [SI], if that can be run
    failed: int  # members without a curve
    samples: int  # of the ensemble
    parameters: tuple[str, ...]


def band(e: Samples, curve: str, members: int, threads: int | None = None) -> Band:
    """The curve of the first members of an ensemble: as it was kept, or run again at common instants.

    Raises UnknownName; ValueError for an analysis at rest, or if no member can be run.
    """
    count = min(arguments.whole("members", members, 1), len(e))
    task = e.task
    if not task.t_end > 0.0:
        raise ValueError(f"{curve}: a band is drawn over time, and this ensemble is of one instant; give it a t_end")
    times = np.linspace(0.0, task.t_end, HISTORY_POINTS)
    numbers = [int(n) for n in np.flatnonzero(e.store.status() != WAITING)[:count]]
    known = e.store.status()[numbers] != FAILED
    first = _curve(task, task.mechanism, curve, times)  # alone, because it compiles
    with ThreadPoolExecutor(cores() if threads is None else threads) as pool:
        try:
            runs = [pool.submit(_sample, e, n, curve, times) for n, ok in zip(numbers, known, strict=True) if ok]
            found: Sequence[Outcome] = [one.result() for one in runs]
        except BaseException:
            stop.set()  # ends the runs in the other threads
            raise
        finally:
            pool.shutdown(cancel_futures=True)
            stop.clear()
    good = [one for one in found if not isinstance(one, str)]
    if not good:
        why = next((one for one in found if isinstance(one, str)), next(iter(e.messages.values()), ""))
        raise ValueError(f"{curve}: none of {len(numbers)} members could be run: {why}")
    return Band(
        curve, good[0][1], times, np.array([one[0] for one in good]), None if isinstance(first, str) else first[0],
        len(numbers) - len(good), len(e), e.parameters,
    )  # fmt: skip


Outcome = tuple[np.ndarray, str] | str  # curve and unit, or why there is none


def _sample(e: Samples, number: int, curve: str, times: np.ndarray) -> Outcome:
    if curve in e.task.histories:
        return _finite(curve, e.history(number, curve)[1], e.unit(curve))
    try:
        m = e.sample(number)
    except ModelError as error:
        return str(error)
    return _curve(e.task, m, curve, times)


def _curve(task: Task, m: Mechanism, curve: str, times: np.ndarray) -> Outcome:
    """A curve [SI] of a mechanism with its unit, or why there is none.  Raises UnknownName."""
    try:
        result = task.result(m, times, {curve})
    except (ModelError, AssemblyError, SolverError) as error:
        return str(error)
    if curve not in result:
        raise UnknownName(f"no curve '{curve}'{suggest(curve, result.names)}")
    values = np.asarray(result[curve], dtype=float)
    return _finite(curve, values if len(values) == len(times) else np.full(len(times), np.nan), result.unit(curve))


def _finite(curve: str, values: np.ndarray, unit: str) -> Outcome:
    """Values of a curve with their unit, if all are finite."""
    return (values, unit) if np.isfinite(values).all() else f"{curve} has no finite value at some instants"
