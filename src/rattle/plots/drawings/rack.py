"""Rack: its pitch line with teeth away from the pinion, as far as this goes, and the pinion as a gear."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.drawings import Part, drawing
from rattle.plots.drawings.gear import DEPTH, GAP, around, draw_strokes, gear, pitch
from rattle.plots.movie_file import Update
from rattle.plots.scene import Array, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MORE = 1.5  # of the line beyond the ways of the pinion's centre, in radii
MOST = 400  # teeth


@drawing("rack", reach=around, name_at=1.0)
def rack(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one rack and its pinion."""
    form = part.form
    axis, reach = form["fields"]["axis"], MORE * form["fields"]["radius"]
    turn = scene.angle(form["bodies"][0]) + axis
    a, b = scene.ends(form)
    way = ((b - a) * np.column_stack([np.cos(turn), np.sin(turn)])).sum(axis=1)
    line = toothed_line(way.min() - reach, way.max() + reach, pitch(scene.result.geometry))
    along, across = np.array([np.cos(axis), np.sin(axis)]), np.array([-np.sin(axis), np.cos(axis)])
    strokes = line[:, :1] * along + line[:, 1:] * across + np.array(form["points"][0])
    return [*gear(ax, scene, part), draw_strokes(ax, scene, form["bodies"][0], strokes)]


def toothed_line(low: float, high: float, step: float) -> Array:
    """Strokes (n, 2) [m] of a rack along x from `low` to `high` with teeth to its left, `step` apart, all [m]."""
    step *= max(1.0, (high - low) / (step * MOST))
    strokes = [np.array([[low, 0.0], [high, 0.0]])]
    for x in np.arange(np.ceil(low / step), np.floor(high / step) + 1.0) * step:
        strokes += [GAP, np.array([[x, 0.0], [x, 2.0 * DEPTH * step]])]
    return np.vstack(strokes)
