"""A mechanism with all rates zero: its forces and how they change with position."""

from __future__ import annotations

import numpy as np

from rattle.equations.closure import place_only
from rattle.equations.motion import constraints, loads
from rattle.jit import layout as at
from rattle.jit.functions import native

# K from differences of the force: places [steps] and factors [1/12 per step] of fourth order, [1/2 per step] of second
SHIFTS, FACTORS = np.array([-2.0, -1.0, 1.0, 2.0]), np.array([-1.0, 8.0, -8.0, 1.0])
TWO_SHIFTS, TWO_FACTORS = np.array([-1.0, 1.0]), np.array([1.0, -1.0])


@native("void", "h", "f", "v", "v")
def force_at(m, t, q, out):
    """Q - Phi_q^T lambda [N, N m] at q with zero rates, into out (3 nb,); drivers and lambda as in the workspace."""
    body, rows, force = m.body, m.rows, m.force
    multiplier, row_body = m.multiplier, m.row_body
    for i in range(1, body.shape[0]):
        for k in range(3):
            body[i, at.VX + k] = 0.0
    place_only(m, q)
    constraints(m)
    loads(m, t)
    for i in range(1, body.shape[0]):
        for k in range(3):
            out[3 * i - 3 + k] = force[i, k]
    for r in range(rows.shape[0]):
        i, j = 3 * row_body[r, at.ROW_A] - 3, 3 * row_body[r, at.ROW_B] - 3
        for k in range(3):
            if i >= 0:
                out[i + k] -= rows[r, at.AX + k] * multiplier[r]
            if j >= 0:
                out[j + k] -= rows[r, at.BX + k] * multiplier[r]


@native("void", "h", "f", "v", "v", "v", "m")
def stiffness(m, t, q, step, out, result):
    """K = -d(Q - Phi_q^T lambda)/dq (3 nb, 3 nb) [N/m, N, N m] with lambda fixed, by fourth-order differences.

    step (3 nb,): increment of every coordinate [m, rad]; out (3 nb,): scratch.  q is unchanged on return.
    """
    for c in range(q.shape[0]):
        spot = q[c]
        for r in range(q.shape[0]):
            result[r, c] = 0.0
        for n in range(4):
            factor = FACTORS[n] / (12.0 * step[c])
            q[c] = spot + SHIFTS[n] * step[c]
            force_at(m, t, q, out)
            for r in range(q.shape[0]):
                result[r, c] += factor * out[r]
        q[c] = spot
    force_at(m, t, q, out)
