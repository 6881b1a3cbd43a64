"""What play does to a mechanism, on one page: the demonstration of `rattle demo`."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import BLACK, BLUE, RED, new_figure, save_figure, tidy
from rattle.plots.orbit import clearance_joints, plot_orbit
from rattle.plots.sketch import draw_at
from rattle.results.contact_summary import joint_table
from rattle.user_paths import expanded

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.result import Result

EXAMPLE = "crank_rocker_play"
POINT = "coupler.P"  # whose path the play spoils
MAGNIFIED = 20  # how many times larger its deviation is drawn than it is
DASHED = (0, (5, 2))


def folder_for(folder: str | os.PathLike[str]) -> Path:
    """The folder, made if it is not there.  Raises OSError with a sentence."""
    place = expanded(folder)
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise type(error)(f"cannot make the folder {place}: {error.strerror}") from error
    return place


def deviation(play: Result, ideal: Result) -> tuple[np.ndarray, np.ndarray]:
    """Where the point is with play, less where it would be without, along x and y [m] (n,); at the same instants."""
    x, y = (play[f"{POINT}.{axis}"] - ideal[f"{POINT}.{axis}"] for axis in "xy")
    return x, y


def demo_page(play: Result, ideal: Result) -> Figure:
    """Mechanism and path, deviation of the path, forces, and the pin in its bush; without play dashed."""
    figure = new_figure(12.0, 9.0)
    path_ax, deviation_ax, force_ax, orbit_ax = (figure.add_subplot(2, 2, place) for place in (1, 2, 3, 4))
    _draw_path(path_ax, play, ideal)
    _draw_deviation(deviation_ax, play, ideal)
    _draw_forces(force_ax, play, ideal)
    joint, form = next(iter(clearance_joints(play).items()))
    plot_orbit(play, joint, ax=orbit_ax)
    orbit_ax.set_title(f"the pin of {joint} in its bush", loc="left")
    figure.suptitle(f"Two loose pins: radial play {form['clearance'] * 1e3:g} mm", fontsize=13)
    return figure


def _draw_path(ax: Axes, play: Result, ideal: Result) -> None:
    draw_at(ax, play, 0)
    x, y = (ideal[f"{POINT}.{axis}"] for axis in "xy")
    dx, dy = deviation(play, ideal)
    ax.plot(x, y, color=BLACK, linestyle=DASHED, linewidth=1.1, label="P without play")
    ax.plot(
        x + MAGNIFIED * dx,
        y + MAGNIFIED * dy,
        color=RED,
        linewidth=1.3,
        label=f"with play, its error {MAGNIFIED} times as large",
    )
    ax.set_xlim(left=min(ax.get_xlim()[0], x.min() - 0.05 * np.ptp(x)))
    ax.set_ylim(top=ax.get_ylim()[1] + 0.25 * np.ptp(ax.get_ylim()))  # room for the words
    ax.legend(frameon=False, fontsize=9, loc="upper right")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.set_title("the mechanism and what P draws", loc="left")


def _draw_deviation(ax: Axes, play: Result, ideal: Result) -> None:
    dx, dy = deviation(play, ideal)
    tidy(ax).plot(play.t, 1e3 * np.hypot(dx, dy), color=RED, label="distance")
    ax.plot(play.t, 1e3 * dx, color=BLUE, linewidth=0.9, label="along x")
    ax.plot(play.t, 1e3 * dy, color=BLACK, linewidth=0.9, label="along y")
    ax.set_ylabel("P off its path [mm]")
    ax.set_xlabel("time [s]")
    ax.margins(x=0.0)
    ax.legend(frameon=False, fontsize=9, ncols=3)
    ax.set_title("how far P is off", loc="left")


def _draw_forces(ax: Axes, play: Result, ideal: Result) -> None:
    tidy(ax)
    for joint, colour in zip(clearance_joints(play), (BLUE, RED), strict=False):
        ax.plot(play.t, play[f"{joint}.normal"], color=colour, linewidth=0.9, label=f"pin {joint} on its bush")
        ax.plot(ideal.t, ideal[f"{joint}.force"], color=colour, linewidth=1.1, linestyle=DASHED, label="without play")
    ax.set_ylim(bottom=0.0)
    ax.set_ylabel("force [N]")
    ax.set_xlabel("time [s]")
    ax.margins(x=0.0)
    ax.legend(frameon=False, fontsize=9, ncols=2)
    ax.set_title("forces of the loose pins", loc="left")


def trust_lines(result: Result, why: bool) -> str:
    """How far a result can be trusted, in a word, and what has to be noted or, if asked, why."""
    return "\n".join([result.trust.word, *(result.trust.why if why else result.trust.notes)])


def run_demo(folder: str | os.PathLike[str], *, why: bool = False) -> tuple[list[Path], str]:
    """Run the crank-rocker with and without play, and write a picture, a page that computes, and a table.

    Returns the files written and what is to be said: how far the point is off, the joint forces [N], the trust; why:
    with its reasons.
    Raises OSError if the folder cannot be made or written.
    """
    import rattle

    place = folder_for(folder)
    mechanism = rattle.example(EXAMPLE)
    play, ideal = mechanism.simulate(horizon=True).whole(), mechanism.ideal().simulate().whole()
    writers: dict[str, Callable[[Path], object]] = {
        "crank-rocker.png": partial(save_figure, demo_page(play, ideal)),
        "crank-rocker.html": mechanism.page,
        "crank-rocker.csv": play.to_csv,
    }
    for name, write in writers.items():
        write(place / name)
    off = 1e3 * np.hypot(*deviation(play, ideal))
    size = 1e3 * next(iter(clearance_joints(play).values()))["clearance"]
    largest = max(float(play.peaks[f"{joint}.force"].value) for joint in clearance_joints(play))
    calm = max(float(ideal.peaks[f"{joint}.force"].value) for joint in clearance_joints(play))
    text = (
        f"With a radial play of {size:g} mm in two pins, P is {off.min():.2f} to {off.max():.2f} mm off its path;"
        f" the pins press with up to {largest:.3g} N, without play {calm:.3g} N.\n\n{joint_table(play)}"
        f"\n{trust_lines(play, why)}"
    )
    return [place / name for name in writers], text
