"""Gear: pitch circles to scale, a mark for every tooth and one spoke, so that turning is seen; a ring has a rim."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rattle import registry
from rattle.plots.drawings import Form, Part, drawing
from rattle.plots.movie_file import Update
from rattle.plots.scene import Array, Pair, Scene, draw_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TEETH = 16  # marks on the smallest wheel: a model knows pitch circles, not teeth
MOST = 1000  # marks on a wheel: more, beside a tiny wheel, would lie closer than lines are wide, and fill the memory
DEPTH = 0.3  # length of a mark on either side of the pitch circle, as a share of the pitch
RIM = 3.0  # height of the rim of a ring, in such lengths
GAP = np.full((1, 2), np.nan)  # between the strokes of a line


class Wheel(NamedTuple):
    """A wheel of a gear pair, or the pinion of a rack."""

    body: str
    centre: Pair  # in the frame of its body [m]
    radius: float  # [m]
    ring: bool


def wheels(form: Form) -> list[Wheel]:
    """The wheels of a gear pair, or the pinion of a rack; none of other joints."""
    known, fields = registry.kinds("joint"), form["fields"]
    drawn_as = known[form["type"]].leaf.drawn_as if form["type"] in known else ""
    radii = {"gear": fields.get("radii", ()), "rack": (0.0, fields.get("radius", 0.0))}.get(drawn_as, ())
    return [
        Wheel(body, (point[0], point[1]), radius, n == 0 and bool(fields.get("internal")))
        for n, (body, point, radius) in enumerate(zip(form["bodies"], form["points"], radii, strict=False))
        if radius > 0.0
    ]


def around(form: Form) -> list[tuple[str, Pair]]:
    """Points around the wheels of a gear or rack."""
    turns, every = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False), wheels(form)
    rim = RIM * DEPTH * 2.0 * np.pi * min(one.radius for one in every) / TEETH
    return [
        (one.body, (one.centre[0] + r * float(np.cos(turn)), one.centre[1] + r * float(np.sin(turn))))
        for one in every
        for r in (one.radius + rim * one.ring,)
        for turn in turns
    ]


def pitch(geometry: Mapping[str, Any]) -> float:
    """Distance of the marks along all pitch circles [m], as far as whole numbers of them allow."""
    radii = [one.radius for form in geometry["joints"].values() for one in wheels(form)]
    return 2.0 * np.pi * min(radii, default=1.0) / TEETH


@drawing("gear", reach=around)
def gear(ax: Axes, scene: Scene, part: Part) -> list[Update]:
    """Draw those wheels of one pair that no joint before it has."""
    before: set[Wheel] = set()
    for name, form in scene.result.geometry["joints"].items():
        if name == part.name:
            break
        before.update(wheels(form))
    step = pitch(scene.result.geometry)
    return [draw_strokes(ax, scene, one.body, outline(one, step)) for one in wheels(part.form) if one not in before]


def draw_strokes(ax: Axes, scene: Scene, body: str, strokes: Array) -> Update:
    """Draw strokes (n, 2) [m] in the frame of a body, nan between them, in its colour."""
    path = np.stack([scene.path(body, point) for point in strokes], axis=1)
    return draw_line(ax, path, color=scene.colour(body), linewidth=1.2, zorder=2)


def outline(wheel: Wheel, step: float) -> Array:
    """Strokes (n, 2) [m] of a wheel in the frame of its body, marked about every `step` [m] up to MOST times."""
    count = max(3.0, np.round(2.0 * np.pi * wheel.radius / step))
    depth = DEPTH * step
    strokes = [_circle(wheel.radius)]
    if wheel.ring:
        strokes += [GAP, _circle(wheel.radius + RIM * depth)]
    for angle in np.linspace(0.0, 2.0 * np.pi, int(count) if count <= MOST else 0, endpoint=False):
        way = np.array([[np.cos(angle), np.sin(angle)]])
        strokes += [GAP, (wheel.radius - depth) * way, (wheel.radius + depth) * way]
    spoke = (wheel.radius, wheel.radius + RIM * depth) if wheel.ring else (0.0, wheel.radius)
    strokes += [GAP, *(np.array([[length, 0.0]]) for length in spoke)]
    return np.asarray(np.vstack(strokes) + np.array(wheel.centre))


def _circle(radius: float) -> Array:
    turn = np.linspace(0.0, 2.0 * np.pi, 97)
    return np.asarray(radius * np.column_stack([np.cos(turn), np.sin(turn)]))
