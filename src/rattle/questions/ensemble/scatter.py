"""Scatter matrix of an ensemble: outputs (rows) over parameters (columns)."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Literal

import numpy as np

from rattle.errors import InputError
from rattle.plots.bulk import Bulk, bulk_of, set_range
from rattle.plots.curves import BLACK, BLUE, GREY, RED, axis_label, new_figure, tidy
from rattle.questions.ensemble.pictures import finite, told_samples
from rattle.studies.runs.columns import scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.ensemble.compute import Ensemble

MOST = 6  # outputs, and parameters
POINTS = 5000  # from which on cells are coloured by their number of points
MARGIN = 0.06  # share of the axis beyond the outermost point
CELLS = 40  # across a panel
CLEAR = 0.3  # rank correlation that is written in bold, from this size on


def plot_scatter(e: Ensemble, outputs: Sequence[str] | None = None, parameters: Sequence[str] | None = None) -> Figure:
    """See `Ensemble.plot_scatter`."""
    rows = _chosen(e, "outputs", outputs, e.outputs)
    correlations = {(o, p): rank_correlation(e[p], e[o]) for o in rows for p in e.parameters}
    strongest = sorted(e.parameters, key=lambda p: -max(np.nan_to_num(abs(correlations[o, p])) for o in rows))
    kept = [p for p in e.parameters if p in strongest[:MOST]]
    columns = _chosen(e, "parameters", parameters, kept)
    figure = new_figure(1.3 + 2.2 * len(columns), 1.0 + 1.75 * len(rows))
    grid = figure.subplots(len(rows), len(columns), sharex="col", sharey="row", squeeze=False)
    far: list[str] = []
    for n, output in enumerate(rows):
        bulk = bulk_of(finite(e, output), e.unit(output))
        for k, parameter in enumerate(columns):
            ax = tidy(grid[n, k])
            x = e[parameter]
            scale, unit = scale_of([float(np.nanmax(np.abs(x))), float(np.nanstd(x))], e.unit(parameter))
            _panel(ax, scale * x, bulk.factor * e[output], bulk)
            _correlation(ax, correlations[output, parameter])
            ax.locator_params(axis="x", nbins=3)
            ax.ticklabel_format(axis="x", useOffset=False)
            ax.tick_params(labelsize=8)
            if not bulk.log:
                ax.locator_params(axis="y", nbins=5)
            if n == len(rows) - 1:
                ax.set_xlabel(axis_label(parameter, unit), parse_math=False)
        grid[n, 0].set_ylabel(axis_label(_broken(output), bulk.unit), fontsize=9, parse_math=False)
        far += [f"triangles: {output}, {bulk.outside}"] if bulk.outside else []
    _heading(figure, e, len(columns), parameters is None, far)
    figure.align_ylabels()
    return figure


def _heading(figure: Figure, e: Ensemble, shown: int, chosen: bool, far: list[str]) -> None:
    left = len(e.parameters) - shown
    words = told_samples(e)
    if chosen and left:
        words += f"; the {shown} parameters with the closest relations"
    failed = e.counts()["failed"] + e.counts()["not finite"]
    words += "; red: parameters of those without a value" if failed else ""
    across = int(16.5 * figure.get_figwidth())  # characters
    text = "\n".join(line for paragraph in (f"{words}; ρ: rank correlation", *far) for line in wrap(paragraph, across))
    figure.suptitle(text, x=0.012, ha="left", fontsize=8.5, color=GREY, parse_math=False)


def _chosen(e: Ensemble, what: str, asked: Sequence[str] | None, every: Sequence[str]) -> list[str]:
    """The rows or columns.  Raises UnknownName, ValueError."""
    if asked is None:
        return list(every)[:MOST]
    names = [asked] if isinstance(asked, str) else list(dict.fromkeys(asked))
    allowed = e.outputs if what == "outputs" else e.parameters
    for name in names:
        if name not in allowed:
            raise InputError(f"{what}: '{name}' is none of {', '.join(allowed)}")
    if not 0 < len(names) <= MOST:
        raise InputError(f"{what}: {len(names)} are asked for; a scatter matrix shows 1 to {MOST}, choose those")
    return names


def _broken(output: str) -> str:
    """A long output on two lines."""
    if len(output) <= 22:
        return output
    middle = len(output) // 2
    places = [n + 1 for n, sign in enumerate(output) if sign in "(,+-* "]
    at = min(places, key=lambda n: abs(n - middle), default=middle)
    return f"{output[:at].rstrip()}\n{output[at:].lstrip()}"


def rank_correlation(x: np.ndarray, y: np.ndarray) -> float:
    """Spearman's rank correlation [-] of the pairs (n,) that are finite; nan if one of them does not vary."""
    from scipy.stats import rankdata

    finite = np.isfinite(x) & np.isfinite(y)
    if finite.sum() < 3 or np.ptp(x[finite]) == 0.0 or np.ptp(y[finite]) == 0.0:
        return float("nan")
    return float(np.corrcoef(rankdata(x[finite]), rankdata(y[finite]))[0, 1])


def _panel(ax: Axes, x: np.ndarray, y: np.ndarray, bulk: Bulk) -> None:
    """Points, in the units shown; those beyond the bulk are marked at its end, those without a value below."""
    lacks = ~np.isfinite(y)
    inside = (y >= bulk.low) & (y <= bulk.high)
    set_range(ax, bulk, "y", MARGIN)
    least, most = float(np.nanmin(x)), float(np.nanmax(x))
    room = 0.04 * (most - least) or 0.05 * abs(most) or 0.5
    ax.set_xlim(least - room, most + room)
    if inside.sum() > POINTS:
        _cells(ax, x[inside], y[inside], bulk)
    else:
        size = float(np.clip(80.0 / np.sqrt(max(inside.sum(), 1)), 2.6, 6.0))
        alpha = float(np.clip(150.0 / max(inside.sum(), 1) ** 0.8, 0.2, 0.8))
        ax.plot(x[inside], y[inside], ".", color=BLUE, markersize=size, alpha=alpha, markeredgewidth=0, rasterized=True)
    across = ax.get_xaxis_transform()
    for far, place, marker in ((y > bulk.high, 0.985, "^"), (y < bulk.low, 0.015, "v")):
        if far.any():
            at = np.full(far.sum(), place)
            ax.plot(x[far], at, marker, color=BLACK, markersize=3, transform=across, clip_on=False)
    if lacks.any() and np.isfinite(x[lacks]).any():
        ax.plot(x[lacks], np.zeros(lacks.sum()), "|", color=RED, markersize=6, transform=across, clip_on=False)


def _cells(ax: Axes, x: np.ndarray, y: np.ndarray, bulk: Bulk) -> None:
    down, up = (np.log10(limit) if bulk.log else limit for limit in ax.get_ylim())
    extent = (*ax.get_xlim(), float(down), float(up))
    scale: Literal["log", "linear"] = "log" if bulk.log else "linear"
    cells = ax.hexbin(
        x, y, gridsize=CELLS, yscale=scale, extent=extent, bins="log", mincnt=1, cmap="Blues", linewidths=0
    )
    cells.set_rasterized(True)
    cells.set_clim(0.5)
    set_range(ax, bulk, "y", MARGIN)  # hexbin has set its own


def _correlation(ax: Axes, value: float) -> None:
    text = f"ρ = {round(value, 2) + 0.0:.2f}".replace("-", "\N{MINUS SIGN}") if np.isfinite(value) else "ρ: none"
    weight = "bold" if abs(value) >= CLEAR else "normal"
    ax.set_title(text, loc="right", fontsize=8, fontweight=weight, pad=5)
