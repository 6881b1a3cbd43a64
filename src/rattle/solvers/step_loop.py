"""Time integration loop: steps, projection onto the constraints, outputs and located changes of sign.

One compiled call takes many steps; it returns when done, when it cannot go on, or after a number of
steps so that the caller can show progress and be interrupted.
"""

from __future__ import annotations

import math

from rattle.equations.motion import (
    DONE,
    NOT_FINITE,
    OK,
    PAUSED,
    STEP_TOO_SMALL,
    accelerate,
    collect,
    derivative,
    loads,
)
from rattle.equations.schur import WEAK
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers import step_audit
from rattle.solvers.contact_events import (
    change_contacts,
    contact_time,
    find_peaks,
    first_change,
    interpolate,
    may_any_change,
    near_peak,
    pass_on,
    remember_end,
    start_contacts,
)
from rattle.solvers.gap_search import ESCAPED, NONE, escaped
from rattle.solvers.output_row import record
from rattle.solvers.peaks.samples import END, START, end_step, gauge, may_rise
from rattle.solvers.projection import project
from rattle.solvers.sign_watch import cross_at_once, find_crossings, watched_change
from rattle.solvers.state_switches import GO_ON, LANDS, REPEAT, SLIDES, arrive, crossed, land, release
from rattle.solvers.step_audit import UNSOUND, stands
from rattle.solvers.step_state import (
    CONTACTS,
    EVALUATIONS,
    EVENT_COUNT,
    FEWEST,
    FOUND,
    H_FREE,
    H_MIN,
    H_SOUND,
    LEAPS,
    LOST,
    OUTPUTS,
    REJECTED,
    SHARE,
    STEPS,
    STREAK,
    TAME,
    TROUBLE,
    H,
    T,
)
from rattle.solvers.steppers import dop853, rk4
from rattle.solvers.steppers.dop853 import prepare_dense as prepare_dop853
from rattle.solvers.steppers.dop853 import step as step_dop853
from rattle.solvers.steppers.rk4 import prepare_dense as prepare_rk4
from rattle.solvers.steppers.rk4 import step as step_rk4

METHODS = {"dop853": 0, "rk4": 1}
ORDERS = {"dop853": dop853.ORDER, "rk4": rk4.ORDER}
LEAP = 0.1  # share of the last sound step below which a step is not cut further at a singular position
LEAP_ERROR = 1e-8  # error of such a step that is let pass [units of the state]; it doubles with every try
MOST_TRIES = 20
SHORT = 1e-9  # share of the time ahead down to which a step that does not stand is tried again, shorter
FIRST_STEP = 0.01  # first step in a contact as a share of how long it will last: its force starts like a broken power


@compiled
def prepare_dense(m, t, h, method):
    """Make the dense output of the step from (t, y) to (t + h, y_new)."""
    y, f, y_new, f_new, dense = m.state, m.rate, m.state_new, m.rate_new, m.dense
    for n in range(y.shape[0]):
        jump = y_new[n] - y[n]
        dense[0, n] = jump
        dense[1, n] = h * f[n] - jump
        dense[2, n] = 2.0 * jump - h * (f_new[n] + f[n])
    if method == 0:
        prepare_dop853(m, t, h)
    else:
        prepare_rk4(m)


@native("void", "h", "f")
def resume(m, t):
    """Go on from (t, y) where the right-hand side has changed: its derivative, contacts and signs as from now on."""
    y, f = m.state, m.rate
    derivative(m, t, y, f)
    remember_end(m)
    pass_on(m)
    cross_at_once(m, t)
    gauge(m, START, t)


@native("i", "h", "f", "f", "f", "f", "f")
def begin(m, t, t_end, rtol, atol, h_max):
    """Derivative at the start, signs of the watched forces, a first step size."""
    y, f, stage, k1 = m.state, m.rate, m.stage, m.slopes[1]
    clock, tally = m.clock, m.tally
    sign, watch, multiplier = m.sign, m.watch, m.multiplier
    clock[T] = t
    if m.contact.shape[0] > 0:
        start_contacts(m, t, y)
    tally[LOST] = derivative(m, t, y, f)
    gauge(m, START, t)
    remember_end(m)
    pass_on(m)
    for n in range(watch.shape[0]):
        sign[n] = -1.0 if multiplier[watch[n]] < 0.0 else 1.0
    ny = 2 * m.change.shape[0]
    size, slope = 0.0, 0.0
    for n in range(ny):
        scale = atol + rtol * abs(y[n])
        size += (y[n] / scale) ** 2
        slope += (f[n] / scale) ** 2
    if not slope < math.inf:
        return NOT_FINITE
    m.audit[step_audit.STARTED] = 0.0
    stands(m, y)
    h = 0.01 * math.sqrt(size / slope) if size > 1e-10 and slope > 1e-10 else 1e-6
    h = min(h, h_max, t_end - t)
    for n in range(y.shape[0]):
        stage[n] = y[n] + h * f[n]
    derivative(m, t + h, stage, k1)
    bend = 0.0
    for n in range(ny):
        bend += ((k1[n] - f[n]) / (atol + rtol * abs(y[n]))) ** 2
    largest = max(math.sqrt(slope), math.sqrt(bend) / h) / math.sqrt(ny)
    second = (0.01 / largest) ** (1.0 / 8.0) if largest > 1e-15 and largest < math.inf else max(1e-6, 1e-3 * h)
    clock[H] = min(100.0 * h, second, h_max, t_end - t)
    tally[EVALUATIONS] = 2
    return OK


