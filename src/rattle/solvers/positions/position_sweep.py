"""Sweep of a fully driven mechanism over many positions: no integration, every position is solved for itself.

At each instant  Phi(q, t) = 0,  Phi_q v = nu,  Phi_q dv = gamma,  Phi_q^T lambda = Q - M dv.

The last position with its rates and accelerations predicts the next one, which Newton's method corrects.  The branch is
kept by taking only steps whose correction is small compared with the distance to the nearest other branch, which is
estimated by the square root of the smallest pivot share.  Close to a singular position the equations are
ill-conditioned; a step crosses it, and positions inside are interpolated by the quintic through both sides.

The Schur complement is formed with geometric weights (1, 1, 1/radius^2), so that light bodies do not disturb it.
"""

from __future__ import annotations

import math

from rattle.equations.dry_friction import add_dry_friction
from rattle.equations.motion import constraints, correct, drive, loads, place, rate_residual, residual
from rattle.equations.schur import factorise, solve
from rattle.jit import layout as at
from rattle.jit.families import call_joint
from rattle.jit.functions import compiled
from rattle.solvers.output_row import write
from rattle.solvers.ports import first_port, write_ports

Q, V, A, Q_NEW, V_NEW, A_NEW, Q_OLD, V_OLD, A_OLD = range(9)  # rows of `node`
# clock: time of the node, allowed step, largest gap, root at the node, the roots before it, and their times
NOW, FREE, GAP, ROOT, ROOT_BEFORE, T_BEFORE = range(6)
COUNT, STEPS, FOUND, NEWTON = range(4)  # tally: outputs written, steps, near-singular intervals, Newton iterations
ARRIVED, STUCK = range(2)
WEAK_ROOT = 4e-3  # smallest root at which positions are solved; below it they are too close to a singular position
CORRECTION = 5e-3  # largest correction of a prediction, as a share of the mechanism's size or in rad
SHARE = 0.1  # the same as a share of the distance to another branch
TURN = 0.2  # largest predicted motion in one step [rad, or share of the size]
DEAD = 1e-11  # a motor that moves the driver by less, as a share of the rest of its motion, is at a dead centre
LEAPS = 12  # doublings of a step across a singular position
EXACT = 1e-16  # gap, as a share of the mechanism's size, that no correction makes smaller
LAST = 1e-10  # correction [sizes, rad] after which positions are as good as the factor computed there
SETTLED = 1e-12  # correction [sizes, rad] after which none is needed
ROUNDING = 1e-13  # gap [sizes] that is rounding where a correction has not made it smaller
CLOSED = 1e-12  # gap [sizes] with which positions are closed
MOST_ROUNDS = 12  # of Newton's method
FARTHEST = 0.5  # corrections [sizes, rad] with which it is given up
NARROWS = 0.8  # share of the roots on both sides below which a minimum of the root is recorded
LEAST_STEP = 1e-15  # share of the way to the target below which no step is tried
EASY = 0.1  # share of the largest correction below which the next step may be twice as long


@compiled
def acceleration_residual(m, a):
    """Write Phi_q a - gamma to the right-hand side; returns the largest [m/s^2 or rad/s^2]."""
    rows, x, place_of, row_body = m.rows, m.solution, m.place, m.row_body
    most = 0.0
    for r in range(rows.shape[0]):
        i, j = 3 * row_body[r, at.ROW_A] - 3, 3 * row_body[r, at.ROW_B] - 3
        value = -rows[r, at.GAMMA]
        for k in range(3):
            if i >= 0:
                value += rows[r, at.AX + k] * a[i + k]
            if j >= 0:
                value += rows[r, at.BX + k] * a[j + k]
        x[place_of[r]] = value
        if not abs(value) <= most:
            most = abs(value)
    return most


@compiled
def largest(x, size):
    """Largest component of a motion: angles [rad], lengths as a share of the mechanism's size [m]."""
    most = 0.0
    for k in range(0, x.shape[0], 3):
        value = max(max(abs(x[k]), abs(x[k + 1])) / size, abs(x[k + 2]))
        if not value <= most:  # also catches nan
            most = value
    return most


@compiled
def redundant(m, q):
    """Number of rows that may be redundant at positions q."""
    spare = m.rows.shape[0] - q.shape[0]
    for i in range(1, m.weight.shape[0]):
        if m.weight[i, 0] == 0.0:  # a body without a row stays where it is
            spare += 3
    return spare


