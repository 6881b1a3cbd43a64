"""Contacts that nothing can move: at rest, and held there by the joints or by other contacts whatever their own force.

Two clutches side by side, a backstop beside a stop, a clutch across a pin that cannot turn: the row of such a contact
is a combination of those of the joints and of closed contacts, and its force is not determined by the motion.  It needs
no mode: it is idle, without a force, until the next event, or until it moves after all.
"""

from __future__ import annotations

from rattle.equations.complementarity import (
    EXACT,
    FORWARD,
    LOOSE,
    OFF,
    STICK,
    A,
    diagonalise,
    friction_of,
    resolution,
)
from rattle.equations.dry_friction import DEPENDENT, mobility, rounding
from rattle.equations.unilateral import contact_rows
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.nonsmooth.contact_projection import closed_contacts
from rattle.solvers.nonsmooth.rubbing_impacts import row_response


@compiled
def held_by_closed(m, count, k):
    """True if the closed ones of the active contacts keep open contact k where it is: its row is one of theirs."""
    candidate, g, system = m.candidate, m.delassus, m.system
    if m.held[at.SPARSE] == 1.0:
        return False
    size, scale = 0, 0.0
    for r in range(2 * count):
        if not holds_row(candidate, r):
            continue
        column = 0
        for s in range(2 * count):
            if holds_row(candidate, s):
                system[size, column] = g[r, s]
                column += 1
        system[size, column] = g[r, 2 * k]
        size, scale = size + 1, max(scale, g[r, r])
    diagonalise(system, m.pivots, size, max(scale, m.held[at.NOISE] / EXACT))
    left, column = g[2 * k, 2 * k], 0
    for s in range(2 * count):
        if holds_row(candidate, s):
            r = m.pivots[column]
            left -= g[2 * k, s] * system[r, size] / system[r, column] if r >= 0 else 0.0
            column += 1
    if size == 0 or abs(left) > max(DEPENDENT * g[2 * k, 2 * k], m.held[at.NOISE]):
        return False
    column = 0
    for s in range(2 * count):  # what holds it might press more, and it too
        if holds_row(candidate, s):
            r = m.pivots[column]
            if r >= 0 and abs(system[r, size]) > DEPENDENT * abs(system[r, column]):
                m.contact_memory[m.active[s // 2], at.UNSURE] = 1.0
            column += 1
    return True


@compiled
def note_pressed(m):
    """Note which joints that rub are at rest because closed contacts hold them, beside their friction.

    Such a coordinate has a sense of slip, but no slip, whose rate would be an event by rounding.
    """
    memory, candidate, g, system = m.dry_memory, m.candidate, m.delassus, m.system
    count = closed_contacts(m, closed_contacts(m, 0, 0), 1)
    if count > 0:
        contact_rows(m, count)
    for n in range(memory.shape[0]):
        memory[n, at.DRY_PRESSED] = 0.0
        if count == 0 or m.held[at.SPARSE] == 1.0 or abs(memory[n, at.DRY_RATE]) > rounding(m, n):
            continue
        size, scale = 0, 0.0
        for r in range(2 * count):
            if not holds_row(candidate, r):
                continue
            column = 0
            for s in range(2 * count):
                if holds_row(candidate, s):
                    system[size, column] = g[r, s]
                    column += 1
            system[size, column] = row_response(m, n, r)
            size, scale = size + 1, max(scale, g[r, r])
        diagonalise(system, m.pivots, size, max(scale, m.held[at.NOISE] / EXACT))
        own = mobility(m, n, n)
        left, column = own, 0
        for s in range(2 * count):
            if holds_row(candidate, s):
                r = m.pivots[column]
                left -= row_response(m, n, s) * system[r, size] / system[r, column] if r >= 0 else 0.0
                column += 1
        memory[n, at.DRY_PRESSED] = 1.0 if abs(left) <= DEPENDENT * own else 0.0


@compiled
def holds_row(candidate, r):
    """True if the mode in `candidate` keeps the rate of row r of the active contacts at zero."""
    return candidate[r // 2] == STICK or (r % 2 == 0 and candidate[r // 2] != OFF)


@compiled
def let_idle(m, count):
    """Active contacts of the present solution become idle that the joints fix, or closed contacts hold.

    An idle clutch is off, any other contact closed.
    """
    contact, memory, active, candidate, side = m.contact, m.contact_memory, m.active, m.candidate, m.side
    for k in range(count):
        n = active[k]
        _, rate = resolution(m, count)
        still = candidate[k] == OFF and friction_of(m, n) == 0.0 and abs(side[A, 2 * k]) <= LOOSE * rate
        if contact[n, at.LEVEL] == 1 and m.row_fixed[2 * n] != 0:
            still = side[A, 2 * k] == 0.0
        elif still:
            still = held_by_closed(m, count, k)
        if still:
            candidate[k] = OFF if contact[n, at.LEVEL] == 1 else FORWARD
            memory[n, at.IDLE], memory[n, at.UNSURE] = 1.0, 1.0
