"""New modes of set-valued contacts at an event, from the problem for the accelerations."""

from __future__ import annotations

from rattle.equations.complementarity import (
    BACKWARD,
    FORWARD,
    IMPOSSIBLE,
    OFF,
    SOLVED,
    STICK,
    TRY_ALL,
    A,
    B,
    F,
    friction_of,
    linear,
    mode_of_closing,
    resolution,
)
from rattle.equations.motion import OK
from rattle.equations.one_way import hold
from rattle.equations.state import IMPULSE, LOSS, account_at
from rattle.equations.unilateral import (
    NO_SOLUTION,
    NOT_UNIQUE,
    add_forces,
    along,
    approach,
    contact_rows,
    count_solutions,
    ending,
    floor_of_accelerations,
    is_rough,
    lasting_rows,
    lasting_side,
    reach,
    solve_by_trying,
    solve_contacts,
)  # fmt: skip
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.families import call_problem
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.clutches import (
    driven_on,
    held_back,
    note_slip,
    overloaded,
    pushed_on,
    settle_slips,
    undecided_is_free,
)
from rattle.solvers.contacts.event_rows import note, note_end
from rattle.solvers.contacts.penetration import scale_of
from rattle.solvers.dry_friction_modes import AGAINST_LOOSE
from rattle.solvers.nonsmooth.contact_projection import at_rest, at_wall, largest_acceleration, motion_without
from rattle.solvers.nonsmooth.idle_contacts import doubt_holders, held_by_closed, let_idle
from rattle.solvers.nonsmooth.impact_path import as_full_matrix
from rattle.solvers.nonsmooth.rubbing_contacts import (
    MOST_LINEARISED,
    agrees_with_joints,
    expect_nothing,
    expect_solution,
    linearise_at_expected,
    rubs,
)
from rattle.solvers.nonsmooth.uniqueness import lasts

NOTHING, HIT, LET_GO, BREAK_AWAY, TURN, DROP, MEETS = range(7)  # what an event is; MEETS: a compliant contact changes
TOGETHER, ALONE, KEPT = range(3)  # a contact opens: with all that are about to, by itself, or not after all
MOST_RETURNS = 20  # times that clutches which begin to slip together are decided anew: once each but for cycles
CREEP = 1e-6  # share of the largest slip at one instant below which the direction of a slip is not resolved
AHEAD = 1e-6  # share by which the required friction force exceeds the limit shortly after a breakaway
HOLDS = 1e-3  # share by which a force is below the limit that it is said to pass: a jump that is still to come
CREEPS, ANEW = 30, -1  # beside statuses, see `find_modes`
NOT_LINEARISED = MOST_LINEARISED + 1  # rounds: the first solution is taken, linearised at no forces
SLIGHT = 1e-7  # share of its largest force below which a contact opens together with another one
SLOWLY = 1e-4  # largest acceleration with which it then opens, as a share of the largest acceleration
OPENING = 1e-9  # share of its terms below which the acceleration of a gap is rounding
AHEAD_OF_PRESSED = 1e-2  # share of AHEAD, of the largest normal force, where little tangential force is required


@compiled
def goes_along(m, n, apart):
    """True if closed contact n presses with almost no force, compared with before, while another one opens."""
    return (
        n != apart and m.mode[n] != OFF and m.contact_kinematics[n, at.NORMAL] <= SLIGHT * m.contact_memory[n, at.PEAK]
    )


@compiled
def leaves(m, n, apart, attempt):
    """True if contact n is left out of an attempt."""
    return (n == apart and attempt != KEPT) or (attempt == TOGETHER and goes_along(m, n, apart))


@compiled
def against(m, n, sense):
    """True if a slip of contact n in a sense (1, -1, or 0: none) is not that of its mode, the latter being one."""
    mode = m.mode[n]
    return friction_of(m, n) > 0.0 and ((mode == FORWARD and sense < 0) or (mode == BACKWARD and sense > 0))


@compiled
def gather(m, apart, attempt):
    """Contacts that an attempt does not leave out and that may be closed become active. Returns their number."""
    contact, mode, memory, count = m.contact, m.mode, m.contact_memory, 0
    for n in range(contact.shape[0]):
        left_out = contact[n, at.IMPACT] == 0 or memory[n, at.SLIPS] == 1.0 or leaves(m, n, apart, attempt)
        if not left_out and (mode[n] != OFF or n == apart or at_wall(m, n)):
            m.active[count] = n
            count += 1
    return count


