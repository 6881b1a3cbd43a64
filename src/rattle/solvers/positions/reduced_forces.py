"""Forces and stiffness in the degrees of freedom that the joints leave: g = Z^T Q, H = Z^T K Z.

Z spans the null space of Phi_q in scaled coordinates; its columns follow from triangulating Phi_q by reflections.
"""

from __future__ import annotations

import math

from rattle.equations.rest_force import FACTORS, SHIFTS, TWO_FACTORS, TWO_SHIFTS, force_at
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.jit.small_matrices import into_basis, out_of_basis, solve_upper, triangulate

RANK = 1e-9  # remainder of a row, as a share of the longest, below which it counts as dependent
# rows of `line`
OUT, G, DZ, MOVE, TRIAL, START, WORK = range(7)
LEAST_FORCE = 1e-12  # [N] that forces are compared with where there are none


@compiled
def scaled_rows(m, scale, wide, norm):
    """Phi_q of the present rows in scaled coordinates into wide (nr, 3 nb), every row normalised to length one."""
    rows, row_body = m.rows, m.row_body
    for r in range(rows.shape[0]):
        line = wide[r]
        for c in range(line.shape[0]):
            line[c] = 0.0
        i, j = 3 * row_body[r, at.ROW_A] - 3, 3 * row_body[r, at.ROW_B] - 3
        for k in range(3):
            if i >= 0:
                line[i + k] += rows[r, at.AX + k] * scale[i + k]
            if j >= 0:
                line[j + k] += rows[r, at.BX + k] * scale[j + k]
        square = 0.0
        for c in range(line.shape[0]):
            square += line[c] * line[c]
        norm[r] = math.sqrt(square)
        if square > 0.0:
            for c in range(line.shape[0]):
                line[c] /= norm[r]


@compiled
def reduce(m, t, q, scale, wide, norm, order, pivot, null, line):
    """Reduced force [N] into line[G], scaled null space into the first rows of `null`, multipliers into the workspace.

    Returns the number of degrees of freedom.
    """
    n, multiplier = q.shape[0], m.multiplier
    for r in range(multiplier.shape[0]):
        multiplier[r] = 0.0
    force_at(m, t, q, line[OUT])
    scaled_rows(m, scale, wide, norm)
    rank = triangulate(wide, wide.shape[0], order, pivot, RANK)
    work, g = line[WORK], line[G]
    for k in range(n):
        work[k] = line[OUT, k] * scale[k]
    into_basis(wide, pivot, rank, work)
    for k in range(n - rank):
        g[k] = work[rank + k]
    solve_upper(wide, pivot, rank, work)
    for k in range(rank):
        multiplier[order[k]] = work[k] / norm[order[k]]
    for j in range(n - rank):
        direction = null[j]
        for k in range(n):
            direction[k] = 0.0
        direction[rank + j] = 1.0
        out_of_basis(wide, pivot, rank, direction)
        for k in range(n):
            direction[k] *= scale[k]
    return n - rank


@compiled
def reduced_stiffness(m, t, q, step, dof, points, null, line, small):
    """H^T = (Z^T K Z)^T [N/m] into `small` (a row for each column of H), by differences along Z.

    points: 2 (second order, enough for a search direction) or 4 (fourth order).
    """
    work, out, n = line[WORK], line[OUT], q.shape[0]
    trial = line[TRIAL]
    for j in range(dof):
        for k in range(n):
            work[k] = 0.0
        for s in range(points):
            if points == 4:
                shift, factor = SHIFTS[s] * step, FACTORS[s] / (12.0 * step)
            else:
                shift, factor = TWO_SHIFTS[s] * step, TWO_FACTORS[s] / (2.0 * step)
            for k in range(n):
                trial[k] = q[k] + shift * null[j, k]
            force_at(m, t, trial, out)
            for k in range(n):
                work[k] += factor * out[k]
        for i in range(dof):
            value = 0.0
            for k in range(n):
                value += null[i, k] * work[k]
            small[j, i] = value


@compiled
def force_size(m, size):
    """A typical magnitude of the applied forces [N]; size: of the mechanism [m]."""
    rows, force, multiplier = m.rows, m.force, m.multiplier
    most = LEAST_FORCE
    for r in range(rows.shape[0]):
        for k in range(6):
            most = max(most, abs(multiplier[r] * rows[r, at.AX + k]))
    for i in range(force.shape[0]):
        most = max(most, max(abs(force[i, 0]), abs(force[i, 1])))
        most = max(most, abs(force[i, 2]) / size)
    return most
