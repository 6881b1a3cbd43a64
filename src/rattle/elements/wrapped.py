"""Straight lines that touch two wheels: the line of action of involute teeth, the strand of a belt.

a, b: radii of the circles that the line touches; b < 0 where the second wheel turns the other way (inside of a ring,
open belt);  S = a + b,  d = (r_B + s_B) - (r_A + s_A),  l = |d|,  e = d/l,  p: e turned by 90 deg,  psi: direction of d

X  = a phi_A + b phi_B - S psi - c                                        turning of the wheels, along the line    [m]
F  = sqrt(l^2 - S^2) - S acos(S/l),  F' = sqrt(l^2 - S^2)/l = sin(angle of the line to p),  F'' = S^2/(l^2 sqrt(..))
g  = i X + k F + j                                                        gap; i = +1, -1 of the two lines, k = +-1
n  = i S/l p - k F' e,  |n| = 1,   at  p_A = s_A - i a q,  p_B = s_B + i b q,   q: n turned by 90 deg
gamma = -i S q_psi + k (F' q_l + F'' (e . d')^2)                                                           [m/s^2]

q_psi, q_l: the parts of psi'' and l'' without accelerations.  psi is known up to whole turns only.  It is taken next to
(a phi_A + b phi_B - c)/S, which is right for any number of turns while |X| < pi |S|, or, where S is too small for this,
next to its value at the start.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from rattle.jit import layout as at
from rattle.jit.choices import assume, select
from rattle.jit.functions import compiled
from rattle.jit.geometry import COINCIDENT, ends
from rattle.language.recorded import acos, sqrt

SMALL = 0.2  # |S| by the radii, below which psi is counted from the start
OVERLAPPING = 1e-24  # square of the least length of a belt's line, by the distance of the centres: wheels overlap


class Wrapped(NamedTuple):
    """What the kernel takes after the points."""

    a: float  # [m]
    b: float  # [m]
    c: float  # [m]
    k: float  # 1, or -1
    j: float  # [m]
    from_start: float  # 1: psi next to `psi`; 0: next to the direction that the wheels give
    psi: float  # at the start [rad]
    scale: float  # size of the gap by which tolerances are set [m]


def length_of(l: float, s: float) -> float:
    """F [m] at the distance l [m] of the centres; s: S [m]."""
    return sqrt(l * l - s * s) - s * acos(s / l)


def bow_of(l: float, s: float) -> float:
    """Largest second derivative [1/m] of the gap by d near the distance l [m], with a margin of 2."""
    root = sqrt(l * l - s * s)
    return 2.0 * (abs(s) / l**2 + s * s / (l * l * root) + root / l**2)


@compiled
def turned_by(wheels, s, from_start, psi, dx, dy):
    """X [m]; wheels: a phi_A + b phi_B - c [m], s: S [m], from_start > 0: the direction of d is next to psi [rad]."""
    near = select(from_start > 0.0, psi, wheels / select(s == 0.0, 1.0, s))
    cos, sin = math.cos(near), math.sin(near)
    return wheels - s * (near + math.atan2(cos * dy - sin * dx, cos * dx + sin * dy))


@compiled
def write_turning(body, a, b, p, k, ra, rb, residual, row, rows):
    """Write the row X = 0 of two wheels that roll on each other, or on a belt; residual: X [m]."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb, s = body[a, at.W], body[b, at.W], ra + rb
    l2 = dx * dx + dy * dy
    # coincident centres have no direction
    inv = 1.0 / l2 if assume(l2 > COINCIDENT * COINCIDENT) else 0.0
    x, y = s * dx * inv, s * dy * inv
    turned = dx * ddy - dy * ddx

    rows[row, at.RES] = residual
    rows[row, at.NU] = 0.0
    rows[row, at.GAMMA] = (
        x * (say * wa * wa - sby * wb * wb)
        - y * (sax * wa * wa - sbx * wb * wb)
        - 2.0 * s * (dx * ddx + dy * ddy) * turned * inv * inv
    )
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = -y, x, ra + x * sax + y * say
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = y, -x, rb - x * sbx - y * sby


@compiled
def write_line(body, a, b, p, k, i, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m] and gamma [m/s^2] of line i = +1 or -1 into its row."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    wa, wb = body[a, at.W], body[b, at.W]
    ra, rb, side = p[k + 4], p[k + 5], p[k + 7]
    s = ra + rb
    d = math.sqrt(dx * dx + dy * dy)
    inv = 1.0 / d
    ex, ey = dx * inv, dy * inv
    root = math.sqrt(max(d * d - s * s, OVERLAPPING * d * d))
    slope, bent = root * inv, s * s * inv * inv / root
    along, across = ex * ddx + ey * ddy, ex * ddy - ey * ddx
    f = root - s * math.acos(min(max(s * inv, -1.0), 1.0))
    nx = -i * s * inv * ey - side * slope * ex
    ny = i * s * inv * ex - side * slope * ey
    d0x, d0y = wa * wa * sax - wb * wb * sbx, wa * wa * say - wb * wb * sby
    q_psi = (ex * d0y - ey * d0x) * inv - 2.0 * along * across * inv * inv
    q_l = across * across * inv + ex * d0x + ey * d0y

    wheels = ra * body[a, at.PHI] + rb * body[b, at.PHI] - p[k + 6]

    kinematics[row, at.GAP] = i * turned_by(wheels, s, p[k + 9], p[k + 10], dx, dy) + side * f + p[k + 8]
    kinematics[row, at.DGAP] = i * (ra * wa + rb * wb - s * across * inv) + side * slope * along
    kinematics[row, at.NX], kinematics[row, at.NY] = nx, ny
    kinematics[row, at.PAX], kinematics[row, at.PAY] = sax + i * ra * ny, say - i * ra * nx
    kinematics[row, at.PBX], kinematics[row, at.PBY] = sbx - i * rb * ny, sby + i * rb * nx
    kinematics[row, at.GAMMA_N] = -i * s * q_psi + side * (slope * q_l + bent * along * along)
