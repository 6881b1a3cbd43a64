"""Events of contacts inside a step.

Hits of open contacts, and starts and ends of compliant ones, are found by `gap_search`; changes of closed ones are
detected at sampling points on the dense output, then located.  The sampling points are few and not evenly spaced, so
that no period of a load fits them all; where a force or slip may have been below zero between two of them
(`contact_samples`) the interval is halved.
If the stages of a step show that a contact condition is violated, its zero is located at once, starting from the zero
of the polynomial through them; with the sample taken there they show whether anything may have happened before.
"""

from __future__ import annotations

import numpy as np

from rattle.equations.complementarity import FORWARD, OFF, friction_of
from rattle.equations.motion import solve_motion
from rattle.equations.one_way import pressing
from rattle.equations.state import take_states
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.contacts.clutches import most_torque, rate_left, watched
from rattle.solvers.contacts.contact_events import first_change as first_meeting
from rattle.solvers.contacts.gap_search import NONE, may_reach, search
from rattle.solvers.contacts.pawls import first_drop
from rattle.solvers.dense_output import INSTANT, OF_STEP, interpolate
from rattle.solvers.nonsmooth.contact_modes import BREAK_AWAY, DROP, HIT, LET_GO, MEETS, NOTHING, TURN
from rattle.solvers.peaks.contact_samples import (
    KINDS,
    last_look,
    margin_of,
    matters,
    may_dip,
    slack_of,
    unseen,
    write_look,
)
from rattle.solvers.peaks.samples import LOOKS, gauge
from rattle.solvers.peaks.stage_polynomial import told, zero_told
from rattle.solvers.step_size import STANDSTILL

# first sampling points of a step: evenly spaced ones, which peaks use too, and one that is not
PLACES = np.array([0.0, 0.057, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0])
ODD = 1
LOOKS_KEPT = 64
MOST_LOOKS = 4000  # in one step
GUIDED = 6  # attempts to locate a zero where the stages predict it
NARROW = 1e-6  # share of a step that is not halved further
JUMPED = 1e-3  # share of an indicator that is left where it jumps below zero, as N where a wall ends
BEYOND = 1e-12  # share of the time by which an event is later that is a jump: on its other side whatever the rounding
BEGUN = 1e6  # roundings of a slip up to which it has just begun: a located instant is off by its error, too
GROWN = 1e-9  # share of an interval down to which the place is sought from which on a slip has its sign
MOST_TURNS = 100  # values of an indicator in the search of one zero


@compiled
def at_share(m, t, h, theta):
    """State and forces at the share theta (0 to 1) of the step from t [s] of length h [s]."""
    stage, nq = m.stage, m.change.shape[0]
    interpolate(m, theta, stage)
    take_states(m, stage)
    solve_motion(m, t + theta * h, stage[:nq], stage[nq : 2 * nq])


@compiled
def indicator(m, n, what):
    """Indicator of contact n, not negative while its mode holds: N, mu N - |T| [N], or slip in its direction [m/s].

    `contact_kinematics` must be up to date.
    """
    kinematics = m.contact_kinematics
    if what == LET_GO:
        return pressing(m, n)
    if m.contact[n, at.LEVEL] == 1:
        return most_torque(m, n) - kinematics[n, at.NORMAL] if what == BREAK_AWAY else rate_left(m, n)
    if what == BREAK_AWAY:
        return friction_of(m, n) * kinematics[n, at.NORMAL] - abs(kinematics[n, at.TANGENT])
    return kinematics[n, at.SLIP] if m.mode[n] == FORWARD else -kinematics[n, at.SLIP]


@compiled
def between(low, high, far, f_low, f_high, f_far):
    """Zero of f between low and high as a share of high - low; far: the end that the last point has replaced.

    Inverse quadratic interpolation if that is safe, otherwise the midpoint.  Source: Chandrupatla, A new hybrid
    quadratic/bisection algorithm for finding the zero of a nonlinear function, Adv. Eng. Softw. 28 (1997) 145-149.
    """
    if f_far in (f_low, f_high):
        return f_low / (f_low - f_high)
    if far < low:
        x, phi = (low - high) / (far - high), (f_low - f_high) / (f_far - f_high)
    else:
        x, phi = (high - low) / (far - low), (f_high - f_low) / (f_far - f_low)
    if not (phi * phi < x and (1.0 - phi) * (1.0 - phi) < 1.0 - x):
        return 0.5
    share = f_low * f_far / ((f_high - f_low) * (f_high - f_far))
    return share + (far - low) / (high - low) * f_low * f_high / ((f_far - f_low) * (f_far - f_high))


