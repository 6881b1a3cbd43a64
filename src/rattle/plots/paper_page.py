"""The paper's four-bar with and without play: its Figures 3 to 12 on one page, orbits, a table and an animation.

Source: Grigore, Jderu, Enachescu, Application to the Motion and Equilibrium of the Planar Kinematic
Chains with Rotational Links with Clearances (2015).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rattle.plots.curves import (
    BLACK,
    BLUE,
    RED,
    SHADE,
    figure_of,
    mark_largest,
    new_axes,
    robust_limits,
    save_figure,
    shade_after_horizon,
)
from rattle.plots.demo_page import folder_for, trust_lines
from rattle.plots.orbit import clearance_joints
from rattle.results.contact_summary import joint_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.result import Result

EXAMPLE = "fourbar"
FINE = 20_001  # outputs of the figures: the sharpest peaks of N are 0.3 ms wide


class Panel(NamedTuple):
    """One figure of the paper: its curve is `factor` times the result's `name`."""

    number: int
    symbol: str
    name: str
    unit: str
    factor: float = 1.0
    no_play: str = ""  # the curve of the mechanism without play, if it has another name


DEGREES = 180 / np.pi
PANELS = (
    Panel(3, "θ₂", "coupler.angle", "deg", DEGREES),
    Panel(4, "θ₃", "rocker.angle", "deg", DEGREES),
    Panel(5, "X₂", "coupler.x", "m"),
    Panel(6, "Y₂", "coupler.y", "m"),
    Panel(7, "X₃", "rocker.x", "m"),
    Panel(8, "Y₃", "rocker.y", "m"),
    Panel(9, "H₂", "O2.fx", "N", -1.0),
    Panel(10, "V₂", "O2.fy", "N", -1.0),
    Panel(11, "N₃", "O3.normal", "N", 1.0, "O3.force"),
    Panel(12, "N₄", "O4.normal", "N", 1.0, "O4.force"),
)


def paper_page(with_clearance: Result, ideal: Result) -> Figure:
    """The paper's Figures 3 to 12 on one page; the mechanism without play is dashed.

    The paper's N is a force along the clearance [N]; for the ideal mechanism the magnitude of its reaction is drawn.
    """
    axes = new_axes(11.0, 13.5, rows=5, columns=2)
    for ax, panel in zip(axes, PANELS, strict=True):
        _panel(ax, panel, with_clearance, ideal)
    for ax in axes[-2:]:
        ax.set_xlabel("time [s]")
    _head(figure_of(axes[0]), with_clearance)
    return figure_of(axes[0])


def _panel(ax: Axes, panel: Panel, play: Result, ideal: Result) -> None:
    curve = panel.factor * play[panel.name]
    other = panel.factor * ideal[panel.no_play or panel.name]
    ax.plot(play.t, curve, color=BLUE, linewidth=0.8)
    ax.plot(ideal.t, other, color=BLACK, linewidth=1.1, linestyle=(0, (5, 2)))
    if panel.name.endswith(".normal"):
        ax.axhline(0, color=RED, linewidth=0.9)
    ax.set_title(f"Figure {panel.number}   {panel.symbol}", loc="left", fontsize=11)
    ax.set_ylabel(f"{panel.symbol} [{panel.unit}]")
    ax.margins(x=0.0)
    shade_after_horizon(ax, play)
    tops = mark_largest(ax, play, panel.name, BLUE, panel.factor)
    robust_limits(ax, [curve, other, tops], side="right")


def _head(figure: Figure, play: Result) -> None:
    """What the page shows, and what its lines and shades mean."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    pins = clearance_joints(play)
    size = ", ".join(f"{form['clearance'] * 1e3:g} mm in {joint}" for joint, form in pins.items())
    keys: list[Line2D | Patch] = [
        Line2D([], [], color=BLUE, label="with play"),
        Line2D([], [], color=BLACK, linestyle=(0, (5, 2)), label="without play (11, 12: |reaction|)"),
        Line2D([], [], color=RED, label="N = 0: below it the bush would have to pull"),
    ]
    horizon = play.trust.horizon
    if horizon is not None and horizon < play.trust.t_end:
        keys.append(Patch(color=SHADE, label=f"after the horizon, t > {horizon:.3g} s: statistics only"))
    legend = figure.legend(handles=keys, loc="outside upper center", ncols=len(keys), frameon=False, fontsize=9)
    legend.set_title(f"The paper's four-bar with play: {size}", FontProperties(size=13))


def run_demo(folder: str | os.PathLike[str], *, why: bool = False) -> tuple[list[Path], str]:
    """Run the shipped four-bar with and without play and write page, orbits, CSV and GIF into `folder`.

    Returns the files written and a table of joint forces [N] with the trust lines; why: with its reasons.
    Raises OSError if the folder cannot be made or written.
    """
    import rattle

    place = folder_for(folder)
    mechanism = rattle.example(EXAMPLE)
    play, ideal = mechanism.simulate().whole(), mechanism.ideal().simulate(horizon=True).whole()
    times = np.linspace(0.0, play.trust.t_end, FINE)
    drawn = mechanism.simulate(t_eval=times, horizon=True).whole()
    writers: dict[str, Callable[[Path], object]] = {
        f"{EXAMPLE}-figures.png": partial(save_figure, paper_page(drawn, ideal)),
        **{f"orbit-{pin}.png": partial(save_figure, drawn.plot_orbit(pin)) for pin in clearance_joints(drawn)},
        f"{EXAMPLE}.csv": play.to_csv,
        f"{EXAMPLE}.gif": play.animate,
    }
    for name, write in writers.items():
        write(place / name)
    parts = [
        f"{title}\n{joint_table(r)}\n{trust_lines(r, why)}"
        for title, r in (("with play", drawn), ("without play", ideal))
    ]
    return [place / name for name in writers], "\n\n".join(parts)
