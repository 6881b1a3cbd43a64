"""Peaks and sums of an event-driven step from its stages, if these show all forces: up to an event, or to its end.

If forces depend only on the state and contacts keep their modes, the stages of a step lie on the forces of its
dense output, also beyond an event that ends it.  A polynomial through six separate stages gives the integral of
f^2 up to the event, and shows where f may exceed its largest value so far: there f itself is computed.
"""

from __future__ import annotations

from rattle.equations.schur import WEAK
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.peaks.peak_search import climb, crest_all, end_step, probe
from rattle.solvers.peaks.samples import (
    BEST,
    LOOKS,
    NOTHING,
    SAME,
    SAMPLE,
    SQUARES,
    STAGES,
    add,
    beside_end,
    pass_end_on,
    probe_of,
    summit,
    unresolved,
)
from rattle.solvers.peaks.stage_polynomial import through_stages

BESIDE = 10.0  # times the deviation of the last stage from the end of the step: how much higher a maximum may be
UNSURE = 3.0  # times that error: how much higher a maximum may be, too
MANY = 3  # number of new peaks in a step above which they are not computed one by one
FINE = 1e-9  # allowed error of a peak that was computed once, as a share of it
NEXT_TO = 1e-3  # share of an interval next to its end where no peak is searched: the end is known


@compiled
def doubt_at(m, samples, x):
    """Error bound of that polynomial of a quantity at the share x, from the stages that it leaves out."""
    nodes, places, others, products = m.beside_nodes, m.beside_places, m.shape_places, m.beside_products
    most, product = 0.0, 1.0
    for k in range(nodes.shape[0]):
        beside = abs(samples[SAMPLE + nodes[k]] - through_stages(m, samples, SAMPLE, places[k]))
        most = max(most, beside / products[k])
    for k in range(others.shape[0]):
        product *= abs(x - others[k])
    return most * product


@compiled
def crest(m, samples, low, top, high):
    """Place and height of the maximum of that polynomial between low and high, by successive parabolas."""
    wide, best = 0.25 * (high - low), through_stages(m, samples, SAMPLE, top)
    for _ in range(10):
        left = through_stages(m, samples, SAMPLE, max(top - wide, low))
        right = through_stages(m, samples, SAMPLE, min(top + wide, high))
        bend = left - 2.0 * best + right
        shift = 0.5 * (left - right) / bend if bend < 0.0 else (1.0 if right > left else -1.0)
        there = min(max(top + wide * min(max(shift, -1.0), 1.0), low), high)
        value = through_stages(m, samples, SAMPLE, there)
        if value > best:
            top, best = there, value
        wide *= 0.5
    return top, best


@compiled
def higher(m, samples, i, until):
    """Place next to stage i where a quantity may have a new peak before the share `until`, -1 if none; and its height.

    Returns the place, the height of the polynomial there, and a bound for how much that is too low.
    """
    value, highest = samples[SAMPLE + m.sample_order[STAGES, i]], samples[BEST]
    shares, last = m.sample_shares, m.sample_count[STAGES] - 1
    low, high = shares[STAGES, max(i - 1, 0)], min(shares[STAGES, min(i + 1, last)], until)
    height, least = summit(m, samples, STAGES, i)[1], highest + SAME * abs(highest) + samples[NOTHING]
    if not low < until or not (height > 0.0 and value + 3.0 * height > least):
        return -1.0, 0.0, 0.0
    top, best = crest(m, samples, low, min(shares[STAGES, i], high), high)
    unsure = BESIDE * beside_end(samples) + UNSURE * doubt_at(m, samples, top)
    if not best + unsure > least or top > (1.0 - NEXT_TO) * until:
        return -1.0, 0.0, 0.0
    return top, best, unsure


@compiled
def measure_crests(m, t, h, until):
    """Compute the few new peaks of a step where its stages show them; returns the number of states computed."""
    peaks, solved, shares, count = m.peaks, 0, m.sample_shares, m.sample_count[STAGES]
    for n in range(peaks.shape[0]):
        for i in range(count):
            top, best, unsure = higher(m, peaks[n], i, until)
            if top < 0.0:
                continue
            value, height = probe(m, t, h, top, n), summit(m, peaks[n], STAGES, i)[1]
            solved += 1
            # an error of the place lowers the value computed there only by its square
            if (value - best) ** 2 > FINE * abs(value) * height:
                low, high = shares[STAGES, max(i - 1, 0)], shares[STAGES, min(i + 1, count - 1)]
                solved += climb(m, t, h, n, low, top, min(high, until), unsure)
    return solved


@compiled
def measure_evenly(m, t, h, until):
    """Sample at eight evenly spaced points up to the share `until`; new peaks are those of the polynomials through
    them."""
    peaks, shares, order, count = m.peaks, m.sample_shares, m.sample_order, m.sample_count[LOOKS]
    for k in range(1, count):
        probe(m, t, h, until * shares[LOOKS, k], 0)
        for n in range(peaks.shape[0]):
            peaks[n, SAMPLE + order[LOOKS, k]] = peaks[n, SAMPLE + probe_of(m)]
    return count - 1 + crest_all(m, t, h, until)


@compiled
def new_peaks(m, until):
    """Number of places where quantities may have new peaks; counting stops above MANY."""
    peaks, count = m.peaks, 0
    for n in range(peaks.shape[0]):
        for i in range(m.sample_count[STAGES]):
            if higher(m, peaks[n], i, until)[0] > 0.0:
                count += 1
                if count > MANY:
                    return count
    return count


@native("i", "h", "f", "f", "f")
def end_by_stages(m, t, h, until):
    """Peaks and sums of the step from t [s] of length h [s] up to the share `until`, where an event ends it if < 1.

    As `peak_search.end_step`, if the stages show all forces; needs the dense output.  Returns the states computed.
    """
    peaks, solved = m.peaks, 0
    if peaks.shape[0] == 0:
        return 0
    if not m.power[at.PIVOT_SHARE] > WEAK or unresolved(m, h, STAGES):
        return end_step(m, t, h, until, STAGES, 1)
    if until < 1.0:
        nodes, forms = m.shape_nodes, m.shape_forms
        for k in range(nodes.shape[0]):
            weight, power = 0.0, until
            for j in range(nodes.shape[0]):
                weight += forms[k, j] * power / (j + 1.0)
                power *= until
            for n in range(peaks.shape[0]):
                peaks[n, SQUARES] += h * weight * peaks[n, SAMPLE + nodes[k]] ** 2
        probe(m, t, h, until, 0)
        solved += 1
    else:
        add(m, t + h, h, STAGES, 1)
    solved += measure_evenly(m, t, h, until) if new_peaks(m, until) > MANY else measure_crests(m, t, h, until)
    if until == 1.0:
        pass_end_on(m)
    return solved
