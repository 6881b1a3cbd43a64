"""Where bodies and their points are, from the positions q (3 nb,) of all bodies; the ground stays at zero."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rattle.description.model import Point
    from rattle.equations.system import System


def pose(system: System, q: np.ndarray, body: str) -> tuple[float, float, float]:
    """Position [m, m] of the mass centre of a body and its angle [rad]."""
    if body == "ground":
        return 0.0, 0.0, 0.0
    x, y, angle = q[3 * system.bodies.index(body) :][:3]
    return float(x), float(y), float(angle)


def point_at(system: System, q: np.ndarray, point: Point) -> np.ndarray:
    """Position (2,) [m] of a point of a body, or of the ground."""
    x, y, angle = pose(system, q, point.body)
    c, s = math.cos(angle), math.sin(angle)
    return np.array([x + c * point.at[0] - s * point.at[1], y + s * point.at[0] + c * point.at[1]])


def turned(angle: float, at: Sequence[float]) -> np.ndarray:
    """The vector `at` (2,) rotated by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * at[0] - s * at[1], s * at[0] + c * at[1]])
