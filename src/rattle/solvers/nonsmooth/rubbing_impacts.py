"""Friction of joints in impacts: Coulomb's law for the impulses of their reactions.

    w . v+ = 0,  |P| <= mu L(Lambda)     or     P = -s mu L(Lambda),  s = sign(w . v+)

with L of `dry_friction`, which grows in proportion to the impulses Lambda of the joint.  So for given modes and
directions of Lambda everything is linear in the impulses f of the contacts,

    P = C + D f,     Lambda = -Z_c f + Z P,     v+ = v- - Y_c f + Y P,

and the impact is solved with responses that contain D, as in `friction_beside_contacts`, until Lambda keeps its
direction; then the modes are changed one by one.  Joints with a smooth law of friction take no part, nor do those
whose friction has a stated size: what is finite has no impulse.

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 8.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import F, friction_of
from rattle.equations.dry_friction import (
    DEPENDENT,
    bearing,
    borne,
    borne_from,
    eliminate,
    mobility,
    plain_row,
    prepare_rows,
    presses_roller,
    pressing,
    rounding,
    sticking_row,
)  # fmt: skip
from rattle.equations.state import DISSIPATED, energies_at
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native

NONE = 3.0  # mode of a joint that takes no part, besides those of `dry_memory`
AGREES = 1e-13  # share of the largest impulse of friction that ends the rounds for given modes
MOST_ROUNDS = 60
MOST_COMBINED = 729  # combinations of modes that are tried: those of six joints
BEYOND = 1e-10  # share by which a condition may be violated by rounding


@compiled
def row_response(m, n, r):
    """w_n . Y_c: rate of coordinate n per unit impulse in row r of the active contacts."""
    dry, line, total = m.dry, m.dry_rows, 0.0
    for k in range(3):
        a, b = dry[n, at.DRY_A], dry[n, at.DRY_B]
        if a > 0:
            total += line[n, at.AX + k] * m.velocity_response[r, 3 * a - 3 + k]
        if b > 0:
            total += line[n, at.BX + k] * m.velocity_response[r, 3 * b - 3 + k]
    return total


@compiled
def grip(m, n):
    """mu times the arm of joint n."""
    p = m.dry[n, at.DRY_P]
    return m.values[p + at.DRY_MU] * m.values[p + at.DRY_ARM]


@native("void", "h")
def begin_rubbing(m):
    """Rows and responses of friction at these positions; joints that slip go on at first, others rest.

    The directions of the reactions are open: those of the impact before would act where none has been computed yet.
    """
    memory = m.dry_memory
    prepare_rows(m)
    for row in range(m.impact_reaction.shape[0]):
        m.impact_reaction[row] = 0.0
    for n in range(memory.shape[0]):
        rate = memory[n, at.DRY_RATE]
        moves = abs(rate) > rounding(m, n)
        memory[n, at.IMPACT_MODE] = math.copysign(1.0, rate) if moves else at.DRY_STICKS
        finite = m.dry[n, at.DRY_LAW] >= 0 or m.dry[n, at.DRY_STATED] == 1
        if finite or (memory[n, at.DRY_HELD] == 1.0 and not moves):
            memory[n, at.IMPACT_MODE] = NONE
        memory[n, at.IMPACT_ALONE], memory[n, at.IMPACT_FRICTION], memory[n, at.IMPACT_PRESS] = 0.0, 0.0, 0.0


@compiled
def fill_system(m):
    """The matrix of the equations of all P for the present modes and directions of `impact_reaction`."""
    memory, system = m.dry_memory, m.dry_system
    count = memory.shape[0]
    for n in range(count):
        mode = memory[n, at.IMPACT_MODE]
        plain_row(m, n)
        system[n, count] = 0.0
        if mode == at.DRY_STICKS:
            sticking_row(m, n)
        elif mode != NONE:
            first, second = bearing(m, n, m.impact_reaction, at.IMPACT_FRICTION)
            _, slope, slope2 = pressing(m, n, first, second)
            for o in range(count):
                by_first, by_second = borne(m, n, o)
                system[n, o] += mode * grip(m, n) * (slope * by_first + slope2 * by_second)


@compiled
def solve_shares(m, r):
    """P of all joints per unit impulse in row r of the active contacts into `dry_share`; r = -1: C, without them."""
    memory, system = m.dry_memory, m.dry_system
    count = memory.shape[0]
    fill_system(m)
    for n in range(count):
        mode = memory[n, at.IMPACT_MODE]
        if mode == at.DRY_STICKS:
            system[n, count] = (row_response(m, n, r) if r >= 0 else -memory[n, at.DRY_RATE]) / mobility(m, n, n)
        elif mode != NONE and r >= 0:
            first, second = bearing(m, n, m.impact_reaction, at.IMPACT_FRICTION)
            _, slope, slope2 = pressing(m, n, first, second)
            by_first, by_second = borne_from(m, n, m.multiplier_response, r)
            system[n, count] = mode * grip(m, n) * (slope * by_first + slope2 * by_second)
    eliminate(system, count)
    for n in range(count):
        if r >= 0:
            m.dry_share[n, r] = system[n, count]
        else:
            memory[n, at.IMPACT_ALONE] = system[n, count]


@native("void", "h", "i")
def rub(m, count):
    """Add the friction of joints that the impulses of the active contacts cause to their responses, and to G."""
    contact, active, w, share = m.contact, m.active, m.contact_jacobian, m.dry_share
    response, reaction, joints = m.velocity_response, m.multiplier_response, m.dry.shape[0]
    solve_shares(m, -1)
    for r in range(2 * count):
        for n in range(joints):
            share[n, r] = 0.0
        if r % 2 == 1 and friction_of(m, active[r // 2]) == 0.0:
            continue
        solve_shares(m, r)
        for n in range(joints):
            for c in range(response.shape[1]):
                response[r, c] -= m.dry_response[n, 3 + c] * share[n, r]
            for row in range(reaction.shape[1]):
                reaction[r, row] -= m.dry_reaction[n, row] * share[n, r]
    for r in range(2 * count):
        a, b = contact[active[r // 2], at.A_BODY], contact[active[r // 2], at.B_BODY]
        free = abs(m.delassus[r, r])
        for s in range(2 * count):
            value = 0.0
            for q in range(3):
                if a > 0:
                    value += w[r, q] * response[s, 3 * a - 3 + q]
                if b > 0:
                    value += w[r, 3 + q] * response[s, 3 * b - 3 + q]
            m.delassus[r, s] = value
        if abs(m.delassus[r, r]) <= DEPENDENT * free:  # joints that stick hold it: what is left is rounding
            for s in range(2 * count):
                m.delassus[r, s] = 0.0


@compiled
def rate_alone(m, r, n):
    """Rate [m/s or rad/s] in row r of active contact n that the part C of friction adds."""
    total, a, b, w = 0.0, m.contact[n, at.A_BODY], m.contact[n, at.B_BODY], m.contact_jacobian
    for j in range(m.dry.shape[0]):
        for q in range(3):
            value = w[r, q] * m.dry_response[j, 3 * a + q] + w[r, 3 + q] * m.dry_response[j, 3 * b + q]
            total += value * m.dry_memory[j, at.IMPACT_ALONE]
    return total


@native("f", "h", "i")
def take_rubbing(m, count):
    """Impulses P and those of the joints for the present f; returns the largest change of P, as a share of them."""
    memory, side, percussion = m.dry_memory, m.side, m.impact_reaction
    change, largest = 0.0, 0.0
    for row in range(percussion.shape[0]):
        percussion[row] = 0.0
        for r in range(2 * count):
            percussion[row] -= m.multiplier_response[r, row] * side[F, r]
    for n in range(memory.shape[0]):
        impulse, pressing_impulse = memory[n, at.IMPACT_ALONE], 0.0
        for r in range(2 * count):
            impulse += m.dry_share[n, r] * side[F, r]
            if presses_roller(m, n, r):
                pressing_impulse = side[F, r]
        if m.dry[n, at.DRY_FORM] == at.DRY_ROLLER:
            memory[n, at.IMPACT_PRESS] = pressing_impulse
        for row in range(percussion.shape[0]):
            percussion[row] += m.dry_reaction[n, row] * memory[n, at.IMPACT_ALONE]
        change = max(change, abs(impulse - memory[n, at.IMPACT_FRICTION]))
        largest = max(largest, abs(impulse))
        memory[n, at.IMPACT_FRICTION] = impulse
    return change / largest if largest > 0.0 else 0.0


@compiled
def rate_after(m, n, count):
    """Rate of coordinate n after the impact [m/s or rad/s], and the size of its terms."""
    memory = m.dry_memory
    total, size = memory[n, at.DRY_RATE], abs(memory[n, at.DRY_RATE])
    for o in range(memory.shape[0]):
        value = mobility(m, n, o) * memory[o, at.IMPACT_ALONE]
        total += value
        size += abs(value)
    for r in range(2 * count):
        value = row_response(m, n, r) * m.side[F, r]
        total -= value
        size += abs(value)
    return total, size


@native("i", "h", "i")
def change_rubbing(m, count):
    """Change the mode of the joint that violates Coulomb's law most; False if none does."""
    memory, worst, who, sense = m.dry_memory, 0.0, -1, 0.0
    for n in range(memory.shape[0]):
        mode, impulse = memory[n, at.IMPACT_MODE], memory[n, at.IMPACT_FRICTION]
        if mode == NONE or memory[n, at.DRY_HELD] == 1.0:
            continue
        if mode == at.DRY_STICKS:
            first, second = bearing(m, n, m.impact_reaction, at.IMPACT_FRICTION)
            N, _, _ = pressing(m, n, first, second)
            most = grip(m, n) * N
            beyond = (abs(impulse) - most) / (abs(impulse) + most) if abs(impulse) > 0.0 else 0.0
            turned = -math.copysign(1.0, impulse)
        else:
            rate, size = rate_after(m, n, count)
            beyond = -mode * rate / size if size > 0.0 else 0.0
            backwards = mode * memory[n, at.DRY_RATE] > rounding(m, n)  # it may bounce back before it sticks
            turned = -mode if backwards else at.DRY_STICKS
        if beyond > max(worst, BEYOND):
            worst, who, sense = beyond, n, turned
    if who >= 0:
        memory[who, at.IMPACT_MODE] = sense
    return who >= 0


