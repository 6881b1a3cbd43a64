"""The state inside a step: the cubic polynomial through both ends, and higher terms of the stepper.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.6.
"""

from __future__ import annotations

from rattle.jit import layout as at
from rattle.jit.families import call_dense_output
from rattle.jit.functions import compiled

INSTANT = 1e-16  # share of the time within which two instants are one: the spacing of numbers is up to twice as much
OF_STEP = 1e-15  # share of a step below which it is not divided: a few spacings of numbers at its end
HALVINGS = 60  # of a part of a step: more than there are numbers between its ends


@compiled
def prepare_dense(m, t, h):
    """Compute the dense output of the step from (t [s], y) to (t + h, y_new)."""
    y, f, y_new, f_new, dense = m.state, m.rate, m.state_new, m.rate_new, m.dense
    for n in range(y.shape[0]):
        jump = y_new[n] - y[n]
        dense[0, n] = jump
        dense[1, n] = h * f[n] - jump
        dense[2, n] = 2.0 * jump - h * (f_new[n] + f[n])
    call_dense_output(m.stepper_table[at.DENSE], (m, t, h))


@compiled
def interpolate(m, theta, out):
    """State at the share theta (0 to 1) of the step into `out`, laid out and in the units of y."""
    y, dense = m.state, m.dense
    rest = 1.0 - theta
    for n in range(out.shape[0]):
        value = (dense[4, n] + (dense[5, n] + dense[6, n] * theta) * rest) * theta
        out[n] = (
            y[n] + (dense[0, n] + (dense[1, n] + (dense[2, n] + (dense[3, n] + value) * rest) * theta) * rest) * theta
        )
