"""What the kernels of all oil films share: the velocity that the film sees, the place of the pin, the books.

See `rattle.elements.film` for the derivation, and for p[k:], whose places have names here.
"""

from __future__ import annotations

import math

from rattle.jit.functions import compiled

FORCE, CLEARANCE, SHEAR, LEAST, FULL, WETTED, START = range(7)  # places in p[k:]


@compiled
def seen_velocity(ex, ey, vx, vy, wa, wb):
    """v [m/s] of Reynolds' equation from e [m], its rate [m/s] and the rates of both bodies [rad/s]."""
    wm = 0.5 * (wa + wb)
    return vx + wm * ey, vy - wm * ex


@compiled
def relative_place(ex, ey, p, k):
    """e/c as two numbers, and 1 - |e|/c, no thinner than the least film; |e| [m] at the end."""
    c = p[k + CLEARANCE]
    size = math.sqrt(ex * ex + ey * ey)
    scale = 1.0 / c
    gap = (c - size) * scale
    if gap < p[k + LEAST]:
        gap = p[k + LEAST]
        scale = (1.0 - gap) / size
    return ex * scale, ey * scale, gap, size


@compiled
def book(ex, ey, ux, uy, fx, fy, wa, wb, arc, p, k, out):
    """Write the force F [N], the moments [N*m] and the loss [W]; u: the velocity v, arc: int dphi/H."""
    dw = wb - wa
    shear = p[k + SHEAR] * dw * arc
    half = 0.5 * (ex * fy - ey * fx)
    out[0] = fx
    out[1] = fy
    out[2] = shear - half
    out[3] = -shear - half
    out[4] = -fx * ux - fy * uy + shear * dw
