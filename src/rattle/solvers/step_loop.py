"""Time integration loop: steps, projection onto the constraints, outputs and located zero crossings.

One compiled call takes many steps; it returns at the end, if it cannot go on, or after a number of
steps, so that the caller can show progress and be interrupted.
"""

from __future__ import annotations

import math

from rattle.equations.dry_friction import add_dry_friction, end_dry_friction
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
from rattle.equations.state import take_states
from rattle.jit import layout as at
from rattle.jit.families import call_stepper
from rattle.jit.functions import compiled, native
from rattle.solvers.breaks import before_break, keeps_breaks, rows_at_end
from rattle.solvers.contacts.contact_events import (
    find_peaks,
    first_change,
    may_any_change,
    near_peak,
    pass_on,
    remember_end,
    start_contacts,
    turn,
)
from rattle.solvers.contacts.gap_search import NONE
from rattle.solvers.contacts.penetration import ESCAPED, escaped
from rattle.solvers.contacts.wear_sum import add_wear
from rattle.solvers.dense_output import interpolate, prepare_dense
from rattle.solvers.output_row import record
from rattle.solvers.peaks.samples import START, end_of, gauge, may_rise, stage_layout
from rattle.solvers.projection import project
from rattle.solvers.sign_watch import cross_at_once, find_crossings, watched_change
from rattle.solvers.singular_passage import (
    come_near,
    comes_or_leaves,
    count_step,
    ends_beside,
    keep_pivots,
    pass_pivots_on,
    passes,
    straddle,
    watch_pivots,
)
from rattle.solvers.step_audit import stands
from rattle.solvers.step_control import (
    SHORT,
    TRY_AGAIN,
    end_on_switch,
    end_stands,
    first_step,
    has_room,
    is_stable,
    largest_rate,
    lengthen,
    next_step,
    output_due,
    quarter,
    refuse,
    shorten,
    take_over,
    turn_switch,
)  # fmt: skip

LEAP = 0.1  # share of the last regular step below which a step is not shortened further at a singular position
LEAP_ERROR = 1e-8  # error of such a step that is accepted [units of the state]; it doubles with every attempt
LAID_ERROR = 1e-6  # the same of a step laid across a singular position: the projection at its end removes most of it
USUAL = 2.0  # such a step is at most so many times as long as the last regular one
ROUNDING_ACROSS = 1e-10  # error [the same] that is accepted while stages are projected: rounding, across the branch
MOST_TRIES = 20


@native("void", "h", "f")
def resume(m, t):
    """Continue from (t, y) after the right-hand side has changed: new derivative, contacts and signs."""
    y, f = m.state, m.rate
    derivative(m, t, y, f)
    m.tally[at.EVALUATIONS] += 1
    remember_end(m)
    pass_on(m)
    cross_at_once(m, t)
    gauge(m, START, t)


@native("i", "h", "f", "f", "f", "f", "f")
def begin(m, t, t_end, rtol, atol, h_max):
    """Derivative at the start, signs of the monitored forces, first step [s]."""
    y, f = m.state, m.rate
    clock, tally = m.clock, m.tally
    sign, watch, multiplier = m.sign, m.watch, m.multiplier
    clock[at.T] = t
    if m.contact.shape[0] > 0 and m.mode.shape[0] == 0:  # the event-driven loop has done so
        start_contacts(m, t, y)
    m.power[at.PIVOT_SHARE] = 1.0
    tally[at.LOST_ROWS] = derivative(m, t, y, f)
    keep_pivots(m, at.SHARE_BEFORE)
    m.passage[at.USUAL_LOST] = tally[at.LOST_ROWS]
    m.passage[at.ROOT_BEFORE] = math.sqrt(m.power[at.PIVOT_SHARE])
    if m.power[at.PIVOT_SHARE] < WEAK:
        come_near(m, t)
    gauge(m, START, t)
    remember_end(m)
    pass_on(m)
    for n in range(watch.shape[0]):
        sign[n] = -1.0 if multiplier[watch[n]] < 0.0 else 1.0
    if not largest_rate(m, f) < math.inf:
        return NOT_FINITE
    m.audit[at.STARTED] = 0.0
    stands(m, y)
    clock[at.H] = first_step(m, t, y, f, min(h_max, t_end - t), rtol, atol)
    return OK


@native("i", "h", "f", "v", "v")
def finish_step(m, t, y_new, f_new):
    """Projection and derivative at the end of a step."""
    project(m, t, y_new)
    take_states(m, y_new)
    loads(m, t)
    accelerate(m)
    if m.dry.shape[0] > 0:
        add_dry_friction(m)
        end_dry_friction(m)
    nq = m.change.shape[0]
    collect(m, y_new[nq : 2 * nq], f_new)
    m.tally[at.EVALUATIONS] += 1
    return 0


