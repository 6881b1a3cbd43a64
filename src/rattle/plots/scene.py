"""What all drawings of a mechanism share: places of its points, colours of its bodies, lines and areas that move."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.plots.curves import BLACK, BLUE, GREEN, MORE, ORANGE, PINK, SKY
from rattle.plots.movie_file import Update

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rattle.results.result import Result

Array = NDArray[np.float64]
Pair = tuple[float, float]
FIRST = (BLUE, GREEN, ORANGE, PINK, SKY, *MORE)  # red is kept for forces that a bush cannot give
DARKER = (1.0, 0.62, 0.36)  # further bodies have the same colours, mixed with so much black
# behind a name; a white outline instead would turn it into curves in an .svg
PAPER = {"boxstyle": "square,pad=0.05", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))


def body_colours() -> tuple[str, ...]:
    """Colours of bodies in their order: thirty that differ."""
    shades = []
    for share in DARKER:
        for colour in FIRST:
            parts = (round(share * int(colour[k : k + 2], 16)) for k in (1, 3, 5))
            shades.append("#" + "".join(f"{part:02X}" for part in parts))
    return tuple(shades)


BODIES = body_colours()


class Scene(NamedTuple):
    """What all drawing functions read: a result at `pick` of its instants."""

    result: Result
    pick: NDArray[np.intp]  # (frames,) rows of the result
    size: float  # of the mechanism [m]
    colours: Sequence[str] = BODIES

    @property
    def bodies(self) -> Mapping[str, Any]:
        """The bodies of the result's geometry by name."""
        found: Mapping[str, Any] = self.result.geometry["bodies"]
        return found

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

    def ends(self, form: Mapping[str, Any]) -> tuple[Array, Array]:
        """(frames, 2) positions [m] of the two points of a joint or load."""
        a, b = (self.path(body, p) for body, p in zip(form["bodies"], form["points"], strict=True))
        return a, b

    def colour(self, body: str) -> str:
        """Colour of a body, dark for the ground."""
        if body not in self.bodies:
            return BLACK
        return self.colours[list(self.bodies).index(body) % len(self.colours)]

    def points(self, body: str) -> Array:
        """(points, 2) named points of a body in its frame [m]."""
        return np.array(list(self.bodies[body]["points"].values()), float).reshape(-1, 2)

    def rings(self, body: str) -> list[Array]:
        """Corners (n, 2) of a plate and of each of its holes, in its frame [m]; none of any other body."""
        return [np.array(ring, float) for ring in self.bodies.get(body, {}).get("outline", ())]


# ---------------------------------------------------------------- lines and areas; each function moves one to frame k
def draw_line(ax: Axes, path: Array, **style: Any) -> Update:
    """A line through `path` (frames, points, 2) [m] at each frame."""
    (line,) = ax.plot([], [], **style)

    def update(k: int) -> None:
        line.set_data(path[k, :, 0], path[k, :, 1])

    return update


def draw_area(ax: Axes, path: Array, colour: str, *, alpha: float = 0.2, zorder: float = 2) -> Update:
    """A filled polygon with the corners `path` (frames, points, 2) [m]."""
    from matplotlib.patches import Polygon

    area = Polygon(path[0], facecolor=colour, alpha=alpha, linewidth=0, zorder=zorder)
    ax.add_patch(area)

    def update(k: int) -> None:
        area.set_xy(path[k])

    return update


def draw_plate(ax: Axes, rings: Sequence[Array], colour: str, *, alpha: float = 0.25, zorder: float = 2) -> Update:
    """A filled polygon with holes: corners of each ring (frames, points, 2) [m]."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    # each ring ends where it began; holes go around the other way, so that they stay empty
    sense = [float(np.sign(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))) for x, y in (one[0].T for one in rings)]
    ways = [1 if k == 0 or one != sense[0] else -1 for k, one in enumerate(sense)]
    closed = [np.concatenate([one, one[:, :1]], axis=1)[:, ::way] for one, way in zip(rings, ways, strict=True)]
    codes = [[Path.MOVETO, *[Path.LINETO] * (one.shape[1] - 2), Path.CLOSEPOLY] for one in closed]
    corners, code = np.concatenate(closed, axis=1), np.concatenate(codes)
    area = PathPatch(Path(corners[0], code), facecolor=colour, alpha=alpha, linewidth=0, zorder=zorder)
    ax.add_patch(area)

    def update(k: int) -> None:
        area.set_path(Path(corners[k], code))

    return update


def draw_dot(ax: Axes, path: Array, **style: Any) -> Update:
    """A mark of fixed size at `path` (frames, 2) [m]; style: of the mark."""
    usual: dict[str, Any] = {"marker": "o", "linestyle": "", "color": BLACK, "markerfacecolor": "white", "zorder": 5}
    return draw_line(ax, path[:, None, :], **{**usual, **style})


def draw_tag(ax: Axes, name: str, path: Array) -> Update:
    """The name of a joint or body, beside its point `path` (frames, 2) [m]."""
    tag = ax.annotate(
        name, (0, 0), (9, 5), textcoords="offset points", fontsize=9, color=BLACK, zorder=6, parse_math=False,
        bbox=PAPER,
    )  # fmt: skip

    def update(k: int) -> None:
        tag.xy = (path[k, 0], path[k, 1])

    return update


# ---------------------------------------------------------------- the ground
def draw_foot(ax: Axes, at: Iterable[float], size: float) -> None:
    """The usual symbol of a fixed pivot, a triangle on a hatched line; `at` and `size` [m]."""
    from matplotlib.patches import Polygon

    x, y = at
    corners = [(x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)]
    ax.add_patch(Polygon(corners, facecolor="white", edgecolor=BLACK, linewidth=1, zorder=2))
    draw_wall(ax, (x - size, y - size), (x + size, y - size), 0.3 * size)


def draw_wall(ax: Axes, start: Iterable[float], end: Iterable[float], stroke: float, **style: Any) -> None:
    """A line of the ground from start to end, hatched on its right hand; `stroke` is the length of a hatch, all [m]."""
    a, b = np.array(list(start), float), np.array(list(end), float)
    length = float(np.hypot(*(b - a)))
    if not length > 0.0:
        return
    usual: dict[str, Any] = {"color": BLACK, "linewidth": 1, "zorder": 2, **style}
    ax.plot([a[0], b[0]], [a[1], b[1]], **usual)
    u = (b - a) / length
    slant = stroke * (np.array([u[1], -u[0]]) - u)
    count = max(3, min(60, round(length / (1.1 * stroke))))
    strokes = [
        (one, one + slant, (np.nan, np.nan))
        for one in a + np.linspace(0.5 * length / count, length, count)[:, None] * u
    ]
    x, y = np.array(strokes).reshape(-1, 2).T
    ax.plot(x, y, **{**usual, "linewidth": 0.6})