@compiled
def first_positive(m, t, h, n, what, low, high, f_low):
    """Share between low and high, and value, from which on an indicator is positive, if it is not at low.

    Slip that has just reversed or begun starts from zero: its sign is that of later samples.
    """
    share = 0.5 * (high - low)
    while f_low <= 0.0 and share > GROWN * (high - low) and share * h > STANDSTILL * abs(t):
        at_share(m, t, h, low + share)
        if indicator(m, n, what) > 0.0:
            low += share
            f_low = indicator(m, n, what)
        share *= 0.5
    return low, f_low


@compiled
def locate(m, t, h, n, what, low, high, f_low, f_high, force, column):
    """Share of the step between low and high at which an indicator, with these values there, becomes negative.

    The second share is the same, or just before it if the indicator jumps there.
    force: the largest of all [N].
    column: of the samples at the stages, which predict the zero; -1 if they do not.
    """
    low, f_low = first_positive(m, t, h, n, what, low, high, f_low)
    # a slip or force that is rounding: where it is larger than rounding
    lift = unseen(m, n, 3 if what == TURN else 0, force) if f_low <= 0.0 else 0.0
    f_low, f_high = f_low + lift, f_high + lift
    if f_low <= 0.0:
        return low, low
    last, whole = high, f_low
    low, high, f_high = zero_of(m, t, h, n, what, low, high, f_low, f_high, lift, column)
    if f_high < -JUMPED * whole:
        return min(high + BEYOND * abs(t) / h, last), low
    return high, high


@compiled
def zero_of(m, t, h, n, what, low, high, f_low, f_high, lift, column):
    """Shares just before and after an indicator plus `lift` becomes negative between low and high, and it after."""
    far, f_far, near, shift, tilt = low, f_low, low, lift, 0.0
    least = INSTANT * abs(t) + OF_STEP * h
    for turn in range(MOST_TURNS):
        if not (high - low) * h > least:
            break
        if turn < GUIDED and column >= 0:
            share = (zero_told(m, m.glances, column, low, high, near, shift, tilt) - low) / (high - low)
        else:
            share = 0.5 if turn % 8 == 7 else between(low, high, far, f_low, f_high, f_far)
        aside = min(0.5, 0.75 * least / ((high - low) * h))  # to the other side of a zero that is nearly found
        middle = low + min(max(share, aside), 1.0 - aside) * (high - low)
        if middle <= low or middle >= high:
            break
        at_share(m, t, h, middle)
        value = indicator(m, n, what) + lift
        if column >= 0:
            beside = value - told(m, m.glances, column, middle)
            tilt = (beside - shift) / (middle - near) if turn > 0 else 0.0
            near, shift = middle, beside
        if value < 0.0:
            far, f_far, high, f_high = high, f_high, middle, value
        else:
            far, f_far, low, f_low = low, f_low, middle, value
    return low, high, f_high


@compiled
def first_hit(m, h):
    """Share of the step at which the first open contact closes (NONE if none does, or GAVE_UP), and its index."""
    contact, mode, best, who = m.contact, m.mode, NONE, -1
    for n in range(contact.shape[0]):
        gap = contact[n, at.IMPACT] == 1 and mode[n] == OFF and contact[n, at.LEVEL] == 0
        if gap and may_reach(m, h, n, 1.0):
            share = search(m, h, n, 1.0, min(best, 1.0))
            if share > NONE:
                return share, -1
            if share < best:
                best, who = share, n
    return best, who


@compiled
def any_closed(m):
    """True if a set-valued contact is closed, or at velocity level, which is searched like closed ones."""
    for n in range(m.contact.shape[0]):
        if watched(m, n):
            return True
    return False


@compiled
def look(m, t, h, share, row):
    """Sample all indicators at a share of the step into a row of `looks`, with the largest force [N]."""
    line = m.looks[row]
    at_share(m, t, h, share)
    line[0] = share
    write_look(m, line)


@compiled
def something_may_dip(m, i, count):
    """True if an indicator may be below zero between samples i and i + 1, but is not at either of them."""
    contact, looks = m.contact, m.looks
    force = largest_force(m, i)
    for n in range(contact.shape[0]):
        if not watched(m, n):
            continue
        for kind in range(KINDS):
            c = 1 + KINDS * n + kind
            slack = slack_of(m, n, kind, looks[i, c], looks[i + 1, c], force)
            if matters(m, n, kind) and may_dip(looks, i, count, c, slack):
                return True
    return False


@compiled
def move_looks(looks, first, last, by):
    """Move rows first..last-1 of `looks` by `by` rows."""
    for r in range(last - first):
        k = last - 1 - r if by > 0 else first + r
        for c in range(looks.shape[1]):
            looks[k + by, c] = looks[k, c]


@compiled
def make_room(looks, i, count):
    """Drop the looks before the one ahead of look i; returns where look i is then, and how many are left."""
    move_looks(looks, i - 1, count, 1 - i)
    return 1, count - i + 1


