"""Drawings of a mechanism: matplotlib plays the primitives of `rattle.drawings`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.drawings.forms import display_list
from rattle.drawings.played import Shape, Stage
from rattle.plots.curves import GREY, LINES, tidy
from rattle.plots.movie_file import Update
from rattle.plots.scene import PIXEL, Array, Scene, draw_area, draw_line, draw_name, draw_plate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rattle.results.result import Result


def draw_at(ax: Axes, result: Result, k: int) -> None:
    """Draw the mechanism at instant k of a result, without axes or labels."""
    scene = Scene(result, np.array([k]), 1.0, (GREY,))
    low, high = extent(scene)
    scene = scene._replace(size=float(max(high - low)) or 1.0)
    low, high = low - 0.12 * scene.size, high + 0.12 * scene.size
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    tidy(ax).grid(False)
    ax.spines[["left", "bottom"]].set_color(LINES)
    ax.tick_params(colors=GREY, labelsize=8)
    draw_mechanism(ax, scene)


def draw_mechanism(ax: Axes, scene: Scene, names: bool = True) -> list[Update]:
    """Draw all parts at frame 0; each of the functions returned moves one of them to frame k.

    names: beside pins with play.
    """
    return draw_layers(ax, scene, stage_of(scene), ("drawn", "pins") if names else ("drawn",))


def draw_layers(ax: Axes, scene: Scene, stage: Stage, layers: Iterable[str]) -> list[Update]:
    """The same of some layers of a stage."""
    return draw_shapes(ax, scene, (shape for layer in layers for shape in stage.shapes(layer)))


def draw_shapes(ax: Axes, scene: Scene, shapes: Iterable[Shape]) -> list[Update]:
    """The same of some primitives."""
    updates = [move for shape in shapes for move in draw_shape(ax, scene, shape)]
    for move in updates:
        move(0)
    return updates


def stage_of(scene: Scene) -> Stage:
    """The primitives of a mechanism in its motion."""
    geometry = scene.result.geometry
    return Stage(display_list(geometry), geometry, scene, scene.size)


def draw_shape(ax: Axes, scene: Scene, shape: Shape) -> list[Update]:
    """Draw a primitive."""
    style, frames = shape.style, len(scene.pick)
    line, fill = scene.written(style["line"]), scene.written(style.get("fill"))
    shown = np.broadcast_to(shape.shown, (frames,))[:, None, None]
    rings = [np.broadcast_to(ring, (frames, *ring.shape[1:])) for ring in shape.rings]
    if not shown.all():
        rings = [np.where(shown, ring, np.nan) for ring in rings]
    if style["draw"] == "text":
        weight = "bold" if style["bold"] else "normal"
        return [draw_name(ax, style["text"], rings[0], color=line, fontweight=weight, zorder=style["z"])]
    width = PIXEL * style["width"]
    own: dict[str, Any] = {"color": line, "linewidth": width, "zorder": style["z"], "solid_joinstyle": "round"}
    if style["draw"] == "dot":
        shape_of_it = {"marker": "s" if style["square"] else "o", "markersize": 2.0 * PIXEL * style["radius"]}
        face = {"markerfacecolor": fill, "markeredgewidth": width, "linestyle": ""}
        return [draw_line(ax, rings[0], **own, **shape_of_it, **face)]
    if style["draw"] == "wall":
        wall, hatches = rings
        return [draw_line(ax, wall, **own), draw_line(ax, hatches, **{**own, "linewidth": 0.6, "alpha": 0.8})]
    updates = []
    if fill is not None:
        name = style.get("body")
        area = draw_plate(ax, rings, fill, style["opacity"], style["z"], name) if len(rings) > 1 else draw_area(
            ax, rings[0], fill, style["opacity"], style["z"], name)  # fmt: skip
        updates.append(area)
    return updates + (_draw_outline(ax, style, rings, own) if line is not None else [])


def _draw_outline(ax: Axes, style: Mapping[str, Any], rings: Sequence[Array], own: Mapping[str, Any]) -> list[Update]:
    """Draw the line of a path or around an area."""
    if style["closed"]:
        rings = [np.concatenate([ring, ring[:, :1]], axis=1) for ring in rings]
    cap = "butt" if style["butt"] else "round"
    dash = style.get("dash")
    dashed = {"linestyle": (0, [length / style["width"] for length in dash])} if dash else {}
    names = [f"{style['body']}-outline{n or ''}" if "body" in style else None for n in range(len(rings))]
    return [
        draw_line(ax, ring, solid_capstyle=cap, gid=name, **own, **dashed)
        for ring, name in zip(rings, names, strict=True)
    ]


def extent(scene: Scene) -> tuple[Array, Array]:
    """Lower left and upper right corner (2,) [m] of the box that holds everything at every frame.

    It is no smaller than a bush: the path of a pin in its clearance alone is no picture of a mechanism.
    """
    low, high = _reached(scene)
    bush = _largest_bush(scene)
    if float(max(high - low)) < bush:
        middle = 0.5 * (low + high)
        low, high = middle - 0.5 * bush, middle + 0.5 * bush
    return low, high


def is_a_pin_alone(scene: Scene) -> bool:
    """True if there is nothing to see but a pin in its bush."""
    low, high = _reached(scene)
    return float(max(high - low)) < _largest_bush(scene)


def _reached(scene: Scene) -> tuple[Array, Array]:
    """Lower left and upper right corner (2,) [m] of the box of all points and parts at every frame.

    Parts whose size follows from that of the mechanism reach as far as their points when it is measured.
    """
    low = high = np.zeros(2)
    geometry = scene.result.geometry
    written = display_list(geometry)
    for _ in range(2):
        stage = Stage(written, geometry, scene, float(max(high - low)))
        every = np.vstack([path.reshape(-1, 2) for path in stage.held()])
        every = every[np.isfinite(every).all(axis=1)]
        low, high = every.min(axis=0), every.max(axis=0)
    return low, high


def _largest_bush(scene: Scene) -> float:
    """Diameter [m] of the largest bush; 0 without any."""
    return 2.0 * max((form.get("bush_radius", 0.0) for form in scene.result.geometry["joints"].values()), default=0.0)
