"""Pictures of an ensemble: how an output is distributed, and the band in which a curve lies."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rattle.errors import InputError
from rattle.plots.bulk import Bulk, bulk_of, set_range
from rattle.plots.curves import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    RED,
    SKY,
    axis_label,
    drawn,
    new_axes,
    note,
    robust_limits,
)  # fmt: skip
from rattle.results.handy_units import QUANTITY
from rattle.studies.runs.columns import number, scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.ensemble.bands import Band
    from rattle.questions.ensemble.compute import Ensemble, Limit

FEWEST_BINS, MOST_BINS = 8, 80
SAME = 1e-12  # share of the largest value by which values differ from rounding alone
WHOLE = 60  # different whole numbers with a bin each, at most
LEGEND: dict[str, Any] = {
    "frameon": False,
    "fontsize": 9,
    "loc": "upper left",
    "bbox_to_anchor": (1.01, 1.0),
    "borderaxespad": 0.0,
}


class Mark(NamedTuple):
    """A line at a value of the horizontal axis."""

    value: float  # in the unit shown
    label: str
    colour: str
    style: Any


def told_samples(e: Ensemble) -> str:
    """How many samples of what, and how many of them have no numbers."""
    counts = e.counts()
    run = len(e) - counts["not run"]
    words = f"{run} sample{'s' if run != 1 else ''} of {listed(e.parameters)}"
    parts = [f"{counts[kind]} {kind}" for kind in ("failed", "not finite") if counts[kind]]
    return ", ".join([words, *parts])


def listed(names: tuple[str, ...], most: int = 6) -> str:
    """Names, or their number if they are many."""
    return ", ".join(names) if len(names) <= most else f"{len(names)} parameters"


def finite(e: Ensemble, output: str) -> np.ndarray:
    """The finite values of an output [SI].  Raises UnknownName, or ValueError if there are none."""
    values = e[output]
    finite_values = values[np.isfinite(values)]
    if not len(finite_values):
        why = next(iter(e.why()), "no sample was run" if not (e.store.status() >= 0).any() else "")
        raise InputError(
            f"{output}: none of {len(e)} samples has a finite value, there is nothing to draw" + f": {why}" * bool(why)
        )
    return np.asarray(finite_values)


# ---------------------------------------------------------------- how an output is distributed
def plot_output(e: Ensemble, output: str, limit: Limit, ax: Axes | None) -> Figure | Axes:
    """See `Ensemble.plot`."""
    from matplotlib.ticker import MaxNLocator

    values = finite(e, output)
    unit = e.unit(output)
    users_axes, ends = ax, _ends(e, output, limit)
    nominal = dict(zip(e.outputs, e.nominal, strict=True))[output]
    bulk = bulk_of(values, unit, [nominal, *(end for end in ends if end is not None)])
    ax = ax if ax is not None else new_axes(8.6, 4.6)[0]
    shown = bulk.factor * values
    edges = _edges(shown, bulk)
    ax.hist(shown, edges.tolist(), color=SKY, alpha=0.75, edgecolor="white", linewidth=0.4)
    whole = _whole(shown, bulk)
    if whole:
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    beside = 1.0 if whole else 2.0 * (edges[1] - edges[0]) if len(edges) == 2 else 0.0  # of a single bar
    left, right = min(bulk.low, edges[0] - beside), max(bulk.high, edges[-1] + beside)
    set_range(ax, bulk._replace(low=left, high=right), "x", 0.02)
    quantiles = e.statistics(output).quantiles
    marks = [
        Mark(bulk.factor * end.value, f"{100 * share:.0f} %: {_number(bulk.factor * end.value, bulk)}", BLACK, style)
        for (share, end), style in zip(quantiles.items(), [(0, (2, 2)), "-", (0, (5, 2))], strict=True)
    ]
    if math.isfinite(nominal):
        at = bulk.factor * nominal
        marks.append(Mark(at, f"nominal: {_number(at, bulk)}", ORANGE, "-"))
    marks += _limit_marks(e, output, limit, ends, bulk)
    _shade_beyond(ax, ends, bulk, 0.5 if whole else 0.0)
    _draw_marks(ax, marks)
    ax.set_ylabel("number of samples")
    ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel(axis_label(QUANTITY.get(unit, "value"), bulk.unit))
    ax.set_title(output, loc="left", fontsize=11, pad=28 if bulk.outside else 16, parse_math=False)
    note(ax, told_samples(e) + (f"\nnot shown: {bulk.outside}" if bulk.outside else ""), "left")
    return drawn(ax, users_axes)


def _number(shown: float, bulk: Bulk) -> str:
    text = number(shown, bulk.spread).replace("-", "\N{MINUS SIGN}")
    return f"{text} {bulk.unit}".rstrip().replace("*", "·")


def _ends(e: Ensemble, output: str, limit: Limit) -> tuple[float | None, float | None]:
    """Limits (low, high) [SI].  Raises InputError, TypeError."""
    low, high = limit if isinstance(limit, tuple) else (None, limit)
    ends = tuple(None if end is None else e.limit(output, end) for end in (low, high))
    if ends[0] is not None and ends[1] is not None and ends[0] >= ends[1]:
        raise InputError(f"limit: the lower one, {low}, is not below the upper one, {high}")
    return ends[0], ends[1]


def _whole(shown: np.ndarray, bulk: Bulk) -> bool:
    """Whether the values are whole numbers, few enough for a bin each."""
    return not bulk.log and not bulk.unit and bulk.high - bulk.low < WHOLE and bool((shown == np.round(shown)).all())


def _edges(shown: np.ndarray, bulk: Bulk) -> np.ndarray:
    """Edges of bins over the bulk of values, in the unit shown and even on its scale."""
    inside = shown[(shown >= bulk.low) & (shown <= bulk.high)]
    if _whole(inside, bulk):
        return np.arange(inside.min() - 0.5, inside.max() + 1.0)  # a bin for each number
    seen = np.log10(inside) if bulk.log else inside
    low, high = float(seen.min()), float(seen.max())
    if high - low <= SAME * max(abs(low), abs(high)):  # all are equal
        half = (0.02 if bulk.log else 0.01 * abs(low)) or 0.5
        low, high, count = low - half, high + half, 1
    else:
        bins = len(np.histogram_bin_edges(seen, "auto")) - 1  # the finer of Sturges, and Freedman and Diaconis
        count = int(np.clip(bins, min(FEWEST_BINS, len(inside)), MOST_BINS))
    edges = np.linspace(low, high, count + 1)
    if not bulk.log:
        return edges
    edges = 10.0**edges
    edges[0], edges[-1] = min(edges[0], inside.min()), max(edges[-1], inside.max())  # roundings leave nobody out
    return np.asarray(edges)


def _limit_marks(
    e: Ensemble, output: str, limit: Limit, ends: tuple[float | None, float | None], bulk: Bulk
) -> list[Mark]:
    """The limits, with the share of the samples within."""
    if ends == (None, None):
        return []
    limits = limit if isinstance(limit, tuple) else (None, limit)
    both = zip(limits, ends, strict=True)
    texts = [
        text if isinstance(text, str) else _number(bulk.factor * end, bulk) for text, end in both if end is not None
    ]
    share = e.yield_between(output, *ends)
    label = f"limit{'s' if len(texts) > 1 else ''} {' and '.join(texts)}:\n{_percent(share.value)} within"
    label += f" ({_percent(share.low)} to {_percent(share.high)})"
    at = [bulk.factor * end for end in ends if end is not None]
    return [Mark(place, label if n == 0 else "", RED, (0, (6, 1.5))) for n, place in enumerate(at)]


def _percent(share: float) -> str:
    """A share with digits enough to tell it from all and nothing."""
    rest = min(share, 1.0 - share)
    digits = max(1, min(6, -math.floor(math.log10(100 * rest)))) if rest > 0.0 else 1
    return f"{100 * share:.{digits}f} %"


def _shade_beyond(ax: Axes, ends: tuple[float | None, float | None], bulk: Bulk, half: float) -> None:
    """Shade what is beyond limits [SI]; half: a bin, which belongs to the value in its middle."""
    left, right = ax.get_xlim()
    low, high = (
        None if end is None else bulk.factor * end + side * half for end, side in zip(ends, (-1, 1), strict=True)
    )
    for first, last in ((left, low), (high, right)):
        if first is not None and last is not None and first < last:
            ax.axvspan(max(first, left), min(last, right), color=RED, alpha=0.08, linewidth=0, zorder=0)
    ax.set_xlim(left, right)


def _draw_marks(ax: Axes, marks: list[Mark]) -> None:
    """Lines with a legend; what lies outside of the axis is in the legend only, with the side on which it is."""
    left, right = ax.get_xlim()
    lines = []
    for mark in marks:
        side = "" if left <= mark.value <= right else " (further left)" if mark.value < left else " (further right)"
        line = ax.axvline(mark.value, color=mark.colour, linestyle=mark.style, linewidth=1.3, label=mark.label + side)
        line.set_visible(not side)
        lines += [line] if mark.label else []
    ax.set_xlim(left, right)
    legend = ax.legend(lines, [str(n) for n in range(len(lines))], **LEGEND)
    for text, line in zip(legend.get_texts(), lines, strict=True):
        text.set(text=str(line.get_label()), parse_math=False)


# ---------------------------------------------------------------- curves
def plot_band(band: Band, ax: Axes | None = None) -> Figure | Axes:
    """See `Ensemble.plot_band`."""
    low, high = np.quantile(band.members, [0.05, 0.95], axis=0)
    narrow = float((high - low).max()) < NARROW * float(high.max() - low.min())
    axes = [ax] if ax is not None else new_axes(8.6, 6.4 if narrow else 4.6, rows=2 if narrow else 1)
    cut = _draw_band(axes[0], band.t, band.members, band.nominal, band.unit)
    axes[0].set_ylabel(axis_label(QUANTITY.get(band.unit, ""), axes[0].get_ylabel()) if band.unit else "no unit")
    if len(axes) > 1:
        middle = np.median(band.members, axis=0) if band.nominal is None else band.nominal
        nominal = None if band.nominal is None else 0.0 * middle
        _draw_band(axes[1], band.t, band.members - middle, nominal, band.unit)
        what = "deviation from the " + ("median" if nominal is None else "nominal")
        axes[1].set_ylabel(axis_label(what, axes[1].get_ylabel()))
    axes[-1].set_xlabel("time [s]")
    count = len(band.members)
    words = f"the first {count + band.failed} of {band.samples} samples of {listed(band.parameters)}"
    words += f", {band.failed} of them failed" if band.failed else ""
    note(axes[0], words + ("\n" if cut else ""), "left")  # what is cut off stands below
    title = f"{band.curve}, {count} member{'s' if count != 1 else ''}"
    axes[0].set_title(title, loc="left", fontsize=11, pad=28 if cut else 16, parse_math=False)
    axes[0].legend(**LEGEND)
    return drawn(axes[0], ax)


NARROW = 0.1  # width of a band, as a share of the range of its curve, below which its deviations are drawn too
SINGLE = 5  # members that are drawn as lines


def _draw_band(ax: Axes, t: np.ndarray, members: np.ndarray, nominal: np.ndarray | None, unit: str) -> bool:
    """Draw members (n, k) [SI] at instants (k,) [s] and label the axis with the unit; True if spikes are cut off."""
    low, lower, middle, upper, high = np.quantile(members, [0.05, 0.25, 0.5, 0.75, 0.95], axis=0)
    seen = [low, high, *([] if nominal is None else [nominal])]
    sizes = [float(np.abs(curve).max()) for curve in seen]
    factor, shown = scale_of([max(sizes), float((high - low).max())], unit)
    ax.fill_between(t, factor * low, factor * high, color=BLUE, alpha=0.18, linewidth=0, label="5 to 95 %")
    ax.fill_between(t, factor * lower, factor * upper, color=BLUE, alpha=0.3, linewidth=0, label="25 to 75 %")
    few = members[:SINGLE]
    for n, member in enumerate(few):
        label = f"{len(few)} members" if n == 0 and len(few) > 1 else None
        ax.plot(t, factor * member, color=GREY, linewidth=0.5, alpha=0.8, label=label)
    ax.plot(t, factor * middle, color=BLUE, linewidth=1.6, label="median")
    if nominal is not None:
        style: dict[str, Any] = {"color": ORANGE, "linewidth": 1.4, "linestyle": (0, (5, 2))}
        ax.plot(t, factor * nominal, label="nominal", **style)
    cut = robust_limits(ax, [factor * curve for curve in seen])
    if not cut:
        least, most = (factor * float(end([end(curve) for curve in seen])) for end in (np.min, np.max))
        room = 0.06 * (most - least) or 0.05 * abs(most) or 0.5
        ax.set_ylim(least - room, most + room)
    ax.margins(x=0.0)
    ax.set_ylabel(shown)
    return cut
