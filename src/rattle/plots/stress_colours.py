"""Bars and cuts in a drawing that moves, coloured by their stress; moments of bars on the side that is pulled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rattle.plots.curves import BLUE, MORE, axis_label, figure_of
from rattle.plots.movie_file import Update
from rattle.plots.scene import Array, Scene
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

HIGHEST = 0.16  # of a moment diagram, as a share of the mechanism's size
PALE, DARK = 0.9, MORE[0]  # colours grow darker with the stress, from so much white on: tints that a .gif holds
WIDE = 6.0  # width of a coloured bar [pt]


class Drawn(NamedTuple):
    """What is drawn of a bar or of a cut through a plate."""

    body: str
    places: Array  # (k, 2) in the frame of the body; nan between pieces [m]
    stress: Array  # (n, k) [Pa]
    moment: Array | None  # (n, k) [N m], drawn to the side that is pulled


def draw_stress(ax: Axes, scene: Scene, bars: Sequence[Drawn]) -> list[Update]:
    """Bars at every frame, with a bar of colours beside the axes; what has no value is left out."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgb

    largest = largest_of(scene, bars)
    dark = np.array(to_rgb(DARK))
    colours = LinearSegmentedColormap.from_list("stress", [tuple(dark + PALE * (1.0 - dark)), tuple(dark)])
    factor, unit = handy_unit("Pa", largest[0])
    shades = ScalarMappable(Normalize(0.0, factor * largest[0] or 1.0), colours)
    scale = HIGHEST * scene.size / largest[1] if largest[1] > 0.0 else 0.0
    updates = [_draw_bar(ax, scene, bar, shades, factor, scale) for bar in bars]
    label = axis_label("magnitude of the stress", unit)
    figure_of(ax).colorbar(shades, ax=ax, shrink=0.8, pad=0.02).set_label(label)
    return updates


def largest_of(scene: Scene, bars: Sequence[Drawn]) -> tuple[float, float]:
    """The largest magnitudes of stress [Pa] and moment [N m] at all frames."""
    stress = max(_largest(bar.stress[scene.pick]) for bar in bars)
    moment = max(0.0 if bar.moment is None else _largest(bar.moment[scene.pick]) for bar in bars)
    return stress, moment


def _largest(values: Array) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0))


def _draw_bar(ax: Axes, scene: Scene, bar: Drawn, shades: ScalarMappable, factor: float, scale: float) -> Update:
    """A bar and its moment; scale [m/(N m)], factor: on stresses."""
    from matplotlib.collections import LineCollection

    x, y, angle = (scene.curve(f"{bar.body}.{name}")[:, None, None] for name in ("x", "y", "angle"))
    along = np.concatenate([np.cos(angle), np.sin(angle)], axis=2)
    across = np.concatenate([-np.sin(angle), np.cos(angle)], axis=2)
    axis = np.concatenate([x, y], axis=2) + bar.places[:, :1] * along + bar.places[:, 1:] * across  # (frames, k, 2)
    stress = factor * np.abs(np.nan_to_num(bar.stress[scene.pick]))
    diagram = (
        _diagram(ax, axis, scale * np.nan_to_num(bar.moment[scene.pick]), across) if bar.moment is not None else None
    )
    line = LineCollection([], cmap=shades.cmap, norm=shades.norm, linewidths=WIDE, zorder=8)
    ax.add_collection(line, autolim=False)

    def update(k: int) -> None:
        if diagram is not None:
            diagram(k)
        # each piece reaches over the next one, so that there are no gaps between them
        beyond = np.append(axis[k, 2:], axis[k, -1:], axis=0)
        beyond = np.where(np.isnan(beyond), axis[k, 1:], beyond)
        beyond[np.isnan(axis[k, 1:])] = np.nan  # nothing is drawn from one piece to another
        line.set_segments(list(np.stack([axis[k, :-1], beyond], axis=1)))
        line.set_array(0.5 * (stress[k, :-1] + stress[k, 1:]))

    update(0)
    return update


def _diagram(ax: Axes, axis: Array, sizes: Array, across: Array) -> Update:
    """Moments beside an axis (frames, k, 2); sizes: (frames, k) [m]."""
    from matplotlib.patches import Polygon

    pulled = axis - sizes[:, :, None] * across
    outline = np.concatenate([axis, pulled[:, ::-1]], axis=1)
    area = Polygon(outline[0], facecolor=BLUE, alpha=0.2, linewidth=0, zorder=6)
    ax.add_patch(area)
    (edge,) = ax.plot([], [], color=BLUE, linewidth=1.0, zorder=7)

    def update(k: int) -> None:
        area.set_xy(outline[k])
        edge.set_data(*pulled[k].T)

    return update
