"""Largest values and mean squares of forces, from within the steps: independent of the outputs.

Where the stages show that a force may exceed its largest value so far the maximum is searched on the dense output, with
every state projected onto the joints like an output.  With closed set-valued contacts the search for events samples
each step at eight evenly spaced points: a peak is then that of the polynomial through them, unless that is in doubt, as
where a force jumps.  A step that an event ends is integrated at three Gauss points of its dense output, and one in
which f changes faster than the motion in pieces, halved until they resolve it.
"""

from __future__ import annotations

import numpy as np

from rattle.equations.motion import solve_motion
from rattle.equations.schur import WEAK
from rattle.equations.state import take_states
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.dense_output import interpolate
from rattle.solvers.peaks.samples import (
    BEST,
    CUT,
    LOOKS,
    SAMPLE,
    STAGES,
    WHEN,
    add,
    gauge,
    higher,
    may_rise,
    near_peak,
    pass_end_on,
    probe_of,
    rises,
    stages_tell,
    summit,
    unresolved,
)
from rattle.solvers.projection import project_on_constraints

FINE = 1e-8  # share of a peak by which the last iteration of a search may exceed the one before
TRIES = 8
BLIND = 1e-8  # pivot, as a share of its diagonal, below which states on the constraints have no forces to trust
UNSURE = 0.1  # share of the height of a crest above its sample by which a polynomial may be wrong
SHORTEST = 1.0 / 1024.0  # share of a step that is not halved again
BARYCENTRIC = np.array([1.0, -8.0, 28.0, -56.0, 70.0, -56.0, 28.0, -8.0, 1.0])  # of nine evenly spaced samples
AROUND = 0.3  # of the wider side of a crest: how far beside it its maximum is first enclosed
NEXT_TO = 1e-6  # share of an interval within which a place is no new one
REST = 1.001  # pieces: what is left of a step is not divided if it is hardly longer than one
FIRST_PIECE = 0.125  # share of a step of the first piece of its dense output
FACTORIAL = 40320.0  # 8!, of the remainder with nine samples


@compiled
def through(m, samples, x):
    """The polynomial through nine evenly spaced samples of a step at the share x."""
    above, below = 0.0, 0.0
    for k in range(BARYCENTRIC.shape[0]):
        value = samples[SAMPLE + m.sample_order[LOOKS, k]]
        if x == k / 8.0:
            return value
        weight = BARYCENTRIC[k] / (x - k / 8.0)
        above += weight * value
        below += weight
    return above / below


@compiled
def crest(m, samples, low, top, high):
    """Place and height of the maximum of that polynomial between low and high, by successive parabolas."""
    wide, best = 0.25 * (high - low), through(m, samples, top)
    for _ in range(12):
        left, right = through(m, samples, max(top - wide, low)), through(m, samples, min(top + wide, high))
        bend = left - 2.0 * best + right
        shift = 0.5 * (left - right) / bend if bend < 0.0 else (1.0 if right > left else -1.0)
        there = min(max(top + wide * min(max(shift, -1.0), 1.0), low), high)
        value = through(m, samples, there)
        if value > best:
            top, best = there, value
        wide *= 0.5
    return top, best


@compiled
def doubt_at(m, samples, x):
    """How much that polynomial differs at the share x from the one without the end of the step that is nearer to x."""
    difference, product = 0.0, 1.0 / FACTORIAL
    for k in range(BARYCENTRIC.shape[0]):
        difference += BARYCENTRIC[k] * samples[SAMPLE + m.sample_order[LOOKS, k]]
        product *= abs(8.0 * x - k)
    nearer = min(8.0 * x, 8.0 - 8.0 * x)
    return abs(difference) * product / nearer if nearer > 0.0 else 0.0


@compiled
def probe(m, t, h, theta, n):
    """Compute all quantities at the share theta of the step, on its dense output; returns quantity n."""
    stage, nq = m.stage, m.change.shape[0]
    interpolate(m, theta, stage)
    if len(m.closed_contacts_table) == 0:  # forces of closed contacts are those of the search for events
        project_on_constraints(m, t + theta * h, stage, stage)
    take_states(m, stage)
    solve_motion(m, t + theta * h, stage[:nq], stage[nq : 2 * nq])
    gauge(m, probe_of(m), t + theta * h)
    return m.peaks[n, SAMPLE + probe_of(m)]


@compiled
def probe_within(m, t, h):
    """Replace the samples at the few stages by those of the dense output at the same shares; returns their number."""
    peaks, count = m.peaks, m.sample_count[STAGES]
    for k in range(1, count - 1):
        probe(m, t, h, m.sample_shares[STAGES, k], 0)
        for n in range(peaks.shape[0]):
            peaks[n, SAMPLE + m.sample_order[STAGES, k]] = peaks[n, SAMPLE + probe_of(m)]
    return count - 2


@compiled
def climb(m, t, h, n, low, top, high, height):
    """Maximum of quantity n between the shares low and high of the step, from `top` on; returns the iterations.

    Successive parabolas: the lowest of three points is replaced by the maximum of the parabola through them.
    """
    highest = m.peaks[n, BEST]
    fb = probe(m, t, h, top, n)
    if not fb + height > highest:
        return 1
    b, wide = top, AROUND * max(top - low, high - top)
    a, c = max(low, b - wide), min(high, b + wide)
    fa, fc = probe(m, t, h, a, n), probe(m, t, h, c, n)
    for tried in range(TRIES):
        best = max(fa, fb, fc)
        bend = ((fa - fb) / (a - b) - (fc - fb) / (c - b)) / (a - c)
        if bend < 0.0:
            x = b - 0.5 * ((fa - fb) / (a - b) - bend * (a - b)) / bend
        else:
            x = low if fa > fc else high
        x = min(max(x, low), high)
        if min(abs(x - a), abs(x - b), abs(x - c)) <= NEXT_TO * (high - low):
            return tried + 3
        f = probe(m, t, h, x, n)
        if not f - best > FINE * abs(best) and tried > 0:
            return tried + 4
        if fa <= fb and fa <= fc:
            a, fa = x, f
        elif fc <= fb:
            c, fc = x, f
        else:
            b, fb = x, f
    return TRIES + 3


