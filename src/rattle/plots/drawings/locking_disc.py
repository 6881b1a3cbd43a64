"""Locking disc of a Geneva drive: the disc with its sector cut out, and the wheel with its hollow arcs, to scale."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.plots.drawings import Form, Part, drawing
from rattle.plots.drawings.cam import around, draw_outline
from rattle.plots.movie_file import Update
from rattle.plots.scene import Pair, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def borne(form: Form) -> Form:
    """The form as seen from B: its outline stands in the place of that of A."""
    bodies, points = form["bodies"], form["points"]
    return {**form, "bodies": bodies[::-1], "points": points[::-1], "outline": form["borne_outline"]}


def reach(form: Form) -> list[tuple[str, Pair]]:
    """Points of both outlines."""
    return [*around(form), *around(borne(form))]


@drawing("locking-disc", reach=reach, name_at=0.0)
def locking_disc(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one disc and its wheel."""
    return [*draw_outline(ax, scene, part), *draw_outline(ax, scene, part._replace(form=borne(part.form)))]
