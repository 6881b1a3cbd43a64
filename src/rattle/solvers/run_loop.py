"""A run around its step loop: how it begins, and what happens at the instants at which expressions of time switch.

A run goes in smooth pieces between the instants of its timetable: steps end there, switches take the sides of the next
piece, and a driver that jumps in speed makes a jolt.  Friction that locks a contact is passed, where that is asked for.
`course` holds what is settled before the start and the place in the run; `driver_jump` tells what jolts have done.
"""

from __future__ import annotations

import math

from rattle.equations.dry_friction import is_smooth
from rattle.equations.motion import DONE, OK, PAUSED, STEP_TOO_SMALL, potential_of_fall
from rattle.equations.state import WORK, energies_at
from rattle.equations.unilateral import LOCKED, NO_SOLUTION
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.language.instants import SAME, take_sides_of
from rattle.solvers import step_loop
from rattle.solvers.breaks import after_break, before_break
from rattle.solvers.contacts.wear_sum import add_wear, keep_speeds
from rattle.solvers.dry_friction_modes import decide
from rattle.solvers.nonsmooth import event_driven, jams, moreau_jean
from rattle.solvers.nonsmooth.jolts import jolt, speeds
from rattle.solvers.output_row import record
from rattle.solvers.state_switches import choose_sides
from rattle.solvers.step_audit import set_floor

WHILE_HELD = 125.0  # steps of a run with joints that may stick, at least; each is searched in 16 parts
GLANCE = 1e-6  # share of a run to look ahead for the side of a switching function that is zero
JAM_APART = 1e-9  # share of a run within which a second jam is at the same place: passing it again does not help
STEP_AFTER_JAM = 1e-6  # share of what is left of a run that the step after a jam has at least
BEFORE, AFTER, PERCUSSION = range(3)  # rows of `jolt_rows`: nu before and after, Lambda
WHOLE = 1e-9  # by how much a span may exceed a whole number of longest steps and not need one more: rounding
WHOLE_LEG = 1e-12  # the same of a leg to a given instant, as a share


# ---------------------------------------------------------------- the beginning
@native("i", "h", "f", "f", "f", "f", "f", "v", "m")
def begin(m, t, t_end, rtol, atol, h_max, t_out, out):
    """Prepare steps from the time t [s] and the state in the workspace; PAUSED, or a failure status.

    If the state stands there, the output at t is written, if t_out [s] begins with one.  h_max: longest step [s].
    """
    loop = m.course[at.LOOP]
    take_sides(m, t, t_end)
    if loop == at.RUNS_EQUAL_STEPS:
        begin_leg(m, t)
        moreau_jean.start(m, t)
        set_floor(m, m.course[at.EXTENT], m.audit[at.OPEN_LIMIT], rtol, atol)
        return PAUSED
    if loop == at.RUNS_BY_EVENTS:
        status = begin_contacts(m, t, t_end)
        if status != OK:
            return status
        take_sides(m, t, t_end)
    h_max = while_held(m, t_end, h_max)
    status = step_loop.begin(m, t, t_end, rtol, atol, h_max)
    set_floor(m, m.course[at.EXTENT], m.audit[at.OPEN_LIMIT], rtol, atol)
    if loop == at.RUNS_SMOOTHLY:
        pace(m, t, t_end, h_max)
    if m.wear_work.shape[0] > 0:
        keep_speeds(m)
        step_loop.resume(m, t)
        add_wear(m, 0.0)
    if status != OK:
        return status
    if t_out.shape[0] > 0 and t_out[0] <= t:
        record(m, t, m.state, out[0])
        m.tally[at.OUTPUTS] = 1
    return PAUSED


@compiled
def begin_contacts(m, t, t_end):
    """Modes of closed set-valued contacts, and impacts, at the start t [s]; OK, or why there are none."""
    contact, course, stuck = m.contact, m.course, m.stuck
    course[at.MAY_PASS] = 0.0
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1 and jams.passes_jams(m, n):
            course[at.MAY_PASS] = 1.0
    for k in range(stuck.shape[0]):
        stuck[k] = 0.0
    stuck[at.EVENT_AT] = -math.inf
    m.clock[at.T] = t
    status = event_driven.start(m, t, t_end)
    if status == NO_SOLUTION and course[at.MAY_PASS] == 1.0 and pass_jam(m, t_end, status, 0) == PAUSED:
        return OK
    return status


@compiled
def take_sides(m, t, t_end):
    """Set every switch to the side that it has from the time t [s] on.

    Where steps do not end at switches of the state, the values of their switching functions decide.
    """
    edges, piece = m.edges, 0
    while piece + 2 < edges.shape[0] and edges[piece + 1] <= t:
        piece += 1
    take_piece(m, piece)
    if m.switch.shape[0] > 0 and lands(m):
        choose_sides(m, t, GLANCE * (t_end - t))
    if m.dry.shape[0] > 0 and lands(m):
        decide(m, t, m.state, -1, 0)


