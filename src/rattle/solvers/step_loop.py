"""The time integration loop: steps, projection onto the constraints, located events, outputs and largest forces.

One compiled call takes many steps; it returns at the end, if it cannot go on, or after a number of steps, so that the
caller can show progress and be interrupted.  Each step is searched on its dense output for the first event: a contact
starts or ends, an expression switches, or what `nonsmooth.event_driven` adds for set-valued contacts.
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
from rattle.equations.unilateral import LOCKED
from rattle.jit import layout as at
from rattle.jit.families import call_stepper
from rattle.jit.functions import compiled, native
from rattle.solvers.breaks import before_break, keeps_breaks, row_within, rows_at_end
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
from rattle.solvers.contacts.penetration import ESCAPED, escaped, inside_wall
from rattle.solvers.contacts.wear_sum import add_wear
from rattle.solvers.dense_output import interpolate, prepare_dense
from rattle.solvers.nonsmooth.contact_modes import MEETS, NOTHING
from rattle.solvers.nonsmooth.contact_projection import project_on_contacts
from rattle.solvers.nonsmooth.event_driven import (
    doubtful,
    first_of_rigid,
    is_rigid,
    none_may_hit,
    note_lock,
    restart,
    take_event,
)
from rattle.solvers.nonsmooth.event_handling import handle_event
from rattle.solvers.nonsmooth.event_search import any_closed
from rattle.solvers.output_row import record
from rattle.solvers.peaks.contact_samples import last_look
from rattle.solvers.peaks.peak_search import end_step
from rattle.solvers.peaks.samples import LOOKS, START, end_of, gauge, stage_layout
from rattle.solvers.peaks.stage_peaks import end_by_stages
from rattle.solvers.projection import project
from rattle.solvers.sign_watch import cross_at_once, find_crossings, watched_change
from rattle.solvers.singular_passage import (
    AWAY,
    NEAR,
    come_near,
    count_step,
    ends_beside,
    keep_pivots,
    pass_pivots_on,
    passes,
    root_at,
    straddle,
    suspect_pivots,
    watch_pivots,
)
from rattle.solvers.state_switches import follow_jump
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
    never_switches,
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
WHOLE, BEYOND = 0.99, 1.001  # share of a step up to an event from which on it stands; else it is repeated: up to where
CLEAR, COMES_NEAR, PASSES, UNRESOLVED = range(4)  # a step beside singular positions
FORGIVEN = 1e-8  # error with which such a step counts, over the tolerances, so that the next one may be longer
FADING = 0.7  # share of the length of the last regular steps that a shorter one leaves as their measure
SHRINKING = 0.9  # factor of the length of such a step from one attempt to the next


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


@compiled
def project_state(m, t, y):
    """Project a state y inside the step at t [s] onto the joints, and onto closed set-valued contacts."""
    if is_rigid(m):
        project_on_contacts(m, t, y, -1)
    else:
        project(m, t, y)


@compiled
def try_step(m, t, h, last, rtol, atol, h_max):
    """Step from t of length h into y_new; OK, TRY_AGAIN or NOT_FINITE, its error, True if watched signs changed."""
    tally, power, stepper = m.tally, m.power, m.stepper
    power[at.PIVOT_SHARE] = 1.0
    watch_pivots(m)
    m.power[at.CULLS] = 1.0
    error, changed = call_stepper(m.stepper_table[at.STEP], (m, t, h, rtol, atol, tally[at.TAME]))
    m.power[at.CULLS] = 0.0
    tally[at.EVALUATIONS] += stepper[at.STAGES] - 1
    m.passage[at.ROOT_WITHIN] = math.sqrt(power[at.PIVOT_SHARE])
    laid = m.passage[at.TRIED_AT] == t  # across a singular position
    weak = power[at.PIVOT_SHARE] < WEAK and (laid or h <= LEAP * m.clock[at.H_SOUND])
    allowed = LEAP_ERROR * 2.0 ** tally[at.STREAK] if weak else ROUNDING_ACROSS
    if laid and h <= USUAL * m.clock[at.H_SOUND]:  # the motion along the branch is resolved
        allowed = max(allowed, LAID_ERROR)
    if (weak or tally[at.TAME] == 1) and error > 1.0 and error * rtol <= allowed:
        tally[at.LEAPS] += 1
        error = FORGIVEN
    if not error <= 1.0:
        return step_anew(m, t, h, error, weak), error, changed
    if stepper[at.ADAPTIVE] == 1:
        if power[at.PIVOT_SHARE] > WEAK:
            tally[at.TAME] = 0
        if not weak:
            tally[at.STREAK] = 0
            m.clock[at.H_SOUND] = max(h, FADING * m.clock[at.H_SOUND])
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
        clock[at.H] = LEAP * clock[at.H_SOUND] * SHRINKING ** tally[at.STREAK]
    return TRY_AGAIN


@compiled
def end_on_constraints(m, t, h, t_new, t_end, rtol, atol):
    """Project the end of the step onto the constraints; OK, TRY_AGAIN, UNSOUND or SLIDES, and True as in `try_step`."""
    passage, share = m.passage, m.power[at.PIVOT_SHARE]
    m.power[at.PIVOT_SHARE] = 1.0
    if is_rigid(m):
        project_on_contacts(m, t_new, m.state_new, -1)
        derivative(m, t_new, m.state_new, m.rate_new)
    else:
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
    if is_rigid(m):
        note_lock(m, t_new)
    gauge(m, end_of(m), t_new)
    changed = watched_change(m)
    if m.contact.shape[0] > 0:
        remember_end(m)
    return end_on_switch(m, t, t_new - t, t_end, False), changed


@compiled
def comes_near(m):
    """True if a step comes near a singular position, or begins there: forces may grow without bound."""
    passage = m.passage
    return min(passage[at.ROOT_WITHIN], passage[at.ROOT_AFTER]) < NEAR or passage[at.NEARBY] != AWAY


@compiled
def passage_of(m, t, h, rtol):
    """PASSES if the step passes a singular position, COMES_NEAR, else CLEAR; UNRESOLVED if it is too long to tell."""
    if not comes_near(m) and suspect_pivots(m) == 0.0:
        return CLEAR
    passed = passes(m, t, h, rtol)
    laid_across = m.passage[at.TRIED_AT] == t
    if passed < 0 or (passed == 0 and laid_across and m.passage[at.SUSPECTS] > 0.0):  # what is only nearly singular
        return UNRESOLVED
    if passed == 1:
        return PASSES
    return COMES_NEAR if comes_near(m) else CLEAR


@compiled
def is_calm(m, h, changed, passed, low, suspect):
    """True if nothing happens in a step of length h [s] that its dense output would have to tell.

    low: first look at which a closed contact may change, see `doubtful`; suspect: a compliant one may start or end.
    """
    if changed or passed != CLEAR:
        return False
    if is_rigid(m):
        return low == last_look(m) and none_may_hit(m, h)
    return not suspect and not (watches_forces(m) and near_peak(m))


@compiled
def relies_on_stages(m):
    """True if only stages tell that an expression or joint may have switched, or a monitored force its sign.

    Those of a step that an event cuts short hardly lie in what is left of it.
    """
    return not never_switches(m) or m.watch.shape[0] > 0


@compiled
def lets_go(m, who, what):
    """True if a compliant contact ends: what its force is beyond that makes the dense output worse than the step."""
    return what == MEETS and m.contact[who, at.IMPACT] == 0 and m.contact_memory[who, at.CLOSED] == at.SHUT


@compiled
def watches_forces(m):
    """True unless sliding is summed instead, for wear."""
    return m.wear_work.shape[0] == 0


@compiled
def first_event(m, t, h, low, high, calm, suspect):
    """The first event in the step: its share (NONE), the contact (-1), what it is, 1 if stages have shown all forces.

    low, high, suspect: as in `is_calm`.
    """
    if is_rigid(m):
        return first_of_rigid(m, t, h, low, high, 1 if calm else 0)
    if not suspect:
        return NONE, -1, NOTHING, 0
    share, who = first_change(m, h, 1.0)
    return share, who, MEETS, 0


@compiled
def just_before(m, until, met):
    """Share of a step up to which forces count: `until`, or just before it if the event there is a jump of a force.

    A wall that ends holds no more behind its end: what the contact would need there is no force of the motion.
    """
    return min(until, m.held[at.BEFORE_JUMP]) if met and is_rigid(m) else until


@compiled
def sum_step(m, t, h, until, by_stages, met, passed):
    """Peaks and sums of a step with a dense output up to the share `until`; met: an event ends it there.

    by_stages: 1 if the stages have shown all changes of closed contacts.
    """
    event, until = until, just_before(m, until, met)
    if passed != CLEAR:
        solved = count_step(m, t, h, until, stage_layout(m), 1, 1 if passed == PASSES else 0)
    elif by_stages == 1 and until == event:  # no polynomial through the stages has a jump
        solved = end_by_stages(m, t, h, until)
    else:
        looked = is_rigid(m) and not met and any_closed(m)
        solved = end_step(m, t, h, until, LOOKS if looked else stage_layout(m), 1)
    m.tally[at.EVALUATIONS] += solved


@compiled
def write_until(m, t, h, t_until, t_out, out):
    """Write outputs of the step from t of length h up to t_until [s]; needs the dense output.

    False if a contact is inside its wall at one.
    """
    tally, stage = m.tally, m.stage
    while output_due(m, t_until, t_out):
        k = tally[at.OUTPUTS]
        interpolate(m, (t_out[k] - t) / h, stage)
        if escaped(m, stage):
            m.clock[at.TROUBLE] = t_out[k]
            return False
        project_state(m, t_out[k], stage)
        record(m, t_out[k], stage, out[k])
        tally[at.OUTPUTS] = k + 1
    return True


@compiled
def keep_rows(m, t, h, summit, until, t_until, met):
    """Rows of a step from t of length h [s]: at the share `summit` where a contact pushes most, if that is below
    `until`, and just before what happens at t_until [s], the share `until`."""
    y_new, stage = m.state_new, m.stage
    if summit < until:
        interpolate(m, summit, stage)
        project_state(m, t + summit * h, stage)
        row_within(m, t + summit * h, stage)
    if met or m.landing[at.LANDS] > 0.0:
        before = just_before(m, until, met)
        if before < until:
            interpolate(m, before, stage)
        else:
            for n in range(stage.shape[0]):
                stage[n] = y_new[n]
        project_state(m, t_until, stage)
        before_break(m, t_until, stage)


@compiled
def go_to(m, t, h, until, t_until, met, quiet, changed, t_out, out):
    """Signs and outputs up to t_until, the share `until` of the step from t of length h; the state there into y_new.

    met: an event ends the step there.  quiet: the end of a step that needs no dense output.
    Returns OK, or ESCAPED.
    """
    y_new = m.state_new
    summit = find_peaks(m, until, 0 if quiet or not watches_forces(m) else 1)
    if changed:
        find_crossings(m, t, h, until)
    if met:
        interpolate(m, until, y_new)
    if not quiet and not write_until(m, t, h, t_until, t_out, out):
        return ESCAPED
    if keeps_breaks(m):
        keep_rows(m, t, h, summit, until, t_until, met)
    if m.contact.shape[0] > 0 and (inside_wall(m) if quiet else escaped(m, y_new)):
        m.clock[at.TROUBLE] = t_until
        return ESCAPED
    return OK


@compiled
def pass_event(m, t, h, t_end, who, what):
    """What happens at the end of a step of length h [s] at t: an event of contact `who` (-1: none), a switch.

    Returns OK, or a failure.
    """
    status, met = OK, who >= 0
    if met and is_rigid(m):
        status = take_event(m, t, h, t_end, who, what)
        if status == OK and m.switch.shape[0] > 0 and follow_jump(m, t, m.state_new):
            status = handle_event(m, t, m.state_new, -1, NOTHING)
    elif met:
        turn(m, who, t, m.state_new)
        finish_step(m, t, m.state_new, m.rate_new)
        remember_end(m)
        gauge(m, START, t)
    if status == OK and turn_switch(m, t, met):
        if is_rigid(m):
            return handle_event(m, t, m.state_new, -1, NOTHING)
        remember_end(m)
        cross_at_once(m, t)
        gauge(m, START, t)
    return status


@compiled
def take_step(m, t, h, t_new, t_end, last, rtol, atol, h_max):
    """A step whose end is on the constraints: OK, TRY_AGAIN or why not, its error, True if watched signs changed.

    TRY_AGAIN also if it ends beside a singular position and another end was chosen.
    """
    if is_rigid(m):
        m.held[at.DETERMINANT] = 1.0
    status, error, changed = try_step(m, t, h, last, rtol, atol, h_max)
    if status == OK:
        status, at_end = end_on_constraints(m, t, h, t_new, t_end, rtol, atol)
        changed |= at_end
    if status == OK and ends_beside(m, t, t_new - t) == 1:
        status = TRY_AGAIN
    return status, error, changed


@compiled
def shorten_for_event(m, t, h, t_end, share, who, what):
    """True if a step is to be repeated, with the length in the clock: it hides events, or should end at one."""
    if share > NONE and h > SHORT * (t_end - t):  # events may be hidden in it
        m.landing[at.LANDS] = 0.0
        quarter(m, h)
        return True
    if who < 0 or share >= WHOLE or share * h <= SHORT * (t_end - t):
        return False
    if relies_on_stages(m) or lets_go(m, who, what):
        m.landing[at.LANDS] = 0.0
        m.tally[at.REJECTED] += 1
        m.clock[at.H] = BEYOND * share * h
        return True
    return False


@compiled
def foresee(m, t, span, t_new, changed, passed, error, t_out):
    """What is known of a step before its dense output: the stages between which contacts may change, and whether
    compliant contacts may change, nothing happens in it, its forces are counted, and all that without an output.
    """
    rigid = is_rigid(m)
    low, high = doubtful(m, error) if rigid else (0, 0)
    suspect = not rigid and may_any_change(m, span)
    calm = is_calm(m, span, changed, passed, low, suspect)
    counted = calm and end_step(m, t, span, 1.0, stage_layout(m), -1) >= 0  # no peak of a force in it
    return low, high, suspect, calm, counted, counted and not output_due(m, t_new, t_out)


@compiled
def complete_step(m, t, span, until, t_until, h, t_end, who, what, quiet, changed, passed, rtol, atol, t_out, out):
    """End a step at t_until [s], its share `until`: outputs, the event there, and the start of the next step."""
    met, rigid, written = who >= 0, is_rigid(m), m.tally[at.OUTPUTS]
    if go_to(m, t, span, until, t_until, met, quiet, changed, t_out, out) != OK:
        return ESCAPED
    bends = met or m.landing[at.LANDS] > 0.0
    status = pass_event(m, t_until, h, t_end, who, what)
    if status != OK:
        m.clock[at.T] = t_until
        return status
    m.passage[at.ROOT_BEFORE] = m.passage[at.ROOT_AFTER]
    if met and passed != CLEAR:
        m.passage[at.ROOT_BEFORE] = root_at(m, t_until, m.state_new)
    pass_pivots_on(m)
    if rigid:
        restart(m, t_until, t_end, 1 if met else 0, 1 if quiet else 0, rtol, atol)
    elif m.contact.shape[0] > 0:
        pass_on(m)
    take_over(m, t_until, met)
    rows_at_end(m, t_until, bends, written)
    if not watches_forces(m):
        add_wear(m, t_until - t)
    return LOCKED if rigid and m.held[at.DETERMINANT] < 0.0 else OK


@native("i", "h", "f", "f", "f", "f", "v", "m", "i")
def advance(m, t_end, rtol, atol, h_max, t_out, out, most_steps):
    """Take up to `most_steps` steps towards t_end [s]; writes every output with t_out [s] <= the time reached.

    Next to a singular position a stage slightly off the constraints has a very wrong acceleration.  There the
    stages are projected too (`tame`).  Shorter steps would only come closer to it, so a step well below the
    last regular one crosses it even if its error is above the tolerance.

    Returns DONE, PAUSED, NOT_FINITE, STEP_TOO_SMALL, ESCAPED, UNSOUND, SLIDES or, of set-valued contacts, NO_SOLUTION,
    NOT_FOUND, NOT_UNIQUE, LOCKED, CHATTER.
    """
    clock, steps = m.clock, m.tally[at.STEPS] + most_steps
    while has_room(m, steps):
        t = clock[at.T]
        if t >= t_end:
            return DONE
        h, last = next_step(m, t_end)
        if h == 0.0:
            return STEP_TOO_SMALL
        t_new = t_end if last else t + h
        status, error, changed = take_step(m, t, h, t_new, t_end, last, rtol, atol, h_max)
        if status == TRY_AGAIN:
            continue
        if status != OK:
            return status
        span = t_new - t
        passed = passage_of(m, t, span, rtol)
        if passed == UNRESOLVED and h > SHORT * (t_end - t):
            m.landing[at.LANDS] = 0.0
            quarter(m, h)
            continue
        low, high, suspect, calm, counted, quiet = foresee(m, t, span, t_new, changed, passed, error, t_out)
        if not quiet:
            prepare_dense(m, t, span)
            m.tally[at.EVALUATIONS] += m.stepper[at.DENSE_STAGES]
        share, who, what, by_stages = first_event(m, t, span, low, high, calm, suspect)
        if shorten_for_event(m, t, h, t_end, share, who, what):
            continue
        met = who >= 0
        until, t_until = (share, t + share * span) if met else (1.0, t_new)
        if not counted:
            sum_step(m, t, span, until, by_stages, met, passed)
        status = complete_step(
            m, t, span, until, t_until, h, t_end, who, what, quiet, changed, passed, rtol, atol, t_out, out
        )
        if status != OK:
            return status
    return DONE if clock[at.T] >= t_end else PAUSED
