"""Worst case: the output where every contributor is at an end of its field.

An output that is monotone along every contributor, whatever the others are, has its extremes at corners.  Up to ten
contributors all 2^d corners are run.  Beyond, the search begins at the corners to which the slopes point, and goes to
the best of the d corners beside as long as that is worse than the last one.

An output that is not monotone may be worse inside of the fields: samples that lie beyond the corners say so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rattle.questions.ensemble.contributors import at_ends, labels
from rattle.questions.ensemble.fields import Fields
from rattle.questions.ensemble.runs import Samples
from rattle.questions.tolerance.trials import Trials
from rattle.studies.runs.columns import number, scale_of

ALL = 10  # contributors up to which all corners are run
PASSES = 50  # of the search beyond
ROUNDING = 1e-12  # share of the output that is allowed besides: a worst case of no width leaves BEYOND nothing
BEYOND = 1e-6  # share of the worst case by which a sample lies beyond it for certain: errors of runs


@dataclass(frozen=True)
class Corners:
    """Extremes (low, high) of an output at corners [SI], nan where a corner cannot be run."""

    low: float
    high: float
    count: int  # of the corners that were looked at
    notes: tuple[str, ...] = ()


def every_corner(d: int) -> np.ndarray:
    """(2^d, d) which contributors are at their upper ends."""
    return np.asarray((np.arange(2**d)[:, None] >> np.arange(d)) % 2 == 1)


def extremes(samples: Samples, corners: np.ndarray, fields: Fields, outputs: np.ndarray) -> Corners:
    """The worst case from runs of all corners (n, d), the first samples, with outputs (n,) [SI]."""
    lost = np.flatnonzero(~np.isfinite(outputs))
    if not len(lost):
        return Corners(float(outputs.min()), float(outputs.max()), len(corners))
    first = int(lost[0])
    words = f"worst case unknown: {len(lost)} of {len(corners)} corners have no value, such as {samples.told(first)}"
    reason = samples.message(first) or "the output has no value there"
    return Corners(float("nan"), float("nan"), len(corners), (f"{words}: {reason}",))


def search(trials: Trials, fields: Fields, effects: np.ndarray) -> Corners:
    """The worst case of many contributors with first-order effects (d,) [SI]."""
    ends, count, notes = [], 0, []
    for sign in (-1.0, 1.0):
        value, looked, note = _climb(trials, fields, sign * effects > 0.0, sign)
        ends.append(value)
        count += looked
        notes += [note] if note else []
    words = f"worst case from {count} of the 2^{fields.draws} corners: those to which the slopes point, and beside"
    return Corners(ends[0], ends[1], count, (words, *dict.fromkeys(notes)))


def _climb(trials: Trials, fields: Fields, corner: np.ndarray, sign: float) -> tuple[float, int, str]:
    """The greatest value of sign*output at corners, from one on; how many were looked at; what is to be said."""
    run = trials.run(at_ends(fields, corner[None]))
    best = sign * float(run[run.outputs[0]][0])
    if not np.isfinite(best):
        reason = run.message(0) or "the output has no value there"
        return float("nan"), 1, f"worst case unknown: {run.told(0)} has no value: {reason}"
    count, lost = 1, ""
    for _ in range(PASSES):
        beside = corner ^ np.eye(len(corner), dtype=bool)
        run = trials.run(at_ends(fields, beside))
        values = sign * run[run.outputs[0]]
        count += len(values)
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            reason = run.message(int(bad[0])) or "the output has no value there"
            lost = f"worst case unknown: {run.told(int(bad[0]))} has no value: {reason}"
            return float("nan"), count, lost
        if values.max() <= best:
            return sign * best, count, ""
        corner, best = beside[int(values.argmax())], float(values.max())
    return sign * best, count, f"the search for the worst corner was stopped after {PASSES} steps"


# ---------------------------------------------------------------- inside of the fields
def beyond(trials: Trials, fields: Fields, worst_case: Corners, values: np.ndarray, outputs: np.ndarray) -> str:
    """What is said of samples with values (k, n) and outputs (n,) [SI] that are worse than all corners; "" if none."""
    finite = np.isfinite(outputs)
    if not finite.any() or not np.isfinite([worst_case.low, worst_case.high]).all():
        return ""
    allowed = BEYOND * (worst_case.high - worst_case.low) + ROUNDING * max(abs(worst_case.low), abs(worst_case.high))
    for sign, limit, word in ((1.0, worst_case.high, "greater"), (-1.0, -worst_case.low, "less")):
        worst = int(np.argmax(np.where(finite, sign * outputs, -np.inf)))
        if sign * outputs[worst] <= limit + allowed:
            continue
        names = _inside(trials, fields, values[:, worst], sign * float(outputs[worst]), sign)
        factor, unit = scale_of([worst_case.low, worst_case.high], trials.task.outputs[0].unit)
        shown = number(factor * float(outputs[worst]), factor * (worst_case.high - worst_case.low))
        where = f" in {', '.join(names)}" if names else ""
        return (
            f"the output is not monotone{where}: the worst case is inside of the fields, not at their corners;"
            f" a sample is {word} than all corners, {shown} {unit}".rstrip()
        )
    return ""


def _inside(trials: Trials, fields: Fields, values: np.ndarray, worst: float, sign: float) -> list[str]:
    """Contributors of which both ends are better than a sample with values (k,) and sign*output `worst` [SI]."""
    rows = []
    for contributor in range(fields.draws):
        for end in (False, True):
            ends = at_ends(fields, np.full((1, fields.draws), end))[:, 0]
            rows.append(np.where(np.array(fields.draw) == contributor, ends, values))
    moved = sign * trials.outputs(np.array(rows).T).reshape(fields.draws, 2)
    return [name for name, pair in zip(labels(fields), moved, strict=True) if (pair < worst).all()]
