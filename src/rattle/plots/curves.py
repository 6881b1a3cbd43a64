"""Curves over time and orbits of pins in their bushes, drawn with matplotlib."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from rattle.atomic_file import atomic

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.result import Result

Array = NDArray[np.float64]
# Okabe and Ito (2008), the colours that all kinds of eyes tell apart
BLUE, RED, GREEN, PINK, ORANGE, SKY, BLACK = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#333333"
CURVES = (BLUE, RED, GREEN, PINK, ORANGE, SKY, BLACK)
# Paul Tol, muted: for more than seven of a kind
MORE = ("#882255", "#44AA99", "#999933", "#332288", "#AA4499")
GREY, SHADE, LINES, BORE = "#777777", "#ECECEC", "#DDDDDD", "#F4F4F4"
AFTER = "after the horizon: statistics only"
QUANTITY = {
    "m": "length",
    "rad": "angle",
    "N": "force",
    "N*m": "moment",
    "m/s": "speed",
    "rad/s": "angular rate",
    "m/s^2": "acceleration",
    "rad/s^2": "angular acceleration",
    "J": "energy",
    "W": "power",
}
SUFFIXES = (".svg", ".png", ".pdf")


@overload
def plot(
    result: Result,
    *names: str,
    ax: None = None,
    compare: Iterable[tuple[str, Result]] = (),
    robust: bool = False,
    over: str | None = None,
) -> Figure: ...
@overload
def plot(
    result: Result,
    *names: str,
    ax: Axes,
    compare: Iterable[tuple[str, Result]] = (),
    robust: bool = False,
    over: str | None = None,
) -> Axes: ...
def plot(
    result: Result,
    *names: str,
    ax: Axes | None = None,
    compare: Iterable[tuple[str, Result]] = (),
    robust: bool = False,
    over: str | None = None,
) -> Figure | Axes:
    """Curves over time: one panel per unit, one time axis; what lies after the horizon is shaded.

    Angles are drawn in degrees, lengths in m, mm or µm as they are large; with `ax` all stays in SI.
    over: another curve, such as "crank.angle", in the place of time.
    compare: further results as (label, result); their curves of the same names are dashed.
    robust: leave rare spikes out of the range of the axis (a note says how far they reach).
    ax: draw there; then all names must have one unit.  Returns a new figure, or `ax` where it is given.

    Raises UnknownName, or ValueError where there is nothing to draw or one axis for two units.
    """
    if not names:
        raise ValueError(f"name at least one curve, such as {', '.join(repr(n) for n in result.names[:3])}")
    panels: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        panels.setdefault(result.unit(name), []).append(name)
    if ax is not None and len(panels) > 1:
        raise ValueError(f"one axis shows one unit; these names have {', '.join(u or 'none' for u in panels)}")
    others = list(compare)
    axes = [ax] if ax is not None else new_axes(8.0, 1.0 + 2.2 * len(panels), rows=len(panels))
    across, along = _across(result, over)
    for panel, (unit, curves) in zip(axes, panels.items(), strict=True):
        every = [r[name] for _, r in [("", result), *others] for name in curves if name in r]
        largest = max((float(np.nanmax(np.abs(one), initial=0.0)) for one in every), default=0.0)
        factor, shown = (1.0, unit) if ax is not None else handy_unit(unit, largest)
        _panel(panel, result, curves, others, factor, across)
        panel.set_ylabel(axis_label(QUANTITY.get(unit, ""), shown) if unit else "no unit")
        if robust:
            robust_limits(panel, [factor * one for one in every])
    for panel in axes:
        panel.margins(x=0.0)
        if over is None:
            shade_after_horizon(panel, result)
    if shade_after_horizon(axes[0], result, draw=False):
        span = f"t = {result.t[0]:g} to {result.t[-1]:g} s; after t = {result.trust.horizon:.3g} s statistics only"
        note(axes[0], AFTER if over is None else span)
    if ax is None and (title := str(result.provenance.get("model", ""))):
        axes[0].set_title(title, loc="left", fontsize=10, parse_math=False)
    axes[-1].set_xlabel(along)
    return drawn(axes[0], ax)


Across = Callable[["Result"], Array]


def _across(result: Result, over: str | None) -> tuple[Across, str]:
    """What curves are drawn over, for any result, and how its axis is labelled."""
    if over is None:
        return (lambda r: r.t), "time [s]"
    factor, unit = handy_unit(result.unit(over), float(np.nanmax(np.abs(result[over]), initial=0.0)))
    return (lambda r: factor * r[over]), axis_label(over, unit)


def _panel(
    ax: Axes, result: Result, names: list[str], others: list[tuple[str, Result]], factor: float, across: Across
) -> None:
    from matplotlib.colors import to_rgb

    lines = []
    for k, name in enumerate(names):
        colour = CURVES[k % len(CURVES)]
        lines += ax.plot(across(result), factor * result[name], color=colour, linewidth=0.9, label=name)
        for n, (label, other) in enumerate(others):
            if name in other:
                style: dict[str, Any] = {"linestyle": (0, (4, 1 + 2 * n)), "linewidth": 1.1}
                style |= {"color": tuple(0.45 * part for part in to_rgb(colour)), "label": f"{name}, {label}"}
                lines += ax.plot(across(other), factor * other[name], **style)
    place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
    # matplotlib leaves out names that begin with an underscore: they are written once the legend stands
    legend = ax.legend(lines, [str(k) for k in range(len(lines))], frameon=False, fontsize=9, **place)
    for text, line in zip(legend.get_texts(), lines, strict=True):
        text.set(text=str(line.get_label()), parse_math=False)


def handy_unit(unit: str, size: float) -> tuple[float, str]:
    """A factor from SI and the unit in which a quantity of this size is easy to read."""
    if unit == "rad":
        return 180 / np.pi, "deg"
    if unit == "m" and 0.0 < size < 0.1:
        return (1e3, "mm") if size >= 1e-4 else (1e6, "µm")
    return 1.0, unit


@overload
def plot_path(result: Result, *points: str, ax: None = None) -> Figure: ...
@overload
def plot_path(result: Result, *points: str, ax: Axes) -> Axes: ...
def plot_path(result: Result, *points: str, ax: Axes | None = None) -> Figure | Axes:
    """Paths of points such as "coupler.P" (or of mass centres, "coupler") in the plane, a ring at their start.

    ax: draw there.  Returns a new figure, or `ax` where it is given.
    Raises UnknownName, or ValueError without a point.
    """
    if not points:
        raise ValueError("name at least one point, such as 'coupler.P'")
    for name in points:
        require_point(result, name)
    paths = [(name, result[f"{name}.x"], result[f"{name}.y"]) for name in dict.fromkeys(points)]
    factor, unit = handy_unit("m", max(float(np.nanmax(np.abs(one[1:]), initial=0.0)) for one in paths))
    given, ax = ax, ax if ax is not None else new_axes(6.8, 5.4)[0]
    for k, (name, x, y) in enumerate(paths):
        colour = CURVES[k % len(CURVES)]
        ax.plot(factor * x, factor * y, color=colour, linewidth=1.1, label=f"path of {name}")
        ax.plot(factor * x[:1], factor * y[:1], "o", markerfacecolor="white", markeredgecolor=colour, markersize=6)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    ax.set_xlabel(axis_label("x", unit))
    ax.set_ylabel(axis_label("y", unit))
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3, frameon=False, fontsize=9)
    if title := str(result.provenance.get("model", "")):
        ax.set_title(title, loc="left", fontsize=10, pad=14, parse_math=False)
    span = f"t = {result.t[0]:g} to {result.t[-1]:g} s" if len(result.t) else "no instant"
    late = shade_after_horizon(ax, result, draw=False)
    note(ax, f"{span}; after t = {result.trust.horizon:.3g} s statistics only" if late else span)
    return drawn(ax, given)


def require_point(result: Result, name: str) -> None:
    """Raise UnknownName where the result has no path of this point or body."""
    known = [one[:-2] for one in result.names if one.endswith(".x") and f"{one[:-1]}y" in result]
    if name not in known:
        from rattle.errors import suggest
        from rattle.results.result import UnknownName

        raise UnknownName(f"the result has no point or body {name!r}{suggest(name, known)}")


@overload
def plot_orbit(result: Result, joint: str, ax: None = None) -> Figure: ...
@overload
def plot_orbit(result: Result, joint: str, ax: Axes) -> Axes: ...
def plot_orbit(result: Result, joint: str, ax: Axes | None = None) -> Figure | Axes:
    """Path of the pin centre in the clearance circle of a joint, coloured by the normal force.

    Larger forces lie on top of smaller ones.  Ticks outside the circle show where N < 0, that is,
    where the bush would have to pull; dots on the circle are impacts, their area as the impulse, and rings
    where lasting contacts start.
    ax: draw there.  Returns a new figure, or `ax` where it is given.
    Raises ValueError where the joint has no clearance.
    """
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize
    from matplotlib.patches import Circle

    form = clearance_joints(result).get(joint)
    if form is None:
        known = ", ".join(clearance_joints(result)) or "none has"
        raise ValueError(f"{joint!r} is not a pin with clearance; those with clearance: {known}")
    scale, length = length_unit(form["clearance"])
    c = form["clearance"] * scale
    x, y, normal = pin_path(result, joint)
    x, y = x * scale, y * scale
    given, ax = ax, ax if ax is not None else new_axes(6.4, 5.4)[0]

    ax.add_patch(Circle((0, 0), c, facecolor=BORE, edgecolor=GREY, linewidth=0.8, zorder=0))
    ax.plot([0], [0], "+", color=GREY, markersize=8)
    size = np.abs(normal)
    top = float(np.percentile(size, 99.9)) or 1.0
    segments = np.stack([np.column_stack([x[:-1], y[:-1]]), np.column_stack([x[1:], y[1:]])], axis=1)
    strength = np.maximum(size[:-1], size[1:])
    order = np.argsort(strength, kind="stable")
    lines = LineCollection(list(segments[order]), cmap="cividis_r", norm=Normalize(0, top))
    lines.set_linewidth(4.0 if form["contact"] == "massless-link" else 1.2)
    lines.set_array(strength[order])
    lines.set_capstyle("round")
    ax.add_collection(lines)
    bar = figure_of(ax).colorbar(lines, ax=ax, extend="max" if size.max() > top else "neither", shrink=0.85, pad=0.03)
    bar.set_label("size of the normal force [N], largest on top")

    ax.plot(x[:1], y[:1], "o", markerfacecolor="white", markeredgecolor=BLACK, markersize=7, label="start")
    pulls = normal < 0
    if pulls.any():
        mark_pulling(ax, np.arctan2(y[pulls], x[pulls]), c)
    mark_impacts(ax, result, joint, scale)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3, frameon=False, fontsize=9)
    limit = 1.22 * max(c, float(np.hypot(x, y).max()))
    ax.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
    ax.set_xlabel(f"pin centre from bush centre, x [{length}]")
    ax.set_ylabel(f"y [{length}]")
    ax.set_title(f"{joint}: orbit of the pin, clearance {c:.4g} {length}", fontsize=11, loc="left", pad=18)
    if shade_after_horizon(ax, result, draw=False):
        note(ax, f"t = {result.t[0]:g} to {result.t[-1]:g} s; after t = {result.trust.horizon:.3g} s statistics only")
    return drawn(ax, given)


def mark_pulling(ax: Axes, direction: Array, c: float) -> None:
    """A tick outside the circle for every instant; many ticks at one place make it dark."""
    from matplotlib.collections import LineCollection

    radii = np.array([1.06, 1.14]) * c
    ticks = np.stack([np.outer(np.cos(direction), radii), np.outer(np.sin(direction), radii)], axis=2)
    alpha = float(np.clip(100 / len(ticks), 0.06, 1))
    ax.add_collection(LineCollection(list(ticks), colors=RED, linewidths=1.2, alpha=alpha))
    ax.plot([], [], color=RED, linewidth=2, label="N < 0: the bush would have to pull")


def mark_impacts(ax: Axes, result: Result, joint: str, scale: float, colour: str = RED, largest: float = 60.0) -> None:
    """A dot on the circle for every impact, its area as the impulse; a ring where a lasting contact starts.

    scale: of lengths, from metres.  largest: area of the largest dot [points^2].
    """
    if len(result.t) < 2:
        return
    mine = [event for event in result.events if event.joint == joint]
    hits = [event for event in mine if event.kind == "impact" and event.impulse > 0.0]
    lasting = [event for event in mine if event.kind == "contact"]
    if lasting:
        label = f"{len(lasting)} contact{'s' if len(lasting) > 1 else ''}"
        style = {"facecolors": "none", "edgecolors": BLACK, "linewidths": 0.8, "alpha": 0.6, "zorder": 4}
        x, y = _on_circle(result, joint, [event.t for event in lasting])
        ax.scatter(scale * x, scale * y, s=0.35 * largest, label=label, **style)  # type: ignore[arg-type]  # matplotlib takes arrays
    if hits:
        strength = np.array([event.impulse for event in hits])
        style = {"color": colour, "alpha": 0.45, "linewidths": 0, "zorder": 4}
        label = f"{len(hits)} impact{'s' if len(hits) > 1 else ''}, up to {strength.max():.2g} N·s"
        x, y = _on_circle(result, joint, [event.t for event in hits])
        area = np.maximum(largest * strength / strength.max(), 1.0)
        ax.scatter(scale * x, scale * y, s=area, label=label, **style)  # type: ignore[arg-type]  # matplotlib takes arrays


def _on_circle(result: Result, joint: str, times: Sequence[float]) -> tuple[Array, Array]:
    """Directions of a pin at some times, on its clearance circle [m]."""
    x, y = (np.interp(np.array(times), result.t, result[f"{joint}.{what}"]) for what in ("ex", "ey"))
    reach = np.hypot(x, y) / result.geometry["joints"][joint]["clearance"]
    reach[reach == 0.0] = 1.0
    return x / reach, y / reach


def pin_path(result: Result, joint: str) -> tuple[Array, Array, Array]:
    """Pin centre and normal force; on a massless link the arcs between instants are filled in."""
    x, y, normal = (result[f"{joint}.{what}"] for what in ("ex", "ey", "normal"))
    if result.geometry["joints"][joint]["contact"] != "massless-link" or len(x) < 2:
        return x, y, normal
    angle, radius = np.unwrap(np.arctan2(y, x)), np.hypot(x, y)
    pieces = 8
    coarse = np.arange(len(x))
    fine = np.linspace(0, len(x) - 1, pieces * (len(x) - 1) + 1)
    angle, radius, normal = (np.interp(fine, coarse, values) for values in (angle, radius, normal))
    return radius * np.cos(angle), radius * np.sin(angle), normal


def clearance_joints(result: Result) -> dict[str, Any]:
    """The pins whose play the result shows: joint name -> its entry in the geometry."""
    pins = {name: form for name, form in result.geometry["joints"].items() if form["type"] == "revolute"}
    loose = {name: form for name, form in pins.items() if form["clearance"] > 0 and form["contact"] != "ideal"}
    return {name: form for name, form in loose.items() if f"{name}.ex" in result}


def length_unit(clearance: float) -> tuple[float, str]:
    """Factor from metres and the unit in which a clearance is a handy number."""
    return (1e3, "mm") if clearance >= 1e-4 else (1e6, "µm")


# ---------------------------------------------------------------- common to all pictures
def new_figure(width: float, height: float) -> Figure:
    """An empty figure [inches] of its own, without the global state of pyplot; it shows itself in a notebook."""
    from rattle.plots.figure import Page

    return Page(width, height)


def new_axes(width: float, height: float, rows: int = 1, columns: int = 1) -> list[Axes]:
    """Axes of a new figure [inches], row by row, with one time axis."""
    figure = new_figure(width, height)
    return [tidy(ax) for ax in figure.subplots(rows, columns, sharex=True, squeeze=False).flat]


def tidy(ax: Axes) -> Axes:
    """The look that all pictures share."""
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(True, color=LINES, linewidth=0.5)
    ax.set_axisbelow(True)
    return ax


def figure_of(ax: Axes) -> Figure:
    """The figure an axis belongs to."""
    figure = ax.get_figure(root=True)
    if figure is None:
        raise ValueError("this axis belongs to no figure")
    return figure


def drawn(ax: Axes, given: Axes | None) -> Figure | Axes:
    """What a picture returns: its own figure, or the axes it was told to draw into (a notebook shows those once)."""
    return figure_of(ax) if given is None else given


def axis_label(quantity: str, unit: str) -> str:
    """`quantity [unit]` with the unit as one prints it."""
    printed = unit.replace("*", "·").replace("^2", "²").replace("^3", "³")
    return f"{quantity} [{printed}]" if printed else quantity


def note(ax: Axes, text: str, side: Literal["left", "right"] = "right") -> None:
    """A small grey line above the axis, at one of its ends."""
    place = (0 if side == "left" else 1, 1)
    ax.annotate(text, place, (0, 3), "axes fraction", "offset points", color=GREY, fontsize=8, ha=side, va="bottom")


def shade_after_horizon(ax: Axes, result: Result, draw: bool = True) -> bool:
    """Shade what lies after the horizon; True if anything does."""
    horizon, end = result.trust.horizon, result.trust.t_end
    if horizon is None or horizon >= end:
        return False
    if draw:
        ax.axvspan(horizon, end, color=SHADE, linewidth=0, zorder=0)
        ax.axvline(horizon, color=GREY, linewidth=0.8, linestyle=":", zorder=1)
    return True


def robust_limits(ax: Axes, curves: Sequence[Array], side: Literal["left", "right"] = "left") -> bool:
    """Keep rare spikes from flattening the curve; True if something is cut off, and then a note says so.

    A limit moves in only where the extreme lies far outside the middle 99 % of the values.
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
    reach = " and ".join(f"{float(f'{v:.3g}'):g}" for v, cut in ((least, cut_low), (most, cut_high)) if cut)
    note(ax, f"spikes cut off: they reach {reach}".replace("-", "\N{MINUS SIGN}"), side)
    return True


def save_figure(figure: Figure, path: str | os.PathLike[str], dpi: float = 150) -> None:
    """Write a figure as .svg, .png or .pdf; raises ValueError for another suffix."""
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise ValueError(f"{os.fspath(path)}: a picture needs a name ending in {', '.join(SUFFIXES)}")
    with atomic(path) as file:
        figure.savefig(file, dpi=dpi, format=suffix[1:])
