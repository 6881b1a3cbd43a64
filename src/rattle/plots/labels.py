"""Names beside what they name: each where it covers neither another name nor, as far as possible, a line.

Names are placed one after the other.  A name tries sixteen directions and several distances from its point and takes
the place of least cost: other names and the edge of the picture count most, then lines and marks that it would cover,
then the distance.  The same picture gives the same places.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.plots.curves import BLACK, GREY, figure_of
from rattle.plots.scene import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation

Array = NDArray[np.float64]
DISTANCES = (5.0, 9.0, 15.0, 23.0, 33.0, 45.0, 60.0, 80.0, 105.0)  # of a name from its point [pt]
FIRST = np.pi / 4  # direction that is tried first [rad]: right above
LEADER = 12.0  # distance [pt] from which on a thin line leads to the point
SPACING = 3.0  # of the points that stand for lines [pt]
NAME, EDGE, LINE = 1e6, 1e4, 20.0  # cost of covering another name, the edge, one point of a line
SETTLED = 3  # layouts after which axes of fixed scale stay in their place
AIR = 1.5  # around a name [pt]


class Label(NamedTuple):
    """A name and the point that it belongs to."""

    text: str
    at: tuple[float, float]  # in the data of the axes
    colour: str = BLACK
    style: str = "normal"  # or italic
    size: float = 8.5  # [pt]


class Box(NamedTuple):
    """Rectangles [pt]: one each, or (n,) arrays."""

    x0: Any
    y0: Any
    x1: Any
    y1: Any

    def overlaps(self, other: Box) -> Any:
        """Where they overlap."""
        return (self.x0 < other.x1) & (other.x0 < self.x1) & (self.y0 < other.y1) & (other.y0 < self.y1)


def place_labels(ax: Axes, labels: Sequence[Label]) -> list[Annotation]:
    """Write the names into finished axes; their limits and size must not change any more."""
    figure = figure_of(ax)
    for _ in range(SETTLED):
        figure.draw_without_rendering()
    points = 72.0 / figure.dpi
    lines = points * drawn_points(ax, SPACING / points)
    frame = ax.get_window_extent()
    edge = Box(*(points * side for side in (frame.x0, frame.y0, frame.x1, frame.y1)))
    taken: list[Box] = []
    written = []
    for label in labels:
        text = ax.annotate(
            label.text, label.at, (0, 0), textcoords="offset points", ha="center", va="center", color=label.colour,
            fontsize=label.size, fontstyle=label.style, zorder=8, parse_math=False, annotation_clip=False,
            bbox=PAPER,
        )  # fmt: skip
        extent = text.get_window_extent()
        half = points * np.array([extent.width, extent.height]) / 2 + AIR
        anchor = points * ax.transData.transform(label.at)
        offset, box, distance = _best(anchor, half, taken, lines, edge)
        taken.append(box)
        text.set_position((float(offset[0]), float(offset[1])))
        if distance >= LEADER:
            end = offset - np.clip(offset, -half, half)  # of the box, nearest to the point
            line = ax.annotate(
                "", label.at, (float(end[0]), float(end[1])), textcoords="offset points", annotation_clip=False,
                arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 2}, zorder=7,
            )  # fmt: skip
            line.set_in_layout(False)
        text.set_in_layout(False)
        written.append(text)
    return written


def _best(anchor: Array, half: Array, taken: Sequence[Box], lines: Array, edge: Box) -> tuple[Array, Box, float]:
    """Offset (2,) [pt] of the middle of a name from its point, its box and its distance."""
    turns = FIRST + np.array([0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6, 7, -7, 8]) * np.pi / 8
    distance = np.repeat(DISTANCES, len(turns))
    way = np.tile(np.column_stack([np.cos(turns), np.sin(turns)]), (len(DISTANCES), 1))
    # the edge of the box, not its middle, is at this distance: it is reached first across or first upwards
    with np.errstate(divide="ignore"):
        inside = (half / np.abs(way).clip(1e-9)).min(axis=1)
    offset = way * (distance + inside)[:, None]
    low, high = anchor + offset - half, anchor + offset + half
    box = Box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    cost = distance + 0.05 * np.arange(len(distance)) / len(distance)
    for other in taken:
        cost = cost + NAME * box.overlaps(other)
    out = (box.x0 < edge.x0) | (box.y0 < edge.y0) | (box.x1 > edge.x1) | (box.y1 > edge.y1)
    cost = cost + EDGE * out + LINE * _covered(box, lines)
    k = int(np.argmin(cost))
    return offset[k], Box(*(float(side[k]) for side in box)), float(distance[k])


def _covered(box: Box, lines: Array) -> NDArray[np.intp]:
    """(n,) number of the points (m, 2) inside each of n boxes."""
    near = (lines > (box.x0.min(), box.y0.min())).all(axis=1) & (lines < (box.x1.max(), box.y1.max())).all(axis=1)
    x, y = lines[near].T
    return np.array(
        [int(((x > x0) & (x < x1) & (y > y0) & (y < y1)).sum()) for x0, y0, x1, y1 in zip(*box, strict=True)], np.intp
    )


def drawn_points(ax: Axes, spacing: float) -> Array:
    """(n, 2) points [pixels] along all lines and outlines in the axes, so far apart, and its marks.

    Of a line that goes far out of the picture, as of a guide of kilometres, only what is in the picture.
    """
    seen = figure_of(ax).bbox.get_points()
    curves = [ax.transData.transform(np.asarray(line.get_xydata())) for line in ax.lines]
    curves += [np.asarray(patch.get_transform().transform_path(patch.get_path()).vertices) for patch in ax.patches]
    points = [np.zeros((0, 2)), *(_along(curve, spacing, seen) for curve in curves)]
    for line, curve in zip(ax.lines, curves, strict=False):
        if line.get_marker() not in ("", "None", None):
            radius = 0.5 * float(line.get_markersize()) * figure_of(ax).dpi / 72.0
            ring = np.linspace(0, 2 * np.pi, 8, endpoint=False)
            points += [curve + radius * np.array([np.cos(s), np.sin(s)]) for s in ring]
    every = np.vstack(points)
    return np.asarray(every[np.isfinite(every).all(axis=1)])


def _along(curve: Iterable[Iterable[float]], spacing: float, seen: Array) -> Array:
    """Points on a polyline, so far apart, those in the rectangle `seen`; it is interrupted where a point is nan."""
    corners = np.asarray(curve, float).reshape(-1, 2)
    most = float(np.hypot(*(seen[1] - seen[0]))) / spacing + 1.0  # also where lengths are too large to be exact
    pieces = [corners]
    for a, b in itertools.pairwise(corners):
        length = float(np.hypot(*(b - a)))
        if np.isfinite(length) and length > spacing:
            enters, leaves = _share_within(a, b, seen)
            first = max(1.0, np.ceil(enters * length / spacing))
            last = min(np.ceil(length / spacing) - 1.0, np.floor(leaves * length / spacing))
            number = first + np.arange(int(np.clip(last - first + 1.0, 0.0, most)))
            pieces.append(a + number[:, None] * spacing / length * (b - a))
    return np.vstack(pieces)


def _share_within(a: Array, b: Array, seen: Array) -> tuple[float, float]:
    """Shares of the way from a to b at which it enters and leaves a rectangle; the second is less if it misses it."""
    enters, leaves = 0.0, 1.0
    for start, way, low, high in zip(a, b - a, *seen, strict=True):
        if way == 0.0:
            enters, leaves = (enters, leaves) if low <= start <= high else (1.0, 0.0)
        else:
            near, far = sorted(((low - start) / way, (high - start) / way))
            enters, leaves = max(enters, near), min(leaves, far)
    return enters, leaves