@native("i", "h", "f", "f", "f")
def crest_all(m, t, h, until):
    """New peaks of the part up to the share `until` of a step; the samples of LOOKS belong to it.

    Their polynomial has them, without further states, except where it is in doubt, as where a force jumps within the
    step: there states are computed.  Returns their number.
    """
    peaks, solved, shares, count = m.peaks, 0, m.sample_shares, m.sample_count[LOOKS]
    for n in range(peaks.shape[0]):
        for i in range(count):
            if not rises(m, peaks[n], LOOKS, i):
                continue
            low, high = shares[LOOKS, max(i - 1, 0)], shares[LOOKS, min(i + 1, count - 1)]
            top, best = crest(m, peaks[n], low, shares[LOOKS, i], high)
            sample = peaks[n, SAMPLE + m.sample_order[LOOKS, i]]
            if doubt_at(m, peaks[n], top) > max(UNSURE * (best - sample), FINE * abs(best)):
                x, height = summit(m, peaks[n], LOOKS, i)
                solved += climb(m, t, h, n, until * low, until * x, until * high, 3.0 * height)
            elif higher(best, peaks[n, BEST]):
                peaks[n, BEST], peaks[n, WHEN] = best, t + top * until * h
    return solved


@native("i", "h", "f", "f", "f", "f", "i")
def climb_all(m, t, h, low, high, layout):
    """New peaks between the shares low and high of a step, to which the samples belong; returns the states computed."""
    peaks, solved, wide, shares, count = m.peaks, 0, high - low, m.sample_shares, m.sample_count[layout]
    for n in range(peaks.shape[0]):
        for i in range(count):
            if rises(m, peaks[n], layout, i):
                top, height = summit(m, peaks[n], layout, i)
                left, right = shares[layout, max(i - 1, 0)], shares[layout, min(i + 1, count - 1)]
                solved += climb(m, t, h, n, low + wide * left, low + wide * top, low + wide * right, height)
    return solved


@native("i", "h", "f", "f", "f", "f", "f", "i")
def sample_pieces(m, t, h, low, until, wide, sound):
    """Count a step between two shares in pieces of its dense output, as short as the forces need.

    low, until: these shares.  wide: share of the first piece.  Returns the number of states computed.
    """
    peaks, solved, shares, order, count = m.peaks, 0, m.sample_shares, m.sample_order, m.sample_count[CUT]
    while low < until:
        high = low + wide if low + REST * wide < until else until
        for k in range(1, count):
            probe(m, t, h, low + (high - low) * shares[CUT, k], 0)
            for n in range(peaks.shape[0]):
                peaks[n, SAMPLE + order[CUT, k]] = peaks[n, SAMPLE + probe_of(m)]
        solved += count - 1
        if sound and wide > SHORTEST and unresolved(m, (high - low) * h, CUT):
            wide = 0.5 * (high - low)
            continue
        add(m, t + high * h, (high - low) * h, CUT, sound)
        if sound:
            solved += climb_all(m, t, h, low, high, CUT)
        pass_end_on(m)
        low, wide = high, 2.0 * wide
    return solved


@compiled
def end_whole_step(m, t, h, layout, dense, sound, clear):
    """`end_step` of a step that no event ends, with its own samples; sound, clear: its forces, by the pivots."""
    solved, told = 0, layout == STAGES and stages_tell(m)
    # where it is not sound, stages are off the constraints by too much
    if told and dense and (unresolved(m, h, STAGES) if sound else clear):
        return sample_pieces(m, t, h, 0.0, 1.0, FIRST_PIECE, True)
    add(m, t + h, h, layout, sound)
    if layout == STAGES and not told and dense:
        dense = 1 if near_peak(m.peaks) else 0
        if dense:
            solved += probe_within(m, t, h)
    if layout == LOOKS:
        solved += crest_all(m, t, h, 1.0)
    elif dense and sound:
        solved += climb_all(m, t, h, 0.0, 1.0, layout)
    pass_end_on(m)
    return solved


@native("i", "h", "f", "f", "f", "i", "i")
def end_step(m, t, h, until, layout, dense):
    """Peaks and sums of the step from t [s] of length h [s] up to the share `until`; returns the states computed.

    The samples of the step are those of `layout`, of CUT if it left none.  dense: 1 if the dense output is ready; with
    -1 the function returns -1 if it is needed, and counts nothing.  If until < 1 an event ends the step: the state
    after it is measured as START of the next.
    """
    if m.peaks.shape[0] == 0:
        return 0
    sound, clear = m.power[at.PIVOT_SHARE] > WEAK, m.power[at.PIVOT_SHARE] > BLIND
    if dense < 0:
        if may_rise(m, h, layout):
            return -1
        dense = 0
    if until < 1.0 or layout == CUT:
        return sample_pieces(m, t, h, 0.0, until, until, clear)
    return end_whole_step(m, t, h, layout, dense, sound, clear)