@compiled
def seen_at(m, i, n, what):
    """The indicator of contact n at sample i."""
    c, looks = 1 + KINDS * n, m.looks
    if what == BREAK_AWAY:
        return min(looks[i, c + 1], looks[i, c + 2])
    return looks[i, c] if what == LET_GO else looks[i, c + 3]


@compiled
def largest_force(m, i):
    """The largest force [N] of samples i and i + 1."""
    width = 1 + KINDS * m.contact.shape[0]
    return max(m.looks[i, width], m.looks[i + 1, width])


@compiled
def soonest(m, i):
    """Contact that by sample i + 1 has opened, broken away or reversed its slip, and what: the one with the first zero.

    (-1, NOTHING) if there is none; zeros are those of straight lines from sample i.
    """
    contact, first, who, what = m.contact, 2.0, -1, NOTHING
    force = largest_force(m, i)
    for n in range(contact.shape[0]):
        if not watched(m, n):
            continue
        for kind in (LET_GO, BREAK_AWAY, TURN):
            begin, there = seen_at(m, i, n, kind), seen_at(m, i + 1, n, kind)
            slight = unseen(m, n, 3 if kind == TURN else 0, force)
            if kind == TURN and -BEGUN * slight < begin < 0.0 and there > begin:
                continue  # a slip that has just begun grows out of rounding
            here = max(begin, 0.0)
            if there < -slight and here < first * (here - there):
                first, who, what = here / (here - there), n, kind
    return who, what


@compiled
def column_of(m, i, n, what):
    """Column of the samples for the indicator of contact n, which is below zero at sample i."""
    c, looks = 1 + KINDS * n, m.looks
    if what == BREAK_AWAY:
        return c + 1 if looks[i, c + 1] < looks[i, c + 2] else c + 2
    return c if what == LET_GO else c + 3


@compiled
def first_between(m, t, h, i, best, who, what, guided):
    """First event between samples i and i + 1 before the share `best`, otherwise (best, who, what) unchanged.

    One after the other: a condition that still holds where another one is violated is violated later.  The last sample
    is that at the event.  guided: 1 if the stages predict approximately where it is.
    """
    looks, last = m.looks, -1
    for _ in range(KINDS * m.contact.shape[0]):
        n, kind = soonest(m, i)
        if n < 0 or KINDS * n + kind == last:
            break
        last = KINDS * n + kind
        column = column_of(m, i + 1, n, kind) if guided == 1 else -1
        left, right = seen_at(m, i, n, kind), seen_at(m, i + 1, n, kind)
        begin, end = looks[i, at.LOOK_SHARE], looks[i + 1, at.LOOK_SHARE]
        share, before = locate(m, t, h, n, kind, begin, end, left, right, largest_force(m, i), column)
        if share < best:
            best, who, what = share, n, kind
            m.held[at.BEFORE_JUMP] = before
        if share <= begin:
            break
        look(m, t, h, share, i + 1)
        m.tally[at.EVALUATIONS] += 1
    return best, who, what


@compiled
def look_at_place(m, t, h, low, high, placed, places, count):
    """Sample number `placed` of the first ones of an interval, into row `count`; of a whole step, for peaks too."""
    narrow = places < PLACES.shape[0]
    look(m, t, h, low + (high - low) * (placed / 3.0 if narrow else PLACES[placed]), count)
    if not narrow and high == 1.0 and ODD < placed < PLACES.shape[0] - 1:
        gauge(m, m.sample_order[LOOKS, placed - 1], t + PLACES[placed] * h)


@compiled
def note_largest(m, i):
    """Largest normal force so far of every contact, with sample i + 1."""
    contact, memory = m.contact, m.contact_memory
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            memory[n, at.PEAK] = max(memory[n, at.PEAK], m.looks[i + 1, 1 + KINDS * n]) if m.mode[n] != OFF else 0.0


@compiled
def first_change(m, t, h, low, high, places, best, who, what):
    """First event of closed contacts between two shares of the step, otherwise (best, who, what) unchanged.

    places: number of first sampling points, 4 or all of PLACES; these are the samples of LOOKS in a whole step.
    """
    looks = m.looks
    count, placed, i, seen, wide = 0, 0, 0, 0, high - low
    while True:
        while count < max(i + 3, 4) and placed < places:
            if count == looks.shape[0]:
                i, count = make_room(looks, i, count)
            look_at_place(m, t, h, low, high, placed, places, count)
            count += 1
            placed += 1
            seen += 1
        if i + 1 >= count:
            break
        left, right = looks[i, at.LOOK_SHARE], looks[i + 1, at.LOOK_SHARE]
        room = i > 1 or count + 2 <= looks.shape[0]
        if room and right - left > NARROW * wide and seen < MOST_LOOKS and something_may_dip(m, i, count):
            if count + 2 > looks.shape[0]:
                i, count = make_room(looks, i, count)
            move_looks(looks, i + 1, count, 1)
            look(m, t, h, 0.5 * (left + right), i + 1)
            count += 1
            seen += 1
            i = max(i - 1, 0)
            continue
        note_largest(m, i)
        before = best
        best, who, what = first_between(m, t, h, i, best, who, what, 1 if places < PLACES.shape[0] else 0)
        if best < before:
            break
        i += 1
    m.tally[at.EVALUATIONS] += seen
    return best, who, what


