"""Peaks and sums of a step of event mode from its stages, where these tell all forces: up to an event, or entire.

Where forces depend on the state alone and contacts keep their modes, the stages of a step lie on the forces that its
dense output gives, also beyond an event that cuts it.  A polynomial through six of them that lie apart gives the
integral of f^2 up to the event, and says where f may exceed its largest value so far: there f itself is measured.
"""

from __future__ import annotations

import numpy as np

from rattle.equations.schur import WEAK
from rattle.jit.functions import compiled, native
from rattle.solvers.peaks.samples import (
    BEST,
    COUNT,
    DOP853,
    END,
    LAST_STAGE,
    LOOK,
    LOOKS,
    NOTHING,
    PROBE,
    SAME,
    SAMPLE,
    SHARES,
    SQUARES,
    add,
    climb,
    crest_all,
    end_step,
    pass_end_on,
    probe,
    summit,
    unresolved,
)
from rattle.solvers.peaks.stage_polynomial import FORMS, NODES, PLACES, through_stages

BESIDE = 10.0  # times what the last stage is beside the end of the step: by how much a crest may be higher
LEFT_OUT = np.array([2, 4])  # stages that show by how much the polynomial is beside them
PRODUCT = np.array([abs(np.prod(x - PLACES)) for x in SHARES[DOP853, LEFT_OUT]])
UNSURE = 3.0  # times what follows from them, by which a crest may be higher, too
MANY = 3  # new peaks in a step beyond which each is not measured on its own
FINE = 1e-9  # share of a peak that it may lack where it was measured once
NEXT_TO = 1e-3  # share of a stretch next to its end where no peak is looked for: the end is known


@compiled
def doubt_at(samples, x):
    """By how much that polynomial of a quantity may be wrong at the share x, as the stages that it leaves out say."""
    most, product = 0.0, 1.0
    for k in range(LEFT_OUT.shape[0]):
        i = LEFT_OUT[k]
        beside = abs(samples[SAMPLE + i] - through_stages(samples, SAMPLE, SHARES[DOP853, i]))
        most = max(most, beside / PRODUCT[k])
    for k in range(PLACES.shape[0]):
        product *= abs(x - PLACES[k])
    return most * product


@compiled
def crest(samples, low, top, high):
    """Place and height of the maximum of that polynomial between low and high, by parabolas over shorter stretches."""
    wide, best = 0.25 * (high - low), through_stages(samples, SAMPLE, top)
    for _ in range(10):
        left = through_stages(samples, SAMPLE, max(top - wide, low))
        right = through_stages(samples, SAMPLE, min(top + wide, high))
        bend = left - 2.0 * best + right
        shift = 0.5 * (left - right) / bend if bend < 0.0 else (1.0 if right > left else -1.0)
        there = min(max(top + wide * min(max(shift, -1.0), 1.0), low), high)
        value = through_stages(samples, SAMPLE, there)
        if value > best:
            top, best = there, value
        wide *= 0.5
    return top, best


@compiled
def higher(samples, i, until):
    """Place next to stage i where a quantity may have a new peak before the share `until`, -1 if none; and how high.

    Returns the place, the height of the polynomial there, and by how much that may be too low.
    """
    value, known = samples[SAMPLE + i], samples[BEST]
    low, high = SHARES[DOP853, max(i - 1, 0)], min(SHARES[DOP853, min(i + 1, COUNT[DOP853] - 1)], until)
    height, least = summit(samples, DOP853, i)[1], known + SAME * abs(known) + samples[NOTHING]
    if not low < until or not (height > 0.0 and value + 3.0 * height > least):
        return -1.0, 0.0, 0.0
    top, best = crest(samples, low, min(SHARES[DOP853, i], high), high)
    unsure = BESIDE * abs(samples[SAMPLE + LAST_STAGE] - samples[SAMPLE + END]) + UNSURE * doubt_at(samples, top)
    if not best + unsure > least or top > (1.0 - NEXT_TO) * until:
        return -1.0, 0.0, 0.0
    return top, best, unsure


@compiled
def measure_crests(m, t, h, until):
    """Measure the few new peaks of a step where its stages show them; returns the states solved for."""
    peaks, solved = m.peaks, 0
    for n in range(peaks.shape[0]):
        for i in range(COUNT[DOP853]):
            top, best, unsure = higher(peaks[n], i, until)
            if top < 0.0:
                continue
            value, height = probe(m, t, h, top, n), summit(peaks[n], DOP853, i)[1]
            solved += 1
            # a place beside by as much as values are beside each other lowers what is measured there by its square
            if (value - best) ** 2 > FINE * abs(value) * height:
                low, high = SHARES[DOP853, max(i - 1, 0)], SHARES[DOP853, min(i + 1, COUNT[DOP853] - 1)]
                solved += climb(m, t, h, n, low, top, min(high, until), unsure)
    return solved


@compiled
def measure_evenly(m, t, h, until):
    """Measure at eight even places up to the share `until`; new peaks are those of the polynomials through them."""
    peaks = m.peaks
    for k in range(1, COUNT[LOOKS]):
        probe(m, t, h, until * SHARES[LOOKS, k], 0)
        for n in range(peaks.shape[0]):
            peaks[n, SAMPLE + LOOK[k]] = peaks[n, SAMPLE + PROBE]
    crest_all(m, t, until * h)
    return COUNT[LOOKS] - 1


@compiled
def new_peaks(m, until):
    """Number of places where quantities may have new peaks, as far as it is not above MANY."""
    peaks, found = m.peaks, 0
    for n in range(peaks.shape[0]):
        for i in range(COUNT[DOP853]):
            if higher(peaks[n], i, until)[0] > 0.0:
                found += 1
                if found > MANY:
                    return found
    return found


@native("i", "h", "f", "f", "f")
def end_by_stages(m, t, h, until):
    """Peaks and sums of the step from t of length h up to the share `until`, where an event cuts it if that is < 1.

    As `samples.end_step` where stages tell all forces; the dense output is there.  Returns the states solved for.
    """
    peaks, solved = m.peaks, 0
    if peaks.shape[0] == 0:
        return 0
    if not m.power[3] > WEAK or unresolved(m, h, DOP853):
        return end_step(m, t, h, until, DOP853, 1)
    if until < 1.0:
        for k in range(NODES.shape[0]):
            weight, power = 0.0, until
            for j in range(NODES.shape[0]):
                weight += FORMS[k, j] * power / (j + 1.0)
                power *= until
            for n in range(peaks.shape[0]):
                peaks[n, SQUARES] += h * weight * peaks[n, SAMPLE + NODES[k]] ** 2
        probe(m, t, h, until, 0)
        solved += 1
    else:
        add(m, t + h, h, DOP853, 1)
    solved += measure_evenly(m, t, h, until) if new_peaks(m, until) > MANY else measure_crests(m, t, h, until)
    if until == 1.0:
        pass_end_on(m)
    return solved
