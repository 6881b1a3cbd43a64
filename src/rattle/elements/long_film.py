"""The largest pressure of a long film: exact for wedge and squeeze together; see `film.pinkus_sternlicht`."""

from __future__ import annotations

import math

from rattle.jit.functions import compiled

PARTS = 1000  # places on the circle, among which the largest is looked for


@compiled
def long_peaks(e, alpha, peaks):
    """`long_peak` of every state: arrays (n,), the last one is filled."""
    for k in range(e.shape[0]):
        peaks[k] = long_peak(e[k], alpha[k])


@compiled
def long_peak(e, alpha):
    """The largest pressure over 12 mu R^2 |v|/c^3, by a parabola through the three largest of 1000 on the circle."""
    un, ut, largest, most = math.cos(alpha), math.sin(alpha), 0, -math.inf
    for k in range(PARTS):
        p = _long_pressure(e, un, ut, k)
        if p > most:
            largest, most = k, p
    before, after = _long_pressure(e, un, ut, largest - 1), _long_pressure(e, un, ut, largest + 1)
    bend = before - 2.0 * most + after
    return most - (after - before) ** 2 / (8.0 * bend) if bend < 0.0 else most


@compiled
def _long_pressure(e, un, ut, k):
    """The pressure in the same unit at the place k of the circle, of a motion un along the eccentricity, ut across."""
    phi = 2.0 * math.pi * k / PARTS
    wide = 1.0 - e * math.cos(phi)
    wedge = ut * math.sin(phi) * (1.0 + wide) / (2.0 + e * e)
    squeeze = un * (1.0 + math.cos(phi)) * (1.0 + e + wide) / (2.0 * (1.0 + e) * (1.0 + e))
    return (wedge + squeeze) / (wide * wide)
