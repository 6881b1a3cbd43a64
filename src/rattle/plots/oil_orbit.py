"""Path of a pin in its oil film: pressure as colour, the boundary film as a ring, dots for the angle of the crank."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.plots.curves import BLACK, BORE, GREY, RED, Array, axis_label, figure_of
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rattle.results.result import Result

DOT = 10  # degrees of the crank from dot to dot
NAMED = 90  # degrees of the crank from one dot with its angle to the next
FAINT = 0.35  # opacity of the turns before the last
FINEST = 0.004  # thickness over clearance below which the ring of the boundary film is a line


def draw_oil_orbit(ax: Axes, result: Result, joint: str, scale: float) -> None:
    """Draw the path of the pin in the circle of its clearance, with a colour bar and what the legend needs.

    scale: from metres to the unit of the axes.  The last turn of the driver is drawn thick, what was before it thin.
    """
    form = result.geometry["joints"][joint]
    c = form["clearance"] * scale
    _ring(ax, c, form["oil"]["boundary"], scale)
    x, y = scale * result[f"{joint}.ex"], scale * result[f"{joint}.ey"]
    crank = _crank(result)
    last = int(np.searchsorted(crank[1], crank[1][-1] - 2.0 * math.pi - 1e-9)) if crank is not None else 0
    last = min(last, max(len(x) - 2, 0))
    pressure = result[f"{joint}.film_pressure"]
    factor, unit = handy_unit("Pa", float(np.nanmax(pressure)))
    _path(ax, x, y, factor * pressure, last, axis_label("largest pressure in the film", unit))
    _mixed(ax, x, y, result[f"{joint}.regime"])
    ax.plot(x[:1], y[:1], "o", markerfacecolor="white", markeredgecolor=BLACK, markersize=7, label="start")
    if crank is not None and len(x) > last + 2:
        _dots(ax, x[last:], y[last:], crank[1][last:], crank[0])
    _least(ax, result, joint, x, y)


def _ring(ax: Axes, c: float, boundary: float, scale: float) -> None:
    """The circle of the clearance, and inside of it the ring where the film is thinner than the boundary film [m]."""
    from matplotlib.patches import Annulus, Circle, Patch

    ax.add_patch(Circle((0, 0), c, facecolor=BORE, edgecolor=GREY, linewidth=0.8, zorder=0))
    ax.plot([0], [0], "+", color=GREY, markersize=8)
    factor, unit = handy_unit("m", boundary)
    label, thick = f"boundary film, {factor * boundary:.3g} {unit}", scale * boundary
    ring: Patch = Circle((0, 0), c - thick, fill=False, edgecolor=RED, linewidth=0.7, zorder=0.5, label=label)
    if thick > FINEST * c:
        ring = Annulus((0, 0), c, thick, facecolor=RED, alpha=0.25, linewidth=0, zorder=0.5, label=label)
    ax.add_patch(ring)


def _crank(result: Result) -> tuple[str, Array] | None:
    """Name and angle (n,) [rad] of the first driven joint, if it turns one way; else None."""
    for name in result.geometry["driven"]:
        if f"{name}.angle" not in result:
            continue
        angle = result[f"{name}.angle"]
        steps = np.diff(angle)
        if len(steps) and (steps > 0.0).all():
            return name, angle
        return (name, -angle) if len(steps) and (steps < 0.0).all() else None
    return None


def _path(ax: Axes, x: Array, y: Array, strength: Array, last: int, label: str) -> None:
    """The path coloured by `strength`, larger ones on top; thin up to the output `last`."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize

    segments = np.stack([np.column_stack([x[:-1], y[:-1]]), np.column_stack([x[1:], y[1:]])], axis=1)
    height = np.maximum(strength[:-1], strength[1:])
    norm = Normalize(0, float(np.nanmax(strength, initial=0.0)) or 1.0)
    shown: Any = None
    for part, width, alpha in ((slice(0, last), 0.8, FAINT), (slice(last, None), 2.4, 1.0)):
        order = np.argsort(height[part], kind="stable")
        shown = LineCollection(list(segments[part][order]), cmap="cividis_r", norm=norm, alpha=alpha)
        shown.set_linewidth(width)
        shown.set_array(height[part][order])
        shown.set_capstyle("round")
        ax.add_collection(shown)
    figure_of(ax).colorbar(shown, ax=ax, shrink=0.85, pad=0.03).set_label(label)


def _mixed(ax: Axes, x: Array, y: Array, regime: Array) -> None:
    """A red edge where the dry contact carries too."""
    if (regime > 0.0).any():
        part = np.where(regime > 0.0, 1.0, np.nan)
        style: dict[str, Any] = {"color": RED, "linewidth": 4.5, "alpha": 0.5, "zorder": 1.5}
        ax.plot(part * x, part * y, solid_capstyle="round", label="dry contact carries too", **style)


def _dots(ax: Axes, x: Array, y: Array, angle: Array, name: str) -> None:
    """Dots at whole tens of degrees of the driven joint, with numbers at quarters of a turn."""
    from matplotlib.patheffects import withStroke

    degrees = np.degrees(angle)
    marks = np.arange(math.ceil(degrees[0] / DOT - 1e-6), math.floor(degrees[-1] / DOT + 1e-6) + 1) * DOT
    marks = marks[-360 // DOT :]
    px, py = np.interp(marks, degrees, x), np.interp(marks, degrees, y)
    style: dict[str, Any] = {"color": BLACK, "linestyle": "none", "marker": ".", "zorder": 4}
    ax.plot(px, py, markersize=3.5, label=f"every {DOT}° of {name}", **style)
    named = marks % NAMED == 0
    ax.plot(px[named], py[named], markersize=7, **style)
    for mark, u, v in zip(marks[named], px[named], py[named], strict=True):
        away = 11.0 / (math.hypot(u, v) or 1.0)  # outwards [points]
        text = ax.annotate(
            f"{mark % 360:g}°", (u, v), (away * u, away * v), textcoords="offset points", fontsize=8, color=BLACK,
            ha="center", va="center", zorder=6,
        )  # fmt: skip
        text.set_path_effects([withStroke(linewidth=2.0, foreground="white")])


def _least(ax: Axes, result: Result, joint: str, x: Array, y: Array) -> None:
    """A mark where the film is thinnest, with its thickness in the legend."""
    thickness = result[f"{joint}.film_thickness"]
    k = int(np.nanargmin(thickness))
    factor, unit = handy_unit("m", abs(float(thickness[k])))
    label = f"least film, {factor * thickness[k]:.3g} {unit}"
    ax.plot(x[k], y[k], "D", markerfacecolor="white", markeredgecolor=RED, markersize=6, zorder=5, label=label)
