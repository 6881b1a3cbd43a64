"""Animation of a mechanism: bodies, joints and springs, with its joints with play magnified beside it."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rattle.atomic_file import atomic
from rattle.drawings.forms import display_list
from rattle.drawings.played import Stage
from rattle.errors import InputError
from rattle.plots.curves import AFTER, BLACK, CURVES, RED, length_axes, new_figure, tidy
from rattle.plots.movie_file import Update, require_film, write_gif, write_mp4
from rattle.plots.orbit import require_point
from rattle.plots.power_arrows import draw_power
from rattle.plots.scene import Scene
from rattle.plots.sketch import draw_layers, draw_shapes, extent
from rattle.plots.stress_colours import HIGHEST, draw_stress
from rattle.results.handy_units import handy_unit, units_of_result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.result import Result

Array = NDArray[np.float64]
MOST_INSETS = 4
ACROSS = 136.0  # pixels of an inset in a page, in which marks have these sizes
MOST_FRAMES = 3000
MARGIN = 0.08  # around what moves, as a share of the mechanism's size


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
    power: bool = False,
    stress: bool = False,
) -> None:
    """Write the motion as .gif, or as .mp4 if ffmpeg is installed.

    At most `frames` pictures, evenly spaced in time, shown at `fps` [1/s].
    trace: names of points ("coupler.P") whose paths are drawn.  names: label the bodies with their names.
    power: arrows through joints, and from drivers and loads, whose width is the power.
    stress: bars with section and material, and necks of plates, have the colour of their stress, bars their moments
            beside them.
    speed: of the animation relative to the motion, 0.1 for ten times slower; it sets the number of frames.
    dpi: resolution [1/inch].

    Raises InputError for another suffix or an empty result, UnknownName for an unknown point and
    MissingProgram (a RuntimeError) if ffmpeg is missing.
    """
    require_film(path)
    if not result.geometry["bodies"]:
        raise InputError("this result holds curves only, no motion of bodies that could be shown")
    if not fps > 0:
        raise InputError(f"an animation needs a positive number of frames per second, got {fps}")
    if speed is not None:
        if not 0.0 < speed < math.inf:
            raise InputError(f"speed must be positive and finite, got {speed:g}")
        frames = math.ceil(float(result.t[-1] - result.t[0]) / speed * fps) + 1 if len(result.t) else 0
        if frames > min(MOST_FRAMES, max(len(result.t), 1)):
            raise InputError(
                f"speed {speed:g} needs {frames} frames at {fps} per second, but the result has {len(result.t)} outputs"
                f" and {MOST_FRAMES} frames are allowed: choose a larger speed or a smaller output interval"
            )
    write = {".gif": write_gif, ".mp4": write_mp4}[Path(path).suffix.lower()]
    figure, update, count = scene(result, frames, trace, fps=fps, names=names, power=power, stress=stress)
    figure.set_dpi(dpi)
    with atomic(path) as file:
        write(figure, update, count, file, fps)


def scene(
    result: Result, frames: int = 120, trace: Iterable[str] = (), *, fps: int = 20, names: bool = False,
    power: bool = False, stress: bool = False,
) -> tuple[Figure, Update, int]:  # fmt: skip
    """The figure, the function that changes it to frame k, and the number of frames; arguments as of `animate`."""
    if not len(result.t):
        raise InputError("the result has no instant to show")
    if frames < 1:
        raise InputError(f"an animation needs at least one frame, got {frames}")
    instants = np.linspace(result.t[0], result.t[-1], min(frames, len(result.t)))
    pick = np.unique(np.searchsorted(result.t, instants - 1e-12 * (1 + abs(result.t[-1]))).clip(0, len(result.t) - 1))
    stage = Scene(result, pick, 1.0)
    low, high = extent(stage._replace(pick=np.arange(len(result.t))))  # of all instants: paths go on between frames
    stage = stage._replace(size=float(max(high - low)) or 1.0)
    margin = MARGIN + (HIGHEST if stress else 0.0)
    low, high = low - margin * stage.size, high + margin * stage.size

    written = display_list(result.geometry)
    loose = [picture for picture in written["magnified"] if _has_play(result, picture["joint"])][:MOST_INSETS]
    figure, ax, insets = _axes(high - low, len(loose))
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    length_axes(ax, float(max(high - low)), units_of_result(result.provenance))
    pace = float(result.t[pick[-1]] - result.t[pick[0]]) * fps / max(len(pick) - 1, 1)
    updates = [_clock(ax, stage, pace), *_traces(ax, stage, trace)]
    drawn = Stage(written, result.geometry, stage, stage.size)
    updates += draw_layers(ax, stage, drawn, ("drawn", "pins", "names") if names else ("drawn", "pins"))
    if power:
        updates += draw_power(ax, stage, result.power())
    if stress:
        updates += draw_stress(ax, stage, [result.strength(name).drawn for name in _stressed(result)])
    small = Stage(written, result.geometry, stage, 1.0, ACROSS)
    for inset, picture in zip(insets, loose, strict=True):
        updates += _inset(inset, stage, small, picture)

    def update(k: int) -> None:
        for change in updates:
            change(k)

    update(0)
    figure.canvas.draw()
    figure.set_layout_engine("none")  # laid out once: half the time of a frame
    return figure, update, len(pick)


def _stressed(result: Result) -> list[str]:
    """Names of the bars with section and material, and of the necks of plates, in the model of a result.

    Raises InputError without any.
    """
    bodies = json.loads(str(result.provenance.get("document") or "{}")).get("bodies", {})
    names = [name for name, body in bodies.items() if {"bar", "section", "material"} <= set(body)]
    names += [f"{name}.{neck}" for name, body in bodies.items() for neck in body.get("necks", {})]
    if not names:
        raise InputError("stress: no bar of this result has a section and a material, and no plate has necks")
    return names


def _has_play(result: Result, joint: str) -> bool:
    return bool(result.geometry["joints"][joint]["clearance"] > 0.0) and f"{joint}.ex" in result


def _axes(extent: Array, pins: int) -> tuple[Figure, Axes, list[Axes]]:
    """A large axis for the mechanism; beside it a square one for each joint with play, two in a column."""
    rows, columns = min(2, pins), (pins + 1) // 2
    height = float(np.clip(6.2 * extent[1] / extent[0] + 1.0, 3.2 if rows < 2 else 4.6, 6.4))
    side = 0.42 * height if rows == 2 else 2.2
    figure = new_figure(7.0 + columns * side, height)
    grid = figure.add_gridspec(max(rows, 1), 1 + columns, width_ratios=[7.0, *([side] * columns)])
    insets = [figure.add_subplot(grid[k % rows, 1 + k // rows]) for k in range(pins)]
    return figure, tidy(figure.add_subplot(grid[:, 0])), insets


# ---------------------------------------------------------------- what moves
def _clock(ax: Axes, stage: Scene, pace: float) -> Update:
    """The time as title, and how fast the animation is relative to the motion."""
    t, horizon = stage.result.t[stage.pick], stage.result.trust.horizon
    title = ax.set_title("", loc="left", fontsize=11)
    against = f",  shown {pace:.2g} times as fast" if pace > 0.0 and abs(pace - 1.0) > 0.01 else ""
    digits = max(2, 3 - math.floor(math.log10(float(t[-1] - t[0]) or 1.0)))

    def update(k: int) -> None:
        after = horizon is not None and t[k] > horizon
        title.set_text(f"t = {t[k]:.{digits}f} s{against}{f'   ({AFTER})' if after else ''}")

    return update


def _traces(ax: Axes, stage: Scene, points: Iterable[str]) -> list[Update]:
    updates: list[Update] = []
    for n, point in enumerate(points):
        require_point(stage.result, point)
        x, y = stage.result[f"{point}.x"], stage.result[f"{point}.y"]
        (line,) = ax.plot([], [], color=CURVES[n % len(CURVES)], linewidth=0.8, zorder=1)

        def update(k: int, line: Any = line, x: Array = x, y: Array = y) -> None:
            line.set_data(x[: stage.pick[k] + 1], y[: stage.pick[k] + 1])

        updates.append(update)
    return updates


# ---------------------------------------------------------------- a joint with play, magnified
def _inset(ax: Axes, scene: Scene, stage: Stage, picture: Mapping[str, Any]) -> list[Update]:
    """A pin in its bush or a block in its guide, with the force on it; red where N < 0."""
    result, joint = scene.result, picture["joint"]
    scale, unit = handy_unit("m", result.geometry["joints"][joint]["clearance"])
    ax.set(xlim=(-0.5, 0.5), ylim=(-0.5, 0.5), aspect="equal", xticks=[], yticks=[])
    ax.spines[:].set_visible(False)
    ax.set_title(f"{joint}: play {result.geometry['joints'][joint]['clearance'] * scale:.3g} {unit}", fontsize=10)
    label, normal = ax.set_xlabel("N", fontsize=9), scene.curve(f"{joint}.normal")

    def update(k: int) -> None:
        pulls = " (would pull)" if normal[k] < 0 else ""
        label.set_text(f"N = {normal[k]:.0f} N{pulls}".replace("-", "\N{MINUS SIGN}"))
        label.set_color(RED if normal[k] < 0 else BLACK)

    return [*draw_shapes(ax, scene, stage.shapes_of(picture["drawn"])), update]
