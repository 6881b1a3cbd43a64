"""The kernels of all explicit Runge-Kutta methods: what differs between them are the arrays of their tableau.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), sections II.1, II.4 and II.6.
"""

from __future__ import annotations

import math

from rattle.equations.motion import derivative
from rattle.equations.state import WORK, states_at
from rattle.jit.functions import compiled, kernel
from rattle.solvers.peaks.samples import gauge
from rattle.solvers.projection import project_on_constraints
from rattle.solvers.sign_watch import watched_change
from rattle.solvers.step_size import error_share

ERRORS = 5  # first row of `dense` in which errors are summed, before it is used for the dense output


@compiled
def write_stage(m, s, h):
    """Write the state of stage s of a step of length h [s] into `stage`, from the slopes before it."""
    y, k, stage, a = m.state, m.slopes, m.stage, m.stage_weights
    ny = y.shape[0]
    for n in range(ny):
        stage[n] = 0.0
    for j in range(s):
        weight = a[s, j]
        if weight != 0.0:
            for n in range(ny):
                stage[n] += weight * k[j, n]
    for n in range(ny):
        stage[n] = y[n] + h * stage[n]


@compiled
def write_end(m, h):
    """Write the state at the end of a step, and its errors / h, from the slopes of all stages."""
    y, k, y_new, ends, dense = m.state, m.slopes, m.state_new, m.end_weights, m.dense
    ny, errors = y.shape[0], ends.shape[0] - 1
    for n in range(ny):
        y_new[n] = 0.0
    for r in range(errors):
        for n in range(ny):
            dense[ERRORS + r, n] = 0.0
    for s in range(ends.shape[1]):  # the long loop is the inner one
        weight = ends[0, s]
        for n in range(ny):
            y_new[n] += weight * k[s, n]
        for r in range(errors):
            weight = ends[1 + r, s]
            for n in range(ny):
                dense[ERRORS + r, n] += weight * k[s, n]
    for n in range(ny):
        y_new[n] = y[n] + h * y_new[n]


@compiled
def error_of(m, h, rtol, atol):
    """Error of the step relative to the tolerance; without an estimate 0, or inf if the state at its end is not finite.

    Energies and impulses are integrated without error control, but for the work of gravity that is a function of time,
    which goes on where nothing moves; states of elements are controlled.
    """
    y, y_new, dense, errors = m.state, m.state_new, m.dense, m.end_weights.shape[0] - 1
    nq, first_state = 2 * m.change.shape[0], states_at(m)
    first, second = 0.0, 0.0
    for n in range(y.shape[0]):
        if errors == 0 and not abs(y_new[n]) < math.inf:
            return math.inf
        if errors > 0 and (n < nq or n >= first_state or (n == nq + WORK and m.falling.shape[0] > 0)):
            scale = atol + rtol * max(abs(y[n]), abs(y_new[n]))
            first += (dense[ERRORS, n] / scale) ** 2
            if errors == 2:
                second += (dense[ERRORS + 1, n] / scale) ** 2
    return error_share(h, first, second, nq)


@kernel("stepper")
def step(m, t, h, rtol, atol, tame):
    """One step from (t [s], y) of length h [s] into y_new; tame: stages are projected onto the constraints first.

    Returns the error as in `error_of`, and True if a monitored force changed its sign at a stage.
    """
    f, k, stage, c, sample_of = m.rate, m.slopes, m.stage, m.stage_times, m.sample_of_stage
    changed = False
    for n in range(f.shape[0]):
        k[0, n] = f[n]
    for s in range(1, m.end_weights.shape[1]):
        write_stage(m, s, h)
        if tame == 1:
            project_on_constraints(m, t + c[s] * h, stage, stage)
        derivative(m, t + c[s] * h, stage, k[s])
        if sample_of[s] >= 0:
            gauge(m, sample_of[s], t + c[s] * h)
        changed |= watched_change(m)
    write_end(m, h)
    return error_of(m, h, rtol, atol), changed


@kernel("dense output")
def prepare_dense(m, t, h):
    """Further stages and the upper rows of the dense output for the step from (t, y) to (t + h, y_new)."""
    k, dense, f_new, c, weights = m.slopes, m.dense, m.rate_new, m.stage_times, m.dense_weights
    ny, stages, count = m.state.shape[0], m.end_weights.shape[1], c.shape[0]
    if count > stages:
        for n in range(ny):
            k[stages, n] = f_new[n]
    for s in range(stages + 1, count):
        write_stage(m, s, h)
        derivative(m, t + c[s] * h, m.stage, k[s])
    for row in range(3, dense.shape[0]):
        for n in range(ny):
            dense[row, n] = 0.0
    for r in range(weights.shape[0]):
        for s in range(count):
            d = weights[r, s]
            for n in range(ny):
                dense[3 + r, n] += d * k[s, n]
        for n in range(ny):
            dense[3 + r, n] *= h
