"""Contacts that nothing can move: at rest, and held there by the joints or by other contacts whatever their own force.

Two clutches side by side, a backstop beside a stop, a clutch across a pin that cannot turn: the row of such a contact
is a combination of those of the joints and of closed contacts, and its force is not determined by the motion.  It needs
no mode: it is idle, without a force, until the next event, or until it moves after all.
"""

from __future__ import annotations

from rattle.equations.complementarity import (
    EXACT,
    LOOSE,
    OFF,
    STICK,
    A,
    diagonalise,
    doubt,
    friction_of,
    mode_of_closing,
    resolution,
)
from rattle.equations.dry_friction import DEPENDENT, mobility, rounding
from rattle.equations.unilateral import contact_rows
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.dry_friction_modes import in_doubt, sudden
from rattle.solvers.nonsmooth.contact_projection import closed_contacts
from rattle.solvers.nonsmooth.rubbing_impacts import row_response


@compiled
def held_by_closed(m, count, k, d):
    """True if the closed ones of the active contacts keep contact k where it is: its row is one of theirs.

    d = 0: along its normal, 1: along its wall.
    """
    candidate, g, system = m.candidate, m.delassus, m.system
    if m.held[at.SPARSE] == 1.0:
        return False
    row, size, scale = 2 * k + d, 0, 0.0
    for r in range(2 * count):
        if not holds_row(candidate, r):
            continue
        column = 0
        for s in range(2 * count):
            if holds_row(candidate, s):
                system[size, column] = g[r, s]
                column += 1
        system[size, column] = g[r, row]
        size, scale = size + 1, max(scale, g[r, r])
    diagonalise(system, m.pivots, size, max(scale, m.held[at.NOISE] / EXACT))
    left, column = g[row, row], 0
    for s in range(2 * count):
        if holds_row(candidate, s):
            r = m.pivots[column]
            left -= g[row, s] * system[r, size] / system[r, column] if r >= 0 else 0.0
            column += 1
    return size > 0 and abs(left) <= max(DEPENDENT * g[row, row], m.held[at.NOISE])


@compiled
def doubt_holders(m, count):
    """Note the contacts of the last `held_by_closed`: what holds another one might press more, and that one too."""
    system, size, column = m.system, 0, 0
    for s in range(2 * count):
        size += 1 if holds_row(m.candidate, s) else 0
    for s in range(2 * count):
        if holds_row(m.candidate, s):
            r = m.pivots[column]
            if r >= 0 and abs(system[r, size]) > DEPENDENT * abs(system[r, column]):
                doubt(m, m.active[s // 2], 1.0)
            column += 1


@compiled
def note_pressed(m):
    """Note which joints that rub are at rest because closed contacts hold them, beside their friction.

    Such a coordinate has a sense of slip, but no slip, whose rate would be an event by rounding.  One that a contact
    moves, as a driven pin does a slotted yoke, is at rest for an instant only: where it turns back.
    """
    memory, candidate, g, system = m.dry_memory, m.candidate, m.delassus, m.system
    count = closed_contacts(m, closed_contacts(m, 0, 0), 1)
    if count > 0:
        contact_rows(m, count)
    for n in range(memory.shape[0]):
        memory[n, at.DRY_PRESSED] = 0.0
        if count == 0 or m.held[at.SPARSE] == 1.0 or abs(memory[n, at.DRY_RATE]) > rounding(m, n):
            continue
        if abs(sudden(m, n)) > in_doubt(m, n, -1):
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
def kept_still(m, count, k):
    """True if closed contacts hold open contact k, and along its wall too unless it is smooth or slides anyway.

    They are noted: see `doubt_holders`.
    """
    sticks = mode_of_closing(m.slide[k], friction_of(m, m.active[k])) == STICK
    if (sticks and not held_by_closed(m, count, k, 1)) or not held_by_closed(m, count, k, 0):
        return False
    doubt_holders(m, count)
    return True


@compiled
def slides_without_slip(m, count, k, rate):
    """True if contact k has the friction of sliding, but closed contacts hold it along its wall too.

    Its slip is rounding from now on, whose sign is no event.  rate: acceleration that counts as none.
    """
    if m.candidate[k] == OFF or m.candidate[k] == STICK or m.slide[k] != 0 or friction_of(m, m.active[k]) == 0.0:
        return False
    return abs(m.side[A, 2 * k + 1]) <= LOOSE * rate and held_by_closed(m, count, k, 1)


@compiled
def let_idle(m, count):
    """Active contacts of the present solution become idle that the joints fix, or closed contacts hold.

    An idle clutch is off, any other contact closed, and sticks or slides as it moves.
    """
    contact, memory, active, candidate, side = m.contact, m.contact_memory, m.active, m.candidate, m.side
    for k in range(count):
        n = active[k]
        _, rate = resolution(m, count)
        memory[n, at.NO_SLIP] = 1.0 if slides_without_slip(m, count, k, rate) else 0.0
        still = candidate[k] == OFF and abs(side[A, 2 * k]) <= LOOSE * rate
        if contact[n, at.LEVEL] == 1 and m.row_fixed[2 * n] != 0:
            still = side[A, 2 * k] == 0.0
        elif still:
            still = kept_still(m, count, k)
        if still:
            candidate[k] = OFF if contact[n, at.LEVEL] == 1 else mode_of_closing(m.slide[k], friction_of(m, n))
            memory[n, at.IDLE] = 1.0
            doubt(m, n, 1.0)
