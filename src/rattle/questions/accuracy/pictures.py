"""Pictures of analyses without time integration: the error band of an output under play, a mode of vibration."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from rattle.jit.choices import TINY
from rattle.plots.curves import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    RED,
    axis_label,
    new_figure,
    tidy,
)
from rattle.results.chosen_units import Shown
from rattle.results.display import quantity
from rattle.results.handy_units import QUANTITY, handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.accuracy.compute import Accuracy

BAND = "#BBD7EA"
ROUNDING = 1e-9  # decades by which a magnification may lie beyond a power of ten and yet be that one


def plot_accuracy(accuracy: Accuracy) -> Figure:
    """The output with its worst-case band, the deviation alone, and the contribution of each joint; time [s]."""
    figure = new_figure(8.6, 6.6)
    top, middle, bar = figure.subplots(3, 1, height_ratios=(1.0, 1.3, 0.35 + 0.16 * len(accuracy.joints)))
    draw_band(tidy(top), accuracy)
    draw_deviation(tidy(middle), accuracy)
    middle.set_xlabel("time [s]")
    top.sharex(middle)
    top.tick_params(labelbottom=False)
    top.set_title(f"{accuracy.of}: deviation that the play of the joints allows", loc="left", fontsize=11)
    for ax in (top, middle):
        ax.margins(x=0.0)
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, frameon=False, fontsize=9)
    _contributions(tidy(bar), accuracy)
    return figure


def draw_band(ax: Axes, accuracy: Accuracy) -> None:
    """The output and its band, magnified by a power of ten if it would be too narrow to be seen."""
    factor, unit = handy_unit(accuracy.unit, 1.0)
    many = magnified(float(np.ptp(accuracy.nominal)), float(accuracy.worst.max(initial=0.0)))
    low, high = (factor * (accuracy.nominal + sign * many * accuracy.worst) for sign in (-1.0, 1.0))
    label = "worst case" if many == 1 else f"worst case,\nmagnified {many} times"
    ax.fill_between(accuracy.t, low, high, color=BAND, linewidth=0, label=label)
    ax.plot(accuracy.t, factor * accuracy.nominal, color=BLUE, linewidth=1.2, label="without play")
    ax.set_ylabel(axis_label(QUANTITY.get(accuracy.unit, accuracy.of), unit))


def magnified(span: float, band: float) -> int:
    """1, or the power of ten that makes half the band at least 3 % of the span of its curve (same unit)."""
    if not (span > 0.0 < band) or band >= 0.03 * span:
        return 1
    return int(10 ** math.ceil(math.log10(0.03 * span / band) - ROUNDING))


def draw_deviation(ax: Axes, accuracy: Accuracy) -> None:
    """How far the output deviates: in the worst case, as a root sum square, exactly, and under the loads."""
    factor, unit = _small_unit(accuracy)
    worst, rss = factor * accuracy.worst, factor * accuracy.rss
    ax.fill_between(accuracy.t, -worst, worst, color=BAND, linewidth=0, label="worst case,\nfirst order")
    ax.plot(accuracy.t, rss, color=BLUE, linewidth=1.0, label="root sum square")
    ax.plot(accuracy.t, -rss, color=BLUE, linewidth=1.0)
    for n, curve in enumerate((accuracy.low, accuracy.high)):
        if np.isfinite(curve).any():
            label = None if n else "exact extremes"
            ax.plot(
                accuracy.t,
                factor * (curve - accuracy.nominal),
                color=BLACK,
                linewidth=0.9,
                linestyle=(0, (4, 2)),
                label=label,
            )
    if np.isfinite(accuracy.loaded).any():
        ax.plot(accuracy.t, factor * accuracy.loaded, color=RED, linewidth=1.4, label="under the loads,\nat rest")
    ax.axhline(0.0, color=GREY, linewidth=0.6)
    ax.set_ylabel(axis_label("deviation", unit))


def _small_unit(accuracy: Accuracy) -> Shown:
    """Factor and unit for deviations."""
    return handy_unit(accuracy.unit, float(accuracy.worst.max()))


def _contributions(ax: Axes, accuracy: Accuracy) -> None:
    factor, unit = _small_unit(accuracy)
    k = int(np.argmax(accuracy.worst))
    order = sorted(range(len(accuracy.joints)), key=lambda n: accuracy.contributions[k, n])
    sizes = [factor * accuracy.contributions[k, n] for n in order]
    names = [f"{name} ({quantity(accuracy.clearances[name], 'm', 3)})" for name in (accuracy.joints[n] for n in order)]
    colours = [ORANGE if accuracy.joints[n] == accuracy.tighten else BLUE for n in order]
    ax.barh(names, sizes, color=colours, height=0.6)
    for n, size in enumerate(sizes):
        share = 100 * size / max(sum(sizes), TINY)
        ax.annotate(f"{share:.0f} %", (size, n), (4, 0), textcoords="offset points", va="center", fontsize=9)
    ax.grid(axis="y", visible=False)
    ax.set_xlim(0, 1.15 * max([*sizes, TINY]))
    ax.set_xlabel(axis_label(f"contribution where the band is widest, t = {accuracy.t[k]:.3g} s", unit))
    first = accuracy.contributions[k, accuracy.joints.index(accuracy.tighten)]
    equal = [name for name, size in zip(accuracy.joints, accuracy.contributions[k], strict=True) if size > 0.99 * first]
    ax.set_title(f"tighten {' or '.join(equal)} first", loc="left", fontsize=10, parse_math=False)
