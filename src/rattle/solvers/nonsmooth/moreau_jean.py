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

from rattle.equations.complementarity import FORWARD, OFF, STICK, A, B, F, friction_of
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
from rattle.equations.schur import factorise
from rattle.equations.state import DISSIPATED, IMPULSE, LOSS, WORK, account_at, energies_at, states_at, take_states
from rattle.equations.unilateral import along, contact_rows, ending, push_all, shift, solve_contacts, solve_modes
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.clutches import book_slips, slips_changed
from rattle.solvers.contacts.event_rows import note, note_end, note_impact
from rattle.solvers.contacts.pawls import seat_pawls
from rattle.solvers.contacts.penetration import ESCAPED, deepest, scale_of
from rattle.solvers.output_row import write
from rattle.solvers.peaks.samples import START, add_step, gauge
from rattle.solvers.ports import keep_ports, show_ports
from rattle.solvers.projection import close_joints, project
from rattle.solvers.sign_watch import cross_at_once
from rattle.solvers.step_audit import UNSOUND, stands
from rattle.solvers.step_control import has_room

ACTIVE = 1e-8  # share of its scale within which a contact takes part
KEPT = 1e-4  # the same for one that pressed in the step before: on curved paths a gap of O(h^2) is no separation
MOST_CHANGES = 4  # times that a step is taken for clutches that begin or cease to slip
LASTING = 3  # steps in a row after which a contact counts as closed, or as released


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
def choose_active(m):
    """Choose the contacts that are closed, with the modes of the step before as a start; the others are off."""
    contact, kinematics, mode = m.contact, m.contact_kinematics, m.mode
    active, candidate, slide = m.active, m.candidate, m.slide
    count = 0
    for n in range(contact.shape[0]):
        kinematics[n, at.NORMAL], kinematics[n, at.TANGENT], kinematics[n, at.LOSS] = 0.0, 0.0, 0.0
        if m.contact_memory[n, at.SLIPS] == 1.0:
            continue
        if kinematics[n, at.GAP] <= (ACTIVE if mode[n] == OFF else KEPT) * scale_of(m, n):
            active[count], candidate[count], slide[count] = n, mode[n], 0
            count += 1
    return count


@compiled
def late(h, gap, speed):
    """Time from the hit to the middle of the step [s]: within the step, also if it began inside the wall."""
    return min(max(-gap / speed, -0.5 * h), 0.5 * h)


@compiled
def impact_side(m, count, h):
    """b of the active contacts without impulses [m/s]: g'+ minus the required rate of a bounce, and -(u_t+ + e_T u_t-).

    Rates are those at the end of the step, at the position of its middle.
    """
    contact, kinematics, active, side = m.contact, m.contact_kinematics, m.active, m.side
    acceleration, values, memory, body = m.acceleration, m.values, m.contact_memory, m.body
    for k in range(count):
        n, p = active[k], contact[active[k], at.NORMAL_P]
        kinematics[n, at.DGAP] = -along(m, 2 * k, n, body, at.VX)
        kinematics[n, at.SLIP] = along(m, 2 * k + 1, n, body, at.VX)
        pull, bend = along(m, 2 * k, n, acceleration, 0), kinematics[n, at.GAMMA_N]
        least = 2.0 * h * abs(bend - pull)
        hits = kinematics[n, at.DGAP] < -least
        memory[n, at.HITS], memory[n, at.E_T] = (
            1.0 if hits else 0.0,
            values[p + at.TANGENTIAL_RESTITUTION] if hits else 0.0,
        )
        memory[n, at.RATE_AFTER] = memory[n, at.SHIFT] = 0.0  # a jolt has left other quantities there
        if hits:
            when = 0.5 * h - late(h, kinematics[n, at.GAP], -kinematics[n, at.DGAP])  # after the start of the step
            speed = kinematics[n, at.DGAP] - pull * when + bend * (when - 0.5 * h)
            if -values[p + at.RESTITUTION] * speed > least:  # it bounces: free before and after
                memory[n, at.RATE_AFTER] = (
                    -values[p + at.RESTITUTION] * speed - bend * (when - 0.5 * h) - pull * (h - when)
                )
        side[B, 2 * k] = kinematics[n, at.DGAP] - h * pull - memory[n, at.RATE_AFTER]
        side[B, 2 * k + 1] = -(1.0 + memory[n, at.E_T]) * kinematics[n, at.SLIP] - h * along(
            m, 2 * k + 1, n, acceleration, 0
        )


