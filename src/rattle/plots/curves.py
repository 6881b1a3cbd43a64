"""Curves over time, and what all pictures share: colours, units, axes, files."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from rattle.atomic_file import atomic
from rattle.errors import InputError
from rattle.exchange.measured import shortened
from rattle.exchange.residuals import Residual, Source, residuals
from rattle.results.chosen_units import Shown
from rattle.results.handy_units import QUANTITY, Units, handy_unit, units_of_result
from rattle.results.within_steps import bursts, cut, largest, shown_curve, summit

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.container import BarContainer
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.text import Annotation

    from rattle.results.result import Result

Array = NDArray[np.float64]
# Okabe and Ito (2008): colours that can be told apart with every kind of colour vision
BLUE, RED, GREEN, PINK, ORANGE, SKY, BLACK = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#333333"
CURVES = (BLUE, RED, GREEN, PINK, ORANGE, SKY, BLACK)
# Paul Tol, muted: for more than seven of a kind
MORE = ("#882255", "#44AA99", "#999933", "#332288", "#AA4499")
GREY, SHADE, LINES, BORE = "#777777", "#ECECEC", "#DDDDDD", "#F4F4F4"
AFTER = "after the horizon: statistics only"
MARKS = "os^Dv"  # of measured curves
LARGEST = "largest "  # before the name of a curve: what marks its largest value
NOTE = "_note"  # label of notes that may be left out where a caption says the same
SUFFIXES = (".svg", ".png", ".pdf")
MICRO = re.compile(r"(?<![a-zA-Z])u(?=[ms]\b)")  # of a unit, as it is typed


@overload
def plot(
    result: Result,
    *names: str,
    ax: None = None,
    compare: Iterable[tuple[str, Result]] = (),
    robust: bool = False,
    over: str | None = None,
    measured: Source | Iterable[Source | Residual] = (),
) -> Figure: ...
@overload
def plot(
    result: Result,
    *names: str,
    ax: Axes,
    compare: Iterable[tuple[str, Result]] = (),
    robust: bool = False,
    over: str | None = None,
    measured: Source | Iterable[Source | Residual] = (),
) -> Axes: ...
def plot(
    result: Result,
    *names: str,
    ax: Axes | None = None,
    compare: Iterable[tuple[str, Result]] = (),
    robust: bool = False,
    over: str | None = None,
    measured: Source | Iterable[Source | Residual] = (),
) -> Figure | Axes:
    """Curves over time [s]: one panel per unit, one time axis; the time after the horizon is shaded.

    Units are those of the model file, or else degrees, and m, mm or µm by size; with `ax` everything stays in SI.
    A triangle is the largest magnitude within the steps of the run, a thin line a contact between two outputs.
    over: a curve for the horizontal axis instead of time, such as "crank.angle".
    compare: further results as (label, result); their curves of the same names are dashed.
    robust: leave rare spikes out of the range of the axis (a note says how far they reach).
    measured: measured curves as dots, such as "measured.csv:theta=rocker.angle@0.2s", see `Result.residuals`; what they
    belong to is drawn too.  Below them is what they differ by, unless there is `ax`.
    ax: draw there; then all names must have one unit.  Returns a new figure, or `ax` if it is given.

    Raises UnknownName, or ValueError if there is nothing to draw or one axis for two units.
    """
    beside = residuals(result, measured, names)
    names = (*names, *(part.curve for part in beside))
    panels = _by_unit(result, names)
    _require_drawable(result, panels, ax)
    others = list(compare)
    across, along = _across(result, over)
    with_measured = {part.unit for part in beside}
    differing = () if ax is not None else tuple(unit for unit in panels if unit in with_measured)
    axes = [ax] if ax is not None else _axes_for(panels, differing)
    left = iter(axes)
    for unit, curves in panels.items():
        own = [part for part in beside if part.unit == unit]
        panel = next(left)
        _fill(panel, result, unit, curves, others, across, own, in_si=ax is not None, robust=robust)
        if unit in differing:
            below = next(left)
            legend_beside(below, draw_residuals(below, result, unit, curves, own, across))
    _mark_horizon(axes, result, over)
    if ax is None:
        title_of(axes[0], result)
    axes[-1].set_xlabel(along)
    return drawn(axes[0], ax)


def _require_drawable(result: Result, panels: Mapping[str, Sequence[str]], ax: Axes | None) -> None:
    """Raise InputError without curves, and for curves of several units on one axis."""
    if not panels:
        raise InputError(f"name at least one curve, such as {', '.join(map(repr, result.names[:3]))}")
    if ax is not None and len(panels) > 1:
        raise InputError(f"one axis shows one unit; these names have {', '.join(unit or 'none' for unit in panels)}")


def _by_unit(result: Result, names: Iterable[str]) -> dict[str, list[str]]:
    """Names of curves by their unit, each once."""
    panels: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        panels.setdefault(result.unit(name), []).append(name)
    return panels


def _mark_horizon(axes: Sequence[Axes], result: Result, over: str | None) -> None:
    """Shade the time after the horizon, or say when that is where the axis is not time."""
    for panel in axes:
        panel.margins(x=0.0)
        if over is None:
            shade_after_horizon(panel, result)
    if shade_after_horizon(axes[0], result, draw=False):
        span = f"t = {result.t[0]:g} to {result.t[-1]:g} s; after t = {result.trust.horizon:.3g} s statistics only"
        note(axes[0], AFTER if over is None else span)


def _axes_for(panels: Iterable[str], differing: Sequence[str]) -> list[Axes]:
    """Axes of a new figure: a panel for each unit, and below those with measured curves a flat one."""
    heights = [height for unit in panels for height in ((2.2, 1.3) if unit in differing else (2.2,))]
    return new_axes(8.0, 1.0 + sum(heights), rows=len(heights), heights=heights)


Across = Callable[["Result"], Array]
Curve = Callable[["Result", str], tuple[Array, Array]]  # of a result and a name


def _fill(
    panel: Axes, result: Result, unit: str, names: Sequence[str], others: Sequence[tuple[str, Result]], across: Across,
    beside: Sequence[Residual], *, in_si: bool, robust: bool,
) -> None:  # fmt: skip
    """Draw the curves of one unit; beside: the measured ones."""
    present = [(r, name) for r in (result, *(other for _, other in others)) for name in names if name in r]
    size = max((largest(r, name) for r, name in present), default=0.0)
    factor, shown = Shown(1.0, unit) if in_si else handy_unit(unit, size, units_of_result(result.provenance))
    dots = draw_measured(panel, result, names, beside, across, factor, shown if in_si else None)
    panel_of(panel, result, names, others, lambda r, name: (across(r), shown_curve(r, name)), factor, cut, dots)
    tops = [mark_largest(panel, result, name, CURVES[k % len(CURVES)], factor, across) for k, name in enumerate(names)]
    panel.set_ylabel(axis_label(QUANTITY.get(unit, ""), shown) if unit else "no unit")
    if robust:
        curves = [*(shown_curve(r, name) for r, name in present), *tops, *(part.values for part in beside)]
        robust_limits(panel, [factor * values for values in curves])


def _across(result: Result, over: str | None) -> tuple[Across, str]:
    """The values on the horizontal axis, for any result, and the label of that axis."""
    if over is None:
        return (lambda r: r.t), "time [s]"
    size = float(np.nanmax(np.abs(result[over]), initial=0.0))
    factor, unit = handy_unit(result.unit(over), size, units_of_result(result.provenance))
    return (lambda r: factor * r[over]), axis_label(over, unit)


def mark_largest(
    ax: Axes, result: Result, name: str, colour: str, factor: float, across: Across | None = None
) -> Array:
    """A triangle at the largest magnitude of a curve within the steps, lines where contacts are too short to be seen.

    factor: on the values.  across: the horizontal axis (default: time [s]).  Returns the values that are marked [SI].
    """
    place = across(result) if across is not None else result.t
    top, short = summit(result, name), bursts(result, name)
    if short:
        x = np.interp([peak.t for peak in short], result.t, place)
        ax.vlines(x, 0.0, [factor * peak.y for peak in short], color=colour, linewidth=0.7)
    if top is not None:
        shape = "v" if top.y > 0.0 else "^"
        x = np.interp([top.t], result.t, place)
        (mark,) = ax.plot(x, [factor * top.y], shape, color=colour, markersize=5, zorder=5, clip_on=False)
        mark.set_label(f"_largest magnitude of {name}")
        mark.set_gid(f"{LARGEST}{name}")
    return np.array([peak.y for peak in (top, *short) if peak is not None])


def draw_measured(
    ax: Axes, result: Result, names: Sequence[str], beside: Sequence[Residual], across: Across, factor: float,
    told_in: str | None,
) -> list[Line2D]:  # fmt: skip
    """Measured values as dots in a darker shade of the colour of their curve, each file with its own mark.

    factor: on their values.  told_in: the unit in which their labels say how far they are, None where a panel below
    does.  Returns them, for the legend.
    """
    dots = []
    for n, part in enumerate(beside):
        (line,) = ax.plot(
            _places(result, part, across), factor * part.values, MARKS[n % len(MARKS)],
            color=_darker(names, part.curve), markersize=3.2, markerfacecolor="none", markeredgewidth=0.8,
            linestyle="none", zorder=4,
        )  # fmt: skip
        words = part.told(factor, told_in) if told_in is not None else []
        line.set_label("\n".join([part.measured.label, *words]))
        dots.append(line)
    return dots


def draw_residuals(
    ax: Axes, result: Result, unit: str, names: Sequence[str], beside: Sequence[Residual], across: Across
) -> list[Line2D]:
    """What measured curves differ by, measured minus computed, in a unit of their own; returned for a legend."""
    factor, shown = handy_unit(unit, max(part.largest for part in beside), units_of_result(result.provenance))
    lines: list[Line2D] = []
    for n, part in enumerate(beside):
        words = [shortened(part.measured.column), f"\N{MINUS SIGN} {part.curve}", *part.told(factor, shown)]
        lines += ax.plot(
            _places(result, part, across), factor * part.residual, f"{MARKS[n % len(MARKS)]}-",
            color=_darker(names, part.curve), markersize=2.5, markerfacecolor="none", markeredgewidth=0.7,
            linewidth=0.6, label="\n".join(words),
        )  # fmt: skip
    ax.axhline(0.0, color=GREY, linewidth=0.7)
    ax.set_ylabel(axis_label("difference", shown))
    return lines


def _places(result: Result, part: Residual, across: Across) -> Array:
    """Where measured values stand on the horizontal axis."""
    return np.interp(part.t, result.t, across(result))


def _darker(names: Sequence[str], name: str) -> tuple[float, ...]:
    """A darker shade of the colour of a curve."""
    from matplotlib.colors import to_rgb

    return tuple(0.55 * channel for channel in to_rgb(CURVES[names.index(name) % len(CURVES)]))


def title_of(ax: Axes, result: Result) -> None:
    """The name of the model above the axes."""
    if title := str(result.provenance.get("model", "")):
        ax.set_title(title, loc="left", fontsize=10, parse_math=False)


def panel_of(
    ax: Axes, result: Result, names: Sequence[str], others: Sequence[tuple[str, Result]], curve: Curve,
    factor: float, told: Callable[[Result, str], str] | None = None, dots: Sequence[Line2D] = (),
) -> None:  # fmt: skip
    """Curves of a result, and dashed those of others, with a legend beside them.

    factor: on their values.  told: words on a curve of a result that stand in the legend, "" for none.  dots: what else
    stands there.
    """
    from matplotlib.colors import to_rgb

    lines = []
    for k, name in enumerate(names):
        colour = CURVES[k % len(CURVES)]
        x, y = curve(result, name)
        words = told(result, name) if told is not None else ""
        label = f"{name}\n({words})" if words else name
        lines += ax.plot(x, factor * y, color=colour, linewidth=0.9, label=label)
        for n, (label, other) in enumerate(others):
            if name in other:
                style: dict[str, Any] = {"linestyle": (0, (4, 1 + 2 * n)), "linewidth": 1.1}
                style |= {"color": tuple(0.45 * part for part in to_rgb(colour)), "label": f"{name}, {label}"}
                x, y = curve(other, name)
                lines += ax.plot(x, factor * y, **style)
    legend_beside(ax, [*lines, *dots])


def legend_beside(ax: Axes, lines: Sequence[Artist | BarContainer]) -> None:
    """A legend of these lines or bars on the right of the axes, whatever their names are made of."""
    place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
    # matplotlib leaves out names that begin with an underscore: they are written after the legend is made
    legend = ax.legend(lines, [str(k) for k in range(len(lines))], frameon=False, fontsize=9, **place)
    for text, line in zip(legend.get_texts(), lines, strict=True):
        text.set(text=str(line.get_label()), parse_math=False)


def length_axes(ax: Axes, span: float, written: Units | None = None) -> None:
    """Label the axes of a drawing of this span, whose data are in m, in the unit of the model file or a handy one."""
    factor, unit = handy_unit("m", span, written)
    ax.set(xlabel=axis_label("x", unit), ylabel=axis_label("y", unit))
    for axis in (ax.xaxis, ax.yaxis) if factor != 1.0 else ():
        axis.set_major_formatter(lambda value, _: f"{factor * value:g}".replace("-", "\N{MINUS SIGN}"))


# ---------------------------------------------------------------- common to all pictures
def new_figure(width: float, height: float) -> Figure:
    """An empty figure (width, height [inches]), independent of pyplot; it shows itself in a notebook."""
    from rattle.plots.figure import Page

    return Page(width, height)


def new_axes(
    width: float, height: float, rows: int = 1, columns: int = 1, heights: Sequence[float] | None = None
) -> list[Axes]:
    """Axes of a new figure (width, height [inches]), row by row, with one time axis; heights: of rows, as ratios."""
    figure = new_figure(width, height)
    axes = figure.subplots(rows, columns, sharex=True, squeeze=False, height_ratios=heights)
    return [tidy(ax) for ax in axes.flat]


def tidy(ax: Axes) -> Axes:
    """Give an axis the look that all pictures share; returns it."""
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(True, color=LINES, linewidth=0.5)
    ax.set_axisbelow(True)
    return ax


def figure_of(ax: Axes) -> Figure:
    """The figure that an axis belongs to. Raises InputError if there is none."""
    figure = ax.get_figure(root=True)
    if figure is None:
        raise InputError("this axis belongs to no figure")
    return figure


def drawn(ax: Axes, asked: Axes | None) -> Figure | Axes:
    """What a drawing function returns: its new figure, or the given axes (which a notebook shows only once)."""
    return figure_of(ax) if asked is None else asked


def axis_label(quantity: str, unit: str) -> str:
    """`quantity [unit]`, the unit as it is printed (N·m, m/s², µm)."""
    printed = MICRO.sub("µ", unit.replace("*", "·").replace("^2", "²").replace("^3", "³"))
    return f"{quantity} [{printed}]" if printed else quantity


def note(ax: Axes, text: str, side: Literal["left", "right"] = "right") -> Annotation:
    """A small grey line above the axis, at one of its ends."""
    place = (0 if side == "left" else 1, 1)
    return ax.annotate(
        text, place, (0, 3), "axes fraction", "offset points", color=GREY, fontsize=8, ha=side, va="bottom", label=NOTE
    )  # fmt: skip


def shade_after_horizon(ax: Axes, result: Result, draw: bool = True) -> bool:
    """Shade the time after the horizon; True if there is any."""
    horizon, end = result.trust.horizon, result.trust.t_end
    if horizon is None or horizon >= end:
        return False
    if draw:
        ax.axvspan(horizon, end, color=SHADE, linewidth=0, zorder=0)
        ax.axvline(horizon, color=GREY, linewidth=0.8, linestyle=":", zorder=1)
    return True


def robust_limits(ax: Axes, curves: Sequence[Array], side: Literal["left", "right"] = "left") -> bool:
    """Keep rare spikes from flattening the curve; True if something is cut off, which a note then says.

    A limit moves in only if the extreme lies far outside the middle 99 % of the values.
    """
    values = np.concatenate([c[np.isfinite(c)] for c in curves])
    if not len(values):
        return False
    low, high = (float(p) for p in np.percentile(values, [0.5, 99.5]))
    least, most = float(values.min()), float(values.max())
    far = 0.7 * (high - low)
    cut_low, cut_high = least < low - far, most > high + far
    if not (cut_low or cut_high):
        return False
    bottom, top = (low if cut_low else least), (high if cut_high else most)
    ax.set_ylim(bottom - 0.12 * (top - bottom), top + 0.12 * (top - bottom))
    for mark in ax.lines:
        if str(mark.get_gid()).startswith(LARGEST):
            mark.set_ydata(np.clip(mark.get_ydata(), *ax.get_ylim()))  # at the edge, beyond which the largest lies
    reach = " and ".join(f"{float(f'{v:.3g}'):g}" for v, cut in ((least, cut_low), (most, cut_high)) if cut)
    note(ax, f"spikes cut off: they reach {reach}".replace("-", "\N{MINUS SIGN}"), side).set_label("_spikes")
    return True


def save_figure(figure: Figure, path: str | os.PathLike[str], dpi: float = 150) -> None:
    """Write a figure as .svg, .png or .pdf; dpi: resolution [1/inch]. Raises InputError for another suffix, OSError."""
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"{os.fspath(path)}: a picture needs a name ending in {', '.join(SUFFIXES)}")
    from matplotlib import rc_context

    from rattle.plots.figure import TEXT

    with rc_context(TEXT), atomic(path) as file:
        figure.savefig(file, dpi=dpi, format=suffix[1:], metadata={"Date": None} if suffix == ".svg" else None)
