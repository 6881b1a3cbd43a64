"""The row of a contact of which one side is a disc: its centre is a point of one body, the other body has any wall.

r_d: radius of the disc (0: a point), g: gap, n: normal towards A, from the centre to the wall if the disc is on B,
from the wall to the centre if it is on A, t = n turned by 90 degrees

h = +-(r_d + g/2),  + on B, - on A        p_B = s_B + h n,  p_A = s_A + h n          s: arms to the centre of the disc
r'  velocity of B relative to A where the centre is
w_n = w + bent (t . r')                   rate at which n turns, w that of the wall's body
    n . r' = -g'                                   d/dt = J_n dv - gamma_n
    slip = t . r' + (w_B - w_A) h                  d/dt = J_t dv - gamma_t
    gamma_n = -w_n slip + t . (w_B p_B' - w_A p_A')
    gamma_t = w_n (n . r') - n . (w_B p_B' - w_A p_A')

`bent` is 0 of a straight wall, 1/l of a hollow arc about a point from which the centre is l away, -1/l of a round one
or of a corner there.
"""

from __future__ import annotations

from rattle.jit import layout as at
from rattle.jit.functions import compiled


@compiled
def write_disc(body, a, b, on_b, ax, ay, bx, by, nx, ny, gap, radius, bent, row, kinematics):
    """Write the row; (ax, ay), (bx, by): arms to the centre [m]; on_b: the disc is on B. Returns t . r' [m/s]."""
    wa, wb = body[a, at.W], body[b, at.W]
    side = 1.0 if on_b else -1.0
    vx, vy = body[b, at.VX] - body[a, at.VX], body[b, at.VY] - body[a, at.VY]
    rx, ry = vx - wb * by + wa * ay, vy + wb * bx - wa * ax
    closing, across = nx * rx + ny * ry, nx * ry - ny * rx
    turning = (wa if on_b else wb) + across * bent
    h, dh = side * (radius + 0.5 * gap), -side * 0.5 * closing
    slip = across + (wb - wa) * h
    # rates of the arms: the centre is fixed on one body, and the arms differ by the way between the mass centres
    cx, cy, w = (bx, by, wb) if on_b else (ax, ay, wa)
    dpx, dpy = -w * cy + dh * nx - h * turning * ny, w * cx + dh * ny + h * turning * nx
    dpax, dpay = (dpx + vx, dpy + vy) if on_b else (dpx, dpy)
    dpbx, dpby = (dpx, dpy) if on_b else (dpx - vx, dpy - vy)
    fx, fy = wb * dpbx - wa * dpax, wb * dpby - wa * dpay

    kinematics[row, at.GAP] = gap
    kinematics[row, at.DGAP] = -closing
    kinematics[row, at.NX], kinematics[row, at.NY] = nx, ny
    kinematics[row, at.PAX], kinematics[row, at.PAY] = ax + h * nx, ay + h * ny
    kinematics[row, at.PBX], kinematics[row, at.PBY] = bx + h * nx, by + h * ny
    kinematics[row, at.SLIP] = slip
    kinematics[row, at.ACROSS] = 0.0
    kinematics[row, at.GAMMA_N] = -turning * slip + nx * fy - ny * fx
    kinematics[row, at.GAMMA_T] = turning * closing - nx * fx - ny * fy
    return across