@compiled
def take_percussions(m, t, count, h, y):
    """Add the impulses to rates, multipliers, forces and energies; y holds q_M and the rates without impulses.

    Returns True if there was an impact.
    """
    contact, kinematics, active, candidate = m.contact, m.contact_kinematics, m.active, m.candidate
    side, dv, dlambda, multiplier = m.side, m.velocity_change, m.multiplier_change, m.multiplier
    memory, mode, nq = m.contact_memory, m.mode, m.change.shape[0]
    rows, power = m.rows, m.power
    push_all(m, count)
    for c in range(nq):
        y[nq + c] -= dv[1 + c // 3, c % 3]
    for row in range(multiplier.shape[0]):
        multiplier[row] -= dlambda[row] / h
    energies = energies_at(m)
    y[energies + WORK] += h * power[at.WORK_RATE]
    y[energies + DISSIPATED] += h * power[at.LOSS_RATE]
    for row in range(multiplier.shape[0]):
        y[energies + WORK] -= h * multiplier[row] * rows[row, at.NU]
    k, nc, impact = 0, contact.shape[0], False
    for n in range(nc):
        old = mode[n]
        mode[n] = OFF
        if k < count and active[k] == n:
            pressed, held = side[F, 2 * k], side[F, 2 * k + 1]
            if pressed > 0.0:
                mode[n] = candidate[k]
                gap_rate = side[A, 2 * k] + memory[n, at.RATE_AFTER]
                slip = -side[A, 2 * k + 1] - memory[n, at.E_T] * kinematics[n, at.SLIP]
                if friction_of(m, n) == 0.0:
                    slip = kinematics[n, at.SLIP]
                lost = 0.5 * (held * (kinematics[n, at.SLIP] + slip) - pressed * (kinematics[n, at.DGAP] + gap_rate))
                account = account_at(m, n)
                y[account + IMPULSE] += pressed
                y[account + LOSS] += lost
                kinematics[n, at.NORMAL], kinematics[n, at.TANGENT] = pressed / h, held / h
                kinematics[n, at.LOSS] = lost / h
                if old == OFF and memory[n, at.HITS] == 1.0:
                    speed = -kinematics[n, at.DGAP]
                    when = t + 0.5 * h - late(h, kinematics[n, at.GAP], speed)
                    note_impact(m, n, when, speed, pressed, lost)
                    memory[n, at.SPEED] = speed
                    memory[n, at.SHIFT] = gap_rate * late(h, kinematics[n, at.GAP], speed) - kinematics[n, at.GAP]
                    impact = True
            k += 1
        watch_contact(m, n, old, t, h, y)
    return impact


@compiled
def watch_contact(m, n, old, t, h, y):
    """Count pressed and free steps of contact n; record when it closes or opens, sticks or slips."""
    mode, memory, kinematics = m.mode, m.contact_memory, m.contact_kinematics
    steps = memory[n, at.STEPS_ON]
    account = account_at(m, n)
    if mode[n] != OFF:
        steps = max(steps, 0.0) + 1.0
        if memory[n, at.CLOSED] == at.OPEN and steps >= LASTING:
            memory[n, at.CLOSED], memory[n, at.SINCE], memory[n, at.PEAK] = at.SHUT, t + h - steps * h, 0.0
            memory[n, at.IMPULSE_0], memory[n, at.LOSS_0] = y[account + IMPULSE], y[account + LOSS]
            if mode[n] == STICK and friction_of(m, n) > 0.0:
                note(m, at.STICK_EVENT, n, t, 0.0)
        elif memory[n, at.CLOSED] == at.SHUT and (old == STICK) != (mode[n] == STICK) and friction_of(m, n) > 0.0:
            note(m, at.STICK_EVENT if mode[n] == STICK else at.SLIP_EVENT, n, t, 0.0)
        memory[n, at.PEAK] = max(memory[n, at.PEAK], kinematics[n, at.NORMAL])
    else:
        steps = min(steps, 0.0) - 1.0
        if memory[n, at.CLOSED] == at.SHUT and steps <= -LASTING:
            note_end(m, n, t + (steps + 1.0) * h, y, 0.0)
            memory[n, at.CLOSED], memory[n, at.SPEED] = at.OPEN, 0.0
    memory[n, at.STEPS_ON] = steps


@compiled
def lift(m, count, y):
    """Correct positions: bounces to where they would be had they hit in time, closed contacts onto the wall."""
    kinematics, active, candidate, side = m.contact_kinematics, m.active, m.candidate, m.side
    memory, nq = m.contact_memory, m.change.shape[0]
    deep = False
    for k in range(count):
        n = active[k]
        candidate[k] = OFF
        side[B, 2 * k], side[B, 2 * k + 1] = 0.0, 0.0
        if (
            m.contact[n, at.LEVEL] == 0
            and kinematics[n, at.NORMAL] > 0.0
            and (kinematics[n, at.GAP] < 0.0 or memory[n, at.CLOSED] == at.SHUT or memory[n, at.SHIFT] > 0.0)
        ):
            candidate[k] = FORWARD
            side[B, 2 * k] = memory[n, at.SHIFT] if memory[n, at.SHIFT] > 0.0 else -kinematics[n, at.GAP]
            deep = True
        memory[n, at.SHIFT] = 0.0
    if not deep:
        return
    solve_modes(m, count, 0)
    shift(m, count, y[:nq], 1.0)


@compiled
def write_until(m, t, h, t_out, out):
    """Write outputs up to t + h: positions interpolated in the step, rates of its end, forces of this step."""
    tally, y, y_new, stage = m.tally, m.state, m.state_new, m.stage
    acceleration, nq, nc = m.acceleration, m.change.shape[0], m.contact_kinematics.shape[0]
    energies = energies_at(m)
    while tally[at.OUTPUTS] < t_out.shape[0] and t_out[tally[at.OUTPUTS]] <= t + 1.0000001 * h:
        k = tally[at.OUTPUTS]
        share = min(max((t_out[k] - t) / h, 0.0), 1.0)
        for c in range(y.shape[0]):
            stage[c] = y[c] + share * (y_new[c] - y[c])
        for c in range(nq):
            stage[nq + c] = y[nq + c] if share == 0.0 else y_new[nq + c]
            acceleration[1 + c // 3, c % 3] = (y_new[nq + c] - y[nq + c]) / h
        take_states(m, stage)
        place(m, stage[:nq], stage[nq : 2 * nq])
        drive(m, t_out[k])
        constraints(m)
        loads(m, t_out[k])
        lost = stage[energies + DISSIPATED]
        for n in range(nc):
            lost += stage[account_at(m, n) + LOSS]
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
    loads(m, t + 0.5 * h)
    m.power[at.PIVOT_SHARE] = 1.0
    factorise(m)
    accelerate(m)


@compiled
def solve_step(m, h):
    """Contacts that take part and their percussions, at the positions of the middle; rates of a free step into y_new.

    Returns how many there are, or -1 where no solution was found.
    """
    y, y_new, acceleration, nq = m.state, m.state_new, m.acceleration, m.change.shape[0]
    active = choose_active(m)
    contact_rows(m, active)
    place(m, y_new[:nq], y[nq : 2 * nq])
    impact_side(m, active, h)
    for c in range(nq):
        y_new[nq + c] = y[nq + c] + h * acceleration[1 + c // 3, c % 3]
    if active > 0 and not solve_contacts(m, active):
        return -1
    return active


@compiled
def end_step(m, t, h, active):
    """Percussions into rates, the second half of the step with these, positions onto walls and joints."""
    y, y_new, rate, nq = m.state, m.state_new, m.rate, m.change.shape[0]
    impact = take_percussions(m, t, active, h, y_new)
    book_slips(m, h, y, y_new)
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
    locate_contacts(m)
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
        end_step(m, t, h, active)
        status = end_stands(m, t, h)
        if status != OK:
            return status
        write_until(m, t, h, t_out, out)
        for c in range(y.shape[0]):
            y[c] = y_new[c]
        tally[at.STEPS] += 1
        clock[at.T] = t_start + tally[at.STEPS] * h
    return DONE if tally[at.STEPS] >= count else PAUSED
