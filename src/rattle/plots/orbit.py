"""Paths: the orbit of a pin in its bush, coloured by the normal force, and the paths of points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from rattle import registry
from rattle.errors import InputError
from rattle.plots.bulk import short
from rattle.plots.curves import (
    BLACK,
    BORE,
    CURVES,
    GREY,
    RED,
    Array,
    axis_label,
    drawn,
    figure_of,
    new_axes,
    note,
    shade_after_horizon,
)
from rattle.plots.oil_orbit import draw_oil_orbit
from rattle.results.handy_units import handy_unit, units_of_result
from rattle.results.within_steps import cut, largest, shown_limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.event import Event
    from rattle.results.result import Result


@overload
def plot_path(result: Result, *points: str, ax: None = None) -> Figure: ...


@overload
def plot_path(result: Result, *points: str, ax: Axes) -> Axes: ...


def plot_path(result: Result, *points: str, ax: Axes | None = None) -> Figure | Axes:
    """Paths of points such as "coupler.P" (or of mass centres, "coupler") in the plane [m or mm], a ring at the start.

    ax: draw there.  Returns a new figure, or `ax` if it is given.
    Raises UnknownName, or ValueError without a point.
    """
    if not points:
        raise InputError("name at least one point, such as 'coupler.P'")
    for name in points:
        require_point(result, name)
    paths = [(name, result[f"{name}.x"], result[f"{name}.y"]) for name in dict.fromkeys(points)]
    wide = max(float(np.ptp(c[np.isfinite(c)])) if np.isfinite(c).any() else 0.0 for _, *way in paths for c in way)
    factor, unit = handy_unit("m", wide, units_of_result(result.provenance))
    asked, ax = ax, ax if ax is not None else new_axes(6.8, 5.4)[0]
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
    return drawn(ax, asked)


def require_point(result: Result, name: str) -> None:
    """Raise UnknownName if the result has no path of this point or body."""
    points = [name[:-2] for name in result.names if name.endswith(".x") and f"{name[:-1]}y" in result]
    if name not in points:
        from rattle.errors import suggest
        from rattle.results.result import UnknownName

        raise UnknownName(f"the result has no point or body {name!r}{suggest(name, points)}")


@overload
def plot_orbit(result: Result, joint: str, ax: None = None) -> Figure: ...


@overload
def plot_orbit(result: Result, joint: str, ax: Axes) -> Axes: ...


def plot_orbit(result: Result, joint: str, ax: Axes | None = None) -> Figure | Axes:
    """Path of the pin centre in the clearance circle of a joint, coloured by the normal force [N].

    A pin in oil is coloured by the largest pressure in its film: a red ring is the boundary film, dots are every
    10 degrees of the driven joint, a diamond is where the film is thinnest; the last turn is drawn thick.

    Larger forces lie on top of smaller ones.  Ticks outside the circle show where N < 0, that is,
    where the bush would have to pull; dots on the circle are impacts, with an area proportional to the impulse;
    rings show where a contact that lasts begins.
    ax: draw there.  Returns a new figure, or `ax` if it is given.
    Raises InputError if the joint is not a pin with clearance in a bush.
    """
    form = clearance_joints(result).get(joint)
    if form is None:
        pins = ", ".join(clearance_joints(result)) or "none"
        raise InputError(f"no orbit of {joint!r}: orbits are drawn for pins with clearance in a bush; here: {pins}")
    scale, length = handy_unit("m", form["clearance"])
    c = form["clearance"] * scale
    x, y, normal = pin_path(result, joint)
    x, y = x * scale, y * scale
    asked, ax = ax, ax if ax is not None else new_axes(6.4, 5.4)[0]

    oiled = f"{joint}.film_pressure" in result
    if oiled:
        draw_oil_orbit(ax, result, joint, scale)
    else:
        _coloured_by_force(ax, result, joint, x, y, normal, c, scale)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2 if oiled else 3, frameon=False, fontsize=9)
    limit = 1.22 * max(c, float(np.hypot(x, y).max()))
    ax.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
    ax.set_xlabel(axis_label("pin centre from bush centre, x", length))
    ax.set_ylabel(axis_label("y", length))
    where = "in oil, " if oiled else ""
    ax.set_title(f"{joint}: orbit of the pin, {where}clearance {c:.4g} {length}", fontsize=11, loc="left", pad=18)
    if shade_after_horizon(ax, result, draw=False):
        note(ax, f"t = {result.t[0]:g} to {result.t[-1]:g} s; after t = {result.trust.horizon:.3g} s statistics only")
    return drawn(ax, asked)


def _coloured_by_force(
    ax: Axes, result: Result, joint: str, x: Array, y: Array, normal: Array, c: float, scale: float
) -> None:
    """The path x, y (n,) of a dry pin in its circle of radius c, all in the unit of the axes; normal (n,) [N]."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize
    from matplotlib.patches import Circle

    form = clearance_joints(result)[joint]
    ax.add_patch(Circle((0, 0), c, facecolor=BORE, edgecolor=GREY, linewidth=0.8, zorder=0))
    ax.plot([0], [0], "+", color=GREY, markersize=8)
    told = cut(result, f"{joint}.normal")
    size = np.minimum(np.abs(normal), shown_limit(result, f"{joint}.normal"))
    top, most = float(np.nanpercentile(size, 99.9)) or 1.0, largest(result, f"{joint}.normal")
    many, unit = handy_unit("N", most)
    segments = np.stack([np.column_stack([x[:-1], y[:-1]]), np.column_stack([x[1:], y[1:]])], axis=1)
    strength = np.maximum(size[:-1], size[1:])
    order = np.argsort(strength, kind="stable")
    lines = LineCollection(list(segments[order]), cmap="cividis_r", norm=Normalize(0, many * top))
    lines.set_linewidth(4.0 if form["contact"] == "massless-link" else 1.2)
    lines.set_array(many * strength[order])
    lines.set_capstyle("round")
    ax.add_collection(lines)
    beyond = most > top
    bar = figure_of(ax).colorbar(lines, ax=ax, extend="max" if beyond or told else "neither", shrink=0.85, pad=0.03)
    reach = f", {told}" if told else f", up to {short(many * most, 4)} {unit}" if beyond else ""
    bar.set_label(f"{axis_label('magnitude of the normal force', unit)}\nlargest on top{reach}")

    ax.plot(x[:1], y[:1], "o", markerfacecolor="white", markeredgecolor=BLACK, markersize=7, label="start")
    pulls = normal < 0
    if pulls.any():
        mark_pulling(ax, np.arctan2(y[pulls], x[pulls]), c)
    mark_impacts(ax, result, joint, scale)


