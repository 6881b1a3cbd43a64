"""Newton's method for an equilibrium in the degrees of freedom that the joints leave, as one compiled loop.

    Z = null space of Phi_q,   g = Z^T Q,   H = Z^T K Z,   K = -d(Q - Phi_q^T lambda)/dq,   q += Z H^-1 g

H is formed by differences along the columns of Z.  Coordinates are scaled, see `rattle.questions.equilibrium.balance`.
"""

from __future__ import annotations

import math

from rattle.equations.closure import CLOSED, ITERATIONS, SHUT, close_position, merit_at
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.jit.functions import compiled
from rattle.jit.small_matrices import (
    out_of_basis,
    rotate_columns,
    solve_downhill,
    solve_lower,
    solve_square,
    triangulate,
)
from rattle.solvers.positions.reduced_forces import (
    DZ,
    MOVE,
    RANK,
    START,
    TRIAL,
    WORK,
    G,
    force_size,
    reduce,
    reduced_stiffness,
    scaled_rows,
)

ROUNDS = 150  # Newton steps after which a start is abandoned
HALVINGS = 30
LOST, FOUND, KNOWN, GOING = range(4)
# entries of `state`; MOST_TURN: largest rotation in one step [rad]; displacements as a share of the mechanism's size
PHASE, ITERATION, SMALL, FORCE_SIZE, TRIALS, EXTENT, DOF, G_SIZE, G_LENGTH, MOST_TURN = range(10)
SAME_SIDE = 0.7  # cosine of the angle by which a pin may move in its bush in one step
FLAT = 1e-9  # stiffness, as a share of the largest, below which a way downhill is not one of Newton's method
SINGULAR = 1e-13  # pivot, as a share of the largest, below which a stiffness is singular
# reduced forces, as shares of a typical force: at an equilibrium if steps end, or are as short as EXACTLY says
BALANCED, BALANCED_WELL, BALANCED_SLOWLY = 1e-8, 1e-12, 1e-11
NO_STEP, SHORT_STEP = 1e-13, 1e-10  # sizes of the mechanism: steps that move nothing, that end the search in balance
SLOW = 0.1  # share of the force that a step must leave at most, near rounding
LESS = 1e-4  # share of the expected decrease of the force that a step must reach
ALONG = 1e-8  # square of the share of a direction that the joints allow, below which a path ends
AT_TARGET = 1e-13  # correction [m, rad] that ends `displace`


@compiled
def offsets(m, links, first, arm):
    """Pin centre minus bush centre [m] of every massless link at the state in `body`, into arm from row `first` on."""
    body, values = m.body, m.values
    for n in range(links.shape[0]):
        a, b, p = links[n, 0], links[n, 1], links[n, 2]
        arm[first + n, 0] = (
            body[b, at.X]
            + body[b, at.COS] * values[p + 2]
            - body[b, at.SIN] * values[p + 3]
            - (body[a, at.X] + body[a, at.COS] * values[p] - body[a, at.SIN] * values[p + 1])
        )
        arm[first + n, 1] = (
            body[b, at.Y]
            + body[b, at.SIN] * values[p + 2]
            + body[b, at.COS] * values[p + 3]
            - (body[a, at.Y] + body[a, at.SIN] * values[p] + body[a, at.COS] * values[p + 1])
        )


@compiled
def changed_side(arm, links):
    """True if a pin has moved by more than 0.8 rad in its bush: it may have changed sides."""
    count = links.shape[0]
    for n in range(count):
        x, y, x_new, y_new = arm[n, 0], arm[n, 1], arm[count + n, 0], arm[count + n, 1]
        size = math.sqrt((x * x + y * y) * (x_new * x_new + y_new * y_new)) + TINY
        if (x * x_new + y * y_new) / size < SAME_SIDE:
            return True
    return False


@compiled
def largest_of(x, n):
    """Largest magnitude of the first n components, in their unit; inf if one is not finite."""
    most = 0.0
    for k in range(n):
        value = abs(x[k])
        if not value < math.inf:
            return math.inf
        most = max(most, value)
    return most


@compiled
def is_known(q, positions, count, near, scale):
    """True if q is within `near` (scaled [m]) of one of the first `count` positions, angles compared modulo a turn."""
    for n in range(count):
        apart = 0.0
        for k in range(q.shape[0]):
            value = q[k] - positions[n, k]
            if k % 3 == 2:
                value -= 2.0 * math.pi * math.floor(value / (2.0 * math.pi) + 0.5)
            apart = max(apart, abs(value) / scale[k])
            if apart > near:
                break
        if apart <= near:
            return True
    return False