@native("i", "h", "f", "f", "i", "i", "v", "m")
def search_step_for_events(m, t, t_new, changed, passed, t_out, out):
    """Contacts, zero crossings and outputs inside the step from (t, y) to (t_new, y_new).

    Returns the contact that starts or ends first (-1 if none does); its share of the step goes to clock[SHARE].
    -2 if an open contact is inside its wall at an output.
    """
    tally, stage, h = m.tally, m.stage, t_new - t
    share, who, contacts = NONE, -1, m.contact.shape[0] > 0
    suspect = may_any_change(m, h)
    peak = m.wear_work.shape[0] == 0 and near_peak(m)
    samples = stage_layout(m)
    dense = suspect or peak or output_due(m, t_new, t_out) or changed or passed == 1 or may_rise(m, h, samples)
    dense = dense or comes_or_leaves(m)
    if dense:
        prepare_dense(m, t, h)
        tally[at.EVALUATIONS] += m.stepper[at.DENSE_STAGES]
    if suspect:
        share, who = first_change(m, h, 1.0)
    until = min(share, 1.0)
    if contacts:
        find_peaks(m, until, peak)
    tally[at.EVALUATIONS] += count_step(m, t, h, until, samples, dense, passed)
    if changed:
        find_crossings(m, t, h, until)
    t_until = t + until * h if until < 1.0 else t_new  # t + h may round to less
    while output_due(m, t_until, t_out):
        k = tally[at.OUTPUTS]
        interpolate(m, (t_out[k] - t) / h, stage)
        if contacts and escaped(m, stage):
            m.clock[at.TROUBLE] = t_out[k]
            return -2
        project(m, t_out[k], stage)
        record(m, t_out[k], stage, out[k])
        tally[at.OUTPUTS] = k + 1
    m.clock[at.CHANGE_AT] = share
    return who


@native("void", "h", "f", "v", "i")
def turn_contact(m, t, y, who):
    """Contact `who` starts or ends at (t, y): change its memory, record the event, choose the next step."""
    turn(m, who, t, y)
    finish_step(m, t, y, m.rate_new)
    remember_end(m)


@compiled
def try_step(m, t, h, last, rtol, atol, h_max):
    """Step from t of length h into y_new; OK, TRY_AGAIN or NOT_FINITE, its error, True if watched signs changed."""
    tally, power, stepper = m.tally, m.power, m.stepper
    power[at.PIVOT_SHARE] = 1.0
    watch_pivots(m)
    error, changed = call_stepper(m.stepper_table[at.STEP], (m, t, h, rtol, atol, tally[at.TAME]))
    tally[at.EVALUATIONS] += stepper[at.STAGES] - 1
    m.passage[at.ROOT_WITHIN] = math.sqrt(power[at.PIVOT_SHARE])
    laid = m.passage[at.TRIED_AT] == t  # across a singular position
    weak = power[at.PIVOT_SHARE] < WEAK and (laid or h <= LEAP * m.clock[at.H_SOUND])
    allowed = LEAP_ERROR * 2.0 ** tally[at.STREAK] if weak else ROUNDING_ACROSS
    if laid and h <= USUAL * m.clock[at.H_SOUND]:  # the motion along the branch is resolved
        allowed = max(allowed, LAID_ERROR)
    if (weak or tally[at.TAME] == 1) and error > 1.0 and error * rtol <= allowed:
        tally[at.LEAPS] += 1
        error = 1e-8
    if not error <= 1.0:
        return step_anew(m, t, h, error, weak), error, changed
    if stepper[at.ADAPTIVE] == 1:
        if power[at.PIVOT_SHARE] > WEAK:
            tally[at.TAME] = 0
        if not weak:
            tally[at.STREAK] = 0
            m.clock[at.H_SOUND] = max(h, 0.7 * m.clock[at.H_SOUND])
        lengthen(m, h, error, last, h_max)
    return OK, error, changed


@compiled
def step_anew(m, t, h, error, weak):
    """After a step with too large an error: TRY_AGAIN with another length, NOT_FINITE if none is left."""
    clock, tally = m.clock, m.tally
    if refuse(m, t, h, error):
        return TRY_AGAIN
    if m.stepper[at.ADAPTIVE] == 0:
        return NOT_FINITE
    if m.power[at.PIVOT_SHARE] < WEAK and straddle(m, t, h) == 1:
        return TRY_AGAIN
    if m.power[at.PIVOT_SHARE] < WEAK and tally[at.TAME] == 0:
        tally[at.TAME] = 1
        return TRY_AGAIN
    shorten(m, h, error)
    if weak and tally[at.STREAK] < MOST_TRIES:
        tally[at.STREAK] += 1
        clock[at.H] = LEAP * clock[at.H_SOUND] * 0.9 ** tally[at.STREAK]
    return TRY_AGAIN


