"""Curves of an ensemble at common instants, kept or run again, for the band in which they lie."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rattle.analyses import arguments
from rattle.errors import AssemblyError, InputError, ModelError, SolverError, suggest
from rattle.questions.ensemble.pieces import FAILED, WAITING
from rattle.questions.ensemble.runs import Samples
from rattle.results.result import UnknownName
from rattle.studies.runs.analyses import analysis_of
from rattle.studies.runs.runner import Runner, cores
from rattle.studies.runs.task import Task


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
    if not e.task.t_end > 0.0:
        raise InputError(f"{curve}: a band is drawn over time, and this ensemble is of one instant; give it a t_end")
    units = analysis_of(e.task.analysis).names(e.task.mechanism)
    if curve not in units:
        raise UnknownName(f"no curve '{curve}'{suggest(curve, units)}")
    task = replace(e.task, outputs=(), histories=(curve,), history_units=(units[curve],))
    status = e.store.status()
    numbers = np.flatnonzero(status != WAITING)[:count]
    sound = numbers[status[numbers] != FAILED]
    curves, messages = _kept(e, curve, sound) if curve in e.task.histories else _run(e, task, sound, threads)
    good = curves[np.isfinite(curves).all(axis=1)]
    if not len(good):
        why = next(iter(messages.values()), "") or next(iter(e.messages.values()), "it has no finite value")
        raise InputError(f"{curve}: none of {len(numbers)} members could be run: {why}")
    return Band(
        curve, units[curve], task.history_times, good, _nominal(task), len(numbers) - len(good), len(e), e.parameters
    )


def _kept(e: Samples, curve: str, numbers: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
    """Curves (n, k) [SI] of some samples as they were kept."""
    curves = [e.history(n, curve)[1] for n in numbers.tolist()]
    return np.array(curves).reshape(len(numbers), len(e.task.history_times)), {}


def _run(e: Samples, task: Task, numbers: np.ndarray, threads: int | None) -> tuple[np.ndarray, dict[int, str]]:
    """Curves (n, k) [SI] of some samples, nan where there are none, and why."""
    values = [e.plan.values(n, n + 1) for n in numbers.tolist()]
    batch = Runner(task).run(
        np.hstack([np.empty((len(task.names), 0)), *values]), cores() if threads is None else threads
    )
    return batch.curves[0], batch.messages


def _nominal(task: Task) -> np.ndarray | None:
    """The curve (k,) without deviations [SI], None if it cannot be run."""
    try:
        result = task.result(task.mechanism, task.history_times, task.histories)
    except (ModelError, AssemblyError, SolverError):
        return None
    values = np.asarray(result[task.histories[0]], dtype=float)
    return values if np.isfinite(values).all() else None
