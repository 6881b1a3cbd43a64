"""Set-valued contacts as the equations of motion see them: rows, right sides, and the forces of lasting contacts.

The problem itself is solved in `complementarity`, whose kernels are called by their addresses: what calls them need
not compile them again.
"""

from __future__ import annotations

from rattle.equations.complementarity import (
    COUNT,
    IMPOSSIBLE,
    MODES,
    OFF,
    OUTCOME,
    ROWS_OF,
    SEARCH,
    SHARED,
    SOLVED,
    SPARSE,
    STICK,
    TRY_ALL,
    UNDECIDED,
    B,
    F,
    friction_of,
)  # fmt: skip
from rattle.equations.schur import solve
from rattle.jit import layout as at
from rattle.jit.functions import call_problem, compiled, kernel

DETERMINANT, SIZE = range(2)  # entries of `held`; more in complementarity
EXPAND, TRACE = (
    6,
    7,
)  # places in `problem_table`, after those of complementarity: see solvers.nonsmooth.impact_phases and paths
# endings of a run that only set-valued contacts have
NO_SOLUTION, NOT_UNIQUE, LOCKED, CHATTER, NOT_FOUND = range(10, 15)


@compiled
def along(m, r, n, values, column):
    """w . values for line r of contact n; values (nb + 1, ...) has x, y, phi from `column` on."""
    contact, w = m.contact, m.contact_jacobian
    a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
    total = 0.0
    for q in range(3):
        total += w[r, q] * values[a, column + q] + w[r, 3 + q] * values[b, column + q]
    return total


@compiled
def velocity_scale(m, r, n):
    """Size of the terms that make up w . v: what rounding of a contact velocity is measured by [m/s]."""
    return reach(m, r, n, m.body, at.VX)


@compiled
def reach(m, r, n, values, column):
    """Size of the terms that make up `along`."""
    contact, w = m.contact, m.contact_jacobian
    a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
    total = 0.0
    for q in range(3):
        total += abs(w[r, q] * values[a, column + q]) + abs(w[r, 3 + q] * values[b, column + q])
    return total


@compiled
def lasting_side(m, count):
    """b of lasting contacts: g'' and minus the rate of slip that the motion without contact forces would have."""
    kinematics, active, side, acceleration = m.contact_kinematics, m.active, m.side, m.acceleration
    for k in range(count):
        n = active[k]
        side[B, 2 * k] = kinematics[n, at.GAMMA_N] - along(m, 2 * k, n, acceleration, 0)
        side[B, 2 * k + 1] = kinematics[n, at.GAMMA_T] - along(m, 2 * k + 1, n, acceleration, 0)


@compiled
def contact_rows(m, count):
    """Rows w of the active contacts, what a unit force on each of them changes, and G."""
    call_problem(m.problem_table[ROWS_OF], (m, count))


@compiled
def solve_contacts(m, count):
    """Find modes, f and a of the active contacts, starting from `candidate`; False: none was found, see `ending`."""
    return call_problem(m.problem_table[SEARCH], (m, count)) == SOLVED


@compiled
def solve_by_trying(m, count):
    """Try all modes where `solve_contacts` has found none; True when there is a solution, else see `ending`."""
    held = m.held
    if held[OUTCOME] == IMPOSSIBLE:
        return False
    found = call_problem(m.problem_table[TRY_ALL], (m, 2 * count))
    if found >= 0:
        held[OUTCOME] = SOLVED if found > 0 else IMPOSSIBLE
    return found > 0


@compiled
def ending(m):
    """How a run ends whose contact problem was not solved: NOT_FOUND where nothing tells that friction jams."""
    return NOT_FOUND if m.held[OUTCOME] == UNDECIDED else NO_SOLUTION


@compiled
def count_solutions(m, count):
    """Number of different solutions of the problem, at most 2."""
    return call_problem(m.problem_table[COUNT], (m, count))


@compiled
def solve_modes(m, count, rough):
    """Forces f (not always a) for the modes in `candidate`, rough = 0: without friction of sliding. Returns a sign.

    See `complementarity.modes_kernel`.
    """
    return call_problem(m.problem_table[MODES], (m, 4 * count + 2 + rough))


@compiled
def is_rough(m, count):
    """True when a active contact has friction."""
    active = m.active
    for k in range(count):
        if friction_of(m, active[k]) > 0.0:
            return True
    return False


