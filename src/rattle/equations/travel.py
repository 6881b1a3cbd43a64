"""How far drivers have come whose speed s(t) is given: X = int s dt from the start, where no state of a run tells it.

    int_a^b s dt,  b - a = h:   G(a, h) = h/2 sum_i w_i s(a + h/2 (1 + x_i))    (Gauss-Legendre, 8 points)

An interval stands if its two halves together give the same as the whole; otherwise it is halved.  So a kink or jump
costs some forty halvings, and everything else the accuracy of floating point.

Source: Davis, Rabinowitz, Methods of Numerical Integration (1984), section 6.2 (adaptive quadrature).
"""

from __future__ import annotations

import numpy as np

from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.language.jets import evaluate_jet

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(8)
EXACT = 1e-14  # of the interval times the largest speed: error of one part of it; sums of the rule round by 1e-16
SHORTEST = 1e-15  # share of the interval below which no part is halved


@native("void", "h", "f")
def travel_to(m, t):
    """Go on with all travels [rad or m] in `signals` from the time in `travelled` to t [s]."""
    begin = float(m.travelled[0])
    if t == begin:
        return
    for n in range(m.jet.shape[0]):
        state = m.jet[n, at.TRAVEL]
        if state >= 0:
            m.signals[state] += integral(m, n, begin, t)
    m.travelled[0] = t


@compiled
def integral(m, n, begin, end):
    """Integral [rad or m] of the speed of driver n of `jet` between two times [s]."""
    total, most, t, h = 0.0, 0.0, begin, end - begin
    while t != end:
        last = abs(h) >= abs(end - t)
        if last:
            h = end - t
        whole, fastest = over(m, n, t, h)
        first, faster = over(m, n, t, 0.5 * h)
        second, fast = over(m, n, t + 0.5 * h, 0.5 * h)
        most = max(max(most, fastest), max(faster, fast))
        off = abs(first + second - whole) > EXACT * most * abs(end - begin)
        if off and abs(h) > SHORTEST * abs(end - begin) and t + 0.5 * h != t:
            h *= 0.5
            continue
        total += first + second
        t = end if last else t + h
        h *= 2.0
    return total


@compiled
def over(m, n, t, h):
    """The rule over h [s] from t on, and the largest speed that it has seen [rad/s or m/s]."""
    total, fastest = 0.0, 0.0
    for i in range(POINTS.shape[0]):
        speed = speed_at(m, n, t + 0.5 * h * (1.0 + POINTS[i]))
        total += WEIGHTS[i] * speed
        fastest = max(fastest, abs(speed))
    return 0.5 * h * total, fastest


@compiled
def speed_at(m, n, t):
    """Speed [rad/s or m/s] of driver n of `jet` at t [s]."""
    jet_signal, jet, out, jets = m.jet_signal, m.jet, m.jet_out, m.jets
    for k in range(jet_signal.shape[0]):
        first, last = jet_signal[k, at.FIRST_CODE], jet_signal[k, at.END_CODE]
        evaluate_jet(m.code, m.const, first, last, t, jets, m.jet_stack, out)
        place = jet_signal[k, at.TARGET]
        jets[place, 0], jets[place, 1], jets[place, 2] = out[0], out[1], out[2]
    evaluate_jet(m.code, m.const, jet[n, at.FIRST_CODE], jet[n, at.END_CODE], t, jets, m.jet_stack, out)
    return float(out[0])
