"""Belt: both pulleys to scale, each with a spoke, and the strands that touch them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import BLACK
from rattle.plots.drawings import Form, Part, drawing
from rattle.plots.drawings.gear import GAP, draw_strokes
from rattle.plots.movie_file import Update
from rattle.plots.scene import Array, Pair, Scene, draw_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def around(form: Form) -> list[tuple[str, Pair]]:
    """Points around both pulleys."""
    turns = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    return [
        (body, (x + radius * float(np.cos(turn)), y + radius * float(np.sin(turn))))
        for body, (x, y), radius in zip(form["bodies"], form["points"], form["fields"]["radii"], strict=True)
        for turn in turns
    ]


def pulley(point: Pair, radius: float) -> Array:
    """Strokes (n, 2) [m] of a pulley in the frame of its body."""
    turn = np.linspace(0.0, 2.0 * np.pi, 97)
    circle = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.asarray(np.vstack([circle, GAP, [[0.0, 0.0], [radius, 0.0]]]) + np.array(point))


def strand(one: Array, other: Array, radii: tuple[float, float], crossed: bool, side: float) -> Array:
    """The line (n, 2, 2) [m] that touches both pulleys on one side, from their centres (n, 2)."""
    d = other - one
    length = np.hypot(*d.T)
    share = np.clip((radii[0] + radii[1] if crossed else radii[0] - radii[1]) / np.maximum(length, 1e-300), -1.0, 1.0)
    turn = np.arctan2(d[:, 1], d[:, 0]) + side * np.arccos(share)
    normal = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.stack([one + radii[0] * normal, other + (-1.0 if crossed else 1.0) * radii[1] * normal], axis=1)


@drawing("belt", reach=around, name_at=0.5)
def belt(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw both pulleys of one belt and its strands."""
    form = part.form
    fields = form["fields"]
    one, other = scene.ends(form)
    drawn = [
        draw_strokes(ax, scene, body, pulley(point, radius))
        for body, point, radius in zip(form["bodies"], form["points"], fields["radii"], strict=True)
    ]
    return drawn + [
        draw_line(ax, strand(one, other, fields["radii"], bool(fields["crossed"]), side), color=BLACK, linewidth=1.2)
        for side in (1.0, -1.0)
    ]