@compiled
def end_on_constraints(m, t, h, t_new, t_end, rtol, atol):
    """Project the end of the step onto the constraints; OK, TRY_AGAIN, UNSOUND or SLIDES, and True as in `try_step`."""
    passage, share = m.passage, m.power[at.PIVOT_SHARE]
    m.power[at.PIVOT_SHARE] = 1.0
    finish_step(m, t_new, m.state_new, m.rate_new)
    passage[at.ROOT_AFTER] = math.sqrt(m.power[at.PIVOT_SHARE])
    keep_pivots(m, at.SHARE_AFTER)
    m.power[at.PIVOT_SHARE] = min(share, m.power[at.PIVOT_SHARE])
    if m.stepper[at.STABLE] > 0 and not is_stable(m, h, rtol, atol):
        m.tally[at.REJECTED] += 1
        m.landing[at.LANDS] = 0.0
        return TRY_AGAIN, False
    status = end_stands(m, t, h, t_new, t_end)
    if status != OK:
        return status, False
    gauge(m, end_of(m), t_new)
    changed = watched_change(m)
    if m.contact.shape[0] > 0:
        remember_end(m)
    return end_on_switch(m, t, t_new - t, t_end, False), changed


@compiled
def start_next(m, t, who):
    """Make the end of a step at t the start of the next; contact `who` (-1: none) and a switch may change there."""
    if who >= 0:
        turn_contact(m, t, m.state_new, who)
        gauge(m, START, t)
    if turn_switch(m, t, who >= 0):
        remember_end(m)
        cross_at_once(m, t)
        gauge(m, START, t)
    if m.contact.shape[0] > 0:
        pass_on(m)
    take_over(m, t, who >= 0)


@compiled
def write_before(m, t, y):
    """Write the row just before an event at (t [s], y), which need not be on the constraints."""
    stage = m.stage
    for n in range(stage.shape[0]):
        stage[n] = y[n]
    project(m, t, stage)
    before_break(m, t, stage)


@native("i", "h", "f", "f", "f", "f", "v", "m", "i")
def advance(m, t_end, rtol, atol, h_max, t_out, out, most_steps):
    """Take up to `most_steps` steps towards t_end [s]; writes every output with t_out [s] <= the time reached.

    Next to a singular position a stage slightly off the constraints has a very wrong acceleration.  There the
    stages are projected too (`tame`).  Shorter steps would only come closer to it, so a step well below the
    last regular one crosses it even if its error is above the tolerance.

    Returns DONE, PAUSED, NOT_FINITE, STEP_TOO_SMALL, ESCAPED, UNSOUND or SLIDES.
    """
    clock, y_new = m.clock, m.state_new
    steps = m.tally[at.STEPS] + most_steps
    while has_room(m, steps):
        t = clock[at.T]
        if t >= t_end:
            return DONE
        h, last = next_step(m, t_end)
        if h == 0.0:
            return STEP_TOO_SMALL
        t_new = t_end if last else t + h
        status, _, changed = try_step(m, t, h, last, rtol, atol, h_max)
        passed = 0
        if status == OK:
            status, at_end = end_on_constraints(m, t, h, t_new, t_end, rtol, atol)
            changed |= at_end
        if status == OK and ends_beside(m, t, t_new - t) == 1:
            continue
        if status == OK:
            passed = passes(m, t, t_new - t, rtol)
            if passed == 0 and m.passage[at.TRIED_AT] == t and m.passage[at.SUSPECTS] > 0.0:
                passed = -1  # laid across what is only nearly singular: to be resolved
            if passed < 0 and h > SHORT * (t_end - t):
                quarter(m, h)
                continue
            passed = max(passed, 0)
        if status == TRY_AGAIN:
            continue
        if status != OK:
            return status
        written = m.tally[at.OUTPUTS]
        who = search_step_for_events(m, t, t_new, changed, passed, t_out, out)
        if who == -2:
            return ESCAPED
        if who >= 0:
            interpolate(m, clock[at.CHANGE_AT], y_new)
            t_new = t + clock[at.CHANGE_AT] * (t_new - t)
        if m.contact.shape[0] > 0 and escaped(m, y_new):
            clock[at.TROUBLE] = t_new
            return ESCAPED
        m.passage[at.ROOT_BEFORE] = m.passage[at.ROOT_AFTER]
        pass_pivots_on(m)
        bends = keeps_breaks(m) and (who >= 0 or m.landing[at.LANDS] > 0.0)
        if bends:
            write_before(m, t_new, y_new)
        start_next(m, t_new, who)
        rows_at_end(m, t_new, bends, written)
        if m.wear_work.shape[0] > 0:
            add_wear(m, t_new - t)
    return DONE if clock[at.T] >= t_end else PAUSED
