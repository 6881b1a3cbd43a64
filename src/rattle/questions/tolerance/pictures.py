"""A tolerance study as a picture: what each tolerance causes, and the bands of the output beside its samples."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from rattle.jit.choices import TINY
from rattle.plots.bulk import bulk_of
from rattle.plots.curves import BLACK, BLUE, ORANGE, RED, SKY, axis_label, figure_of, new_figure, note, tidy
from rattle.questions.ensemble.shares import MOST, draw_shares
from rattle.results.handy_units import QUANTITY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.tolerance.report import Tolerance

BINS = 40


def plot_tolerance(t: Tolerance) -> Figure:
    """See `Tolerance.plot`."""
    count = min(len(t.contributors), MOST)
    figure = new_figure(8.6, 4.2 + 0.34 * count)
    above, below = figure.subplots(2, 1, height_ratios=[2.2, 0.9 + 0.34 * count])
    _draw_bands(tidy(above), t)
    _draw_contributions(tidy(below), t)
    return figure_of(above)


def _draw_bands(ax: Axes, t: Tolerance) -> None:
    """Samples as a histogram, and below it the three bands."""
    ends = [end for band in (t.worst_case, t.root_sum_square, t.monte_carlo) for end in band if math.isfinite(end)]
    bulk = bulk_of(t.known if len(t.known) else np.array([t.nominal]), t.unit, [t.nominal, *ends])
    counts, _, _ = ax.hist(
        bulk.factor * t.known,
        BINS,
        range=(bulk.low, bulk.high),
        color=SKY,
        alpha=0.75,
        edgecolor="white",
        linewidth=0.4,
    )
    top = max(float(np.max(counts, initial=0.0)), 1.0)
    sampled = "99.73 % of the samples" if t.enough else "all samples"
    bands = (("worst case", t.worst_case, RED), ("root sum square", t.root_sum_square, ORANGE))
    for n, (name, band, color) in enumerate((*bands, (sampled, t.monte_carlo, BLUE)), 1):
        height = -0.13 * n * top
        if all(map(math.isfinite, band)):
            low, high = (bulk.factor * end for end in band)
            ax.plot([low, high], [height, height], color=color, linewidth=3, solid_capstyle="butt")
        text = name if all(map(math.isfinite, band)) else f"{name}: unknown"
        ax.annotate(text, (1.0, height), (6, 0), ("axes fraction", "data"), "offset points", va="center", fontsize=9)
    ax.axvline(bulk.factor * t.nominal, color=BLACK, linewidth=1.0)
    ax.set_ylim(-0.52 * top, 1.08 * top)
    ax.set_yticks([tick for tick in ax.get_yticks() if 0.0 <= tick <= 1.08 * top])
    ax.set_ylabel("number of samples")
    ax.set_xlabel(axis_label(QUANTITY.get(t.unit, "value"), bulk.unit))
    ax.set_title(t.of, loc="left", fontsize=11, pad=16, parse_math=False)
    outside = f"; not shown: {bulk.outside}" if bulk.outside else ""
    note(ax, f"{len(t.known)} samples ({t.trials.task.analysis}); line: nominal{outside}", "left")


def _draw_contributions(ax: Axes, t: Tolerance) -> None:
    """Sobol indices, or where there are none the shares of the root sum square."""
    indices = t.indices
    if indices.rows:
        first = list(zip(indices.first, indices.first_low, indices.first_high, strict=True))
        draw_shares(
            ax, t.contributors, first, list(zip(indices.total, indices.total_low, indices.total_high, strict=True))
        )
        ax.set_xlabel("share of the variance: Sobol indices with 95 % bounds [%]")
        return
    squares = t.effects**2 / max(float(t.effects @ t.effects), TINY)
    draw_shares(ax, t.contributors, [(float(square), math.nan, math.nan) for square in squares])
    ax.set_xlabel("share of the root sum square [%]")