@compiled
def is_open(m, n):
    """True if joint n may stick or slip either way in the impact: it takes part, and its friction moves something."""
    return m.dry_memory[n, at.IMPACT_MODE] != NONE and m.dry_memory[n, at.DRY_HELD] == 0.0


@native("i", "h")
def combinations_of_rubbing(m):
    """Number of combinations of modes of the joints that rub; 0 if they are too many to be tried."""
    total = 1
    for n in range(m.dry_memory.shape[0]):
        total = min(total * (3 if is_open(m, n) else 1), 2 * MOST_COMBINED)
    return total if total <= MOST_COMBINED else 0


@native("void", "h", "i")
def take_rubbing_modes(m, code):
    """Combination number `code` of the modes of the joints that rub."""
    for n in range(m.dry_memory.shape[0]):
        if is_open(m, n):
            digit = code % 3
            code //= 3
            m.dry_memory[n, at.IMPACT_MODE] = -1.0 if digit == 2 else float(digit)


@native("void", "h", "v")
def add_rubbing(m, v):
    """Add to the rates v after an impact (3 nb,) what the part C of friction changes."""
    for n in range(m.dry.shape[0]):
        for c in range(v.shape[0]):
            v[c] += m.dry_response[n, 3 + c] * m.dry_memory[n, at.IMPACT_ALONE]


