"""Revolute joint: a circle, dark if it is driven, with a ring if it has play and a foot on the ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.plots.curves import BLACK, GREY
from rattle.plots.drawings import Part, drawing
from rattle.plots.movie_file import Update
from rattle.plots.scene import Scene, draw_dot, draw_foot

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@drawing("pin", name_at=0.0)
def pin(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one pin."""
    form = part.form
    path = scene.ends(form)[0]
    updates = [draw_dot(ax, path, markersize=7, markerfacecolor=BLACK if part.driven else "white")]
    if form["clearance"] > 0.0 and form["contact"] != "ideal":
        style = {"markersize": 12, "markeredgewidth": 0.9, "markerfacecolor": "none"}
        updates.append(draw_dot(ax, path, color=GREY, **style))
    if "ground" in form["bodies"]:
        draw_foot(ax, form["points"][form["bodies"].index("ground")], 0.045 * scene.size)
    return updates
