"""Sliding work in the bins of a worn contact under given loads: where the pin lies follows from equilibrium.

For each row of loads (s, F_x, F_y, psi; see `wear_sum`) the centre e of the pin is sought at which the foundation
bears F; the pin then slides by s.  Newton's method, with the slope of the integral in place of that of the polygon.
"""

from __future__ import annotations

import math

from rattle.elements.worn_bins import BED, CHORD, COUNT, LEAST, around, depth_at, pin_place, shares, window
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.wear_sum import FORCE_X, FORCE_Y, SLIDING, TURNED

MOST = 60  # steps of Newton's method
CLOSE = 1e-6  # share of the load that may be left
X, Y, XX, XY, YY = range(5)  # of `sums`: sum P u / k [m], and its derivative by e
FLAT = 1e-9  # determinant, by the square of the trace, below which the contact bears in one direction only
APPROACH = 0.1  # of the clearance: step along the load of a pin that does not touch
FARTHEST = 0.2  # of the clearance: longest step


@compiled
def bear(p, x, y, first, part, work, slide, sums):
    """Sums over the nodes with the pin at (x, y) [m]; adds P s [J] to the bins of `work` if the distance s > 0 [m]."""
    n, play, chord = int(p[COUNT]), p[at.CLEARANCE], p[CHORD]
    for q in range(5):
        sums[q] = 0.0
    start, count = window(p, 0, x, y, play + p[LEAST])
    if count < n:
        start, count = around(start - 1, n), min(count + 1, n)
    wide = 2.0 * math.pi / n
    step_cos, step_sin = math.cos(wide), math.sin(wide)
    cos, sin = math.cos((start + 0.5) * wide), math.sin((start + 0.5) * wide)
    here = chord * (x * cos + y * sin) - play - depth_at(p, 0, start, first, part)
    before, i = 0.0, start
    for s in range(count + 1):
        next_cos, next_sin = cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin
        following, there, left, right = around(i + 1, n), 0.0, 0.0, 0.0
        if s < count:
            there = chord * (x * next_cos + y * next_sin) - play - depth_at(p, 0, following, first, part)
            left, right = shares(here, there)
            if left + right > 0.0:
                reach = max(here, there, 0.0) / max(max(here, there) - min(here, there, 0.0), TINY)
                mid_x, mid_y = 0.5 * (cos + next_cos), 0.5 * (sin + next_sin)
                sums[XX] += reach * mid_x * mid_x
                sums[XY] += reach * mid_x * mid_y
                sums[YY] += reach * mid_y * mid_y
        depth = before + left
        if depth > 0.0:
            sums[X] += depth * cos
            sums[Y] += depth * sin
            if slide > 0.0:
                put(p, work, i, n, first, part, p[BED] * depth * slide)
        here, before, cos, sin, i = there, right, next_cos, next_sin, following


@compiled
def put(p, work, i, n, first, part, amount):
    """Add work [J] at node i of the bush to its bin, and to those of the pin by the weights of its spline."""
    work[i] += amount
    j = around(i + first, n)
    low, high = 0.5 - part, 0.5 + part
    work[n + around(j - 1, n)] += 0.5 * low * low * amount
    work[n + j] += (0.75 - part * part) * amount
    work[n + around(j + 1, n)] += 0.5 * high * high * amount


@native("void", "v", "m", "m", "v", "v")
def slide_under(p, loads, places, work, sums):
    """Sliding work [J] in the bins (2 n,) under all loads; places (rows, 2) [m]: of the pin, from which it starts.

    p: parameters of the contact, as of its kernel.  Rows without a load are left out.
    """
    for q in range(work.shape[0]):
        work[q] = 0.0
    for r in range(loads.shape[0]):
        slide = loads[r, SLIDING]
        if not slide > 0.0:
            continue
        fx, fy = loads[r, FORCE_X] / slide / p[BED], loads[r, FORCE_Y] / slide / p[BED]
        size = math.sqrt(fx * fx + fy * fy)
        if not size > 0.0:
            continue
        first, part = pin_place(p, 0, loads[r, TURNED] / slide)
        x, y, push = places[r, 0], places[r, 1], p[at.CLEARANCE]
        for _ in range(MOST):
            bear(p, x, y, first, part, work, 0.0, sums)
            dx, dy = fx - sums[X], fy - sums[Y]
            if dx * dx + dy * dy <= CLOSE * CLOSE * size * size:
                break
            chord = p[CHORD]
            det = chord * (sums[XX] * sums[YY] - sums[XY] * sums[XY])
            if det > FLAT * (sums[XX] + sums[YY]) ** 2:
                sx, sy = (dx * sums[YY] - dy * sums[XY]) / det, (dy * sums[XX] - dx * sums[XY]) / det
            elif sums[XX] + sums[YY] > 0.0:
                sx, sy = dx / (chord * (sums[XX] + sums[YY])), dy / (chord * (sums[XX] + sums[YY]))
            else:  # it does not touch: out along the load
                sx, sy = APPROACH * push * fx / size, APPROACH * push * fy / size
            far = math.sqrt(sx * sx + sy * sy)
            if far > FARTHEST * push:
                sx, sy = sx * FARTHEST * push / far, sy * FARTHEST * push / far
            x, y = x + sx, y + sy
        places[r, 0], places[r, 1] = x, y
        bear(p, x, y, first, part, work, slide, sums)


@native("void", "v", "f", "f", "f", "v")
def bear_at(p, x, y, turned, sums):
    """Sums over the nodes with the pin at (x, y) [m] in the frame of the bush, turned: phi_A - phi_B [rad]."""
    first, part = pin_place(p, 0, turned)
    bear(p, x, y, first, part, sums, 0.0, sums)