@compiled
def sense_of_slip(m, k, n, apart, kind, pulling):
    """Direction in which contact n, with the rows of the k-th active one, slips: 1, -1, or 0: it is open."""
    if n == apart and kind == BREAK_AWAY:
        return 1 if pulling > 0.0 else -1
    u, kept = along(m, 2 * k + 1, n, m.body, at.VX), m.mode[n] != OFF and kind != HIT
    still = (kept and m.mode[n] == STICK) or (n == apart and kind == TURN)
    sense = 0
    if not still and not at_rest(m, 2 * k + 1, n, u, m.contact_memory[n, at.ROUNDING]):
        sense = 1 if u > 0.0 else -1
    # a reversal would have been an event: such a slip is an error
    return 0 if kept and against(m, n, sense) else sense


@compiled
def mode_to_try(m, n, sense):
    """The first mode to try of contact n, which slips in a direction (1, -1, or 0: open)."""
    if undecided_is_free(m, n):
        return OFF
    if m.mode[n] == OFF or sense != 0:
        return FORWARD if sense >= 0 else BACKWARD
    return m.mode[n]


@compiled
def choose_closed(m, apart, kind, attempt, pulling):
    """Choose the contacts that are closed and do not open, with their directions of slip and initial modes.

    The workspace holds the motion without their forces; pulling: tangential force [N] at contact `apart`.
    Returns their number.
    """
    active = m.active
    count = gather(m, apart, attempt)
    contact_rows(m, count)
    closed = 0
    for k in range(count):
        n = active[k]
        kept = m.mode[n] != OFF and kind != HIT
        if kept or at_rest(m, 2 * k, n, approach(m, k, n), m.contact_memory[n, at.ROUNDING]):
            active[closed] = n
            m.slide[closed] = sense_of_slip(m, k, n, apart, kind, pulling)
            m.candidate[closed] = mode_to_try(m, n, m.slide[closed])
            closed += 1
    if closed < count or m.dry.shape[0] > 0:
        lasting_rows(m, closed)
    return closed


@compiled
def part(m, count, apart, attempt):
    """True if the gaps of all contacts that an attempt leaves out are going to open; the others' forces are known.

    Those that open together with another one must also open slowly: a contact that flies off was not about to open.
    The motion in the workspace becomes that with these forces.
    """
    kinematics, acceleration = m.contact_kinematics, m.acceleration
    add_forces(m, count, acceleration, m.multiplier)
    for n in range(kinematics.shape[0]):
        if leaves(m, n, apart, attempt):
            contact_rows_of_one(m, count, n)
            opening = kinematics[n, at.GAMMA_N] - along(m, 2 * count, n, acceleration, 0)
            size = turning(m, n) + largest_acceleration(m, n) + reach(m, 2 * count, n, acceleration, 0)
            if opening < -OPENING * size or (n != apart and opening > SLOWLY * size):
                return False
            m.candidate[count] = OFF
            if opening < OPENING * size and held_by_closed(m, count + 1, count, 0):
                doubt_holders(m, count + 1)
                return False
    return True


@compiled
def first_attempt(m, apart, kind):
    """Which contacts open first at an event: `apart` with all that are about to, itself, or none."""
    if kind != LET_GO:
        return KEPT
    for n in range(m.contact_kinematics.shape[0]):
        if goes_along(m, n, apart):
            return TOGETHER
    return ALONE


@compiled
def status_of(m, count, solved, apart, kind, pulling):
    """Status of the problem of the active contacts, solved or not: OK, CREEPS, ANEW, or why there are no modes.

    Without solution all modes are tried, or a clutch slips that is pushed on; other solutions are looked for.
    """
    if not solved and end_creep(m, count):
        return CREEPS
    status = OK
    if not solved and not solve_by_trying(m, count):
        if pushed_on(m, count):
            return ANEW
        status = ending(m)
    elif is_rough(m, count) and count_solutions(m, count) > 1:
        status = NOT_UNIQUE
    if kind == BREAK_AWAY and (status != OK or linear(m, count) < 0 or not lasts(m, count)):
        status = go_beyond(m, count, apart, pulling)
    return status


@compiled
def solve_attempt(m, count, attempt, apart, kind, pulling, broken, slipping, returns):
    """Solve the problem of the active contacts: status, or ANEW, and True with how often if clutches slip together."""
    if driven_on(m, count):
        return ANEW, slipping, returns
    solved = solve_contacts(m, count)
    if solved and overloaded(m, count):
        return ANEW, True, returns
    if solved and slipping and returns < MOST_RETURNS:
        add_forces(m, count, m.acceleration, m.multiplier)
        return ANEW, held_back(m, broken), returns + 1
    if attempt == TOGETHER:
        return (OK if solved else NO_SOLUTION), slipping, returns
    return status_of(m, count, solved, apart, kind, pulling), slipping, returns


