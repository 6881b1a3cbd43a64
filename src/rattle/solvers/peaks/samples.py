"""Samples of forces at the stages of a step: their sums, and whether there may be a peak between them.

At the stages and the end of a step all forces are computed anyway.  As the error of a Runge-Kutta step is below
the tolerance for any integral along the motion, the weights of its stages give the integral of f^2 to the same
order.  The stages also show where f may exceed its largest value so far: a parabola through the highest sample and its
neighbours, with three times its height above that sample.  Next to a singular position, where stages are inaccurate,
only the ends of steps count.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.equations.schur import WEAK
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.dop853_tableau import B, C
from rattle.solvers.output_row import write_joints
from rattle.solvers.peaks.glances import write_look

# columns of `peaks`: largest value so far, its time, integral of the square; size up to which the quantity is rounding
# or drift, and an arm that says so for moments [m]; then the samples of the present step
BEST, WHEN, SQUARES, NOTHING, ARM, SAMPLE = range(6)
START, END, LAST_STAGE, PROBE = 0, 7, 8, 9  # samples; 1 to 6 lie between the ends
WIDTH = SAMPLE + 10
DOP853, RK4, CUT, LOOKS = range(4)  # where the samples lie
LOOK = np.array([0, 1, 2, 3, 4, 5, 6, 8, 7])  # samples of LOOKS in order of time: the search for events solves there
NODE_OF_STAGE = np.array([0, -1, -1, -1, -1, 3, 1, 2, 5, 4, 6, 8])  # of dop853; -1: no weight
GAUSS = math.sqrt(0.15)
COUNT = np.array([8, 3, 5, 9])
ORDER = np.array([  # in order of time
    [0, 1, 2, 3, 4, 5, 6, 7, 0], [0, 4, 7, 0, 0, 0, 0, 0, 0], [0, 1, 2, 3, 7, 0, 0, 0, 0], LOOK,
])  # fmt: skip
SHARES = np.array([
    [0.0, C[6], C[7], C[5], C[9], C[8], C[10], 1.0, 0.0],
    [0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.0, 0.5 - GAUSS, 0.5, 0.5 + GAUSS, 1.0, 0.0, 0.0, 0.0, 0.0],
    np.arange(9) / 8.0,
])  # fmt: skip
WEIGHTS = np.array([
    [B[0], B[6], B[7], B[5], B[9], B[8], B[10], 0.0, B[11]],
    [1.0 / 6.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0, 0.0, 0.0, 0.0, 1.0 / 6.0],
    [0.0, 5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    np.array([1.0, 4.0, 2.0, 4.0, 2.0, 4.0, 2.0, 1.0, 4.0]) / 24.0,
])  # fmt: skip
FEW = np.array([0, 1, 4, 6, 7])  # samples of dop853 for a second rule, of order 5; Simpson's for pieces of a step
COARSE = np.zeros((4, 9))
COARSE[DOP853, FEW] = np.linalg.solve(np.vander(SHARES[DOP853, FEW], increasing=True).T, 1.0 / np.arange(1.0, 6.0))
COARSE[CUT, [0, 2, 7]] = 1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0
APART = 1e-2  # share of the mean of f^2 by which two rules may differ
MATTERS = 1e-4  # share of the integral so far below which they may differ more
ROUNDING = 1e-9  # share of the largest force below which a force is rounding
CANCELLED = 1e-13  # share of the largest force times an arm below which a moment is rounding
SAME = 1e-9  # share within which two peaks are equal: the first one is kept


@compiled
def value_of(row, kind, c):
    """One quantity from an output row, in its SI unit."""
    if kind == at.OF_VECTOR:
        return math.sqrt(row[c] * row[c] + row[c + 1] * row[c + 1])
    if kind == at.OF_SIZE:
        return abs(row[c])
    if kind == at.OF_LARGER:
        return max(row[c], row[c + 1])
    return row[c] if kind == at.OF_VALUE else -row[c]


@compiled
def higher(value, best):
    """True if a value is above the largest so far by more than SAME (`best` starts from minus infinity)."""
    return value - best > SAME * abs(value)


@native("void", "h", "i", "f")
def gauge(m, sample, t):
    """Write all quantities of the workspace at t [s] into a sample; START and PROBE may be peaks."""
    quantity, peaks, row = m.quantity, m.peaks, m.peak_row
    if sample < m.glances.shape[0]:
        write_look(m, m.glances[sample])
    if quantity.shape[0] == 0:
        return
    write_joints(m, row, 0)
    for n in range(quantity.shape[0]):
        value = value_of(row, quantity[n, at.FORM], quantity[n, at.FIRST_COLUMN])
        peaks[n, SAMPLE + sample] = value
        if higher(value, peaks[n, BEST]) and sample in (START, PROBE):
            peaks[n, BEST], peaks[n, WHEN] = value, t


@compiled
def add_step(m, h):
    """Count the sample START for a time h [s], for methods with one force per step."""
    peaks = m.peaks
    for n in range(peaks.shape[0]):
        peaks[n, SQUARES] += h * peaks[n, SAMPLE + START] ** 2


@compiled
def summit(samples, layout, i):
    """Place of the maximum near sample i and its height above it, by a parabola; height 0 if it is no maximum."""
    last = COUNT[layout] - 1
    x, f = SHARES[layout, i], samples[SAMPLE + ORDER[layout, i]]
    before, after = i - 1, i + 1
    if before >= 0 and samples[SAMPLE + ORDER[layout, before]] > f:
        return x, 0.0
    if after <= last and samples[SAMPLE + ORDER[layout, after]] > f:
        return x, 0.0
    before = before if before >= 0 else 2
    after = after if after <= last else last - 2
    left, right = SHARES[layout, before] - x, SHARES[layout, after] - x
    down_left = (samples[SAMPLE + ORDER[layout, before]] - f) / left
    down_right = (samples[SAMPLE + ORDER[layout, after]] - f) / right
    bend = (down_left - down_right) / (left - right)
    if not bend < 0.0:
        return x, 0.0
    slope = down_left - bend * left
    top = x - 0.5 * slope / bend
    if not 0.0 < top < 1.0:
        return x, 0.0
    return top, -0.25 * slope * slope / bend


@compiled
def rises(samples, layout, i):
    """True if the maximum near sample i may exceed the largest value so far."""
    known = max(samples[BEST], samples[SAMPLE + END])
    height = summit(samples, layout, i)[1]
    least = known + SAME * abs(known) + samples[NOTHING]
    return height > 0.0 and samples[SAMPLE + ORDER[layout, i]] + 3.0 * height > least


@compiled
def near_peak(peaks):
    """True if a quantity could reach its largest value by continuing to change as over the step."""
    for n in range(peaks.shape[0]):
        one, two, known = peaks[n, SAMPLE + START], peaks[n, SAMPLE + END], peaks[n, BEST]
        if max(one, two) + abs(one - two) > known + SAME * abs(known):
            return True
    return False


@compiled
def may_rise(m, h, layout):
    """True if the dense output of the step must be searched; the stages of rk4 are too coarse to decide."""
    peaks = m.peaks
    if layout == CUT:
        return peaks.shape[0] > 0
    if layout == RK4:
        return near_peak(peaks)
    if not m.power[at.PIVOT_SHARE] > WEAK or unresolved(m, h, DOP853):
        return True
    for n in range(peaks.shape[0]):
        for i in range(COUNT[layout]):
            if rises(peaks[n], layout, i):
                return True
    return False


@compiled
def largest_force(m):
    """Largest force so far [N]; the rounding of each moment follows from it."""
    peaks, quantity, largest = m.peaks, m.quantity, 0.0
    for n in range(peaks.shape[0]):
        if quantity[n, at.FORM] == at.OF_VECTOR:
            largest = max(largest, peaks[n, BEST])
    for n in range(peaks.shape[0]):
        if peaks[n, ARM] > 0.0:
            peaks[n, NOTHING] = CANCELLED * peaks[n, ARM] * largest
    return largest


@native("i", "h", "f", "i")
def unresolved(m, h, layout):
    """True if two quadrature rules for the mean of f^2 differ: a force changes faster than the motion."""
    peaks, quantity, largest = m.peaks, m.quantity, largest_force(m)
    for n in range(peaks.shape[0]):
        if quantity[n, at.FORM] != at.OF_VECTOR or peaks[n, BEST] < ROUNDING * largest:
            continue
        mean, apart = 0.0, 0.0
        for k in range(9):
            square = peaks[n, SAMPLE + k] ** 2
            mean += WEIGHTS[layout, k] * square
            apart += (WEIGHTS[layout, k] - COARSE[layout, k]) * square
        if abs(apart) > APART * abs(mean) and h * abs(apart) > MATTERS * peaks[n, SQUARES]:
            return True
    return False


@compiled
def add(m, t, h, layout, sound):
    """Count the samples of an interval of length h [s] and its end, which is at t [s]."""
    peaks = m.peaks
    for n in range(peaks.shape[0]):
        mean = 0.5 * (peaks[n, SAMPLE + START] ** 2 + peaks[n, SAMPLE + END] ** 2)
        if sound:
            mean = 0.0
            for k in range(9):
                mean += WEIGHTS[layout, k] * peaks[n, SAMPLE + k] ** 2
        peaks[n, SQUARES] += h * mean
        if higher(peaks[n, SAMPLE + END], peaks[n, BEST]):
            peaks[n, BEST], peaks[n, WHEN] = peaks[n, SAMPLE + END], t


@compiled
def pass_end_on(m):
    """Make the sample at the end of an interval that at the start of the next."""
    peaks = m.peaks
    for n in range(peaks.shape[0]):
        peaks[n, SAMPLE + START] = peaks[n, SAMPLE + END]
