"""Pictures of a journal bearing: chart of its positions, where the pin is, and the Stribeck curve."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rattle.plots.curves import (
    BLACK,
    BLUE,
    BORE,
    GREEN,
    GREY,
    LINES,
    ORANGE,
    RED,
    SHADE,
    axis_label,
    new_figure,
    note,
    tidy,
)  # fmt: skip
from rattle.results.handy_units import DEGREES, handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.film.bearing import Film
    from rattle.questions.film.journal import JournalPosition
    from rattle.questions.film.locus import Columns
    from rattle.results.result import Result

ECCENTRICITIES = np.concatenate(
    [np.geomspace(1e-3, 0.06, 14), np.linspace(0.08, 0.94, 38), 1.0 - np.geomspace(0.055, 1e-3, 24)]
)
MARKED = (0.1, 0.3, 0.5, 0.7, 0.9)  # eccentricities that are written on the path


class LoadPoints(NamedTuple):
    """Where a joint of a mechanism is, at every output with a turning film and a load: arrays (n,)."""

    sommerfeld: np.ndarray
    eccentricity: np.ndarray
    attitude: np.ndarray  # from the load to the line of centres, in the sense of the mean rate, -pi to pi [rad]
    joint: str


def load_points(result: Result, joint: str) -> LoadPoints:
    """The points of a joint with oil.  Raises UnknownName."""
    s, e, fx, fy, ex, ey = (
        result[f"{joint}.{key}"] for key in ("sommerfeld", "eccentricity", "film_fx", "film_fy", "ex", "ey")
    )
    a, b = (
        result[f"{body}.omega"] if body != "ground" else np.zeros(len(result.t))
        for body in result.geometry["joints"][joint]["bodies"]
    )
    turned = np.arctan2(ey, ex) - np.arctan2(-fy, -fx)
    angle = np.sign(a + b) * np.arctan2(np.sin(turned), np.cos(turned))
    defined = np.isfinite(s) & (s > 0.0) & (e > 0.0)
    return LoadPoints(s[defined], e[defined], angle[defined], joint)


def plot_film(film: Film, position: JournalPosition | None, points: LoadPoints | None = None) -> Figure:
    """The chart of a film, with the point of a load if there is one, and the points of a joint."""
    from rattle.questions.film.locus import locus

    curves = locus(film, [float(e) for e in ECCENTRICITIES], coefficients=False)
    figure = new_figure(9.6, 5.2)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.25, 1.0))
    top = tidy(figure.add_subplot(grid[0, 0]))
    below = tidy(figure.add_subplot(grid[1, 0], sharex=top))
    top.semilogx(curves["sommerfeld"], curves["eccentricity"], color=BLUE)
    top.set(ylabel="eccentricity e/c", ylim=(0.0, 1.02))
    below.semilogx(curves["sommerfeld"], DEGREES * curves["attitude"], color=BLUE)
    below.set(ylabel=axis_label("attitude", "deg"), ylim=(0.0, 92.0), yticks=(0, 30, 60, 90))
    below.set_xlabel("Sommerfeld number S = µ N (2 R L/W) (R/c)²")
    below.set_xlim(*_decades(curves["sommerfeld"], position))
    if points is not None:
        dots: dict[str, Any] = {"color": ORANGE, "linestyle": "none", "marker": ".", "markersize": 3, "zorder": 1}
        top.plot(points.sommerfeld, points.eccentricity, **dots)
        below.plot(points.sommerfeld, DEGREES * points.attitude, **dots)
        below.set(ylim=(-180.0, 180.0), yticks=(-180, -90, 0, 90, 180))
        note(top, f"dots: {points.joint} at its outputs; beside the line oil is squeezed")
    top.tick_params(labelbottom=False)
    if position is not None:
        top.plot([position.sommerfeld], [position.eccentricity], "o", color=RED)
        below.plot([position.sommerfeld], [DEGREES * position.attitude], "o", color=RED)
    _clearance(figure.add_subplot(grid[:, 1]), curves, position, points)
    title = f"film '{film.model}', L/D = {film.ratio:.3g}" + (", no cavitation" if film.cavitation == "full" else "")
    top.set_title(title, loc="left", fontsize=11)
    return figure


def _decades(numbers: np.ndarray, position: JournalPosition | None) -> tuple[float, float]:
    """Whole decades that hold the Sommerfeld numbers of eccentricities from 0.02 to 0.99, and that of the load."""
    shown = numbers[(ECCENTRICITIES > 0.02) & (ECCENTRICITIES < 0.992)]
    ends = [float(shown.min()), float(shown.max()), *([position.sommerfeld] if position is not None else [])]
    return 10.0 ** math.floor(math.log10(min(ends))), 10.0 ** math.ceil(math.log10(max(ends)))


def _clearance(ax: Axes, curves: Columns, position: JournalPosition | None, points: LoadPoints | None) -> None:
    """The path of the pin's centre as the load grows, in the circle of the clearance; the load points down."""
    from matplotlib.patches import Circle

    way = -1.0 if position is not None and position.speed < 0.0 else 1.0
    for radius in (1.0, 0.75, 0.5, 0.25):
        edge = BLACK if radius == 1.0 else LINES
        ax.add_patch(Circle((0, 0), radius, facecolor=BORE if radius == 1.0 else "none", edgecolor=edge, zorder=0))
    e, attitude = curves["eccentricity"], curves["attitude"]
    x, y = way * e * np.sin(attitude), -e * np.cos(attitude)
    ax.plot(x, y, color=BLUE)
    if points is not None:
        e_joint, a_joint = points.eccentricity, points.attitude
        ax.plot(way * e_joint * np.sin(a_joint), -e_joint * np.cos(a_joint), ".", color=ORANGE, markersize=3, zorder=1)
    for mark in MARKED:
        a = float(np.interp(mark, e, attitude))
        place = (way * mark * math.sin(a), -mark * math.cos(a))
        ax.plot(*place, ".", color=BLUE, markersize=5)
        aside = (6.0 * way, 3.0) if mark < 0.6 else (7.0 * way, -2.0)
        ax.annotate(
            f"{mark:g}", place, aside, textcoords="offset points", color=BLUE, fontsize=8,
            ha="left" if way > 0.0 else "right",
        )  # fmt: skip
    ax.annotate("", (0, -0.55), (0, 0), arrowprops={"arrowstyle": "-|>", "color": BLACK, "linewidth": 1.2})
    ax.annotate(
        "load", (0, -0.45), (-4 * way, 0), textcoords="offset points", ha="right" if way > 0 else "left", fontsize=9
    )
    turn = np.radians(np.linspace(100.0, 165.0, 30)) if way > 0.0 else np.radians(np.linspace(80.0, 15.0, 30))
    ax.plot(0.85 * np.cos(turn[:-1]), 0.85 * np.sin(turn[:-1]), color=GREY, linewidth=1.0)
    ends = [(0.85 * math.cos(angle), 0.85 * math.sin(angle)) for angle in (turn[-1], turn[-3])]
    ax.annotate("", ends[0], ends[1], arrowprops={"arrowstyle": "-|>", "color": GREY, "linewidth": 1.0})
    ax.text(-0.42 * way, 0.52, "pin", color=GREY, fontsize=9, ha="center")
    if position is not None:
        a, r = position.attitude, position.eccentricity
        place = (way * r * math.sin(a), -r * math.cos(a))
        ax.plot([0.0, place[0]], [0.0, place[1]], color=RED, linewidth=1.0)
        ax.plot(*place, "o", color=RED)
    ax.set(xlim=(-1.08, 1.08), ylim=(-1.08, 1.08), aspect="equal")
    ax.set_axis_off()
    ax.set_title("centre of the pin in the clearance, e/c", fontsize=10)
    if position is not None:
        ax.text(0.5, -0.02, _told(position), transform=ax.transAxes, ha="center", va="top", fontsize=9, color=RED)


