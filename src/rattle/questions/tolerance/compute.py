"""Tolerance studies: slopes, corners and samples of an output whose parameters have tolerances."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from rattle.analyses import arguments
from rattle.errors import InputError, WrongType
from rattle.questions.ensemble.compute import nominal_run
from rattle.questions.ensemble.contributors import added, at_ends, half_widths
from rattle.questions.ensemble.fields import Fields, Vary, fields_of
from rattle.questions.tolerance import corners
from rattle.questions.tolerance.allocation import costs_of
from rattle.questions.tolerance.report import Tolerance
from rattle.questions.tolerance.required_accuracy import Within, limits_about
from rattle.questions.tolerance.slopes import Slopes, slopes
from rattle.questions.tolerance.sobol import Indices, Rows, indices, unknown
from rattle.questions.tolerance.trials import Trials
from rattle.studies.runs.task import task_of

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

MOST_ROWS = 2**20
SIDE_BY_SIDE, ONE_BY_ONE = 1024, 512  # rows unless given
LINEAR = 0.1  # share by which the standard deviation of the samples may differ from that by slopes, else it is said
STILL = 1e-9  # share of the output up to which its samples spread by rounding alone


def tolerance(
    m: Mechanism, of: str, vary: Vary = None, *, analysis: str = "simulate", t_end: float | None = None,
    n: int | None = None, seed: int = 0, threads: int | None = None, progress: bool = False,
) -> Tolerance:  # fmt: skip
    """What tolerances do to an output; see `Mechanism.tolerance`."""
    if n is not None:
        _require_rows(n)
    fields = fields_of(m, vary)
    if not isinstance(of, str):
        raise WrongType(f"of: expected one output such as 'max(O3.force)', got {of!r:.60}")
    task = task_of(m, fields.names, [of], analysis=analysis, t_end=t_end)
    (value,), remarks = nominal_run(task)
    if not math.isfinite(value):
        raise InputError(f"of: {of!r} has no value without deviations" + "".join(f"; {remark}" for remark in remarks))
    trials = Trials(task, threads, progress)
    count = n or (SIDE_BY_SIDE if trials.side_by_side else ONE_BY_ONE)
    gradient = slopes(trials, fields, value)
    effects = added(fields, gradient.values * half_widths(fields))

    # corners and rows in one go
    rows = Rows(fields, seed, 2 * count)
    ends = corners.every_corner(rows.d) if rows.d <= corners.ALL else np.zeros((0, rows.d), dtype=bool)
    samples = trials.run(np.concatenate([at_ends(fields, ends), rows.values(0, count)], axis=1))
    outputs = samples[samples.outputs[0]]
    table = outputs[len(ends) :].reshape(rows.d + 2, count)
    worst = corners.extremes(samples, ends, fields, outputs[: len(ends)]) if len(ends) else None
    worst = worst or corners.search(trials, fields, effects)
    values = samples.plan.values(len(ends), samples.plan.count)
    inside = corners.beyond(trials, fields, worst, values, outputs[len(ends) :])
    shares, lost = _indices(trials, rows, table, seed)
    notes = [
        *remarks,
        *_linear(fields, gradient, table[:2].ravel(), value),
        *worst.notes,
        *lost,
        *([inside] if inside else []),
    ]
    return Tolerance(
        of, task.outputs[0].unit, value, fields, dict(zip(fields.names, gradient.values.tolist(), strict=True)),
        gradient.how, (worst.low, worst.high), shares, table[:2].ravel(), samples, trials, int(seed), tuple(notes),
    )  # fmt: skip


def require_limit(
    m: Mechanism, of: str, within: Within, cost: Mapping[str, float] | None, vary: Vary = None, *,
    analysis: str = "simulate", t_end: float | None = None,
) -> None:  # fmt: skip
    """Check, before anything runs, what is asked beside a tolerance study.  Raises what `Tolerance.allocate` raises."""
    fields = fields_of(m, vary)
    costs_of(fields, cost)
    limits_about(within, 0.0, task_of(m, fields.names, [of], analysis=analysis, t_end=t_end).outputs[0].unit)


def _require_rows(n: int) -> None:
    """Check the number of rows.  Raises InputError, TypeError."""
    count = arguments.whole("n", n, 2, MOST_ROWS)
    if count & (count - 1):
        near = 2 ** round(math.log2(count))
        raise InputError(f"n must be a power of two, for which Sobol's sequence is even; got {count}, take {near}")


def _indices(trials: Trials, rows: Rows, table: np.ndarray, seed: int) -> tuple[Indices, list[str]]:
    """Sobol indices from outputs (d + 2, n) at the rows, further rows in place of those without a value."""
    n = table.shape[1]
    whole = table[:, np.isfinite(table).all(axis=0)]
    lost = n - whole.shape[1]
    if not lost:
        return indices(table, seed), _still(table)
    if whole.shape[1]:
        more = min(n, math.ceil(1.2 * lost * n / whole.shape[1]) + 8)
        further = trials.outputs(rows.values(n, n + more)).reshape(rows.d + 2, more)
        whole = np.concatenate([whole, further[:, np.isfinite(further).all(axis=0)]], axis=1)[:, :n]
    left = whole.shape[1]
    loss = f"Sobol indices: {lost} of {n} rows have a sample without a value"
    if left < 2:
        return unknown(rows.d), [f"{loss}; there are none"]
    kept = 2 ** int(math.log2(left))
    what = "others stand in for them" if kept == n else f"they come from {kept} rows"
    return indices(whole[:, :kept], seed), [f"{loss}; {what}, so that they are those of mechanisms that can be run"]


def _still(table: np.ndarray) -> list[str]:
    if np.ptp(table) == 0.0:
        return ["the output is the same in all samples: its variance has no parts"]
    return []


def _linear(fields: Fields, slopes: Slopes, drawn: np.ndarray, value: float) -> list[str]:
    """What is said where slopes do not tell how far the output spreads."""
    finite = drawn[np.isfinite(drawn)]
    if not np.isfinite(slopes.values).all():
        missing = [name for name, slope in zip(fields.names, slopes.values, strict=True) if not math.isfinite(slope)]
        return [f"no slope by {', '.join(missing)}: root sum square unknown"]
    if len(finite) < 2:
        return []
    parts = added(fields, slopes.values * np.array([field.sd for field in fields.fields]))
    by_slopes, sampled = math.sqrt(float(parts @ parts)), float(finite.std(ddof=1))
    doubt = LINEAR + 1.0 / math.sqrt(len(finite))  # more than the sampling error of a standard deviation
    if abs(by_slopes - sampled) <= doubt * max(by_slopes, sampled) or sampled <= STILL * abs(value):
        return []
    ratio = f"{by_slopes / sampled:.2g} times" if sampled else "not"
    return [
        f"the output is not linear over the tolerances: by slopes it would spread {ratio} as far as it does; trust the"
        " samples, not the root sum square"
    ]
