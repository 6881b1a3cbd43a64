"""Pictures of what bars bear: along a bar, and in the mechanism."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rattle.plots.curves import (
    BLACK,
    BLUE,
    GREY,
    RED,
    SHADE,
    axis_label,
    figure_of,
    new_axes,
    new_figure,
    tidy,
    title_of,
)
from rattle.plots.sketch import draw_at
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.strength.compute import Strength

Array = NDArray[np.float64]
PANELS = (
    ("normal", "normal force", "N"),
    ("shear", "shear force", "N"),
    ("moment", "moment", "N*m"),
    ("deflection", "deflection", "m"),
    ("stress", "stress", "Pa"),
)
HIGHEST = 0.16  # of a moment diagram in the mechanism, as a share of its size
STRESSES = "cividis_r"  # colours that grow darker with the stress


def plot_along(s: Strength) -> Figure:
    """Forces and stress along the bar when the stress is largest, and what they reach at any instant as a band."""
    when, where = s.peak_at
    row = int(np.argmin(np.abs(s.t - when)))
    axes = new_axes(7.0, 1.0 + 1.5 * len(PANELS), rows=len(PANELS))
    length, unit = handy_unit("m", s.beam.length)
    x = length * s.x
    for ax, (name, words, si) in zip(axes, PANELS, strict=True):
        values = getattr(s, name)
        factor, shown = handy_unit(si, float(np.nanmax(np.abs(values), initial=0.0)))
        band = [factor * part for part in (np.nanmin(values, axis=0), np.nanmax(values, axis=0))]
        ax.fill_between(x, *band, color=SHADE, label=f"all {len(s.t)} instants", linewidth=0)
        ax.plot(x, factor * values[row], color=BLUE, label=f"t = {when:.6g} s")
        ax.axhline(0.0, color=BLACK, linewidth=0.6, zorder=1)
        ax.set_ylabel(axis_label(words, shown))
        ax.margins(x=0.0)
    _mark_peak(axes[-1], s, length * where)
    axes[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, fontsize=8, frameon=False)
    first, last = s.beam.ends
    axes[-1].set_xlabel(axis_label(f"from {first} to {last}, along {s.body}", unit))
    title_of(axes[0], s.result)
    figure = figure_of(axes[0])
    figure.align_ylabels(axes)
    return figure


def _mark_peak(ax: Axes, s: Strength, place: float) -> None:
    """A triangle at the largest stress, and how large it is."""
    from rattle.questions.strength.compute import in_mega

    row = int(np.argmin(np.abs(s.t - s.peak_at[0])))
    stress = s.stress[row]
    value = np.copysign(s.peak, stress[np.nanargmax(np.abs(stress))])
    factor = handy_unit("Pa", s.peak).factor
    ax.plot([place], [factor * value], "v" if value > 0.0 else "^", color=RED, markersize=6, clip_on=False, zorder=5)
    ax.annotate(
        in_mega(s.peak), (place, factor * value), (0, -7 if value > 0.0 else 7), textcoords="offset points",
        fontsize=8.5, color=RED, ha="center", va="top" if value > 0.0 else "bottom",
    )  # fmt: skip


def draw_bars(bars: Sequence[Strength], t: float) -> Figure:
    """The mechanism at the instant next to t [s], bars coloured by their stress, moments drawn on their pulled side."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize

    first = bars[0]
    row = int(np.argmin(np.abs(first.t - t)))
    figure = new_figure(7.5, 5.4)
    ax = tidy(figure.add_subplot())
    draw_at(ax, first.result, row)
    ax.set_axis_off()
    size = float(np.diff(ax.get_xlim())[0])
    stress = max(float(np.nanmax(np.abs(s.stress[row]), initial=0.0)) for s in bars)
    moment = max(float(np.nanmax(np.abs(s.moment[row]), initial=0.0)) for s in bars)
    factor, unit = handy_unit("Pa", stress)
    norm = Normalize(0.0, factor * stress or 1.0)
    reached = [np.array([ax.get_xlim(), ax.get_ylim()]).T]
    for s in bars:
        line, pulled = _placed(s, row, HIGHEST * size / moment if moment > 0.0 else 0.0)
        ax.fill(*np.concatenate([line, pulled[::-1]]).T, facecolor=BLUE, alpha=0.18, linewidth=0, zorder=6)
        reached.append(pulled[np.isfinite(pulled).all(axis=1)])
        ax.plot(*pulled.T, color=BLUE, linewidth=1.0, zorder=7)
        pieces = np.stack([line[:-1], np.append(line[2:], line[-1:], axis=0)], axis=1)  # without gaps between them
        middle = factor * np.abs(0.5 * (s.stress[row, :-1] + s.stress[row, 1:]))
        shown = LineCollection(list(pieces), cmap=STRESSES, norm=norm, linewidths=6.0, zorder=8, capstyle="butt")
        shown.set_array(middle)
        ax.add_collection(shown)
    low, high = np.concatenate(reached).min(axis=0), np.concatenate(reached).max(axis=0)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    figure.colorbar(shown, ax=ax, shrink=0.8, pad=0.02).set_label(axis_label("magnitude of the stress", unit))
    largest, moment_unit = handy_unit("N*m", moment)
    words = f"moment on the side that is pulled, largest {largest * moment:.3g} {moment_unit.replace('*', '·')}"
    ax.text(
        0.0,
        -0.02,
        f"t = {first.t[row]:.6g} s; blue: {words}",
        transform=ax.transAxes,
        fontsize=8.5,
        color=GREY,
        va="top",
    )
    title_of(ax, first.result)
    return figure_of(ax)


def _placed(s: Strength, row: int, scale: float) -> tuple[Array, Array]:
    """Points (nx, 2) [m] along a bar, and those of its moment diagram beside it; scale [m/(N m)]."""
    x, y, angle = (float(s.result[f"{s.body}.{what}"][row]) for what in ("x", "y", "angle"))
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-np.sin(angle), np.cos(angle)])
    line = np.array([x, y]) + (s.x - s.beam.centre)[:, None] * along
    return line, line - scale * s.moment[row][:, None] * across