def mark_pulling(ax: Axes, direction: Array, c: float) -> None:
    """A tick outside the circle for each direction; many ticks at one place make it dark.

    direction: (n,) angles of the pin [rad].  c: radius of the circle in the unit of the axis.
    """
    from matplotlib.collections import LineCollection

    radii = np.array([1.06, 1.14]) * c
    ticks = np.stack([np.outer(np.cos(direction), radii), np.outer(np.sin(direction), radii)], axis=2)
    alpha = float(np.clip(100 / len(ticks), 0.06, 1))
    ax.add_collection(LineCollection(list(ticks), colors=RED, linewidths=1.2, alpha=alpha))
    ax.plot([], [], color=RED, linewidth=2, label="N < 0: the bush would have to pull")


def mark_impacts(ax: Axes, result: Result, joint: str, scale: float, colour: str = RED, largest: float = 60.0) -> None:
    """A dot on the circle for every impact, its area proportional to the impulse; a ring where a contact that lasts
    begins.

    scale: from metres to the unit of the axis.  largest: area of the largest dot [points^2].
    """
    if len(result.t) < 2:
        return
    mine = [event for event in result.events if event.joint == joint]
    hits = [event for event in mine if event.kind == "impact" and event.impulse > 0.0]
    lasting = [event for event in mine if event.kind == "contact"]
    if lasting:
        label = f"{len(lasting)} contact{'s' if len(lasting) > 1 else ''}"
        style = {"facecolors": "none", "edgecolors": BLACK, "linewidths": 0.8, "alpha": 0.6}
        _scatter(ax, _on_circle(result, joint, lasting), scale, 0.35 * largest, label, style)
    if hits:
        strength = np.array([event.impulse for event in hits])
        label = f"{len(hits)} impact{'s' if len(hits) > 1 else ''}, up to {strength.max():.2g} N·s"
        area = np.maximum(largest * strength / strength.max(), 1.0)
        style = {"color": colour, "alpha": 0.45, "linewidths": 0}
        _scatter(ax, _on_circle(result, joint, hits), scale, area, label, style)


def _scatter(
    ax: Axes, at: tuple[Array, Array], scale: float, area: float | Array, label: str, style: Mapping[str, Any]
) -> None:
    x, y = at
    ax.scatter(scale * x, scale * y, s=area, label=label, zorder=4, **style)


def _on_circle(result: Result, joint: str, events: Sequence[Event]) -> tuple[Array, Array]:
    """Places on the clearance circle [m] in the direction of the pin at some events."""
    times = [event.t for event in events]
    x, y = (np.interp(times, result.t, result[f"{joint}.{what}"]) for what in ("ex", "ey"))
    reach = np.hypot(x, y) / result.geometry["joints"][joint]["clearance"]
    reach[reach == 0.0] = 1.0
    return x / reach, y / reach


def pin_path(result: Result, joint: str) -> tuple[Array, Array, Array]:
    """Pin centre x, y [m] and normal force [N], (n,) each; on a massless link with the arcs between the outputs."""
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
    """Joints in a result whose play is a circle: joint name -> its entry in the geometry."""
    plays = {name: registry.play_of(form["type"]) for name, form in result.geometry["joints"].items()}
    pins = {name: result.geometry["joints"][name] for name, play in plays.items() if play and play.leaf.orbit}
    loose = {name: form for name, form in pins.items() if form["clearance"] > 0 and form["contact"] != "ideal"}
    return {name: form for name, form in loose.items() if f"{name}.ex" in result}
