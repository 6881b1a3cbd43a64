"""Clutch: an arrow in its sense around the middle of the driven body, black while it is locked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import BLACK, GREY
from rattle.plots.drawings import Form, Part, drawing
from rattle.plots.movie_file import Update
from rattle.plots.scene import Pair, Scene, draw_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def hub(form: Form) -> str:
    """The body around which the arrow is drawn: B, or A if B is the ground."""
    a, b = form["bodies"]
    return str(a if b == "ground" else b)


def middle(form: Form) -> list[tuple[str, Pair]]:
    """The mass centre of that body."""
    return [(hub(form), (0.0, 0.0))]


@drawing("clutch", reach=middle, name_at=1.0)
def clutch(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one clutch; several around one body have arrows of different radii."""
    form, result = part.form, scene.result
    others = [name for name, one in result.geometry["joints"].items() if "sense" in one and hub(one) == hub(form)]
    radius, sense = (0.035 + 0.02 * others.index(part.name)) * scene.size, float(form["sense"])
    turns = (0.5 + sense * np.linspace(-1.6, -0.15, 30)) * np.pi
    arrow = radius * np.column_stack([np.cos(turns), np.sin(turns)])
    tip = turns[-1] + 0.12 * sense * np.pi
    head = [1.25 * arrow[-1], radius * np.array([np.cos(tip), np.sin(tip)]), 0.75 * arrow[-1], arrow[-1]]
    path = scene.path(hub(form), (0.0, 0.0))[:, None, :] + np.vstack([arrow, *head])[None]
    updates = [draw_line(ax, path, color=GREY, linewidth=1.2, zorder=6)]
    if f"{part.name}.locked" in result:
        on = result[f"{part.name}.locked"][scene.pick] > 0.5
        held = np.where(on[:, None, None], path, np.nan)
        updates.append(draw_line(ax, held, color=BLACK, linewidth=2, zorder=6))
    return updates