@native("i", "h", "f", "v", "v")
def finish_step(m, t, y_new, f_new):
    """Projection and derivative at the end of a step."""
    project(m, t, y_new)
    loads(m, t)
    accelerate(m)
    nq = m.change.shape[0]
    collect(m, y_new[nq : 2 * nq], f_new)
    return 0


@native("i", "h", "f", "f", "i", "i", "v", "m")
def search_step_for_events(m, t, h, changed, method, t_out, out):
    """Contacts, changes of sign and outputs inside the step from (t, y) to (t + h, y_new).

    Returns the contact that starts or ends first (-1 if none does); its share of the step goes to clock[SHARE].
    -2 when a contact is inside its wall at an output though it has not started.
    """
    tally, stage = m.tally, m.stage
    share, who, contacts = NONE, -1, m.contact.shape[0] > 0
    suspect = may_any_change(m, h)
    peak = near_peak(m)
    wanted = tally[OUTPUTS] < t_out.shape[0] and t_out[tally[OUTPUTS]] <= t + h
    dense = suspect or peak or wanted or changed or may_rise(m, h, method)
    if dense:
        prepare_dense(m, t, h, method)
        tally[EVALUATIONS] += 3
    if suspect:
        share, who = first_change(m, h)
    until = min(share, 1.0)
    if contacts:
        find_peaks(m, until, peak)
    tally[EVALUATIONS] += end_step(m, t, h, until, method, dense)
    if changed:
        find_crossings(m, t, h, until)
    t_until = t + until * h if until < 1.0 else t + h
    while tally[OUTPUTS] < t_out.shape[0] and t_out[tally[OUTPUTS]] <= t_until:
        k = tally[OUTPUTS]
        interpolate(m, (t_out[k] - t) / h, stage)
        if contacts and escaped(m, stage):
            m.clock[TROUBLE] = t_out[k]
            return -2
        project(m, t_out[k], stage)
        record(m, t_out[k], stage, out[k])
        tally[OUTPUTS] = k + 1
    m.clock[SHARE] = share
    return who


@native("void", "h", "f", "v", "i")
def turn_contact(m, t, y, who):
    """Contact `who` starts or ends at (t, y): change its memory, note the event, choose a step for what follows."""
    clock, tally, memory = m.clock, m.tally, m.contact_memory
    was_shut = memory[who, at.CLOSED] == at.SHUT
    if was_shut:
        clock[FEWEST] = min(clock[FEWEST], memory[who, at.STEPS_IN])
    else:
        tally[CONTACTS] += 1
        clock[H_FREE] = max(clock[H], 0.5 * clock[H_FREE])
    tally[EVENT_COUNT] = change_contacts(m, who, t, y, tally[EVENT_COUNT])
    finish_step(m, t, y, m.rate_new)
    remember_end(m)
    if was_shut:
        clock[H] = max(clock[H], 0.3 * clock[H_FREE])
    else:
        lasting = contact_time(m, who)
        if lasting > 0.0:
            clock[H] = min(clock[H], FIRST_STEP * lasting)


@compiled
def finite(y):
    """True when all of y is finite."""
    for n in range(y.shape[0]):
        if not abs(y[n]) < math.inf:
            return False
    return True


