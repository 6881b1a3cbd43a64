"""Event-driven motion with set-valued contacts: smooth motion between located events.

Between events every contact keeps its mode (off, sticking, sliding) and closed contacts act as constraints whose
forces `equations.unilateral.closed_contacts` adds.  Each step is searched on its dense output for the first of

    gap = 0                  impact, with all contacts that are closed at that instant in one problem; or a compliant
                             contact starts or ends
    N = 0                    release
    |T| = mu N               stick -> slip
    slip = 0                 slip -> stick, or slip in the other direction, by the problem for the accelerations

Forces of compliant contacts and oil films are smooth ones besides: finite, so that they have no part in impacts.

Impacts and the end of infinite sequences of bounces are in `impacts`, the choice of modes in `contact_modes`, the
search in `event_search`.

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5 to 9.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import FORWARD, OFF, STICK, friction_of
from rattle.equations.motion import DONE, OK, PAUSED, STEP_TOO_SMALL, derivative
from rattle.equations.unilateral import CHATTER, LOCKED
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.breaks import before_break, rows_at_end
from rattle.solvers.contacts.clutches import gets_ahead, takes_impulses
from rattle.solvers.contacts.contact_events import (
    find_peaks,
    may_any_change,
    near_peak,
    remember_end,
    start_contacts,
)
from rattle.solvers.contacts.gap_search import NONE, may_reach, rate_rounding
from rattle.solvers.contacts.pawls import seat_pawls
from rattle.solvers.contacts.penetration import ESCAPED, escaped, inside_wall, scale_of
from rattle.solvers.dense_output import interpolate, prepare_dense
from rattle.solvers.nonsmooth.contact_modes import HIT, MEETS, NOTHING
from rattle.solvers.nonsmooth.contact_projection import noise, project_on_contacts
from rattle.solvers.nonsmooth.event_handling import handle_event, modes_with_friction, remember
from rattle.solvers.nonsmooth.event_search import any_closed, first_event
from rattle.solvers.output_row import record
from rattle.solvers.peaks.climb import end_step
from rattle.solvers.peaks.glances import doubts, keep_forces, last_look, pass_look_on
from rattle.solvers.peaks.samples import LOOKS, START, end_of, gauge, stage_layout, stages_tell
from rattle.solvers.peaks.stage_peaks import end_by_stages
from rattle.solvers.projection import project
from rattle.solvers.sign_watch import cross_at_once, find_crossings, watched_change
from rattle.solvers.singular_passage import (
    AWAY,
    NEAR,
    count_step,
    ends_beside,
    keep_pivots,
    pass_pivots_on,
    passes,
    root_at,
    suspect_pivots,
)
from rattle.solvers.step_control import (
    SHORT,
    TRY_AGAIN,
    end_on_switch,
    end_stands,
    first_step,
    has_room,
    is_stable,
    never_switches,
    next_step,
    output_due,
    quarter,
    take_over,
    turn_switch,
)  # fmt: skip
from rattle.solvers.step_loop import try_step

START_NEAR = 1e-6  # share of its scale within which a contact given at its wall is put there
MOST_AT_ONCE = 60  # events without progress in time after which a run stops
MOST_IN_A_ROW = 200_000  # events, each after less than CROWDED of the run, after which it stops too
CROWDED = 1e-6


@native("i", "h", "f")
def start(m, t):
    """Modes at the start of a run: closed contacts that approach have their impact at once. Returns a status."""
    contact, kinematics, mode, y = m.contact, m.contact_kinematics, m.mode, m.state
    project(m, t, y)
    start_contacts(m, t, y)
    seat_pawls(m, True)
    who, nearest = -1, -1
    for n in range(contact.shape[0]):
        if m.contact_memory[n, at.CLOSED] == at.AUTO:
            m.contact_memory[n, at.CLOSED] = at.OPEN
        if contact[n, at.LEVEL] == 1:
            who = n if contact[n, at.IMPACT] == 1 and takes_impulses(m, n) and gets_ahead(m, n) else who
            continue
        near = max(START_NEAR * scale_of(m, n), 4.0 * noise(m, n))
        if contact[n, at.IMPACT] == 0 or mode[n] != OFF or kinematics[n, at.GAP] > near:
            continue
        if nearest < 0 or kinematics[n, at.GAP] < kinematics[nearest, at.GAP]:
            nearest = n
        if kinematics[n, at.DGAP] < -rate_rounding(m, n):
            who = n
            break
    if who < 0:
        project_on_contacts(m, t, y, nearest)
    status = handle_event(m, t, y, who, NOTHING)
    remember(m)
    return status


@native("i", "h", "f", "i")
def go_on(m, t, jolted):
    """Modes after expressions have switched at t; jolted: rates have jumped, contacts may open. Returns a status."""
    y = m.state
    if jolted == 0:
        status = handle_event(m, t, y, -1, NOTHING)
    else:
        status = modes_with_friction(m, t, y, -1, HIT)
    remember(m)
    return status


@compiled
def write_until(m, t, h, t_until, t_out, out):
    """Write outputs of the step from t of length h up to t_until [s]; needs the dense output. False if a contact
    escaped."""
    tally, stage = m.tally, m.stage
    while output_due(m, t_until, t_out):
        k = tally[at.OUTPUTS]
        interpolate(m, (t_out[k] - t) / h, stage)
        if escaped(m, stage):
            m.clock[at.TROUBLE] = t_out[k]
            return False
        project_on_contacts(m, t_out[k], stage, -1)
        record(m, t_out[k], stage, out[k])
        tally[at.OUTPUTS] = k + 1
    return True


@compiled
def none_may_hit(m, h):
    """True if no open contact can reach its wall in the step of length h [s], and no compliant one can start or end,
    or reach its largest force."""
    contact, mode = m.contact, m.mode
    if may_any_change(m, h) or near_peak(m):
        return False
    for n in range(contact.shape[0]):
        gap = contact[n, at.IMPACT] == 1 and mode[n] == OFF and contact[n, at.LEVEL] == 0
        if contact[n, at.TOOTHED] == 1:
            return False
        if gap and may_reach(m, h, n, 1.0):
            return False
    return True


@compiled
def note_lock(m, t):
    """Record how near friction has come to locking a sliding contact, from G of the motion just computed at t [s]."""
    contact, mode, delassus, held, k = m.contact, m.mode, m.delassus, m.held, 0
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] != 1 or mode[n] == OFF:
            continue
        r = 2 * k
        k += 1
        friction = friction_of(m, n)
        if mode[n] == STICK or friction == 0.0 or held[at.SPARSE] == 1.0 or not delassus[r, r] > 0.0:
            continue
        sense = 1.0 if mode[n] == FORWARD else -1.0
        share = 1.0 + sense * friction * delassus[r, r + 1] / delassus[r, r]
        if share < held[at.LOCK_SHARE]:
            held[at.LOCK_SHARE], held[at.LOCK_AT], held[at.LOCK_CONTACT] = share, t, float(n)


@compiled
def end_on_contacts(m, t, h, t_new, t_end, rtol, atol):
    """Project the end of the step onto joints and closed contacts; a status, and True as in `try_step`."""
    y_new = m.state_new
    project_on_contacts(m, t_new, y_new, -1)
    m.power[at.PIVOT_SHARE] = 1.0
    derivative(m, t_new, y_new, m.rate_new)
    m.passage[at.ROOT_AFTER] = math.sqrt(m.power[at.PIVOT_SHARE])
    keep_pivots(m, at.SHARE_AFTER)
    if m.stepper[at.STABLE] > 0 and not is_stable(m, h, rtol, atol):
        m.tally[at.REJECTED] += 1
        m.landing[at.LANDS] = 0.0
        return TRY_AGAIN, False
    status = end_stands(m, t, h, t_new, t_end)
    if status != OK:
        return status, False
    note_lock(m, t_new)
    gauge(m, end_of(m), t_new)
    remember_end(m)
    return OK, watched_change(m)


@compiled
def in_doubt(m, error):
    """`doubts` from the stages, if they are so many that they can decide."""
    if stages_tell(m):
        return doubts(m, error)
    return (0 if any_closed(m) else last_look(m)), last_look(m)


@compiled
def search_step(m, t, h, low, high, calm):
    """The first event in the step, see `first_event`; calm: there is none.

    Returns its share of the step, the contact (-1: none), its kind, and whether the stages have shown all events.
    """
    if calm:
        keep_forces(m)
        return NONE, -1, NOTHING, stages_tell(m)
    return first_event(m, t, h, low, high)


@compiled
def comes_near(m):
    """True if a step comes near a singular position, or begins there: forces may grow without bound."""
    passage = m.passage
    return min(passage[at.ROOT_WITHIN], passage[at.ROOT_AFTER]) < NEAR or passage[at.NEARBY] != AWAY


@compiled
def sum_step(m, t, h, until, met, by_stages, passed):
    """Peaks and sums of a step with a dense output up to the share `until`; met: there is an event.

    by_stages: the stages have shown all changes of closed contacts.  passed: 1 if it passes a singular position, 0 if
    it comes near one, -1 if it does not.
    """
    if passed >= 0:
        solved = count_step(m, t, h, until, stage_layout(m), 1, passed)
    elif by_stages:
        solved = end_by_stages(m, t, h, until)
    else:
        solved = end_step(m, t, h, until, LOOKS if not met and any_closed(m) else stage_layout(m), 1)
    m.tally[at.EVALUATIONS] += m.stepper[at.DENSE_STAGES] + solved


@compiled
def go_to(m, t, h, until, t_until, met, quiet, changed, t_out, out):
    """Signs and outputs up to t_until, the share `until` of the step from t of length h; the state there into y_new.

    met: an event ends the step there.  quiet: the end of a step that needs no dense output.
    Returns OK, or ESCAPED.
    """
    y_new = m.state_new
    find_peaks(m, until, 0 if quiet else 1)
    if changed:
        find_crossings(m, t, h, until)
    if met:
        interpolate(m, until, y_new)
    if not quiet and not write_until(m, t, h, t_until, t_out, out):
        return ESCAPED
    if met:
        stage = m.stage
        for n in range(stage.shape[0]):
            stage[n] = y_new[n]
        project_on_contacts(m, t_until, stage, -1)
        before_break(m, t_until, stage)
    if inside_wall(m) if quiet else escaped(m, y_new):
        m.clock[at.TROUBLE] = t_until
        return ESCAPED
    return OK


@compiled
def take_event(m, t, h, t_end, who, what):
    """Event of contact `who` at t, in a step of length h; CHATTER if events follow each other without end."""
    stuck = m.stuck
    again = t - stuck[at.EVENT_AT] <= 1e-14 * t_end
    stuck[at.EVENTS_THERE] = stuck[at.EVENTS_THERE] + 1.0 if again else 0.0
    stuck[at.EVENTS_IN_A_ROW] = stuck[at.EVENTS_IN_A_ROW] + 1.0 if t - stuck[at.EVENT_AT] <= CROWDED * t_end else 0.0
    stuck[at.EVENT_AT] = stuck[at.EVENT_AT] if again else t
    stuck[at.EVENT_WHO] = who
    if stuck[at.EVENTS_THERE] > MOST_AT_ONCE or stuck[at.EVENTS_IN_A_ROW] > MOST_IN_A_ROW:
        return CHATTER
    status = handle_event(m, t, m.state_new, who, what)
    if status == OK and what != MEETS:
        m.clock[at.H] = min(max(m.clock[at.H], h), m.clock[at.H_STABLE])
    return status


@compiled
def start_next(m, t, t_end, met, quiet, rtol, atol):
    """Make the end of a step at t, where an event may have occurred, the start of the next."""
    if not quiet:
        if met and m.stepper[at.STABLE] == 0 and t < t_end:  # oil damps what an impact has thrown, at a rate of its own
            derivative(m, t, m.state_new, m.rate_new)
            m.clock[at.H] = min(m.clock[at.H], first_step(m, t, m.state_new, m.rate_new, t_end - t, rtol, atol))
        derivative(m, t, m.state_new, m.rate_new)
        m.tally[at.EVALUATIONS] += 1
        cross_at_once(m, t)
    if met or not never_switches(m):
        gauge(m, START, t)
    else:
        pass_look_on(m)
    m.tally[at.EVALUATIONS] += 1
    remember(m)
    take_over(m, t, met)


@native("i", "h", "f", "f", "f", "f", "v", "m", "i")
def advance(m, t_end, rtol, atol, h_max, t_out, out, most_steps):
    """Take up to `most_steps` steps towards t_end [s], each to the next event at most; writes outputs on the way.

    Returns DONE, PAUSED, STEP_TOO_SMALL, ESCAPED, NO_SOLUTION, NOT_FOUND, NOT_UNIQUE, LOCKED, CHATTER,
    UNSOUND, or SLIDES.
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
        m.held[at.DETERMINANT] = 1.0
        status, error, changed = try_step(m, t, h, last, rtol, atol, h_max)
        if status == OK:
            status, at_end = end_on_contacts(m, t, h, t_new, t_end, rtol, atol)
            changed |= at_end
        if status == TRY_AGAIN:
            continue
        if status != OK:
            return status
        if ends_beside(m, t, t_new - t) == 1:
            continue
        passed = -1
        if comes_near(m) or suspect_pivots(m) > 0.0:
            passed = passes(m, t, t_new - t, rtol)
            if passed < 0 and h > SHORT * (t_end - t):
                m.landing[at.LANDS] = 0.0
                quarter(m, h)
                continue
            passed = 1 if passed == 1 else (0 if comes_near(m) else -1)
        low, high = in_doubt(m, error)
        calm = passed < 0 and low == last_look(m) and not changed and never_switches(m) and none_may_hit(m, t_new - t)
        counted = calm and end_step(m, t, t_new - t, 1.0, stage_layout(m), -1) >= 0  # no peak of a force in it
        quiet = counted and not output_due(m, t_new, t_out)
        if not quiet:
            prepare_dense(m, t, t_new - t)
        status = end_on_switch(m, t, t_new - t, t_end, True)
        if status == TRY_AGAIN:
            continue
        if status != OK:
            return status
        share, who, what, by_stages = search_step(m, t, t_new - t, low, high, calm)
        if share > NONE and h > SHORT * (t_end - t):  # events may be hidden in it
            m.landing[at.LANDS] = 0.0
            quarter(m, h)
            continue
        met, written = who >= 0, m.tally[at.OUTPUTS]
        until, t_until = (share, t + share * (t_new - t)) if met else (1.0, t_new)
        if not counted:
            sum_step(m, t, t_new - t, until, met, by_stages, passed)
        if go_to(m, t, t_new - t, until, t_until, met, quiet, changed, t_out, out) != OK:
            return ESCAPED
        turns = not met and m.landing[at.LANDS] > 0.0
        if turns:
            before_break(m, t_until, y_new)
        if met:
            status = take_event(m, t_until, h, t_end, who, what)
        if status == OK and turn_switch(m, t_until, met):
            status = handle_event(m, t_until, y_new, -1, NOTHING)
        if status != OK:
            clock[at.T] = t_until
            return status
        m.passage[at.ROOT_BEFORE] = root_at(m, t_until, y_new) if met and passed >= 0 else m.passage[at.ROOT_AFTER]
        pass_pivots_on(m)
        start_next(m, t_until, t_end, met, quiet, rtol, atol)
        rows_at_end(m, t_until, met or turns, written)
        if m.held[at.DETERMINANT] < 0.0:
            return LOCKED
    return DONE if clock[at.T] >= t_end else PAUSED
