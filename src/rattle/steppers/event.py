"""Event-driven motion with set-valued contacts: smooth stretches between located events.

Between events every contact keeps its mode (off, sticking, sliding) and lasting contacts act as constraints whose
forces `impact.hold` adds.  Each step is searched on its dense output for the first of

    gap = 0                  impact, with all contacts that are closed at that instant in one problem
    N = 0                    release
    |T| = mu N               stick -> slip
    slip = 0                 slip -> stick, or on in the other sense, as the problem for the accelerations says

An infinite sequence of bounces is closed when a bounce would rise less than LOW clearances: the contact is then
taken as lasting, and its start is put at the end of the geometric series, t + 2 v / (|g''| (1 - e)).
LOW is 1e-11 (but never less than the rounding of positions, 4e-15 of the size of the mechanism): in a clearance of
1 mm that is a bounce of a few 1e-6 m/s.

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5 to 9.
"""

from __future__ import annotations

import math

from rattle.catalog import compiled
from rattle.contact import touch_all
from rattle.equations import (
    DONE,
    OK,
    PAUSED,
    STEP_TOO_SMALL,
    accelerate,
    constraints,
    derivative,
    drive,
    loads,
    place,
    solve_motion,
)
from rattle.impact import (
    BACKWARD,
    DETERMINANT,
    FORWARD,
    OFF,
    OTHER,
    SIZE,
    STICK,
    B,
    F,
    add_forces,
    along,
    contact_rows,
    count_solutions,
    friction_of,
    is_rough,
    lasting_side,
    solve_contacts,
    solve_modes,
    swing,
)  # fmt: skip
from rattle.memory import (
    ACCELERATION,
    BODY,
    CHANGE,
    CHOSEN,
    CLOCK,
    CONTACT,
    DIRECTION,
    EVENTS,
    GRIP,
    HELD,
    MODE,
    MULTIPLIER,
    POWER,
    RATE,
    RATE_NEW,
    ROWS,
    SIDE,
    SLIDE,
    STAGE,
    STATE,
    STATE_NEW,
    TALLY,
    TOUCH,
    TRIAL,
    VALUES,
    imat,
    ivec,
    mat,
    vec,
)  # fmt: skip
from rattle.plane import (
    CLOSED,
    CONTACT_EVENT,
    DGAP,
    DGAP_0,
    DGAP_1,
    GAMMA_N,
    GAP,
    GAP_0,
    GAP_1,
    IMPACT,
    IMPACT_EVENT,
    IMPULSE_0,
    LOSS_0,
    N_1,
    NORMAL,
    NORMAL_P,
    NU,
    OPEN,
    PEAK,
    RELEASE_EVENT,
    SHAPE_P,
    SHUT,
    SINCE,
    SLIP,
    SLIP_EVENT,
    SPEED,
    STEPS_IN,
    STICK_EVENT,
    TANGENT,
    VX,
)  # fmt: skip
from rattle.schur import factorise
from rattle.steppers.dop853 import step as step_dop853
from rattle.steppers.march import (
    DRIFT,
    EVALUATIONS,
    EVENT_COUNT,
    H_MIN,
    OUTPUTS,
    REJECTED,
    STEPS,
    TROUBLE,
    H,
    T,
    prepare_dense,
    project,
)  # fmt: skip
from rattle.steppers.touching import NONE, interpolate
from rattle.steppers.writing import record

NO_SOLUTION, NOT_UNIQUE, LOCKED, CHATTER = range(10, 14)  # more endings of a run
PARTS = 8  # pieces of a step that are searched
LOW = 1e-11  # bounces that rise less than this share of the clearance are closed
NEAR = 1e-9  # share of the clearance within which contacts hit at the same instant
STILL = 1e-12  # share of the terms of a contact velocity that counts as rest
NOTHING, HIT, LET_GO, BREAK_AWAY, TURN = range(5)  # what an event is
MOST_AT_ONCE = 60  # events without progress in time after which a run stops


@compiled
def clearance_of(m, n):
    """Clearance of contact n [m]."""
    return vec(m, VALUES)[imat(m, CONTACT)[n, SHAPE_P] + 4]


@compiled
def noise(m, n):
    """Depth that rounding may give to contact n [m]."""
    return 1e-12 * clearance_of(m, n) + 1e-15 * vec(m, HELD)[SIZE]


