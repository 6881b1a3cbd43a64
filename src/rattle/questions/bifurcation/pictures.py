"""Picture of a bifurcation diagram."""

from __future__ import annotations

from typing import TYPE_CHECKING, overload

import numpy as np

from rattle.plots.curves import BLUE, axis_label, drawn, new_axes, note
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.bifurcation.compute import Bifurcation


@overload
def plot_bifurcation(diagram: Bifurcation, ax: None = None) -> Figure: ...
@overload
def plot_bifurcation(diagram: Bifurcation, ax: Axes) -> Axes: ...
def plot_bifurcation(diagram: Bifurcation, ax: Axes | None = None) -> Figure | Axes:
    """All points of the output over the parameter, in handy units (mm, deg); on a new figure, or on `ax`, which is
    then returned."""
    asked, ax = ax, ax if ax is not None else new_axes(8.0, 5.0)[0]
    count = diagram.points.shape[1]
    x = np.repeat(diagram.values, count)
    wide = handy_unit(diagram.parameter_unit, float(np.abs(diagram.values).max(initial=0.0)))
    high = handy_unit(diagram.of_unit, float(np.nanmax(np.abs(diagram.points), initial=0.0)))
    dot = float(
        np.clip(60.0 / np.sqrt(max(x.size, 1)), 2.5, 6.0)
    )  # [points] few dots are large enough to be seen, many do not merge
    ax.plot(
        wide[0] * x, high[0] * diagram.points.ravel(), ".", color=BLUE, markersize=dot, alpha=0.7, markeredgewidth=0
    )
    ax.set_xlabel(axis_label(diagram.parameter, wide[1]))
    ax.set_ylabel(axis_label(diagram.of, high[1]))
    ax.set_title(f"{diagram.of}, {diagram.rule}", loc="left", fontsize=11, pad=16)
    missing = int(np.isnan(diagram.points).any(axis=1).sum())
    note(ax, f"{len(diagram.values)} runs, {count} points each" + (f"; {missing} ended early" if missing else ""))
    ax.margins(x=0.01)
    return drawn(ax, asked)
