"""Pictures of a sweep: an output over one parameter, or a map of it over two."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rattle.errors import InputError
from rattle.plots.bulk import Bulk, bulk_of, set_range
from rattle.plots.curves import (
    BLACK,
    BLUE,
    GREY,
    RED,
    axis_label,
    drawn,
    figure_of,
    new_axes,
    new_figure,
    note,
    tidy,
)
from rattle.results.handy_units import QUANTITY
from rattle.studies.runs.columns import in_one_unit, scale_of
from rattle.studies.runs.limits import limit_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.sweep.compute import Sweep

PANELS = 6  # outputs in one picture, at most
MARKED = 60  # values up to which each one is marked
LINES = 8  # contour lines, about
FEWEST = 4  # values of both parameters, for contour lines
SAME = 1e-9  # relative difference of values that are the same
BRIGHT = 0.55  # place on the colour map from which on lines are dark
EMPTY = "#C8C8C8"


class Section(NamedTuple):
    """What is left of a grid when some parameters are fixed."""

    names: tuple[str, ...]  # with several values
    axes: tuple[np.ndarray, ...]  # their values [SI], increasing
    values: np.ndarray  # (n_1,) or (n_1, n_2) [SI], nan where there is none
    fixed: str  # as text


def plot_sweep(
    w: Sweep, output: str | None = None, ax: Axes | None = None, at: Mapping[str, float | str] | None = None
) -> Figure | Axes:
    """See `Sweep.plot`."""
    if output is None and len(w.outputs) > 1:
        if ax is not None:
            raise InputError(f"one axis shows one output; name one of {', '.join(w.outputs)}")
        names = w.outputs[:PANELS]
        figure = new_figure(8.0, 3.6 * len(names))
        for name, panel in zip(names, figure.subplots(len(names), 1), strict=True):
            plot_output(w, name, tidy(panel), at)
        return figure
    return plot_output(w, w.outputs[0] if output is None else output, ax, at)


def plot_output(w: Sweep, output: str, ax: Axes | None, at: Mapping[str, float | str] | None) -> Figure | Axes:
    """One output; on a new figure, or on `ax`, which is then returned."""
    shown = section(w, output, {} if at is None else at)
    if not np.isfinite(shown.values).any():
        why = next(iter(w.why()), "")
        raise InputError(
            f"{output}: no combination has a finite value, there is nothing to draw" + f": {why}" * bool(why)
        )
    line = len(shown.names) == 1
    axes, ax = ax, ax if ax is not None else new_axes(*((8.0, 4.6) if line else (7.2, 5.4)))[0]
    bulk = bulk_of(shown.values[np.isfinite(shown.values)], w.unit(output))
    (_curve if line else _map)(ax, w, output, shown, bulk)
    remarks = [shown.fixed] if shown.fixed else []
    count = shown.values.size
    remarks.append(f"{count} run{'s' if count != 1 else ''}")
    lacks = int(np.isnan(shown.values).sum())
    remarks += [f"{lacks} without a value ({'red' if line else 'grey'})"] if lacks else []
    text = ", ".join(remarks) + (f"\nnot in the range: {bulk.outside}" if bulk.outside else "")
    ax.set_title(output, loc="left", fontsize=11, pad=28 if bulk.outside else 16, parse_math=False)
    note(ax, text, "left")
    return drawn(ax, axes)


def section(w: Sweep, output: str, at: Mapping[str, float | str]) -> Section:
    """A grid with parameters fixed where `at` says, or where they have one value only; at most two are left.

    Raises UnknownName, and ValueError for values that are not in the grid, or more than two parameters.
    """
    values = w.grid(output)
    names: list[str] = []
    places: list[Any] = []
    fixed: list[str] = []
    for name in at:
        if name not in w.axes:
            raise InputError(f"at: '{name}' is none of {', '.join(w.axes)}")
    for name, axis in w.axes.items():
        if name in at or len(axis) == 1:
            n = _place(name, axis, at[name], w.unit(name)) if name in at else 0
            places.append(n)
            fixed.append(f"{name} = " + " ".join(in_one_unit([axis[n]], w.unit(name))).rstrip())
        else:
            names.append(name)
            places.append(slice(None))
    if not names:  # a single combination: a point over the last parameter
        names, last = [list(w.axes)[-1]], places[-1]
        places[-1] = slice(last, last + 1)
        fixed.pop()
    if len(names) > 2:
        fix = {name: float(f"{w.axes[name][len(w.axes[name]) // 2]:.6g}") for name in names[2:]}
        raise InputError(
            f"{output} varies with {', '.join(names)}, and a picture shows two of them; fix the others at one of their "
            f"values, such as at={fix}"
        )
    chosen = values[tuple(places)]
    axes = []
    for k, name in enumerate(names):
        axis = w.axes[name][places[list(w.axes).index(name)]]
        order = np.argsort(axis, kind="stable")
        chosen = np.take(chosen, order, axis=k)
        axes.append(axis[order])
    return Section(tuple(names), tuple(axes), chosen, ", ".join(fixed))


def _place(name: str, axis: np.ndarray, asked: float | str, unit: str) -> int:
    """Where a value is in the grid.  Raises InputError, TypeError."""
    value = limit_of(asked, unit, f"at: '{name}'")
    n = int(np.argmin(np.abs(axis - value)))
    if abs(axis[n] - value) > SAME * np.abs(axis).max():
        near = np.sort(axis[np.argsort(np.abs(axis - value))[:2]])
        raise InputError(
            f"at: {name} = {value:g} is not in the sweep; the nearest: {', '.join(f'{x:g}' for x in near)}"
        )
    return n


def _axis(w: Sweep, name: str, axis: np.ndarray) -> tuple[np.ndarray, str]:
    """Values in the unit shown, and the label."""
    scale, unit = scale_of([float(x) for x in axis], w.unit(name))
    return scale * axis, axis_label(name, unit)


def _curve(ax: Axes, w: Sweep, output: str, shown: Section, bulk: Bulk) -> None:
    x, label = _axis(w, shown.names[0], shown.axes[0])
    y = bulk.factor * shown.values
    finite = np.isfinite(y)
    marker = "o" if len(x) <= MARKED else ""
    alone = finite & ~np.append(finite[1:], False) & ~np.append(False, finite[:-1])  # no line leads there
    ax.plot(x, y, color=BLUE, linewidth=1.2, marker=marker, markersize=3.5)
    if alone.any() and not marker:
        ax.plot(x[alone], y[alone], ".", color=BLUE)
    if not finite.all():
        place = np.zeros(int((~finite).sum()))
        ax.plot(x[~finite], place, "|", color=RED, markersize=9, transform=ax.get_xaxis_transform(), clip_on=False)
    set_range(ax, bulk, "y", 0.06)
    ax.set_xlabel(label, parse_math=False)
    ax.set_ylabel(axis_label(QUANTITY.get(w.unit(output), "value"), bulk.unit))
    ax.margins(x=0.02)


def _map(ax: Axes, w: Sweep, output: str, shown: Section, bulk: Bulk) -> None:
    from matplotlib.colors import LogNorm, Normalize

    (x, across), (y, up) = (_axis(w, name, axis) for name, axis in zip(shown.names, shown.axes, strict=True))
    z = np.ma.masked_invalid(bulk.factor * shown.values.T)
    half = 0.0 if bulk.high > bulk.low else 0.05 * abs(bulk.low) or 0.5  # all are equal
    norm = (LogNorm if bulk.log else Normalize)(bulk.low - half, bulk.high + half)
    ax.grid(False)
    ax.set_facecolor(EMPTY)
    cells = ax.pcolormesh(_edges(x), _edges(y), z, norm=norm, cmap="cividis", rasterized=True, linewidth=0)
    if z.mask.any():
        _hatch(ax, _edges(x), _edges(y), np.ma.getmaskarray(z))
    if min(z.shape) >= FEWEST and bulk.high > bulk.low:
        _lines(ax, x, y, z, bulk, norm)
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    bar = figure_of(ax).colorbar(cells, ax=ax, pad=0.02, extend=extend[bulk.below > 0, bulk.above > 0])
    bar.set_label(axis_label(QUANTITY.get(w.unit(output), "value"), bulk.unit))
    ax.set_xlabel(across, parse_math=False)
    ax.set_ylabel(up, parse_math=False)


def _edges(middle: np.ndarray) -> np.ndarray:
    """Edges (n + 1,) of cells about increasing values (n,), n > 1."""
    between = 0.5 * (middle[1:] + middle[:-1])
    return np.concatenate([[2 * middle[0] - between[0]], between, [2 * middle[-1] - between[-1]]])


def _hatch(ax: Axes, x: np.ndarray, y: np.ndarray, empty: np.ndarray) -> None:
    """Hatch cells without a value; empty (n_y, n_x)."""
    from matplotlib.collections import PolyCollection

    boxes = [
        [(x[k], y[n]), (x[k + 1], y[n]), (x[k + 1], y[n + 1]), (x[k], y[n + 1])] for n, k in np.argwhere(empty).tolist()
    ]
    ax.add_collection(PolyCollection(boxes, facecolor=EMPTY, edgecolor=GREY, hatch="////", linewidth=0), autolim=False)


def _lines(ax: Axes, x: np.ndarray, y: np.ndarray, z: np.ndarray, bulk: Bulk, norm: Any) -> None:
    """Contour lines with their values."""
    from matplotlib.ticker import LogLocator, MaxNLocator

    locator = LogLocator(subs=(1.0, 2.0, 5.0)) if bulk.log else MaxNLocator(LINES)
    levels = [level for level in locator.tick_values(bulk.low, bulk.high) if bulk.low < level < bulk.high]
    if levels:
        colours = [BLACK if norm(level) > BRIGHT else "white" for level in levels]
        lines = ax.contour(x, y, z, levels, colors=colours, linewidths=0.8, alpha=0.9)
        ax.clabel(lines, fontsize=8, fmt=lambda level: f"{level:g}".replace("-", "\N{MINUS SIGN}"))
