"""Drawings of the parts of a mechanism: bodies, joints, guides and springs at chosen instants of a result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle import registry
from rattle.plots.curves import BLACK, BLUE, GREEN, GREY, LINES, MORE, ORANGE, PINK, SKY, tidy
from rattle.plots.movie_file import Update
from rattle.plots.orbit import clearance_joints

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rattle.results.result import Result

Array = NDArray[np.float64]
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))
BODIES = (BLUE, GREEN, ORANGE, PINK, SKY, *MORE)  # red is kept for forces that a bush cannot give


class Scene(NamedTuple):
    """What all drawing functions read: a result at `frames` of its instants."""

    result: Result
    pick: NDArray[np.intp]  # (frames,) rows of the result
    size: float  # of the mechanism [m]

    def path(self, body: str, point: Iterable[float]) -> Array:
        """(frames, 2) positions [m] of a point given in the frame of a body or of the ground."""
        x, y = point
        if body == "ground":
            return np.tile(np.array([x, y], float), (len(self.pick), 1))
        cx, cy, angle = (self.result[f"{body}.{what}"][self.pick] for what in ("x", "y", "angle"))
        cos, sin = np.cos(angle), np.sin(angle)
        return np.column_stack([cx + cos * x - sin * y, cy + sin * x + cos * y])

    def angle(self, body: str) -> Array:
        """(frames,) angle of a body [rad]."""
        return np.zeros(len(self.pick)) if body == "ground" else self.result[f"{body}.angle"][self.pick]


def drawn_as(form: dict[str, Any]) -> str:
    """How the kind of a joint is drawn: pin, rod, guide, slot, or not at all."""
    known = registry.kinds("joint")
    return str(known[form["type"]].leaf.drawn_as) if form["type"] in known else ""


def draw_at(ax: Axes, result: Result, k: int) -> None:
    """Draw the mechanism at instant k of a result, without axes or labels."""
    stage = Scene(result, np.array([k]), 1.0)
    low, high = extent(stage)
    stage = stage._replace(size=float(max(high - low)) or 1.0)
    low, high = low - 0.12 * stage.size, high + 0.12 * stage.size
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    tidy(ax).grid(False)
    ax.spines[["left", "bottom"]].set_color(LINES)
    ax.tick_params(colors=GREY, labelsize=8)
    draw_mechanism(ax, stage, (GREY,))


def draw_mechanism(ax: Axes, stage: Scene, colours: Sequence[str] = BODIES) -> list[Update]:
    """Draw all parts at frame 0; each of the functions returned moves one of them to frame k."""
    updates = draw_guides(ax, stage, colours) + draw_slots(ax, stage) + draw_springs(ax, stage)
    updates += draw_bodies(ax, stage, colours) + draw_joints(ax, stage)
    for move in updates:
        move(0)
    return updates


def extent(stage: Scene) -> tuple[Array, Array]:
    """Lower left and upper right corner (2,) [m] of the box that holds everything at every frame."""
    geometry = stage.result.geometry
    paths = [stage.path(body, p) for body, form in geometry["bodies"].items() for p in form["points"].values()]
    paths += [stage.path(body, (0, 0)) for body in geometry["bodies"]]
    springs = [form for form in geometry["loads"].values() if form["type"] == "spring"]
    for part in (*geometry["joints"].values(), *springs):
        paths += [stage.path(body, p) for body, p in zip(part["bodies"], part["points"], strict=True)]
    for form in geometry["joints"].values():
        for way in (-form["travel"], form["travel"]) if "travel" in form else ():
            (x, y), angle = form["points"][0], form["axis"]
            paths.append(stage.path(form["bodies"][0], (x + way * np.cos(angle), y + way * np.sin(angle))))
    everything = np.vstack(paths)
    everything = everything[np.isfinite(everything).all(axis=1)]
    return everything.min(axis=0), everything.max(axis=0)


# ---------------------------------------------------------------- parts; each function returned moves one to frame k
def draw_line(ax: Axes, path: Array, **style: Any) -> Update:
    """A line through `path` (frames, points, 2) [m] at each frame."""
    (line,) = ax.plot([], [], **style)

    def update(k: int) -> None:
        line.set_data(path[k, :, 0], path[k, :, 1])

    return update


def draw_bodies(ax: Axes, stage: Scene, colours: Sequence[str] = BODIES) -> list[Update]:
    """A bar through two points, a plate through more; a single point is tied to the mass centre.

    Bodies in which another one slides are tubes, see `draw_guides`.
    """
    updates = []
    hollow = {form["bodies"][0] for form in _tubes(stage)}
    for n, (body, form) in enumerate(stage.result.geometry["bodies"].items()):
        points = np.array(list(form["points"].values()), float).reshape(-1, 2)
        if body in hollow:
            continue
        if len(points) < 2:
            points = np.vstack([points, np.zeros((1, 2))])
        if len(points) > 2:
            middle = points - points.mean(axis=0)
            points = points[np.argsort(np.arctan2(middle[:, 1], middle[:, 0]))]
            points = np.vstack([points, points[:1]])
        path = np.stack([stage.path(body, p) for p in points], axis=1)
        colour = colours[n % len(colours)]
        updates.append(draw_line(ax, path, color=colour, linewidth=5, alpha=0.75, solid_capstyle="round", zorder=3))
        if len(points) > 2:
            updates.append(draw_plate(ax, path, colour))
    return updates


def _along(stage: Scene, form: dict[str, Any]) -> Array:
    """Coordinates of the points of A along a guide [m], from the guide's own point."""
    points = np.array(list(stage.result.geometry["bodies"][form["bodies"][0]]["points"].values()), float)
    axis = np.array([np.cos(form["axis"]), np.sin(form["axis"])])
    return np.asarray((points - np.array(form["points"][0], float)) @ axis)


