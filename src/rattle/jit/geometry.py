"""Points, ends and directions in the plane, as kernels need them, and the constraint row of an angle."""

from __future__ import annotations

import math

from rattle.jit import layout as at
from rattle.jit.choices import TINY, assume
from rattle.jit.functions import compiled

COINCIDENT = 1e-150  # distance [m] below which points have no direction: its square is near the least number
AHEAD = 1e-100  # [s] after which coincident points have a direction, if they move: no other distance is changed by it


@compiled
def turn_x(body, i, x, y):
    """Ground-frame x component [m] of the body-fixed vector (x, y) of body i."""
    return body[i, at.COS] * x - body[i, at.SIN] * y


@compiled
def turn_y(body, i, x, y):
    """Ground-frame y component [m] of the body-fixed vector (x, y) of body i."""
    return body[i, at.SIN] * x + body[i, at.COS] * y


@compiled
def ends(body, a, b, p, k):
    """The two ends of a joint or load, points p[k: k + 2] of body a and p[k + 2: k + 4] of body b, in the ground frame.

    Arms s_A and s_B from the mass centres [m], d = (r_B + s_B) - (r_A + s_A) [m] and its rate d' [m/s], x and y each.
    """
    sax = turn_x(body, a, p[k], p[k + 1])
    say = turn_y(body, a, p[k], p[k + 1])
    sbx = turn_x(body, b, p[k + 2], p[k + 3])
    sby = turn_y(body, b, p[k + 2], p[k + 3])
    wa, wb = body[a, at.W], body[b, at.W]
    dx = body[b, at.X] + sbx - body[a, at.X] - sax
    dy = body[b, at.Y] + sby - body[a, at.Y] - say
    ddx = body[b, at.VX] - wb * sby - body[a, at.VX] + wa * say
    ddy = body[b, at.VY] + wb * sbx - body[a, at.VY] - wa * sax
    return sax, say, sbx, sby, dx, dy, ddx, ddy


@compiled
def line_of(dx, dy, ddx, ddy):
    """Unit vector along d [m] and its length [m], from d and its rate d' [m/s], x and y each.

    Coincident points part along d': their line is that of an instant later, and a zero vector if they rest.
    """
    assume(dx * dx + dy * dy > TINY)
    dx, dy = dx + AHEAD * ddx, dy + AHEAD * ddy
    length = math.sqrt(dx * dx + dy * dy)
    inv = 1.0 / (length + COINCIDENT)
    return dx * inv, dy * inv, length


@compiled
def direction(body, i, angle):
    """Unit vector (x, y) in the ground frame of the direction at `angle` [rad] in the frame of body i."""
    cos, sin = math.cos(angle), math.sin(angle)
    return turn_x(body, i, cos, sin), turn_y(body, i, cos, sin)


@compiled
def angle_row(body, a, b, angle, nu, gamma, row, rows):
    """The row phi_B - phi_A - angle = 0 of a joint or driver, with its nu [rad/s] and gamma [rad/s^2]."""
    rows[row, at.RES] = body[b, at.PHI] - body[a, at.PHI] - angle
    rows[row, at.NU] = nu
    rows[row, at.GAMMA] = gamma
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = 0.0, 0.0, -1.0
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = 0.0, 0.0, 1.0


@compiled
def position_row(body, a, b, p, k, axis, position, nu, gamma, row, rows):
    """The row u . d - position = 0, u the direction at `axis` [rad] in A, d from the point of A to that of B [m].

    nu [m/s] and gamma [m/s^2] are its own, without what A's turning and the arms add.
    """
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    ux, uy = direction(body, a, axis)
    nx, ny = -uy, ux
    wa, wb = body[a, at.W], body[b, at.W]

    rows[row, at.RES] = ux * dx + uy * dy - position
    rows[row, at.NU] = nu
    rows[row, at.GAMMA] = (
        gamma
        + ux * (sbx * wb * wb - sax * wa * wa)
        + uy * (sby * wb * wb - say * wa * wa)
        - 2.0 * wa * (nx * ddx + ny * ddy)
        + wa * wa * (ux * dx + uy * dy)
    )
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -ux, -uy, ux * say - uy * sax + nx * dx + ny * dy
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = ux, uy, uy * sbx - ux * sby
