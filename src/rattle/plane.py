"""Points and frames in the plane, in the letters of the kernels.

`body` is an array (nb + 1, 8), one row per body, row 0 the ground; `rows` is an array (nr, 9), one
row per constraint.  Their columns are named here.
"""

from __future__ import annotations

from rattle.catalog import compiled

# columns of `body`: mass centre [m], angle [rad], their rates, cosine and sine of the angle
X, Y, PHI, VX, VY, W, COS, SIN = range(8)
# columns of `rows`: residual Phi, nu, gamma, then the Jacobian with respect to x, y, phi of A and of B
RES, NU, GAMMA, AX, AY, AP, BX, BY, BP = range(9)
# columns of `energy`: potential [J]; power of the elastic part, power from outside, dissipation [W]
POTENTIAL, ELASTIC, OUTSIDE, DISSIPATED = range(4)


@compiled
def turn_x(body, i, x, y):
    """Ground-frame x component [m] of the body-fixed vector (x, y) of body i."""
    return body[i, COS] * x - body[i, SIN] * y


@compiled
def turn_y(body, i, x, y):
    """Ground-frame y component [m] of the body-fixed vector (x, y) of body i."""
    return body[i, SIN] * x + body[i, COS] * y
