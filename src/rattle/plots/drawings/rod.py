"""Massless rod: a thin bar between two pins."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import GREY
from rattle.plots.drawings import Part, drawing
from rattle.plots.movie_file import Update
from rattle.plots.scene import Scene, draw_dot, draw_foot, draw_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@drawing("rod")
def rod(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one rod."""
    ends = scene.ends(part.form)
    for body, point in zip(part.form["bodies"], part.form["points"], strict=True):
        if body == "ground":
            draw_foot(ax, point, 0.045 * scene.size)
    bar = draw_line(ax, np.stack(ends, axis=1), color=GREY, linewidth=2, zorder=2)
    return [bar, *(draw_dot(ax, end, markersize=6) for end in ends)]
