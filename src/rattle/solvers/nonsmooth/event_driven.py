"""What set-valued contacts add to the loop of `step_loop`: smooth motion between located events.

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

from rattle.equations.complementarity import FORWARD, OFF, STICK, friction_of
from rattle.equations.motion import OK, derivative
from rattle.equations.unilateral import CHATTER
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.clutches import gets_ahead, takes_impulses
from rattle.solvers.contacts.contact_events import may_any_change, near_peak, start_contacts
from rattle.solvers.contacts.gap_search import NONE, may_reach, rate_rounding
from rattle.solvers.contacts.pawls import seat_pawls
from rattle.solvers.contacts.penetration import scale_of
from rattle.solvers.nonsmooth.contact_modes import HIT, MEETS, NOTHING
from rattle.solvers.nonsmooth.contact_projection import noise, project_on_contacts
from rattle.solvers.nonsmooth.event_handling import handle_event, modes_with_friction, remember
from rattle.solvers.nonsmooth.event_search import any_closed, first_event
from rattle.solvers.peaks.contact_samples import doubts, keep_forces, last_look, pass_look_on
from rattle.solvers.peaks.samples import START, gauge, stages_tell
from rattle.solvers.projection import project
from rattle.solvers.sign_watch import cross_at_once
from rattle.solvers.state_switches import follow_jump
from rattle.solvers.step_control import first_step, never_switches

START_NEAR = 1e-6  # share of its scale within which a contact given at its wall is put there
START_SIZE = 1e-9  # the same of the size of the mechanism, where that is less: stops and surfaces without play
MOST_AT_ONCE = 60  # events without progress in time after which a run stops
MOST_IN_A_ROW = 200_000  # events, each after less than CROWDED of the run, after which it stops too
CROWDED = 1e-6
SAME_INSTANT = 1e-14  # share of the run within which events are at one instant
AHEAD = 1e-15  # share of the run by which a second event at one instant is later: where loads begin all forces are zero
FARTHER, FARTHEST = 4.0, 15.0  # how much later each of the next ones is, so many, at rest: forces may be rounding there
AT_REST = 1e-9  # share of the size of the mechanism, and of 1 rad, that a body moves in a run at such a rate


@native("i", "h", "f", "f")
def start(m, t, t_end):
    """Modes at the start of a run: closed contacts that approach have their impact at once. Returns a status.

    Where nothing is moved at the start, what touches is decided by the forces just after it.
    """
    y = m.state
    project(m, t, y)
    start_contacts(m, t, y)
    seat_pawls(m, True)
    for n in range(m.contact.shape[0]):
        if m.contact_memory[n, at.CLOSED] == at.AUTO:
            m.contact_memory[n, at.CLOSED] = at.OPEN
    who, nearest = touching(m)
    if who < 0:
        project_on_contacts(m, t, y, nearest)
    status = handle_event(m, t, y, who, NOTHING)
    if nearest >= 0:
        status = decide_just_after(m, t, t_end, status)
    remember(m)
    return status


@compiled
def touching(m):
    """The contact that hits at the start (-1: none), and the one nearest to its wall among those that are at theirs."""
    contact, kinematics, mode = m.contact, m.contact_kinematics, m.mode
    who, nearest = -1, -1
    for n in range(contact.shape[0]):
        if contact[n, at.LEVEL] == 1:
            who = n if contact[n, at.IMPACT] == 1 and takes_impulses(m, n) and gets_ahead(m, n) else who
            continue
        near = max(min(START_NEAR * scale_of(m, n), START_SIZE * m.lever[n, at.GAP_SIZE]), 4.0 * noise(m, n))
        if contact[n, at.IMPACT] == 0 or mode[n] != OFF or kinematics[n, at.GAP] > near:
            continue
        if nearest < 0 or kinematics[n, at.GAP] < kinematics[nearest, at.GAP]:
            nearest = n
        if kinematics[n, at.DGAP] < -rate_rounding(m, n):
            who = n
            break
    return who, nearest


@compiled
def decide_just_after(m, t, t_end, status):
    """Modes of contacts by the forces just after the start t [s], as long as nothing is moved there."""
    ahead = AHEAD * (t_end - t)
    for _ in range(int(FARTHEST)):
        if status != OK or not is_unmoved(m):
            break
        status = handle_event(m, t + ahead, m.state, -1, NOTHING)
        ahead *= FARTHER
    return status


@compiled
def is_at_rest(m, t_end):
    """True if no body moves, but for rounding."""
    nq = m.change.shape[0]
    for n in range(nq):
        if abs(m.state_new[nq + n]) * t_end > AT_REST * (1.0 if n % 3 == 2 else m.course[at.EXTENT]):
            return False
    return True


@compiled
def is_unmoved(m):
    """True if no body moves nor is accelerated."""
    nq = m.change.shape[0]
    for n in range(nq):
        if m.state[nq + n] != 0.0 or m.acceleration[1 + n // 3, n % 3] != 0.0:
            return False
    return True


@native("i", "h", "f", "i")
def go_on(m, t, jolted):
    """Modes after expressions have switched at t; jolted: rates have jumped, contacts may open. Returns a status."""
    y = m.state
    if jolted == 1 and m.switch.shape[0] > 0:
        follow_jump(m, t, y)
    if jolted == 0:
        status = handle_event(m, t, y, -1, NOTHING)
    else:
        status = modes_with_friction(m, t, y, -1, HIT)
    remember(m)
    return status


@compiled
def is_rigid(m):
    """True if the run has set-valued contacts."""
    return m.mode.shape[0] > 0


@compiled
def is_implicit(m):
    """True if the steps are those of an implicit method, as beside oil films."""
    return m.jacobian.shape[0] > 0


@native("i", "h", "f")
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


@native("void", "h", "f")
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


@native("ii", "h", "f")
def doubtful(m, error):
    """Looks between which a closed contact may change, see `glances.doubts`; few stages do not decide.

    error: of the step [tolerances].
    """
    if stages_tell(m):
        return doubts(m, error)
    return (0 if any_closed(m) else last_look(m)), last_look(m)


@native("fiii", "h", "f", "f", "i", "i", "i")
def first_of_rigid(m, t, h, low, high, calm):
    """The first event in the step, see `first_event`; calm: 1 if there is none."""
    m.held[at.BEFORE_JUMP] = 1.0
    if calm == 1:
        keep_forces(m)
        return NONE, -1, NOTHING, 1 if stages_tell(m) else 0
    share, who, what, by_stages = first_event(m, t, h, low, high)
    return share, who, what, 1 if by_stages else 0


@native("i", "h", "f", "f", "f", "i", "i")
def take_event(m, t, h, t_end, who, what):
    """Event of contact `who` at t, in a step of length h; CHATTER if events follow each other without end."""
    stuck = m.stuck
    again = t - stuck[at.EVENT_AT] <= SAME_INSTANT * t_end
    stuck[at.EVENTS_THERE] = stuck[at.EVENTS_THERE] + 1.0 if again else 0.0
    stuck[at.EVENTS_IN_A_ROW] = stuck[at.EVENTS_IN_A_ROW] + 1.0 if t - stuck[at.EVENT_AT] <= CROWDED * t_end else 0.0
    stuck[at.EVENT_AT] = stuck[at.EVENT_AT] if again else t
    stuck[at.EVENT_WHO] = who
    if stuck[at.EVENTS_THERE] > MOST_AT_ONCE or stuck[at.EVENTS_IN_A_ROW] > MOST_IN_A_ROW:
        return CHATTER
    ahead = AHEAD * t_end if again else 0.0
    if again and is_at_rest(m, t_end):
        ahead *= FARTHER ** min(stuck[at.EVENTS_THERE] - 1.0, FARTHEST)
    status = handle_event(m, t + ahead, m.state_new, who, what)
    if status == OK and what != MEETS:
        m.clock[at.H] = min(max(m.clock[at.H], h), m.clock[at.H_STABLE])
    return status


@native("void", "h", "f", "f", "i", "i", "f", "f")
def restart(m, t, t_end, met, quiet, rtol, atol):
    """Derivative, samples and memory at the end of a step at t, with which the next one begins.

    met: 1 if an event has ended the step; quiet: 1 if the state is still that at its end.
    """
    if quiet == 0:
        if met == 1 and is_implicit(m) and t < t_end:  # oil damps what an impact has thrown, at a rate of its own
            derivative(m, t, m.state_new, m.rate_new)
            m.clock[at.H] = min(m.clock[at.H], first_step(m, t, m.state_new, m.rate_new, t_end - t, rtol, atol))
        derivative(m, t, m.state_new, m.rate_new)
        m.tally[at.EVALUATIONS] += 1
        cross_at_once(m, t)
    if met == 1 or not never_switches(m):
        gauge(m, START, t)
    else:
        pass_look_on(m)
    m.tally[at.EVALUATIONS] += 1
    remember(m)