def _told(position: JournalPosition) -> str:
    """The point of the load in words."""
    factor, unit = handy_unit("m", position.film_thickness)
    return (
        f"{position.load:.4g} N at {abs(position.speed):.4g} rad/s: e/c = {position.eccentricity:.3f},"
        f" least film {factor * position.film_thickness:.3g} {unit}"
    )


def plot_stribeck(film: Film, columns: dict[str, np.ndarray], load: float, boundary: float) -> Figure:
    """Two panels over the speed [rad/s]; shaded: where the dry contact carries too.  load [N], boundary film [m]."""
    speed, friction = columns["speed"], columns["friction"]
    figure = new_figure(8.0, 6.0)
    grid = figure.add_gridspec(2, 1, height_ratios=(1.5, 1.0))
    top = tidy(figure.add_subplot(grid[0]))
    below = tidy(figure.add_subplot(grid[1], sharex=top))
    top.loglog(speed, friction, color=BLUE)
    top.set_ylabel("coefficient of friction")
    factor, unit = handy_unit("m", float(columns["film_thickness"].max()))
    below.loglog(speed, factor * np.maximum(columns["film_thickness"], 1e-3 * boundary), color=GREEN)
    below.axhline(factor * boundary, color=GREY, linewidth=0.8, linestyle="--")
    below.set_ylabel(axis_label("least film", unit))
    below.set_xlabel("speed of the pin [rad/s]")
    top.tick_params(labelbottom=False)
    mixed = columns["dry"] > 0.0
    if mixed.any():
        last = float(speed[mixed].max())
        for ax in (top, below):
            ax.axvspan(float(speed.min()), last, color=SHADE, linewidth=0, zorder=0)
        note(top, f"shaded: the dry contact carries too, up to {last:.3g} rad/s")
    note(below, "dashed: boundary film")
    top.set_xlim(float(speed.min()), float(speed.max()))
    least = int(np.argmin(friction))
    lowest = f"least friction {friction[least]:.2g} at {speed[least]:.3g} rad/s"
    title = f"film '{film.model}', L/D = {film.ratio:.3g}, {load:.4g} N: {lowest}"
    top.set_title(title, loc="left", fontsize=11, pad=18)
    return figure
