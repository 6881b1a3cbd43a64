"""Pictures of what bars and necks bear: along a bar, over time, and in the mechanism."""

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
from rattle.plots.scene import Scene
from rattle.plots.sketch import draw_at
from rattle.plots.stress_colours import draw_stress, largest_of
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.strength.answer import Strength
    from rattle.questions.strength.bar import Bar
    from rattle.questions.strength.neck import Neck

Array = NDArray[np.float64]
PANELS = (
    ("normal", "normal force", "N"),
    ("shear", "shear force", "N"),
    ("moment", "moment", "N*m"),
    ("deflection", "deflection", "m"),
    ("stress", "stress", "Pa"),
)


def plot_along(s: Bar) -> Figure:
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


def _mark_peak(ax: Axes, s: Bar, place: float) -> None:
    """A triangle at the largest stress, and how large it is."""
    from rattle.questions.strength.answer import in_mega

    row = int(np.argmin(np.abs(s.t - s.peak_at[0])))
    stress = s.stress[row]
    value = np.copysign(s.peak, stress[np.nanargmax(np.abs(stress))])
    factor = handy_unit("Pa", s.peak).factor
    ax.plot([place], [factor * value], "v" if value > 0.0 else "^", color=RED, markersize=6, clip_on=False, zorder=5)
    ax.annotate(
        in_mega(s.peak), (place, factor * value), (0, -7 if value > 0.0 else 7), textcoords="offset points",
        fontsize=8.5, color=RED, ha="center", va="top" if value > 0.0 else "bottom",
    )  # fmt: skip


def plot_over_time(s: Neck) -> Figure:
    """Forces in a neck, and stresses at both ends of its cut, over time."""
    panels = [*PANELS[:3], ("stress", "stress", "Pa")]
    axes = new_axes(7.0, 1.0 + 1.5 * len(panels), rows=len(panels))
    for ax, (name, words, si) in zip(axes, panels, strict=True):
        curves = {"second end": s.fibres[0], "first end": s.fibres[1]} if name == "stress" else {"": getattr(s, name)}
        factor, shown = handy_unit(si, max(float(np.nanmax(np.abs(curve), initial=0.0)) for curve in curves.values()))
        for (label, curve), colour in zip(curves.items(), (BLUE, RED), strict=False):
            ax.plot(s.t, factor * curve[:, 0], color=colour, label=label)
        ax.axhline(0.0, color=BLACK, linewidth=0.6, zorder=1)
        ax.set_ylabel(axis_label(words, shown))
        ax.margins(x=0.0)
    axes[-1].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, fontsize=8, frameon=False)
    axes[-1].set_xlabel(axis_label("time", "s"))
    title_of(axes[0], s.result)
    figure = figure_of(axes[0])
    figure.align_ylabels(axes)
    return figure


def draw_stressed(stressed: Sequence[Strength], t: float) -> Figure:
    """The mechanism at the instant next to t [s], bars and necks coloured by their stress, moments of bars drawn on

    their pulled side.
    """
    from matplotlib.transforms import Bbox

    first, drawn = stressed[0], [s.drawn for s in stressed]
    row = int(np.argmin(np.abs(first.t - t)))
    ax = tidy(new_figure(7.5, 5.4).add_subplot())
    draw_at(ax, first.result, row)
    ax.set_axis_off()
    scene = Scene(first.result, np.array([row]), float(np.diff(ax.get_xlim())[0]))
    draw_stress(ax, scene, drawn)
    limits = Bbox.union([ax.dataLim, ax.viewLim])  # with the moments
    ax.set(xlim=limits.intervalx, ylim=limits.intervaly)
    caption = f"t = {first.t[row]:.6g} s"
    if moment := largest_of(scene, drawn)[1]:
        factor, unit = handy_unit("N*m", moment)
        words = f"moment on the side that is pulled, largest {factor * moment:.3g} {unit.replace('*', '·')}"
        caption += f"; blue: {words}"
    ax.text(0.0, -0.02, caption, transform=ax.transAxes, fontsize=8.5, color=GREY, va="top")
    title_of(ax, first.result)
    return figure_of(ax)
