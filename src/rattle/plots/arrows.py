"""Arrows of a drawing: forces and moments, driven and free coordinates."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
HEAD = 0.028  # length of a head, as a share of the mechanism's size


def straight(
    ax: Axes, start: Iterable[float], way: Iterable[float], size: float, both: bool = False, **style: Any
) -> Array:
    """An arrow from `start` by `way` [m]; size: of the mechanism [m]; both: with two heads.  Returns its tip (2,)."""
    a, d = np.array(list(start), float), np.array(list(way), float)
    u = d / float(np.hypot(*d))
    _head(ax, a + d, u, HEAD * size, style)
    ends = [a, a + d - 0.6 * HEAD * size * u]
    if both:
        _head(ax, a, -u, HEAD * size, style)
        ends[0] = a + 0.6 * HEAD * size * u
    ax.plot(*np.array(ends).T, **_line(style))
    return np.asarray(a + d)


def turning(
    ax: Axes, centre: Iterable[float], radius: float, sense: float, size: float, start: float = -0.6,
    both: bool = False, **style: Any,
) -> Array:  # fmt: skip
    """An arc about `centre`, counter-clockwise where sense > 0, from the angle `start` [rad]; lengths in m.

    Returns the point (2,) in its middle.
    """
    c, sweep = np.array(list(centre), float), 3.6
    angles = start + np.linspace(0.0, sweep, 40)
    if sense < 0:
        angles = angles[::-1]
    arc = c + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    for k, way in ((-1, 1.0), (0, -1.0)) if both else ((-1, 1.0),):
        tangent = way * np.sign(sense) * np.array([-np.sin(angles[k]), np.cos(angles[k])])
        # the head ends a little inside of the circle, as its straight axis does not follow the arc
        inwards = 0.12 * (c - arc[k]) / radius
        u = (tangent + inwards) / float(np.hypot(*(tangent + inwards)))
        _head(ax, arc[k] + 0.7 * HEAD * size * u, u, HEAD * size, style)
    ax.plot(*arc.T, **_line(style))
    return np.asarray(arc[len(arc) // 2])


def _line(style: dict[str, Any]) -> dict[str, Any]:
    return {"linewidth": 1.4, "zorder": 6, "solid_capstyle": "butt", **style}


def _head(ax: Axes, tip: Array, u: Array, length: float, style: dict[str, Any]) -> None:
    """The head of an arrow that points along u."""
    from matplotlib.patches import Polygon

    n = np.array([-u[1], u[0]])
    back = tip - length * u
    corners = [tip, back + 0.34 * length * n, back - 0.34 * length * n]
    ax.add_patch(Polygon(corners, facecolor=style.get("color"), linewidth=0, zorder=style.get("zorder", 6)))