@compiled
def put_among_stages(m, low, share):
    """Replace the samples by those of the stages, with that of row low + 1 sorted in at its share; returns its row."""
    stages, looks, line, last = m.glances, m.looks, low + 1, last_look(m)
    while line < last and stages[line, at.LOOK_SHARE] < share:
        line += 1
    move_looks(looks, low + 1, low + 2, line - low - 1)
    for k in range(last + 1):
        row = k if k < line else k + 1
        for c in range(looks.shape[1]):
            looks[row, c] = stages[k, c]
    return line


@compiled
def none_dips(m, low, line):
    """True if no indicator is or may be below zero between samples `low` and `line`, among those of the stages."""
    contact, looks, stages = m.contact, m.looks, m.glances
    force = stages[last_look(m), 1 + KINDS * contact.shape[0]]
    for n in range(contact.shape[0]):
        if not watched(m, n):
            continue
        for kind in range(KINDS):
            if not matters(m, n, kind):
                continue
            c = 1 + KINDS * n + kind
            least, most, margin = margin_of(stages, c)
            margin -= unseen(m, n, kind, force)
            if least - (most - least) > margin:
                continue
            for i in range(low, line):
                if i + 1 < line and looks[i + 1, c] < margin:
                    return False
                if may_dip(looks, i, last_look(m) + 2, c, -margin):
                    return False
    return True


@compiled
def first_by_stages(m, t, h, low, high):
    """First event of closed contacts between two stages, at the later of which a condition is violated.

    (NONE, -1, NOTHING) if the stages and the sample at the event do not show that it is the first.
    """
    contact, mode, memory = m.contact, m.mode, m.contact_memory
    looks, stages = m.looks, m.glances
    for c in range(looks.shape[1]):
        looks[low, c], looks[low + 1, c] = stages[low, c], stages[high, c]
    share, who, what = first_between(m, t, h, low, NONE, -1, NOTHING, 1)
    if who < 0 or share <= looks[low, at.LOOK_SHARE]:
        return NONE, -1, NOTHING
    line = put_among_stages(m, low, share)
    if not none_dips(m, low, line):
        return NONE, -1, NOTHING
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            for i in range(1, line + 1):
                memory[n, at.PEAK] = max(memory[n, at.PEAK], looks[i, 1 + KINDS * n]) if mode[n] != OFF else 0.0
    return share, who, what


@compiled
def first_besides(m, h):
    """First event of the step but for changes of closed contacts: share (NONE if there is none), contact, kind."""
    best, who = first_hit(m, h)
    what = HIT if who >= 0 else NOTHING
    share, pawl = first_drop(m, h, min(best, 1.0))
    if best <= NONE and (share > NONE or share < best):
        best, who, what = share, pawl, DROP
    if best <= NONE:
        share, elastic = first_meeting(m, h, min(best, 1.0))
        if share < best:
            best, who, what = share, elastic, MEETS
    return best, who, what


@compiled
def first_event(m, t, h, low, high):
    """First event of the step: share (NONE if there is none, GAVE_UP if that is not known), contact and kind of event.

    low, high: the stages between which the first change of closed contacts is, if there is one.
    The dense output must be ready, gaps and rates at both ends in `contact_memory`.  The last value returned is True
    if the stages have shown all changes of closed contacts; otherwise the samples may be those of the search.
    """
    best, who, what = first_besides(m, h)
    if not any_closed(m) or not 0.0 < best <= NONE:
        return best, who, what, False
    last, shares = last_look(m), m.glances
    if best == NONE and high < last:
        best, who, what = first_by_stages(m, t, h, low, high)
        if who >= 0:
            return best, who, what, True
        m.held[at.BEFORE_JUMP] = 1.0
    if best == NONE and low < last and (low > 0 or high < last):
        left, right = shares[low, at.LOOK_SHARE], shares[high, at.LOOK_SHARE]
        best, who, what = first_change(m, t, h, left, right, 4, best, who, what)
        if who >= 0:
            return best, who, what, True
    best, who, what = first_change(m, t, h, 0.0, min(best, 1.0), PLACES.shape[0], best, who, what)
    return best, who, what, False
