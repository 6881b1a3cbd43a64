"""Moreau-Jean time stepping: contact impulses over fixed steps, without locating events.

    q_M  = q + h/2 v                                 contacts with g(q_M) <= 0 take part
    v_M  = v + h/2 (change of v in the step before)  for the forces; so the states z of the model, z_M
    M (v+ - v) = h Q(q_M, v_M, t_M) - Phi_q^T Lambda - W P,   Phi_q v+ = nu
    0 <= g'+ + e_N g'-,  0 <= P_N,  complementary;   P_T in -mu P_N Sgn(-(u_t+ + e_T u_t-))
    q+   = q_M + h/2 v+,   z+ = z + h z'(q_M, v_M, z_M, t_M)

The contact problem is solved by `unilateral.solve_contacts`, started from the modes of the step before.  The approach
speed of a bounce is that at its hit, at the time that follows from g(q_M), with free motion before and after it.
Then positions are corrected with the least mass-weighted change: a contact that hit at the depth d, approaching with
v- and leaving with v+, by d (1 + v+/v-), the distance lost by reversing too late; closed contacts onto the wall; the
joints.  The force of a contact is its impulse divided by h.

The order is one where contacts close, and the energy error is O(h).  An approach counts as an impact, with restitution
and as an event, if it is faster than two steps of free motion can make it; a contact counts as closed after LASTING
pressed steps in a row and ends after as many free ones.

Source: Jean, The non-smooth contact dynamics method, Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257; Moreau,
Unilateral contact and dry friction in finite freedom dynamics (1988); position correction as in Acary, Projected
event-capturing time-stepping schemes for nonsmooth mechanical systems, ibid. 256 (2013) 224-250.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import UNDECIDED
from rattle.equations.compliant import locate_contacts
from rattle.equations.motion import (
    DONE,
    NOT_FINITE,
    OK,
    PAUSED,
    accelerate,
    constraints,
    drive,
    loads,
    place,
)  # fmt: skip
from rattle.equations.one_way import any_one_way, follow_sides
from rattle.equations.schur import factorise
from rattle.equations.state import (
    DISSIPATED,
    LOSS,
    STORED,
    WORK,
    account_at,
    energies_at,
    states_at,
    take_states,
)
from rattle.equations.unilateral import contact_rows, ending, push_all, solve_contacts
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.clutches import book_slips, slips_changed
from rattle.solvers.contacts.pawls import seat_pawls
from rattle.solvers.contacts.penetration import ESCAPED, deepest
from rattle.solvers.nonsmooth.implicit_forces import (
    BEARABLE,
    MOST,
    SAME,
    add_base,
    book,
    go_to,
    keep_forces,
    keep_free,
    linearise,
    respond_all,
    settle,
    soften,
    start_rates,
    take_out,
)
from rattle.solvers.nonsmooth.percussions import choose_active, impact_side, lift, take_percussions
from rattle.solvers.output_row import write
from rattle.solvers.peaks.samples import START, add_step, gauge
from rattle.solvers.ports import keep_ports, show_ports
from rattle.solvers.projection import close_joints, project
from rattle.solvers.sign_watch import cross_at_once
from rattle.solvers.step_audit import UNSOUND, keep_energies, stands
from rattle.solvers.step_control import has_room

MOST_CHANGES = 4  # times that a step is taken for clutches that begin or cease to slip
REACHES = 1.0000001  # steps within which an output lies in this one: rounding of its instant


@native("void", "h", "f")
def start(m, t):
    """Project the start at t [s] onto its constraints."""
    y, sign = m.state, m.sign
    project(m, t, y)
    locate_contacts(m)
    seat_pawls(m, True)
    for n in range(sign.shape[0]):  # what the first step finds
        sign[n] = 1.0
    for n in range(m.contact_memory.shape[0]):
        m.contact_memory[n, at.CLOSED] = at.OPEN
    loads(m, t)
    m.audit[at.STARTED] = 0.0
    stands(m, y)
    m.clock[at.T] = t


@compiled
def write_until(m, t, h, impact, t_out, out):
    """Write outputs up to t + h: positions interpolated in the step, rates of its end, forces of this step.

    Rates are interpolated too where forces of compliant contacts and films follow from both, if there was no impact.
    """
    tally, y, y_new, stage = m.tally, m.state, m.state_new, m.stage
    acceleration, nq, nc = m.acceleration, m.change.shape[0], m.contact_kinematics.shape[0]
    energies = energies_at(m)
    while tally[at.OUTPUTS] < t_out.shape[0] and t_out[tally[at.OUTPUTS]] <= t + REACHES * h:
        k = tally[at.OUTPUTS]
        share = min(max((t_out[k] - t) / h, 0.0), 1.0)
        for c in range(y.shape[0]):
            stage[c] = y[c] + share * (y_new[c] - y[c])
        for c in range(nq):
            last = share > 0.0 and (impact or m.soft.shape[0] == 0)
            stage[nq + c] = y_new[nq + c] if last else y[nq + c] + share * (y_new[nq + c] - y[nq + c])
            acceleration[1 + c // 3, c % 3] = (y_new[nq + c] - y[nq + c]) / h
        take_states(m, stage)
        place(m, stage[:nq], stage[nq : 2 * nq])
        drive(m, t_out[k])
        constraints(m)
        loads(m, t_out[k])
        lost = stage[energies + DISSIPATED]
        for n in range(nc):
            lost += stage[account_at(m, n) + LOSS]
            m.power[at.POTENTIAL_ENERGY] += stage[account_at(m, n) + STORED]
        write(m, stage[energies + WORK], lost, out[k])
        show_ports(m, out[k])
        tally[at.OUTPUTS] = k + 1


@compiled
def move_free(m, t, h):
    """Half the step from (t, y): positions of its middle into y_new, with accelerations there as without contacts."""
    y, y_new, rate, nq = m.state, m.state_new, m.rate, m.change.shape[0]
    for c in range(y.shape[0]):
        y_new[c] = y[c]
    for c in range(nq):
        y_new[c] += 0.5 * h * y[nq + c]
        y_new[nq + c] += 0.5 * h * rate[c]
    for c in range(states_at(m), y.shape[0]):
        y_new[c] += 0.5 * h * rate[c]
    take_states(m, y_new)
    place(m, y_new[:nq], y_new[nq : 2 * nq])
    drive(m, t + 0.5 * h)
    constraints(m)
    if any_one_way(m):  # a corner that comes up to its segment from below touches nothing in this step
        locate_contacts(m)
        follow_sides(m)
    loads(m, t + 0.5 * h)
    if m.soft.shape[0] > 0:
        take_out(m, t, h)
    m.power[at.PIVOT_SHARE] = 1.0
    factorise(m)
    accelerate(m)


@compiled
def solve_step(m, h):
    """Contacts that take part and their percussions, at the positions of the middle; rates of a free step into y_new.

    Returns how many there are, or -1 where no solution was found.
    """
    y, y_new, acceleration, nq = m.state, m.state_new, m.acceleration, m.change.shape[0]
    place(m, y_new[:nq], y[nq : 2 * nq])
    active = solve_all(m, h) if m.soft.shape[0] > 0 else solve_rigid(m, h)
    for c in range(nq):
        y_new[nq + c] = y[nq + c] + h * acceleration[1 + c // 3, c % 3]
    return active


@compiled
def solve_rigid(m, h):
    """Set-valued contacts that take part and their percussions; how many there are, -1 if no solution was found."""
    active = choose_active(m)
    contact_rows(m, active)
    if m.soft.shape[0] > 0:
        soften(m, h, active)
    impact_side(m, active, h)
    if active > 0 and not solve_contacts(m, active):
        return -1
    return active


@compiled
def solve_all(m, h):
    """The same together with the forces of compliant contacts and films, by Newton's method."""
    respond_all(m)
    keep_free(m)
    start_rates(m, h)
    before = math.inf
    for k in range(MOST):
        linearise(m, h)
        add_base(m)
        active = solve_rigid(m, h)
        if active < 0:
            return -1
        push_all(m, active)
        off = settle(m, h)
        if off <= SAME or (k == MOST - 1 and off <= BEARABLE):
            return active
        go_to(m, 1.0 if off < 0.5 * before else 0.5)
        before = off
    m.held[at.OUTCOME] = UNDECIDED
    return -1


