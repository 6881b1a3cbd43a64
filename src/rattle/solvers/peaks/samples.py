"""Samples of forces at the stages of a step: their sums, and whether there may be a peak between them.

At the stages and the end of a step all forces are computed anyway.  As the error of a Runge-Kutta step is below
the tolerance for any integral along the motion, the weights of its stages give the integral of f^2 to the same
order.  The stages also show where f may exceed its largest value so far: a parabola through the highest sample and its
neighbours, with three times its height above that sample.  Next to a singular position, where stages are inaccurate,
only the ends of steps count.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from rattle.equations.schur import WEAK
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.output_row import write_joints
from rattle.solvers.peaks.contact_samples import write_look
from rattle.solvers.peaks.stage_polynomial import best_nodes, shape_arrays
from rattle.solvers.tableau import Tableau

# columns of `peaks`: largest value so far, its time, integral of the square; size up to which the quantity is rounding
# or drift, and an arm that says so for moments [m]; then the samples of the present step
BEST, WHEN, SQUARES, NOTHING, ARM, SAMPLE = range(6)
START = 0  # first sample; those within the step follow, then `end_of`, a last stage that is there too, and `probe_of`
LEAST_WITHIN = 6  # places for samples within a step, at least
# where the samples of a step lie: at the stages of the stepper, at Gauss points of the dense output, or evenly spaced
STAGES, CUT, LOOKS = range(3)
BLANK, COARSE, FINE = range(3)  # what stages show of forces: nothing, their mean, and where they may have peaks
TOLD_BY = 6  # separate stages within a step from which on they show that
GAUSS = math.sqrt(0.15)
APART = 1e-2  # share of the mean of f^2 by which two rules may differ
MATTERS = 1e-4  # share of the integral so far below which they may differ more
ROUNDING = 1e-9  # share of the largest force below which a force is rounding
CANCELLED = 1e-13  # share of the largest force times an arm below which a moment is rounding
SAME = 1e-9  # share within which two peaks are equal: the first one is kept


def within(tableau: Tableau | None) -> list[int]:
    """Stages inside a step whose forces count, in order of time; none if stages do not give the mean of a force."""
    if tableau is None:
        return []
    c, weights = tableau.c, tableau.weights
    counted = [s for s in range(tableau.stages) if weights[s] != 0.0]
    if any(not (0.0 < c[s] <= 1.0 or s == 0) for s in counted) or sum(c[s] == 1.0 for s in counted) > 1:
        return []
    return sorted((s for s in counted if 0.0 < c[s] < 1.0), key=lambda s: (c[s], s))


def room_within(tableau: Tableau | None) -> int:
    """Number of places for samples within a step; the one for its end follows."""
    return max(LEAST_WITHIN, len(within(tableau)))


def width(tableau: Tableau | None) -> int:
    """Columns of `peaks`: with START, the end, the last stage and one sample for any other instant."""
    return SAMPLE + room_within(tableau) + 4


def stage_shares(tableau: Tableau | None) -> np.ndarray:
    """(n,) shares of a step at the samples that its stages leave, if they are so many that they decide (FINE)."""
    inner, room = within(tableau), room_within(tableau)
    shares = np.ones(room + 3)
    shares[0] = 0.0
    if tableau is not None:
        shares[1 : 1 + len(inner)] = tableau.c[inner]
    return shares


@cache
def sample_arrays(tableau: Tableau | None) -> dict[str, np.ndarray]:
    """Where the samples of a step lie, by layout, and two rules for the mean of what is sampled.

    tableau: None for a method whose stages show nothing, as an implicit one.
    """
    inner, last = within(tableau), room_within(tableau) + 2
    places = last + 1
    order, shares = np.zeros((3, places), np.int64), np.zeros((3, places))
    fine, coarse = np.zeros((3, places)), np.zeros((3, places))
    even = [*[k for k in range(places) if k != last - 1][:8], last - 1]
    count = np.array([0, 5, 9])
    order[CUT, :5] = [0, 1, 2, 3, last - 1]
    order[LOOKS, :9] = even
    shares[CUT, :5] = [0.0, 0.5 - GAUSS, 0.5, 0.5 + GAUSS, 1.0]
    shares[LOOKS, :9] = np.arange(9) / 8.0
    fine[CUT, 1:4] = 5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0
    coarse[CUT, [0, 2, last - 1]] = 1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0  # Simpson's rule
    fine[LOOKS, even] = np.array([1.0, 4.0, 2.0, 4.0, 2.0, 4.0, 2.0, 4.0, 1.0]) / 24.0
    sample_of = np.full(tableau.stages if tableau else 0, -1, np.int64)
    shows = BLANK
    if tableau is not None and inner:
        c, weights = tableau.c, tableau.weights
        sample_of[inner] = 1 + np.arange(len(inner))
        sample_of[[s for s in range(tableau.stages) if weights[s] != 0.0 and c[s] == 1.0]] = last
        separate = [s for n, s in enumerate(inner) if n + 1 == len(inner) or c[inner[n + 1]] != c[s]]
        shows = FINE if len(separate) >= TOLD_BY else COARSE
        count[STAGES] = len(separate) + 2
        order[STAGES, 1 : count[STAGES]] = [*sample_of[separate], last - 1]
        shares[STAGES, 1 : count[STAGES]] = [*c[separate], 1.0]
        fine[STAGES, 0] = weights[0]
        used = sample_of >= 0
        fine[STAGES, sample_of[used]] = np.array(weights)[used]
        few = best_nodes(shares[STAGES, : count[STAGES]], min(5, count[STAGES]))
        powers = np.vander(shares[STAGES, few], increasing=True).T
        coarse[STAGES, order[STAGES, few]] = np.linalg.solve(powers, 1.0 / np.arange(1.0, len(few) + 1.0))
    return {
        "sample_of_stage": sample_of, "sample_order": order, "sample_shares": shares, "sample_count": count,
        "sample_weights": fine, "sample_coarse": coarse, "sampling": np.array([shows]),
    } | (shape_arrays(order[STAGES], shares[STAGES, : count[STAGES]]) if shows == FINE else {})  # fmt: skip


@compiled
def end_of(m):
    """Number of the sample at the end of the step."""
    return m.peaks.shape[1] - SAMPLE - 3


@compiled
def probe_of(m):
    """Number of the sample at any other instant."""
    return m.peaks.shape[1] - SAMPLE - 1


@compiled
def at_end(samples):
    """Sample at the end of the step."""
    return samples[samples.shape[0] - 3]


@compiled
def beside_end(samples):
    """How much the last stage, which is at the end of the step too, differs from it."""
    return abs(samples[samples.shape[0] - 2] - at_end(samples))


@compiled
def stage_layout(m):
    """Layout of the samples that a step leaves: STAGES, or CUT if it leaves none."""
    return CUT if m.sampling[0] == BLANK else STAGES


@compiled
def stages_tell(m):
    """True if the stages of a step show where forces may have peaks, or change their sign."""
    return m.sampling[0] == FINE


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
    """Write all quantities of the workspace at t [s] into a sample; that at START and of `probe_of` may be peaks."""
    quantity, peaks, row = m.quantity, m.peaks, m.peak_row
    if sample < m.glances.shape[0]:
        write_look(m, m.glances[sample])
    if quantity.shape[0] == 0:
        return
    write_joints(m, row, 0)
    for n in range(quantity.shape[0]):
        value = value_of(row, quantity[n, at.FORM], quantity[n, at.FIRST_COLUMN])
        peaks[n, SAMPLE + sample] = value
        if higher(value, peaks[n, BEST]) and sample in (START, probe_of(m)):
            peaks[n, BEST], peaks[n, WHEN] = value, t


@compiled
def add_step(m, h):
    """Count the sample START for a time h [s], for methods with one force per step."""
    peaks = m.peaks
    for n in range(peaks.shape[0]):
        peaks[n, SQUARES] += h * peaks[n, SAMPLE + START] ** 2


@compiled
def summit(m, samples, layout, i):
    """Place of the maximum near sample i and its height above it, by a parabola; height 0 if it is no maximum."""
    shares, order, last = m.sample_shares, m.sample_order, m.sample_count[layout] - 1
    x, f = shares[layout, i], samples[SAMPLE + order[layout, i]]
    before, after = i - 1, i + 1
    if before >= 0 and samples[SAMPLE + order[layout, before]] > f:
        return x, 0.0
    if after <= last and samples[SAMPLE + order[layout, after]] > f:
        return x, 0.0
    before = before if before >= 0 else 2
    after = after if after <= last else last - 2
    left, right = shares[layout, before] - x, shares[layout, after] - x
    down_left = (samples[SAMPLE + order[layout, before]] - f) / left
    down_right = (samples[SAMPLE + order[layout, after]] - f) / right
    bend = (down_left - down_right) / (left - right)
    if not bend < 0.0:
        return x, 0.0
    slope = down_left - bend * left
    top = x - 0.5 * slope / bend
    if not 0.0 < top < 1.0:
        return x, 0.0
    return top, -0.25 * slope * slope / bend


@compiled
def rises(m, samples, layout, i):
    """True if the maximum near sample i may exceed the largest value so far."""
    highest = max(samples[BEST], at_end(samples))
    height = summit(m, samples, layout, i)[1]
    least = highest + SAME * abs(highest) + samples[NOTHING]
    return height > 0.0 and samples[SAMPLE + m.sample_order[layout, i]] + 3.0 * height > least


@compiled
def near_peak(peaks):
    """True if a quantity could reach its largest value by continuing to change as over the step."""
    for n in range(peaks.shape[0]):
        begin, finish, highest = peaks[n, SAMPLE + START], at_end(peaks[n]), peaks[n, BEST]
        if max(begin, finish) + abs(begin - finish) > highest + SAME * abs(highest):
            return True
    return False


@compiled
def may_rise(m, h, layout):
    """True if the dense output of the step must be searched; few stages do not decide where it is."""
    peaks = m.peaks
    if layout == CUT:
        return peaks.shape[0] > 0
    if not stages_tell(m):
        return near_peak(peaks)
    if not m.power[at.PIVOT_SHARE] > WEAK or unresolved(m, h, STAGES):
        return True
    for n in range(peaks.shape[0]):
        for i in range(m.sample_count[layout]):
            if rises(m, peaks[n], layout, i):
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
    fine, coarse = m.sample_weights, m.sample_coarse
    for n in range(peaks.shape[0]):
        if quantity[n, at.FORM] != at.OF_VECTOR or peaks[n, BEST] < ROUNDING * largest:
            continue
        mean, apart = 0.0, 0.0
        for k in range(fine.shape[1]):
            square = peaks[n, SAMPLE + k] ** 2
            mean += fine[layout, k] * square
            apart += (fine[layout, k] - coarse[layout, k]) * square
        if abs(apart) > APART * abs(mean) and h * abs(apart) > MATTERS * peaks[n, SQUARES]:
            return True
    return False


@compiled
def add(m, t, h, layout, sound):
    """Count the samples of an interval of length h [s] and its end, which is at t [s]."""
    peaks, weights = m.peaks, m.sample_weights
    for n in range(peaks.shape[0]):
        mean = 0.5 * (peaks[n, SAMPLE + START] ** 2 + at_end(peaks[n]) ** 2)
        if sound:
            mean = 0.0
            for k in range(weights.shape[1]):
                mean += weights[layout, k] * peaks[n, SAMPLE + k] ** 2
        peaks[n, SQUARES] += h * mean
        if higher(at_end(peaks[n]), peaks[n, BEST]):
            peaks[n, BEST], peaks[n, WHEN] = at_end(peaks[n]), t


@compiled
def pass_end_on(m):
    """Make the sample at the end of an interval that at the start of the next."""
    peaks = m.peaks
    for n in range(peaks.shape[0]):
        peaks[n, SAMPLE + START] = at_end(peaks[n])
