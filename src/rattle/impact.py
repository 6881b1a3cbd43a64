"""Set-valued contacts as the equations of motion see them: rows, right sides, and the forces of lasting contacts.

The problem itself is solved in `complementarity`, whose kernels are called by their addresses: what calls them need
not compile them again.
"""

from __future__ import annotations

from rattle.catalog import call_problem, compiled, kernel
from rattle.complementarity import OFF, STICK, B, F, friction_of
from rattle.memory import (
    ACCELERATION,
    ARM,
    BODY,
    CHOSEN,
    CONTACT,
    DIRECTION,
    HELD,
    MODE,
    MULTIPLIER,
    PROBLEM_TABLE,
    REPLY,
    SIDE,
    TOUCH,
    TRIAL,
    imat,
    ivec,
    mat,
    vec,
)  # fmt: skip
from rattle.plane import A_BODY, B_BODY, DBRISTLE, GAMMA_N, GAMMA_T, IMPACT, LOSS, NORMAL, SLIP, STORE, TANGENT, VX

DETERMINANT, SIZE = range(2)  # entries of `held`
NO_SOLUTION, NOT_UNIQUE, LOCKED, CHATTER = range(10, 14)  # endings of a run that only set-valued contacts have


@compiled
def along(m, r, n, values, column):
    """w . values for line r of contact n; values (nb + 1, ...) has x, y, phi from `column` on."""
    contact, arm = imat(m, CONTACT), mat(m, ARM)
    a, b = contact[n, A_BODY], contact[n, B_BODY]
    total = 0.0
    for q in range(3):
        total += arm[r, q] * values[a, column + q] + arm[r, 3 + q] * values[b, column + q]
    return total


@compiled
def swing(m, r, n):
    """Size of the terms that make up w . v: what rounding of a contact velocity is measured by [m/s]."""
    contact, arm, body = imat(m, CONTACT), mat(m, ARM), mat(m, BODY)
    a, b = contact[n, A_BODY], contact[n, B_BODY]
    total = 0.0
    for q in range(3):
        total += abs(arm[r, q] * body[a, VX + q]) + abs(arm[r, 3 + q] * body[b, VX + q])
    return total


@compiled
def lasting_side(m, count):
    """b of lasting contacts: g'' and minus the rate of slip that the motion without contact forces would have."""
    touch, chosen, side, acceleration = mat(m, TOUCH), ivec(m, CHOSEN), mat(m, SIDE), mat(m, ACCELERATION)
    for k in range(count):
        n = chosen[k]
        side[B, 2 * k] = touch[n, GAMMA_N] - along(m, 2 * k, n, acceleration, 0)
        side[B, 2 * k + 1] = touch[n, GAMMA_T] - along(m, 2 * k + 1, n, acceleration, 0)


@compiled
def contact_rows(m, count):
    """Rows w of the chosen contacts, what a unit force on each of them changes, and G."""
    call_problem(ivec(m, PROBLEM_TABLE)[0], (m, count))


@compiled
def solve_contacts(m, count):
    """Find modes, f and a of the chosen contacts, from those in `trial` on; False when there is no solution."""
    return call_problem(ivec(m, PROBLEM_TABLE)[1], (m, count)) > 0


@compiled
def count_solutions(m, count):
    """Number of different solutions of the problem, at most 2."""
    return call_problem(ivec(m, PROBLEM_TABLE)[2], (m, count))


@compiled
def solve_modes(m, count, rough):
    """Forces f and a for the modes in `trial`, rough = 0: without friction of sliding. See `linear`."""
    return call_problem(ivec(m, PROBLEM_TABLE)[4 - rough], (m, count))


@compiled
def is_rough(m, count):
    """True when a chosen contact has friction."""
    chosen = ivec(m, CHOSEN)
    for k in range(count):
        if friction_of(m, chosen[k]) > 0.0:
            return True
    return False


@compiled
def add_forces(m, count, acceleration, multiplier):
    """Add what f changes: acceleration (nb + 1, 3) and multipliers (or rates and percussions of the joints)."""
    side, direction, reply = mat(m, SIDE), mat(m, DIRECTION), mat(m, REPLY)
    for r in range(2 * count):
        f = side[F, r]
        if f == 0.0:
            continue
        for i in range(1, acceleration.shape[0]):
            for q in range(3):
                acceleration[i, q] -= direction[r, 3 * i - 3 + q] * f
        for row in range(multiplier.shape[0]):
            multiplier[row] -= reply[r, row] * f


@kernel("hold")
def hold(m):
    """Forces of lasting contacts in their present modes, on top of the motion without them; N, T go to `touch`."""
    contact, touch, mode = imat(m, CONTACT), mat(m, TOUCH), ivec(m, MODE)
    chosen, trial, side = ivec(m, CHOSEN), ivec(m, TRIAL), mat(m, SIDE)
    count = 0
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 1:
            for column in (NORMAL, TANGENT, LOSS, STORE, DBRISTLE):
                touch[n, column] = 0.0
            if mode[n] != OFF:
                chosen[count], trial[count] = n, mode[n]
                count += 1
    if count == 0:
        return
    contact_rows(m, count)
    lasting_side(m, count)
    vec(m, HELD)[DETERMINANT] = solve_modes(m, count, 1)
    add_forces(m, count, mat(m, ACCELERATION), vec(m, MULTIPLIER))
    for k in range(count):
        n = chosen[k]
        touch[n, NORMAL], touch[n, TANGENT] = side[F, 2 * k], side[F, 2 * k + 1]
        touch[n, LOSS] = 0.0 if mode[n] == STICK else side[F, 2 * k + 1] * touch[n, SLIP]
