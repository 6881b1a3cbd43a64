"""Small drawings of mechanisms, to be known again in a list of many."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np

from rattle.drawings.forms import display_list
from rattle.drawings.magnified import BUSH, PIN
from rattle.drawings.played import Stage
from rattle.plots.curves import GREY, SKY, new_figure
from rattle.plots.figure import TEXT
from rattle.plots.orbit import clearance_joints, pin_path
from rattle.plots.scene import Scene
from rattle.plots.sketch import draw_mechanism, draw_shapes, extent, is_a_pin_alone

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rattle.results.result import Result

ROOM = 0.06  # around a drawing, as a share of its size
SIZE = 3.2, 2.0  # [inch]
ACROSS = 200.0  # pixels of a pin that is drawn alone


def thumbnail(result: Result, k: int = 0, path: str = "", salt: str = "") -> str:
    """The mechanism at instant k of a result as a small SVG drawing; of a pin alone its orbit, magnified.

    path: "BODY.POINT" whose path is drawn too.  salt: what makes the names in the drawing its own in a page of many.
    """
    from matplotlib import rc_context

    out = io.StringIO()
    with rc_context({**TEXT, "svg.hashsalt": salt}):
        figure = new_figure(*SIZE)
        figure.set_layout_engine("none")
        ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        ax.axis("off")
        if is_a_pin_alone(Scene(result, np.array([k]), 1.0)):
            _draw_pin(ax, result, k)
        else:
            _draw(ax, result, k, path)
        figure.savefig(out, format="svg", metadata={"Date": None}, transparent=True)
    text = out.getvalue()
    return text[text.index("<svg") :]


def _show(ax: Axes, low: np.ndarray, high: np.ndarray) -> None:
    """Show the box low, high (2,) [m] in the middle."""
    size = np.array(SIZE)
    middle, half = 0.5 * (low + high), 0.5 * float(max((high - low) / size))
    low, high = middle - half * size, middle + half * size
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")


def _draw(ax: Axes, result: Result, k: int, path: str) -> None:
    scene = Scene(result, np.array([k]), 1.0)
    low, high = extent(scene)
    if path:
        x, y = result[f"{path}.x"], result[f"{path}.y"]
        ax.plot(x, y, color=GREY, linewidth=1)
        low, high = np.minimum(low, (x.min(), y.min())), np.maximum(high, (x.max(), y.max()))
    size = float(max(high - low)) or 1.0
    draw_mechanism(ax, scene._replace(size=size), names=False)
    _show(ax, low - ROOM * size, high + ROOM * size)


def _draw_pin(ax: Axes, result: Result, k: int) -> None:
    """Pin and bush, with the path of the pin's centre."""
    scene, written = Scene(result, np.array([k]), 1.0), display_list(result.geometry)
    stage = Stage(written, result.geometry, scene, 1.0, ACROSS)
    for picture in (each for each in written["magnified"] if each["joint"] in clearance_joints(result)):
        for move in draw_shapes(ax, scene, stage.shapes_of(picture["drawn"])):
            move(0)
        x, y, _ = pin_path(result, picture["joint"])
        scale = (1.0 - PIN) * BUSH / result.geometry["joints"][picture["joint"]]["clearance"]
        ax.plot(scale * x, scale * y, color=SKY, linewidth=1, zorder=1)
    _show(ax, np.full(2, -0.5), np.full(2, 0.5))
