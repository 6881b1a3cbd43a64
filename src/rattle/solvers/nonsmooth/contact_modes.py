"""New modes of set-valued contacts at an event, from the problem for the accelerations."""

from __future__ import annotations

from rattle.equations.complementarity import (
    BACKWARD,
    FORWARD,
    IMPOSSIBLE,
    OFF,
    OUTCOME,
    SOLVED,
    STICK,
    TRY_ALL,
    B,
    F,
    friction_of,
    linear,
)  # fmt: skip
from rattle.equations.motion import OK
from rattle.equations.state import IMPULSE, LOSS, account_at
from rattle.equations.unilateral import (
    NO_SOLUTION,
    NOT_UNIQUE,
    add_forces,
    along,
    contact_rows,
    count_solutions,
    ending,
    is_rough,
    lasting_side,
    solve_by_trying,
    solve_contacts,
)  # fmt: skip
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.functions import call_problem, compiled, native
from rattle.solvers.event_rows import note, note_end
from rattle.solvers.gap_search import clearance_of
from rattle.solvers.nonsmooth.contact_projection import at_rest, at_wall, largest_acceleration, motion_without
from rattle.solvers.nonsmooth.impact_path import as_full_matrix

NOTHING, HIT, LET_GO, BREAK_AWAY, TURN = range(5)  # what an event is
TOGETHER, ALONE, KEPT = range(3)  # a contact lets go: with all that are about to, by itself, or not after all
CREEP = 1e-7  # share of the largest slip at one instant below which the sense of a slip is not resolved
AHEAD = 1e-6  # share of a force by which what is called for exceeds friction a little after a contact has broken away
CREEPS = 30  # see regroup
SLIGHT = 1e-7  # share of its largest force at which a contact lets go together with another one
SLOWLY = 1e-4  # share of the largest acceleration with which it then parts, at most


@compiled
def goes_along(m, n, apart):
    """True when lasting contact n presses next to nothing, against its force before, while another one lets go."""
    return (
        n != apart and m.mode[n] != OFF and m.contact_kinematics[n, at.NORMAL] <= SLIGHT * m.contact_memory[n, at.PEAK]
    )


@compiled
def leaves(m, n, apart, attempt):
    """True when contact n is left out of an attempt."""
    return (n == apart and attempt != KEPT) or (attempt == TOGETHER and goes_along(m, n, apart))


@compiled
def choose_closed(m, apart, kind, attempt, pulling):
    """Choose the contacts that are closed and do not part, with the sense of their slips, and modes to start from.

    The motion without their forces is at hand; pulling: force along the wall at contact `apart`.  Returns how many.
    """
    contact, mode, body, memory = m.contact, m.mode, m.body, m.contact_memory
    active, candidate, slide = m.active, m.candidate, m.slide
    count = 0
    for n in range(contact.shape[0]):
        left_out = contact[n, at.IMPACT] == 0 or leaves(m, n, apart, attempt)
        if not left_out and (mode[n] != OFF or n == apart or at_wall(m, n)):
            active[count] = n
            count += 1
    contact_rows(m, count)
    closed = 0
    for k in range(count):
        n = active[k]
        kept = mode[n] != OFF and kind != HIT
        if kept or at_rest(m, 2 * k, n, along(m, 2 * k, n, body, at.VX), memory[n, at.N_1]):
            active[closed] = n
            u = along(m, 2 * k + 1, n, body, at.VX)
            slide[closed] = 0
            still = (kept and mode[n] == STICK) or (n == apart and kind == TURN)
            if not still and not at_rest(m, 2 * k + 1, n, u, memory[n, at.N_1]):
                slide[closed] = 1 if u > 0.0 else -1
            if n == apart and kind == BREAK_AWAY:
                slide[closed] = 1 if pulling > 0.0 else -1
            elif kind == BREAK_AWAY and kept and mode[n] != STICK:  # it had reached its limit before: goes along
                slide[closed] = 1 if mode[n] == FORWARD else -1
            candidate[closed] = mode[n]
            if mode[n] == OFF or slide[closed] != 0:
                candidate[closed] = FORWARD if slide[closed] >= 0 else BACKWARD
            closed += 1
    if closed < count:
        contact_rows(m, closed)
    return closed


@compiled
def part(m, count, apart, attempt):
    """True when the gaps of all contacts that an attempt leaves out are going to open; the others' forces are at hand.

    Those that go along have to open slowly, too: a contact that flies off is not one that was about to let go.
    The motion at hand becomes that with these forces.
    """
    kinematics, acceleration = m.contact_kinematics, m.acceleration
    add_forces(m, count, acceleration, m.multiplier)
    for n in range(kinematics.shape[0]):
        if leaves(m, n, apart, attempt):
            contact_rows_of_one(m, count, n)
            opening = kinematics[n, at.GAMMA_N] - along(m, 2 * count, n, acceleration, 0)
            size = turning(m, n) + largest_acceleration(m)
            if opening < -1e-9 * size or (n != apart and opening > SLOWLY * size):
                return False
    return True