@compiled
def held_contacts(m):
    """Choose all contacts that last, with their modes; returns how many there are."""
    contact, mode, chosen, trial = imat(m, CONTACT), ivec(m, MODE), ivec(m, CHOSEN), ivec(m, TRIAL)
    count = 0
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 1 and mode[n] != OFF:
            chosen[count], trial[count] = n, mode[n]
            count += 1
    return count


@compiled
def settle(m, t, y, who):
    """Bring y onto the constraints and onto its lasting contacts, positions and rates; leaves rows and factor.

    who: a contact that hits now (or -1); it and all that are as near come onto their walls too, with their rates.
    """
    project(m, t, y)
    touch_all(m)
    count = held_contacts(m)
    closed = add_hitting(m, count, who)
    if closed == 0:
        return
    chosen, trial, side, touch, clock = ivec(m, CHOSEN), ivec(m, TRIAL), mat(m, SIDE), mat(m, TOUCH), vec(m, CLOCK)
    direction, nq = mat(m, DIRECTION), vec(m, CHANGE).shape[0]
    q, v = y[:nq], y[nq : 2 * nq]
    for attempt in range(4):
        worst = 0.0
        for k in range(closed):
            worst = max(worst, abs(touch[chosen[k], GAP]))
        if worst < 1e-16 * vec(m, HELD)[SIZE] or attempt == 3:
            clock[DRIFT] = max(clock[DRIFT], worst)
            break
        contact_rows(m, closed)
        for k in range(closed):
            side[B, 2 * k] = -touch[chosen[k], GAP]
            trial[k] = FORWARD
        solve_modes(m, closed, 0)
        for k in range(closed):
            for c in range(nq):
                q[c] += direction[2 * k, c] * side[F, 2 * k]
        project(m, t, y)
        touch_all(m)
    contact_rows(m, count)
    for k in range(count):
        n = chosen[k]
        side[B, 2 * k], side[B, 2 * k + 1] = touch[n, DGAP], -touch[n, SLIP]
        trial[k] = STICK if ivec(m, MODE)[n] == STICK else FORWARD
    solve_modes(m, count, 0)
    for r in range(2 * count):
        for c in range(nq):
            v[c] -= direction[r, c] * side[F, r]
    place(m, q, v)
    constraints(m)
    touch_all(m)


@compiled
def add_hitting(m, count, who):
    """Choose contact `who` and all free ones as near to their walls after the `count` lasting ones; returns how many."""
    contact, mode, touch, chosen = imat(m, CONTACT), ivec(m, MODE), mat(m, TOUCH), ivec(m, CHOSEN)
    closed = count
    for n in range(contact.shape[0]):
        if who < 0 or contact[n, IMPACT] == 0 or mode[n] != OFF:
            continue
        if n == who or abs(touch[n, GAP]) <= NEAR * clearance_of(m, n):
            chosen[closed] = n
            closed += 1
    return closed


@compiled
def note(m, kind, n, t, y, speed, peak, impulse, lost):
    """Write one event row; a contact that ends says what it was from its memory."""
    tally, events = ivec(m, TALLY), mat(m, EVENTS)
    if tally[EVENT_COUNT] == events.shape[0]:
        return
    event = events[tally[EVENT_COUNT]]
    for k in range(8):
        event[k] = 0.0
    event[0], event[1], event[2], event[3] = t, n, kind, speed
    event[5], event[6], event[7] = peak, impulse, lost
    if kind == CONTACT_EVENT:
        grip, k = mat(m, GRIP)[n], y.shape[0] - 4 * mat(m, GRIP).shape[0] + 4 * n
        event[0], event[3], event[4], event[5] = grip[SINCE], grip[SPEED], max(t - grip[SINCE], 0.0), grip[PEAK]
        event[6], event[7] = y[k + 1] - grip[IMPULSE_0], y[k + 2] - grip[LOSS_0]
    tally[EVENT_COUNT] += 1


@compiled
def motion_without(m, t, y):
    """Everything at y but without forces of lasting contacts."""
    nq = vec(m, CHANGE).shape[0]
    place(m, y[:nq], y[nq : 2 * nq])
    drive(m, t)
    constraints(m)
    loads(m, t)
    factorise(m)
    accelerate(m)


