"""Contacts at velocity level: clutches, which have a rate w = g' but no gap.

Their mode is off where B overruns A (w > 0) and otherwise that of a closed contact.  One that slips at its largest
torque M (w < 0) is off too, and M is an applied force: a finite torque has no part in impacts.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import OFF, B, F
from rattle.equations.state import IMPULSE, LOSS, account_at
from rattle.equations.unilateral import push_all
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.contacts.event_rows import note

STILL = 1e-12  # share of the rates of its bodies below which the rate of a clutch counts as zero
LEAST = 1e-14  # rate of a clutch that counts as zero in any case [rad/s]
NOISE = 1e-11  # share of the largest torque below which one is rounding: more than the contact problem leaves
OVER = 1e-12  # share by which a torque may exceed the largest one by rounding
BACK = 1e-9  # share of the accelerations of its bodies below which that of a clutch that begins to slip is rounding
TURNS = 1e-6  # share of the rates of its bodies from which on an idle clutch turns: dense output of a step errs less


@compiled
def most_torque(m, n):
    """Largest torque of contact n at velocity level [N*m]."""
    return m.values[m.contact[n, at.NORMAL_P] + at.MOST_TORQUE]


@compiled
def takes_impulses(m, n):
    """True unless contact n is a clutch with a largest torque."""
    return m.contact[n, at.LEVEL] == 0 or most_torque(m, n) == math.inf


@compiled
def watched(m, n):
    """True if an indicator of contact n may announce an event: a closed contact, and every one at velocity level."""
    return m.contact[n, at.IMPACT] == 1 and (m.mode[n] != OFF or m.contact[n, at.LEVEL] == 1)


@compiled
def rate_left(m, n):
    """Rate of clutch n [rad/s] in the direction of its mode: not negative while it overruns, slips or is idle."""
    rate = m.contact_kinematics[n, at.DGAP]
    if m.contact_memory[n, at.IDLE] == 1.0:
        a, b = m.contact[n, at.A_BODY], m.contact[n, at.B_BODY]
        return rate + TURNS * (abs(m.body[a, at.W]) + abs(m.body[b, at.W]) + TURNS)
    return -rate if m.contact_memory[n, at.SLIPS] == 1.0 else rate


@compiled
def rate_noise(m, n):
    """Rate of clutch n that may be rounding [rad/s]."""
    a, b = m.contact[n, at.A_BODY], m.contact[n, at.B_BODY]
    return STILL * (abs(m.body[a, at.W]) + abs(m.body[b, at.W])) + LEAST


@compiled
def gets_ahead(m, n):
    """True if A turns faster than B in the sense of clutch n, by more than rounding."""
    return m.contact_kinematics[n, at.DGAP] < -rate_noise(m, n)


@compiled
def left_of_soft(m, n):
    """What is left of the state of a clutch without impacts: its torque [N*m], or its rate if it is free [rad/s].

    0 where it may be rounding, as between shafts that rest.
    """
    left, noise, p = m.contact_kinematics[n, at.DGAP], rate_noise(m, n), m.contact[n, at.NORMAL_P]
    if m.contact_memory[n, at.CLOSED] == at.SHUT:
        left, noise = m.contact_kinematics[n, at.NORMAL], (m.values[p + at.OIL] + m.values[p + at.WIND_UP]) * noise
    return left if abs(left) > noise else 0.0


@compiled
def torque_noise(m):
    """Torque that may be rounding [N*m]: a share of the largest one that acts on a body or in a clutch."""
    contact, kinematics, force, largest = m.contact, m.contact_kinematics, m.force, 0.0
    for i in range(1, force.shape[0]):
        largest = max(largest, abs(force[i, 2]))
    for n in range(contact.shape[0]):
        if contact[n, at.LEVEL] == 1:
            largest = max(largest, abs(kinematics[n, at.NORMAL]))
    return NOISE * largest


@compiled
def settle_slips(m, slips):
    """Clutches with a largest torque slip where A gets ahead; those without a rate are to be decided.

    slips: one that begins to slip now, or -1.
    """
    contact, memory = m.contact, m.contact_memory
    for n in range(contact.shape[0]):
        memory[n, at.IDLE], memory[n, at.NO_SLIP] = 0.0, 0.0
        if contact[n, at.IMPACT] == 1 and not takes_impulses(m, n):
            memory[n, at.SLIPPED] = memory[n, at.SLIPS]
            memory[n, at.SLIPS] = 1.0 if n == slips or gets_ahead(m, n) else 0.0


@compiled
def note_slip(m, n, t):
    """Record that clutch n, which did not hold before, begins to slip at t [s], or is overrun after slipping."""
    memory = m.contact_memory
    if memory[n, at.SLIPS] != memory[n, at.SLIPPED]:
        note(m, at.SLIP_EVENT if memory[n, at.SLIPS] == 1.0 else at.RELEASE_EVENT, n, t, 0.0)


@compiled
def undecided_is_free(m, n):
    """True if clutch n stays overrun where neither torque nor acceleration decides; at the start of a run it locks."""
    return m.contact[n, at.LEVEL] == 1 and m.mode[n] == OFF and m.tally[at.STEPS] > 0


@compiled
def overloaded(m, count):
    """Let active clutches slip that would need more than their largest torque; True if there are any."""
    contact, memory, active, side = m.contact, m.contact_memory, m.active, m.side
    any_slips = False
    for k in range(count):
        n = active[k]
        if contact[n, at.LEVEL] == 1 and side[F, 2 * k] > (1.0 + OVER) * most_torque(m, n):
            memory[n, at.SLIPS] = 1.0
            any_slips = True
    return any_slips


@compiled
def held_back(m, broken):
    """Let clutches be decided anew that slip from rest while the accelerations carry A back; True if there are any.

    They were overloaded beside others that slip too.  broken: the clutch that has to slip, or -1.
    """
    memory, acceleration, any_held = m.contact_memory, m.acceleration, False
    for n in range(m.contact.shape[0]):
        if n == broken or memory[n, at.SLIPS] != 1.0 or gets_ahead(m, n):
            continue
        a, b = m.contact[n, at.A_BODY], m.contact[n, at.B_BODY]
        parting = m.contact_kinematics[n, at.TURN] * (acceleration[a, 2] - acceleration[b, 2])
        if parting > BACK * (abs(acceleration[a, 2]) + abs(acceleration[b, 2])):
            memory[n, at.SLIPS] = 0.0
            any_held = True
    return any_held


@compiled
def pushed_on(m, count):
    """Let the first active clutch slip that the joints drive on, or that must give way if all is to; True if there is.

    Its row in b approaches.  It needs a largest torque.
    """
    contact, memory, active, side = m.contact, m.contact_memory, m.active, m.side
    worst, who = 0.0, -1
    for k in range(count):
        n = active[k]
        if contact[n, at.LEVEL] == 1 and most_torque(m, n) < math.inf and side[B, 2 * k] < worst:
            worst, who = side[B, 2 * k], n
    if who >= 0:
        memory[who, at.SLIPS] = 1.0
    return who >= 0


@compiled
def driven_on(m, count):
    """Let active clutches slip whose rows the joints fix and drive on; True if there are any."""
    contact, memory, active, side, any_slips = m.contact, m.contact_memory, m.active, m.side, False
    for k in range(count):
        n = active[k]
        limited = contact[n, at.LEVEL] == 1 and most_torque(m, n) < math.inf
        if limited and m.row_fixed[2 * n] != 0 and side[B, 2 * k] < 0.0:
            memory[n, at.SLIPS] = 1.0
            any_slips = True
    return any_slips


@compiled
def rate_with(m, n, v):
    """Rate of clutch n [rad/s] with the rates v (3 nb,) [m/s, rad/s]."""
    a, b = m.contact[n, at.A_BODY], m.contact[n, at.B_BODY]
    return -m.contact_kinematics[n, at.TURN] * ((v[3 * b - 1] if b > 0 else 0.0) - (v[3 * a - 1] if a > 0 else 0.0))


@compiled
def slips_changed(m, h, count, v):
    """After a step with impulses, and with free rates v (3 nb,): clutches that begin or cease to slip, True if any do.

    Those of the `count` active ones that would need more than the largest torque over the step, and those that slip but
    would be overrun at its end.  The step is to be repeated with them.
    """
    contact, memory, active, side, dv = m.contact, m.contact_memory, m.active, m.side, m.velocity_change
    changed, limited = False, False
    for n in range(contact.shape[0]):
        limited = limited or (contact[n, at.IMPACT] == 1 and not takes_impulses(m, n))
    if not limited:
        return False
    push_all(m, count)
    for n in range(contact.shape[0]):
        if memory[n, at.SLIPS] == 1.0:
            a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
            if rate_with(m, n, v) + m.contact_kinematics[n, at.TURN] * (dv[b, 2] - dv[a, 2]) > 0.0:
                memory[n, at.SLIPS] = 0.0
                changed = True
    for k in range(count):
        n = active[k]
        if contact[n, at.LEVEL] == 1 and side[F, 2 * k] > (1.0 + OVER) * h * most_torque(m, n):
            memory[n, at.SLIPS] = 1.0
            changed = True
    return changed


@compiled
def book_slips(m, h, y, y_new):
    """Torques, impulses and losses over a step of length h [s] from y to y_new of the clutches that slip."""
    kinematics, memory, nq = m.contact_kinematics, m.contact_memory, m.change.shape[0]
    for n in range(m.contact.shape[0]):
        if memory[n, at.SLIPS] == 1.0:
            most, account = most_torque(m, n), account_at(m, n)
            rate = 0.5 * (rate_with(m, n, y[nq : 2 * nq]) + rate_with(m, n, y_new[nq : 2 * nq]))
            kinematics[n, at.NORMAL] = most
            y_new[account + IMPULSE] += h * most
            kinematics[n, at.LOSS] = -most * rate
            y_new[account + LOSS] -= h * most * rate