@native("i", "h", "f", "v", "i", "i")
def update_modes(m, t, y, apart, kind):
    """Modes of all closed contacts from the problem for the accelerations; `apart` is the contact of the event, or -1.

    A contact that has just let go or broken away keeps to that unless the others then press it back; contacts that
    are about to let go do so with it if all of them part then, so that a block parallel to its wall leaves it parallel.
    Returns OK, NO_SOLUTION, NOT_FOUND or NOT_UNIQUE; or CREEPS, when some stick now and it is to be tried anew.
    """
    kinematics, attempt = m.contact_kinematics, KEPT
    pulling = kinematics[apart, at.TANGENT] if apart >= 0 else 0.0
    if kind == LET_GO:
        attempt = ALONE
        for n in range(kinematics.shape[0]):
            attempt = TOGETHER if goes_along(m, n, apart) else attempt
    while True:
        motion_without(m, t, y)
        closed = choose_closed(m, apart, kind, attempt, pulling)
        lasting_side(m, closed)
        solved = solve_contacts(m, closed)
        if attempt != TOGETHER:
            if not solved and end_creep(m, closed):
                return CREEPS
            status = OK
            if not solved and not solve_by_trying(m, closed):
                status = ending(m)
            elif is_rough(m, closed) and count_solutions(m, closed) > 1:
                status = NOT_UNIQUE
            if kind == BREAK_AWAY and (status != OK or linear(m, closed) < 0):
                status = go_beyond(m, closed, apart, pulling)
            if status != OK:
                return status
            solved = True
        if attempt == KEPT or (solved and part(m, closed, apart, attempt)):
            break
        attempt += 1
    change_modes(m, t, y, closed)
    return OK


@compiled
def go_beyond(m, count, apart, pulling):
    """Modes a little after contact `apart`, one of the active ones, has been pulled away from rest. Returns a status.

    Where the force that presses it makes it approach when it slides (Painleve), sticking and sliding are solutions up
    to that instant and neither is one after it: sliding would turn at once.  So b goes on by what calls for a little
    more along the wall than friction gives, the sense of slip is open, and what solves the problem then is what lasts.
    """
    as_full_matrix(m, count)
    largest, k = 0.0, 0
    for j in range(count):
        largest = max(largest, m.contact_kinematics[m.active[j], at.NORMAL])
        k = j if m.active[j] == apart else k
    more = max(AHEAD * abs(pulling), 1e-2 * AHEAD * largest)
    for r in range(2 * count):
        m.side[B, r] -= (more if pulling > 0.0 else -more) * m.delassus[r, 2 * k + 1]
    m.slide[k] = 0
    found = call_problem(m.problem_table[TRY_ALL], (m, 2 * count + 1))
    if found < 0:  # too many to be tried
        found = 1 if solve_contacts(m, count) and linear(m, count) > 0 else 2
    m.held[OUTCOME] = SOLVED if found > 0 else IMPOSSIBLE
    return OK if found == 1 else (NOT_UNIQUE if found > 1 else NO_SOLUTION)


@compiled
def end_creep(m, count):
    """Lasting contacts among the active ones that creep stick from now on; True when there are any.

    What an impact sends along a chain of contacts falls off by orders, and leaves slips whose sense a run does not
    resolve.  Where friction in that sense leaves the problem without solution they are none: friction ends them at
    once, with no more than CREEP^2 of the energy.
    """
    kinematics, mode, active, slide = m.contact_kinematics, m.mode, m.active, m.slide
    largest, found = 0.0, False
    for k in range(count):
        largest = max(largest, abs(kinematics[active[k], at.SLIP]))
    for k in range(count):
        n = active[k]
        if mode[n] != OFF and slide[k] != 0 and abs(kinematics[n, at.SLIP]) <= CREEP * largest:
            mode[n] = STICK
            found = True
    return found


@compiled
def turning(m, n):
    """Size of what makes up gamma of contact n, which may cancel: what its rounding is measured by [m/s^2]."""
    contact, kinematics, lever, body = m.contact, m.contact_kinematics, m.lever, m.body
    size = abs(kinematics[n, at.GAMMA_N]) + kinematics[n, at.ACROSS] * kinematics[n, at.ACROSS] / clearance_of(m, n)
    for end in range(2):
        rate = body[contact[n, at.A_BODY + end], at.W]
        size += lever[n, end] * rate * rate
    return size


@compiled
def contact_rows_of_one(m, k, n):
    """Put contact n after k active ones, with its rows."""
    m.active[k] = n
    contact_rows(m, k + 1)


@compiled
def change_modes(m, t, y, count):
    """Take over the modes in `candidate` of the active contacts (all others are off) and note what has changed."""
    contact, mode, memory = m.contact, m.mode, m.contact_memory
    active, candidate, side = m.active, m.candidate, m.side
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 0:
            continue
        new, pressed = OFF, 0.0
        for k in range(count):
            if active[k] == n:
                new, pressed = candidate[k], side[F, 2 * k]
        old = mode[n]
        account = account_at(m, n)
        if old == OFF and new != OFF:
            memory[n, at.CLOSED], memory[n, at.SINCE], memory[n, at.PEAK] = (
                at.SHUT,
                max(t, memory[n, at.STEPS_IN]),
                pressed,
            )
            memory[n, at.IMPULSE_0], memory[n, at.LOSS_0] = y[account + IMPULSE], y[account + LOSS]
        if old != OFF and new == OFF:
            note_end(m, n, t, y, 0.0)
            memory[n, at.CLOSED], memory[n, at.SPEED] = at.OPEN, 0.0
        if friction_of(m, n) > 0.0 and new != OFF and new != old:
            if new == STICK:
                note(m, at.STICK_EVENT, n, t, 0.0)
            elif old != OFF:
                note(m, at.SLIP_EVENT, n, t, 0.0)
        mode[n] = new
        memory[n, at.STEPS_IN] = 0.0