@compiled
def close_there(m, q, v, size):
    """Newton's method for the positions q (3 nb,), in place, at the time of the drivers.

    Returns the magnitude of the correction (inf if it failed), the remaining gap [m or rad] and the iterations.
    """
    change, power, spare = m.change, m.power, redundant(m, q)
    moved, last = 0.0, math.inf
    rounds = 0
    place(m, q, v)
    constraints(m)
    gap = residual(m)
    while rounds < MOST_ROUNDS:
        if not gap < math.inf:
            return math.inf, gap, rounds
        power[at.PIVOT_SHARE] = 1.0
        if factorise(m) > spare:
            power[at.PIVOT_SHARE] = 0.0
        if gap <= EXACT * size or last <= LAST:
            break
        correct(m)
        last = largest(change, size)
        if not last < FARTHEST or not moved < FARTHEST:
            return math.inf, gap, rounds
        moved += last
        rounds += 1
        for k in range(q.shape[0]):
            q[k] += change[k]
        place(m, q, v)
        constraints(m)
        before = gap
        gap = residual(m)
        if last <= SETTLED or (gap >= before and gap < ROUNDING * size):
            break  # the present factor is accurate enough
    return (moved if gap < CLOSED * size else math.inf), gap, rounds


@compiled
def closed_at(m, t, node, size):
    """Solve positions, rates and accelerations at t [s], starting from the new rows of `node`.

    Returns the magnitude of the correction (inf if it failed), the root of the smallest pivot share, the remaining
    gap [m or rad] and the number of Newton iterations.
    """
    q, v, a, change = node[Q_NEW], node[V_NEW], node[A_NEW], m.change
    drive(m, t)
    moved, gap, rounds = close_there(m, q, v, size)
    if not moved < math.inf or not rate_residual(m) < math.inf:
        return math.inf, 0.0, gap, rounds
    correct(m)
    for k in range(q.shape[0]):
        v[k] += change[k]
    place(m, q, v)
    constraints(m)
    if not acceleration_residual(m, a) < math.inf:
        return math.inf, 0.0, gap, rounds
    correct(m)
    for k in range(q.shape[0]):
        a[k] += change[k]
    return moved, math.sqrt(m.power[at.PIVOT_SHARE]), gap, rounds


@compiled
def predicted(node, h, size):
    """Write the prediction a time h [s] after the node to the new rows; returns the largest motion, see `largest`."""
    for k in range(node.shape[1]):
        node[V_NEW, k] = h * node[V, k] + 0.5 * h * h * node[A, k]
    move = largest(node[V_NEW], size)
    for k in range(node.shape[1]):
        node[Q_NEW, k] = node[Q, k] + node[V_NEW, k]
        node[V_NEW, k] = node[V, k] + h * node[A, k]
        node[A_NEW, k] = node[A, k]
    return move


@compiled
def react(m, a):
    """Multipliers [N, N m] of a known motion: Phi_q^T lambda = Q - M a, refined once."""
    rows, force, weight, mass, x = m.rows, m.force, m.weight, m.mass, m.solution
    multiplier, acceleration = m.multiplier, m.acceleration
    place_of, row_body = m.place, m.row_body
    for i in range(1, force.shape[0]):
        for k in range(3):
            acceleration[i, k] = a[3 * i - 3 + k]
            force[i, k] -= mass[i, k] * acceleration[i, k]
    for r in range(rows.shape[0]):
        multiplier[r] = 0.0
    for _ in range(2):
        for r in range(rows.shape[0]):
            i, j = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
            value = 0.0
            for k in range(3):
                value += (
                    rows[r, at.AX + k] * weight[i, k] * force[i, k] + rows[r, at.BX + k] * weight[j, k] * force[j, k]
                )
            x[place_of[r]] = value
        solve(m)
        for r in range(rows.shape[0]):
            value = x[place_of[r]]
            multiplier[r] += value
            i, j = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
            for k in range(3):
                force[i, k] -= rows[r, at.AX + k] * value
                force[j, k] -= rows[r, at.BX + k] * value


@compiled
def exchange(m, probe, line, row):
    """Let a motor at another joint do the work of a driver: its row h replaces the driver's row d.

    h = Phi_q^T y gives  lambda_h = lambda_d / y_d  and  lambda -= y lambda_h.  probe (5,): kernel, A, B, first
    parameter of the motor, row d; line (1, 9) scratch.  Writes effort [N or N m] and power [W] of the motor into
    row[0], row[1].
    """
    table, body, values, rows = m.joint_table, m.body, m.values, m.rows
    weight, x, multiplier = m.weight, m.solution, m.multiplier
    place_of, row_body = m.place, m.row_body
    a, b, d = probe[1], probe[2], probe[4]
    call_joint(table[probe[0]], (body, a, b, values, probe[3], 0, line))
    for r in range(rows.shape[0]):
        value = 0.0
        for side in range(2):
            i, c = row_body[r, side], at.AX + 3 * side
            for k in range(3):
                if i == a:
                    value += rows[r, c + k] * weight[i, k] * line[0, at.AX + k]
                if i == b:
                    value += rows[r, c + k] * weight[i, k] * line[0, at.BX + k]
        x[place_of[r]] = value
    solve(m)
    ratio, most = x[place_of[d]], 0.0
    for r in range(rows.shape[0]):
        most = max(most, abs(x[r]))
    motor = multiplier[d] / ratio if abs(ratio) > DEAD * most else math.nan
    rate = 0.0
    for k in range(3):
        rate += line[0, at.AX + k] * body[a, at.VX + k] + line[0, at.BX + k] * body[b, at.VX + k]
    for r in range(rows.shape[0]):
        multiplier[r] -= x[place_of[r]] * motor
    multiplier[d] = 0.0
    row[0] = -motor
    row[1] = -motor * rate


