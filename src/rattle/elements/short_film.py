"""The film of a short journal bearing under positive pressure, as integrals in closed form.

Reynolds' equation without flow around the pin, `d/dz(h^3/(12 mu) dp/dz) = -v.u(phi)`, has the pressure

    p = (6 mu (v.u)/h^3) (L^2/4 - z^2)      h = c (1 - E.u)      E = e/c

which is positive on the half circle around m = v/|v|, the direction of the velocity.  With a = E.m, b = E.k, k = z x m,
s^2 = 1 - a^2 - b^2 and Q = atan2(s, -a) the force on the pin is F = -(mu R L^3/c^3) |v| (I1 m + I2 k),

    I1 = int cos^2/(1 - a cos - b sin)^3    = [3 a s + Q (s^2 + 3 a^2)]/s^5
    I2 = int cos sin/(1 - a cos - b sin)^3  = b [3 s - s^3/(s^2 + a^2) + 3 Q a]/s^5        over (-pi/2, pi/2)

Both are second derivatives of G = int 1/(1 - a cos - b sin) = 2 Q/s.  For a separation near the bush (a < 0, u = -s/a
small) the brackets cancel as u^5; there they are replaced by their series in u^2.  Checked against quadrature.

The full film, with pressure of either sign, is linear: F = -(mu R L^3/c^3) pi [(1 + 2 e^2)/s^5 v_n n + 1/s^3 v_t t].
"""

from __future__ import annotations

import math

from rattle.jit.functions import compiled

SWITCH = 0.3  # u from which the closed forms lose less than the series
TERMS = 16
NORMAL_SERIES = tuple((-1.0) ** j * (4 * j + 4) / ((2 * j + 5) * (2 * j + 3)) for j in reversed(range(TERMS)))
CROSS_SERIES = tuple((-1.0) ** j * (2 * j + 2) / (2 * j + 5) for j in reversed(range(TERMS)))


@compiled
def short_integrals(a, b, s):
    """Q [rad], I1, I2 [-]: extent of the film over sqrt(1 - e^2), force against the velocity and across it."""
    q = math.atan2(s, -a)
    if a < 0.0 and s < -SWITCH * a:
        x = s * s / (a * a)
        first, second = 0.0, 0.0
        for term in NORMAL_SERIES:
            first = first * x + term
        for term in CROSS_SERIES:
            second = second * x + term
        return q, -first / (a * a * a), b * second / (a * a * a * a)
    s2 = s * s
    over = 1.0 / (s2 * s2 * s)
    first = over * (3.0 * a * s + q * (s2 + 3.0 * a * a))
    second = over * b * (3.0 * s - s2 * s / (s2 + a * a) + 3.0 * q * a)
    return q, first, second


@compiled
def short_peak(e, alpha):
    """Largest pressure over mu L^2 |v|/c^3 at the eccentricity e [of the clearance], v at the angle alpha [rad].

    It is 1.5 cos(phi - alpha)/(1 - e cos phi)^3 at its maximum within the half circle, where the slope
    -sin(phi - alpha) (1 - e cos phi) - 3 e cos(phi - alpha) sin phi falls through zero; found by halving.
    """
    best = 0.0
    parts = 32
    for k in range(parts):  # the slope may vanish three times
        low = alpha - 0.5 * math.pi + math.pi * k / parts
        high = low + math.pi / parts
        if _rise(e, alpha, low) < 0.0 or _rise(e, alpha, high) > 0.0:
            continue
        for _ in range(60):
            middle = 0.5 * (low + high)
            if _rise(e, alpha, middle) > 0.0:
                low = middle
            else:
                high = middle
        best = max(best, 1.5 * math.cos(low - alpha) / (1.0 - e * math.cos(low)) ** 3)
    return best


@compiled
def short_peaks(e, alpha, peaks):
    """`short_peak` of every state: arrays (n,), the last one is filled."""
    for k in range(e.shape[0]):
        peaks[k] = short_peak(e[k], alpha[k])


@compiled
def _rise(e, alpha, phi):
    """Slope of the pressure along the circumference, times a positive number."""
    turn = phi - alpha
    return -math.sin(turn) * (1.0 - e * math.cos(phi)) - 3.0 * e * math.cos(turn) * math.sin(phi)