@compiled
def regroup(m, t, y, apart, kind):
    """Modes of all closed contacts from the problem for the accelerations; `apart` is the contact of the event, or -1.

    A contact that has just let go or broken away keeps to that unless the others then press it back.
    Returns OK, NO_SOLUTION or NOT_UNIQUE.
    """
    contact, touch, mode, body = imat(m, CONTACT), mat(m, TOUCH), ivec(m, MODE), mat(m, BODY)
    chosen, trial, slide = ivec(m, CHOSEN), ivec(m, TRIAL), ivec(m, SLIDE)
    grip, pulling = mat(m, GRIP), touch[apart, TANGENT] if apart >= 0 else 0.0
    motion_without(m, t, y)
    for attempt in range(2):
        count = 0
        for n in range(contact.shape[0]):
            if contact[n, IMPACT] == 0 or (attempt == 0 and n == apart and kind == LET_GO):
                continue
            if mode[n] != OFF or n == apart or touch[n, GAP] <= NEAR * clearance_of(m, n):
                chosen[count] = n
                count += 1
        contact_rows(m, count)
        closed = 0
        for k in range(count):
            n = chosen[k]
            kept = mode[n] != OFF and kind != HIT
            if kept or at_rest(m, 2 * k, n, along(m, 2 * k, n, body, VX), grip[n, N_1]):
                chosen[closed] = n
                u = along(m, 2 * k + 1, n, body, VX)
                slide[closed] = 0
                still = (kept and mode[n] == STICK) or (n == apart and kind == TURN)
                if not still and not at_rest(m, 2 * k + 1, n, u, grip[n, N_1]):
                    slide[closed] = 1 if u > 0.0 else -1
                if n == apart and kind == BREAK_AWAY:
                    slide[closed] = 1 if pulling > 0.0 else -1
                elif kind == BREAK_AWAY and kept and mode[n] != STICK:  # it had reached its limit before: goes along
                    slide[closed] = 1 if mode[n] == FORWARD else -1
                trial[closed] = mode[n]
                if mode[n] == OFF or slide[closed] != 0:
                    trial[closed] = FORWARD if slide[closed] >= 0 else BACKWARD
                closed += 1
        if closed < count:
            contact_rows(m, closed)
        lasting_side(m, closed)
        if not solve_contacts(m, closed):
            return NO_SOLUTION
        if is_rough(m, closed) and count_solutions(m, closed) > 1:
            return NOT_UNIQUE
        if kind != LET_GO or attempt == 1:
            break
        # the contact that let go: is its gap going to open?
        add_forces(m, closed, mat(m, ACCELERATION), vec(m, MULTIPLIER))
        contact_rows_of_one(m, closed, apart)
        opening = touch[apart, GAMMA_N] - along(m, 2 * closed, apart, mat(m, ACCELERATION), 0)
        if opening >= -1e-9 * (abs(touch[apart, GAMMA_N]) + largest_acceleration(m)):
            break
        motion_without(m, t, y)
    change_modes(m, t, y, closed)
    return OK


@compiled
def contact_rows_of_one(m, k, n):
    """Put contact n after k chosen ones, with its rows."""
    ivec(m, CHOSEN)[k] = n
    contact_rows(m, k + 1)


@compiled
def largest_acceleration(m):
    """Largest acceleration of a mass centre along x or y [m/s^2]."""
    acceleration = mat(m, ACCELERATION)
    total = 0.0
    for i in range(1, acceleration.shape[0]):
        total = max(total, abs(acceleration[i, 0]), abs(acceleration[i, 1]))
    return total


@compiled
def at_rest(m, r, n, u, before):
    """True when the velocity u of line r of contact n is rounding; before: size of its terms before an impact [m/s]."""
    return abs(u) <= STILL * max(swing(m, r, n), before) + 1e-14 * vec(m, HELD)[SIZE]