@compiled
def put(m, t, q, v, a, forces, probe, line, row):
    """Write one output row (SI units) for the motion whose rows and factor are in the workspace."""
    body = m.body
    if forces:
        loads(m, t)
        react(m, a)
        if m.dry.shape[0] > 0:
            add_dry_friction(m)
        last = row.shape[0] - 2 * probe.shape[0]
        for n in range(probe.shape[0]):
            exchange(m, probe[n], line, row[last + 2 * n :])
        write(m, 0.0, 0.0, row[:last])
        first = first_port(m)
        if last > first:
            write_ports(m, t, row, first)
        return
    for i in range(1, body.shape[0]):
        c, n = at.PER_BODY * (i - 1), 3 * i - 3
        for k in range(3):
            row[c + at.PLACE + k] = q[n + k]
            row[c + at.RATE + k] = v[n + k]
            row[c + at.RATE_RATE + k] = a[n + k]
    c = at.PER_BODY * (body.shape[0] - 1)
    if row.shape[0] > c:
        loads(m, t)  # evaluates the signals
        write_signals(m, row[c:])


@compiled
def write_signals(m, row):
    """Write the states of the model and the values of all signals to an output row, in their SI units."""
    signals = m.signals
    for n in range(m.state_rate.shape[0] + m.signal.shape[0]):
        row[n] = signals[n]


@compiled
def between(node, theta, h):
    """Quintic through the old and the present node at the share theta of the step h [s], into the new rows."""
    t2, t3 = theta * theta, theta * theta * theta
    for k in range(node.shape[1]):
        q0, v0, a0 = node[Q_OLD, k], h * node[V_OLD, k], h * h * node[A_OLD, k]
        q1, v1, a1 = node[Q, k], h * node[V, k], h * h * node[A, k]
        c3 = 10.0 * (q1 - q0) - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
        c4 = -15.0 * (q1 - q0) + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
        c5 = 6.0 * (q1 - q0) - 3.0 * (v0 + v1) - 0.5 * (a0 - a1)
        node[Q_NEW, k] = q0 + theta * v0 + 0.5 * t2 * a0 + t3 * (c3 + theta * c4 + t2 * c5)
        node[V_NEW, k] = (v0 + theta * a0 + t2 * (3.0 * c3 + 4.0 * theta * c4 + 5.0 * t2 * c5)) / h
        node[A_NEW, k] = (a0 + theta * (6.0 * c3 + 12.0 * theta * c4 + 20.0 * t2 * c5)) / (h * h)


@compiled
def note_spot(spots, tally, before, after):
    """Note that the root has a minimum between two times [s]."""
    if tally[FOUND] < spots.shape[0]:
        spots[tally[FOUND], 0] = before
        spots[tally[FOUND], 1] = after
        tally[FOUND] += 1


@compiled
def arrive(node, clock, tally, spots, t, root):
    """Make the new rows the node at t [s]; records where the root has passed a minimum."""
    for k in range(node.shape[1]):
        for n in range(3):
            node[Q_OLD + n, k] = node[Q + n, k]
            node[Q + n, k] = node[Q_NEW + n, k]
    low = clock[ROOT] <= clock[ROOT_BEFORE] and clock[ROOT] <= root
    if low and clock[ROOT] < NARROWS * max(root, clock[ROOT_BEFORE]):
        note_spot(spots, tally, clock[T_BEFORE], t)
    clock[T_BEFORE] = clock[NOW]
    clock[ROOT_BEFORE] = clock[ROOT]
    clock[NOW] = t
    clock[ROOT] = root
    tally[STEPS] += 1


@compiled
def keeps_branch(correction, root):
    """True if a correction is too small to lead to another branch; root: of the smallest pivot share."""
    return correction <= min(CORRECTION, SHARE * root)


