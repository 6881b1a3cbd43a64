"""Points and frames in the plane, in the letters of the kernels.

`body` is an array (nb + 1, 8), one row per body, row 0 the ground.  Its columns are named here.
"""

from __future__ import annotations

from rattle.catalog import compiled

# columns of `body`: mass centre [m], angle [rad], their rates, cosine and sine of the angle
X, Y, PHI, VX, VY, W, COS, SIN = range(8)


@compiled
def turn_x(body, i, x, y):
    """Ground-frame x component [m] of the body-fixed vector (x, y) of body i."""
    return body[i, COS] * x - body[i, SIN] * y


@compiled
def turn_y(body, i, x, y):
    """Ground-frame y component [m] of the body-fixed vector (x, y) of body i."""
    return body[i, SIN] * x + body[i, COS] * y