@compiled
def change_modes(m, t, y, count):
    """Take over the modes in `trial` of the chosen contacts (all others are off) and note what has changed."""
    contact, mode, grip = imat(m, CONTACT), ivec(m, MODE), mat(m, GRIP)
    chosen, trial, side = ivec(m, CHOSEN), ivec(m, TRIAL), mat(m, SIDE)
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 0:
            continue
        new, pressed = OFF, 0.0
        for k in range(count):
            if chosen[k] == n:
                new, pressed = trial[k], side[F, 2 * k]
        old = mode[n]
        k = y.shape[0] - 4 * grip.shape[0] + 4 * n
        if old == OFF and new != OFF:
            grip[n, CLOSED], grip[n, SINCE], grip[n, PEAK] = SHUT, max(t, grip[n, STEPS_IN]), pressed
            grip[n, IMPULSE_0], grip[n, LOSS_0] = y[k + 1], y[k + 2]
        if old != OFF and new == OFF:
            note(m, CONTACT_EVENT, n, t, y, 0.0, 0.0, 0.0, 0.0)
            note(m, RELEASE_EVENT, n, t, y, 0.0, 0.0, 0.0, 0.0)
            grip[n, CLOSED], grip[n, SPEED] = OPEN, 0.0
        if friction_of(m, n) > 0.0 and new != OFF and new != old:
            if new == STICK:
                note(m, STICK_EVENT, n, t, y, 0.0, 0.0, 0.0, 0.0)
            elif old != OFF:
                note(m, SLIP_EVENT, n, t, y, 0.0, 0.0, 0.0, 0.0)
        mode[n] = new
        grip[n, STEPS_IN] = 0.0


@compiled
def collide(m, t, y, who):
    """Impact at (t, y): contact `who` and all others that are closed, in one problem; rates in y jump.

    Bounces that are too low to follow are closed (restitution 0).  Returns OK, NO_SOLUTION or NOT_UNIQUE.
    """
    contact, touch, mode, grip, values = imat(m, CONTACT), mat(m, TOUCH), ivec(m, MODE), mat(m, GRIP), vec(m, VALUES)
    chosen, trial, slide, side = ivec(m, CHOSEN), ivec(m, TRIAL), ivec(m, SLIDE), mat(m, SIDE)
    direction, nq = mat(m, DIRECTION), vec(m, CHANGE).shape[0]
    v, before = y[nq : 2 * nq], vec(m, RATE_NEW)
    count = 0
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 1 and (n == who or mode[n] != OFF or touch[n, GAP] <= NEAR * clearance_of(m, n)):
            chosen[count] = n
            grip[n, STEPS_IN], grip[n, N_1] = 0.0, 0.0
            count += 1
    for c in range(nq):
        before[c] = v[c]
    for _ in range(count + 1):
        contact_rows(m, count)
        for k in range(count):
            n, p = chosen[k], contact[chosen[k], NORMAL_P]
            grip[n, N_1] = max(swing(m, 2 * k, n), swing(m, 2 * k + 1, n))
            hits = touch[n, DGAP] < -STILL * grip[n, N_1]
            e = values[p] if hits and grip[n, STEPS_IN] == 0.0 else 0.0
            side[B, 2 * k] = (1.0 + e) * touch[n, DGAP]
            side[B, 2 * k + 1] = -(1.0 + (values[p + 1] if hits else 0.0)) * touch[n, SLIP]
            slide[k] = 0
            trial[k] = STICK if friction_of(m, n) > 0.0 else FORWARD
        if not solve_contacts(m, count):
            return NO_SOLUTION
        if is_rough(m, count) and count_solutions(m, count) > 1:
            return NOT_UNIQUE
        for r in range(2 * count):
            for c in range(nq):
                v[c] -= direction[r, c] * side[F, r]
        if not low_bounce(m, t, y, count):
            break
        for c in range(nq):
            v[c] = before[c]
        motion_without(m, t, y)
    # rows and touch belong to the rates before the impact again, to tell what it did
    settle_accounts(m, t, y, count, before)
    return OK


