"""Pictures of chaotic motion: Poincare section, bifurcation diagram."""

from __future__ import annotations

from typing import TYPE_CHECKING, overload

import numpy as np

from rattle.plots.curves import GREY, axis_label, drawn, figure_of, new_axes, note
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.poincare.compute import Section


@overload
def plot_section(section: Section, x: str, y: str, ax: None = None) -> Figure: ...
@overload
def plot_section(section: Section, x: str, y: str, ax: Axes) -> Axes: ...
def plot_section(section: Section, x: str, y: str, ax: Axes | None = None) -> Figure | Axes:
    """The points of a section, coloured by time, on a new figure, or on `ax`, which is then returned.

    x, y: names of the two curves; axes in handy units (mm, deg), time in s.
    """
    from matplotlib.patches import Circle

    asked, ax = ax, ax if ax is not None else new_axes(6.4, 5.4)[0]
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
    return drawn(ax, asked)
