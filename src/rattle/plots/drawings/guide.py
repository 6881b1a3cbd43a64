"""Prismatic joint: a block on a line of A, hatched if A is the ground; between moving bodies a cylinder with its rod.

A is a barrel if all its points are on the line: a tube that holds them and the piston, from which the rod, B, comes
out.  With play the line becomes two walls.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rattle.plots.curves import BLACK, GREY
from rattle.plots.drawings import Form, Part, drawing
from rattle.plots.movie_file import Update
from rattle.plots.scene import CORNERS, Array, Pair, Scene, draw_area, draw_line, draw_wall

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STRAIGHT = 0.01  # share of the mechanism's size within which points are on the line
BORE, PISTON, ROD = 0.026, 0.032, 0.009  # half the barrel's height, the piston's length, half the rod's: same share
OUT = 0.55  # a barrel without points of its own holds so much of the rod


class Line(NamedTuple):
    """The line of a joint in A, at every frame."""

    origin: Array  # (frames, 2) the point of A [m]
    along: Array  # (frames, 2) unit vector
    across: Array

    def outline(self, x: Array, half: float) -> Array:
        """(frames, 5, 2) corners [m] of a box from x[:, 0] to x[:, 1] along the line, `half` to both sides."""
        return np.stack([self.at(x[:, int(i > 0)], j * half) for i, j in CORNERS], axis=1)

    def at(self, x: Array, y: float) -> Array:
        """(frames, 2) point [m] at x (frames,) along the line and y across it."""
        return np.asarray(self.origin + x[:, None] * self.along + y * self.across)

    def coordinate(self, path: Array) -> Array:
        """(frames,) coordinate [m] along the line of points (frames, 2)."""
        return np.asarray(((path - self.origin) * self.along).sum(axis=1))


def line_of(scene: Scene, form: Form) -> Line:
    """The line of a guide or slot."""
    turn = scene.angle(form["bodies"][0]) + form["axis"]
    along, across = np.column_stack([np.cos(turn), np.sin(turn)]), np.column_stack([-np.sin(turn), np.cos(turn)])
    return Line(scene.ends(form)[0], along, across)


def on_line(scene: Scene, form: Form, end: int) -> bool:
    """True if all points of A (end 0) or B (end 1) are on the line."""
    body = form["bodies"][end]
    line = line_of(scene, form)
    paths = [scene.path(body, point) for point in scene.points(body)]
    off = [abs(float(((path - line.origin) * line.across).sum(axis=1)[0])) for path in paths]
    return max(off, default=0.0) < STRAIGHT * scene.size


def is_cylinder(scene: Scene, form: Form) -> bool:
    """True if A is drawn as a barrel."""
    a = form["bodies"][0]
    return a != "ground" and not scene.rings(a) and on_line(scene, form, 0)


def barrel_and_rod(scene: Scene, form: Form) -> list[str]:
    """The bodies that are drawn here and not as bars."""
    if not is_cylinder(scene, form):
        return []
    a, b = form["bodies"]
    return [a, b] if b != "ground" and not scene.rings(b) and on_line(scene, form, 1) else [a]


def reach(form: Form) -> list[tuple[str, Pair]]:
    """Both points, and how far the guide goes if it has ends."""
    (a, b), (p, q) = form["bodies"], form["points"]
    ways = [-form["travel"], form["travel"]] if "travel" in form else []
    ways += [end for end in form.get("stop", ()) if end is not None]
    cos, sin = np.cos(form["axis"]), np.sin(form["axis"])
    return [(a, tuple(p)), (b, tuple(q)), *((a, (p[0] + way * cos, p[1] + way * sin)) for way in ways)]


def on_body(form: Form, low: float, high: float) -> list[tuple[str, Pair]]:
    """Both ends [m] of a line of A, in its frame, where A is a body: it reaches up to them."""
    (body, _), ((x, y), _) = form["bodies"], form["points"]
    cos, sin = float(np.cos(form["axis"])), float(np.sin(form["axis"]))
    return [(body, (x + end * cos, y + end * sin)) for end in (low, high)] if body != "ground" else []


def rail_of(scene: Scene, form: Form) -> list[tuple[str, Pair]]:
    """The ends of a guide that a body carries."""
    return [] if is_cylinder(scene, form) else on_body(form, *guide_span(scene, form))


def guide_span(scene: Scene, form: Form) -> tuple[float, float]:
    """Where a guide begins and ends along its line [m]."""
    length, _ = block_size(scene, form)
    way = line_of(scene, form).coordinate(scene.ends(form)[1])
    stops = [end for end in form.get("stop", ()) if end is not None]
    return min([way.min(), *stops]) - 0.8 * length, max([way.max(), *stops]) + 0.8 * length


def block_size(scene: Scene, form: Form) -> tuple[float, float]:
    """Length and height of the block of a guide [m]."""
    return form.get("block") or (0.12 * scene.size, 0.07 * scene.size)


@drawing("guide", reach=reach, instead_of=barrel_and_rod, name_at=1.0, holds=rail_of)
def guide(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw one guide with its block, or a cylinder."""
    form = part.form
    if is_cylinder(scene, form):
        return _cylinder(ax, scene, form)
    line = line_of(scene, form)
    length, height = block_size(scene, form)
    low, high = guide_span(scene, form)
    updates = draw_stops(ax, form, line, length / 2, 0.7 * height)
    for side in (-1, 1) if form["clearance"] else (0,):
        y = side * (height / 2 + form["clearance"])
        wall = np.stack([line.at(np.full(len(line.origin), x), y) for x in (low, high)], axis=1)
        if form["bodies"][0] == "ground":
            start, end = wall[0] if side <= 0 else wall[0, ::-1]
            draw_wall(ax, start, end, 0.014 * scene.size, color=GREY, linewidth=1.5, zorder=1)
        else:
            updates.append(draw_line(ax, wall, color=GREY, linewidth=1.5, zorder=1))
    return updates + _block(ax, scene, form, line, length, height)


