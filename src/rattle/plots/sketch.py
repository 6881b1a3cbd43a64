"""Drawings of a mechanism: its bodies, and its joints and loads in the forms of `rattle.plots.drawings`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import GREY, LINES, tidy
from rattle.plots.drawings import parts
from rattle.plots.movie_file import Update
from rattle.plots.orbit import clearance_joints
from rattle.plots.scene import Array, Pair, Scene, draw_area, draw_dot, draw_line, draw_plate, draw_tag

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rattle.results.result import Result


def draw_at(ax: Axes, result: Result, k: int) -> None:
    """Draw the mechanism at instant k of a result, without axes or labels."""
    stage = Scene(result, np.array([k]), 1.0, (GREY,))
    low, high = extent(stage)
    stage = stage._replace(size=float(max(high - low)) or 1.0)
    low, high = low - 0.12 * stage.size, high + 0.12 * stage.size
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    tidy(ax).grid(False)
    ax.spines[["left", "bottom"]].set_color(LINES)
    ax.tick_params(colors=GREY, labelsize=8)
    draw_mechanism(ax, stage)


def draw_mechanism(ax: Axes, stage: Scene, names: bool = True) -> list[Update]:
    """Draw all parts at frame 0; each of the functions returned moves one of them to frame k.

    names: beside pins with play.
    """
    drawn = list(parts(stage.result.geometry))
    own = {body for part, how in drawn for body in how.instead_of(stage, part.form)}
    updates = [move for part, how in drawn for move in how.draw(ax, stage, part)]
    held = [end for part, how in drawn for end in how.holds(stage, part.form)]
    for body in stage.bodies:
        if body not in own:
            updates += draw_body(ax, stage, body, [point for other, point in held if other == body])
    for name in clearance_joints(stage.result) if names else ():
        form = stage.result.geometry["joints"][name]
        updates.append(draw_tag(ax, name, stage.ends(form)[0]))
    for move in updates:
        move(0)
    return updates


def draw_body(ax: Axes, stage: Scene, body: str, held: Sequence[Pair] = ()) -> list[Update]:
    """A bar through two points, a filled plate through more; a single point is tied to the mass centre.

    A plate with an outline is drawn as it is, with its holes.  held: further points in its frame [m], of its slots.
    """
    points, colour = np.vstack([stage.points(body), *(np.array([point]) for point in held)]), stage.colour(body)
    if rings := stage.rings(body):
        paths = [np.stack([stage.path(body, p) for p in np.vstack([ring, ring[:1]])], axis=1) for ring in rings]
        edges = [draw_line(ax, path, color=colour, linewidth=2, alpha=0.85, zorder=3) for path in paths]
        return [draw_plate(ax, [path[:, :-1] for path in paths], colour), *edges]
    if len(points) < 2:
        points = np.vstack([points, np.zeros((1, 2))])
    if float(np.ptp(points, axis=0).max()) < 1e-9 * stage.size:
        return [
            draw_dot(ax, stage.path(body, points[0]), marker="o", markersize=11, color=colour, alpha=0.75, zorder=3)
        ]
    if len(points) > 2:
        corners = hull(points)
        points = np.vstack([corners, corners[:1]])
    path = np.stack([stage.path(body, p) for p in points], axis=1)
    updates = [draw_line(ax, path, color=colour, linewidth=5, alpha=0.75, solid_capstyle="round", zorder=3)]
    if len(points) > 2:
        updates.append(draw_area(ax, path, colour))
    return updates


def hull(points: Array) -> Array:
    """Corners (n, 2) of the convex hull of points (m, 2), counter-clockwise; two if all are on one line."""
    ordered = sorted(map(tuple, points.tolist()))
    corners: list[tuple[float, ...]] = []
    for way in (ordered, ordered[::-1]):
        side: list[tuple[float, ...]] = []
        for x, y in way:
            while len(side) > 1:
                (ax, ay), (bx, by) = side[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                    break
                side.pop()
            side.append((x, y))
        corners += side[:-1]
    return np.array(corners)


def _reach(stage: Scene, body: str) -> Iterator[Array]:
    """Points of a body [m] that a picture has to show: the corners of its outline, its named points, its centre."""
    yield from (p for some in (*stage.rings(body), stage.points(body), np.zeros((1, 2))) for p in some)


def extent(stage: Scene) -> tuple[Array, Array]:
    """Lower left and upper right corner (2,) [m] of the box that holds everything at every frame.

    It is no smaller than a bush: the path of a pin in its clearance alone is no picture of a mechanism.
    """
    low, high = _reached(stage)
    bush = _largest_bush(stage)
    if float(max(high - low)) < bush:
        middle = 0.5 * (low + high)
        low, high = middle - 0.5 * bush, middle + 0.5 * bush
    return low, high


def is_a_pin_alone(stage: Scene) -> bool:
    """True if there is nothing to see but a pin in its bush."""
    low, high = _reached(stage)
    return float(max(high - low)) < _largest_bush(stage)


def _reached(stage: Scene) -> tuple[Array, Array]:
    """Lower left and upper right corner (2,) [m] of the box of all points and parts at every frame."""
    paths = [stage.path(body, p) for body in stage.bodies for p in _reach(stage, body)]
    for part, how in parts(stage.result.geometry):
        paths += [stage.path(body, p) for body, p in how.reach(part.form)]
    everything = np.vstack(paths)
    everything = everything[np.isfinite(everything).all(axis=1)]
    return everything.min(axis=0), everything.max(axis=0)


def _largest_bush(stage: Scene) -> float:
    """Diameter [m] of the largest bush; 0 without any."""
    return 2.0 * max((form.get("bush_radius", 0.0) for form in stage.result.geometry["joints"].values()), default=0.0)