@compiled
def low_bounce(m, t, y, count):
    """Mark hitting contacts whose bounce would be too low to follow; True when there is a new one."""
    touch, grip, chosen, side = mat(m, TOUCH), mat(m, GRIP), ivec(m, CHOSEN), mat(m, SIDE)
    values, contact, mode, trial = vec(m, VALUES), imat(m, CONTACT), ivec(m, MODE), ivec(m, TRIAL)
    found = False
    motion_without(m, t, y)
    for r in range(2 * count):
        side[OTHER, r] = side[F, r]
    for k in range(count):
        trial[k] = mode[chosen[k]]
    lasting_side(m, count)
    solve_modes(m, count, 1)
    add_forces(m, count, mat(m, ACCELERATION), vec(m, MULTIPLIER))
    for r in range(2 * count):
        side[F, r] = side[OTHER, r]
    for k in range(count):
        n = chosen[k]
        speed, e = touch[n, DGAP], values[contact[n, NORMAL_P]]
        if side[F, 2 * k] <= 0.0 or grip[n, STEPS_IN] != 0.0 or speed <= STILL * swing(m, 2 * k, n):
            continue
        pull = touch[n, GAMMA_N] - along(m, 2 * k, n, mat(m, ACCELERATION), 0)
        least = max(LOW * clearance_of(m, n), 4e-15 * vec(m, HELD)[SIZE])
        if pull < 0.0 and speed * speed < -2.0 * pull * least:
            grip[n, STEPS_IN] = t + (2.0 * speed / (-pull * (1.0 - e)) if e < 1.0 else 0.0)
            found = True
    return found


@compiled
def settle_accounts(m, t, y, count, before):
    """Impulses, losses and work of an impact into y, and its events; v in y is after, `before` (3 nb,) is before."""
    touch, grip, chosen, side, rows = mat(m, TOUCH), mat(m, GRIP), ivec(m, CHOSEN), mat(m, SIDE), mat(m, ROWS)
    multiplier, work, nq = vec(m, MULTIPLIER), 0.0, vec(m, CHANGE).shape[0]
    place(m, y[:nq], before[:nq])
    constraints(m)
    touch_all(m)
    for row in range(multiplier.shape[0]):
        multiplier[row] = 0.0
    acceleration = mat(m, ACCELERATION)
    add_forces(m, count, acceleration, multiplier)
    for row in range(multiplier.shape[0]):
        work -= multiplier[row] * rows[row, NU]
    y[2 * nq] += work
    for k in range(count):
        n = chosen[k]
        grip[n, GAP_1], grip[n, DGAP_1] = touch[n, DGAP], touch[n, SLIP]
    place(m, y[:nq], y[nq : 2 * nq])
    constraints(m)
    touch_all(m)
    for k in range(count):
        n = chosen[k]
        pressed, held = side[F, 2 * k], side[F, 2 * k + 1]
        if pressed == 0.0 and held == 0.0:
            continue
        lost = 0.5 * (held * (grip[n, DGAP_1] + touch[n, SLIP]) - pressed * (grip[n, GAP_1] + touch[n, DGAP]))
        j = y.shape[0] - 4 * grip.shape[0] + 4 * n
        y[j + 1] += pressed
        y[j + 2] += lost
        grip[n, SPEED] = max(-grip[n, GAP_1], 0.0)
        note(m, IMPACT_EVENT, n, t, y, grip[n, SPEED], 0.0, pressed, lost)


@compiled
def at_share(m, t, h, theta, full):
    """State at the share theta of the step: contacts alone, or with all forces."""
    stage, nq = vec(m, STAGE), vec(m, CHANGE).shape[0]
    interpolate(m, theta, stage)
    if full:
        solve_motion(m, t + theta * h, stage[:nq], stage[nq : 2 * nq])
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


@compiled
def remember(m):
    """Keep gaps and their rates: the start of the next step."""
    touch, grip = mat(m, TOUCH), mat(m, GRIP)
    for n in range(touch.shape[0]):
        grip[n, GAP_0], grip[n, DGAP_0] = touch[n, GAP], touch[n, DGAP]


@compiled
def happen(m, t, y, who, what):
    """Event at (t, y): impact if contacts hit, then new modes; leaves y on its constraints. Returns a status."""
    if what != HIT:
        nq = vec(m, CHANGE).shape[0]
        settle(m, t, y, -1)
        solve_motion(m, t, y[:nq], y[nq : 2 * nq])
        status = regroup(m, t, y, who, what)
    else:
        settle(m, t, y, who)
        status = collide(m, t, y, who)
        if status == OK:
            status = regroup(m, t, y, -1, HIT)
    if status == OK:
        settle(m, t, y, -1)
    return status


@compiled
def start(m, t):
    """Modes at the start of a run: contacts that are closed and hit take their impact at once. Returns a status."""
    contact, touch, y = imat(m, CONTACT), mat(m, TOUCH), vec(m, STATE)
    settle(m, t, y, -1)
    for n in range(contact.shape[0]):
        near = max(NEAR * clearance_of(m, n), 4.0 * noise(m, n))
        if contact[n, IMPACT] == 1 and touch[n, GAP] <= near and touch[n, DGAP] < 0.0:
            status = collide(m, t, y, n)
            if status != OK:
                return status
            break
    status = regroup(m, t, y, -1, NOTHING)
    settle(m, t, y, -1)
    remember(m)
    return status


