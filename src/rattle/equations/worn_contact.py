"""Contact of a worn pin with its worn bush at one instant: an elastic foundation, several zones at once.

P_i        elastic force at node i of the bush, see `rattle.elements.worn_bins`; it stores sum P_i ddelta_i    [W]
           ddelta_i = lambda u_i . e' + w_A (lambda t_i . e - h_B') + w_B h_B'
S, ddelta  static force and rate of the contact as a whole: S = lambda |sum P_i u_i|,  S ddelta = sum P_i ddelta_i
N_i        = P_i N/S, N by the normal law for S and ddelta: motion along the wall, and turning, is not damped
u          mean slip, weighted by N_i;  T = friction law(u, sum N_i), shared among the nodes in proportion to N_i

force on B at its point   F = -lambda sum N_i u_i - (T/sum N_i) sum N_i t_i
moment on A about its point   -sum N_i (lambda t_i . e - h_B') + (T/sum N_i) sum N_i r_A,i
moment on B about its point   -sum N_i h_B' - (T/sum N_i) sum N_i r_B,i
r_A,i = R - (c - u_i . e)/2,  r_B,i = r_A,i - u_i . e     arms midway between the surfaces

Together they have no resultant, and the power that they take is that of the N_i and of T u.  The row of the contact in
`contact_kinematics` gets the resultant: its direction as n, an arm R along it on A, and the couple that is left.
"""

from __future__ import annotations

import math

from rattle.elements.worn_bins import (
    BED,
    CHORD,
    COUNT,
    LEAST,
    around,
    depth_at,
    half_square,
    pin_place,
    pin_slope,
    shares,
    window,
)  # fmt: skip
from rattle.jit import layout as at
from rattle.jit.families import call_friction, call_normal
from rattle.jit.functions import compiled, native
from rattle.jit.geometry import ends

# sums over the nodes, in `bin_sums`: P, P u (x, y), P (lambda t . e - h_B'), P times the slip, P r_A, P ddelta; N/S
OF_N, OF_X, OF_Y, OF_TURN, OF_SLIP, OF_ARM_A, STORED_RATE, DAMPED = range(8)


@compiled
def sum_nodes(m, c, deposit):
    """Elastic forces of all nodes of contact c, into `bin_sums` (x and y in the frame of A), and N/S.

    deposit: 1 to add P |slip| [W] of every node of the bush, then of the pin, to row c of `wear_rate`.
    """
    contact, p, body, sums = m.contact, m.values, m.body, m.bin_sums
    k, a, b = contact[c, at.SHAPE_P], contact[c, at.A_BODY], contact[c, at.B_BODY]
    _, _, _, _, ex, ey, dex, dey = ends(body, a, b, p, k)
    n, play, chord = int(p[k + COUNT]), p[k + at.CLEARANCE], p[k + CHORD]
    cos_a, sin_a = body[a, at.COS], body[a, at.SIN]
    x, y = cos_a * ex + sin_a * ey, cos_a * ey - sin_a * ex
    vx, vy = cos_a * dex + sin_a * dey, cos_a * dey - sin_a * dex
    first, part = pin_place(p, k, body[a, at.PHI] - body[b, at.PHI])
    start, count = window(p, k, x, y, play + p[k + LEAST])
    if count < n:  # from the last node before it to the first behind it
        start, count = around(start - 1, n), min(count + 1, n)
    wide = 2.0 * math.pi / n
    step_cos, step_sin = math.cos(wide), math.sin(wide)
    cos, sin = math.cos((start + 0.5) * wide), math.sin((start + 0.5) * wide)
    here = chord * (x * cos + y * sin) - play - depth_at(p, k, start, first, part)
    bed, bore, wa, wb = p[k + BED], p[k + at.RADIUS] - 0.5 * play, body[a, at.W], body[b, at.W]
    of_n, of_x, of_y, of_turn, of_slip, of_arm, stored = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    before, i = 0.0, start
    for s in range(count + 1):
        next_cos, next_sin = cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin
        following, there, left, right = around(i + 1, n), 0.0, 0.0, 0.0
        if s < count:
            there = chord * (x * next_cos + y * next_sin) - play - depth_at(p, k, following, first, part)
            left, right = shares(here, there)
        if before + left > 0.0:
            force = bed * (before + left)
            along, across = x * cos + y * sin, y * cos - x * sin
            slope = pin_slope(p, k, i, first, part)
            turn, arm = chord * across - slope, bore + 0.5 * along
            slip = vy * cos - vx * sin + wb * (arm - along) - wa * arm
            of_n += force
            of_x += force * cos
            of_y += force * sin
            of_turn += force * turn
            of_slip += force * slip
            of_arm += force * arm
            stored += force * (chord * (vx * cos + vy * sin) + wa * turn + wb * slope)
            if deposit == 1:
                deposit_at(m.wear_rate, c, i, n, first, part, force * abs(slip))
        here, before, cos, sin, i = there, right, next_cos, next_sin, following
    sums[OF_N], sums[OF_X], sums[OF_Y], sums[OF_TURN] = of_n, of_x, of_y, of_turn
    sums[OF_SLIP], sums[OF_ARM_A], sums[STORED_RATE], sums[DAMPED] = of_slip, of_arm, stored, 0.0
    static = chord * math.sqrt(of_x * of_x + of_y * of_y)
    if static > 0.0:
        depth, speed = -m.contact_kinematics[c, at.GAP], m.contact_memory[c, at.SPEED]
        arguments = (static, depth, stored / static, speed, p, contact[c, at.NORMAL_P])
        sums[DAMPED] = call_normal(m.normal_table[contact[c, at.NORMAL_LAW]], arguments) / static


