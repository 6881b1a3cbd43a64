"""Stribeck's curve of a bearing: friction and thickness of the film over the speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import BLUE, GREEN, GREY, SHADE, axis_label, new_figure, note, tidy
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.studies.film.bearing import Film


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
    said = f"least friction {friction[least]:.2g} at {speed[least]:.3g} rad/s"
    title = f"film '{film.model}', L/D = {film.ratio:.3g}, {load:.4g} N: {said}"
    top.set_title(title, loc="left", fontsize=11, pad=18)
    return figure
