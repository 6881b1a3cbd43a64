"""Events of set-valued contacts inside a step.

Hits of free contacts are found by `searching`; what lasting ones do is noticed at some places of the dense output,
then located.  The places are few, one of them odd, so that no period of a load fits them all, and where a force or a
slip may have been below zero between two of them (`glances`) the stretch between them is halved.
"""

from __future__ import annotations

import numpy as np

from rattle.equations.complementarity import FORWARD, OFF, friction_of
from rattle.equations.motion import solve_motion
from rattle.equations.unilateral import SIZE
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.contact_events import interpolate
from rattle.solvers.gap_search import NONE, may_reach, search
from rattle.solvers.glances import KINDS, matters, may_dip, slack_of, write_look
from rattle.solvers.nonsmooth.contact_modes import BREAK_AWAY, HIT, LET_GO, NOTHING, TURN
from rattle.solvers.peaks import LOOK, gauge
from rattle.solvers.step_loop import EVALUATIONS

# places of a step at which it is looked first: even ones, of which peaks make use too, and an odd one
PLACES = np.array([0.0, 0.057, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0])
ODD = 1
LOOKS_KEPT = 64
MOST_LOOKS = 4000  # in one step
NARROW = 1e-6  # share of a step that is not halved


@compiled
def at_share(m, t, h, theta):
    """State and forces at the share theta of the step."""
    stage, nq = m.stage, m.change.shape[0]
    interpolate(m, theta, stage)
    solve_motion(m, t + theta * h, stage[:nq], stage[nq : 2 * nq])


@compiled
def indicator(m, n, what):
    """What must not become negative for contact n: N, mu N - |T|, or slip in its sense; touch is at hand."""
    touch = m.touch
    if what == LET_GO:
        return touch[n, at.NORMAL]
    if what == BREAK_AWAY:
        return friction_of(m, n) * touch[n, at.NORMAL] - abs(touch[n, at.TANGENT])
    return touch[n, at.SLIP] if m.mode[n] == FORWARD else -touch[n, at.SLIP]


@compiled
def locate(m, t, h, n, what, low, high):
    """Share of the step between low and high at which an indicator becomes negative."""
    at_share(m, t, h, low)
    f_low = indicator(m, n, what)
    # slip that has just turned, or a contact that has just slipped, starts from zero: its sign is that of later places
    share = 0.5 * (high - low)
    while f_low <= 0.0 and share > 1e-9 * (high - low) and share * h > 1e-15 * abs(t):
        at_share(m, t, h, low + share)
        if indicator(m, n, what) > 0.0:
            low += share
            f_low = indicator(m, n, what)
        share *= 0.5
    if f_low <= 0.0:
        return low
    at_share(m, t, h, high)
    f_high = indicator(m, n, what)
    for turn in range(100):
        if not (high - low) * h > 1e-16 * abs(t) + 1e-15 * h:
            break
        share = f_low / (f_low - f_high)
        middle = low + min(max(share, 1e-3), 0.999) * (high - low) if turn % 3 < 2 else 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        at_share(m, t, h, middle)
        value = indicator(m, n, what)
        if value < 0.0:
            high, f_high = middle, value
            f_low *= 0.5 if turn % 3 == 1 else 1.0
        else:
            low, f_low = middle, value
            f_high *= 0.5 if turn % 3 == 1 else 1.0
    return high


@compiled
def first_hit(m, h):
    """Share of the step at which the first free contact closes (NONE if none does, or GAVE_UP), and which."""
    contact, mode, best, who = m.contact, m.mode, NONE, -1
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1 and mode[n] == OFF and may_reach(m, h, n, 1.0):
            share = search(m, h, n, 1.0, min(best, 1.0))
            if share > NONE:
                return share, -1
            if share < best:
                best, who = share, n
    return best, who


@compiled
def any_held(m):
    """True when a set-valued contact is closed."""
    contact, mode = m.contact, m.mode
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1 and mode[n] != OFF:
            return True
    return False