@compiled
def take_piece(m, piece):
    """Write the sides of a piece into the programs."""
    m.course[at.PIECE] = piece
    take_sides_of(m, piece)


@compiled
def lands(m):
    """True if steps end where switches of the state change their side, and at outputs beside instants."""
    return m.course[at.LOOP] != at.RUNS_EQUAL_STEPS


@compiled
def instant_ahead(m):
    """The next instant at which an expression of time switches [s], or one beyond the end of the run."""
    edges, piece = m.edges, int(m.course[at.PIECE])
    return edges[piece + 1] if piece + 1 < edges.shape[0] else math.inf


@compiled
def while_held(m, t_end, h_max):
    """The longest step [s] of a run to t_end [s]: steps grow while joints stick, however what they hold changes."""
    if m.course[at.LOOP] == at.RUNS_EQUAL_STEPS:
        return h_max
    for n in range(m.dry.shape[0]):
        if m.stepper[at.ADAPTIVE] == 1 and not is_smooth(m, n):
            return min(h_max, abs(t_end) / WHILE_HELD)
    return h_max


@compiled
def pace(m, t, t_end, h_max):
    """With fixed steps, choose equal ones from the time t [s] to the next instant of the timetable."""
    ahead = min(instant_ahead(m), t_end) - t
    if m.stepper[at.ADAPTIVE] == 0 and ahead > 0.0:
        m.clock[at.H] = ahead / equal_steps(ahead / h_max - WHOLE)


@compiled
def equal_steps(span):
    """Number of equal steps over a span of so many of the longest ones."""
    return max(1.0, -math.floor(-span))


# ---------------------------------------------------------------- steps
@native("i", "h", "f", "f", "f", "f", "f", "v", "m", "i")
def advance(m, t, t_end, rtol, atol, h_max, t_out, out, most_steps):
    """Up to `most_steps` steps towards the time t [s] of a run to t_end [s]; PAUSED before t, DONE at t, or a failure.

    It passes at most one instant or jam.
    """
    h_max = while_held(m, t_end, h_max)
    instant = instant_ahead(m)
    if instant > t:
        return take_steps(m, t, t_end, rtol, atol, h_max, t_out, out, most_steps)
    outputs = outputs_before(t_out, instant - SAME * t_end)
    if instant >= t_end and not lands(m):  # equal steps write those at the end too
        outputs = t_out.shape[0]
    status = take_steps(m, instant, t_end, rtol, atol, h_max, t_out[:outputs], out, most_steps)
    if status == DONE:
        status = pass_instant(m, instant, t_end, h_max, t_out, out)
    return DONE if status == PAUSED and m.clock[at.T] >= t and instant_ahead(m) > t else status


@compiled
def outputs_before(t_out, limit):
    """Number of outputs at times t_out (n,) [s] before a limit [s]: at an instant the values just after it count."""
    first, last = 0, t_out.shape[0]
    while first < last:
        middle = (first + last) // 2
        if t_out[middle] < limit:
            first = middle + 1
        else:
            last = middle
    return first


@compiled
def take_steps(m, t, t_end, rtol, atol, h_max, t_out, out, most_steps):
    """Up to `most_steps` steps towards t [s] without switching, with the outputs t_out [s]; returns as `advance`."""
    if not lands(m):
        aim_leg(m, t, t_end, h_max)
        course = m.course
        start, h, count = course[at.LEG_START], course[at.LEG_STEP], int(course[at.LEG_STEPS])
        return moreau_jean.advance(m, start, h, count, t_out, out, most_steps)
    status = step_loop.advance(m, t, rtol, atol, h_max, t_out, out, most_steps)
    if status in (NO_SOLUTION, LOCKED, STEP_TOO_SMALL) and m.course[at.MAY_PASS] == 1.0:
        return pass_jam(m, t_end, status, 1 if status == NO_SOLUTION else 0)
    return status


@compiled
def begin_leg(m, t):
    """Equal steps begin at t [s]."""
    course = m.course
    course[at.LEG_START], course[at.LEG_END], course[at.LEG_STEP], course[at.LEG_STEPS] = t, t, 0.0, 0.0


@compiled
def aim_leg(m, t, t_end, h_max):
    """Equal steps up to the time t [s], counted as if the run had taken such steps from its start."""
    course, done = m.course, float(m.tally[at.STEPS])
    now = course[at.LEG_END]
    if t == now:
        return
    longest = h_max if h_max < math.inf else t_end
    count = equal_steps((t - now) / longest * (1.0 - WHOLE_LEG))
    h = (t - now) / count
    course[at.LEG_START], course[at.LEG_END], course[at.LEG_STEP], course[at.LEG_STEPS] = (
        now - done * h,
        t,
        h,
        done + count,
    )


