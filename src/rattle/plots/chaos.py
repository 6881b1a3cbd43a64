"""Pictures of chaotic motion: Poincare section, bifurcation diagram."""

from __future__ import annotations

from typing import TYPE_CHECKING, overload

import numpy as np

from rattle.plots.curves import BLUE, GREY, axis_label, drawn, figure_of, new_axes, note
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.studies.bifurcation import Bifurcation
    from rattle.studies.poincare import Section


@overload
def plot_section(section: Section, x: str, y: str, ax: None = None) -> Figure: ...
@overload
def plot_section(section: Section, x: str, y: str, ax: Axes) -> Axes: ...
def plot_section(section: Section, x: str, y: str, ax: Axes | None = None) -> Figure | Axes:
    """The points of a section, coloured by time, on a new figure, or on `ax`, which is then returned.

    x, y: names of the two curves; axes in handy units (mm, deg), time in s.
    """
    from matplotlib.patches import Circle

    given, ax = ax, ax if ax is not None else new_axes(6.4, 5.4)[0]
    same = section.units[x] == section.units[y]
    size = {name: float(np.nanmax(np.abs(section[name]), initial=0.0)) for name in (x, y)}
    wide, high = (handy_unit(section.units[n], max(size.values()) if same else size[n]) for n in (x, y))
    dots = ax.scatter(wide[0] * section[x], high[0] * section[y], c=section.t, s=9, cmap="cividis", linewidths=0)
    if x.endswith(".ex") and y == x[:-1] + "y" and (play := section.clearances.get(x[:-3])):
        circle = Circle((0, 0), wide[0] * play, fill=False, edgecolor=GREY, linewidth=0.9, label="bush")
        ax.add_patch(circle)
        limit = 1.15 * wide[0] * max(play, *size.values())
        ax.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
    elif same and section.units[x] == "m":
        ax.set_aspect("equal", adjustable="datalim")
    ax.locator_params(nbins=6)
    figure_of(ax).colorbar(dots, ax=ax, pad=0.02, shrink=0.85).set_label("time [s]")
    ax.set_xlabel(axis_label(x, wide[1]))
    ax.set_ylabel(axis_label(y, high[1]))
    ax.set_title(f"Poincare section, {section.rule}", loc="left", fontsize=11, pad=16)
    note(ax, f"{len(section.t)} points")
    return drawn(ax, given)


@overload
def plot_bifurcation(found: Bifurcation, ax: None = None) -> Figure: ...
@overload
def plot_bifurcation(found: Bifurcation, ax: Axes) -> Axes: ...
def plot_bifurcation(found: Bifurcation, ax: Axes | None = None) -> Figure | Axes:
    """All points of the output over the parameter, in handy units (mm, deg); on a new figure, or on `ax`, which is
    then returned."""
    given, ax = ax, ax if ax is not None else new_axes(8.0, 5.0)[0]
    count = found.points.shape[1]
    x = np.repeat(found.values, count)
    wide = handy_unit(found.parameter_unit, float(np.abs(found.values).max(initial=0.0)))
    high = handy_unit(found.of_unit, float(np.nanmax(np.abs(found.points), initial=0.0)))
    dot = float(
        np.clip(60.0 / np.sqrt(max(x.size, 1)), 2.5, 6.0)
    )  # [points] few dots are large enough to be seen, many do not merge
    ax.plot(wide[0] * x, high[0] * found.points.ravel(), ".", color=BLUE, markersize=dot, alpha=0.7, markeredgewidth=0)
    ax.set_xlabel(axis_label(found.parameter, wide[1]))
    ax.set_ylabel(axis_label(found.of, high[1]))
    ax.set_title(f"{found.of}, {found.rule}", loc="left", fontsize=11, pad=16)
    missing = int(np.isnan(found.points).any(axis=1).sum())
    note(ax, f"{len(found.values)} runs, {count} points each" + (f"; {missing} ended early" if missing else ""))
    ax.margins(x=0.01)
    return drawn(ax, given)
