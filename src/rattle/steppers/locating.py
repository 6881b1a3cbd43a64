"""Events of set-valued contacts inside a step.

Hits of free contacts are found by `searching`; what lasting ones do is noticed at PARTS places of the dense output,
then located.
"""

from __future__ import annotations

from rattle.catalog import call_gauge, call_search, call_state, compiled
from rattle.complementarity import FORWARD, OFF, STICK, friction_of
from rattle.impact import SIZE
from rattle.memory import (
    CHANGE,
    CONTACT,
    GAUGE,
    GRIP,
    HELD,
    LINKS,
    MODE,
    MOTION,
    SEARCH,
    SLIDE,
    STAGE,
    TOUCH,
    imat,
    ivec,
    mat,
    vec,
)
from rattle.plane import IMPACT, NORMAL, PEAK, SLIP, TANGENT
from rattle.steppers.closed import BREAK_AWAY, HIT, LET_GO, NOTHING, TURN
from rattle.steppers.peaks import LOOK
from rattle.steppers.searching import NONE, may_reach
from rattle.steppers.touching import interpolate

PARTS = 8  # pieces of a step that are searched


@compiled
def at_share(m, t, h, theta):
    """State and forces at the share theta of the step."""
    stage, nq = vec(m, STAGE), vec(m, CHANGE).shape[0]
    interpolate(m, theta, stage)
    call_state(ivec(m, LINKS)[MOTION], (m, t + theta * h, stage[:nq], stage[nq : 2 * nq]))


@compiled
def indicator(m, n, what):
    """What must not become negative for contact n: N, mu N - |T|, or slip in its sense; touch is at hand."""
    touch = mat(m, TOUCH)
    if what == LET_GO:
        return touch[n, NORMAL]
    if what == BREAK_AWAY:
        return friction_of(m, n) * touch[n, NORMAL] - abs(touch[n, TANGENT])
    return touch[n, SLIP] if ivec(m, MODE)[n] == FORWARD else -touch[n, SLIP]


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
    """Share of the step at which the first free contact closes (NONE if none does), and which."""
    contact, mode, best, who = imat(m, CONTACT), ivec(m, MODE), NONE, -1
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 1 and mode[n] == OFF and may_reach(m, h, n, 1.0):
            share = call_search(ivec(m, LINKS)[SEARCH], (m, h, n, 1.0, min(best, 1.0)))
            if share < best:
                best, who = share, n
    return best, who


@compiled
def any_held(m):
    """True when a set-valued contact is closed."""
    contact, mode = imat(m, CONTACT), ivec(m, MODE)
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 1 and mode[n] != OFF:
            return True
    return False


@compiled
def first_event(m, t, h):
    """First event of the step: share (NONE if there is none), contact and what it is.  The dense output is ready,

    gaps and rates at both ends are in `grip`.
    """
    contact, touch, mode, grip = imat(m, CONTACT), mat(m, TOUCH), ivec(m, MODE), mat(m, GRIP)
    best, who = first_hit(m, h)
    what = HIT if who >= 0 else NOTHING
    if not any_held(m):
        return best, who, what
    for part in range(1, PARTS + 1):
        left, right = (part - 1) / PARTS, min(part / PARTS, best)
        if left >= right:
            break
        at_share(m, t, h, right)
        if part < PARTS and right == part / PARTS:
            call_gauge(ivec(m, LINKS)[GAUGE], (m, LOOK[part], t + right * h))
        for n in range(contact.shape[0]):  # what has become negative, noted before the search overwrites touch
            slide = 0
            grip[n, PEAK] = max(grip[n, PEAK], touch[n, NORMAL]) if mode[n] != OFF else 0.0
            if contact[n, IMPACT] == 1 and mode[n] != OFF:
                if touch[n, NORMAL] < 0.0:
                    slide += 1
                if friction_of(m, n) > 0.0:
                    if mode[n] == STICK and indicator(m, n, BREAK_AWAY) < 0.0:
                        slide += 2
                    if mode[n] != STICK and indicator(m, n, TURN) < -1e-13 * vec(m, HELD)[SIZE]:
                        slide += 4
            ivec(m, SLIDE)[n] = slide
        for n in range(contact.shape[0]):
            broken = ivec(m, SLIDE)[n]
            for k in range(3):
                if broken & (1 << k):
                    share = locate(m, t, h, n, LET_GO + k, left, right)
                    if share < best:
                        best, who, what = share, n, LET_GO + k
        if what > HIT:
            break
    return best, who, what
