"""Radau IIA of order 5: implicit, L-stable, stiffly accurate, three stages; for stiff contacts and oil films.

    Z_i = h sum_j A_ij f(t + C_j h, y + Z_j),     y_new = y + Z_3

A simplified Newton iteration solves for the increments Z of the stages.  Its Jacobian J (`shifted_matrices`), taken
where the second stage is expected, is kept from step to step while the iteration converges fast.  With W = T^-1 Z it
falls into a real system and a complex one,

    (REAL / h - J) dW_1 = (T^-1 F)_1 - REAL / h W_1,     ((RE + i IM) / h - J) (dW_2 + i dW_3) = ..

It begins with the stages of the step before, continued.  The error is that of an embedded formula of order 3,

    e = (REAL / h - J)^-1 (f(t, y) - u'(0) / h),     u: the polynomial through the start and the stages, share theta

which grows with h^4, that of the step with h^6: tolerances for e are 0.1 rtol^(2/3) and as much of atol.  Dense output
is w = u(theta) + REAL e (theta - 4.5 theta^2 + 6 theta^3 - 2.5 theta^4), whose derivative is right at the start too as
long as the step resolves it; its error is h^5, without e it were h^4.  What follows the motion at once, because it is
stiff, comes closer than that, so that forces of stiff contacts and films are as good inside a step as at its ends: with
the defect d = f(w) - w'/h at four shares of the step, w is corrected there by

    -J (REAL / h - J)^-2 d,     for large J the Newton step -J^-1 d, for small J nothing

Energies and impulses do not act on the motion: they are integrated with the derivatives of the last iteration.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), section IV.8.
"""

from __future__ import annotations

import math

from rattle.equations.motion import derivative
from rattle.equations.state import WORK, energies_at, states_at
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel, native
from rattle.registry import kind
from rattle.solvers.dense_output import interpolate
from rattle.solvers.projection import project_on_constraints
from rattle.solvers.radau_tableau import FIT, IM, INNER, RE, REAL, SLOPE, TI, A, C, E, T
from rattle.solvers.shifted_matrices import (
    MOVED,
    acting,
    differentiate,
    factor_shifted,
    is_current,
    solve_pair,
    solve_real,
)
from rattle.solvers.sign_watch import watched_change
from rattle.solvers.state_switches import crossed
from rattle.solvers.step_size import SAFETY
from rattle.solvers.stepper import OILED, AdaptiveStepper

# first rows of `newton` after Z in 0 to 2: Z of the step before, W, then dW or e and the slope that u lacks
KEPT, W, CORRECTION, ERROR, FIRST = 3, 6, 9, 9, 10
SETTLED, AGAIN = 15, 0  # rows of `newton` for dense output: corrections at four shares of the step, scratch
MOST_ROUNDS = 8
CONVERGED, SLOW, NO_NUMBER = 0, 1, 2  # outcome of an iteration
FINE = 1e-8  # error of the iteration, as a share of the increments, that counts as converged whatever the tolerances
ROUNDING = 2e-15
STUCK, ROUGH = 0.01, 1e-6  # of the tolerances and increments: corrections that rounding of stiff forces may cause
SLOW_RATE = 0.03  # ratio of two corrections above which the next step takes a new Jacobian
HALF = (SAFETY / 0.5) ** 4  # error that makes the next attempt half as long
BEARABLE = 0.15  # ratio of two corrections that the next step may have; it is proportional to the step at most
REMEMBERED, REGROWTH = 0.6, 1.2  # share of a step that failed which the next ones may reach, and how that grows
CONTINUED = 3.0  # growth of the step up to which stages are continued
LEAST_OF_ITERATION = 10.0  # roundings, over the tolerance: smallest error of the iteration that counts
MOST_OF_ITERATION = 0.03  # largest one [tolerances], below the square root of rtol, which is less at fine tolerances
CONTRACTS = 1e-3  # least ratio of corrections by which the length that the next step may have is told
WIDE, WIDE_POWER = 0.1, 2.0 / 3.0  # tolerance of the error estimate, whose order is lower: WIDE rtol^WIDE_POWER


@compiled
def numbers_acting(m):
    """How many numbers of y act on the motion."""
    return m.jacobian.shape[1]


@compiled
def through(m, first, k, theta):
    """The polynomial through 0 and the increments of number k of y in rows first to first + 2, at the share theta."""
    z = m.newton
    end = z[first + 2, k]
    first_slope = (z[first, k] / C[0] - end) / (1.0 - C[0])
    second_slope = (z[first + 1, k] / C[1] - end) / (1.0 - C[1])
    bend = (second_slope - first_slope) / (C[1] - C[0])
    return theta * (end + (1.0 - theta) * (first_slope + (theta - C[0]) * bend))


