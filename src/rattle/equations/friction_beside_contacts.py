"""Dry friction of joints beside set-valued contacts: each changes the reactions by which the other acts.

A force f of a contact changes accelerations by -Y_c f and multipliers by -Z_c f, and thereby the friction tau of the
joints.  To first order, with J of `dry_friction.set_up`,

    J dtau = (w . Y_c of sticking joints, s mu dL/dlambda . Z_c of slipping ones) f,     Y_c -> Y_c - Y dtau

With these responses the problem of the contacts is solved as without friction of joints, G being no longer symmetric.
It is exact where joints stick; where they slip, L is not linear and the solution is repeated with the forces found.
"""

from __future__ import annotations

from rattle.equations.complementarity import friction_of
from rattle.equations.dry_friction import (
    DEPENDENT,
    bearing,
    borne_from,
    eliminate,
    mobility,
    presses_roller,
    resisting,
    sense_of,
    set_up,
)  # fmt: skip
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native

BY_FRICTION = 2  # in `row_fixed`: joints that stick hold the row


@compiled
def pull(m, r, n):
    """Right-hand side of dtau of joint n for a unit force in row r of the active contacts."""
    dry, line, memory = m.dry, m.dry_rows, m.dry_memory
    if memory[n, at.DRY_MODE] == at.DRY_STICKS and dry[n, at.DRY_LAW] < 0:
        if memory[n, at.DRY_HELD] == 1.0:
            return 0.0
        total = 0.0
        for k in range(3):
            a, b = dry[n, at.DRY_A], dry[n, at.DRY_B]
            if a > 0:
                total += line[n, at.AX + k] * m.velocity_response[r, 3 * a - 3 + k]
            if b > 0:
                total += line[n, at.BX + k] * m.velocity_response[r, 3 * b - 3 + k]
        return total / mobility(m, n, n)
    first, second = bearing(m, n, m.multiplier, at.DRY_FORCE)
    _, slope, slope2 = resisting(m, n, first, second)
    by_first, by_second = borne_from(m, n, m.multiplier_response, r)
    return -sense_of(m, n) * (slope * by_first + slope2 * by_second)


@compiled
def couple_responses(m, count):
    """Add to the responses to the forces of the active contacts those of the friction of joints."""
    share, system, joints = m.dry_share, m.dry_system, m.dry.shape[0]
    response, reaction = m.velocity_response, m.multiplier_response
    for r in range(2 * count):
        for n in range(joints):
            share[n, r] = 0.0
        if r % 2 == 1 and friction_of(m, m.active[r // 2]) == 0.0:
            continue
        set_up(m, 1.0)
        for n in range(joints):
            system[n, joints] = pull(m, r, n)
        eliminate(system, joints)
        for n in range(joints):
            share[n, r] = system[n, joints]
        for n in range(joints):
            for c in range(response.shape[1]):
                response[r, c] -= m.dry_response[n, 3 + c] * share[n, r]
            for row in range(reaction.shape[1]):
                reaction[r, row] -= m.dry_reaction[n, row] * share[n, r]


@native("void", "h", "i")
def couple(m, count):
    """Add to the responses to the forces of the active contacts those of the friction of joints, and to G."""
    contact, active, w, response = m.contact, m.active, m.contact_jacobian, m.velocity_response
    couple_responses(m, count)
    for r in range(2 * count):
        a, b = contact[active[r // 2], at.A_BODY], contact[active[r // 2], at.B_BODY]
        before = abs(m.delassus[r, r])
        for s in range(2 * count):
            value = 0.0
            for q in range(3):
                if a > 0:
                    value += w[r, q] * response[s, 3 * a - 3 + q]
                if b > 0:
                    value += w[r, 3 + q] * response[s, 3 * b - 3 + q]
            m.delassus[r, s] = value
        # joints that stick hold it: what is left is rounding
        if before > 0.0 and abs(m.delassus[r, r]) <= DEPENDENT * before:
            m.row_fixed[2 * active[r // 2] + r % 2] = BY_FRICTION
            for s in range(2 * count):
                m.delassus[r, s] = 0.0


@native("void", "h", "i", "v")
def follow(m, count, f):
    """Friction of joints follows the forces f [N] of the active contacts, which were added with their responses."""
    memory, share = m.dry_memory, m.dry_share
    for n in range(memory.shape[0]):
        for r in range(2 * count):
            memory[n, at.DRY_FORCE] += share[n, r] * f[r]
            memory[n, at.DRY_ADDED] += share[n, r] * f[r]
            if presses_roller(m, n, r):
                memory[n, at.DRY_PRESS] += f[r]
