"""Dormand-Prince 8(5, 3): adaptive, order 8, dense output of order 7.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.10.
"""

from __future__ import annotations

import math

from rattle.equations.motion import derivative
from rattle.equations.state import states_at
from rattle.jit.functions import kernel
from rattle.registry import kind
from rattle.solvers.dop853_tableau import E3, E5, A, B, C, D
from rattle.solvers.peaks.samples import DOP853, NODE_OF_STAGE, gauge
from rattle.solvers.projection import project_on_constraints
from rattle.solvers.sign_watch import watched_change
from rattle.solvers.stepper import COMPLIANT, FREE, AdaptiveStepper

STAGES = 12


@kernel("stepper")
def step(m, t, h, rtol, atol, tame):
    """One step from (t [s], y) of length h [s] into y_new; tame: stages are projected onto the constraints first.

    Returns the error relative to the tolerance, and True if a monitored force changed its sign at a stage.
    """
    y, f, k, stage, y_new = m.state, m.rate, m.slopes, m.stage, m.state_new
    ny = y.shape[0]
    nq = 2 * m.change.shape[0]
    changed = False
    for n in range(ny):
        k[0, n] = f[n]
    for s in range(1, STAGES):
        for n in range(ny):
            stage[n] = 0.0
        for j in range(s):
            a = A[s, j]
            if a != 0.0:
                for n in range(ny):
                    stage[n] += a * k[j, n]
        for n in range(ny):
            stage[n] = y[n] + h * stage[n]
        if tame == 1:
            project_on_constraints(m, t + C[s] * h, stage, stage)
        derivative(m, t + C[s] * h, stage, k[s])
        if NODE_OF_STAGE[s] >= 0:
            gauge(m, NODE_OF_STAGE[s], t + C[s] * h)
        changed |= watched_change(m)
    for n in range(ny):  # rows 13 and 14 are free: the errors of order 3 and 5
        y_new[n], k[13, n], k[14, n] = 0.0, 0.0, 0.0
    for s in range(STAGES):  # the long loop is the inner one
        weight, weight3, weight5 = B[s], E3[s], E5[s]
        for n in range(ny):
            y_new[n] += weight * k[s, n]
            k[13, n] += weight3 * k[s, n]
            k[14, n] += weight5 * k[s, n]
    error3, error5, first_state = 0.0, 0.0, states_at(m)
    for n in range(ny):
        e3, e5 = k[13, n], k[14, n]
        y_new[n] = y[n] + h * y_new[n]
        # energies and impulses are integrated without error control; states of elements are controlled
        if n < nq or n >= first_state:
            scale = atol + rtol * max(abs(y[n]), abs(y_new[n]))
            error3 += (e3 / scale) ** 2
            error5 += (e5 / scale) ** 2
    if error5 == 0.0 and error3 == 0.0:
        return 0.0, changed
    return abs(h) * error5 / math.sqrt((error5 + 0.01 * error3) * nq), changed


@kernel("dense output")
def prepare_dense(m, t, h):
    """Three more stages and the upper rows of the dense output for the step from (t, y) to (t + h, y_new)."""
    y, k, stage, dense, f_new = m.state, m.slopes, m.stage, m.dense, m.rate_new
    ny = y.shape[0]
    for n in range(ny):
        k[12, n] = f_new[n]
    for s in range(13, 16):
        for n in range(ny):
            stage[n] = 0.0
        for j in range(s):
            a = A[s, j]
            for n in range(ny):
                stage[n] += a * k[j, n]
        for n in range(ny):
            stage[n] = y[n] + h * stage[n]
        derivative(m, t + C[s] * h, stage, k[s])
    for row in range(3, 7):
        for n in range(ny):
            dense[row, n] = 0.0
        for s in range(16):
            d = D[row - 3, s]
            for n in range(ny):
                dense[row, n] += d * k[s, n]
        for n in range(ny):
            dense[row, n] *= h


@kind("stepper", "dop853", step)
class Dop853(AdaptiveStepper):
    """Adaptive explicit Runge-Kutta method of order 8, the default without impact contacts.

    Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.10.
    """

    order = 8
    usual_with = (FREE, COMPLIANT)
    stages = STAGES
    dense_stages = 3
    stable = 4
    samples = DOP853
    dense_output = prepare_dense
    refinement = 10 ** (1 / 8)
