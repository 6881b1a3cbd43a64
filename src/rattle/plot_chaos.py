"""Pictures of chaotic motion: Poincare section, bifurcation diagram."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plot import BLUE, axis_label, figure_of, new_axes, note

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.chaos import Bifurcation, Section


def plot_section(section: Section, x: str, y: str, ax: Axes | None = None) -> Figure:
    """The points of a section, coloured by time."""
    ax = ax if ax is not None else new_axes(6.4, 5.4)[0]
    dots = ax.scatter(section[x], section[y], c=section.t, s=6, cmap="cividis", linewidths=0)
    figure_of(ax).colorbar(dots, ax=ax, pad=0.02, shrink=0.85).set_label("time [s]")
    ax.set_xlabel(axis_label(x, section.units[x]))
    ax.set_ylabel(axis_label(y, section.units[y]))
    ax.set_title(f"Poincare section, {section.rule}", loc="left", fontsize=11, pad=16)
    note(ax, f"{len(section.t)} points")
    return figure_of(ax)


def plot_bifurcation(found: Bifurcation, ax: Axes | None = None) -> Figure:
    """All points of the output over the parameter."""
    ax = ax if ax is not None else new_axes(8.0, 5.0)[0]
    count = found.points.shape[1]
    x = np.repeat(found.values, count)
    ax.plot(x, found.points.ravel(), ".", color=BLUE, markersize=1.6, alpha=0.6, markeredgewidth=0)
    ax.set_xlabel(axis_label(found.parameter, found.parameter_unit))
    ax.set_ylabel(axis_label(found.of, found.of_unit))
    ax.set_title(f"{found.of}, {found.rule}", loc="left", fontsize=11, pad=16)
    missing = int(np.isnan(found.points).any(axis=1).sum())
    note(ax, f"{len(found.values)} runs, {count} points each" + (f"; {missing} ended early" if missing else ""))
    ax.margins(x=0.01)
    return figure_of(ax)
