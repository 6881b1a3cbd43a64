"""Bifurcation diagram: an output sampled once per period, over the values of a parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.dynamics.run import stop
from rattle.errors import InputError, SolverError
from rattle.language.times import Seconds
from rattle.progress_bar import progress_bar
from rattle.questions.poincare.compute import period_of
from rattle.results.display import quantity, table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


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
    chosen = np.asarray(values, dtype=float)
    if not chosen.size or chosen.ndim != 1:
        raise InputError("values of the parameter: expected a one-dimensional array with at least one value")
    changed = [m.neighbour({parameter: float(value)}) for value in chosen]

    def run(neighbour: Mechanism) -> tuple[np.ndarray, Result]:
        if stop.is_set():
            raise KeyboardInterrupt
        times = period_of(neighbour, period) * (skip + np.arange(points))
        r = neighbour.simulate(float(times[-1]), t_eval=times, method=method, rtol=rtol, atol=atol, step=step)
        if r.interrupted:
            stop.set()  # here, so that no other run begins
            raise KeyboardInterrupt
        sampled = np.full(points, np.nan)
        sampled[: len(r.t)] = r[of]
        return sampled, r

    bar = progress_bar(len(changed), "bifurcation", unit="run") if progress else None
    rows, first = _rows(run, changed, threads, bar)
    interrupted = len(rows) < len(changed)
    if not (interrupted or first.success or np.isfinite(rows).any()):
        where = f"the first one at t = {first.trust.t_end:.6g} s, {first.message}"
        raise SolverError(f"no point: every run stopped before {skip} periods were over, {where}", first)
    what = m.model.parameters.get(parameter)
    rule = _rule(changed, period)
    if interrupted:
        rule += f", stopped by the user after {len(rows)} of {len(chosen)} values"
        rows += [np.full(points, np.nan)] * (len(chosen) - len(rows))
    return Bifurcation(
        parameter, chosen, what.unit if what else "", of, first.unit(of), np.array(rows), rule, interrupted
    )


def _rows(
    run: Callable[[Mechanism], tuple[np.ndarray, Result]], changed: Sequence[Mechanism], threads: int | None, bar: Any
) -> tuple[list[np.ndarray], Result]:
    """Points of all mechanisms, or of those before Ctrl-C, and the result of the first."""
    rows: list[np.ndarray] = []
    pool = ThreadPoolExecutor(threads)
    try:
        for k in range(len(changed)):
            if k == 0:  # the first run alone, because it compiles
                row, first = run(changed[0])
                waiting = [pool.submit(lambda neighbour: run(neighbour)[0], neighbour) for neighbour in changed[1:]]
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
        if bar is not None:
            bar.close()
    return rows, first