@compiled
def guess(m, t, h):
    """First Z and W for the step from t [s] of length h [s]; 1 if they follow from the step before, 0 if they are 0."""
    z, iteration = m.newton, m.iteration
    before = iteration[at.KEPT_H]
    again, onwards = t == iteration[at.KEPT_T], t == iteration[at.KEPT_T] + before
    continues = (again or onwards) and before > 0.0 and h <= CONTINUED * before
    past = 1.0 if onwards else 0.0
    for c in range(numbers_acting(m)):
        k = acting(m, c)
        origin = through(m, KEPT, k, past) if continues else 0.0
        for i in range(3):
            z[i, k] = through(m, KEPT, k, past + C[i] * h / before) - origin if continues else 0.0
        for i in range(3):
            z[W + i, k] = TI[i, 0] * z[0, k] + TI[i, 1] * z[1, k] + TI[i, 2] * z[2, k]
    return 1 if continues else 0


@compiled
def evaluate_stages(m, t, h, tame):
    """Derivatives at the stages into `slopes` 1 to 3; True if a monitored force has changed its sign at one."""
    y, z, stage, slopes = m.state, m.newton, m.stage, m.slopes
    changed = False
    if m.switch.shape[0] > 0 or m.dry.shape[0] > 0:
        crossed(m)  # what earlier iterates and the Jacobian have seen does not count
    for i in range(3):
        for n in range(y.shape[0]):
            stage[n] = y[n]
        for c in range(numbers_acting(m)):
            k = acting(m, c)
            stage[k] = y[k] + z[i, k]
        if tame == 1:
            project_on_constraints(m, t + C[i] * h, stage, stage)
        derivative(m, t + C[i] * h, stage, slopes[i + 1])
        changed |= watched_change(m)
    m.tally[at.EVALUATIONS] += 3
    return changed


@compiled
def correct_stages(m, h, rtol, atol):
    """One correction of W and Z; returns its size and that of W, relative to the tolerances."""
    y, z, slopes = m.state, m.newton, m.slopes
    x, count = CORRECTION, numbers_acting(m)
    for c in range(count):
        k = acting(m, c)
        f0, f1, f2 = slopes[1, k], slopes[2, k], slopes[3, k]
        w0, w1, w2 = z[W, k], z[W + 1, k], z[W + 2, k]
        z[x, k] = TI[0, 0] * f0 + TI[0, 1] * f1 + TI[0, 2] * f2 - REAL / h * w0
        z[x + 1, k] = TI[1, 0] * f0 + TI[1, 1] * f1 + TI[1, 2] * f2 - (RE * w1 - IM * w2) / h
        z[x + 2, k] = TI[2, 0] * f0 + TI[2, 1] * f1 + TI[2, 2] * f2 - (IM * w1 + RE * w2) / h
    solve_real(m, REAL / h, z[x])
    solve_pair(m, RE / h, IM / h, z[x + 1], z[x + 2])
    size, whole = 0.0, 0.0
    for c in range(count):
        k = acting(m, c)
        scale = atol + rtol * abs(y[k])
        for i in range(3):
            z[W + i, k] += z[x + i, k]
            size += (z[x + i, k] / scale) ** 2
            whole += (z[W + i, k] / scale) ** 2
        for i in range(3):
            z[i, k] = T[i, 0] * z[W, k] + T[i, 1] * z[W + 1, k] + T[i, 2] * z[W + 2, k]
    return math.sqrt(size / (3 * count)), math.sqrt(whole / (3 * count))


@native("ii", "h", "f", "f", "f", "f", "i")
def iterate(m, t, h, rtol, atol, tame):
    """Solve for the stages of the step from t [s] of length h [s]: outcome, and 1 if monitored forces change signs."""
    iteration, least = m.iteration, LEAST_OF_ITERATION * ROUNDING / rtol
    enough = max(least, min(MOST_OF_ITERATION, math.sqrt(rtol)))
    before, left, rate = 0.0, math.inf, 0.0
    changed = False
    guess(m, t, h)
    iteration[at.CONTRACTION] = 0.0
    for k in range(MOST_ROUNDS):
        changed = evaluate_stages(m, t, h, tame)
        size, whole = correct_stages(m, h, rtol, atol)
        if not size < math.inf:
            return NO_NUMBER, changed
        iteration[at.ROUNDS] = k + 1
        left = size if size <= FINE * whole else math.inf
        if k > 0:
            rate = size / before if before > 0.0 else 0.0
            left = rate / (1.0 - rate) * size if rate < 1.0 else math.inf
            rough = min(STUCK, ROUGH * whole)
            if before > max(rough, FINE * whole):  # below that rounding counts
                iteration[at.CONTRACTION] = rate
            if rate >= 1.0 or left * rate ** (MOST_ROUNDS - 1 - k) > enough:
                return (CONVERGED if size < max(enough, rough) else SLOW), changed
        if left <= min(enough, max(least, FINE * whole)):
            return CONVERGED, changed
        before = size
    return (CONVERGED if left <= enough else SLOW), changed


