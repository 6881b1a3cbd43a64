"""The classical Runge-Kutta method of order 4 with a fixed step; between steps the cubic of Hermite.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.1. The paper's method.
"""

from __future__ import annotations

from rattle.equations.motion import derivative
from rattle.jit.functions import native
from rattle.solvers.peaks.samples import LAST_STAGE, gauge
from rattle.solvers.sign_watch import watched_change

ORDER = 4


@native("i", "h", "f", "f")
def step(m, t, h):
    """One step from (t, y) into y_new; returns True when a watched force changed its sign on the way."""
    y, f, k, stage, y_new = m.state, m.rate, m.slopes, m.stage, m.state_new
    ny = y.shape[0]
    changed = False
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
    return changed


@native("void", "h")
def prepare_dense(m):
    """Without the upper rows the dense output is the cubic of Hermite."""
    dense = m.dense
    for row in range(3, 7):
        for n in range(dense.shape[1]):
            dense[row, n] = 0.0