@native("void", "h", "i", "v")
def total_rubbing(m, count, percussion):
    """Impulses P of all joints for the final impulses of the contacts; percussion (nr,) gets that of the part C."""
    memory, reaction = m.dry_memory, m.dry_reaction
    for n in range(memory.shape[0]):
        alone = memory[n, at.IMPACT_ALONE]
        memory[n, at.IMPACT_FRICTION] = alone
        for r in range(2 * count):
            memory[n, at.IMPACT_FRICTION] += m.dry_share[n, r] * m.side[F, r]
        for row in range(percussion.shape[0]):
            percussion[row] += reaction[n, row] * alone


@native("void", "h")
def forget_rubbing(m):
    """No friction of joints in the impulses at hand."""
    for n in range(m.dry_memory.shape[0]):
        m.dry_memory[n, at.IMPACT_ALONE] = 0.0
        m.dry_memory[n, at.IMPACT_FRICTION] = 0.0


@native("void", "h", "v", "v")
def book_rubbing(m, y, before):
    """Losses [J] of friction in an impact; y holds the rates after it."""
    memory, nq = m.dry_memory, m.change.shape[0]
    for n in range(memory.shape[0]):
        mean = 0.0
        for side in range(2):
            i = m.dry[n, at.DRY_A + side]
            for k in range(3):
                if i > 0:
                    rate = 0.5 * (before[3 * i - 3 + k] + y[nq + 3 * i - 3 + k])
                    mean += m.dry_rows[n, at.AX + 3 * side + k] * rate
        y[energies_at(m) + DISSIPATED] -= memory[n, at.IMPACT_FRICTION] * mean