def _tubes(stage: Scene) -> list[dict[str, Any]]:
    """Prismatic joints whose A is a moving body with all its points on the line: a cylinder, a slotted lever."""
    geometry = stage.result.geometry
    found = []
    for form in geometry["joints"].values():
        a = form["bodies"][0]
        if drawn_as(form) != "guide" or a == "ground":
            continue
        points = np.array(list(geometry["bodies"][a]["points"].values()), float).reshape(-1, 2)
        off = points - np.array(form["points"][0], float)
        if np.abs(off @ (-np.sin(form["axis"]), np.cos(form["axis"]))).max(initial=0.0) < 0.01 * stage.size:
            found.append(form)
    return found


def draw_plate(ax: Axes, path: Array, colour: str) -> Update:
    """A filled polygon with the corners `path` (frames, points, 2) [m]."""
    from matplotlib.patches import Polygon

    plate = Polygon(path[0], facecolor=colour, alpha=0.2, linewidth=0, zorder=2)
    ax.add_patch(plate)

    def update(k: int) -> None:
        plate.set_xy(path[k])

    return update


def draw_joints(ax: Axes, stage: Scene) -> list[Update]:
    """Revolute joints as circles (dark: driven), with a support if one body is the ground; rods as thin bars."""
    updates: list[Update] = []
    plain: list[Array] = []
    driven: list[Array] = []
    for name, form in stage.result.geometry["joints"].items():
        a, b = (stage.path(body, p) for body, p in zip(form["bodies"], form["points"], strict=True))
        if drawn_as(form) == "rod":
            updates.append(draw_line(ax, np.stack([a, b], axis=1), color=GREY, linewidth=2, zorder=2))
            plain += [a, b]
        elif drawn_as(form) == "pin":
            (driven if name in stage.result.geometry["driven"] else plain).append(a)
            if "ground" in form["bodies"]:
                draw_foot(ax, form["points"][form["bodies"].index("ground")], 0.045 * stage.size)
    for name in clearance_joints(stage.result):
        form = stage.result.geometry["joints"][name]
        updates.append(draw_tag(ax, name, stage.path(form["bodies"][0], form["points"][0])))
    for paths, fill in ((plain, "white"), (driven, BLACK)):
        if paths:
            style = {
                "marker": "o",
                "linestyle": "",
                "markersize": 7,
                "color": BLACK,
                "markerfacecolor": fill,
                "zorder": 5,
            }
            updates.append(draw_line(ax, np.stack(paths, axis=1), **style))
    return updates


def draw_tag(ax: Axes, name: str, path: Array) -> Update:
    """The name of a joint or body, beside its point `path` (frames, 2) [m]."""
    from matplotlib.patheffects import withStroke

    tag = ax.annotate(name, (0, 0), (9, 5), textcoords="offset points", fontsize=9, color=BLACK, zorder=6)
    tag.set_path_effects([withStroke(linewidth=3, foreground="white")])

    def update(k: int) -> None:
        tag.xy = (path[k, 0], path[k, 1])

    return update


def draw_foot(ax: Axes, at: Iterable[float], size: float) -> None:
    """The usual symbol of a fixed pivot, a triangle on a hatched line; `at` and `size` [m]."""
    from matplotlib.patches import Polygon

    x, y = at
    corners = [(x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)]
    ax.add_patch(Polygon(corners, facecolor="white", edgecolor=BLACK, linewidth=1, zorder=2))
    left, right = x - size, x + size
    ax.plot([left, right], [y - size, y - size], color=BLACK, linewidth=1, zorder=2)
    for start in np.linspace(left + 0.3 * size, right, 6):
        ax.plot([start, start - 0.3 * size], [y - size, y - 1.3 * size], color=BLACK, linewidth=0.6, zorder=2)


