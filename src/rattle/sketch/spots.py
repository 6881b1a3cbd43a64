"""Places on bodies, by name or by coordinates, as numbers at a position and as text of the model file."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rattle.description.model import GROUND, Point
from rattle.equations.placement import point_at
from rattle.errors import InputError, suggest
from rattle.mechanism import Mechanism

Place = str | tuple[str, tuple[float, float]]  # "coupler.B", or a body and where in its frame [m]


class Spot(NamedTuple):
    """A place on a body."""

    point: Point  # its name is "" where it has none
    label: str
    x: str  # its coordinates in the ground plane, as expressions of the model file
    y: str
    vx: str  # their rates
    vy: str

    def at(self, m: Mechanism, q: np.ndarray) -> np.ndarray:
        """Where it is (2,) [m] at positions q (3 nb,)."""
        return point_at(m.system, q, self.point)


def spot(m: Mechanism, place: Place) -> Spot:
    """A place of a mechanism.  Raises InputError for a body or point that it does not have."""
    if isinstance(place, str):
        body, _, name = place.partition(".")
        points = dict(m.model.ground) if body == GROUND else _body_points(m, body)
        if body == GROUND and f"{GROUND}.{name}" in m.model.bodies:
            return _named(Point(f"{GROUND}.{name}", "", (0.0, 0.0)), place)
        if name not in points:
            raise InputError(f"'{body}' has no point '{name}'{suggest(name, list(points))}")
        return _named(Point(body, name, points[name]), place)
    body, (x, y) = place[0], map(float, place[1])
    if body != GROUND:
        _body_points(m, body)
    if not (math.isfinite(x) and math.isfinite(y)):
        raise InputError(f"a place on '{body}' needs two finite numbers")
    label, point = f"{body} at ({x:.4g}, {y:.4g}) m", Point(body, "", (x, y))
    if body == GROUND:
        return Spot(point, label, f"({x!r})", f"({y!r})", "0", "0")
    c, s = f"cos({body}.angle)", f"sin({body}.angle)"
    across, along = f"({x!r}*{s} + {y!r}*{c})", f"({x!r}*{c} - {y!r}*{s})"
    return Spot(
        point, label, f"({body}.x + {along})", f"({body}.y + {across})",
        f"({body}.vx - {body}.omega*{across})", f"({body}.vy + {body}.omega*{along})",
    )  # fmt: skip


def _body_points(m: Mechanism, body: str) -> dict[str, tuple[float, float]]:
    if body not in m.model.moving_bodies:
        raise InputError(f"there is no body '{body}'{suggest(body, [*m.model.moving_bodies, GROUND])}")
    return dict(m.model.bodies[body].points)


def _named(point: Point, name: str) -> Spot:
    return Spot(point, name, *(f"{name}.{key}" for key in ("x", "y", "vx", "vy")))
