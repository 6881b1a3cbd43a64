"""Pin in a slot with rounded or open ends, of its given length or else a little longer than the pin moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import BLACK, GREY
from rattle.plots.drawings import Form, Part, drawing
from rattle.plots.drawings.guide import draw_stops, line_of, on_body, reach
from rattle.plots.movie_file import Update
from rattle.plots.scene import Pair, Scene, draw_area, draw_line, draw_wall

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MORE = 0.06  # of a slot without ends beyond the ways of its pin, as a share of the mechanism's size


def slot_span(scene: Scene, form: Form) -> tuple[float, float]:
    """Where the middle of the pin is at both ends of a slot, along its line [m]."""
    if "travel" in form:
        return -form["travel"], form["travel"]
    way = line_of(scene, form).coordinate(scene.ends(form)[1])
    return float(way.min()) - MORE * scene.size, float(way.max()) + MORE * scene.size


def slot_of(scene: Scene, form: Form) -> list[tuple[str, Pair]]:
    """The ends of a slot that a body carries."""
    return on_body(form, *slot_span(scene, form))


@drawing("slot", reach=reach, name_at=1.0, holds=slot_of)
def slot(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one slot and its pin."""
    form = part.form
    line, centre = line_of(scene, form), scene.ends(form)[1]
    low, high = slot_span(scene, form)
    half = form.get("bush_radius") or 0.02 * scene.size + form["clearance"]
    turns = np.linspace(-np.pi / 2, np.pi / 2, 19)
    opens = form["fields"].get("open", 0.0)  # 1 start, 2 end, 3 both
    edge: list[tuple[float, float]] = []
    for sense, end, mouth in ((1.0, high, opens >= 2.0), (-1.0, low, opens in (1.0, 3.0))):
        round_ = [(end + sense * half * np.cos(s), sense * half * np.sin(s)) for s in turns]
        edge += [(end, -sense * half), (np.nan, np.nan), (end, sense * half)] if mouth else round_
    outline = np.stack([line.at(np.full(len(centre), x), y) for x, y in (*edge, edge[0])], axis=1)
    size = half - form["clearance"]
    pin = np.stack([centre + size * np.array([np.cos(s), np.sin(s)]) for s in 2.0 * turns], axis=1)
    if form["bodies"][0] == "ground":
        draw_wall(ax, outline[0, -2], outline[0, -1], 0.3 * half, color=GREY, linewidth=1.5, zorder=1)
    return [
        *draw_stops(ax, form, line, size, 1.3 * half),
        draw_line(ax, outline, color=GREY, linewidth=1.5, zorder=4),
        draw_line(ax, pin, color=BLACK, linewidth=1.2, zorder=5),
        draw_area(ax, pin, GREY),
    ]