def draw_guides(ax: Axes, stage: Scene, colours: Sequence[str] = BODIES) -> list[Update]:
    """Prismatic joints: the line of the guide in A (its two walls where there is play), a block on B.

    If A is a moving body with all its points on the line, it is drawn as a tube, and the block is the piston in it.
    """
    updates = []
    tubes = _tubes(stage)
    bodies = list(stage.result.geometry["bodies"])
    for form in stage.result.geometry["joints"].values():
        if drawn_as(form) != "guide":
            continue
        (a, b), (point, _) = form["bodies"], form["points"]
        centre, start = stage.path(b, form["points"][1]), stage.path(a, point)
        turn = stage.angle(a) + form["axis"]
        along, across = np.column_stack([np.cos(turn), np.sin(turn)]), np.column_stack([-np.sin(turn), np.cos(turn)])
        travel = ((centre - start) * along).sum(axis=1)
        tube = form in tubes
        usual = (0.04 * stage.size, 0.03 * stage.size) if tube else (0.12 * stage.size, 0.07 * stage.size)
        length, height = form.get("block") or usual
        ends = [travel.min() - 0.8 * length, travel.max() + 0.8 * length]
        if tube:
            own = _along(stage, form)
            ends = [min(*ends, own.min() - height / 2), max(*ends, own.max() + height / 2)]
        gap = height / 2 + form["clearance"]
        if tube:
            corners = [(ends[i > 0], j) for i, j in CORNERS]
            wall = np.stack([start + end * along + side * gap * across for end, side in corners], axis=1)
            colour = colours[bodies.index(a) % len(colours)]
            updates += [draw_line(ax, wall, color=colour, linewidth=2, zorder=3), draw_plate(ax, wall, colour)]
        for side in () if tube else (-1, 1) if form["clearance"] else (0,):
            wall = np.stack([start + end * along + side * gap * across for end in ends], axis=1)
            updates.append(draw_line(ax, wall, color=GREY, linewidth=1.5, zorder=1))
        # the block turns with B, which keeps its angle to A as far as the play lets it
        own = turn + (stage.angle(b) - stage.angle(a)) - (stage.angle(b) - stage.angle(a))[0]
        u, n = np.column_stack([np.cos(own), np.sin(own)]), np.column_stack([-np.sin(own), np.cos(own)])
        block = np.stack([centre + i * length / 2 * u + j * height / 2 * n for i, j in CORNERS], axis=1)
        updates += [draw_line(ax, block, color=BLACK, linewidth=1.2, zorder=4), draw_plate(ax, block, GREY)]
    return updates


def draw_slots(ax: Axes, stage: Scene) -> list[Update]:
    """Slots with rounded ends in A, of their given length or else as far as the pin of B moves, and this pin."""
    updates = []
    turns = np.linspace(-np.pi / 2, np.pi / 2, 19)
    for form in stage.result.geometry["joints"].values():
        if drawn_as(form) != "slot":
            continue
        (a, b), (point, pin) = form["bodies"], form["points"]
        centre, start = stage.path(b, pin), stage.path(a, point)
        turn = stage.angle(a) + form["axis"]
        along, across = np.column_stack([np.cos(turn), np.sin(turn)]), np.column_stack([-np.sin(turn), np.cos(turn)])
        way = ((centre - start) * along).sum(axis=1)
        low, high = (-form["travel"], form["travel"]) if "travel" in form else (way.min(), way.max())
        half = form.get("bush_radius") or 0.02 * stage.size + form["clearance"]
        ends = [(high + half * np.cos(s), half * np.sin(s)) for s in turns]
        ends += [(low - half * np.cos(s), -half * np.sin(s)) for s in turns]
        outline = np.stack([start + x * along + y * across for x, y in (*ends, ends[0])], axis=1)
        size = half - form["clearance"]
        round_ = np.stack([centre + size * np.array([np.cos(s), np.sin(s)]) for s in 2.0 * turns], axis=1)
        updates.append(draw_line(ax, outline, color=GREY, linewidth=1.5, zorder=4))
        updates += [draw_line(ax, round_, color=BLACK, linewidth=1.2, zorder=5), draw_plate(ax, round_, GREY)]
    return updates


def draw_springs(ax: Axes, stage: Scene) -> list[Update]:
    """Springs as zigzag lines between their two points."""
    updates = []
    for form in stage.result.geometry["loads"].values():
        if form["type"] != "spring":
            continue
        a, b = (stage.path(body, p)[:, None, :] for body, p in zip(form["bodies"], form["points"], strict=True))
        part = np.array([0, 0.15, *np.linspace(0.2, 0.8, 9), 0.85, 1])[None, :, None]
        side = np.array([0, 0, *([1, -1] * 5)[:9], 0, 0])[None, :, None] * 0.025 * stage.size
        length = np.maximum(np.hypot(*np.moveaxis(b - a, 2, 0))[..., None], 1e-12)
        across = np.stack([-(b - a)[..., 1], (b - a)[..., 0]], axis=-1) / length
        updates.append(draw_line(ax, a + part * (b - a) + side * across, color=GREY, linewidth=1.2, zorder=2))
    return updates