@compiled
def look(m, t, h, share, row):
    """Look at a share of the step: all that must not become negative into a line of `looks`, and the largest force."""
    line = m.looks[row]
    at_share(m, t, h, share)
    line[0] = share
    write_look(m, line)


@compiled
def something_may_dip(m, i, count):
    """True when something may be below zero between looks i and i + 1, but is not at either of them."""
    contact, mode, looks = m.contact, m.mode, m.looks
    width = 1 + KINDS * contact.shape[0]
    force = max(looks[i, width], looks[i + 1, width])
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 0 or mode[n] == OFF:
            continue
        for kind in range(KINDS):
            c = 1 + KINDS * n + kind
            slack = slack_of(m, kind, looks[i, c], looks[i + 1, c], force)
            if matters(m, n, kind) and may_dip(looks, i, count, c, slack):
                return True
    return False


@compiled
def move_looks(looks, first, last, by):
    """Lines first..last-1 of `looks` go `by` lines on (or back)."""
    for r in range(last - first):
        k = last - 1 - r if by > 0 else first + r
        for c in range(looks.shape[1]):
            looks[k + by, c] = looks[k, c]


@compiled
def broken_at(m, i, n, what):
    """True when contact n is seen at look i to let go, to break away or to turn."""
    c, looks = 1 + KINDS * n, m.looks
    if what == LET_GO:
        return looks[i, c] < 0.0
    if what == BREAK_AWAY:
        return min(looks[i, c + 1], looks[i, c + 2]) < 0.0
    return looks[i, c + 3] < -1e-13 * m.held[SIZE]


@compiled
def first_change(m, t, h, best, who, what):
    """First event of lasting contacts before the share `best` of the step, or (best, who, what) as they are."""
    contact, mode, grip, looks = m.contact, m.mode, m.grip, m.looks
    until, count, placed, i, seen = min(best, 1.0), 0, 0, 0, 0
    while True:
        while count < max(i + 3, 4) and placed < PLACES.shape[0]:
            look(m, t, h, PLACES[placed] * until, count)
            if ODD < placed < PLACES.shape[0] - 1 and until == 1.0:
                gauge(m, LOOK[placed - 1], t + PLACES[placed] * h)
            count += 1
            placed += 1
            seen += 1
        if i + 1 >= count:
            break
        left, right = looks[i, 0], looks[i + 1, 0]
        if right - left > NARROW * until and seen < MOST_LOOKS and something_may_dip(m, i, count):
            if count + 2 > looks.shape[0]:
                move_looks(looks, i - 1, count, 1 - i)
                count -= i - 1
                i = 1
            move_looks(looks, i + 1, count, 1)
            look(m, t, h, 0.5 * (left + right), i + 1)
            count += 1
            seen += 1
            i = max(i - 1, 0)
            continue
        for n in range(contact.shape[0]):
            if contact[n, at.IMPACT] == 0:
                continue
            grip[n, at.PEAK] = max(grip[n, at.PEAK], looks[i + 1, 1 + KINDS * n]) if mode[n] != OFF else 0.0
            for kind in (LET_GO, BREAK_AWAY, TURN):
                if mode[n] != OFF and broken_at(m, i + 1, n, kind):
                    share = locate(m, t, h, n, kind, left, right)
                    if share < best:
                        best, who, what = share, n, kind
        if what > HIT:
            break
        i += 1
    m.tally[EVALUATIONS] += seen
    return best, who, what


@compiled
def first_event(m, t, h):
    """First event of the step: share (NONE if there is none, GAVE_UP if that is not known), contact and what it is.

    The dense output is ready, gaps and rates at both ends are in `grip`.
    """
    best, who = first_hit(m, h)
    what = HIT if who >= 0 else NOTHING
    if any_held(m) and 0.0 < best <= NONE:
        return first_change(m, t, h, best, who, what)
    return best, who, what
