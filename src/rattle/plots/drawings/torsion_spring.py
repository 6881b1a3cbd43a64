"""Torsion spring: a spiral about the point of B that goes with A at its outer and with B at its inner end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import GREY
from rattle.plots.drawings import Part, drawing
from rattle.plots.movie_file import Update
from rattle.plots.scene import Scene, draw_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TURNS = 2.5
RADIUS = 0.05  # as a share of the mechanism's size


@drawing("torsion-spring", name_at=1.0)
def torsion_spring(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one torsion spring."""
    a, b = part.form["bodies"]
    along = np.linspace(0.0, 1.0, 90)
    inner, outer = scene.angle(b), scene.angle(a)
    angle = inner[:, None] + along * (2 * np.pi * TURNS + outer - inner)[:, None]
    radius = scene.size * RADIUS * (0.25 + 0.75 * along)
    spiral = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=2)
    return [draw_line(ax, scene.ends(part.form)[1][:, None] + spiral, color=GREY, linewidth=1.1, zorder=2)]
