"""Bars of shares: what contributors cause of the variance of an output, with bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.plots.curves import BLACK, BLUE, SKY, drawn, new_axes, note
from rattle.questions.ensemble.pictures import told_samples

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.ensemble.compute import Ensemble
    from rattle.questions.ensemble.first_order import FirstOrder

Bounds = tuple[float, float, float]  # value, low, high
MOST = 24  # bars; the others are added up in a line above
ALL = 0.995  # share that is written as 100 %, about


def draw_shares(ax: Axes, names: Sequence[str], first: Sequence[Bounds], total: Sequence[Bounds] | None = None) -> None:
    """Draw shares [-] of contributors (d,) with their bounds as bars in %, the greatest on top.

    total: further shares that hold the first ones, with interactions, drawn as lighter bars behind.
    Shares that are nan are left out, bounds that are nan too.
    """
    shown = first if total is None else total
    size = np.nan_to_num([bounds[0] for bounds in shown])
    order = np.argsort(-size, kind="stable")
    rows = order[:MOST]
    places = np.arange(len(rows))
    if total is None:
        _bars(ax, [first[n] for n in rows], 0.62, 0.0, color=BLUE)
    else:
        _bars(ax, [total[n] for n in rows], 0.72, -0.18, color=SKY, alpha=0.6, label="with interactions")
        _bars(ax, [first[n] for n in rows], 0.4, 0.12, color=BLUE, label="alone")
        ax.legend(loc="lower right", fontsize=9)
    _values(ax, [shown[n] for n in rows], None if total is None else [first[n] for n in rows])
    ax.set_yticks(places, [names[n] for n in rows], parse_math=False)
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("share of the variance [%]")
    if len(order) > MOST:
        rest = 100.0 * float(size[order[MOST:]].sum())
        note(ax, f"{len(order) - MOST} more with {rest:.2g} % together")


def _bars(ax: Axes, shares: Sequence[Bounds], height: float, shift: float, **style: Any) -> None:
    """Bars of shares, the bounds a little below their middle (shift, of the distance of bars)."""
    value, low, high = 100.0 * np.array(shares, dtype=float).T
    places = np.arange(len(shares))
    ax.barh(places, value, height, **style)
    away = np.nan_to_num([value - low, high - value]).clip(0.0)
    ax.errorbar(value, places + shift, xerr=away, fmt="none", ecolor=BLACK, elinewidth=1.1, capsize=3)


def _values(ax: Axes, shown: Sequence[Bounds], first: Sequence[Bounds] | None) -> None:
    """Numbers beside the bars, in a column of their own right of all bars."""
    far = max([100.0 * np.nanmax([bounds[0], bounds[2], 0.0]) for bounds in shown], default=0.0)
    ax.set_xlim(0.0, max(1.06 * far, 1.0))
    for n, bounds in enumerate(shown):
        text = bounded(bounds) if first is None else f"{bounded(first[n])}; {bounded(bounds)}"
        ax.annotate(text, (1.0, n), (6, 0), ("axes fraction", "data"), "offset points", va="center", fontsize=9)


def bounded(bounds: Bounds) -> str:
    """A share [-] in %, with its bounds where they are known; "-" for nan."""
    value, low, high = (100.0 * x for x in bounds)
    if not np.isfinite(value):
        return "-"
    digits = 1 if value < 9.95 or value > 90.05 else 0
    return f"{value:.{digits}f} %" + (
        f" ({low:.{digits}f} to {high:.{digits}f})" if np.isfinite([low, high]).all() else ""
    )


def plot_contributions(e: Ensemble, output: str, indices: FirstOrder, ax: Axes | None = None) -> Figure | Axes:
    """See `Ensemble.plot_contributions`."""
    users_axes = ax
    ax = ax if ax is not None else new_axes(8.6, 1.9 + 0.34 * min(len(indices.names), MOST))[0]
    draw_shares(ax, indices.names, indices.indices)
    what = "variance of its ranks" if indices.ranks else "variance"
    ax.set_xlabel(f"share of the {what} that each causes alone [%], 95 % bounds")
    ax.set_title(output, loc="left", fontsize=11, pad=28, parse_math=False)
    few = "; ranks, because a few outliers carry its variance" if indices.ranks else ""
    note(ax, f"{together(indices)}\n{told_samples(e)}{few}", "left")
    return drawn(ax, users_axes)


def together(indices: FirstOrder) -> str:
    """What all shares explain, and what the rest is."""
    words = f"together {bounded(indices.explained)}"
    if indices.explained.high < ALL:
        words += f"; the rest: interactions, and what polynomials of degree {indices.degree} cannot follow"
    return words
