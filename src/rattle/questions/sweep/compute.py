"""Sweeps: numbers of a mechanism over all combinations of given values of its parameters."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from rattle.analyses.straight_line.recorded_model import require_parameters
from rattle.errors import InputError
from rattle.questions.ensemble.folder import store_of
from rattle.questions.ensemble.plans import Grid
from rattle.questions.ensemble.runs import Samples
from rattle.questions.ensemble.work import run_missing
from rattle.results.display import in_columns, table
from rattle.studies.runs.columns import in_one_unit
from rattle.studies.runs.limits import limit_of
from rattle.studies.runs.task import task_of
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.mechanism import Mechanism

MOST = 2**30  # combinations
HEADER = ("output", "unit", "least", "at", "greatest", "at")


@answers_in_words
@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Samples):
    """Outputs over a grid; the last parameter changes fastest."""

    axes: dict[str, np.ndarray]  # parameter: (n_k,) values [SI]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of every parameter."""
        return tuple(len(axis) for axis in self.axes.values())

    def numbers(self, output: str) -> dict[str, Any]:
        """Values of parameters and output [SI] over the grid."""
        return {"axes": {name: axis.tolist() for name, axis in self.axes.items()}, "values": self.grid(output).tolist()}

    def grid(self, output: str) -> np.ndarray:
        """An output [SI] as an array with one axis per parameter, nan where it has no value."""
        return np.asarray(self[output].reshape(self.shape))

    @overload
    def plot(
        self, output: str | None = None, ax: None = None, at: Mapping[str, float | str] | None = None
    ) -> Figure: ...
    @overload
    def plot(self, output: str | None = None, *, ax: Axes, at: Mapping[str, float | str] | None = None) -> Axes: ...
    def plot(
        self, output: str | None = None, ax: Axes | None = None, at: Mapping[str, float | str] | None = None
    ) -> Figure | Axes:  # fmt: skip
        """Plot an output over one parameter, or as a map over two; returns a new figure, or `ax` if it is given.

        output: None draws the first 6 outputs below each other.  at: values of further parameters of the grid, [SI]
        or such as {"l3": "0.6 m"}.  Units are those of the tables (mm, deg).  Where an output has no value the place is
        marked.  A few values that are orders of magnitude away do not flatten all others: they lie outside of the
        range, and it is said how far.
        Raises UnknownName; ValueError if nothing has a value, or more than two parameters are left.
        """
        from rattle.questions.sweep.pictures import plot_sweep

        return plot_sweep(self, output, ax, at)

    def __repr__(self) -> str:
        return f"<rattle.Sweep: {self._title()}>"

    def _title(self) -> str:
        spans = []
        for name, axis in self.axes.items():
            low, high, unit = in_one_unit([axis.min(), axis.max()], self.unit(name))
            count = f"{len(axis)} value{'s' if len(axis) > 1 else ''}"
            spans.append(f"{name} = {low} to {high} {unit}".rstrip() + f" ({count})")
        return f"{len(self)} combination{'s' if len(self) > 1 else ''} of {', '.join(spans)}"

    def rows(self) -> list[tuple[str, ...]]:
        """Outputs with least and greatest value and where they are, see HEADER."""
        rows = []
        for output in self.outputs:
            values = self[output]
            if not np.isfinite(values).any():
                rows.append((output, self.unit(output), *["-"] * 4))
                continue
            ends = int(np.nanargmin(values)), int(np.nanargmax(values))
            low, high, unit = in_one_unit([values[n] for n in ends], self.unit(output))
            rows.append((output, unit, low, self.told(ends[0]), high, self.told(ends[1])))
        return rows

    def __str__(self) -> str:
        return "\n".join([self._title(), *in_columns([HEADER, *self.rows()]), *self.remarks()])

    def _repr_html_(self) -> str:
        return table(HEADER, self.rows(), self._title(), self.remarks())


def sweep(
    m: Mechanism, values: Mapping[str, Any], outputs: Sequence[str], *, analysis: str = "simulate",
    t_end: float | None = None, rtol: float | None = None, method: str | None = None, threads: int | None = None,
    executor: Executor | None = None, scheduler: str | None = None, workers: int | None = None,
    folder: str | os.PathLike[str] | None = None, resume: bool = True, progress: bool = False,
) -> Sweep:  # fmt: skip
    """Outputs over a grid; see `Mechanism.sweep`."""
    axes = _axes(m, values)
    task = task_of(m, axes, outputs, analysis=analysis, t_end=t_end, rtol=rtol, method=method)
    plan = Grid(axes)
    store = store_of(task, plan, folder, resume)
    how, interrupted = run_missing(
        task, plan, store, executor=executor, scheduler=scheduler, workers=workers, threads=threads, progress=progress,
        what="sweep",
    )  # fmt: skip
    return Sweep(task, plan, store, how, interrupted, axes)


def _axes(m: Mechanism, values: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Checked values [SI] by parameter.  Raises InputError, TypeError, UnknownName."""
    if not isinstance(values, Mapping) or not values:
        raise InputError('values: expected parameters with their values, such as {"r3": [0.001, 0.002]}')
    require_parameters(m.system, list(values))
    axes = {}
    for name, listed in values.items():
        if isinstance(listed, str) or not isinstance(listed, Sequence | np.ndarray) or np.ndim(listed) != 1:
            raise InputError(f"values: '{name}' needs a list of values such as [0.001, 0.002], got {listed!r:.60}")
        if not len(listed):
            raise InputError(f"values: '{name}' has no value")
        unit = m.model.parameters[name].unit
        axes[name] = np.array([limit_of(number, unit, f"values: '{name}'") for number in listed])
    count = math.prod(len(axis) for axis in axes.values())
    if count > MOST:
        raise InputError(f"values: {count} combinations are more than {MOST}; take fewer values of each parameter")
    return axes
