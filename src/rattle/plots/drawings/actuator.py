"""Actuator between two points: a cylinder whose barrel hangs at A and whose rod leads to B."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import BLACK, GREY
from rattle.plots.drawings import Part, drawing
from rattle.plots.drawings.guide import BORE, ROD, Line
from rattle.plots.movie_file import Update
from rattle.plots.scene import Scene, draw_area, draw_dot, draw_foot, draw_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BARREL = 0.6  # of the shortest length


@drawing("actuator")
def actuator(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one actuator."""
    a, b = scene.ends(part.form)
    d = b - a
    length = np.maximum(np.hypot(d[:, 0], d[:, 1]), 1e-12)
    along = d / length[:, None]
    line = Line(a, along, np.column_stack([-along[:, 1], along[:, 0]]))
    for body, point in zip(part.form["bodies"], part.form["points"], strict=True):
        if body == "ground":
            draw_foot(ax, point, 0.045 * scene.size)
    half, end = 0.8 * BORE * scene.size, np.full(len(length), BARREL * length.min())
    barrel = line.outline(np.column_stack([0.0 * length, end]), half)
    rod = line.outline(np.column_stack([end, length]), ROD * scene.size)
    return [
        draw_area(ax, barrel, GREY, alpha=0.35, zorder=2.2),
        draw_line(ax, barrel, color=BLACK, linewidth=1.4, zorder=3.4),
        draw_area(ax, rod, BLACK, alpha=0.8, zorder=3),
        draw_dot(ax, a, markersize=5),
        draw_dot(ax, b, markersize=5),
    ]
