"""Revolute joint: a circle, dark if it is driven, with a ring if it has play and a foot on the ground.

Stops of its angle are short dark marks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import BLACK, GREY
from rattle.plots.drawings import Form, Part, drawing
from rattle.plots.movie_file import Update
from rattle.plots.scene import Array, Scene, draw_dot, draw_foot, draw_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STOP = 0.09  # radius at which stops are marked, as a share of the mechanism's size


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
    return updates + _stops(ax, scene, form)


def _stops(ax: Axes, scene: Scene, form: Form) -> list[Update]:
    """Stops of the angle: marks in the directions that the farthest point of B has there, and the arc between them."""
    (a, b), (point, other) = form["bodies"], form["points"]
    ends = [end for end in form.get("stop", ()) if end is not None]
    if not ends:
        return []
    if b == "ground":
        return _stops(ax, scene, {**form, "bodies": [b, a], "points": [other, point], "stop": [-end for end in ends]})
    arms = scene.points(b) - np.array(other, float)
    far = arms[int(np.argmax(np.hypot(arms[:, 0], arms[:, 1])))] if len(arms) else np.array([1.0, 0.0])
    radius = STOP * scene.size
    turn = scene.angle(a)[:, None] + float(np.arctan2(far[1], far[0]))
    centre = scene.path(a, point)[:, None]

    def polar(r: float | Array, angles: Array) -> Array:
        return np.asarray(centre + r * np.stack([np.cos(angles), np.sin(angles)], axis=2))

    updates = []
    for end in ends:
        mark = np.concatenate([polar(0.5 * radius, turn + end), polar(1.2 * radius, turn + end)], axis=1)
        updates.append(draw_line(ax, mark, color=BLACK, linewidth=3, solid_capstyle="butt", zorder=3.6))
    if len(ends) == 2:
        arc = polar(radius, turn + np.linspace(ends[0], ends[1], 40))
        updates.append(draw_line(ax, arc, color=GREY, linewidth=0.8, zorder=2.5))
    return updates
