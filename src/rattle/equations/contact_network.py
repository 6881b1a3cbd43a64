"""Contact problems of many contacts: rows of joints and contacts are eliminated together, in a sparse order.

    R M^-1 C^T (z, f) = (0, -b)     R = (Phi_q, w_N of contacts that press, w_T of those that stick)
                                    C = the same, but w_N +- mu w_T for those that slide

G = W M^-1 W^T of all contacts is full, although rows couple only if they share a moving body.  Kept together with the
rows of the joints they preserve this sparsity: along a chain the work grows with its length.  The pattern has
all rows, two for each contact; inactive ones are left out.  Friction of sliding makes the values unsymmetric
but not the pattern: L U without pivoting, refined once if the residual is too large.

If a pivot vanishes (rows that depend on each other) or the residual does not decrease, the dense solution is used.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rattle.equations import schur
from rattle.equations.complementarity import DENSE_WAY, FORWARD, OFF, STICK, A, B, F, friction_of
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel

VANISHED = 1e-11  # share of its diagonal below which a pivot counts as zero
CLEAN = 1e-14  # share of the terms that a residual may have without being refined
WRONG = 1e-10  # the same, above which the solution is rejected
SOUND = 1e-4  # share of its diagonal above which a pivot loses no accuracy


def arrays(row_body: np.ndarray, contact: np.ndarray) -> dict[str, np.ndarray]:
    """Pattern of the rows of joints (nr, 2: bodies A, B) and contacts, and arrays for the values."""
    nr, nc = len(row_body), len(contact)
    bodies = [(int(a), int(b)) for a, b in row_body]
    for entry in contact:
        bodies += [(int(entry[at.A_BODY]), int(entry[at.B_BODY]))] * 2
    blocks: Sequence[range] = [
        *(range(row, row + 1) for row in range(nr)),
        *(range(nr + 2 * n, nr + 2 * n + 2) for n in range(nc)),
    ]
    pattern = schur.analyse(bodies, blocks)
    place, pairs = pattern.place, pattern.pairs.copy()
    above = place[pairs[:, at.PAIR_ROW]] < place[pairs[:, at.OTHER_ROW]]  # sorted so that the lower row comes first
    pairs[above] = pairs[above][:, [0, 3, 4, 1, 2, 5]]
    pairs[:, [2, 4]] -= at.AX
    size = len(bodies)
    entries = size + len(pattern.below)
    return {
        "net_place": place,
        "net_first": pattern.first,
        "net_below": pattern.below,
        "net_target": pattern.target,
        "net_pairs": pairs,
        "net_row": np.argsort(place),
        "net_on": np.zeros(size, np.int64),
        "net_line": np.zeros((size, 6)),
        "net_column": np.zeros((size, 6)),
        "net_size": np.zeros(size),
        "net_lower": np.zeros(entries),
        "net_upper": np.zeros(entries),
        "net_x": np.zeros((2, size)),
    }


@compiled
def rows_of_joints(m):
    """R and M^-1 C^T of the rows of joints, which are on; those of contacts are off."""
    on, line, column, size = m.net_on, m.net_line, m.net_column, m.net_size
    rows, row_body, weight = m.rows, m.row_body, m.weight
    nr = rows.shape[0]
    for i in range(on.shape[0]):
        on[i] = 1 if i < nr else 0
    for i in range(nr):
        size[i] = 0.0
        for side in range(2):
            body = row_body[i, side]
            for q in range(3 * side, 3 * side + 3):
                line[i, q] = rows[i, at.AX + q]
                column[i, q] = weight[body, q - 3 * side] * line[i, q]
                size[i] += line[i, q] * column[i, q]


@compiled
def row_of_contact(m, k, d, drag):
    """R and M^-1 C^T of the normal (d = 0) or tangential row of active contact k; drag: mu, with the sign of slip."""
    n, w, weight = m.active[k], m.contact_jacobian, m.weight
    i, r = m.rows.shape[0] + 2 * n + d, 2 * k + d
    m.net_on[i] = 1
    m.net_size[i] = 0.0
    for side in range(2):
        body = m.contact[n, at.A_BODY + side]
        for q in range(3 * side, 3 * side + 3):
            m.net_line[i, q] = w[r, q]
            m.net_size[i] += weight[body, q - 3 * side] * w[r, q] ** 2
            m.net_column[i, q] = weight[body, q - 3 * side] * (w[r, q] + drag * w[2 * k + 1, q])


@compiled
def choose_rows(m, count, rough):
    """R and M^-1 C^T of the rows that are active with the modes in `candidate`; True if C = R (no sliding friction)."""
    candidate, even = m.candidate, True
    rows_of_joints(m)
    for k in range(count):
        if candidate[k] == OFF:
            continue
        mu, drag = friction_of(m, m.active[k]), 0.0
        if candidate[k] != STICK and rough == 1:
            drag = mu if candidate[k] == FORWARD else -mu
            even = even and mu == 0.0
        for d in range(2 if candidate[k] == STICK and mu > 0.0 else 1):
            row_of_contact(m, k, d, drag)
    return even


@compiled
def fill(m, even):
    """R M^-1 C^T of the rows that are on into `net_lower` and, unless it is even, `net_upper`."""
    on, line, column, pairs, low, up = m.net_on, m.net_line, m.net_column, m.net_pairs, m.net_lower, m.net_upper
    for e in range(low.shape[0]):
        low[e], up[e] = 0.0, 0.0
    for p in range(pairs.shape[0]):
        i, j = pairs[p, 1], pairs[p, 3]
        if on[i] == 0 or on[j] == 0:
            continue
        e, c, d = pairs[p, 0], pairs[p, 2], pairs[p, 4]
        low[e] += line[i, c] * column[j, d] + line[i, c + 1] * column[j, d + 1] + line[i, c + 2] * column[j, d + 2]
        if not even:
            up[e] += line[j, d] * column[i, c] + line[j, d + 1] * column[i, c + 1] + line[j, d + 2] * column[i, c + 2]


@compiled
def eliminate_below(m, start, end, u, inverse, even):
    """Take a row with the entries from start to end out of those below it; u: next of `net_target`. Returns u."""
    low, up, target = m.net_lower, m.net_upper, m.net_target
    for a in range(start, end):
        if even:
            x = low[a] * inverse
            for b in range(a, end):
                low[target[u]] -= x * low[b]
                u += 1
            continue
        x, y = low[a] * inverse, up[a] * inverse
        if x == 0.0 and y == 0.0:
            u += end - a
            continue
        low[target[u]] -= x * up[a]
        u += 1
        for b in range(a + 1, end):
            low[target[u]] -= low[b] * y
            up[target[u]] -= x * up[b]
            u += 1
    for a in range(start, end):
        if even:
            up[a] = low[a]
        low[a] *= inverse
    return u


@compiled
def eliminate(m, ridge, even):
    """Fill and factor R M^-1 C^T in place; returns the sign of its determinant, 0 when a pivot vanishes.

    ridge: share by which the diagonal is raised.  even: the matrix is symmetric, its upper half is left out.
    The smallest ratio of a pivot to its diagonal goes to `held`.
    """
    row, first, size, low = m.net_row, m.net_first, m.net_size, m.net_lower
    total = row.shape[0]
    fill(m, even)
    sign, u, weakest = 1, 0, 1.0
    for k in range(total):
        start, end = total + first[k], total + first[k + 1]
        here = row[k]
        if m.net_on[here] == 0:
            u += (end - start) * (end - start + 1) // 2
            continue
        pivot = low[k] + ridge * size[here]
        if not abs(pivot) > VANISHED * size[here]:
            return 0
        sign = sign if pivot > 0.0 else -sign
        weakest = min(weakest, pivot / size[here])
        inverse = 1.0 / pivot
        low[k] = inverse
        u = eliminate_below(m, start, end, u, inverse, even)
    m.held[at.WEAKEST] = weakest
    return sign


@compiled
def substitute(m, n):
    """Solve L U x = x for line n of `net_x`, in place."""
    first, below, low, up, x = (
        m.net_first,
        m.net_below,
        m.net_lower,
        m.net_upper,
        m.net_x,
    )
    total = x.shape[1]
    for k in range(total):
        value = x[n, k]
        if value != 0.0:
            for a in range(first[k], first[k + 1]):
                x[n, below[a]] -= low[total + a] * value
    for k in range(total - 1, -1, -1):
        value = x[n, k]
        for a in range(first[k], first[k + 1]):
            value -= up[total + a] * x[n, below[a]]
        x[n, k] = value * low[k]


@compiled
def effect_of_rows(m):
    """`velocity_change` from the solution: M^-1 C^T x."""
    on, place, column, x, dv = (
        m.net_on,
        m.net_place,
        m.net_column,
        m.net_x,
        m.velocity_change,
    )
    contact, row_body = m.contact, m.row_body
    nr = row_body.shape[0]
    for i in range(dv.shape[0]):
        for q in range(3):
            dv[i, q] = 0.0
    for i in range(on.shape[0]):
        if on[i] == 0:
            continue
        force = x[0, place[i]]
        a = row_body[i, at.ROW_A] if i < nr else contact[(i - nr) // 2, at.A_BODY]
        b = row_body[i, at.ROW_B] if i < nr else contact[(i - nr) // 2, at.B_BODY]
        for q in range(3):
            dv[a, q] += column[i, q] * force
            dv[b, q] += column[i, 3 + q] * force


@compiled
def remainder(m, count):
    """Residual of all rows into line 1 of `net_x`; returns the largest and the magnitude of its terms."""
    on, place, line, x, dv = m.net_on, m.net_place, m.net_line, m.net_x, m.velocity_change
    contact, row_body, size = m.contact, m.row_body, m.net_size
    active, side = m.active, m.side
    nr = row_body.shape[0]
    worst, scale = 0.0, 0.0
    for i in range(on.shape[0]):
        x[1, place[i]] = 0.0
    for k in range(count):
        for d in range(2):
            i = nr + 2 * active[k] + d
            if on[i] == 1:
                x[1, place[i]] = -side[B, 2 * k + d]
            scale = max(scale, abs(side[B, 2 * k + d]))
    for i in range(on.shape[0]):
        if on[i] == 0:
            continue
        a = row_body[i, at.ROW_A] if i < nr else contact[(i - nr) // 2, at.A_BODY]
        b = row_body[i, at.ROW_B] if i < nr else contact[(i - nr) // 2, at.B_BODY]
        value = x[1, place[i]]
        for q in range(3):
            value -= line[i, q] * dv[a, q] + line[i, 3 + q] * dv[b, q]
        x[1, place[i]] = value
        worst = max(worst, abs(value))
        scale = max(scale, abs(size[i] * x[0, place[i]]))
    return worst, scale


@compiled
def solve_rows(m, count, ridge, only):
    """Solution of the factored rows into line 0 of `net_x`, refined; True if its residual is small.

    Fills `velocity_change`; only = 1: just the solution, if no pivot is so small that the residual must be checked.
    """
    on, place, x, active, side = m.net_on, m.net_place, m.net_x, m.active, m.side
    nr = m.row_body.shape[0]
    for i in range(on.shape[0]):
        x[0, i] = 0.0
    for k in range(count):
        for d in range(2):
            i = nr + 2 * active[k] + d
            if on[i] == 1:
                x[0, place[i]] = -side[B, 2 * k + d]
    substitute(m, 0)
    if only == 1 and m.held[at.WEAKEST] > SOUND:
        return True
    effect_of_rows(m)
    worst, scale = remainder(m, count)
    if worst > CLEAN * scale and ridge == 0.0:
        substitute(m, 1)
        for i in range(on.shape[0]):
            x[0, i] += x[1, i]
        effect_of_rows(m)
        worst, scale = remainder(m, count)
    m.held[at.SCALE] = scale
    return worst <= WRONG * scale


@kernel("problem")
def network_kernel(m, number):
    """`complementarity.modes_kernel` for many contacts, with sparse elimination.

    Returns the sign of the determinant, or DENSE_WAY if the rows depend on each other.
    """
    count, only, rough = number // 4, number // 2 % 2, number % 2
    w, side, dv, x = m.contact_jacobian, m.side, m.velocity_change, m.net_x
    contact, active, candidate, place = m.contact, m.active, m.candidate, m.net_place
    nr, ridge = m.row_body.shape[0], m.held[at.RIDGE]
    even = choose_rows(m, count, rough)
    sign = eliminate(m, ridge, even)
    if sign == 0 or not solve_rows(m, count, ridge, only):
        return DENSE_WAY
    for k in range(count):
        n = active[k]
        mu = friction_of(m, n)
        side[F, 2 * k], side[F, 2 * k + 1] = 0.0, 0.0
        if candidate[k] != OFF:
            side[F, 2 * k] = x[0, place[nr + 2 * n]]
            if candidate[k] == STICK:
                side[F, 2 * k + 1] = x[0, place[nr + 2 * n + 1]] if mu > 0.0 else 0.0
            elif rough == 1:
                side[F, 2 * k + 1] = (mu if candidate[k] == FORWARD else -mu) * side[F, 2 * k]
        if only == 1:
            continue
        a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
        for r in range(2 * k, 2 * k + (2 if mu > 0.0 else 1)):
            value = side[B, r]
            for q in range(3):
                value += w[r, q] * dv[a, q] + w[r, 3 + q] * dv[b, q]
            side[A, r] = value
        if not mu > 0.0:
            side[A, 2 * k + 1] = side[B, 2 * k + 1]
    return sign


KERNEL = network_kernel