@compiled
def end_step(m, t, h, active):
    """Percussions into rates, the second half of the step with these, positions onto walls and joints.

    Returns True if there was an impact.
    """
    y, y_new, rate, nq = m.state, m.state_new, m.rate, m.change.shape[0]
    impact = take_percussions(m, t, active, h, y_new)
    book_slips(m, h, y, y_new)
    if m.soft.shape[0] > 0:
        keep_forces(m, h, y[nq : 2 * nq], y_new[nq : 2 * nq], y_new)
    keep_ports(m, t, h)
    cross_at_once(m, t)
    for c in range(nq):
        rate[c] = m.acceleration[1 + c // 3, c % 3] if impact else (y_new[nq + c] - y[nq + c]) / h
        y_new[c] += 0.5 * h * y_new[nq + c]
    first = states_at(m)
    for c in range(first, y.shape[0]):
        rate[c] = m.element_rate[c - first]
        y_new[c] = y[c] + h * rate[c]
    place(m, y_new[:nq], y_new[nq : 2 * nq])
    if active > 0:
        locate_contacts(m)
        lift(m, active, y_new)
        place(m, y_new[:nq], y_new[nq : 2 * nq])
    close_joints(m, t + h, y_new)
    if m.soft.shape[0] > 0:
        book(m, t + h, h, y_new)
    return impact


@compiled
def end_stands(m, t, h):
    """OK when the end of the step may stand and no contact is inside its wall; else NOT_FINITE, UNSOUND or ESCAPED."""
    y_new, audit, nq = m.state_new, m.audit, m.change.shape[0]
    for i in range(1, m.body.shape[0]):
        if not abs(y_new[nq + 3 * i - 1]) + abs(y_new[nq + 3 * i - 2]) + abs(y_new[nq + 3 * i - 3]) < math.inf:
            return NOT_FINITE
    m.tally[at.EVALUATIONS] += 1
    gauge(m, START, t + 0.5 * h)
    add_step(m, h)
    take_states(m, y_new)
    loads(m, t + h)
    if not stands(m, y_new):
        m.clock[at.TROUBLE] = t + h
        return UNSOUND
    keep_energies(m)
    locate_contacts(m)
    follow_sides(m)
    seat_pawls(m, False)
    audit[at.SUNK] = max(audit[at.SUNK], deepest(m))
    if audit[at.SUNK] > 1.0:
        m.clock[at.TROUBLE] = t + h
        return ESCAPED
    return OK


@native("i", "h", "f", "f", "i", "v", "m", "i")
def advance(m, t_start, h, count, t_out, out, most_steps):
    """Take up to `most_steps` of the `count` steps of length h [s] from t_start [s] on; writes outputs on the way.

    Returns DONE, PAUSED, NOT_FINITE, NO_SOLUTION, NOT_FOUND, UNSOUND or ESCAPED.
    """
    y, y_new, clock, tally, nq = m.state, m.state_new, m.clock, m.tally, m.change.shape[0]
    steps = min(tally[at.STEPS] + most_steps, count)
    clock[at.H] = clock[at.H_MIN] = h
    while has_room(m, steps):
        t = t_start + tally[at.STEPS] * h
        active = -1
        for _ in range(MOST_CHANGES):
            move_free(m, t, h)
            active = solve_step(m, h)
            if active < 0:
                return ending(m)
            if not slips_changed(m, h, active, y_new[nq : 2 * nq]):
                break
        impact = end_step(m, t, h, active)
        status = end_stands(m, t, h)
        if status != OK:
            return status
        write_until(m, t, h, impact, t_out, out)
        for c in range(y.shape[0]):
            y[c] = y_new[c]
        tally[at.STEPS] += 1
        clock[at.T] = t_start + tally[at.STEPS] * h
    return DONE if tally[at.STEPS] >= count else PAUSED
