"""A roller on a curve of a body, given in polar form: the distance of its centre from the nearest point of the curve.

q: centre of the roller in the frame of the curve;  C(a) = f(a) e(a), e = (cos a, sin a), p: e turned by 90 deg

C' = f' e + f p,   s = |C'|,   t = C'/s,   n = (f e - f' p)/s (outwards),   k = (f^2 + 2 f'^2 - f f'')/s^3 (convex: > 0)

(q - C(a)) . C'(a) = 0     nearest point: Newton's method, from the direction of q
D = (q - C) . n            distance;  its slope by q is n, its second derivative b t t^T with b = k/(1 + k D)
D'' = n . q'' + b (t . q')^2

Source: do Carmo, Differential Geometry of Curves and Surfaces (1976), sections 1-5 and 1-7 (parallel curves).
"""

from __future__ import annotations

import math

from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import compiled
from rattle.language.local_jet import function_jet

STEPS = 8  # of Newton's method: always as many, so that the calculation can be recorded
LONG = 0.5  # [rad] by which no step is longer
FLAT = 0.1  # least 1 + k D that a step counts with: beyond the centre of curvature nothing is nearest
ROLLER = 5  # place of the radius of the roller among the parameters of a joint, after the points and the curve


@compiled
def above(p, k, x, y):
    """Distance [m] of (x, y), in the frame of the curve p[k], from it; its slope (2) there, and b [1/m]."""
    a = math.atan2(y, x)
    for _ in range(STEPS):
        f, df, ddf = function_jet(p, k, a)
        cos, sin = math.cos(a), math.sin(a)
        along, across = x * cos + y * sin - f, y * cos - x * sin
        square = f * f + df * df
        # (q - C) . C' and minus its slope by a, square (1 + k D)
        ahead = along * df + across * f
        bend = square - along * (ddf - f) - 2.0 * across * df
        step = ahead / select(bend > FLAT * square, bend, FLAT * square)
        a += step / math.sqrt(1.0 + (step / LONG) * (step / LONG))
    f, df, ddf = function_jet(p, k, a)
    cos, sin = math.cos(a), math.sin(a)
    square = f * f + df * df
    inv = 1.0 / math.sqrt(square)
    nx, ny = (f * cos + df * sin) * inv, (f * sin - df * cos) * inv
    distance = (x - f * cos) * nx + (y - f * sin) * ny
    curvature = (square + df * df - f * ddf) * inv * inv * inv
    return distance, nx, ny, curvature / (1.0 + curvature * distance)


@compiled
def roller_at(body, a, p, k, dx, dy, ux, uy):
    """`above` for the offset d [m] of a roller on body a: distance, normal, and the terms of D'' without accelerations.

    u [m/s]: rate of d.  Returns D, n (2) in the axes of the ground, D' and those terms [m/s^2].
    """
    cos, sin, w = body[a, at.COS], body[a, at.SIN], body[a, at.W]
    distance, mx, my, b = above(p, k, cos * dx + sin * dy, cos * dy - sin * dx)
    nx, ny = cos * mx - sin * my, sin * mx + cos * my
    vx, vy = ux + w * dy, uy - w * dx  # of the roller's centre as seen from the curve
    slip = ny * vx - nx * vy
    rest = 2.0 * w * (nx * vy - ny * vx) + w * w * (nx * dx + ny * dy) + b * slip * slip
    return distance, nx, ny, nx * vx + ny * vy, rest
