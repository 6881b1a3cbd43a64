"""Stribeck's curve of a bearing: friction under a steady load over the speed, from rubbing to floating.

Film and dry contact act side by side as in a lubricated joint (see `rattle.elements.contact_laws.oiled`): the film
with the coefficients of max(h, h_b), the dry contact with N = k (h_b - h) where h < h_b, and friction mu N on the pin's
radius.  With e along x, and the pin turning at w in a bush at rest, the pin feels

    P = (F_x(e, w) - N, F_y(e, w) - mu N)

whose size grows with e: the position is the root of |P| = load, and the attitude follows from the direction of P.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Force = Callable[[float, float], tuple[float, ...]]  # of e [m] and w [rad/s], as `Film.force`
SINKS = 0.01  # of the boundary film: how far the load presses the dry contact if its stiffness is not given


def stribeck_curve(
    force: Force, load: float, speeds: Sequence[float], sizes: tuple[float, float], boundary: float, friction: float,
    stiffness: float,
) -> dict[str, Array]:  # fmt: skip
    """Columns (n,) by name, a row for each speed [rad/s] > 0.

    load [N]; sizes: radius and clearance [m]; boundary: thickness of the boundary film [m]; stiffness [N/m] of the dry
    contact.
    """
    rows = [_row(force, load, float(w), sizes, boundary, friction, stiffness) for w in speeds]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]} if rows else {}


def lift_off(force: Force, load: float, edge: float) -> float:
    """Speed [rad/s] from which the film alone carries the load [N] at the eccentricity `edge` [m]."""
    return load / math.hypot(*force(edge, 1.0)[:2])


def _row(
    force: Force, load: float, w: float, sizes: tuple[float, float], boundary: float, friction: float, stiffness: float
) -> dict[str, float]:
    from scipy.optimize import brentq

    radius, clearance = sizes
    edge = clearance - boundary

    def felt(e: float) -> tuple[float, float, float, float, float]:
        """Both parts of P [N], N [N], moment on the pin [N*m] and loss [W]."""
        fx, fy, _, moment, loss = force(e, w)
        pressed = stiffness * max(e - edge, 0.0)
        rubbing = friction * pressed * (radius - clearance)
        return fx - pressed, fy - friction * pressed, pressed, moment - rubbing, loss + rubbing * w

    def excess(x: float) -> float:
        return math.hypot(*felt(x * clearance)[:2]) / load - 1.0

    most = (edge + load / stiffness) / clearance
    e = clearance * float(brentq(excess, 0.0, most, xtol=1e-15, rtol=1e-14))
    px, py, pressed, moment, loss = felt(e)
    return {
        "speed": w,
        "eccentricity": e / clearance,
        "attitude": math.atan2(py, -px),
        "film_thickness": clearance - e,
        "dry": pressed / load,
        "friction": abs(moment) / (load * radius),
        "torque": abs(moment),
        "loss": loss,
    }