@compiled
def find_modes(m, t, y, apart, kind, pulling, broken, first):
    """Modes into `candidate` by attempts from the first one on: status, number of active contacts, last attempt."""
    attempt, slipping, returns, rounds = first, False, 0, 0
    while True:
        motion_without(m, t, y)
        count = choose_closed(m, apart, kind, attempt, pulling)
        linearised = 0 < rounds <= MOST_LINEARISED
        if linearised and not linearise_at_expected(m, count):
            rounds = NOT_LINEARISED
            continue
        lasting_side(m, count)
        floor_of_accelerations(m)
        status, slipping, returns = solve_attempt(m, count, attempt, apart, kind, pulling, broken, slipping, returns)
        if status == ANEW:
            continue
        if status != OK and attempt != TOGETHER:
            if linearised and status != CREEPS:
                rounds = NOT_LINEARISED
                continue
            if attempt == KEPT or status == CREEPS:
                return status, count, attempt
        # without the contact that opens: with it the problem may have a solution, or one
        if attempt == KEPT or (status == OK and part(m, count, apart, attempt)):
            if not another_round(m, count, rounds):
                return OK, count, attempt
            rounds += 1
        else:
            attempt += 1


@compiled
def another_round(m, count, rounds):
    """True if the problem beside joints that rub is to be linearised anew, at the solution that is now expected."""
    return rounds < MOST_LINEARISED and rubs(m) and expect_solution(m, count)


@compiled
def is_held_yet(m, n):
    """True if contact n sticks well within its limit where it has broken away: its force jumps just after this place.

    Where an edge ends on a disc forces jump; rounding of the place decides whether that is so already.
    """
    kinematics = m.contact_kinematics[n]
    limit = friction_of(m, n) * kinematics[at.NORMAL]
    return m.contact[n, at.LEVEL] == 0 and abs(kinematics[at.TANGENT]) < (1.0 - HOLDS) * limit


@native("i", "h", "f", "v", "i", "i")
def update_modes(m, t, y, apart, kind):
    """Modes of all closed contacts from the problem for the accelerations; `apart` is the contact of the event, or -1.

    A contact that has just opened or broken away stays so unless the others then press it back; contacts that
    are about to open do so with it if all of them then separate, so that a block parallel to its wall leaves it
    parallel.  Beside joints that rub the problem is solved until it is linearised where it leads, see
    `rubbing_contacts`.  Returns OK, NO_SOLUTION, NOT_FOUND or NOT_UNIQUE; or CREEPS, if some now stick and the caller
    must try again.
    """
    if kind == BREAK_AWAY and is_held_yet(m, apart):
        apart, kind = -1, NOTHING
    pulling, attempt = m.contact_kinematics[apart, at.TANGENT] if apart >= 0 else 0.0, first_attempt(m, apart, kind)
    broken = apart if apart >= 0 and m.contact[apart, at.LEVEL] == 1 and kind == BREAK_AWAY else -1
    settle_slips(m, broken)
    kind = NOTHING if broken >= 0 else kind
    expect_nothing(m)
    status, count, attempt = find_modes(m, t, y, apart, kind, pulling, broken, attempt)
    if status != OK:
        return status
    if not agrees_with_joints(m, count, attempt != KEPT):
        return NO_SOLUTION
    if kind == HIT and m.dry.shape[0] > 0:
        stay_at_wall(m, count, apart)
    let_idle(m, count)
    change_modes(m, t, y, count)
    return OK


@compiled
def stay_at_wall(m, count, who):
    """Let a contact that is met close though it bears nothing, where friction of joints just balances what presses it:
    they begin to slip at this instant, and it would be met again at once."""
    _, least = resolution(m, count)
    for k in range(count):
        if m.active[k] != who or m.candidate[k] != OFF:
            continue
        if m.side[A, 2 * k] <= max(least, AGAINST_LOOSE * held_by_friction(m, 2 * k, who)):
            m.candidate[k] = mode_of_closing(m.slide[k], friction_of(m, who))


@compiled
def held_by_friction(m, r, n):
    """Sum of the accelerations in row r of contact n that joints cause by their friction, as magnitudes."""
    w, a, b, total = m.contact_jacobian, m.contact[n, at.A_BODY], m.contact[n, at.B_BODY], 0.0
    for o in range(m.dry.shape[0]):
        caused = 0.0
        for q in range(3):
            caused += w[r, q] * m.dry_response[o, 3 * a + q] + w[r, 3 + q] * m.dry_response[o, 3 * b + q]
        total += abs(caused * m.dry_memory[o, at.DRY_FORCE])
    return total


