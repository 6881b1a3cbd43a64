"""Event-driven motion with set-valued contacts: smooth stretches between located events.

Between events every contact keeps its mode (off, sticking, sliding) and lasting contacts act as constraints whose
forces `equations.unilateral.hold` adds.  Each step is searched on its dense output for the first of

    gap = 0                  impact, with all contacts that are closed at that instant in one problem
    N = 0                    release
    |T| = mu N               stick -> slip
    slip = 0                 slip -> stick, or on in the other sense, as the problem for the accelerations says

How impacts are solved and infinite sequences of bounces closed stands in `impacts`, the choice of modes in
`contact_modes`, the search in `event_search`.

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5 to 9.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import OFF, STICK
from rattle.equations.compliant import locate_contacts
from rattle.equations.motion import DONE, OK, PAUSED, STEP_TOO_SMALL, derivative, solve_motion
from rattle.equations.unilateral import CHATTER, DETERMINANT, LOCKED, NOT_FOUND
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.contact_events import interpolate
from rattle.solvers.gap_search import ESCAPED, NONE, clearance_of, escaped, inside_wall, may_reach
from rattle.solvers.nonsmooth.contact_modes import CREEPS, HIT, NOTHING, TURN, update_modes
from rattle.solvers.nonsmooth.contact_projection import NEAR, noise, project_on_contacts
from rattle.solvers.nonsmooth.event_search import any_closed, first_event
from rattle.solvers.nonsmooth.impacts import collide
from rattle.solvers.output_row import record
from rattle.solvers.peaks.glances import END as LAST
from rattle.solvers.peaks.glances import doubts, keep_forces, pass_look_on
from rattle.solvers.peaks.samples import DOP853, END, LOOKS, START, end_step, gauge
from rattle.solvers.peaks.stage_peaks import end_by_stages
from rattle.solvers.projection import project
from rattle.solvers.sign_watch import cross_at_once, find_crossings, watched_change
from rattle.solvers.state_switches import GO_ON, LANDS, REPEAT, SLIDES, arrive, crossed, land, release
from rattle.solvers.step_audit import LENGTH, UNSOUND, stands
from rattle.solvers.step_loop import SHORT, prepare_dense
from rattle.solvers.step_state import EVALUATIONS, EVENT_COUNT, FOUND, H_MIN, OUTPUTS, REJECTED, STEPS, TROUBLE, H, T
from rattle.solvers.steppers.dop853 import step as step_dop853

MOST_AT_ONCE = 60  # events without progress in time after which a run stops
MOST_IN_A_ROW = 200_000  # events, each after less than CROWDED of the run, after which it stops too
CROWDED = 1e-6


@compiled
def remember(m):
    """Keep gaps and their rates: the start of the next step."""
    kinematics, memory = m.contact_kinematics, m.contact_memory
    for n in range(kinematics.shape[0]):
        memory[n, at.GAP_0], memory[n, at.DGAP_0] = kinematics[n, at.GAP], kinematics[n, at.DGAP]


@compiled
def count_shift(m):
    """By how much a located event was beside the joints and walls, from gaps before and after the projection: drift."""
    memory, kinematics, audit = m.contact_memory, m.contact_kinematics, m.audit
    for n in range(memory.shape[0]):
        audit[LENGTH] = max(audit[LENGTH], abs(kinematics[n, at.GAP] - memory[n, at.GAP_1]))


@compiled
def new_modes(m, t, y, who, what):
    """New modes at (t, y) after an event, see `update_modes`; leaves y on its constraints. Returns a status."""
    nq = m.change.shape[0]
    status = update_modes(m, t, y, who, what)
    if status == CREEPS:
        project_on_contacts(m, t, y, -1)
        solve_motion(m, t, y[:nq], y[nq : 2 * nq])
        status = update_modes(m, t, y, who, what)
    if status == OK:
        project_on_contacts(m, t, y, -1)
    return NOT_FOUND if status == CREEPS else status


@native("i", "h", "f", "v", "i", "i")
def handle_event(m, t, y, who, what):
    """Event at (t, y): impact if contacts hit, then new modes; leaves y on its constraints. Returns a status.

    `contact_kinematics` holds the gaps at (t, y).
    what: HIT, LET_GO, BREAK_AWAY or TURN of contact `who`; or NOTHING: a run starts, `who` hits (-1: none does).
    """
    memory, kinematics = m.contact_memory, m.contact_kinematics
    for n in range(memory.shape[0]):
        memory[n, at.GAP_1] = kinematics[n, at.GAP]
    if what == HIT or (what == NOTHING and who >= 0):
        project_on_contacts(m, t, y, who)
        count_shift(m)
        status = collide(m, t, y, who)
        who = -1
        if status != OK:
            return status
    else:
        nq, mode = m.change.shape[0], m.mode
        old = mode[who] if what == TURN else OFF
        if what == TURN:  # at the reversal there is no slip; which sign it takes, the accelerations say
            mode[who] = STICK
        project_on_contacts(m, t, y, -1)
        if what == TURN:
            mode[who] = old
        solve_motion(m, t, y[:nq], y[nq : 2 * nq])
    return new_modes(m, t, y, who, what)


@native("i", "h", "f")
def start(m, t):
    """Modes at the start of a run: contacts that are closed and hit take their impact at once. Returns a status."""
    contact, kinematics, mode, y = m.contact, m.contact_kinematics, m.mode, m.state
    project(m, t, y)
    locate_contacts(m)
    who, nearest = -1, -1
    for n in range(contact.shape[0]):
        near = max(NEAR * clearance_of(m, n), 4.0 * noise(m, n))
        if contact[n, at.IMPACT] == 0 or mode[n] != OFF or kinematics[n, at.GAP] > near:
            continue
        if nearest < 0 or kinematics[n, at.GAP] < kinematics[nearest, at.GAP]:
            nearest = n
        if kinematics[n, at.DGAP] < 0.0:
            who = n
            break
    if who < 0:
        project_on_contacts(m, t, y, nearest)
    status = handle_event(m, t, y, who, NOTHING)
    remember(m)
    return status


@native("i", "h", "f", "i")
def go_on(m, t, jolted):
    """Modes after expressions have switched at t; jolted: rates have jumped, contacts may part. Returns a status."""
    y = m.state
    if jolted == 0:
        status = handle_event(m, t, y, -1, NOTHING)
    else:
        status = new_modes(m, t, y, -1, HIT)
    remember(m)
    return status


@compiled
def write_until(m, t, h, t_until, t_out, out):
    """Outputs of the step from t of length h up to t_until; the dense output is ready. False if a contact escaped."""
    tally, stage = m.tally, m.stage
    while tally[OUTPUTS] < t_out.shape[0] and t_out[tally[OUTPUTS]] <= t_until:
        k = tally[OUTPUTS]
        interpolate(m, (t_out[k] - t) / h, stage)
        if escaped(m, stage):
            m.clock[TROUBLE] = t_out[k]
            return False
        project_on_contacts(m, t_out[k], stage, -1)
        record(m, t_out[k], stage, out[k])
        tally[OUTPUTS] = k + 1
    return True


@compiled
def none_may_hit(m, h):
    """True when no free contact can reach its wall in the step of length h."""
    contact, mode = m.contact, m.mode
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1 and mode[n] == OFF and may_reach(m, h, n, 1.0):
            return False
    return True


@compiled
def finish_step(m, t, h, until, met, by_stages):
    """Peaks and sums of a step with a dense output up to the share `until`; met: an event is there.

    by_stages: lasting contacts have shown at its stages all that they do.
    """
    if by_stages:
        solved = end_by_stages(m, t, h, until)
    else:
        solved = end_step(m, t, h, until, LOOKS if not met and any_closed(m) else DOP853, 1)
    m.tally[EVALUATIONS] += 3 + solved


@native("i", "h", "f", "f", "f", "f", "v", "m", "i", "v")
def advance(m, t_end, rtol, atol, h_max, t_out, out, most_steps, stuck):
    """Take up to `most_steps` steps towards t_end, each to the next event at most; writes outputs on the way.

    stuck (4,): time of the last event, events at that time so far, contact of the last event, events in a row that
    followed each other at once.
    Returns DONE, PAUSED, STEP_TOO_SMALL, ESCAPED, NO_SOLUTION, NOT_FOUND, NOT_UNIQUE, LOCKED, CHATTER,
    UNSOUND, or SLIDES.
    """
    y, f, y_new, f_new = m.state, m.rate, m.state_new, m.rate_new
    clock, tally, kinematics, memory = m.clock, m.tally, m.contact_kinematics, m.contact_memory
    begun, most_found = tally[STEPS], m.events.shape[0] // 2
    landing, switches = m.landing, m.switch.shape[0] > 0
    while tally[STEPS] < begun + most_steps and max(tally[EVENT_COUNT], tally[FOUND]) < most_found:
        t, h = clock[T], clock[H]
        if t >= t_end:
            return DONE
        last = t + (1.000001 if landing[LANDS] == 0.0 else 1.0) * h >= t_end
        if last:
            h = t_end - t
        if h <= 1e-15 * abs(t) or h <= 1e-16 * t_end or t + h == t:
            return STEP_TOO_SMALL
        m.power[3] = 1.0
        m.held[DETERMINANT] = 1.0
        error, changed = step_dop853(m, t, h, rtol, atol, 0)
        tally[EVALUATIONS] += 12
        if not error <= 1.0:
            tally[REJECTED] += 1
            clock[TROUBLE] = t + h
            landing[LANDS] = 0.0
            if switches and not error < math.inf and release(m):
                continue
            clock[H] = h * (max(0.2, 0.9 * error ** (-0.125)) if error < math.inf else 0.1)
            continue
        ahead = h * (6.0 if error < 1e-7 else min(6.0, 0.9 * error ** (-0.125)))
        clock[H] = min(h_max, max(ahead, clock[H] if last else 0.0))
        t_new = t_end if last else t + h
        project_on_contacts(m, t_new, y_new, -1)
        derivative(m, t_new, y_new, f_new)
        if not stands(m, y_new):
            clock[TROUBLE] = t_new
            landing[LANDS] = 0.0
            if h > SHORT * (t_end - t):
                clock[H] = 0.25 * h
                tally[REJECTED] += 1
                continue
            return UNSOUND
        gauge(m, END, t_new)
        changed |= watched_change(m)
        for n in range(kinematics.shape[0]):
            memory[n, at.GAP_1], memory[n, at.DGAP_1] = kinematics[n, at.GAP], kinematics[n, at.DGAP]
        low, high = doubts(m, error)
        calm = low == LAST and not changed and not switches and none_may_hit(m, t_new - t)
        counted = calm and end_step(m, t, t_new - t, 1.0, DOP853, -1) >= 0  # no force has a peak in it
        quiet = counted and not (tally[OUTPUTS] < t_out.shape[0] and t_out[tally[OUTPUTS]] <= t_new)
        if not quiet:
            prepare_dense(m, t, t_new - t, 0)
        if switches and landing[LANDS] == 0.0 and crossed(m):
            verdict, shorter = land(m, t, t_new - t, t_end, clock[H])
            if verdict == SLIDES:
                return SLIDES
            if verdict == REPEAT:
                clock[H] = shorter
                continue
        share, who, what, by_stages = NONE, -1, NOTHING, calm
        if calm:
            keep_forces(m)
        else:
            share, who, what, by_stages = first_event(m, t, t_new - t, low, high)
        if share > NONE and h > SHORT * (t_end - t):
            clock[H], landing[LANDS] = 0.25 * h, 0.0
            tally[REJECTED] += 1
            continue
        t_until = t + share * (t_new - t) if who >= 0 else t_new
        until = share if who >= 0 else 1.0
        if not counted:
            finish_step(m, t, t_new - t, until, who >= 0, by_stages)
        if changed:
            find_crossings(m, t, t_new - t, until)
        if who >= 0:
            interpolate(m, share, y_new)
        if not quiet and not write_until(m, t, t_new - t, t_until, t_out, out):
            return ESCAPED
        if inside_wall(m) if quiet else escaped(m, y_new):
            clock[TROUBLE] = t_until
            return ESCAPED
        if who >= 0:
            again = t_until - stuck[0] <= 1e-14 * t_end
            stuck[1] = stuck[1] + 1.0 if again else 0.0
            stuck[3] = stuck[3] + 1.0 if t_until - stuck[0] <= CROWDED * t_end else 0.0
            stuck[0] = stuck[0] if again else t_until
            stuck[2] = who
            status = CHATTER
            if stuck[1] <= MOST_AT_ONCE and stuck[3] <= MOST_IN_A_ROW:
                status = handle_event(m, t_until, y_new, who, what)
            if status != OK:
                clock[T] = t_until
                return status
            clock[H] = max(clock[H], h)
        if switches:
            clock[H] = landing[GO_ON] if landing[LANDS] > 0.0 and who < 0 else clock[H]
            landing[LANDS] = landing[LANDS] if who < 0 else 0.0
            if arrive(m, t_until, y_new, f_new, landing[GO_ON]):
                status = handle_event(m, t_until, y_new, -1, NOTHING)
                if status != OK:
                    clock[T] = t_until
                    return status
        if not quiet:
            derivative(m, t_until, y_new, f_new)
            tally[EVALUATIONS] += 1
            cross_at_once(m, t_until)
        if who >= 0 or switches:
            gauge(m, START, t_until)
        else:
            pass_look_on(m)
        tally[EVALUATIONS] += 1
        remember(m)
        for n in range(y.shape[0]):
            y[n] = y_new[n]
            f[n] = f_new[n]
        clock[T] = t_until
        clock[H_MIN] = min(clock[H_MIN], t_until - t) if who < 0 else clock[H_MIN]
        tally[STEPS] += 1
        if m.held[DETERMINANT] < 0.0:
            return LOCKED
    return DONE if clock[T] >= t_end else PAUSED
