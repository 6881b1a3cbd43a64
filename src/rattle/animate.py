"""The mechanism moving: bodies, joints and springs, with the play of its pins magnified beside it."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.files import atomic
from rattle.movie import Update, require_film, write_gif, write_mp4
from rattle.plot import (
    AFTER,
    BLACK,
    BLUE,
    BORE,
    CURVES,
    GREEN,
    GREY,
    LINES,
    MORE,
    ORANGE,
    PINK,
    RED,
    SKY,
    clearance_joints,
    length_unit,
    new_figure,
    pin_path,
    tidy,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.result import Result

Array = NDArray[np.float64]
MOST_INSETS = 4
SMALL = 0.2  # [m] below which a mechanism is measured in mm
BODIES = (BLUE, GREEN, ORANGE, PINK, SKY, *MORE)  # red is kept for what must not be
MOST_FRAMES = 3000


class Scene(NamedTuple):
    """What all drawing functions read: a result looked at in `frames` instants."""

    result: Result
    pick: NDArray[np.intp]  # (frames,) rows of the result
    size: float  # of the mechanism [m]

    def path(self, body: str, point: Iterable[float]) -> Array:
        """(frames, 2) positions of a point given in the frame of a body, or of the ground [m]."""
        x, y = point
        if body == "ground":
            return np.tile(np.array([x, y], float), (len(self.pick), 1))
        cx, cy, angle = (self.result[f"{body}.{what}"][self.pick] for what in ("x", "y", "angle"))
        cos, sin = np.cos(angle), np.sin(angle)
        return np.column_stack([cx + cos * x - sin * y, cy + sin * x + cos * y])

    def angle(self, body: str) -> Array:
        """(frames,) angle of a body [rad]."""
        return np.zeros(len(self.pick)) if body == "ground" else self.result[f"{body}.angle"][self.pick]


def animate(
    result: Result,
    path: str | os.PathLike[str],
    *,
    frames: int = 120,
    fps: int = 20,
    trace: Iterable[str] = (),
    dpi: float = 90.0,
    speed: float | None = None,
    names: bool = False,
) -> None:
    """Write the motion as .gif, or as .mp4 where ffmpeg is installed.

    At most `frames` pictures, evenly spaced in time, shown at `fps` per second.
    trace: names of points ("coupler.P") that leave their path behind.  names: write the names of bodies on them.
    speed: of the film against the motion, 0.1 for ten times slower; then there are as many frames as that takes.

    Raises ValueError for another suffix or an empty result, UnknownName for an unknown point and
    MissingProgram (a RuntimeError) where ffmpeg is missing.
    """
    require_film(path)
    if not fps > 0:
        raise ValueError(f"an animation needs a positive number of frames per second, got {fps}")
    if speed is not None:
        if not 0.0 < speed < math.inf:
            raise ValueError(f"speed must be positive and finite, got {speed:g}")
        frames = math.ceil(float(result.t[-1] - result.t[0]) / speed * fps) + 1 if len(result.t) else 0
        if frames > min(MOST_FRAMES, max(len(result.t), 1)):
            raise ValueError(
                f"speed {speed:g} takes {frames} frames at {fps} per second; there are {len(result.t)} outputs,"
                f" and {MOST_FRAMES} frames at most: choose a larger speed or a smaller output interval"
            )
    write = {".gif": write_gif, ".mp4": write_mp4}[Path(path).suffix.lower()]
    figure, update, count = scene(result, frames, trace, fps=fps, names=names)
    figure.set_dpi(dpi)
    with atomic(path) as file:
        write(figure, update, count, file, fps)


def scene(
    result: Result, frames: int = 120, trace: Iterable[str] = (), *, fps: int = 20, names: bool = False
) -> tuple[Figure, Update, int]:
    """The figure, the function that moves it to frame k, and the number of frames."""
    if not len(result.t):
        raise ValueError("the result has no instant to show")
    if frames < 1:
        raise ValueError(f"an animation needs at least one frame, got {frames}")
    instants = np.linspace(result.t[0], result.t[-1], min(frames, len(result.t)))
    pick = np.unique(np.searchsorted(result.t, instants - 1e-12 * (1 + abs(result.t[-1]))).clip(0, len(result.t) - 1))
    stage = Scene(result, pick, 1.0)
    low, high = _extent(stage)
    stage = stage._replace(size=float(max(high - low)) or 1.0)
    low, high = low - 0.08 * stage.size, high + 0.08 * stage.size

    pins = list(clearance_joints(result))[:MOST_INSETS]
    figure, ax, insets = _stage(high - low, len(pins))
    unit = "mm" if max(high - low) < SMALL else "m"
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel=f"x [{unit}]", ylabel=f"y [{unit}]")
    if unit == "mm":
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter(lambda value, _: f"{1e3 * value:g}")
    pace = float(result.t[pick[-1]] - result.t[pick[0]]) * fps / max(len(pick) - 1, 1)
    updates = [_clock(ax, stage, pace), *_traces(ax, stage, trace)]
    updates += _guides(ax, stage) + _springs(ax, stage) + _bodies(ax, stage) + _joints(ax, stage)
    if names:
        updates += [_tag(ax, body, stage.path(body, (0, 0))) for body in result.geometry["bodies"]]
    updates += [_inset(inset, stage, pin) for inset, pin in zip(insets, pins, strict=True)]

    def update(k: int) -> None:
        for one in updates:
            one(k)

    update(0)
    figure.canvas.draw()
    figure.set_layout_engine("none")  # laid out once: half the time of a frame
    return figure, update, len(pick)


def draw_at(ax: Axes, result: Result, k: int) -> None:
    """The mechanism at one instant of a result, without frame or labels."""
    stage = Scene(result, np.array([k]), 1.0)
    low, high = _extent(stage)
    stage = stage._replace(size=float(max(high - low)) or 1.0)
    low, high = low - 0.12 * stage.size, high + 0.12 * stage.size
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    tidy(ax).grid(False)
    ax.spines[["left", "bottom"]].set_color(LINES)
    ax.tick_params(colors=GREY, labelsize=8)
    for move in _guides(ax, stage) + _springs(ax, stage) + _bodies(ax, stage, (GREY,)) + _joints(ax, stage):
        move(0)


def _stage(extent: Array, pins: int) -> tuple[Figure, Axes, list[Axes]]:
    """One large axis for the mechanism; beside it a square one per pin, two in a column."""
    rows, columns = min(2, pins), (pins + 1) // 2
    height = float(np.clip(6.2 * extent[1] / extent[0] + 1.0, 3.2 if rows < 2 else 4.6, 6.4))
    side = 0.42 * height if rows == 2 else 2.2
    figure = new_figure(7.0 + columns * side, height)
    grid = figure.add_gridspec(max(rows, 1), 1 + columns, width_ratios=[7.0, *([side] * columns)])
    insets = [figure.add_subplot(grid[k % rows, 1 + k // rows]) for k in range(pins)]
    return figure, tidy(figure.add_subplot(grid[:, 0])), insets


def _extent(stage: Scene) -> tuple[Array, Array]:
    """Corners of the box that holds everything at every frame [m]."""
    geometry = stage.result.geometry
    paths = [stage.path(body, p) for body, form in geometry["bodies"].items() for p in form["points"].values()]
    paths += [stage.path(body, (0, 0)) for body in geometry["bodies"]]
    springs = [form for form in geometry["loads"].values() if form["type"] == "spring"]
    for part in (*geometry["joints"].values(), *springs):
        paths += [stage.path(body, p) for body, p in zip(part["bodies"], part["points"], strict=True)]
    everything = np.vstack(paths)
    everything = everything[np.isfinite(everything).all(axis=1)]
    return everything.min(axis=0), everything.max(axis=0)


# ---------------------------------------------------------------- what moves
def _clock(ax: Axes, stage: Scene, pace: float) -> Update:
    """Time, and how fast the film is against the motion."""
    t, horizon = stage.result.t[stage.pick], stage.result.trust.horizon
    title = ax.set_title("", loc="left", fontsize=11)
    against = f",  film {pace:.2g} times as fast" if pace > 0.0 and abs(pace - 1.0) > 0.01 else ""
    digits = max(2, 3 - math.floor(math.log10(float(t[-1] - t[0]) or 1.0)))

    def update(k: int) -> None:
        after = horizon is not None and t[k] > horizon
        title.set_text(f"t = {t[k]:.{digits}f} s{against}{f'   ({AFTER})' if after else ''}")

    return update


def _line(ax: Axes, path: Array, **style: Any) -> Update:
    """A line through `path` (frames, points, 2) at each frame."""
    (line,) = ax.plot([], [], **style)

    def update(k: int) -> None:
        line.set_data(path[k, :, 0], path[k, :, 1])

    return update


def _traces(ax: Axes, stage: Scene, points: Iterable[str]) -> list[Update]:
    updates: list[Update] = []
    for n, point in enumerate(points):
        x, y = stage.result[f"{point}.x"], stage.result[f"{point}.y"]
        (line,) = ax.plot([], [], color=CURVES[n % len(CURVES)], linewidth=0.8, zorder=1)

        def update(k: int, line: Any = line, x: Array = x, y: Array = y) -> None:
            line.set_data(x[: stage.pick[k] + 1], y[: stage.pick[k] + 1])

        updates.append(update)
    return updates


def _bodies(ax: Axes, stage: Scene, colours: Sequence[str] = BODIES) -> list[Update]:
    """A bar through two points, a plate through more; a single point is tied to the mass centre."""
    updates = []
    for n, (body, form) in enumerate(stage.result.geometry["bodies"].items()):
        points = np.array(list(form["points"].values()), float).reshape(-1, 2)
        if len(points) < 2:
            points = np.vstack([points, np.zeros((1, 2))])
        if len(points) > 2:
            middle = points - points.mean(axis=0)
            points = points[np.argsort(np.arctan2(middle[:, 1], middle[:, 0]))]
            points = np.vstack([points, points[:1]])
        path = np.stack([stage.path(body, p) for p in points], axis=1)
        colour = colours[n % len(colours)]
        updates.append(_line(ax, path, color=colour, linewidth=5, alpha=0.75, solid_capstyle="round", zorder=3))
        if len(points) > 2:
            updates.append(_plate(ax, path, colour))
    return updates


def _plate(ax: Axes, path: Array, colour: str) -> Update:
    from matplotlib.patches import Polygon

    plate = Polygon(path[0], facecolor=colour, alpha=0.2, linewidth=0, zorder=2)
    ax.add_patch(plate)

    def update(k: int) -> None:
        plate.set_xy(path[k])

    return update


def _joints(ax: Axes, stage: Scene) -> list[Update]:
    """Revolutes as circles (dark: driven), with a foot where one side is the ground; rods as thin bars."""
    updates: list[Update] = []
    plain: list[Array] = []
    driven: list[Array] = []
    for name, form in stage.result.geometry["joints"].items():
        a, b = (stage.path(body, p) for body, p in zip(form["bodies"], form["points"], strict=True))
        if form["type"] == "rod":
            updates.append(_line(ax, np.stack([a, b], axis=1), color=GREY, linewidth=2, zorder=2))
            plain += [a, b]
        elif form["type"] == "revolute":
            (driven if name in stage.result.geometry["driven"] else plain).append(a)
            if "ground" in form["bodies"]:
                _foot(ax, form["points"][form["bodies"].index("ground")], 0.045 * stage.size)
    for name in clearance_joints(stage.result):
        form = stage.result.geometry["joints"][name]
        updates.append(_tag(ax, name, stage.path(form["bodies"][0], form["points"][0])))
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
            updates.append(_line(ax, np.stack(paths, axis=1), **style))
    return updates


def _tag(ax: Axes, name: str, path: Array) -> Update:
    """The name of a joint, beside it."""
    from matplotlib.patheffects import withStroke

    tag = ax.annotate(name, (0, 0), (9, 5), textcoords="offset points", fontsize=9, color=BLACK, zorder=6)
    tag.set_path_effects([withStroke(linewidth=3, foreground="white")])

    def update(k: int) -> None:
        tag.xy = (path[k, 0], path[k, 1])

    return update


def _foot(ax: Axes, at: Iterable[float], size: float) -> None:
    """The usual sign of a pivot on the ground: a triangle on a hatched line."""
    from matplotlib.patches import Polygon

    x, y = at
    corners = [(x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)]
    ax.add_patch(Polygon(corners, facecolor="white", edgecolor=BLACK, linewidth=1, zorder=2))
    left, right = x - size, x + size
    ax.plot([left, right], [y - size, y - size], color=BLACK, linewidth=1, zorder=2)
    for start in np.linspace(left + 0.3 * size, right, 6):
        ax.plot([start, start - 0.3 * size], [y - size, y - 1.3 * size], color=BLACK, linewidth=0.6, zorder=2)


def _guides(ax: Axes, stage: Scene) -> list[Update]:
    """Prismatic joints: the line of the guide in A (its two walls where there is play), a block on B."""
    updates = []
    for form in stage.result.geometry["joints"].values():
        if form["type"] != "prismatic":
            continue
        (a, b), (point, _) = form["bodies"], form["points"]
        centre, start = stage.path(b, form["points"][1]), stage.path(a, point)
        turn = stage.angle(a) + form["axis"]
        along, across = np.column_stack([np.cos(turn), np.sin(turn)]), np.column_stack([-np.sin(turn), np.cos(turn)])
        travel = ((centre - start) * along).sum(axis=1)
        length, height = form.get("block") or (0.12 * stage.size, 0.07 * stage.size)
        ends = (travel.min() - 0.8 * length, travel.max() + 0.8 * length)
        walls = (-1, 1) if form["clearance"] else (0,)
        for side in walls:
            shift = side * (height / 2 + form["clearance"]) * across
            wall = np.stack([start + end * along + shift for end in ends], axis=1)
            updates.append(_line(ax, wall, color=GREY, linewidth=1.5, zorder=1))
        # the block turns with B, which keeps its angle to A as far as the play lets it
        own = turn + (stage.angle(b) - stage.angle(a)) - (stage.angle(b) - stage.angle(a))[0]
        u, n = np.column_stack([np.cos(own), np.sin(own)]), np.column_stack([-np.sin(own), np.cos(own)])
        corners = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))
        block = np.stack([centre + i * length / 2 * u + j * height / 2 * n for i, j in corners], axis=1)
        updates += [_line(ax, block, color=BLACK, linewidth=1.2, zorder=4), _plate(ax, block, GREY)]
    return updates


def _springs(ax: Axes, stage: Scene) -> list[Update]:
    updates = []
    for form in stage.result.geometry["loads"].values():
        if form["type"] != "spring":
            continue
        a, b = (stage.path(body, p)[:, None, :] for body, p in zip(form["bodies"], form["points"], strict=True))
        part = np.array([0, 0.15, *np.linspace(0.2, 0.8, 9), 0.85, 1])[None, :, None]
        side = np.array([0, 0, *([1, -1] * 5)[:9], 0, 0])[None, :, None] * 0.025 * stage.size
        length = np.maximum(np.hypot(*np.moveaxis(b - a, 2, 0))[..., None], 1e-12)
        across = np.stack([-(b - a)[..., 1], (b - a)[..., 0]], axis=-1) / length
        updates.append(_line(ax, a + part * (b - a) + side * across, color=GREY, linewidth=1.2, zorder=2))
    return updates


# ---------------------------------------------------------------- a pin, magnified
def _inset(ax: Axes, stage: Scene, joint: str) -> Update:
    """The pin centre in its clearance circle, with the force on the pin; red where N < 0."""
    from matplotlib.patches import Circle

    result, pick = stage.result, stage.pick
    form = result.geometry["joints"][joint]
    scale, unit = length_unit(form["clearance"])
    c = form["clearance"] * scale
    normal, size = result[f"{joint}.normal"], result[f"{joint}.force"]
    # typical forces fill the arrow, so that rare peaks do not shrink it
    length = np.minimum(size / (float(np.percentile(size, 80)) or 1.0), np.where(normal < 0, 0.45, 1.0)) * c
    u, v = (result[f"{joint}.{force}"] / np.maximum(size, 1e-300) * length for force in ("fx", "fy"))
    path = pin_path(result, joint)
    pieces = (len(path[0]) - 1) // max(len(result.t) - 1, 1)

    ax.add_patch(Circle((0, 0), c, facecolor=BORE, edgecolor=GREY, linewidth=1.2))
    ax.set(xlim=(-1.5 * c, 1.5 * c), ylim=(-1.5 * c, 1.5 * c), aspect="equal", xticks=[], yticks=[])
    ax.spines[:].set_visible(False)
    ax.set_title(f"{joint}: play {c:.3g} {unit}", fontsize=10)
    label = ax.set_xlabel("N", fontsize=9)
    (trail,) = ax.plot([], [], color=SKY, linewidth=2.5)
    (pin,) = ax.plot([], [], "o", markersize=6)
    arrow = ax.quiver([0.0], [0.0], [0.0], [0.0], angles="xy", scale_units="xy", scale=1.0, width=0.02, zorder=4)

    def update(k: int) -> None:
        now, before = pick[k], pick[max(k - 1, 0)]
        colour = RED if normal[now] < 0 else BLACK
        x, y = (values[before * pieces : now * pieces + 1] * scale for values in path[:2])
        trail.set_data(x, y)
        pin.set_data(x[-1:], y[-1:])
        pin.set_color(colour)
        arrow.set_offsets([[x[-1], y[-1]]])
        arrow.set_UVC([u[now]], [v[now]])
        arrow.set_color(colour)
        pulls = " (would pull)" if normal[now] < 0 else ""
        label.set_text(f"N = {normal[now]:.0f} N{pulls}".replace("-", "\N{MINUS SIGN}"))
        label.set_color(colour)

    return update
