"""Steps across a singular position, in which rows of the constraints become dependent for an instant.

    S = Phi_q M^-1 Phi_q^T     root = sqrt(least pivot / its diagonal)     root ~ k |t - t*|  along a smooth branch

There branches of the motion cross.  The motion along a smooth branch is as smooth as elsewhere, but accelerations
follow from 0/0: positions across the branch are known to eps/root, rates to eps/root^2, accelerations to eps/root^3.
Shorter steps only come closer to it.  A step is therefore laid so that its stages straddle the position, none of them
near it: t* is found ahead, on the path of constant acceleration, and put into the widest gap between the stages.  A
step that has passed one is searched for t* on its dense output.  On a smooth branch the constraints hold there too;
where they do not, two branches only come near each other, and the step would have changed from one to the other: it is
repeated with a shorter length.

Steps of a driven motion may be long: its forces do not act on it, so that no stage need be near t*.  Nor does the
least root tell: another row's pivot may be less wherever it is looked at.  Each row's own root is |smooth| across t*,
and its range at the stages shows whether it can vanish between them.

Forces may grow as 1/(t - t*), or be finite but lost in rounding.  What is nearer than NEAR has no part in peaks.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.equations.motion import constraints, drive, place
from rattle.equations.schur import PIVOT, WEAK, factorise
from rattle.equations.state import take_travels
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.dense_output import interpolate, prepare_dense
from rattle.solvers.peaks.peak_search import end_step, probe, sample_pieces
from rattle.solvers.peaks.samples import BEST, SAMPLE, SQUARES, START, WHEN, probe_of
from rattle.solvers.step_audit import openness

NEAR = math.sqrt(WEAK)  # root below which forces are not to be trusted beside a singular position
SINGULAR = 1e-3  # root at t* up to which a position is singular; what is left comes from the error of the dense output
LOOKS = 16  # intervals in which the smallest root is sought
INSIDE = 0.6**2  # pivot share, of the row's largest in the step, from which it may vanish between stages: a line that
# vanishes in the widest gap between them, 0.33 to 0.6 of the step, is seen at a third of its largest value, a curve
# that flattens later
AT_END = 0.4**2  # the same if it is least at an end of the step: a line at 0.14 beside t* in the last gap, 0.86 to 1
DIPS = 0.9**2  # share of those at both ends below which the least one is not that of an end: stages are off by less
SEEN = 1e3 * PIVOT  # largest pivot share of a row in a step that is not rounding
SHARP = 0.75  # a sample this low beside its neighbours' mean may hide another zero; a line's is 0.5 at most
GRAZED = 0.02  # root at an end of the step, of the next sample's, that is one left behind or ahead, not passed
RESOLVED = 100.0  # openness, times this, below which a root that stays above SINGULAR is not one of the dense output
LEVELS = 4  # times that the search is repeated, each in three intervals of the last: 1e-3 of the step, then linear
LATE = 1.2  # a straddling step is at most so many times as long as the one that failed
FORESIGHT = 3.0  # steps ahead of which the next ones are laid so that one of them straddles the position
SHORTER = 0.95  # length of these, at most, in steps that failed
BESIDE = 0.15  # share of a step between its end and a singular position that is too little
FELL = 0.5  # share of the root at the start from which its fall, in a step, is not that of a slow approach
WELL_BEFORE = 0.7  # of a step that ends at a singular position: the next of this length has it in its middle gap
CLOSEST = 1e-4  # share of the last regular step to t* from which no further straddling is tried
CROSSED = 1e-7  # openness of the dense output at t*, relative to size or 1 rad, that is no sign of another branch
CROSSED_RTOL = 1e3  # the same in relative tolerances
FIRST_PIECE = 0.125  # share of a step in which the forces beside a singular position are first sampled
AWAY, BEFORE, PASSED = 0.0, 1.0, 2.0  # where a run is: away from singular positions, near one, or past it but near
MOST = 64  # passages that are kept with their state
FORESEEN = 1.3  # times a step, up to which a singular position after its end is looked for


def passage_arrays(ny: int, rows: int, quantities: int) -> dict[str, np.ndarray]:
    """Workspace arrays for singular positions; ny: numbers of a state, rows: of constraints, quantities: with peaks."""
    passage = np.zeros(at.width("passage"))
    passage[at.TRIED_AT] = -math.inf
    passage[at.ROOT_BEFORE], passage[at.CLOSEST_ROOT] = 1.0, NEAR
    return {
        "passage": passage,
        "passages": np.zeros((MOST, at.width("passages"))),
        "passage_states": np.zeros((MOST, ny)),
        "passage_looks": np.zeros((LOOKS + 1, rows)),
        "passage_roots": np.zeros(LOOKS + 1),
        "peaks_aside": np.zeros((quantities, 3)),
    }


@compiled
def root_at(m, t, y):
    """The root at the positions of y at t [s]; 0 if more rows than usual are dependent."""
    nq, share = m.change.shape[0], m.power[at.PIVOT_SHARE]
    place(m, y[:nq], y[nq : 2 * nq])
    take_travels(m, y)
    drive(m, t)
    constraints(m)
    m.power[at.PIVOT_SHARE] = 1.0
    lost = factorise(m)
    root = math.sqrt(m.power[at.PIVOT_SHARE])
    m.power[at.PIVOT_SHARE] = share
    return 0.0 if lost > m.passage[at.USUAL_LOST] else root


@compiled
def lowest(roots):
    """Place [in intervals] where evenly spaced roots vanish, by lines, and the slope; -1 if none or at an end."""
    k, last = 0, roots.shape[0] - 1
    for n in range(roots.shape[0]):
        k = n if roots[n] < roots[k] else k
    if k == 0 or k == last:
        return -1.0, 0.0
    before, here, after = roots[k - 1], roots[k], roots[k + 1]
    if here > SHARP * 0.5 * (before + after):
        return -1.0, 0.0
    left, right = before + here, here + after  # slopes if it lies in the interval before, behind
    if not left > 0.0 or not right > 0.0:
        return float(k), max(left, right)
    behind, ahead = here / left, here / right
    if abs(left * (1.0 + behind) - after) < abs(right * (1.0 + ahead) - before):
        return k - behind, left
    return k + ahead, right


@native("f", "h", "f", "f")
def time_ahead(m, t, span):
    """Time [s] from t to the next singular position within `span`, with constant accelerations; -1 if there is none."""
    y, f, stage, roots, nq = m.state, m.rate, m.stage, m.passage_roots, m.change.shape[0]
    for k in range(roots.shape[0]):
        tau = span * k / (roots.shape[0] - 1)
        for n in range(nq):
            stage[n] = y[n] + tau * (y[nq + n] + 0.5 * tau * f[nq + n])
            stage[nq + n] = y[nq + n] + tau * f[nq + n]
        roots[k] = root_at(m, t + tau, stage)
    where = lowest(roots)[0]
    return span * where / (roots.shape[0] - 1) if where >= 0.0 else -1.0


@native("i", "h", "f", "f")
def straddle(m, t, h):
    """Choose a step from t [s] after one of length h [s] that failed next to a singular position; 0 if none is left."""
    clock, passage, gaps = m.clock, m.passage, m.stage_gaps  # at which the step would have no stage near it
    if gaps.shape[0] == 0:
        return 0
    ahead = time_ahead(m, t, FORESIGHT * h)
    if not ahead > CLOSEST * clock[at.H_SOUND]:
        return 0
    tried, passage[at.TRIED_AT] = passage[at.TRIED_AT] == t, -math.inf
    m.tally[at.TAME] = 1
    if tried:  # nearer to it, with a shorter step
        clock[at.H] = 0.5 * ahead
        return 1
    for n in range(gaps.shape[0]):
        if ahead <= LATE * gaps[n] * h:
            clock[at.H] = ahead / gaps[n]
            passage[at.TRIED_AT] = t
            return 1
    rest = ahead - gaps[gaps.shape[0] // 2] * h  # steps that end where one of length h would straddle it
    clock[at.H] = rest / (1.0 + int(rest / (SHORTER * h)))
    return 1


@compiled
def ends_beside(m, t, h):
    """1 if the step from t [s] of length h [s] ends so close to a singular position that another one is chosen."""
    passage = m.passage
    if not passage[at.ROOT_AFTER] < min(NEAR, passage[at.ROOT_BEFORE]) or m.stepper[at.ADAPTIVE] == 0:
        return 0
    ahead = time_ahead(m, t, FORESEEN * h)
    if abs(ahead - h) < BESIDE * h and straddle(m, t, h) == 1:
        return 1
    if (
        passage[at.ROOT_BEFORE] > NEAR and passage[at.ROOT_AFTER] < FELL * passage[at.ROOT_BEFORE]
    ):  # on a path too long to be foreseen
        m.clock[at.H] = WELL_BEFORE * h
        return 1
    return 0


@compiled
def watch_pivots(m):
    """Begin the ranges of the pivots anew, at the start of a step."""
    shares = m.pivots_of_row
    for k in range(shares.shape[0]):
        shares[k, at.SHARE_LEAST] = shares[k, at.SHARE_BEFORE]
        shares[k, at.SHARE_MOST] = shares[k, at.SHARE_BEFORE]


@compiled
def keep_pivots(m, column):
    """Keep the pivots as factored last as those at an end of the step: SHARE_BEFORE or SHARE_AFTER."""
    shares = m.pivots_of_row
    for k in range(shares.shape[0]):
        shares[k, column] = shares[k, at.SHARE_NOW]


@compiled
def pass_pivots_on(m):
    """Make the pivots at the end of a step those at the start of the next."""
    shares = m.pivots_of_row
    for k in range(shares.shape[0]):
        shares[k, at.SHARE_BEFORE] = shares[k, at.SHARE_AFTER]


@compiled
def suspect_pivots(m):
    """Mark the rows whose pivot may vanish between the stages of the step; returns their number."""
    shares, suspects = m.pivots_of_row, 0.0
    for k in range(shares.shape[0]):
        least, most = shares[k, at.SHARE_LEAST], shares[k, at.SHARE_MOST]
        shares[k, at.MAY_VANISH] = 0.0
        if least < INSIDE * most and most > SEEN:
            dips = least < DIPS * min(shares[k, at.SHARE_BEFORE], shares[k, at.SHARE_AFTER])
            if dips or least < AT_END * most or least < WEAK:
                shares[k, at.MAY_VANISH] = 1.0
                suspects += 1.0
    m.passage[at.SUSPECTS] = suspects
    return suspects


@compiled
def suspect_root(m, t, y):
    """`root_at`, of the rows that are suspect only; of all if there are none."""
    root, shares = root_at(m, t, y), m.pivots_of_row
    if m.passage[at.SUSPECTS] == 0.0 or root == 0.0:
        return root
    least = 1.0
    for k in range(shares.shape[0]):
        if shares[k, at.MAY_VANISH] == 1.0:
            least = min(least, shares[k, at.SHARE_NOW])
    return math.sqrt(least)


@compiled
def end_zero(roots):
    """Place [in intervals] where the root vanishes between an end of the step and the sample next to it, and its slope.

    -1 if it does not: a line through zero turns there, another one goes on.
    """
    last = roots.shape[0] - 1
    first = roots[0] <= roots[last]
    here, beside, beyond = (roots[0], roots[1], roots[2]) if first else (roots[last], roots[last - 1], roots[last - 2])
    rise = beyond - beside
    if here > GRAZED * beside and abs(beside + here - rise) < abs(beside - here - rise):
        share = here / (here + beside)
        return share if first else last - share, here + beside
    return -1.0, 0.0


@compiled
def sharp_dips(roots):
    """Number of minima of the samples of a root that may be zeros."""
    dips, last = 0, roots.shape[0] - 1
    for k in range(1, last):
        before, here, after = roots[k - 1], roots[k], roots[k + 1]
        if here <= before and here < after and here < SHARP * 0.5 * (before + after):
            dips += 1
    return dips


@compiled
def zero_of(m, row):
    """Place [in intervals] at which the root of a row vanishes in the step, by `passage_looks`, and its slope.

    -1 if it does not, -2 if it may do so twice.
    """
    roots, looks = m.passage_roots, m.passage_looks
    for k in range(roots.shape[0]):
        roots[k] = looks[k, row]
    dips = sharp_dips(roots)
    if dips > 1:
        return -2.0, 0.0
    if dips == 1:
        return lowest(roots)
    return end_zero(roots)


@compiled
def first_look(m, t, h):
    """Place [in intervals] at which suspect rows vanish in the step, and the slope; -1 and -2 as in `zero_of`.

    Rows that do not are suspect no longer.
    """
    roots, looks, shares, passage = m.passage_roots, m.passage_looks, m.pivots_of_row, m.passage
    for k in range(roots.shape[0]):
        share = k / (roots.shape[0] - 1)
        interpolate(m, share, m.stage)
        roots[k] = root_at(m, t + share * h, m.stage)
        for row in range(shares.shape[0]):
            looks[k, row] = math.sqrt(shares[row, at.SHARE_NOW])
    if passage[at.SUSPECTS] == 0.0:
        return lowest(roots)
    where, slope = -1.0, 0.0
    for row in range(shares.shape[0]):
        if shares[row, at.MAY_VANISH] == 0.0:
            continue
        place_of, rise = zero_of(m, row)
        if place_of == -2.0 or (place_of >= 0.0 and where >= 0.0 and abs(place_of - where) > 1.0):
            return -2.0, 0.0
        if place_of < 0.0:
            shares[row, at.MAY_VANISH] = 0.0
        else:
            where, slope = place_of, max(slope, rise)
    return where, slope


@native("f", "h", "f", "f")
def sought(m, t, h):
    """Share of the step from t [s] of length h [s] at which it passes a singular position; -1 if it does not.

    -2 if it may pass two.  The dense output is ready.  The slope of the root per step goes to passage[SLOPE].
    """
    roots, stage = m.passage_roots, m.stage
    low, wide = 0.0, 1.0 / (roots.shape[0] - 1)
    place_of, slope = first_look(m, t, h)
    if place_of < 0.0:
        return place_of
    where = -1.0
    for _ in range(1, LEVELS):
        where, m.passage[at.ROOT_SLOPE] = low + place_of * wide, slope / wide
        low, wide = where - 1.5 * wide, 3.0 * wide / (roots.shape[0] - 1)
        for k in range(roots.shape[0]):
            interpolate(m, low + k * wide, stage)
            roots[k] = suspect_root(m, t + (low + k * wide) * h, stage)
        place_of, slope = lowest(roots)
        if place_of < 0.0:
            break
    if place_of >= 0.0:
        where, m.passage[at.ROOT_SLOPE] = low + place_of * wide, slope / wide
    return where if 0.0 <= where <= 1.0 else -1.0


@compiled
def keep_passage(m, t, y, root):
    """Keep the state y at t [s], with this root, as that of the next singular position."""
    n = int(m.passage[at.PASSED])
    m.passage[at.CLOSEST_ROOT] = root
    if n < m.passages.shape[0]:
        row = m.passages[n]
        row[at.PASSED_AT], row[at.PASSED_ROOT] = t, root
        for k in range(y.shape[0]):
            m.passage_states[n, k] = y[k]


@compiled
def count_passage(m, since, until):
    """Count the singular position that was kept, once; forces from `since` to `until` [s] have no part in peaks."""
    passage = m.passage
    n = int(passage[at.PASSED])
    if passage[at.NEARBY] == PASSED:
        n -= 1
    elif n < m.passages.shape[0]:
        m.passages[n, at.PASSED_FROM] = since
    if n < m.passages.shape[0]:
        m.passages[n, at.PASSED_UNTIL] = until
    passage[at.PASSED] = n + 1.0


@native("void", "h", "f")
def leave(m, t):
    """Forget the forces next to a singular position that lies behind at t [s].

    One that steps have come closer to than SINGULAR, without passing it in one of them, is counted too.
    """
    passage = m.passage
    if passage[at.NEARBY] == PASSED or passage[at.CLOSEST_ROOT] < SINGULAR:
        bring_back(m)
        count_passage(m, passage[at.NEAR_SINCE], t)
    passage[at.NEARBY], passage[at.CLOSEST_ROOT] = AWAY, NEAR


@native("i", "h", "f", "f", "f")
def passes(m, t, h, rtol):
    """1 if the step from t [s] of length h [s] passes a singular position along a smooth branch, 0 if it passes none.

    -1 if it would change to another branch, passes two, or is too coarse to tell.
    """
    passage, stage = m.passage, m.stage
    least = min(passage[at.ROOT_WITHIN], passage[at.ROOT_AFTER])
    if suspect_pivots(m) == 0.0 and not least < NEAR:
        return 0
    prepare_dense(m, t, h)
    m.tally[at.EVALUATIONS] += m.stepper[at.DENSE_STAGES]
    where = sought(m, t, h)
    if where < 0.0:
        return -1 if where == -2.0 else 0
    interpolate(m, where, stage)
    root = root_at(m, t + where * h, stage)
    if root > SINGULAR:
        return 0 if RESOLVED * openness(m) < root else -1
    if openness(m) > max(CROSSED, CROSSED_RTOL * rtol):
        return -1
    passage[at.PASSED_SHARE], passage[at.ROOT_THERE] = where, root
    return 1


@compiled
def put_aside(m):
    """Keep the peaks and sums as they are before the neighbourhood of a singular position."""
    aside, peaks = m.peaks_aside, m.peaks
    for n in range(peaks.shape[0]):
        aside[n, 0], aside[n, 1], aside[n, 2] = peaks[n, BEST], peaks[n, WHEN], peaks[n, SQUARES]


@compiled
def bring_back(m):
    """Forget the peaks and sums since `put_aside`."""
    aside, peaks = m.peaks_aside, m.peaks
    for n in range(peaks.shape[0]):
        peaks[n, BEST], peaks[n, WHEN], peaks[n, SQUARES] = aside[n, 0], aside[n, 1], aside[n, 2]


@compiled
def come_near(m, t):
    """Set peaks and sums aside: from t [s] on they may be those next to a singular position."""
    passage = m.passage
    put_aside(m)
    passage[at.NEARBY], passage[at.CLOSEST_ROOT], passage[at.NEAR_SINCE] = BEFORE, NEAR, t


@native("i", "h", "f", "f", "f", "i", "i", "i")
def count_step(m, t, h, until, layout, dense, passed):
    """`end_step`, without what lies next to a singular position; passed: the step passes one."""
    passage = m.passage
    if m.peaks.shape[0] == 0:
        return 0
    if passed == 1:
        return count_around(m, t, h, until)
    near = passage[at.ROOT_AFTER] < NEAR
    solved, share = 0, 0.0
    if dense == 1 and near == (passage[at.NEARBY] == AWAY):  # comes near within the step, or leaves
        change = passage[at.ROOT_AFTER] - passage[at.ROOT_BEFORE]
        share = min(max(0.0, (NEAR - passage[at.ROOT_BEFORE]) / change), until) if change != 0.0 else 0.0
        solved += count_part(m, t, h, 0.0, share)
    if near and passage[at.NEARBY] == AWAY:
        come_near(m, t + share * h)
    elif not near and passage[at.NEARBY] != AWAY:
        leave(m, t + share * h)
    least = min(passage[at.ROOT_WITHIN], passage[at.ROOT_AFTER])
    if passage[at.NEARBY] == BEFORE and least < passage[at.CLOSEST_ROOT]:
        keep_passage(m, t + h, m.state_new, least)
    if share > 0.0:
        return solved + count_part(m, t, h, share, until)
    if passage[at.NEARBY] != AWAY and least < SINGULAR:
        return 0  # it would be forgotten
    return end_step(m, t, h, until, layout, dense)


@compiled
def count_part(m, t, h, low, high):
    """Count a step between two shares of it, by its dense output; returns the states computed."""
    if not high > low:
        return 0
    if low > 0.0:
        probe(m, t, h, low, 0)
        for n in range(m.peaks.shape[0]):
            m.peaks[n, SAMPLE + START] = m.peaks[n, SAMPLE + probe_of(m)]
    return 1 + sample_pieces(m, t, h, low, high, min(FIRST_PIECE, high - low), True)


@compiled
def count_around(m, t, h, until):
    """Count the parts of a step that passes a singular position where the root is at least NEAR, up to a share of it.

    Returns the states computed.
    """
    passage = m.passage
    half = NEAR / max(passage[at.ROOT_SLOPE], NEAR)
    low = min(max(0.0, passage[at.PASSED_SHARE] - half), until)
    high = min(passage[at.PASSED_SHARE] + half, until)
    if passage[at.NEARBY] == AWAY:
        come_near(m, t + low * h)
    bring_back(m)
    solved = count_part(m, t, h, 0.0, low) + count_part(m, t, h, high, until)
    interpolate(m, passage[at.PASSED_SHARE], m.stage)
    if passage[at.NEARBY] != PASSED:
        keep_passage(m, t + passage[at.PASSED_SHARE] * h, m.stage, passage[at.ROOT_THERE])
    count_passage(m, passage[at.NEAR_SINCE], t + high * h)
    passage[at.NEARBY], passage[at.CLOSEST_ROOT] = PASSED if passage[at.ROOT_AFTER] < NEAR else AWAY, NEAR
    put_aside(m)
    return solved