@compiled
def go_on(m, t, t_end, h_max, jolted):
    """Prepare further steps from t [s], after expressions have switched there; PAUSED or a failure status.

    jolted: 1 if rates have jumped.
    """
    loop = m.course[at.LOOP]
    if loop == at.RUNS_EQUAL_STEPS:  # the next step finds what has changed
        return PAUSED
    if loop == at.RUNS_BY_EVENTS:
        return go_on_with_contacts(m, t, jolted)
    if m.dry.shape[0] > 0:
        decide(m, t, m.state, -1, 1)
    step_loop.resume(m, t)
    pace(m, t, t_end, h_max)
    return PAUSED


@native("i", "h", "f", "i")
def go_on_with_contacts(m, t, jolted):
    """The same with set-valued contacts, whose modes are found anew."""
    status = event_driven.go_on(m, t, jolted)
    if status != OK:
        return status
    step_loop.resume(m, t)
    return PAUSED


@native("i", "h", "f", "i", "i")
def pass_jam(m, t_end, status, late):
    """Pass a position at which friction locks by an impact without collision; PAUSED, or a failure status.

    status: why steps have ended, which stays if there is no such impact.  late: 1 if the state is that of an event
    whose new modes were not found.
    """
    course, clock = m.course, m.clock
    t = clock[at.T]
    if t - course[at.JAM_AT] <= JAM_APART * t_end:
        return status
    if course[at.JAMS] == 0.0:
        note_closed(m)
    if jams.pass_jam(m, t, late) != OK:
        return status
    course[at.JAM_AT] = t
    if course[at.JAMS] == 0.0:
        course[at.FIRST_JAM] = t
    course[at.JAMS] += 1.0
    clock[at.H] = max(clock[at.H], STEP_AFTER_JAM * (t_end - t))
    return go_on_with_contacts(m, t, 1)


@compiled
def note_closed(m):
    """Remember which contacts are closed, or about to, in the first jam."""
    jammed = m.jammed
    for n in range(jammed.shape[0]):
        jammed[n] = jams.touches(m, n)


# ---------------------------------------------------------------- instants
@native("i", "h", "f", "f", "f", "v", "m")
def pass_instant(m, t, t_end, h_max, t_out, out):
    """Switch expressions at t [s]: sides of the next piece, a jolt if a driver jumps; PAUSED or a failure status."""
    rows, jolted = m.jolt_rows, jumps_at(m, t)
    before_break(m, t, m.state)
    if jolted:
        speeds(m, t, rows[BEFORE])
    falls = m.falling.shape[0] > 0
    held = potential_of_fall(m, t, m.state) if falls else 0.0
    take_piece(m, int(m.course[at.PIECE]) + 1)
    if falls:  # gravity may jump
        m.state[energies_at(m) + WORK] += potential_of_fall(m, t, m.state) - held
    if jolted:
        speeds(m, t, rows[AFTER])
        status = jolt(m, t, rows[BEFORE], rows[PERCUSSION])
        if status != OK:
            return status
        book_jolts(m, t)
    status = go_on(m, t, t_end, h_max, 1 if jolted else 0)
    if status == PAUSED:
        if lands(m):
            record_now(m, t, t_end, t_out, out)
        after_break(m, t, m.state)
    return status


@compiled
def jumps_at(m, t):
    """True if a driver jumps in speed at the instant t [s]."""
    jump, k = m.driver_jump, int(m.course[at.JOLTS])
    return k < jump.shape[0] and jump[k, at.JUMP_AT] == t


@compiled
def book_jolts(m, t):
    """Impulse and work of the drivers that have jumped at t [s]."""
    jump, rows = m.driver_jump, m.jolt_rows
    while jumps_at(m, t):
        k = int(m.course[at.JOLTS])
        r = int(jump[k, at.JUMP_ROW])
        jump[k, at.JUMP_IMPULSE] = -rows[PERCUSSION, r]
        jump[k, at.JUMP_WORK] = -0.5 * rows[PERCUSSION, r] * (rows[BEFORE, r] + rows[AFTER, r])
        m.course[at.JOLTS] += 1.0


@compiled
def record_now(m, t, t_end, t_out, out):
    """Write the outputs at the instant t [s], with the values just after it."""
    tally = m.tally
    while tally[at.OUTPUTS] < t_out.shape[0] and t_out[tally[at.OUTPUTS]] <= t + SAME * t_end:
        record(m, t, m.state, out[tally[at.OUTPUTS]])
        tally[at.OUTPUTS] += 1