@compiled
def write_until(m, t, h, t_until, t_out, out):
    """Outputs of the step from t of length h up to t_until; the dense output is ready."""
    tally, stage = ivec(m, TALLY), vec(m, STAGE)
    while tally[OUTPUTS] < t_out.shape[0] and t_out[tally[OUTPUTS]] <= t_until:
        k = tally[OUTPUTS]
        interpolate(m, (t_out[k] - t) / h, stage)
        settle(m, t_out[k], stage, -1)
        record(m, t_out[k], stage, out[k])
        tally[OUTPUTS] = k + 1


@compiled
def advance(m, t_end, rtol, atol, h_max, t_out, out, most_steps, stuck):
    """Take up to `most_steps` steps towards t_end, each to the next event at most; writes outputs on the way.

    stuck (3,): time of the last event, events at that time so far, contact of the last event.
    Returns DONE, PAUSED, STEP_TOO_SMALL, NO_SOLUTION, NOT_UNIQUE, LOCKED or CHATTER.
    """
    y, f, y_new, f_new = vec(m, STATE), vec(m, RATE), vec(m, STATE_NEW), vec(m, RATE_NEW)
    clock, tally, touch, grip = vec(m, CLOCK), ivec(m, TALLY), mat(m, TOUCH), mat(m, GRIP)
    begun, most_found = tally[STEPS], mat(m, EVENTS).shape[0] // 2
    while tally[STEPS] < begun + most_steps and tally[EVENT_COUNT] < most_found:
        t, h = clock[T], clock[H]
        if t >= t_end:
            return DONE
        last = t + 1.000001 * h >= t_end
        if last:
            h = t_end - t
        if h <= 1e-15 * abs(t) or h <= 1e-16 * t_end or t + h == t:
            return STEP_TOO_SMALL
        vec(m, POWER)[3] = 1.0
        vec(m, HELD)[DETERMINANT] = 1.0
        error, _ = step_dop853(m, t, h, rtol, atol, 0)
        tally[EVALUATIONS] += 12
        if not error <= 1.0:
            tally[REJECTED] += 1
            clock[TROUBLE] = t + h
            clock[H] = h * (max(0.2, 0.9 * error ** (-0.125)) if error < math.inf else 0.1)
            continue
        clock[H] = min(h_max, h * (6.0 if error < 1e-7 else min(6.0, 0.9 * error ** (-0.125))))
        t_new = t_end if last else t + h
        settle(m, t_new, y_new, -1)
        derivative(m, t_new, y_new, f_new)
        for n in range(touch.shape[0]):
            grip[n, GAP_1], grip[n, DGAP_1] = touch[n, GAP], touch[n, DGAP]
        prepare_dense(m, t, t_new - t, 0)
        share, who, what = first_event(m, t, t_new - t)
        t_until = t + share * (t_new - t) if who >= 0 else t_new
        write_until(m, t, t_new - t, t_until, t_out, out)
        if who >= 0:
            interpolate(m, share, y_new)
            again = t_until - stuck[0] <= 1e-14 * t_end
            stuck[1] = stuck[1] + 1.0 if again else 0.0
            stuck[0] = stuck[0] if again else t_until
            stuck[2] = who
            status = CHATTER if stuck[1] > MOST_AT_ONCE else happen(m, t_until, y_new, who, what)
            if status != OK:
                clock[T] = t_until
                return status
            clock[H] = max(clock[H], h)
        derivative(m, t_until, y_new, f_new)
        tally[EVALUATIONS] += 5 + PARTS
        remember(m)
        for n in range(y.shape[0]):
            y[n] = y_new[n]
            f[n] = f_new[n]
        clock[T] = t_until
        clock[H_MIN] = min(clock[H_MIN], t_until - t) if who < 0 else clock[H_MIN]
        tally[STEPS] += 1
        if vec(m, HELD)[DETERMINANT] < 0.0:
            return LOCKED
    return DONE if clock[T] >= t_end else PAUSED