@compiled
def predict_and_close(m, t, h, node, tally, size):
    """A step of length h [s] from the node at t [s]: correction (inf if none), root and gap, as `closed_at`."""
    if not predicted(node, h, size) <= TURN:
        return math.inf, 0.0, 0.0
    correction, root, gap, rounds = closed_at(m, t + h, node, size)
    tally[NEWTON] += rounds
    return correction, root, gap


@compiled
def leap(m, t, h, node, size):
    """A step across a singular position, of a multiple of h [s]: its length (0: none), correction, root and gap."""
    far = h
    for _ in range(LEAPS):
        far *= 2.0
        if predicted(node, far, size) > TURN:
            break
        correction, root, gap, _rounds = closed_at(m, t + far, node, size)
        if keeps_branch(correction, root) and root >= WEAK_ROOT:
            return far, correction, root, gap
    return 0.0, math.inf, 0.0, 0.0


@compiled
def stride(m, target, node, clock, tally, spots, size):
    """One step from the node towards the time `target` [s], across it if it is singular; False if no step succeeds."""
    t = clock[NOW]
    ahead = target - t
    while True:
        h = ahead if abs(ahead) <= clock[FREE] else math.copysign(clock[FREE], ahead)
        if t + h == t or abs(h) < LEAST_STEP * abs(ahead):
            return False
        correction, root, gap = predict_and_close(m, t, h, node, tally, size)
        fine = keeps_branch(correction, root)
        if fine and root >= WEAK_ROOT:
            break
        if clock[ROOT] >= WEAK_ROOT and correction < math.inf:
            if predicted(node, 2.0 * h, size) > TURN:  # too far away to step across
                clock[FREE] = 0.5 * abs(h)
                continue
            far, correction, root, gap = leap(m, t, h, node, size)
            if far != 0.0:
                h = far
                note_spot(spots, tally, t, t + far)
                break
            if fine:  # no solution on the other side: go on into the singular position
                predicted(node, h, size)
                correction, root, gap, _rounds = closed_at(m, t + h, node, size)
        if fine:
            break
        clock[FREE] = 0.5 * abs(h)
    clock[GAP] = max(clock[GAP], gap)
    if correction < EASY * min(CORRECTION, SHARE * root):
        clock[FREE] = max(clock[FREE], 2.0 * abs(h))
    arrive(node, clock, tally, spots, target if h == ahead else t + h, root)
    return True


@compiled
def stop_at(m, target, node, clock, stepped):
    """Motion at the time `target` [s], which the node has reached or a step has crossed, to the new rows of `node`."""
    if target == clock[NOW]:
        for k in range(node.shape[1]):
            for i in range(3):
                node[Q_NEW + i, k] = node[Q + i, k]
        if stepped:  # its rows and factor are in the workspace
            return
    else:
        h = clock[NOW] - clock[T_BEFORE]
        between(node, (target - clock[T_BEFORE]) / h, h)
    drive(m, target)
    place(m, node[Q_NEW], node[V_NEW])
    constraints(m)
    clock[GAP] = max(clock[GAP], residual(m))
    factorise(m)


@compiled
def sweep(m, times, raw, node, clock, tally, spots, size, forces, probe, line, onward):
    """Visit all times [s] (monotone) from the node on and write a row of `raw` for each.

    node (9, 3 nb): the position reached with its rates and accelerations, and scratch; clock (6,); tally (4,);
    spots (n, 2): intervals [s] in which the root of the smallest pivot share has a minimum; size [m];
    forces: with all reactions (rows as `output_row.write` writes them, with ports if they have room, then effort and
    power for each row of `probe` (k, 5), see `exchange`), otherwise bodies and signals only;
    onward: 1 or -1 if these times continue a sweep in this direction (it may have stepped beyond the first of them),
    0 at its start.

    Returns ARRIVED, or STUCK if no step succeeds from clock[NOW]; tally[COUNT] rows are written.
    """
    direction = onward
    if onward == 0.0:
        direction = 1.0 if times[times.shape[0] - 1] >= times[0] else -1.0
    for n in range(times.shape[0]):
        target = times[n]
        if n == 0 and onward == 0.0 and target < clock[NOW]:
            direction = -1.0
        stepped = False
        while (target - clock[NOW]) * direction > 0.0:
            stepped = True
            if not stride(m, target, node, clock, tally, spots, size):
                return STUCK
        stop_at(m, target, node, clock, stepped)
        put(m, target, node[Q_NEW], node[V_NEW], node[A_NEW], forces, probe, line, raw[n])
        tally[COUNT] = n + 1
        if n == 0 and onward == 0.0 and times.shape[0] > 1:
            direction = 1.0 if times[1] >= times[0] else -1.0
    return ARRIVED
