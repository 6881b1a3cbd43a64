"""The classical Runge-Kutta method of order 4 with a fixed step; cubic Hermite interpolation within a step.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.1. The paper's method.
"""

from __future__ import annotations

import math

from rattle.equations.motion import derivative
from rattle.jit.functions import kernel
from rattle.registry import kind
from rattle.solvers.peaks.samples import LAST_STAGE, RK4, gauge
from rattle.solvers.sign_watch import watched_change
from rattle.solvers.stepper import FixedStepper


@kernel("stepper")
def step(m, t, h, rtol, atol, tame):
    """One step from (t [s], y) of length h [s] into y_new, without error control.

    Returns 0, or inf if y_new is not finite, and True if a monitored force changed its sign at a stage.
    """
    y, f, k, stage, y_new = m.state, m.rate, m.slopes, m.stage, m.state_new
    ny = y.shape[0]
    changed, error = False, 0.0
    for n in range(ny):
        k[0, n] = f[n]
    for s in range(1, 4):
        share = 1.0 if s == 3 else 0.5
        for n in range(ny):
            stage[n] = y[n] + share * h * k[s - 1, n]
        derivative(m, t + share * h, stage, k[s])
        gauge(m, LAST_STAGE if s == 3 else 2 + s, t + share * h)
        changed |= watched_change(m)
    for n in range(ny):
        y_new[n] = y[n] + h / 6.0 * (k[0, n] + 2.0 * k[1, n] + 2.0 * k[2, n] + k[3, n])
        if not abs(y_new[n]) < math.inf:
            error = math.inf
    return error, changed


@kernel("dense output")
def prepare_dense(m, t, h):
    """Set the upper rows to zero: the dense output is then the cubic Hermite polynomial."""
    dense = m.dense
    for row in range(3, 7):
        for n in range(dense.shape[1]):
            dense[row, n] = 0.0


@kind("stepper", "rk4", step)
class Rk4(FixedStepper):
    """The classical Runge-Kutta method of order 4 with fixed steps: to compare with other programs.

    Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.1.
    """

    order = 4
    stages = 4
    samples = RK4
    dense_output = prepare_dense
    refinement = 10 ** (1 / 4)
