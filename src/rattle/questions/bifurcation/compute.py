"""Bifurcation diagram: an output sampled once per period, over the values of a parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.dynamics.run import stop
from rattle.errors import InputError, ModelError, SolverError, TraceError
from rattle.language.syntax import Name
from rattle.language.times import Seconds
from rattle.progress_bar import progress_bar
from rattle.questions.poincare.compute import period_of
from rattle.results.display import quantity, table
from rattle.studies.runs.runner import cores
from rattle.studies.runs.side_by_side import SideBySide
from rattle.studies.runs.task import task_of
from rattle.trace.lane_control import Status

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


SEEN = 10.0  # periods of a driver in which nothing that is short beside them is missed

Run = Callable[["Mechanism", np.ndarray], tuple[np.ndarray, "Result"]]


@dataclass(frozen=True, repr=False)
class Bifurcation:
    """Points of a Poincare section over a parameter."""

    parameter: str
    values: np.ndarray  # (k,) of the parameter [SI]
    parameter_unit: str
    of: str  # the name of the output
    of_unit: str
    points: np.ndarray  # (k, points) of the output [SI]; nan where a run ended early
    rule: str
    interrupted: bool = False  # stopped by the user; points at values that were not reached are nan
    how: str = ""  # how many ran side by side, and why others did not

    def _repr_html_(self) -> str:
        finite = self.points[np.isfinite(self.points)]
        sizes = (
            [quantity(float(x), self.of_unit, 6) for x in (finite.min(), finite.max())] if len(finite) else ["-", "-"]
        )
        ends = [quantity(float(x), self.parameter_unit, 6) for x in self.values[[0, -1]]] if len(self.values) else []
        rows = [(self.parameter, *ends), (self.of, *sizes)] if ends else []
        title = f"{len(self.values)} values, {self.points.shape[1]} points each, {self.rule}"
        return table(("", "from", "to"), rows, title, hint="b.plot()")

    def __repr__(self) -> str:
        first, last = self.values[[0, -1]] if len(self.values) else (0.0, 0.0)
        shape = (
            f"{len(self.values)} values of {self.parameter} from {first:g} to {last:g} {self.parameter_unit}".rstrip()
        )
        return f"<rattle.Bifurcation: {self.of} over {shape}, {self.points.shape[1]} points each>"

    @overload
    def plot(self, ax: None = None) -> Figure: ...
    @overload
    def plot(self, ax: Axes) -> Axes: ...
    def plot(self, ax: Axes | None = None) -> Figure | Axes:
        """Plot the points over the parameter; returns a new figure, or `ax` if it is given."""
        from rattle.questions.bifurcation.pictures import plot_bifurcation

        return plot_bifurcation(self, ax)


def _rule(changed: Sequence[Mechanism], period: Seconds | None) -> str:
    """When points are taken, in words."""
    if period is None:
        return "once per turn of the driver"
    first, last = (period_of(neighbour, period) for neighbour in (changed[0], changed[-1]))
    if first != last:
        return f"once every {period}, from {first:.4g} to {last:.4g} s"
    return f"once every {first:.4g} s at every value"


def bifurcation(
    m: Mechanism, parameter: str, values: Sequence[float] | np.ndarray, of: str, *, period: Seconds | None = None,
    skip: int = 100, points: int = 100, method: str | None = None, rtol: float | None = None,
    atol: float | None = None, step: float | None = None, threads: int | None = None, progress: bool = False,
) -> Bifurcation:  # fmt: skip
    """Bifurcation diagram: an output once per period, over the values [SI] of a parameter.

    Every run has the start of the model; `skip` periods pass before `points` points are taken.  period: [s] or an
    expression over parameters such as "2*pi/w" (default: one turn of the driver), for every value anew.
    threads: number of runs at the same time (default: number of cores); the result does not depend on it.
    method, rtol, atol, step: as in `simulate`.
    Raises ModelError for a value that the model refuses, ValueError for wrong arguments, UnknownName for an output,
    SolverError if all runs stop before their first point.
    """
    arguments.whole("skip", skip, 0)
    arguments.whole("points", points, 1)
    if threads is not None:
        arguments.whole("threads", threads, 1)
    if skip + points < 2:
        raise InputError("the only point would be the start: give skip or points of at least 2 together")
    chosen = _values(values)
    changed = [m.neighbour({parameter: float(value)}) for value in chosen]
    times = np.array([period_of(neighbour, period) * (skip + np.arange(points)) for neighbour in changed])
    how = {"method": method, "rtol": m.model.settings.rtol if rtol is None else rtol, "atol": atol, "step": step}
    seen = np.full(times.shape, np.nan)
    bar = progress_bar(len(changed), "bifurcation", unit="run") if progress else None
    try:
        together = _side_by_side(m, parameter, chosen, of, times, how, threads or cores(), bar)
        seen[together.done] = together.points[together.done]
        unit, failure = together.unit, None
        alone = [] if together.interrupted else np.flatnonzero(~together.done).tolist()
        rows: list[np.ndarray] = []
        if alone:
            try:
                rows, first = _rows(_run(of, how), [changed[n] for n in alone], times[alone], threads, bar)
                unit, failure = first.unit(of), None if first.success else first
            except KeyboardInterrupt:
                if not together.done.any():
                    raise
            seen[alone[: len(rows)]] = np.reshape(rows, (-1, points))
    finally:
        if bar is not None:
            bar.close()
    through, rule = int(together.done.sum()) + len(rows), _rule(changed, period)
    interrupted = through < len(changed)
    if interrupted:
        rule += f", stopped by the user after {through} of {len(chosen)} values"
    elif failure is not None and not np.isfinite(seen).any():
        where = f"the first one at t = {failure.trust.t_end:.6g} s, {failure.message}"
        raise SolverError(f"no point: every run stopped before {skip} periods were over, {where}", failure)
    what = m.model.parameters.get(parameter)
    return Bifurcation(
        parameter, chosen, what.unit if what else "", of, unit, seen, rule, interrupted, together.words(len(alone))
    )


def _values(values: Sequence[float] | np.ndarray) -> np.ndarray:
    """(k,) values of the parameter.  Raises InputError."""
    chosen = np.asarray(values, dtype=float)
    if not chosen.size or chosen.ndim != 1:
        raise InputError("values of the parameter: expected a one-dimensional array with at least one value")
    return chosen


class _Together(NamedTuple):
    """What was seen of values that ran side by side."""

    points: np.ndarray  # (k, points) [SI]
    done: np.ndarray  # (k,) True where all are there
    unit: str = ""
    why: str = ""  # why the others, or all, could not
    interrupted: bool = False

    def words(self, alone: int) -> str:
        """How the runs ran, in words; so many ran one by one."""
        count = int(self.done.sum())
        parts = [f"{count} run side by side"] if count else []
        return ", ".join([*parts, *([f"{alone} one by one: {self.why}"] if alone else [])])


def _side_by_side(
    m: Mechanism, parameter: str, chosen: np.ndarray, of: str, times: np.ndarray, how: dict[str, Any], threads: int,
    bar: Any,
) -> _Together:  # fmt: skip
    """Points of all values that lanes can vouch for."""
    none = _Together(np.full(times.shape, np.nan), np.zeros(len(times), dtype=bool))
    if not times[:, 0].all():
        return none._replace(why="the start is a point")
    try:
        together = SideBySide(
            task_of(m, [parameter], [f"final({of})"], t_end=float(times.max()), **how), SEEN * times[0, 0]
        )
        if not isinstance(together.task.outputs[0].reductions[0].inner, Name):
            raise InputError(f"{of!r} is no name of the result")
        strobe = together.strobe(chosen[None], times)
    except (TraceError, InputError, ModelError) as error:  # what is wrong of these, runs alone say
        return none._replace(why=str(error))
    interrupted = False
    try:
        strobe.run(min(threads, len(chosen)), None if bar is None else bar.update)
    except KeyboardInterrupt:
        interrupted = True
    done = strobe.status == Status.DONE
    if interrupted and not done.any():
        raise KeyboardInterrupt
    failed = sorted({Status(int(status)).words for status in strobe.status[~done]})
    (row,) = together.asked.rows[0]
    unit = together.task.outputs[0].unit
    return _Together(strobe.values[row], done, unit, "; ".join(failed), interrupted)


def _run(of: str, how: dict[str, Any]) -> Run:
    """What runs one mechanism and gives its points at times (n,) [s]."""

    def run(neighbour: Mechanism, times: np.ndarray) -> tuple[np.ndarray, Result]:
        if stop.is_set():
            raise KeyboardInterrupt
        r = neighbour.simulate(float(times[-1]), t_eval=times, **how)
        if r.interrupted:
            stop.set()  # here, so that no other run begins
            raise KeyboardInterrupt
        sampled = np.full(len(times), np.nan)
        sampled[: len(r.t)] = r[of]
        return sampled, r

    return run


def _rows(
    run: Run, changed: Sequence[Mechanism], times: np.ndarray, threads: int | None, bar: Any
) -> tuple[list[np.ndarray], Result]:
    """Points of all mechanisms, or of those before Ctrl-C, and the result of the first."""
    rows: list[np.ndarray] = []
    pool = ThreadPoolExecutor(threads)
    try:
        for k in range(len(changed)):
            if k == 0:  # the first run alone, because it compiles
                row, first = run(changed[0], times[0])
                later = zip(changed[1:], times[1:], strict=True)
                waiting = [pool.submit(lambda *pair: run(*pair)[0], *pair) for pair in later]
            else:
                row = waiting[k - 1].result()
            rows.append(row)
            if bar is not None:
                bar.update()
    except KeyboardInterrupt:
        if not rows:
            raise
        stop.set()  # ends the runs in the other threads
    finally:
        pool.shutdown(cancel_futures=True)
        stop.clear()
    return rows, first