@native("ii", "h", "f", "f", "f", "f", "i")
def solve_stages(m, t, h, rtol, atol, tame):
    """The same with the Jacobian at hand or, if that does not do, a new one."""
    iteration = m.iteration
    outcome, changed = SLOW, 0
    current = is_current(m, t, h)
    if iteration[at.STALE] == 1.0 and not current:
        differentiate(m, t, h, guess(m, t, h))
        current = True
    for _ in range(2):
        if iteration[at.FACTORED_H] != h:
            iteration[at.FACTORED_H] = h
            outcome = CONVERGED if factor_shifted(m, REAL / h, RE / h, IM / h) else NO_NUMBER
        else:
            outcome = CONVERGED
        if outcome == CONVERGED:
            outcome, changed = iterate(m, t, h, rtol, atol, tame)
        if outcome == CONVERGED or current:
            break
        differentiate(m, t, h, guess(m, t, h))
        current = True
    slow = iteration[at.ROUNDS] > 2.0 and iteration[at.CONTRACTION] > SLOW_RATE
    if outcome != CONVERGED:
        iteration[at.FAILED], iteration[at.BEARS] = 1.0, REMEMBERED * h
    iteration[at.STALE] = 1.0 if outcome != CONVERGED or slow else 0.0
    return outcome, changed


@compiled
def error_of(m, f, h, rtol, atol):
    """e of the step of length h [s] relative to the tolerances, and into row ERROR; f: derivative at its start.

    The work of gravity that is a function of time counts too, as it goes on where nothing moves.
    """
    y, y_new, z, count = m.state, m.state_new, m.newton, numbers_acting(m)
    for c in range(count):
        k = acting(m, c)
        z[ERROR, k] = f[k] + (E[0] * z[0, k] + E[1] * z[1, k] + E[2] * z[2, k]) / h
    solve_real(m, REAL / h, z[ERROR])
    total = 0.0
    for c in range(count):
        k = acting(m, c)
        total += (z[ERROR, k] / (atol + rtol * max(abs(y[k]), abs(y_new[k])))) ** 2
    if m.falling.shape[0] > 0:
        k = energies_at(m) + WORK
        off = (h * f[k] + E[0] * z[0, k] + E[1] * z[1, k] + E[2] * z[2, k]) / REAL
        total += (off / (atol + rtol * max(abs(y[k]), abs(y_new[k])))) ** 2
    return math.sqrt(total / count)


@compiled
def end_stages(m, t, h):
    """y_new from the stages; increments of energies and impulses; the stages are kept for dense output and guess."""
    y, y_new, z, slopes, iteration = m.state, m.state_new, m.newton, m.slopes, m.iteration
    for n in range(2 * m.change.shape[0], states_at(m)):
        for i in range(3):
            z[i, n] = h * (A[i, 0] * slopes[1, n] + A[i, 1] * slopes[2, n] + A[i, 2] * slopes[3, n])
    for n in range(y.shape[0]):
        y_new[n] = y[n] + z[2, n]
        for i in range(3):
            z[KEPT + i, n] = z[i, n]
    iteration[at.KEPT_T], iteration[at.KEPT_H] = t, h


@compiled
def held_back(m, h, error):
    """The error of a step or a larger one, so that the next is not longer than the iteration is likely to bear."""
    iteration = m.iteration
    bearable = BEARABLE / max(iteration[at.CONTRACTION], CONTRACTS)
    growth = 1.0 if iteration[at.FAILED] == 1.0 else max(1.0, min(bearable, iteration[at.BEARS] / h))
    if error <= 1.0:
        iteration[at.FAILED] = 0.0
        iteration[at.BEARS] *= REGROWTH
    return max(error, (SAFETY / growth) ** 4)


