"""Ensembles: what tolerances of lengths, clearances, friction and loads do to numbers of a mechanism.

A sample is the mechanism with parameters drawn from their fields; sample i depends on the seed and on i alone.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from rattle.analyses import arguments
from rattle.errors import AssemblyError, InputError, ModelError, SolverError
from rattle.language.syntax import Name
from rattle.questions.ensemble import statistics
from rattle.questions.ensemble.bands import band
from rattle.questions.ensemble.fields import Fields, Vary, fields_of
from rattle.questions.ensemble.first_order import FirstOrder, first_order
from rattle.questions.ensemble.folder import store_of
from rattle.questions.ensemble.mean_slopes import mean_slopes
from rattle.questions.ensemble.pieces import OK
from rattle.questions.ensemble.plans import Drawn
from rattle.questions.ensemble.runs import Samples
from rattle.questions.ensemble.sampling import MOST, points
from rattle.questions.ensemble.statistics import Bounded, Statistics
from rattle.questions.ensemble.work import run_missing
from rattle.results.archive import package
from rattle.results.display import in_columns, table
from rattle.studies.runs.columns import number, scale_of
from rattle.studies.runs.limits import limit_of
from rattle.studies.runs.task import Task, task_of
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.mechanism import Mechanism

Limit = float | str | tuple[float | str | None, float | str | None] | None  # upper one, or (lower, upper)


@answers_in_words
@dataclass(frozen=True, eq=False, repr=False)
class Ensemble(Samples):
    """n samples whose parameters were drawn from their fields, with statistics of the outputs."""

    fields: Fields = field(repr=False)
    design: str
    seed: int
    nominal: tuple[float, ...]  # the outputs without deviations [SI]
    notes: tuple[str, ...]  # what is to be said of the mechanism without deviations

    def statistics(self, output: str) -> Statistics:
        """Statistics of an output [SI], of all samples in which it is finite."""
        return statistics.statistics(self[output])

    def summary(self) -> Any:
        """A pandas DataFrame, one row per output [SI], with 95 % confidence bounds in columns ..._low and ..._high.

        nominal, mean, sd, min, max, q05, q50, q95 (quantiles); n_ok samples with a finite value, n_failed without a
        run, n_not_finite with a value that is not finite.  Bounds are those of independent draws, see `statistics`.
        """
        pandas = package("pandas", "a table of statistics")
        failed = self.counts()["failed"]
        run = len(self) - self.counts()["not run"]
        rows = []
        for output, nominal in zip(self.outputs, self.nominal, strict=True):
            finite = np.isfinite(self[output])
            row: dict[str, Any] = {"unit": self.unit(output), "nominal": nominal, **self.numbers(output)}
            count = int(finite.sum())
            rows.append(row | {"n_ok": count, "n_failed": failed, "n_not_finite": run - failed - count})
        return pandas.DataFrame(rows, index=pandas.Index(self.outputs, name="output"))

    def numbers(self, output: str) -> dict[str, Any]:
        """Statistics of an output [SI] by their names in the summary."""
        numbers = self.statistics(output)
        row = _columns("mean", numbers.mean) | _columns("sd", numbers.sd) | {"min": numbers.least, "max": numbers.most}
        for share, bounded in numbers.quantiles.items():
            row |= _columns(f"q{round(100 * share):02d}", bounded)
        return row

    def yield_below(self, output: str, limit: float | str) -> Bounded:
        """Share of the mechanisms with an output at or below a limit, [SI] or such as "5 kN": (share, low, high).

        low and high hold the true share with 95 % confidence.  Samples without a run or a finite value count as beyond
        the limit, for the upper bound as within; but a `first` that does not come true is later than the run.
        """
        return self.yield_between(output, None, limit)

    def yield_above(self, output: str, limit: float | str) -> Bounded:
        """Share of the mechanisms with an output at or above a limit; as `yield_below`."""
        return self.yield_between(output, limit, None)

    def yield_between(self, output: str, low: float | str | None, high: float | str | None) -> Bounded:
        """Share of the mechanisms with an output between two limits; as `yield_below`."""
        least, most = (None if limit is None else self.limit(output, limit) for limit in (low, high))
        least, most = (-math.inf if least is None else least), (math.inf if most is None else most)
        if least > most:
            raise InputError(f"the lower limit, {low}, is above the upper one, {high}")
        values, status = self[output], self.store.status()
        decided = np.isfinite(values)
        inside = decided.copy()
        inside[decided] &= (values[decided] >= least) & (values[decided] <= most)
        if self._instant(output):  # one that did not come true in the run is later than its end
            never, end = ~decided & (status == OK), self.task.t_end
            late_enough = least <= end and most == math.inf
            inside |= never & late_enough
            decided |= never & (late_enough or most <= end)
        unknown = int((~decided & (status >= 0)).sum())
        return statistics.share(int(inside.sum()), int(decided.sum()), unknown)

    def limit(self, name: str, given: float | str) -> float:
        """A limit of an output or parameter, [SI] or such as "5 kN", in SI.  Raises InputError, TypeError."""
        dimension = self.task.outputs[self.outputs.index(name)].dimension if name in self.outputs else None
        return limit_of(given, self.unit(name) if name in (*self.outputs, *self.parameters) else "", "limit", dimension)

    def _instant(self, name: str) -> bool:
        """Whether an output is one `first`."""
        outputs = [output for output in self.task.outputs if output.text == name]
        return bool(outputs) and isinstance(outputs[0].outer, Name) and outputs[0].reductions[0].kind == "first"

    def contributions(self, output: str, ranks: bool | None = None) -> FirstOrder:
        """Shares of the variance of an output that each parameter, or group of them, causes alone, from the samples.

        ranks: of the ranks of the values instead; None: where a few samples carry most of the variance.  How shares
        are found, and their bounds: see `tolerance.first_order`.  Raises InputError for too few samples.
        """
        return first_order(self.fields, [self[name] for name in self.parameters], self[output], ranks)

    def slopes(self, output: str) -> dict[str, Bounded]:
        """How the mean of an output changes with each parameter [SI per SI]: (value, low, high), by its name.

        The derivative of the mean, averaged over the field with most weight at its middle, with 95 % bounds: where
        motions are chaotic it exists, though that of a single run does not.  A group counts as its first parameter.
        Samples without a finite value are left out; bounds are infinite where single samples decide.
        Raises InputError for too few samples.
        """
        return mean_slopes(self.fields, [self[name] for name in self.parameters], self[output])

    @overload
    def plot(self, output: str, limit: Limit = None, ax: None = None) -> Figure: ...
    @overload
    def plot(self, output: str, limit: Limit = None, *, ax: Axes) -> Axes: ...
    def plot(self, output: str, limit: Limit = None, ax: Axes | None = None) -> Figure | Axes:
        """Plot the histogram of an output with its 5, 50 and 95 % quantiles and the value without deviations.

        limit: upper limit, [SI] or such as "5 kN", or (lower, upper), with the share of the samples within, see
        `yield_between`.  A few values that are orders of magnitude away are left out, and it is said how many; values
        over several decades have a logarithmic axis.  Units are those of the tables (mm, deg).
        Returns a new figure, or `ax` if it is given.  Raises UnknownName, ValueError if no sample has a value.
        """
        from rattle.questions.ensemble.pictures import plot_output

        return plot_output(self, output, limit, ax)

    def plot_scatter(self, outputs: Sequence[str] | None = None, parameters: Sequence[str] | None = None) -> Figure:
        """Plot outputs (rows) over parameters (columns), with Spearman's rank correlation in every panel.

        By default the first 6 outputs, and the 6 parameters with the closest relations to them.  Raises InputError for
        more of them, for unknown ones, or if no sample has a value.
        """
        from rattle.questions.ensemble.scatter import plot_scatter

        return plot_scatter(self, outputs, parameters)

    @overload
    def plot_band(self, curve: str, members: int = 100, ax: None = None) -> Figure: ...
    @overload
    def plot_band(self, curve: str, members: int = 100, *, ax: Axes) -> Axes: ...
    def plot_band(self, curve: str, members: int = 100, ax: Axes | None = None) -> Figure | Axes:
        """Plot the band of a curve over time [s]: 5 to 95 %, 25 to 75 %, median, some members, and the nominal one.

        The first `members` samples are run again at 201 instants, unless their histories were kept; those that cannot
        be run are left out, and it is said how many.  A new figure has a second panel with the deviations from the
        nominal curve if the band is narrow.
        Returns the figure, or `ax` if it is given.
        Raises UnknownName; ValueError for an analysis of one instant, or if no member can be run.
        """
        from rattle.questions.ensemble.pictures import plot_band

        return plot_band(band(self, curve, members), ax)

    @overload
    def plot_contributions(self, output: str, ax: None = None, *, ranks: bool | None = None) -> Figure: ...
    @overload
    def plot_contributions(self, output: str, ax: Axes, *, ranks: bool | None = None) -> Axes: ...
    def plot_contributions(
        self, output: str, ax: Axes | None = None, *, ranks: bool | None = None
    ) -> Figure | Axes:  # fmt: skip
        """Plot `contributions` as bars with their 95 % bounds, and what they explain together.

        Returns a new figure, or `ax` if it is given.
        """
        from rattle.questions.ensemble.shares import plot_contributions

        return plot_contributions(self, output, self.contributions(output, ranks), ax)

    def remarks(self) -> list[str]:
        """What must be said of the samples, and of the mechanism without deviations."""
        never = [(output, int((np.isnan(self[output]) & (self.store.status() == OK)).sum())) for output in self.outputs]
        reached = [f"{output} is reached in all but {count} samples" for output, count in never if count]
        return [*super().remarks(), *reached, *self.notes]

    def __repr__(self) -> str:
        return f"<rattle.Ensemble: {self._title()}>"

    def _title(self) -> str:
        count = f"{len(self)} sample{'s' if len(self) > 1 else ''}"
        return f"{count} of {', '.join(self.parameters)} ({self.design}, seed {self.seed})"

    def rows(self) -> list[tuple[str, ...]]:
        """Outputs with their statistics as texts, see HEADER."""
        rows = []
        for output, nominal in zip(self.outputs, self.nominal, strict=True):
            stats = self.statistics(output)
            half, sd = 0.5 * (stats.mean.high - stats.mean.low), stats.sd.value
            values = (stats.mean.value, nominal, *(q.value for q in stats.quantiles.values()), stats.least, stats.most)
            factor, unit = scale_of((*values, sd), self.unit(output))
            mean, *texts = (number(factor * x, factor * sd) for x in values)
            bounded = math.isfinite(half)
            spread = (f"{mean} +- {factor * half:.3g}", f"{factor * sd:.3g}") if bounded else (mean, "-")
            rows.append((output, unit, texts[0], *spread, *texts[1:]))
        return rows

    def __str__(self) -> str:
        return "\n".join([self._title(), *in_columns([HEADER, *self.rows()]), *self.remarks()])

    def _repr_html_(self) -> str:
        return table(HEADER, self.rows(), self._title(), self.remarks(), f'e.plot("{self.outputs[0]}")')


HEADER = ("output", "unit", "nominal", "mean (95 %)", "sd", "5 %", "median", "95 %", "min", "max")


def _columns(name: str, number: Bounded) -> dict[str, float]:
    return {name: number.value, f"{name}_low": number.low, f"{name}_high": number.high}


def ensemble(
    m: Mechanism, n: int, outputs: Sequence[str], vary: Vary = None, *, seed: int = 0, analysis: str = "simulate",
    t_end: float | None = None, design: str = "sobol", histories: Sequence[str] = (), rtol: float | None = None,
    method: str | None = None, threads: int | None = None, executor: Executor | None = None,
    scheduler: str | None = None, workers: int | None = None, folder: str | os.PathLike[str] | None = None,
    resume: bool = True, progress: bool = False,
) -> Ensemble:  # fmt: skip
    """Outputs of n samples; see `Mechanism.ensemble`."""
    count = arguments.whole("n", n, 1, MOST)
    fields = fields_of(m, vary)
    task = task_of(
        m, fields.names, outputs, analysis=analysis, t_end=t_end, rtol=rtol, method=method, histories=histories
    )
    plan = Drawn(fields, points(design, seed, fields.draws, count))
    store = store_of(task, plan, folder, resume)
    nominal, notes = nominal_run(task)
    how, interrupted = run_missing(
        task, plan, store, executor=executor, scheduler=scheduler, workers=workers, threads=threads, progress=progress
    )
    return Ensemble(task, plan, store, how, interrupted, fields, design, int(seed), nominal, notes)


def require_limit(
    m: Mechanism, output: str, limit: float | str, vary: Vary = None, *, analysis: str = "simulate",
    t_end: float | None = None,
) -> None:  # fmt: skip
    """Check a limit of an output before anything runs.  Raises InputError, TypeError, and what `ensemble` raises."""
    asked = task_of(m, fields_of(m, vary).names, [output], analysis=analysis, t_end=t_end).outputs[0]
    limit_of(limit, asked.unit, dimension=asked.dimension)


def nominal_run(task: Task) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """The outputs of the mechanism without deviations [SI], and what is to be said of its run."""
    try:
        values, result = task.look(task.mechanism, whole=True)
    except (ModelError, AssemblyError, SolverError) as error:
        return (math.nan,) * len(task.outputs), (f"without deviations: {error}",)
    trust = result.trust
    of_start = task.mechanism.start.notes  # how given start values were taken: the same for every sample
    remarks = replace(
        trust,
        notes=tuple(note for note in trust.notes if note not in of_start),
        pulled={joint: share for joint, share in trust.pulled.items() if share > 0.0},  # good news is no remark
    ).remarks()
    notes = [note for note in ("; ".join(task.unread(result)), remarks) if note]
    return tuple(values), tuple(f"without deviations: {note}" for note in notes)
