"""What all drawings of a mechanism share: places of its points, colours of its bodies, lines and areas that move."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.plots.curves import BLACK, BLUE, GREEN, GREY, MORE, ORANGE, PINK, RED, SKY
from rattle.plots.movie_file import Update
from rattle.plots.orbit import pin_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rattle.results.result import Result

Array = NDArray[np.float64]
Pair = tuple[float, float]
FIRST = (BLUE, GREEN, ORANGE, PINK, SKY, *MORE)  # red is kept for forces that a bush cannot give
DARKER = (1.0, 0.62, 0.36)  # further bodies have the same colours, mixed with so much black
# behind a name; a white outline instead would turn it into curves in an .svg
PAPER = {"boxstyle": "square,pad=0.05", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
COLOURS = {
    "black": BLACK, "grey": GREY, "metal": "#8C959F", "steel": "#D8DEE4", "paper": "#FFFFFF",
    "red": RED, "green": GREEN, "pink": PINK, "sky": SKY,
}  # fmt: skip
PIXEL = 0.75  # [pt]


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
        bodies: Mapping[str, Any] = self.result.geometry["bodies"]
        return bodies

    def path(self, body: str, point: Iterable[float]) -> Array:
        """(frames, 2) positions [m] of a point given in the frame of a body or of the ground."""
        x, y = point
        if body == "ground":
            return np.tile(np.array([x, y], float), (len(self.pick), 1))
        cx, cy, angle = (self.result[f"{body}.{what}"][self.pick] for what in ("x", "y", "angle"))
        cos, sin = np.cos(angle), np.sin(angle)
        return np.column_stack([cx + cos * x - sin * y, cy + sin * x + cos * y])

    def at(self, body: str, x: Any, y: Any) -> tuple[Array, Array]:
        """The same as two arrays (frames,)."""
        path = self.path(body, (x, y))
        return path[:, 0], path[:, 1]

    def curve(self, name: str) -> Array:
        """(frames,) a curve, 0 where there is none."""
        return self.result[name][self.pick] if name in self.result else np.zeros(len(self.pick))

    def trail(self, joint: str, share: float) -> Array:
        """(frames, n, 2) where a pin was in its bush for such a share of the motion [m], from the first instant on."""
        x, y, _ = pin_path(self.result, joint)
        pieces = (len(x) - 1) // max(len(self.result.t) - 1, 1)
        back = np.arange(-math.ceil(share * len(x)), 1)
        rows = np.maximum(pieces * self.pick[:, None] + back, 0)
        return np.stack([x[rows], y[rows]], axis=-1)

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

    def written(self, colour: tuple[str, float] | None) -> str | None:
        """A colour of a display list, by its name and the share of paper in it."""
        if colour is None:
            return None
        name, paper = colour
        own = COLOURS[name] if name in COLOURS else self.colour(name.removeprefix("body "))
        return "#" + "".join(f"{round(x + paper * (255 - x)):02X}" for x in bytes.fromhex(own[1:]))


# ---------------------------------------------------------------- lines and areas; each function moves one to frame k
def draw_line(ax: Axes, path: Array, **style: Any) -> Update:
    """A line through `path` (frames, points, 2) [m] at each frame."""
    (line,) = ax.plot([], [], **style)

    def update(k: int) -> None:
        line.set_data(path[k, :, 0], path[k, :, 1])

    return update


def draw_area(ax: Axes, path: Array, colour: str, alpha: float, zorder: float, name: str | None = None) -> Update:
    """A filled polygon with the corners `path` (frames, points, 2) [m]; name: of its group in an .svg."""
    from matplotlib.patches import Polygon

    area = Polygon(path[0], facecolor=colour, alpha=alpha, linewidth=0, zorder=zorder, gid=name)
    ax.add_patch(area)

    def update(k: int) -> None:
        area.set_xy(path[k])

    return update


def draw_plate(
    ax: Axes, rings: Sequence[Array], colour: str, alpha: float, zorder: float, name: str | None = None
) -> Update:
    """A filled polygon with holes: corners of each ring (frames, points, 2) [m]; name: as above."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    # each ring ends where it began; holes go around the other way, so that they stay empty
    sense = [float(np.sign(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))) for x, y in (ring[0].T for ring in rings)]
    ways = [1 if k == 0 or sign != sense[0] else -1 for k, sign in enumerate(sense)]
    closed = [np.concatenate([ring, ring[:, :1]], axis=1)[:, ::way] for ring, way in zip(rings, ways, strict=True)]
    codes = [[Path.MOVETO, *[Path.LINETO] * (ring.shape[1] - 2), Path.CLOSEPOLY] for ring in closed]
    corners, code = np.concatenate(closed, axis=1), np.concatenate(codes)
    area = PathPatch(Path(corners[0], code), facecolor=colour, alpha=alpha, linewidth=0, zorder=zorder, gid=name)
    ax.add_patch(area)

    def update(k: int) -> None:
        area.set_path(Path(corners[k], code))

    return update


def draw_name(ax: Axes, name: str, path: Array, **style: Any) -> Update:
    """The name of a joint or body, beside its point `path` (frames, 1, 2) [m]; nan: it is not there."""
    tag = ax.annotate(
        name, (0, 0), (7.5, 7.5), textcoords="offset points", fontsize=9, parse_math=False, bbox=PAPER, **style
    )

    def update(k: int) -> None:
        tag.set_visible(bool(np.isfinite(path[k]).all()))
        tag.xy = (path[k, 0, 0], path[k, 0, 1])

    return update
