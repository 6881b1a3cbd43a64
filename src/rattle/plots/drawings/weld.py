"""Fixed joint: a dark square, hatched below if it is on the ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.plots.curves import BLACK
from rattle.plots.drawings import Part, drawing
from rattle.plots.movie_file import Update
from rattle.plots.scene import Scene, draw_dot, draw_wall

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@drawing("weld", name_at=0.0)
def weld(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one fixed joint."""
    form = part.form
    if "ground" in form["bodies"]:
        x, y = form["points"][form["bodies"].index("ground")]
        half = 0.045 * scene.size
        draw_wall(ax, (x - half, y), (x + half, y), 0.3 * half)
    return [draw_dot(ax, scene.ends(form)[0], marker="s", markersize=8, markerfacecolor=BLACK)]
