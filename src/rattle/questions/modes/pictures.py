"""Picture of a mode: the mechanism in equilibrium and at both ends of the vibration."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import (
    BLUE,
    GREY,
    ORANGE,
    length_axes,
    new_figure,
    tidy,
)
from rattle.plots.scene import Scene
from rattle.plots.sketch import draw_mechanism, extent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.modes.compute import Modes
    from rattle.results.result import Result


def plot_mode(modes: Modes, mode: int, amplitude: float = 0.1) -> Figure:
    """The mechanism in equilibrium (grey) with joints, guides and springs, and its bodies at both ends of a swing.

    mode: counted from 0.  amplitude: largest displacement as a share of the mechanism's size.
    """
    motion = modes.motion(mode, amplitude)
    figure = new_figure(6.4, 5.4)
    ax = tidy(figure.subplots())
    half = len(motion.t) // 2
    stage = Scene(modes.equilibrium.result, np.array([0]), 1.0, (GREY,))
    low, high = extent(stage)
    stage = stage._replace(size=float(max(high - low)) or 1.0)
    draw_mechanism(ax, stage)
    ax.plot([], [], color=GREY, linewidth=5, alpha=0.75, label="equilibrium")
    for k, colour, label in ((0, BLUE, "one end of the swing"), (half, ORANGE, "the other")):
        _draw(ax, motion, k, colour, label)
    ax.set_aspect("equal", adjustable="datalim")
    length_axes(ax, stage.size)
    ax.set_title(f"mode {mode + 1}: {modes.behaviour(mode, 4)}", loc="left", fontsize=11)
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, frameon=False, fontsize=9)
    return figure


def _draw(ax: Axes, result: Result, k: int, colour: str, label: str) -> None:
    """Every body as lines between its points; a body with one point as a line to its mass centre."""
    shown: str | None = label
    for body, form in result.geometry["bodies"].items():
        points = list(form["points"])
        x = [float(result[f"{body}.{p}.x"][k]) for p in points]
        y = [float(result[f"{body}.{p}.y"][k]) for p in points]
        if len(points) < 2:  # its mass centre is all there is besides
            x, y = [*x, float(result[f"{body}.x"][k])], [*y, float(result[f"{body}.y"][k])]
        closed = [*range(len(x)), 0] if len(x) > 2 else list(range(len(x)))
        across, up = [x[n] for n in closed], [y[n] for n in closed]
        ax.plot(across, up, "o-", color=colour, linewidth=1.6, markersize=4, label=shown, zorder=7)
        shown = None
