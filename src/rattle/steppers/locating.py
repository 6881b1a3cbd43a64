"""Events of set-valued contacts inside a step: noticed at PARTS places of its dense output, then located."""

from __future__ import annotations

from rattle.catalog import call_state, compiled
from rattle.complementarity import FORWARD, OFF, STICK, friction_of
from rattle.contact import touch_all
from rattle.equations import place
from rattle.impact import SIZE
from rattle.memory import CHANGE, CONTACT, GRIP, HELD, LINKS, MODE, MOTION, SLIDE, STAGE, TOUCH, imat, ivec, mat, vec
from rattle.plane import DGAP, DGAP_0, DGAP_1, GAP, GAP_0, GAP_1, IMPACT, NORMAL, PEAK, SLIP, TANGENT
from rattle.steppers.closed import BREAK_AWAY, HIT, LET_GO, NOTHING, TURN
from rattle.steppers.touching import NONE, interpolate
from rattle.steppers.walls import noise

PARTS = 8  # pieces of a step that are searched


@compiled
def at_share(m, t, h, theta, full):
    """State at the share theta of the step: contacts alone, or with all forces."""
    stage, nq = vec(m, STAGE), vec(m, CHANGE).shape[0]
    interpolate(m, theta, stage)
    if full:
        call_state(ivec(m, LINKS)[MOTION], (m, t + theta * h, stage[:nq], stage[nq : 2 * nq]))
    else:
        place(m, stage[:nq], stage[nq : 2 * nq])
        touch_all(m)


@compiled
def indicator(m, n, what):
    """What must not become negative for contact n: gap, N, mu N - |T|, or slip in its sense; touch is at hand."""
    touch = mat(m, TOUCH)
    if what == HIT:
        return touch[n, GAP]
    if what == LET_GO:
        return touch[n, NORMAL]
    if what == BREAK_AWAY:
        return friction_of(m, n) * touch[n, NORMAL] - abs(touch[n, TANGENT])
    return touch[n, SLIP] if ivec(m, MODE)[n] == FORWARD else -touch[n, SLIP]


@compiled
def locate(m, t, h, n, what, low, high):
    """Share of the step between low and high at which an indicator becomes negative."""
    full = what != HIT
    at_share(m, t, h, low, full)
    f_low = indicator(m, n, what)
    # slip that has just turned, or a contact that has just slipped, starts from zero: its sign is that of later places
    share = 0.5 * (high - low)
    while f_low <= 0.0 and full and share > 1e-9 * (high - low) and share * h > 1e-15 * abs(t):
        at_share(m, t, h, low + share, full)
        if indicator(m, n, what) > 0.0:
            low += share
            f_low = indicator(m, n, what)
        share *= 0.5
    if f_low <= 0.0:
        return low
    at_share(m, t, h, high, full)
    f_high = indicator(m, n, what)
    for turn in range(100):
        if not (high - low) * h > 1e-16 * abs(t) + 1e-15 * h:
            break
        share = f_low / (f_low - f_high)
        middle = low + min(max(share, 1e-3), 0.999) * (high - low) if turn % 3 < 2 else 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        at_share(m, t, h, middle, full)
        value = indicator(m, n, what)
        if value < 0.0:
            high, f_high = middle, value
            f_low *= 0.5 if turn % 3 == 1 else 1.0
        else:
            low, f_low = middle, value
            f_high *= 0.5 if turn % 3 == 1 else 1.0
    return high


@compiled
def turning_point(m, t, h, n, low, high, rising):
    """Share between low and high at which the gap of contact n stops rising (or falling)."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        at_share(m, t, h, middle, False)
        if (mat(m, TOUCH)[n, DGAP] > 0.0) == rising:
            low = middle
        else:
            high = middle
    return low


@compiled
def hit_between(m, t, h, n, left, right, gap, rate):
    """Share at which the gap of free contact n closes between left and right; NONE when it does not.

    gap, rate: at the right end; those at the left end are in `grip`.
    """
    grip, deep = mat(m, GRIP)[n], noise(m, n)
    if gap < -deep:
        if grip[GAP_0] <= 0.0 and grip[DGAP_0] > 0.0:  # has just left the wall and comes back
            left = turning_point(m, t, h, n, left, right, True)
        return locate(m, t, h, n, HIT, left, right)
    if grip[DGAP_0] < 0.0 and rate > 0.0:  # a minimum in between: does it dip below zero?
        slope = max(-grip[DGAP_0], rate)
        if min(grip[GAP_0], gap) < slope * h * (right - left):
            low = turning_point(m, t, h, n, left, right, False)
            at_share(m, t, h, low, False)
            if mat(m, TOUCH)[n, GAP] < min(grip[GAP_0], 0.0) - deep:
                return locate(m, t, h, n, HIT, left, low)
    return NONE


@compiled
def may_hit(m, n, h):
    """True when free contact n may close in the step: its gap is not out of reach at the rates of both ends."""
    grip = mat(m, GRIP)[n]
    bend = abs(grip[DGAP_1] - grip[DGAP_0])
    return min(grip[GAP_0], grip[GAP_1]) <= h * (max(-grip[DGAP_0], grip[DGAP_1], 0.0) + bend)


@compiled
def first_event(m, t, h):
    """First event of the step: share (NONE if there is none), contact and what it is.  The dense output is ready,

    gaps and rates at both ends are in `grip`.
    """
    contact, touch, mode, grip = imat(m, CONTACT), mat(m, TOUCH), ivec(m, MODE), mat(m, GRIP)
    best, who, what = NONE, -1, NOTHING
    any_held, any_free = False, False
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 1:
            any_held = any_held or mode[n] != OFF
            any_free = any_free or (mode[n] == OFF and may_hit(m, n, h))
    if not any_held and not any_free:
        return best, who, what
    for part in range(1, PARTS + 1):
        left, right = (part - 1) / PARTS, part / PARTS
        at_share(m, t, h, right, any_held)
        for n in range(contact.shape[0]):
            grip[n, GAP_1], grip[n, DGAP_1] = touch[n, GAP], touch[n, DGAP]
            grip[n, PEAK] = max(grip[n, PEAK], touch[n, NORMAL]) if mode[n] != OFF else 0.0
        held = 0.0
        for n in range(contact.shape[0]):  # what has become negative, noted before the search overwrites touch
            slide = 0
            if contact[n, IMPACT] == 1 and mode[n] != OFF:
                held = max(held, touch[n, NORMAL])
                if touch[n, NORMAL] < 0.0:
                    slide += 1
                if friction_of(m, n) > 0.0:
                    if mode[n] == STICK and indicator(m, n, BREAK_AWAY) < 0.0:
                        slide += 2
                    if mode[n] != STICK and indicator(m, n, TURN) < -1e-13 * vec(m, HELD)[SIZE]:
                        slide += 4
            ivec(m, SLIDE)[n] = slide
        for n in range(contact.shape[0]):
            if contact[n, IMPACT] == 0:
                continue
            if mode[n] == OFF:
                share = hit_between(m, t, h, n, left, right, grip[n, GAP_1], grip[n, DGAP_1]) if any_free else NONE
                if share < best:
                    best, who, what = share, n, HIT
                continue
            broken = ivec(m, SLIDE)[n]
            for k in range(3):
                if broken & (1 << k):
                    share = locate(m, t, h, n, LET_GO + k, left, right)
                    if share < best:
                        best, who, what = share, n, LET_GO + k
        if who >= 0:
            return best, who, what
        for n in range(contact.shape[0]):
            grip[n, GAP_0], grip[n, DGAP_0] = grip[n, GAP_1], grip[n, DGAP_1]
    return best, who, what
