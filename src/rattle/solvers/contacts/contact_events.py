"""Starts and ends of compliant contacts inside a step: detected, located on the dense output, stored in contact memory.

The contact memory (closed or open, approach speed v0, bristle state) changes only here, at the located instants, so
that each step has a smooth right-hand side.

No contact and no release is missed because it is shorter than a step: see `gap_search`.

A contact with stated damping ends where its force does, inside its wall (RELEASED).  There it is without force until
its gap opens, or until the force would push again: that is another contact.  What its spring gives meanwhile is lost.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.equations.compliant import add_contact_forces, contact_duration, locate_contacts, push
from rattle.equations.motion import place
from rattle.equations.one_way import goes_under, passes
from rattle.equations.state import IMPULSE, LOSS, STORED, account_at, clear_states, take_states
from rattle.equations.worn_contact import worn_energy
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.families import call_stiffness
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.clutches import gets_ahead, left_of_soft
from rattle.solvers.contacts.event_rows import note_end
from rattle.solvers.contacts.gap_search import NONE, gap_at, may_reach, rounding, search
from rattle.solvers.contacts.penetration import is_open
from rattle.solvers.dense_output import HALVINGS, INSTANT, interpolate

PARTS = 16  # samples in a step of what is left of the mode of a clutch
DIPS = 4  # parabolas through a least value between them
GAUSS, WEIGHTS = (np.array(column) for column in np.polynomial.legendre.leggauss(8))
PEAK_PARTS = 8  # samples of a force in a step
FLAT = 0.1  # share by which the force between two samples may be larger than at them
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
PEAK_WIDTH = 1e-6  # share of a step in which the largest force is enclosed: its error is the square of that
FIRST_STEP = 0.01  # of a contact, as a share of its expected duration: its force starts with a fractional power
LATER = 1e-7  # largest share of a step at which a contact changes whose gap had the wrong sign at its start by rounding
LEFT = 1e-13  # share of what is left of the mode of a clutch at the start of a step, which is rounding below zero
INSIDE = 1e-3  # share of a step next to its ends in which a peak is none inside of it
NEAR_PEAK = 0.7  # share of the peak so far that a force at an end of a step exceeds if a higher one may be inside
AFTER_CONTACT = 0.3  # share of the last step before a contact that the step after it may have at once


@native("void", "h", "f", "v")
def start_contacts(m, t, y):
    """Set the contact memory of every compliant contact at the start of a run, t [s]."""
    contact, kinematics, memory, nq = m.contact, m.contact_kinematics, m.contact_memory, m.change.shape[0]
    place(m, y[:nq], y[nq : 2 * nq])
    locate_contacts(m)
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            continue
        memory[n, at.CLOSED] = at.OPEN
        if kinematics[n, at.GAP] < 0.0 or (contact[n, at.LEVEL] == 1 and gets_ahead(m, n)):
            shut(m, n, t, y)
            if contact[n, at.LEVEL] == 0:  # as a belt with its pretension: what it holds may be given back
                y[account_at(m, n) + STORED] = strain_energy(m, n, -kinematics[n, at.GAP])


@compiled
def strain_energy(m, n, delta):
    """Integral of the static force of contact n from 0 to delta [m], in J; by x = delta s^2, as F ~ x^1.5 at first."""
    contact, total = m.contact, 0.0
    if contact[n, at.WORN] == 1:
        return worn_energy(m, n)
    for k in range(GAUSS.shape[0]):
        s = 0.5 * (1.0 + GAUSS[k])
        arguments = (delta * s * s, m.values, contact[n, at.STATIC_P])
        total += WEIGHTS[k] * s * call_stiffness(m.stiffness_table[contact[n, at.STATIC]], arguments)
    return delta * total


@compiled
def shut(m, n, t, y):
    """Contact n starts at (t, y); its geometry is in `contact_kinematics`."""
    kinematics, memory = m.contact_kinematics, m.contact_memory
    k = account_at(m, n)
    memory[n, at.CLOSED] = at.SHUT
    memory[n, at.SPEED] = max(-kinematics[n, at.DGAP], 0.0)
    memory[n, at.SINCE] = t
    memory[n, at.PEAK] = 0.0
    memory[n, at.N_0] = 0.0
    memory[n, at.STEPS_IN] = 0.0
    clear_states(m, n, y)
    memory[n, at.IMPULSE_0] = y[k + IMPULSE]
    memory[n, at.LOSS_0] = y[k + LOSS] + y[k + STORED]


@compiled
def contact_time(m, n):
    """Estimated duration of contact n [s]; 0 if unknown."""
    contact, mass, speed = m.contact, m.mass, m.contact_memory[n, at.SPEED]
    a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
    if contact[n, at.LEVEL] == 1:
        return 0.0
    q = 2 if m.lever[n, at.ANGULAR] > 0.0 else 0
    of_a, of_b = float(mass[a, q]), float(mass[b, q])  # 0 of the ground, and of points of it that move
    light = of_b if of_a == 0.0 else (of_a if of_b == 0.0 else min(of_a, of_b))
    if speed <= 0.0:
        return 0.0
    return contact_duration(m.stiffness_table[contact[n, at.STATIC]], m.values, contact[n, at.STATIC_P], light, speed)


@compiled
def remember_end(m):
    """Store gaps, their rates and forces [SI] at the end of the step just computed."""
    kinematics, memory = m.contact_kinematics, m.contact_memory
    for n in range(kinematics.shape[0]):
        memory[n, at.GAP_1], memory[n, at.DGAP_1], memory[n, at.N_1] = (
            kinematics[n, at.GAP],
            kinematics[n, at.DGAP],
            kinematics[n, at.NORMAL],
        )


@compiled
def pass_on(m):
    """Make the values at the end of this step those at the start of the next."""
    memory = m.contact_memory
    for n in range(memory.shape[0]):
        memory[n, at.GAP_0], memory[n, at.DGAP_0], memory[n, at.N_0] = (
            memory[n, at.GAP_1],
            memory[n, at.DGAP_1],
            memory[n, at.N_1],
        )


@compiled
def may_any_change(m, h):
    """True if any contact may start or end in the step of length h [s]."""
    contact, memory = m.contact, m.contact_memory
    for n in range(contact.shape[0]):
        pressed = memory[n, at.CLOSED] == at.SHUT or memory[n, at.CLOSED] == at.RELEASED
        if contact[n, at.LEVEL] == 1 or (contact[n, at.BY_FORCE] == 1 and pressed):
            return True
        if contact[n, at.IMPACT] == 0 and may_reach(m, h, n, -1.0 if memory[n, at.CLOSED] == at.SHUT else 1.0):
            return True
    return False


@compiled
def normal_at(m, theta, n):
    """Normal force of contact n [N] at the share theta of the step."""
    kinematics, stage, nq = m.contact_kinematics, m.stage, m.change.shape[0]
    interpolate(m, theta, stage)
    take_states(m, stage)
    place(m, stage[:nq], stage[nq : 2 * nq])
    locate_contacts(m)
    add_contact_forces(m)
    return kinematics[n, at.NORMAL]


@compiled
def left_at(m, h, n, theta):
    """What is left of the present mode of a contact at the share theta of the step.

    Of a clutch its torque, or its rate if it is free; of a contact that ends by its force what it pushes, or lacks.
    """
    if m.contact[n, at.BY_FORCE] == 1:
        gap, rate = gap_at(m, theta, n)
        pushes = push(m, n, gap, rate)[1]
        return pushes if m.contact_memory[n, at.CLOSED] == at.SHUT else -pushes
    normal_at(m, theta, n)
    return left_of_soft(m, n)


@compiled
def lowest_between(m, h, n, middle, wide, before, here, after):
    """Place and value of the least that is left near the least of three samples, `wide` apart, by parabolas."""
    best = here
    for _ in range(DIPS):
        bend = before - 2.0 * here + after
        if not bend > 0.0:
            break
        there = middle + 0.5 * wide * (before - after) / bend
        value = left_at(m, h, n, there)
        if value < best:
            best, middle, here = value, there, value
        if value < 0.0:
            break
        wide *= 0.25
        before, after = left_at(m, h, n, middle - wide), left_at(m, h, n, middle + wide)
    return middle, best


@compiled
def turn_between(m, h, n, low, high):
    """Share of the step between low and high at which nothing is left of the mode of contact n, as at high.

    What starts from zero by rounding must first grow.
    """
    share = 0.5 * (high - low)
    while left_at(m, h, n, low) <= 0.0 and share > LATER * high:
        if left_at(m, h, n, low + share) > 0.0:
            low += share
        share *= 0.5
    left = left_at(m, h, n, low)
    if left < 0.0 or (left == 0.0 and m.contact[n, at.LEVEL] == 0):
        return low
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high or (high - low) * h <= INSTANT * abs(m.clock[at.T]):
            break
        if left_at(m, h, n, middle) < 0.0:
            high = middle
        else:
            low = middle
    return high


@native("f", "h", "f", "i", "f")
def first_turn(m, h, n, until):
    """Share of the step, up to `until`, at which nothing is left of the mode of contact n; NONE if it lasts.

    Needs the dense output.  PARTS samples, and the least value between them where three samples show one.
    """
    first = before = here = left_at(m, h, n, 0.0)
    wide, slight = until / PARTS, LEFT * abs(first)
    for part in range(1, PARTS + 1):
        value = left_at(m, h, n, part * wide)
        if part > 1 and here > 0.0 and value > 0.0 and here <= before and here <= value:
            low, least = lowest_between(m, h, n, (part - 1) * wide, wide, before, here, value)
            if least < 0.0:
                return turn_between(m, h, n, (part - 2) * wide, low)
        if value < -slight:
            return turn_between(m, h, n, (part - 1) * wide, part * wide)
        before, here = here, value
    return NONE


@compiled
def beyond_rounding(m, h, n, side):
    """Least share of the step (length h [s]) at which contact n changes; 0 if its gap is more than rounding before.

    Otherwise its gap grows by rounding until then, and no more, so that it does not change back and is not inside its
    wall either.
    """
    memory, slight = m.contact_memory[n], rounding(m, n)
    if side * memory[at.GAP_0] > slight:
        return 0.0
    way = -side * memory[at.DGAP_0] * h
    if side > 0.0 and way < 0.0:  # it opens at first: where it closes, it has come back
        return 0.0
    return LATER if way * LATER <= slight else slight / way


@native("fi", "h", "f", "f")
def first_change(m, h, until):
    """Share of the step, up to `until`, at which the first contact starts or ends, and its index; NONE if none does."""
    contact, memory, best, who = m.contact, m.contact_memory, NONE, -1
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            continue
        side = 1.0 if memory[n, at.CLOSED] == at.OPEN else -1.0
        if contact[n, at.LEVEL] == 0 and may_reach(m, h, n, side):  # where its gap changes sign
            share = max(search(m, h, n, side, min(best, until)), beyond_rounding(m, h, n, side))
            if share < best:
                best, who = share, n
        if contact[n, at.LEVEL] == 1 or (contact[n, at.BY_FORCE] == 1 and side < 0.0):
            share = first_turn(m, h, n, min(best, until))
            if share < best:
                best, who = max(share, LATER), n
    return best, who


@compiled
def near_peak(m):
    """True if the force of a compliant contact may have its maximum inside the step."""
    contact, memory = m.contact, m.contact_memory
    for n in range(memory.shape[0]):
        shut = contact[n, at.IMPACT] == 0 and memory[n, at.CLOSED] == at.SHUT
        if shut and max(memory[n, at.N_0], memory[n, at.N_1]) > NEAR_PEAK * memory[n, at.PEAK]:
            return True
    return False


@compiled
def highest_force(m, n, until):
    """Largest force [N] of compliant contact n up to the share `until` of the step, from the dense output; its share.

    By samples, and by golden section around the largest of them, the ends of the step included.
    """
    high, best = 0.0, 0
    for part in range(PEAK_PARTS + 1):
        force = normal_at(m, until * part / PEAK_PARTS, n)
        if force > high:
            high, best = force, part
    if high <= m.contact_memory[n, at.PEAK] * (1.0 - FLAT):
        return high, until * best / PEAK_PARTS
    low, top = until * max(best - 1, 0) / PEAK_PARTS, until * min(best + 1, PEAK_PARTS) / PEAK_PARTS
    left, right = top - GOLDEN * (top - low), low + GOLDEN * (top - low)
    first, second = normal_at(m, left, n), normal_at(m, right, n)
    while top - low > PEAK_WIDTH:
        high = max(high, first, second)
        if first > second:
            top, right, second = right, left, first
            left = top - GOLDEN * (top - low)
            first = normal_at(m, left, n)
        else:
            low, left, first = left, right, second
            right = low + GOLDEN * (top - low)
            second = normal_at(m, right, n)
    return max(high, first, second), 0.5 * (low + top)


@native("f", "h", "f", "i")
def find_peaks(m, until, sampled):
    """Largest force [N] of every compliant contact up to the share `until` of the step.

    sampled: also from the dense output.  Returns the share at which one has a new peak inside of that; NONE: none has.
    """
    contact, memory, summit = m.contact, m.contact_memory, NONE
    for n in range(memory.shape[0]):
        if contact[n, at.IMPACT] == 1 or memory[n, at.CLOSED] != at.SHUT:
            continue
        memory[n, at.STEPS_IN] += 1.0
        high = max(memory[n, at.N_0], memory[n, at.N_1] if until >= 1.0 else 0.0)
        if sampled and max(memory[n, at.N_0], memory[n, at.N_1]) > NEAR_PEAK * memory[n, at.PEAK]:
            top, share = highest_force(m, n, until)
            if top > max(high, memory[n, at.PEAK]) and INSIDE * until < share < (1.0 - INSIDE) * until:
                summit = share
            high = max(high, top)
        memory[n, at.PEAK] = max(memory[n, at.PEAK], high)
    return summit


@compiled
def change_contacts(m, who, t, y):
    """Contact `who` starts or ends at (t, y), others with it; events are recorded."""
    contact, kinematics, memory, nq = m.contact, m.contact_kinematics, m.contact_memory, m.change.shape[0]
    place(m, y[:nq], y[nq : 2 * nq])
    locate_contacts(m)
    was_shut, was_released = memory[who, at.CLOSED] == at.SHUT, memory[who, at.CLOSED] == at.RELEASED
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            continue
        if memory[n, at.CLOSED] == at.OPEN:
            if (n == who and not was_shut) or (kinematics[n, at.GAP] <= 0.0 and kinematics[n, at.DGAP] < 0.0):
                shut(m, n, t, y)
        elif n == who and was_released:
            take_again(m, n, t, y)
        elif n == who and was_shut:
            let_go(m, n, t, y)


@compiled
def let_go(m, n, t, y):
    """Contact n ends at (t, y) where its gap opens, or where its force does that never pulls."""
    if m.contact[n, at.BY_FORCE] == 1 and m.contact_kinematics[n, at.GAP] < 0.0:
        spend(m, n, t, y)
    else:
        open_up(m, n, t, y)


@compiled
def open_up(m, n, t, y):
    """Contact n ends at (t, y); its geometry is in `contact_kinematics`."""
    k = account_at(m, n)
    note_end(m, n, t, y, max(m.contact_kinematics[n, at.DGAP], 0.0))
    y[k + LOSS] += y[k + STORED]  # stored energy left by rounding is lost
    y[k + STORED] = 0.0
    clear_states(m, n, y)
    m.contact_memory[n, at.CLOSED] = at.OPEN


@compiled
def spend(m, n, t, y):
    """Contact n ends at (t, y) inside its wall, where its force does; what its spring holds is lost until it opens."""
    note_end(m, n, t, y, max(m.contact_kinematics[n, at.DGAP], 0.0))
    clear_states(m, n, y)
    m.contact_memory[n, at.CLOSED] = at.RELEASED


@compiled
def take_again(m, n, t, y):
    """Contact n, without force inside its wall, is out of it at (t, y), or pushes again."""
    m.contact_memory[n, at.CLOSED] = at.OPEN
    depth, k, held = -m.contact_kinematics[n, at.GAP], account_at(m, n), 0.0
    if depth > rounding(m, n):
        held = strain_energy(m, n, depth)
    y[k + LOSS] += y[k + STORED] - held  # what the spring has given since its force ended
    y[k + STORED] = held
    if held > 0.0:
        shut(m, n, t, y)


@compiled
def turn_clutches(m, t, y):
    """Viscous and compliant clutches take or let go at (t, y), where rates have jumped."""
    contact, kinematics, memory, nq = m.contact, m.contact_kinematics, m.contact_memory, m.change.shape[0]
    for n in range(contact.shape[0]):
        if contact[n, at.LEVEL] == 0 or contact[n, at.IMPACT] == 1:
            continue
        take_states(m, y)
        place(m, y[:nq], y[nq : 2 * nq])
        locate_contacts(m)
        add_contact_forces(m)
        shut_before = memory[n, at.CLOSED] == at.SHUT
        if shut_before and kinematics[n, at.NORMAL] < 0.0:
            open_up(m, n, t, y)
        elif not shut_before and gets_ahead(m, n):
            shut(m, n, t, y)


@compiled
def let_others_under(m, who):
    """Open contacts beside `who` that come under a segment from its side at the same instant touch nothing there."""
    changed = False
    for n in range(m.contact.shape[0]):
        if n != who and is_open(m, n) and goes_under(m, n, rounding(m, n)):
            changed = True
    if changed:
        locate_contacts(m)


@native("void", "h", "i", "f", "v")
def turn(m, who, t, y):
    """Contact `who` starts or ends at (t [s], y), see `change_contacts`; chooses the next step."""
    clock, tally, memory = m.clock, m.tally, m.contact_memory
    clock[at.H_STABLE] = math.inf
    let_others_under(m, who)
    if memory[who, at.CLOSED] != at.SHUT and passes(m, who, rounding(m, who)):
        return
    was_shut = memory[who, at.CLOSED] == at.SHUT
    if was_shut:
        clock[at.FEWEST] = min(clock[at.FEWEST], memory[who, at.STEPS_IN])
    elif memory[who, at.CLOSED] == at.OPEN:
        clock[at.H_FREE] = max(clock[at.H], 0.5 * clock[at.H_FREE])
    change_contacts(m, who, t, y)
    if was_shut:
        clock[at.H] = max(clock[at.H], AFTER_CONTACT * clock[at.H_FREE])
    if memory[who, at.CLOSED] != at.SHUT:
        return
    tally[at.CONTACTS] += 1
    lasting = contact_time(m, who)
    if lasting > 0.0:
        clock[at.H] = min(clock[at.H], FIRST_STEP * lasting)