@compiled
def newton_step(dof, downhill, order, pivot, line, small, null, state, size):
    """The step dz and the displacement of all coordinates; returns its length without limits."""
    g, dz, move = line[G], line[DZ], line[MOVE]
    if downhill:
        for i in range(dof):
            for j in range(i):
                value = 0.5 * (small[i, j] + small[j, i])
                small[i, j] = value
                small[j, i] = value
        rotate_columns(small, dof)
        solve_downhill(small, dof, g, FLAT, dz)
    else:
        solve_square(small, dof, order, pivot, g, SINGULAR, line[WORK], dz)
    turn, shift = TINY, TINY
    for k in range(move.shape[0]):
        value = 0.0
        for j in range(dof):
            value += null[j, k] * dz[j]
        move[k] = value
        if k % 3 == 2:
            turn = max(turn, abs(value))
        else:
            shift = max(shift, abs(value))
    share = min(1.0, min(state[MOST_TURN] / turn, state[MOST_TURN] * state[EXTENT] / shift))
    for j in range(dof):
        dz[j] *= share
    for k in range(move.shape[0]):
        move[k] *= share
    return max(turn * size, shift)


@compiled
def advance(m, t, q, scale, size, downhill, links, arm, wide, norm, order, pivot, null, line, state, most):
    """One step along line[MOVE], halved until it is safe and an improvement; q and the state move. False if none is."""
    force, n = m.force, q.shape[0]
    move, trial, dof = line[MOVE], line[TRIAL], int(state[DOF])
    ahead = 0.0  # force along the step, at its start
    for j in range(dof):
        ahead += line[G, j] * line[DZ, j]
    merit_at(m, q)
    offsets(m, links, 0, arm)
    share = 1.0
    for _ in range(HALVINGS):
        state[TRIALS] += 1.0
        if state[TRIALS] >= most:
            return False
        for k in range(n):
            trial[k] = q[k] + share * move[k]
        gap, _ = close_position(m, t, trial, line[START], CLOSED * size, ITERATIONS)
        fine = gap < SHUT * size
        if fine:
            offsets(m, links, links.shape[0], arm)
            fine = not changed_side(arm, links)
        if fine:
            fine = reduce(m, t, trial, scale, wide, norm, order, pivot, null, line) == dof
        if fine:
            length = 0.0
            for j in range(dof):
                length += line[G, j] * line[G, j]
            length = math.sqrt(length)
            if downhill:  # not beyond the point where the force along the step reverses
                along = 0.0
                for k in range(n):
                    along += force[k // 3 + 1, k % 3] * move[k]
                fine = (along > -0.5 * ahead and length < math.inf) or length < state[G_LENGTH]
            else:
                fine = length < state[G_LENGTH] * (1.0 - LESS * share)
            if fine:
                for k in range(n):
                    q[k] = trial[k]
                state[G_LENGTH] = length
                state[G_SIZE] = largest_of(line[G], dof)
                return True
        share *= 0.5
    return False


@compiled
def begin(m, t, q, scale, size, wide, norm, order, pivot, null, line, state):
    """Assemble the mechanism at a start and evaluate it; False if it cannot be assembled."""
    gap, _ = close_position(m, t, q, line[START], CLOSED * size, ITERATIONS)
    if not gap < SHUT * size:
        return False
    dof = reduce(m, t, q, scale, wide, norm, order, pivot, null, line)
    extent, square = size, 0.0
    for k in range(q.shape[0]):
        if k % 3 < 2:
            extent = max(extent, abs(q[k]))
    for j in range(dof):
        square += line[G, j] * line[G, j]
    state[EXTENT], state[FORCE_SIZE], state[DOF] = extent, force_size(m, size), float(dof)
    state[G_SIZE], state[G_LENGTH], state[PHASE] = largest_of(line[G], dof), math.sqrt(square), 1.0
    return True


@compiled
def balanced(state, force):
    """FOUND if reduced forces of this size [N] are those of an equilibrium, LOST otherwise."""
    return FOUND if force <= BALANCED * state[FORCE_SIZE] else LOST


@compiled
def outcome_before(state, far, size):
    """GOING if a step of length `far` [m] is worth it; otherwise what the search has come to."""
    if not far < math.inf:
        return LOST
    if far < NO_STEP * size:  # if H vanishes the step is zero too
        return balanced(state, state[G_SIZE])
    if state[G_SIZE] <= BALANCED_WELL * state[FORCE_SIZE] and far < SHORT_STEP * size:
        return FOUND
    return GOING


@compiled
def find(
    m, t, q, scale, size, step, downhill, rounds, positions, count, near,
    links, arm, wide, norm, order, pivot, null, line, small, state, order_h, pivot_h, most,
):  # fmt: skip
    """From a start q to an equilibrium, in place; to a stable one if `downhill`.

    rounds: Newton steps after which the call returns GOING, to be called again.  positions (k, 3 nb) [m, rad]: those
    that need not be found again, the first `count` of them, within `near`.  most: number of positions to try.
    state[PHASE] is 0 at the start.
    """
    if state[PHASE] == 0.0 and not begin(m, t, q, scale, size, wide, norm, order, pivot, null, line, state):
        return LOST
    dof = int(state[DOF])
    for _ in range(rounds):
        if dof == 0:
            return FOUND
        if not state[G_SIZE] < math.inf:
            return LOST
        if is_known(q, positions, count, near, scale):
            return KNOWN
        reduced_stiffness(m, t, q, step, dof, 2, null, line, small)
        far = newton_step(dof, downhill, order_h, pivot_h, line, small, null, state, size)
        before = state[G_SIZE]
        outcome = outcome_before(state, far, size)
        if outcome != GOING:
            return outcome
        if not advance(m, t, q, scale, size, downhill, links, arm, wide, norm, order, pivot, null, line, state, most):
            return balanced(state, before)
        state[ITERATION] += 1.0
        slow = state[G_SIZE] <= BALANCED_SLOWLY * state[FORCE_SIZE] and state[G_SIZE] > SLOW * before
        state[SMALL] = state[SMALL] + 1.0 if slow else 0.0
        if state[SMALL] == 2.0:
            return FOUND
        if state[ITERATION] >= ROUNDS:
            return balanced(state, state[G_SIZE])
    return GOING


@compiled
def walk(m, t, q, scale, size, stride, direction, wide, norm, order, pivot, null, line):
    """A step of length `stride` [m] along the degrees of freedom in the direction of the last one; both in place.

    Returns the remaining gap (inf if there is no continuation), the force along the path and the largest reduced
    force [N].
    """
    n = q.shape[0]
    dof = reduce(m, t, q, scale, wide, norm, order, pivot, null, line)
    move, square = line[MOVE], 0.0
    for k in range(n):
        move[k] = 0.0
    for j in range(dof):
        part = 0.0
        for k in range(n):
            part += null[j, k] * direction[k] / (scale[k] * scale[k])
        square += part * part
        for k in range(n):
            move[k] += part * null[j, k]
    if not square > ALONG:
        return math.inf, 0.0, 0.0
    for k in range(n):
        direction[k] = move[k] / math.sqrt(square)
        q[k] += stride * direction[k]
    gap, _ = close_position(m, t, q, line[START], CLOSED * size, ITERATIONS)
    if not gap < SHUT * size:
        return math.inf, 0.0, 0.0
    dof = reduce(m, t, q, scale, wide, norm, order, pivot, null, line)
    along = 0.0
    for j in range(dof):
        part = 0.0
        for k in range(n):
            part += null[j, k] * direction[k] / (scale[k] * scale[k])
        along += part * line[G, j]
    return gap, along, largest_of(line[G], dof)


@compiled
def displace(m, q, target, scale, rounds, wide, norm, order, pivot, line):
    """Change q [m, rad] by the least amount so that the residuals of the rows are `target` (nr,), in place."""
    rows, change, n = m.rows, line[WORK], q.shape[0]
    for _ in range(rounds):
        merit_at(m, q)
        scaled_rows(m, scale, wide, norm)
        rank = triangulate(wide, wide.shape[0], order, pivot, RANK)
        for k in range(n):
            change[k] = 0.0
        for k in range(rank):
            r = order[k]
            change[k] = (target[r] - rows[r, at.RES]) / norm[r]
        solve_lower(wide, pivot, rank, change)
        out_of_basis(wide, pivot, rank, change)
        most = 0.0
        for k in range(n):
            change[k] *= scale[k]
            q[k] += change[k]
            most = max(most, abs(change[k]))
        if most < AT_TARGET:
            break