@kernel("stepper")
def step(m, t, h, rtol, atol, tame):
    """One step from (t [s], y) of length h [s] into y_new; tame: stages are projected onto the constraints first.

    Returns the error relative to the tolerance, and True if a monitored force changed its sign at a stage.
    """
    y, f, stage, slopes = m.state, m.rate, m.stage, m.slopes
    for n in range(y.shape[0]):
        slopes[0, n] = f[n]
    wide = WIDE * rtol**WIDE_POWER
    atol *= wide / rtol
    outcome, changed = solve_stages(m, t, h, wide, atol, tame)
    if outcome != CONVERGED:
        return (HALF if outcome == SLOW else math.inf), changed
    end_stages(m, t, h)
    error = error_of(m, f, h, wide, atol)
    if error > 1.0:  # of a stiff component that is not at rest the estimate is too large: filtered once more
        for n in range(y.shape[0]):
            stage[n] = y[n]
        for c in range(numbers_acting(m)):
            k = acting(m, c)
            stage[k] = y[k] + m.newton[ERROR, k]
        derivative(m, t, stage, m.newton[MOVED])
        m.tally[at.EVALUATIONS] += 1
        error = error_of(m, m.newton[MOVED], h, wide, atol)
    return held_back(m, h, error), changed


@compiled
def unresolved_start(m, h):
    """h f(t, y) - u'(0) of what does not act on the motion, filtered as much as that of the motion, into row FIRST."""
    f, z, nq = m.rate, m.newton, m.change.shape[0]
    left, whole = 0.0, 0.0
    for n in range(f.shape[0]):
        z[FIRST, n] = h * f[n] + E[0] * z[KEPT, n] + E[1] * z[KEPT + 1, n] + E[2] * z[KEPT + 2, n]
    for c in range(nq, numbers_acting(m)):
        k = acting(m, c)
        whole += z[FIRST, k] ** 2
        z[FIRST, k] = REAL * z[ERROR, k]
        left += z[FIRST, k] ** 2
    share = math.sqrt(left / whole) if left < whole else 1.0
    for c in range(nq):
        z[FIRST, c] = REAL * z[ERROR, c]
    for n in range(2 * nq, states_at(m)):
        z[FIRST, n] *= share


@compiled
def settle(m, t, h):
    """Correct what is stiff in the dense output at four shares of the step, by a polynomial that is 0 at its ends."""
    z, dense, stage, count = m.newton, m.dense, m.stage, numbers_acting(m)
    real = REAL / m.iteration[at.FACTORED_H]
    for i in range(4):
        interpolate(m, INNER[i], stage)
        derivative(m, t + INNER[i] * h, stage, m.newton[MOVED])
        x, again = z[SETTLED + i], z[AGAIN]
        for c in range(count):
            k = acting(m, c)
            slope = 0.0
            for r in range(4):
                slope += SLOPE[i, r] * dense[r, k]
            x[k] = z[MOVED, k] - slope / h
        solve_real(m, real, x)
        for c in range(count):
            k = acting(m, c)
            again[k] = x[k]
        solve_real(m, real, again)
        for c in range(count):
            k = acting(m, c)
            x[k] -= real * again[k]
    for c in range(count):
        k = acting(m, c)
        for r in range(4):
            for i in range(4):
                dense[1 + r, k] += FIT[r, i] * z[SETTLED + i, k]


@kernel("dense output")
def prepare_dense(m, t, h):
    """The polynomial through the start and the stages, and a term of degree 4, for the cubic through both ends."""
    z, dense = m.newton, m.dense
    unresolved_start(m, h)
    for n in range(dense.shape[1]):
        end = z[KEPT + 2, n]
        first_slope = (z[KEPT, n] / C[0] - end) / (1.0 - C[0])
        second_slope = (z[KEPT + 1, n] / C[1] - end) / (1.0 - C[1])
        bend, first = (second_slope - first_slope) / (C[1] - C[0]), z[FIRST, n]
        dense[1, n] = first_slope - C[0] * bend + first
        dense[2, n] = bend - first
        dense[3, n] = -2.5 * first
        for row in range(4, 7):
            dense[row, n] = 0.0
    settle(m, t, h)


@kind("stepper", "radau", step)
class Radau(AdaptiveStepper):
    """Adaptive implicit Runge-Kutta method of order 5, L-stable: the rate of stiff damping does not limit its steps.

    Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), section IV.8.
    """

    order = 5
    usual_with = (OILED,)
    usual_since = "oil films settle much faster than the mechanism moves"
    error_order = 4
    stages = 1
    dense_stages = 4
    implicit = True
    dense_output = prepare_dense
    refinement = 10 ** (1 / 5)
