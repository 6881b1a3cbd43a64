"""Set-valued contacts over a step of Moreau-Jean: those that take part, their percussions and positions."""

from __future__ import annotations

from rattle.equations.complementarity import FORWARD, OFF, STICK, A, B, F, friction_of
from rattle.equations.state import DISSIPATED, IMPULSE, LOSS, WORK, account_at, energies_at
from rattle.equations.unilateral import along, push_all, shift, solve_modes
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.contacts.event_rows import note, note_end, note_impact
from rattle.solvers.contacts.penetration import scale_of

ACTIVE = 1e-8  # share of its scale within which a contact takes part
KEPT = 1e-4  # the same for one that pressed in the step before: on curved paths a gap of O(h^2) is no separation
LASTING = 3  # steps in a row after which a contact counts as closed, or as released


@compiled
def choose_active(m):
    """Choose the contacts that are closed, with the modes of the step before as a start; the others are off."""
    contact, kinematics, mode = m.contact, m.contact_kinematics, m.mode
    active, candidate, slide = m.active, m.candidate, m.slide
    count = 0
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 0:
            continue
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
        if contact[n, at.IMPACT] == 0:
            continue
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