@compiled
def add_forces(m, count, acceleration, multiplier):
    """Add what f changes: acceleration (nb + 1, 3) and multipliers (or rates and percussions of the joints)."""
    dv, dlambda = m.velocity_change, m.multiplier_change
    push_all(m, count)
    for i in range(1, acceleration.shape[0]):
        for q in range(3):
            acceleration[i, q] -= dv[i, q]
    for row in range(multiplier.shape[0]):
        multiplier[row] -= dlambda[row]


@compiled
def shift(m, count, values, share):
    """Add to values (3 nb,) a share of what f changes."""
    dv = m.velocity_change
    push_all(m, count)
    for c in range(values.shape[0]):
        values[c] += share * dv[1 + c // 3, c % 3]


@compiled
def push_all(m, count):
    """What all f change together, M^-1 (W^T f - Phi_q^T z), into `velocity_change`, and z into `multiplier_change`."""
    side, dv, dlambda = m.side, m.velocity_change, m.multiplier_change
    response, multiplier_response, w, weight = m.velocity_response, m.multiplier_response, m.contact_jacobian, m.weight
    contact, active, sparse = m.contact, m.active, m.held[SPARSE] == 1.0
    for i in range(dv.shape[0]):
        for q in range(3):
            dv[i, q] = 0.0
    for row in range(dlambda.shape[0]):
        dlambda[row] = 0.0
    for r in range(2 * count):
        f = side[F, r]
        if f == 0.0:
            continue
        if sparse:
            a, b = contact[active[r // 2], at.A_BODY], contact[active[r // 2], at.B_BODY]
            for q in range(3):
                dv[a, q] += weight[a, q] * w[r, q] * f
                dv[b, q] += weight[b, q] * w[r, 3 + q] * f
            continue
        for i in range(1, dv.shape[0]):
            for q in range(3):
                dv[i, q] += response[r, 3 * i - 3 + q] * f
        for row in range(dlambda.shape[0]):
            dlambda[row] += multiplier_response[r, row] * f
    if sparse and dlambda.shape[0] > 0:
        hold_joints(m)


@compiled
def hold_joints(m):
    """Take off `velocity_change` what the joints do not allow; their multipliers go to `multiplier_change`."""
    dv, dlambda, rows, weight = m.velocity_change, m.multiplier_change, m.rows, m.weight
    row_body, place, x = m.row_body, m.place, m.solution
    for row in range(dlambda.shape[0]):
        a, b = row_body[row, 0], row_body[row, 1]
        value = 0.0
        for q in range(3):
            value += rows[row, at.AX + q] * dv[a, q] + rows[row, at.BX + q] * dv[b, q]
        x[place[row]] = value
    solve(m)
    for row in range(dlambda.shape[0]):
        a, b = row_body[row, 0], row_body[row, 1]
        dlambda[row] = x[place[row]]
        for q in range(3):
            dv[a, q] -= weight[a, q] * rows[row, at.AX + q] * dlambda[row]
            dv[b, q] -= weight[b, q] * rows[row, at.BX + q] * dlambda[row]


@kernel("hold")
def hold(m):
    """Forces of lasting contacts in their present modes, on top of the motion without them; N, T go with them."""
    contact, kinematics, mode = m.contact, m.contact_kinematics, m.mode
    active, candidate, side, held = m.active, m.candidate, m.side, m.held
    count = 0
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            for column in (at.NORMAL, at.TANGENT, at.LOSS, at.STORE):
                kinematics[n, column] = 0.0
            if mode[n] != OFF:
                active[count], candidate[count] = n, mode[n]
                count += 1
    if count == 0:
        return
    contact_rows(m, count)
    lasting_side(m, count)
    held[DETERMINANT] = solve_modes(m, count, 1)
    add_forces(m, count, m.acceleration, m.multiplier)
    for k in range(count):
        n = active[k]
        kinematics[n, at.NORMAL], kinematics[n, at.TANGENT] = side[F, 2 * k], side[F, 2 * k + 1]
        kinematics[n, at.LOSS] = 0.0 if mode[n] == STICK else side[F, 2 * k + 1] * kinematics[n, at.SLIP]
        if side[F, 2 * k] == 0.0 and held[DETERMINANT] == 0.0:
            held[SHARED] = 1.0 + n
