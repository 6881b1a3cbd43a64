"""Jacobian J of y' = f(t, y) and solutions of (lambda - J) x = r, for implicit steppers.

Only positions q, rates v and states z act back on the motion; energies and impulses are left out.  As q' = v,

    lambda dq - dv = r_q
    (lambda - D - K / lambda) (dv, dz) = (r_v, r_z) + K r_q / lambda,     dq = (r_q + dv) / lambda

with K and D the derivatives of (dv/dt, dz/dt) by q and (v, z): the matrix has one row for each rate and each state z.
A complex one, P + i Q, is factored as the real one of twice its size, [P, -Q; Q, P].

K and D are forward differences.  They decide how fast the iteration of a stepper converges, not what it converges to.
Their lengths are small against the least penetration, at most INCREMENT of the mechanism's size, and large against
rounding.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), section IV.8, equations (8.11) to (8.14).
"""

from __future__ import annotations

import numpy as np

from rattle.equations.motion import derivative
from rattle.equations.state import states_at
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.jit.small_matrices import factor_lu, solve_lu

INCREMENT = 1e-10  # of positions and angles, as a share of the mechanism's size and of 1 rad, at most
SMALLEST = 1e-13  # the same, at least
SHALLOW = 0.01  # of the least penetration
FASTER = 1e-9  # of rates as a share of the largest, of states as a share of each
INSIDE = 1e-3  # share of the step after which J is taken
NEARLY = 1.5  # ratio to a shorter step for which J is as good
# rows of `newton`: increments of a stage that is expected, scratch, a derivative, the derivative to which J belongs
AHEAD, WORK, MOVED, AT_RATE = 1, 12, 13, 14


def implicit_arrays(bodies: int, states: int, ny: int) -> dict[str, np.ndarray]:
    """Arrays of an implicit stepper for `bodies` bodies, `states` states of elements and a state of ny numbers."""
    n = 3 * bodies + states
    iteration = np.zeros(at.width("iteration"))
    iteration[at.STALE], iteration[at.JACOBIAN_T], iteration[at.BEARS] = 1.0, -np.inf, np.inf
    return {
        "jacobian": np.zeros((n, n + 3 * bodies)),
        "shifted": np.zeros((n, n)),
        "shifted_pair": np.zeros((2 * n, 2 * n)),
        "shifted_order": np.zeros(n, np.int64),
        "pair_order": np.zeros(2 * n, np.int64),
        "newton": np.zeros((19, max(ny, 2 * n))),
        "iteration": iteration,
    }


@compiled
def acting(m, c):
    """Index in y of number c of those that act on the motion: positions, rates, then states."""
    nq = m.change.shape[0]
    return c if c < 2 * nq else states_at(m) + c - 2 * nq


@compiled
def sizes(m, h):
    """Largest length [m], speed [m/s] and angular velocity [rad/s] within a step of length h [s]."""
    y, f, measure, nq = m.state, m.rate, m.measure, m.change.shape[0]
    reach, speed, turning = 0.0, 0.0, 0.0
    for r in range(measure.shape[0]):
        if measure[r] > 0.0:
            reach = max(reach, 1.0 / measure[r])
    for k in range(nq):
        rate = abs(y[nq + k]) + h * abs(f[nq + k])
        if k % 3 == 2:
            turning = max(turning, rate)
        else:
            speed, reach = max(speed, rate), max(reach, abs(y[k]))
    return reach if reach > 0.0 else 1.0, speed, turning


@compiled
def increment(m, reach):
    """Increment of angles [rad], and of positions as a share of reach [m], after `derivative` at the base."""
    kinematics, memory, step = m.contact_kinematics, m.contact_memory, INCREMENT
    for n in range(kinematics.shape[0]):
        depth = -kinematics[n, at.GAP] if m.lever[n, at.ANGULAR] > 0.0 else -kinematics[n, at.GAP] / reach
        elastic = m.contact[n, at.IMPACT] == 0 and m.contact[n, at.LEVEL] == 0
        if depth > 0.0 and memory[n, at.CLOSED] != at.OPEN and elastic:
            step = min(step, max(SMALLEST, SHALLOW * depth))
    return step