@native("i", "h", "f", "f", "f", "f", "i", "v", "m", "i")
def advance(m, t_end, rtol, atol, h_max, method, t_out, out, most_steps):
    """Take up to `most_steps` steps towards t_end; writes every output with t_out <= the time reached.

    Next to a singular position a stage slightly off the constraints has a wildly wrong acceleration.  There the
    stages are projected too ("tame" steps).  Cutting the step would only creep closer, so a step well below the
    last sound one leaps across even if its error is above the tolerance.

    Returns DONE, PAUSED, NOT_FINITE, STEP_TOO_SMALL, ESCAPED, UNSOUND or SLIDES.
    """
    y, f, y_new, f_new = m.state, m.rate, m.state_new, m.rate_new
    clock, tally, power, most_found = m.clock, m.tally, m.power, m.crossings.shape[0] // 2
    start = tally[STEPS]
    contacts = m.contact.shape[0] > 0
    landing, switches = m.landing, m.switch.shape[0] > 0
    while tally[STEPS] < start + most_steps and tally[FOUND] < most_found and tally[EVENT_COUNT] < most_found:
        t = clock[T]
        if t >= t_end:
            return DONE
        h = clock[H]
        last = t + (1.000001 if landing[LANDS] == 0.0 else 1.0) * h >= t_end
        if last:
            h = t_end - t
        if h <= 1e-15 * abs(t) or h <= 1e-16 * t_end or t + h == t:
            return STEP_TOO_SMALL
        power[3] = 1.0
        if method == 0:
            error, changed = step_dop853(m, t, h, rtol, atol, tally[TAME])
            tally[EVALUATIONS] += 12
            weak = power[3] < WEAK and h <= LEAP * clock[H_SOUND]
            if weak and error > 1.0 and error * rtol <= LEAP_ERROR * 2.0 ** tally[STREAK]:
                tally[LEAPS] += 1
                error = 1e-8
            if not error <= 1.0:
                tally[REJECTED] += 1
                clock[TROUBLE] = t + h
                landing[LANDS] = 0.0
                if switches and not error < math.inf and release(m):
                    continue
                if power[3] < WEAK and tally[TAME] == 0:
                    tally[TAME] = 1
                    continue
                clock[H] = h * (max(0.2, 0.9 * error ** (-0.125)) if error < math.inf else 0.1)
                if weak and tally[STREAK] < MOST_TRIES:
                    tally[STREAK] += 1
                    clock[H] = LEAP * clock[H_SOUND] * 0.9 ** tally[STREAK]
                continue
            if power[3] > WEAK:
                tally[TAME] = 0
            if not weak:
                tally[STREAK] = 0
                clock[H_SOUND] = max(h, 0.7 * clock[H_SOUND])
            ahead = h * (6.0 if error < 1e-7 else min(6.0, 0.9 * error ** (-0.125)))
            clock[H] = min(h_max, max(ahead, clock[H] if last else 0.0))
        else:
            changed = step_rk4(m, t, h)
            tally[EVALUATIONS] += 4
            if not finite(y_new):
                clock[TROUBLE] = t + h
                landing[LANDS] = 0.0
                if switches and release(m):
                    continue
                return NOT_FINITE
        t_new = t_end if last else t + h
        finish_step(m, t_new, y_new, f_new)
        tally[EVALUATIONS] += 2
        if not stands(m, y_new):
            clock[TROUBLE] = t_new
            landing[LANDS] = 0.0
            if method == 0 and h > SHORT * (t_end - t):
                clock[H] = 0.25 * h
                tally[REJECTED] += 1
                continue
            return UNSOUND
        gauge(m, END, t_new)
        changed |= watched_change(m)
        if contacts:
            remember_end(m)
        if switches and landing[LANDS] == 0.0 and crossed(m):
            prepare_dense(m, t, t_new - t, method)
            verdict, shorter = land(m, t, t_new - t, t_end, clock[H])
            if verdict == SLIDES:
                return SLIDES
            if verdict == REPEAT:
                clock[H] = shorter
                continue
        who = search_step_for_events(m, t, t_new - t, changed, method, t_out, out)
        if who >= 0:
            interpolate(m, clock[SHARE], y_new)
            t_new = t + clock[SHARE] * (t_new - t)
        if who == -2:
            return ESCAPED
        if contacts and escaped(m, y_new):
            clock[TROUBLE] = t_new
            return ESCAPED
        if who >= 0:
            turn_contact(m, t_new, y_new, who)
            gauge(m, START, t_new)
        if switches:
            clock[H] = landing[GO_ON] if landing[LANDS] > 0.0 and who < 0 else clock[H]
            landing[LANDS] = landing[LANDS] if who < 0 else 0.0
            if arrive(m, t_new, y_new, f_new, landing[GO_ON]):
                remember_end(m)
                cross_at_once(m, t_new)
                gauge(m, START, t_new)
        if contacts:
            pass_on(m)
        for n in range(y.shape[0]):
            y[n] = y_new[n]
            f[n] = f_new[n]
        clock[T] = t_new
        clock[H_MIN] = min(clock[H_MIN], t_new - t) if who < 0 else clock[H_MIN]
        tally[STEPS] += 1
    return DONE if clock[T] >= t_end else PAUSED