def draw_stops(ax: Axes, form: Form, line: Line, before: float, half: float) -> list[Update]:
    """Stops of the position as walls across the line, as far before B's point as the block reaches; lengths in m."""
    updates = []
    for way, end in zip((-1.0, 1.0), form.get("stop", ()), strict=False):
        if end is not None:
            x = np.full(len(line.origin), end + way * before)
            wall = np.stack([line.at(x, -half), line.at(x, half)], axis=1)
            updates.append(draw_line(ax, wall, color=BLACK, linewidth=3, solid_capstyle="butt", zorder=3.6))
    return updates


def _block(ax: Axes, scene: Scene, form: Form, line: Line, length: float, height: float) -> list[Update]:
    """A block that turns with B, which keeps its angle to A as far as the play lets it."""
    (a, b), centre = form["bodies"], scene.ends(form)[1]
    turned = scene.angle(b) - scene.angle(a)
    cos, sin = np.cos(turned - turned[0])[:, None], np.sin(turned - turned[0])[:, None]
    u, n = cos * line.along + sin * line.across, cos * line.across - sin * line.along
    block = np.stack([centre + i * length / 2 * u + j * height / 2 * n for i, j in CORNERS], axis=1)
    return [draw_line(ax, block, color=BLACK, linewidth=1.2, zorder=4), draw_area(ax, block, GREY)]


def _cylinder(ax: Axes, scene: Scene, form: Form) -> list[Update]:
    """Barrel A, piston and rod B."""
    a, b = form["bodies"]
    line, size = line_of(scene, form), scene.size
    piston = line.coordinate(scene.ends(form)[1])
    length, height = form.get("block") or (PISTON * size, 2 * BORE * size)
    half = height / 2 + form["clearance"]
    own = [line.coordinate(scene.path(a, point))[0] for point in scene.points(a)] or [0.0]
    tips = [line.coordinate(scene.path(b, point)) for point in scene.points(b)] if b != "ground" else []
    stops = [end for end in form.get("stop", ()) if end is not None]
    low = min(*own, piston.min() - 0.8 * length, *(end - 0.5 * length for end in stops))
    high = max(*own, piston.max() + 0.8 * length, *(end + 0.5 * length for end in stops))
    out = max(tips, key=lambda tip: float(np.abs(tip - piston).max()), default=piston)
    if np.ptp(own) < 0.1 * size and float((out - piston)[0]) > 0.0:  # no point says where the barrel ends
        high = max(high, OUT * float(out.min()))
    barrel = line.outline(np.tile([low - 0.3 * half, high + 0.3 * half], (len(piston), 1)), half)
    updates = draw_stops(ax, form, line, length / 2, half)
    updates += [draw_area(ax, barrel, scene.colour(a), alpha=0.3, zorder=2)]
    updates.append(draw_line(ax, barrel, color=scene.colour(a), linewidth=2, zorder=3.4))
    if b in barrel_and_rod(scene, form):
        rod = line.outline(np.column_stack([piston, out]), ROD * size)
        updates.append(draw_area(ax, rod, scene.colour(b), alpha=0.85, zorder=3))
    head = line.outline(np.column_stack([piston - length / 2, piston + length / 2]), height / 2)
    updates.append(draw_area(ax, head, scene.colour(b), alpha=0.6, zorder=3.2))
    updates.append(draw_line(ax, head, color=BLACK, linewidth=1.2, zorder=3.3))
    return updates
