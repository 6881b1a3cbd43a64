"""Arrows of power in a drawing that moves: through joints from body to body, from drivers and loads into bodies."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from rattle.jit.choices import TINY
from rattle.plots.bulk import short
from rattle.plots.curves import BLACK, ORANGE, note
from rattle.plots.movie_file import Update
from rattle.plots.scene import Array, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes


LENGTH, WIDTH = 0.13, 0.05  # of the longest arrow's shaft and width, as a share of the mechanism's size
USUAL = 98.0  # percentile of all frames that has this width: rare peaks do not make the others vanish
LEAST = 0.01  # share of it below which there is no arrow

APART = 0.05  # distance between two ends, as a share of the mechanism's size, from which power goes along them


class Powers(Protocol):
    """What is drawn of a power: see `Result.power`."""

    @property
    def names(self) -> Mapping[str, Sequence[str]]:
        """Element, kind and body of every port."""

    @property
    def driven(self) -> Mapping[str, str]:
        """The joint of every driver."""

    @property
    def between(self) -> Collection[str]:
        """Elements that pass power from one body to another."""

    def powers(self, t: Array) -> Array:
        """Powers (n, ports) [W] into the bodies at instants (n,) [s]."""


def draw_power(ax: Axes, stage: Scene, p: Powers) -> list[Update]:
    """Arrows whose width is the power of every element at each frame; gravity has none."""
    powers = p.powers(stage.result.t[stage.pick])
    sizes = np.abs(powers).max(axis=1, initial=0.0)
    usual = float(np.percentile(sizes, USUAL)) if len(sizes) else 0.0
    if not usual > 0.0:
        return []
    note(ax, f"arrows: power, the widest {short(usual)} W", "right")
    ports: dict[str, list[int]] = {}
    for k, name in enumerate(p.names["element"]):
        ports.setdefault(name, []).append(k)
    updates = []
    for name, mine in ports.items():
        form = form_of(stage, p.driven, name)
        if form is None:
            continue
        bodies = [p.names["body"][k] for k in mine]
        first, spot = stage.ends(form)
        centres = [stage.path(body, (0.0, 0.0)) for body in bodies]
        if len(mine) == 2 and name in p.between:
            power = 0.5 * (powers[:, mine[1]] - powers[:, mine[0]]) / usual
            apart = np.hypot(*(spot - first).T)[:, None] > APART * stage.size  # a rod or a spring
            way = np.where(apart, spot - first, centres[1] - centres[0])
            updates.append(_through(ax, stage.size, np.where(apart, 0.5 * (first + spot), spot), way, power))
        else:
            updates += [
                _into(ax, stage.size, spot, centre - spot, powers[:, k] / usual)
                for k, centre in zip(mine, centres, strict=True)
            ]
    return updates


def form_of(stage: Scene, driven: Mapping[str, str], name: str) -> Mapping[str, Any] | None:
    """Bodies and points of an element; a driver has those of its joint.  None if it has no place."""
    geometry = stage.result.geometry
    form: Mapping[str, Any] | None = geometry["loads"].get(name) or geometry["joints"].get(driven.get(name, name))
    return form


def _through(ax: Axes, size: float, spot: Array, way: Array, power: Array) -> Update:
    """An arrow across a joint, in the direction of its power; way (frames, 2): from body A to body B."""
    along = _unit(way, size) * np.sign(power)[:, None]
    return _arrow(ax, size, spot - 0.5 * LENGTH * size * along, along, np.abs(power))


def _into(ax: Axes, size: float, spot: Array, way: Array, power: Array) -> Update:
    """An arrow that comes to a point from outside, or leaves from there; way (frames, 2): into the body."""
    into = _unit(way, size)
    start = spot - np.where(power > 0.0, LENGTH * size, 0.0)[:, None] * into
    return _arrow(ax, size, start, into * np.sign(power)[:, None], np.abs(power))


def _unit(way: Array, size: float) -> Array:
    """Directions (frames, 2); down to the right where a body turns about the point itself."""
    length = np.hypot(*way.T)[:, None]
    return np.asarray(np.where(length > 1e-9 * size, way / np.maximum(length, TINY), np.sqrt(0.5) * np.array([1, -1])))


def _arrow(ax: Axes, size: float, start: Array, along: Array, share: Array) -> Update:
    """An arrow from start (frames, 2) along a direction; share (frames,) of the greatest width."""
    from matplotlib.patches import Polygon

    patch = Polygon(np.zeros((7, 2)), facecolor=ORANGE, edgecolor=BLACK, linewidth=0.4, alpha=0.85, zorder=7)
    ax.add_patch(patch)
    across = np.column_stack([-along[:, 1], along[:, 0]])
    half = 0.5 * WIDTH * size * np.minimum(share, 1.5)
    head = np.minimum(0.6 * LENGTH * size, 2.4 * half + 0.02 * size)
    neck = start + (LENGTH * size - head)[:, None] * along
    tip, side, wing = start + LENGTH * size * along, half[:, None] * across, (1.8 * half)[:, None] * across
    corners = np.stack([start + side, neck + side, neck + wing, tip, neck - wing, neck - side, start - side], axis=1)

    def update(k: int) -> None:
        patch.set_visible(bool(share[k] > LEAST))
        patch.set_xy(corners[k])

    return update
