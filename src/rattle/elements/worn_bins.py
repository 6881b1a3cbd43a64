"""A pin in a bush whose surfaces are worn, on an elastic foundation: what all kernels of this contact share.

Directions theta are angles in the frame of the bush (A); n bins of width d = 2 pi/n, node i at theta_i = (i + 1/2) d.

delta_i = lambda e . u_i - c - h_A,i - h_B(theta_i + phi_A - phi_B)     penetration at node i
V = 1/2 K_w R L int delta_+^2 dtheta     stored energy; delta is linear between the nodes, delta_+ its positive part
P_i = dV/d delta_i                       force at node i: int p phi_i dA, phi_i the hat function of the node

    ends a, b > 0:  V = k (a^2 + a b + b^2)/6      a > 0 > b:  V = k a^3/(6 (a - b))       k = K_w R L d  [N/m]

so the force is smooth in e, and forces, moments and stored energy belong together to rounding.  lambda makes a circle
of the polygon: 12 (1 - cos d)/(d^2 (4 + 2 cos d)) = 1 + d^2/12 + ..., with which full contact is exact.  Nodes turn
with A; h_B is the quadratic spline of the depths of the pin, whose weights are positive and sum to 1 (C1 in the angle).

p[k:]: the points of A and B, clearance c, radius R of the bush, then what has names here, the n depths of the bush and
the n of the pin [m].  Source: docs/wear.md; Winkler foundation: Johnson, Contact Mechanics (1985), section 4.3.
"""

from __future__ import annotations

import math

from rattle.jit import layout as at
from rattle.jit.functions import compiled

# n, k [N/m], least sum of depths [m], lambda, 1 if the pin is worn, first depth of the bush
COUNT, BED, LEAST, CHORD, PIN_WORN, DEPTHS = range(at.FIELDS, at.FIELDS + 6)


@compiled
def pin_place(p, k, turned):
    """Bin of the pin at node 0 of the bush, and the share of a bin (-0.5 to 0.5) beyond it; turned: phi_A - phi_B."""
    n = p[k + COUNT]
    place = turned * n / (2.0 * math.pi)
    whole = math.floor(place + 0.5)
    return int(whole - n * math.floor(whole / n)), place - whole


@compiled
def around(i, n):
    """i modulo n, for i between -n and 2 n."""
    if i < 0:
        return i + n
    return i - n if i >= n else i


@compiled
def depth_at(p, k, i, first, part):
    """Sum of both depths [m] at node i of the bush; first, part: `pin_place`."""
    n = int(p[k + COUNT])
    depth = p[k + DEPTHS + i]
    if p[k + PIN_WORN] != 0.0:
        q = k + DEPTHS + n
        j = around(i + first, n)
        low, high = 0.5 - part, 0.5 + part
        depth += 0.5 * low * low * p[q + around(j - 1, n)] + (0.75 - part * part) * p[q + j]
        depth += 0.5 * high * high * p[q + around(j + 1, n)]
    return depth


@compiled
def pin_slope(p, k, i, first, part):
    """Derivative of the depth of the pin by the angle [m/rad] at node i of the bush."""
    if p[k + PIN_WORN] == 0.0:
        return 0.0
    n = int(p[k + COUNT])
    q, j = k + DEPTHS + n, around(i + first, n)
    slope = (0.5 + part) * p[q + around(j + 1, n)] - 2.0 * part * p[q + j] - (0.5 - part) * p[q + around(j - 1, n)]
    return slope * p[k + COUNT] / (2.0 * math.pi)


@compiled
def window(p, k, x, y, least):
    """First node and number of nodes with lambda e . u > least [m]; (x, y): e in the frame of A [m].

    Nodes count on beyond n; the number is n at most, then the first node is opposite to e.
    """
    n = int(p[k + COUNT])
    wide, size = 2.0 * math.pi / p[k + COUNT], p[k + CHORD] * math.sqrt(x * x + y * y)
    centre = math.atan2(y, x) / wide - 0.5
    if size <= least:
        return 0, 0
    half = math.acos(least / size) / wide if least > -size else 0.5 * n
    if 2.0 * half + 3.0 >= n:
        return around(math.floor(centre - 0.5 * n), n), n
    first = -math.floor(half - centre)
    return around(first, n), math.floor(centre + half) - first + 1


@compiled
def shares(a, b):
    """Derivatives by a and by b of the integral of half the square of delta_+ between two nodes, per k: [m] each."""
    if a >= 0.0 and b >= 0.0:
        return (2.0 * a + b) / 6.0, (a + 2.0 * b) / 6.0
    if a > 0.0:
        wide = a - b
        return a * a * (2.0 * a - 3.0 * b) / (6.0 * wide * wide), a * a * a / (6.0 * wide * wide)
    if b > 0.0:
        wide = b - a
        return b * b * b / (6.0 * wide * wide), b * b * (2.0 * b - 3.0 * a) / (6.0 * wide * wide)
    return 0.0, 0.0


@compiled
def half_square(a, b):
    """Integral of half the square of delta_+ between two nodes, per k [m^2]."""
    if a >= 0.0 and b >= 0.0:
        return (a * a + a * b + b * b) / 6.0
    if a > 0.0:
        return a * a * a / (6.0 * (a - b))
    if b > 0.0:
        return b * b * b / (6.0 * (b - a))
    return 0.0