@compiled
def deposit_at(rates, c, i, n, first, part, work):
    """Add P |slip| [W] at node i of the bush to its bin, and to those of the pin by the weights of its spline."""
    rates[c, i] += work
    j = around(i + first, n)
    low, high = 0.5 - part, 0.5 + part
    rates[c, n + around(j - 1, n)] += 0.5 * low * low * work
    rates[c, n + j] += (0.75 - part * part) * work
    rates[c, n + around(j + 1, n)] += 0.5 * high * high * work


@native("void", "h", "i")
def add_worn_force(m, c):
    """Add force and moments of worn contact c to both bodies; resultant, losses and storage to its kinematics."""
    contact, kinematics, p, body, sums = m.contact, m.contact_kinematics, m.values, m.body, m.bin_sums
    sum_nodes(m, c, 0)
    damped = sums[DAMPED]
    total = damped * sums[OF_N]
    if not total > 0.0:
        kinematics[c, at.STORE], kinematics[c, at.LOSS] = sums[STORED_RATE], -sums[STORED_RATE]
        return
    k, a, b = contact[c, at.SHAPE_P], contact[c, at.A_BODY], contact[c, at.B_BODY]
    slip, tangent, first = sums[OF_SLIP] / sums[OF_N], 0.0, contact[c, at.FIRST_STATE]
    if contact[c, at.FRICTION] >= 0:
        arguments = (slip, total, m.element_state[first:], p, contact[c, at.FRICTION_P], m.element_rate[first:])
        tangent = call_friction(m.friction_table[contact[c, at.FRICTION]], arguments)
    size = math.sqrt(sums[OF_X] * sums[OF_X] + sums[OF_Y] * sums[OF_Y])
    cos, sin = sums[OF_X] / size, sums[OF_Y] / size
    nx = body[a, at.COS] * cos - body[a, at.SIN] * sin
    ny = body[a, at.SIN] * cos + body[a, at.COS] * sin
    normal, along_t = damped * p[k + CHORD] * size, tangent * size / sums[OF_N]
    sax, say, sbx, sby, ex, ey, _, _ = ends(body, a, b, p, k)
    arm = sums[OF_ARM_A] / sums[OF_N]
    kinematics[c, at.NX], kinematics[c, at.NY] = nx, ny
    kinematics[c, at.PAX], kinematics[c, at.PAY] = sax + arm * nx, say + arm * ny
    kinematics[c, at.PBX], kinematics[c, at.PBY] = sbx + arm * nx - ex, sby + arm * ny - ey
    kinematics[c, at.TURN] = (tangent * arm - damped * sums[OF_TURN] - arm * along_t) / normal
    kinematics[c, at.NORMAL], kinematics[c, at.TANGENT] = normal, along_t
    kinematics[c, at.SLIP] = slip
    kinematics[c, at.STORE] = sums[STORED_RATE]
    kinematics[c, at.LOSS] = (damped - 1.0) * sums[STORED_RATE] + tangent * slip


@native("f", "h", "i")
def worn_energy(m, c):
    """Energy [J] that the foundation of worn contact c stores at the present state."""
    contact, p, body = m.contact, m.values, m.body
    k, a, b = contact[c, at.SHAPE_P], contact[c, at.A_BODY], contact[c, at.B_BODY]
    _, _, _, _, ex, ey, _, _ = ends(body, a, b, p, k)
    n, play, chord = int(p[k + COUNT]), p[k + at.CLEARANCE], p[k + CHORD]
    x = body[a, at.COS] * ex + body[a, at.SIN] * ey
    y = body[a, at.COS] * ey - body[a, at.SIN] * ex
    first, part = pin_place(p, k, body[a, at.PHI] - body[b, at.PHI])
    wide, total, before = 2.0 * math.pi / n, 0.0, 0.0
    for s in range(n + 1):
        theta = (s + 0.5) * wide
        depth = chord * (x * math.cos(theta) + y * math.sin(theta)) - play
        depth -= depth_at(p, k, around(s, n), first, part)
        if s > 0:
            total += half_square(before, depth)
        before = depth
    return p[k + BED] * total
