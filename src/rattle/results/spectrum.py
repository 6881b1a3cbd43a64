"""Amplitude spectrum of a curve, from its output instants."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rattle.errors import InputError

Array = NDArray[np.float64]
FEWEST = 8  # instants
EVEN = 1e-6  # allowed difference of the intervals, as a share of an interval
STEADY = 0.01  # allowed difference of a turning speed from its mean, as a share of it


def amplitude_spectrum(t: Array, values: Array) -> tuple[Array, Array]:
    """Frequencies [Hz] and amplitudes [unit of the values] of a curve at evenly spaced instants t (n,) [s].

    With the window of Hann, w_k = 1 - cos(2 pi k / n), and the mean m that it weighs taken out,

        a(f) = 2 |sum_k w_k (y_k - m) exp(-2 pi i f t_k)| / sum_k w_k,      f = 1/T, 2/T, ... up to 1/(2 h),  T = n h

    so that a sine of amplitude A whose frequency is a multiple of 1/T has a = A there, A/2 at the two frequencies
    beside it and 0 elsewhere; between two multiples its largest value is 0.85 A at least.  A last interval that is
    shorter than the others is left out.

    Raises InputError for fewer than eight instants, uneven ones, or values that are not finite.
    Source: Harris, Proc. IEEE 66 (1978) 51-83, Table 1.
    """
    if len(t) > 2 and t[-1] - t[-2] < (1.0 - EVEN) * (t[1] - t[0]):
        t, values = t[:-1], values[:-1]
    n = len(t)
    if n < FEWEST:
        raise InputError(f"a spectrum needs at least {FEWEST} output instants, there are {n}")
    step = float(t[-1] - t[0]) / (n - 1)
    if not np.abs(np.diff(t) - step).max() <= EVEN * step:
        raise InputError("a spectrum needs evenly spaced output instants: simulate with an output interval, not t_eval")
    if not np.isfinite(values).all():
        raise InputError(
            "a spectrum needs values that are all finite; forces next to a singular position are left out (nan): take"
            " outputs on one side of it"
        )
    window = 1.0 - np.cos(2.0 * np.pi * np.arange(n) / n)
    total = float(window.sum())
    mean = float(window @ values) / total
    amplitude = 2.0 * np.abs(np.fft.rfft(window * (values - mean))) / total
    if n % 2 == 0:
        amplitude[-1] /= 2.0  # the highest frequency has no mirror image
    return np.asarray(np.fft.rfftfreq(n, step)[1:]), np.asarray(amplitude[1:])


def steady_turns(t: Array, speed: Array) -> float:
    """Turns per second of what turns at a speed (n,) [rad/s] at instants t [s]; 0 if it is not steady, or < 1 turn."""
    mean = float(speed.mean()) if len(speed) else 0.0
    if not np.isfinite(speed).all() or not np.abs(speed - mean).max(initial=0.0) <= STEADY * abs(mean):
        return 0.0
    turns = abs(mean) / (2.0 * np.pi)
    return turns if turns * float(t[-1] - t[0]) >= 1.0 else 0.0