@native("void", "h", "f", "f", "i")
def differentiate(m, t, h, ahead):
    """J within the step from t [s] of length h [s]: at the increments in row AHEAD of `newton` if ahead is 1.

    Otherwise just after the start, so that a contact that begins there is in contact.
    """
    y, f, trial, moved, jacobian, iteration = m.state, m.rate, m.stage, m.newton[MOVED], m.jacobian, m.iteration
    nq, base = m.change.shape[0], m.newton[WORK]
    reach, speed, turning = sizes(m, h)
    for n in range(y.shape[0]):
        trial[n] = y[n] + (INSIDE * h * y[nq + n] if n < nq else 0.0)
        m.newton[AT_RATE, n] = f[n]
    if ahead:
        for c in range(jacobian.shape[1]):
            k = acting(m, c)
            trial[k] = y[k] + m.newton[AHEAD, k]
    derivative(m, t, trial, base)
    least = increment(m, reach)
    for c in range(jacobian.shape[1]):
        k = acting(m, c)
        start = trial[k]
        if c < 2 * nq:
            size = 1.0 if c % 3 == 2 else reach
            step = least * size
            if c >= nq:  # one that changes the position within the step by more than rounding, or a share of the rates
                step = max(SMALLEST * size / h, FASTER * (turning if c % 3 == 2 else speed))
                step = step if start >= 0.0 else -step  # away from rest, where the force of a film has a kink
        else:
            step = FASTER * (abs(y[k]) + h * abs(f[k])) + FASTER * FASTER
        trial[k] = start + step
        step = trial[k] - start
        derivative(m, t, trial, moved)
        for r in range(jacobian.shape[0]):
            j = acting(m, nq + r)
            jacobian[r, c] = (moved[j] - base[j]) / step
        trial[k] = start
    m.tally[at.EVALUATIONS] += jacobian.shape[1] + 1
    iteration[at.JACOBIAN_T], iteration[at.JACOBIAN_H] = t, h
    iteration[at.STALE], iteration[at.FACTORED_H] = 0.0, 0.0


@compiled
def is_current(m, t, h):
    """True if J was taken for this step from t [s] of length h [s], or one not much longer, with this derivative."""
    f, then = m.rate, m.newton[AT_RATE]
    if m.iteration[at.JACOBIAN_T] != t or m.iteration[at.JACOBIAN_H] > NEARLY * h:
        return False
    for n in range(f.shape[0]):
        if f[n] != then[n]:
            return False
    return True


@native("i", "h", "f", "f", "f")
def factor_shifted(m, real, re, im):
    """Factor the matrices for lambda = real and lambda = re + i im [1/s]; False if one of them is singular."""
    jacobian, single, pair = m.jacobian, m.shifted, m.shifted_pair
    n, nq = jacobian.shape[0], m.change.shape[0]
    size = re * re + im * im
    for r in range(n):
        for c in range(n):
            p = -jacobian[r, nq + c]
            stiffness = jacobian[r, c] if c < nq else 0.0
            single[r, c] = p - stiffness / real
            p -= stiffness * re / size
            q = stiffness * im / size
            if r == c:
                single[r, c] += real
                p += re
                q += im
            pair[r, c], pair[n + r, n + c] = p, p
            pair[r, n + c], pair[n + r, c] = -q, q
    return factor_lu(single, m.shifted_order) and factor_lu(pair, m.pair_order)


@native("void", "h", "f", "v")
def solve_real(m, real, x):
    """Solve (lambda - J) x = r with lambda = real [1/s], in place; x is laid out like y, what does not act stays."""
    jacobian, u, nq = m.jacobian, m.newton[WORK], m.change.shape[0]
    for r in range(jacobian.shape[0]):
        pull = 0.0
        for c in range(nq):
            pull += jacobian[r, c] * x[c]
        u[r] = x[acting(m, nq + r)] + pull / real
    solve_lu(m.shifted, m.shifted_order, u)
    for r in range(jacobian.shape[0]):
        x[acting(m, nq + r)] = u[r]
    for c in range(nq):
        x[c] = (x[c] + u[c]) / real


@native("void", "h", "f", "f", "v", "v")
def solve_pair(m, re, im, x, y):
    """Solve (lambda - J) (x + i y) = r with lambda = re + i im [1/s], in place, as `solve_real`."""
    jacobian, u, nq = m.jacobian, m.newton[WORK], m.change.shape[0]
    n, size = jacobian.shape[0], re * re + im * im
    for r in range(n):
        pull_x, pull_y = 0.0, 0.0
        for c in range(nq):
            pull_x += jacobian[r, c] * x[c]
            pull_y += jacobian[r, c] * y[c]
        k = acting(m, nq + r)
        u[r] = x[k] + (pull_x * re + pull_y * im) / size
        u[n + r] = y[k] + (pull_y * re - pull_x * im) / size
    solve_lu(m.shifted_pair, m.pair_order, u)
    for r in range(n):
        k = acting(m, nq + r)
        x[k], y[k] = u[r], u[n + r]
    for c in range(nq):
        a, b = x[c] + u[c], y[c] + u[n + c]
        x[c], y[c] = (a * re + b * im) / size, (b * re - a * im) / size
