"""Cam: the outline that its function gives, to scale, with a line from its centre, so that turning is seen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import BLACK
from rattle.plots.drawings import Form, Part, drawing, ends
from rattle.plots.drawings.gear import GAP, draw_strokes
from rattle.plots.movie_file import Update
from rattle.plots.scene import Pair, Scene, draw_dot, draw_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EVERY = 12  # of the points of an outline, those that a picture is made large enough for
TURN = np.linspace(0.0, 2.0 * np.pi, 49)  # directions in which a roller is drawn
MORE = 0.1  # of a face beyond where it touches, as a share of the largest reach of the outline


def around(form: Form) -> list[tuple[str, Pair]]:
    """Both ends, and points of the outline."""
    body, (x, y) = form["bodies"][0], form["points"][0]
    return [*ends(form), *((body, (x + one[0], y + one[1])) for one in form.get("outline", ())[::EVERY])]


def draw_outline(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """The outline on its body; of a closed one also a line from the centre to where it begins."""
    form = part.form
    if len(form.get("outline", ())) < 2:
        return []
    outline = np.array(form["outline"])
    closed = float(np.hypot(*(outline[0] - outline[-1]))) < 1e-6 * float(np.abs(outline).max())
    spoke = [GAP, np.zeros((1, 2)), outline[len(outline) // 2 :][:1]] if closed else []
    return [draw_strokes(ax, scene, form["bodies"][0], np.vstack([outline, *spoke]) + np.array(form["points"][0]))]


@drawing("cam", reach=around, name_at=1.0)
def cam(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one cam, with the roller that follows it, to scale, or with a dot for a point."""
    form = part.form
    updates = draw_outline(ax, scene, part)
    if (radius := form["fields"]["roller"]) > 0.0:
        around_it = radius * np.array([np.cos(TURN), np.sin(TURN)]).T + np.array(form["points"][1])
        updates.append(draw_strokes(ax, scene, form["bodies"][1], around_it))
    return [*updates, draw_dot(ax, scene.ends(form)[1], markersize=3 if radius > 0.0 else 6)]


@drawing("flat-follower", reach=around, name_at=1.0)
def flat_follower(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one cam, and the face of its follower as far as the cam may touch it."""
    form = part.form
    centre, point = scene.ends(form)
    turn = scene.angle(form["bodies"][1]) + form["fields"]["axis"]
    along = np.column_stack([-np.sin(turn), np.cos(turn)])
    own = ((centre - point) * along).sum(axis=1)[:, None]
    size = (1.0 + MORE) * float(np.hypot(*np.array(form.get("outline") or [[0.1 * scene.size, 0.0]]).T).max())
    low, high = np.minimum(own - size, 0.0), np.maximum(own + size, 0.0)
    face = np.stack([point + low * along, point + high * along], axis=1)
    return [
        *draw_outline(ax, scene, part),
        draw_line(ax, face, color=scene.colour(form["bodies"][1]), linewidth=2.5, zorder=3),
        draw_line(ax, np.stack([point, point], axis=1), color=BLACK, marker=".", markersize=3, linewidth=0, zorder=4),
    ]
