"""Spring as a zigzag line, damper as a dashpot, both side by side; a short wall where it is held by the ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import GREY
from rattle.plots.drawings import Part, drawing
from rattle.plots.movie_file import Update
from rattle.plots.scene import Array, Scene, draw_line, draw_wall

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HALF = 0.025  # half the width, as a share of the mechanism's size
GAP = (np.nan, np.nan)
Points = list[tuple[float, float]]  # along as a share of the length, across [m]


@drawing("spring")
def spring(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one spring, damper or both."""
    form, half = part.form, HALF * scene.size
    fields = form.get("fields", {})
    stiff, damped = fields.get("stiffness", 1.0) != 0.0, fields.get("damping", 1.0) != 0.0
    if "fields" not in form or (stiff and not damped):
        shape = [(0.0, 0.0), *_coils(half), (1.0, 0.0)]
    elif stiff:
        shape = [(0.0, 0.0), (0.15, 0.0), GAP, (0.15, -half), *_coils(0.7 * half, half), (0.85, -half), GAP]
        shape += [*_dashpot(0.6 * half, -half), GAP, (0.85, 0.0), (1.0, 0.0)]
    else:
        shape = [(0.0, 0.0), *_dashpot(0.7 * half), (1.0, 0.0)]
    a, b = scene.ends(form)
    for body, here, there in zip(form["bodies"], (a, b), (b, a), strict=True):
        if body == "ground":
            _held(ax, here[0], there[0], half)
    return [draw_line(ax, _placed(np.array(shape), a, b), color=GREY, linewidth=1.2, zorder=2)]


def _coils(half: float, shift: float = 0.0) -> Points:
    """A zigzag line, shifted to one side [m]."""
    zigzag = [(float(x), shift + half * (-1) ** k) for k, x in enumerate(np.linspace(0.2, 0.8, 9))]
    return [(0.15, shift), *zigzag, (0.85, shift)]


def _dashpot(half: float, shift: float = 0.0) -> Points:
    """A pot, open to the right, and the plunger in it, shifted to one side [m]."""
    pot = [(0.65, shift + half), (0.35, shift + half), (0.35, shift - half), (0.65, shift - half)]
    plunger = [(0.55, shift + 0.8 * half), (0.55, shift - 0.8 * half)]
    return [(0.15, shift), (0.35, shift), GAP, *pot, GAP, *plunger, GAP, (0.55, shift), (0.85, shift)]


def _placed(shape: Array, a: Array, b: Array) -> Array:
    """(frames, points, 2) [m] of a shape (points, 2) between the points a and b (frames, 2) [m]."""
    d = b - a
    length = np.maximum(np.hypot(d[:, 0], d[:, 1]), 1e-12)[:, None]
    across = np.column_stack([-d[:, 1], d[:, 0]]) / length
    return np.asarray(a[:, None] + shape[:, :1] * d[:, None] + shape[:, 1:] * across[:, None])


def _held(ax: Axes, here: Array, there: Array, half: float) -> None:
    """A short wall across the end at the ground, hatched behind."""
    d = there - here
    length = float(np.hypot(*d))
    n = np.array([-d[1], d[0]]) / length if length > 0.0 else np.array([1.0, 0.0])
    draw_wall(ax, here - 1.6 * half * n, here + 1.6 * half * n, 0.4 * half)
