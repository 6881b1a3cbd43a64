"""Points and frames in the plane."""

from __future__ import annotations

from rattle.jit import layout as at
from rattle.jit.functions import compiled


@compiled
def turn_x(body, i, x, y):
    """Ground-frame x component [m] of the body-fixed vector (x, y) of body i."""
    return body[i, at.COS] * x - body[i, at.SIN] * y


@compiled
def turn_y(body, i, x, y):
    """Ground-frame y component [m] of the body-fixed vector (x, y) of body i."""
    return body[i, at.SIN] * x + body[i, at.COS] * y
