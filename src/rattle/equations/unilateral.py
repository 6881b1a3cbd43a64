"""Set-valued contacts in the equations of motion: rows of W, right-hand sides, and the forces of closed contacts.

The contact problem is solved in `complementarity`, whose kernels are called by address, so that their callers
do not compile them again.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import (
    COUNT,
    IMPOSSIBLE,
    MODES,
    OFF,
    OTHER,
    ROWS_OF,
    SEARCH,
    SOLVED,
    STICK,
    TRY_ALL,
    UNDECIDED,
    B,
    F,
    friction_of,
    note_shares,
    set_floor,
)
from rattle.equations.dependent_rows import fixed_value
from rattle.equations.dry_friction import REST, complete_dry_friction
from rattle.equations.friction_beside_contacts import BY_FRICTION, couple, follow
from rattle.equations.schur import solve
from rattle.jit import layout as at
from rattle.jit.families import call_problem
from rattle.jit.functions import compiled, kernel

# places in `problem_table`, after those of complementarity: see solvers.nonsmooth.impact_phases, path and chain
EXPAND, TRACE, CHAIN = 6, 7, 9
# ends of a run that only occur with set-valued contacts
MOST_ROUNDS = 12  # of contacts and friction of joints by turns
ROUNDED = 1e-9  # share of its terms below which the acceleration of a row that the joints fix counts as zero
AGREES = 1e-14  # share of the largest force below which a correction ends them
NO_SOLUTION, NOT_UNIQUE, LOCKED, CHATTER, NOT_FOUND = range(10, 15)


@compiled
def along(m, r, n, values, column):
    """W_r . values for row r (of contact n); values (nb + 1, ...) has x, y, phi from `column` on."""
    contact, w = m.contact, m.contact_jacobian
    a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
    total = 0.0
    for q in range(3):
        total += w[r, q] * values[a, column + q] + w[r, 3 + q] * values[b, column + q]
    return total


@compiled
def velocity_scale(m, r, n):
    """Magnitude of the terms of W_r . v [m/s], relative to which a contact velocity has rounding."""
    return reach(m, r, n, m.body, at.VX)


@compiled
def reach(m, r, n, values, column):
    """Magnitude of the terms of `along`, in the same unit."""
    contact, w = m.contact, m.contact_jacobian
    a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
    total = 0.0
    for q in range(3):
        total += abs(w[r, q] * values[a, column + q]) + abs(w[r, 3 + q] * values[b, column + q])
    return total


@compiled
def held_along_slips(m, r):
    """True if friction of joints that slip takes part in the response to row r, beside what holds the row."""
    memory = m.dry_memory
    for j in range(memory.shape[0]):
        slips = memory[j, at.DRY_MODE] != at.DRY_STICKS or m.dry[j, at.DRY_LAW] >= 0
        if slips and m.dry_share[j, r] != 0.0:
            return True
    return False


@compiled
def fixed_side(m, r, n):
    """b of row r of contact n [m/s^2 or rad/s^2], which joints fix, or they and friction that sticks; 0 if rounding.

    The reactions z of the row alone give it; those in `multiplier_response` contain the friction of joints that follows
    a force along the row.  Beside friction that slips they are none of the kinematics: the motion itself is taken.
    """
    kinematics, rows, reaction, memory = m.contact_kinematics, m.rows, m.multiplier_response, m.dry_memory
    value = kinematics[n, at.GAMMA_N if r % 2 == 0 else at.GAMMA_T]
    size = abs(value)
    by_friction = m.row_fixed[2 * n + r % 2] == BY_FRICTION
    if by_friction and held_along_slips(m, r):
        value -= along(m, r, n, m.acceleration, 0)
        size += reach(m, r, n, m.acceleration, 0)
        return value if abs(value) > ROUNDED * size + REST else 0.0
    for row in range(rows.shape[0]):
        z = reaction[r, row]
        for j in range(memory.shape[0]):
            z += 0.0 if by_friction else m.dry_share[j, r] * m.dry_reaction[j, row]
        value -= z * rows[row, at.GAMMA]
        size += abs(z * rows[row, at.GAMMA])
    if by_friction:
        for j in range(memory.shape[0]):
            value -= m.dry_share[j, r] * m.dry_rows[j, at.GAMMA]
            size += abs(m.dry_share[j, r] * m.dry_rows[j, at.GAMMA])
    return value if abs(value) > ROUNDED * size + REST else 0.0


@compiled
def approach(m, k, n):
    """Rate [m/s or rad/s] of the gap of active contact n in the rows 2 k of W; exact if the joints fix it."""
    if m.row_fixed[2 * n] == 0:
        return m.contact_kinematics[n, at.DGAP]
    return -fixed_value(m, m.multiplier_response, 2 * k, at.NU)


@compiled
def lasting_side(m, count):
    """b of closed contacts: g'' and minus the rate of slip of the motion without contact forces [m/s^2]."""
    kinematics, active, side, acceleration = m.contact_kinematics, m.active, m.side, m.acceleration
    for k in range(count):
        n = active[k]
        side[B, 2 * k] = kinematics[n, at.GAMMA_N] - along(m, 2 * k, n, acceleration, 0)
        side[B, 2 * k + 1] = kinematics[n, at.GAMMA_T] - along(m, 2 * k + 1, n, acceleration, 0)
        for r in range(2 * k, 2 * k + 2):
            if m.row_fixed[2 * n + r - 2 * k] != 0:
                side[B, r] = fixed_side(m, r, n)


@compiled
def floor_of_accelerations(m):
    """Note which accelerations of the present contact problem are rounding, by the forces that act."""
    force, weight, total = m.force, m.weight, 0.0
    for i in range(1, force.shape[0]):
        for q in range(3):
            total += weight[i, q] * force[i, q] * force[i, q]
    set_floor(m, math.sqrt(total))


@compiled
def floor_of_rates(m):
    """Note which rates of the present contact problem are rounding, by those of all bodies."""
    body, weight, total = m.body, m.weight, 0.0
    for i in range(1, body.shape[0]):
        for q in range(3):
            if weight[i, q] > 0.0:
                total += body[i, at.VX + q] * body[i, at.VX + q] / weight[i, q]
    set_floor(m, math.sqrt(total))


@compiled
def contact_rows(m, count):
    """Rows of W of the active contacts, the responses to unit forces, and G."""
    call_problem(m.problem_table[ROWS_OF], (m, count))


@compiled
def lasting_rows(m, count):
    """`contact_rows` for forces that last, which friction of joints follows."""
    contact_rows(m, count)
    if m.dry.shape[0] > 0:
        couple(m, count)


@compiled
def solve_contacts(m, count):
    """Find modes, f and a of the active contacts, starting from `candidate`; False if none was found, see `ending`."""
    return call_problem(m.problem_table[SEARCH], (m, count)) == SOLVED


@compiled
def solve_by_trying(m, count):
    """Try all modes if `solve_contacts` has found none; True if there is a solution, otherwise see `ending`."""
    held = m.held
    if held[at.OUTCOME] == IMPOSSIBLE:
        return False
    solutions = call_problem(m.problem_table[TRY_ALL], (m, 2 * count))
    if solutions >= 0:
        held[at.OUTCOME] = SOLVED if solutions > 0 else IMPOSSIBLE
    return solutions > 0


@compiled
def ending(m):
    """How a run ends whose contact problem was not solved: NO_SOLUTION if proved or jammed, otherwise NOT_FOUND."""
    return NOT_FOUND if m.held[at.OUTCOME] == UNDECIDED else NO_SOLUTION


@compiled
def count_solutions(m, count):
    """Number of different solutions of the problem, at most 2."""
    return call_problem(m.problem_table[COUNT], (m, count))


@compiled
def solve_modes(m, count, rough):
    """Forces f [N or N s] (a may be left out) for the modes in `candidate`; rough = 0: without friction of sliding.

    Returns the sign of the determinant, see `complementarity.modes_kernel`.
    """
    return call_problem(m.problem_table[MODES], (m, 4 * count + 2 + rough))


@compiled
def is_rough(m, count):
    """True if an active contact has friction."""
    active = m.active
    for k in range(count):
        if friction_of(m, active[k]) > 0.0:
            return True
    return False


@compiled
def add_forces(m, count, acceleration, multiplier):
    """Add the response to f: accelerations (nb + 1, 3) and multipliers, or rates and impulses of the joints."""
    dv, dlambda = m.velocity_change, m.multiplier_change
    push_all(m, count)
    for i in range(1, acceleration.shape[0]):
        for q in range(3):
            acceleration[i, q] -= dv[i, q]
    for row in range(multiplier.shape[0]):
        multiplier[row] -= dlambda[row]


@compiled
def shift(m, count, values, share):
    """Add to values (3 nb,) a share of the response to f."""
    dv = m.velocity_change
    push_all(m, count)
    for c in range(values.shape[0]):
        values[c] += share * dv[1 + c // 3, c % 3]


@compiled
def push_all(m, count):
    """Response to all f, M^-1 (W^T f - Phi_q^T z), into `velocity_change`, and z into `multiplier_change`.

    For forces f [N] accelerations [m/s^2, rad/s^2], for impulses [N s] rates [m/s, rad/s].
    """
    side, dv, dlambda = m.side, m.velocity_change, m.multiplier_change
    response, multiplier_response, w, weight = m.velocity_response, m.multiplier_response, m.contact_jacobian, m.weight
    contact, active, sparse = m.contact, m.active, m.held[at.SPARSE] == 1.0
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
        correct_for_joints(m)


@compiled
def correct_for_joints(m):
    """Remove from `velocity_change` what the joints prevent; their multipliers go to `multiplier_change`."""
    dv, dlambda, rows, weight = m.velocity_change, m.multiplier_change, m.rows, m.weight
    row_body, place, x = m.row_body, m.place, m.solution
    for row in range(dlambda.shape[0]):
        a, b = row_body[row, at.ROW_A], row_body[row, at.ROW_B]
        value = 0.0
        for q in range(3):
            value += rows[row, at.AX + q] * dv[a, q] + rows[row, at.BX + q] * dv[b, q]
        x[place[row]] = value
    solve(m)
    for row in range(dlambda.shape[0]):
        a, b = row_body[row, at.ROW_A], row_body[row, at.ROW_B]
        dlambda[row] = x[place[row]]
        for q in range(3):
            dv[a, q] -= weight[a, q] * rows[row, at.AX + q] * dlambda[row]
            dv[b, q] -= weight[b, q] * rows[row, at.BX + q] * dlambda[row]


@compiled
def agree(m, count):
    """Repeat the solution of `closed_contacts` with the friction of joints that its forces cause, until both agree."""
    side = m.side
    for r in range(2 * count):
        side[OTHER, r] = 0.0
    for _ in range(MOST_ROUNDS):
        follow(m, count, side[F])
        complete_dry_friction(m)
        change, size = 0.0, 0.0
        for r in range(2 * count):
            side[OTHER, r] += side[F, r]
            change, size = max(change, abs(side[F, r])), max(size, abs(side[OTHER, r]))
        if not change > AGREES * size:
            break
        lasting_rows(m, count)
        lasting_side(m, count)
        solve_modes(m, count, 1)
        add_forces(m, count, m.acceleration, m.multiplier)
    for r in range(2 * count):
        side[F, r] = side[OTHER, r]


@kernel("closed contacts")
def closed_contacts(m):
    """Add the response to the forces of closed contacts in their present modes; N, T [N] to `contact_kinematics`."""
    contact, kinematics, mode = m.contact, m.contact_kinematics, m.mode
    active, candidate, side, held, memory = m.active, m.candidate, m.side, m.held, m.contact_memory
    count = 0
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            for column in (at.NORMAL, at.TANGENT, at.LOSS, at.STORE):
                kinematics[n, column] = 0.0
            if memory[n, at.SLIPS] == 1.0:
                kinematics[n, at.NORMAL] = m.values[contact[n, at.NORMAL_P] + at.MOST_TORQUE]
                kinematics[n, at.LOSS] = -kinematics[n, at.NORMAL] * kinematics[n, at.DGAP]
            if mode[n] != OFF and memory[n, at.IDLE] == 0.0:
                active[count], candidate[count] = n, mode[n]
                count += 1
    if count == 0:
        return
    lasting_rows(m, count)
    lasting_side(m, count)
    held[at.DETERMINANT] = solve_modes(m, count, 1)
    add_forces(m, count, m.acceleration, m.multiplier)
    if m.dry.shape[0] > 0:
        agree(m, count)
    for k in range(count):
        n = active[k]
        kinematics[n, at.NORMAL], kinematics[n, at.TANGENT] = side[F, 2 * k], side[F, 2 * k + 1]
        kinematics[n, at.LOSS] = 0.0 if mode[n] == STICK else side[F, 2 * k + 1] * kinematics[n, at.SLIP]
    if held[at.DETERMINANT] == 0.0:
        note_shares(m, count)