@compiled
def go_beyond(m, count, apart, pulling):
    """Modes shortly after contact `apart`, one of the active ones, has broken away from sticking. Returns a status.

    If the force that presses it makes it approach when it slides (Painleve), sticking and sliding are both solutions up
    to that instant and neither is one after it: sliding would reverse at once.  Therefore b is changed so that slightly
    more tangential force is required than friction can give, the direction of slip is left open, and the solution of
    this problem is taken.  So it is if another contact is at its limit too: bodies at rest that begin to move.
    """
    as_full_matrix(m, count)
    largest, k = 0.0, 0
    for j in range(count):
        largest = max(largest, m.contact_kinematics[m.active[j], at.NORMAL])
        k = j if m.active[j] == apart else k
    more = max(AHEAD * abs(pulling), AHEAD_OF_PRESSED * AHEAD * largest)
    for r in range(2 * count):
        m.side[B, r] -= (more if pulling > 0.0 else -more) * m.delassus[r, 2 * k + 1]
    m.slide[k] = 0
    solutions = call_problem(m.problem_table[TRY_ALL], (m, 2 * count + 1))
    if solutions < 0:  # too many combinations to be tried
        solutions = 1 if solve_contacts(m, count) and linear(m, count) > 0 else 2
    m.held[at.OUTCOME] = SOLVED if solutions > 0 else IMPOSSIBLE
    return OK if solutions == 1 else (NOT_UNIQUE if solutions > 1 else NO_SOLUTION)


@compiled
def end_creep(m, count):
    """Active closed contacts that creep stick from now on; True if there are any.

    The effect of an impact decreases by orders of magnitude along a chain of contacts, and leaves slips whose direction
    a run does not resolve.  If friction in that direction leaves the problem without solution the slip is not real:
    friction ends it at once, with no more than CREEP^2 of the energy.
    """
    kinematics, mode, active, slide = m.contact_kinematics, m.mode, m.active, m.slide
    largest, ended = 0.0, False
    for k in range(count):
        largest = max(largest, abs(kinematics[active[k], at.SLIP]))
    for k in range(count):
        n = active[k]
        if mode[n] != OFF and slide[k] != 0 and abs(kinematics[n, at.SLIP]) <= CREEP * largest:
            mode[n] = STICK
            ended = True
    return ended


@compiled
def turning(m, n):
    """Magnitude of the terms of gamma of contact n [SI], which may cancel: its rounding is relative to it."""
    contact, kinematics, lever, body = m.contact, m.contact_kinematics, m.lever, m.body
    size = abs(kinematics[n, at.GAMMA_N]) + kinematics[n, at.ACROSS] * kinematics[n, at.ACROSS] / scale_of(m, n)
    for end in range(2):
        rate = body[contact[n, at.A_BODY + end], at.W]
        size += lever[n, end] * rate * rate
    return size


@compiled
def contact_rows_of_one(m, k, n):
    """Add contact n after k active ones, with its rows of W."""
    m.active[k] = n
    lasting_rows(m, k + 1)


@compiled
def change_modes(m, t, y, count):
    """Accept the modes in `candidate` for the active contacts (all others are off) and record changes as events."""
    for n in range(m.contact.shape[0]):
        if m.contact[n, at.IMPACT] == 0:
            continue
        new, pressed = OFF, 0.0
        for k in range(count):
            if m.active[k] == n:
                new, pressed = m.candidate[k], m.side[F, 2 * k]
        old = m.mode[n]
        if old == OFF and new != OFF:
            close(m, t, y, n, pressed)
        if old != OFF and new == OFF:
            release(m, t, y, n)
        if old == OFF and new == OFF and m.contact[n, at.LEVEL] == 1:
            note_slip(m, n, t)
        if friction_of(m, n) > 0.0 and new != OFF and new != old:
            note_friction(m, t, n, old, new)
        m.mode[n] = new
        hold(m, n, new != OFF)
        m.contact_memory[n, at.BOUNCES_END] = 0.0


@compiled
def close(m, t, y, n, pressed):
    """Enter into the memory of contact n that it closes, with the force `pressed` [N]."""
    memory, account = m.contact_memory[n], account_at(m, n)
    memory[at.CLOSED], memory[at.SINCE], memory[at.PEAK] = at.SHUT, max(t, memory[at.BOUNCES_END]), pressed
    memory[at.IMPULSE_0], memory[at.LOSS_0] = y[account + IMPULSE], y[account + LOSS]


@compiled
def release(m, t, y, n):
    """Record that contact n opens."""
    memory = m.contact_memory[n]
    note_end(m, n, t, y, 0.0)
    if memory[at.SLIPS] == 1.0 and m.tally[at.EVENT_COUNT] > 0:  # it still drives
        m.events[m.tally[at.EVENT_COUNT] - 1, at.EVENT_KIND] = at.SLIP_EVENT
    memory[at.CLOSED], memory[at.SPEED] = at.OPEN, 0.0


@compiled
def note_friction(m, t, n, old, new):
    """Record that contact n, closed and with friction, sticks or begins to slip."""
    if new == STICK:
        note(m, at.STICK_EVENT, n, t, 0.0)
    elif old != OFF:
        note(m, at.SLIP_EVENT, n, t, 0.0)
