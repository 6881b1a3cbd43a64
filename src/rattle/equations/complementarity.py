"""Set-valued contacts at one instant: their forces or impulses, by an active set.

    a = G f + b,      G = W M^-1 W^T for the motions that the joints allow, f = (N, T) of every contact
    0 <= a_n,  0 <= N,  a_n N = 0,      T in -mu N Sgn(a_t)                     (Coulomb, planar: an exact LCP)

    closed contact:   a_n = g'',               a_t = -(rate of slip)            f forces [N], a [m/s^2]
    impact:           a_n = g'+ + e_N g'-,     a_t = -(u_t+ + e_T u_t-)         f impulses [N s], a [m/s]

Every contact is in one of four modes: off (f = 0), sticking (a_n = a_t = 0), sliding forward (T = mu N) or
backward (T = -mu N).  For given modes the problem is linear; many contacts are solved as in `contact_network`.  Modes
are changed where a condition is violated (Newton's method on the piecewise linear problem).  If that does not converge,
Lemke's path is followed (`lemke`), and all modes of a few contacts are tried.

Source: Glocker, Set-Valued Force Laws (2001), chapters 6 and 8; Leine, Nijmeijer, Dynamics and Bifurcations of
Non-Smooth Mechanical Systems (2004), chapter 5.
"""

from __future__ import annotations

import math

from rattle.equations.dependent_rows import FIXED, STAYS, is_fixed, terms_of
from rattle.equations.massless import prepare, take_out_of_response
from rattle.equations.schur import solve
from rattle.jit import layout as at
from rattle.jit.families import call_problem
from rattle.jit.functions import compiled, kernel

OFF, STICK, FORWARD, BACKWARD = range(4)
B, F, A, OTHER = range(4)  # rows of `side`
EXACT = 1e-12  # share of the largest value below which a value counts as zero
ROUNDING = 1e-15  # share of what cancels in a row of G that is rounding: rows that differ by less are one
OF_TERMS = 1e-13  # share of the terms of b that is rounding: they have been solved for, with some loss
LOOSE = 1e3  # times that: a does not vanish as it should, because contacts or joints depend on each other
LARGE = 1e-3  # share of the largest diagonal entry from which on a pivot need not wait
SHARES = 1e-6  # of a change of forces that moves nothing: part of a contact that is no rounding
MOST_TRIED = 5  # contacts up to which all combinations of modes are tried
FEW = 6  # contacts up to which G is formed and solved as a full matrix
# IMPOSSIBLE: all modes tried; JAMMED: the force that presses contacts together makes them approach
SOLVED, IMPOSSIBLE, JAMMED, UNDECIDED = 1, 0, -1, -2
DENSE_WAY = 2  # returned by the sparse solution if the dense one is needed
ROWS_OF, SEARCH, MODES, NETWORK, FOLLOW, COUNT = range(6)  # places in `problem_table`
TRY_ALL = 8


@compiled
def friction_of(m, n):
    """Coefficient of friction of contact n [-]."""
    return m.values[m.contact[n, at.NORMAL_P] + at.MU]


@compiled
def contact_row(m, n, d, w, r):
    """Row r of w: the rate of penetration of contact n (d = 0), or its slip (d = 1)."""
    kinematics = m.contact_kinematics
    ux = kinematics[n, at.NX] if d == 0 else -kinematics[n, at.NY]
    uy = kinematics[n, at.NY] if d == 0 else kinematics[n, at.NX]
    turn = kinematics[n, at.TURN] if d == 0 else 0.0
    w[r, 0], w[r, 1], w[r, 2] = -ux, -uy, -(kinematics[n, at.PAX] * uy - kinematics[n, at.PAY] * ux) - turn
    w[r, 3], w[r, 4], w[r, 5] = ux, uy, kinematics[n, at.PBX] * uy - kinematics[n, at.PBY] * ux + turn


@kernel("problem")
def rows_kernel(m, count):
    """Rows of W of the active contacts; if they are few, also the responses to unit forces, and G.

    `contact_kinematics` and the factor of S must be up to date.
    """
    active, w, held = m.active, m.contact_jacobian, m.held
    held[at.FAINT] = 0.0
    for k in range(count):
        for d in range(2):
            contact_row(m, active[k], d, w, 2 * k + d)
            for n in range(m.dry.shape[0]):
                m.dry_share[n, 2 * k + d] = 0.0
    coupled = m.dry.shape[0] + m.massless.shape[0]  # responses that `contact_network` does not have
    for k in range(count):
        coupled += m.contact[active[k], at.LEVEL]  # nor does it see rows that the joints fix
    held[at.SPARSE] = 1.0 if count > FEW and m.net_first.shape[0] > 0 and coupled == 0 else 0.0
    if held[at.SPARSE] == 0.0:
        fill_delassus(m, count)
    return 0


@compiled
def force_rows(m, a, b, w, r):
    """Right-hand side of the multipliers' equations for a unit force along row r of w, at bodies a and b."""
    rows, weight, row_body = m.rows, m.weight, m.row_body
    for row in range(rows.shape[0]):
        value = 0.0
        for side in range(2):
            i, c = row_body[row, side], at.AX + 3 * side
            if i == a:
                for q in range(3):
                    value += rows[row, c + q] * weight[i, q] * w[r, q]
            if i == b:
                for q in range(3):
                    value += rows[row, c + q] * weight[i, q] * w[r, 3 + q]
        m.solution[m.place[row]] = value


@compiled
def respond(m, a, b, w, response, multiplier_response, r):
    """Response to a unit force along row r of w, at bodies a and b, into rows r; the factor of S must be up to date."""
    rows, weight, row_body = m.rows, m.weight, m.row_body
    for c in range(response.shape[1]):
        response[r, c] = 0.0
    force_rows(m, a, b, w, r)
    solve(m)
    for q in range(3):
        if a > 0:
            response[r, 3 * a - 3 + q] += weight[a, q] * w[r, q]
        if b > 0:
            response[r, 3 * b - 3 + q] += weight[b, q] * w[r, 3 + q]
    for row in range(rows.shape[0]):
        z = m.solution[m.place[row]]
        multiplier_response[r, row] = z
        i, j = row_body[row, at.ROW_A], row_body[row, at.ROW_B]
        for q in range(3):
            if i > 0:
                response[r, 3 * i - 3 + q] -= weight[i, q] * rows[row, at.AX + q] * z
            if j > 0:
                response[r, 3 * j - 3 + q] -= weight[j, q] * rows[row, at.BX + q] * z
    if m.massless.shape[0] > 0:
        take_out_of_response(m, response, 0, multiplier_response, r)


@compiled
def fix_row(m, n, d, r):
    """Note whether the joints fix row r of W, that of contact n in direction d; a force along it then moves nothing."""
    contact, w, weight, response = m.contact, m.contact_jacobian, m.weight, m.velocity_response
    a, b, size = contact[n, at.A_BODY], contact[n, at.B_BODY], 0.0
    for q in range(3):
        size += weight[a, q] * w[r, q] * w[r, q] + weight[b, q] * w[r, 3 + q] * w[r, 3 + q]
    share = STAYS if m.row_fixed[2 * n + d] == 1 else FIXED
    fixed = m.multiplier_response.shape[1] > 0 and is_fixed(m, response, 0, m.multiplier_response, r, size, share)
    m.row_fixed[2 * n + d] = 1 if fixed else 0
    terms = terms_of(m, m.multiplier_response, r, size)
    m.held[at.NOISE] = max(m.held[at.NOISE], ROUNDING * terms * terms)
    if fixed:
        for c in range(response.shape[1]):
            response[r, c] = 0.0


@compiled
def fill_delassus(m, count):
    """Responses to a unit force along each row of W, and G [1/kg]; W and the factor of S must be up to date."""
    contact, active = m.contact, m.active
    w, response, multiplier_response, delassus = (
        m.contact_jacobian,
        m.velocity_response,
        m.multiplier_response,
        m.delassus,
    )
    if m.massless.shape[0] > 0:
        prepare(m)
    m.held[at.NOISE] = 0.0
    for k in range(count):
        n = active[k]
        a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
        rough = friction_of(m, n) > 0.0
        for d in range(2):
            r = 2 * k + d
            if d == 0 or rough:
                respond(m, a, b, w, response, multiplier_response, r)
            else:
                for c in range(response.shape[1]):
                    response[r, c] = 0.0
                for row in range(multiplier_response.shape[1]):
                    multiplier_response[r, row] = 0.0
            fix_row(m, n, d, r)
            for s in range(r + 1):
                value = 0.0
                if d == 0 or rough:
                    for q in range(3):
                        if a > 0:
                            value += w[r, q] * response[s, 3 * a - 3 + q]
                        if b > 0:
                            value += w[r, 3 + q] * response[s, 3 * b - 3 + q]
                delassus[r, s] = value
                delassus[s, r] = value


@compiled
def linear(m, count):
    """Forces f [N] and a = G f + b [m/s^2] for the modes in `candidate`; for an impact [N s], [m/s]."""
    return call_problem(m.problem_table[MODES], (m, 4 * count + 1))


@kernel("problem")
def modes_kernel(m, number):
    """Forces f and a = G f + b, units as of `linear`, for the modes in `candidate`.

    number is 4 * contacts + 2 * only + rough.

    only = 1: a is not needed.  rough = 0: without friction of sliding.
    Returns the sign of the determinant: +1 as without friction, -1 if friction locks, 0 for dependent contacts.
    """
    count, rough = number // 4, number % 2
    if m.held[at.SPARSE] == 1.0:
        sign = call_problem(m.problem_table[NETWORK], (m, number))
        if sign != DENSE_WAY:
            return sign
        m.held[at.SPARSE] = 0.0
        fill_delassus(m, count)
    return eliminate(m, count, rough)


@compiled
def unknowns_of(mode):
    """Number of forces of a contact that the equations of its mode determine."""
    if mode == OFF:
        return 0
    return 2 if mode == STICK else 1


@compiled
def fill_row(m, count, rough, k, d, row, ridge):
    """Row of `system` of the normal (d = 0) or tangential equation of active contact k."""
    delassus, system, candidate, column = m.delassus, m.system, m.candidate, 0
    for j in range(count):
        if candidate[j] == OFF:
            continue
        value = delassus[2 * k + d, 2 * j] * (ridge if j == k and d == 0 else 1.0)
        if candidate[j] == STICK:
            system[row, column + 1] = delassus[2 * k + d, 2 * j + 1] * (ridge if j == k and d == 1 else 1.0)
        elif rough == 1:
            mu = friction_of(m, m.active[j])
            value += (mu if candidate[j] == FORWARD else -mu) * delassus[2 * k + d, 2 * j + 1]
        system[row, column] = value
        column += unknowns_of(candidate[j])


@compiled
def fill_rows(m, count, rough):
    """The equations G f = -b of the candidate modes into `system`; their number, and the largest diagonal entry."""
    ridge, size, row, scale = 1.0 + m.held[at.RIDGE], 0, 0, 0.0
    for k in range(count):
        size += unknowns_of(m.candidate[k])
    for k in range(count):
        for d in range(unknowns_of(m.candidate[k])):
            fill_row(m, count, rough, k, d, row, ridge)
            m.system[row, size] = -m.side[B, 2 * k + d]
            scale = max(scale, m.delassus[2 * k + d, 2 * k + d])
            row += 1
    return size, scale


@compiled
def diagonalise(system, pivot, size, scale):
    """Gauss-Jordan elimination with exchange of rows and columns, in place; the sign of the determinant, 0: singular.

    system: (size, size + 1), the right-hand side last; pivot[c]: row of column c, or -1 - r where nothing larger than
    rounding of `scale` is left; r: a row that is left then, one for each.  Small pivots wait for the others, as what
    is divided by one is no rounding any more.
    """
    sign = 1
    for c in range(size):
        pivot[c] = -1
    top = 0
    while top < size:
        row, column = next_pivot(system, pivot, top, size, scale)
        if row < 0:
            break
        for c in range(column):
            sign = -sign if pivot[c] < 0 else sign
        sign = sign if system[row, column] > 0.0 else -sign
        if row != top:
            sign = -sign
            for j in range(size + 1):
                system[top, j], system[row, j] = system[row, j], system[top, j]
        clear_column(system, top, column, size)
        pivot[column] = top
        top += 1
    if top == size:
        return sign
    for c in range(size):
        if pivot[c] < 0:
            pivot[c], system[top, size] = -1 - top, 0.0
            top += 1
    return 0


@compiled
def next_pivot(system, pivot, top, size, scale):
    """Row, from `top` on, and column of the next pivot: of the first column that has a large one, or the largest left.

    (-1, -1) if only rounding is left.
    """
    row, column, most = -1, -1, EXACT * scale
    for c in range(size):
        if pivot[c] >= 0:
            continue
        for r in range(top, size):
            if abs(system[r, c]) > most:
                row, column, most = r, c, abs(system[r, c])
        if most > LARGE * scale:
            break
    return row, column


@compiled
def clear_column(system, top, column, size):
    """Make all entries of a column zero but that of row `top`, by multiples of this row."""
    inverse = 1.0 / system[top, column]
    for r in range(size):
        if r != top and system[r, column] != 0.0:
            factor = system[r, column] * inverse
            for j in range(size + 1):
                system[r, j] -= factor * system[top, j]
            system[r, column] = 0.0


@compiled
def place_of(pivot, c):
    """Row in the last column of which the solution for unknown c stands."""
    return pivot[c] if pivot[c] >= 0 else -1 - pivot[c]


@compiled
def solve_least(system, pivot, size, scale):
    """As `diagonalise`; the solution, or the least of all, stands in the last column, in the rows of `place_of`."""
    sign = diagonalise(system, pivot, size, scale)
    for c in range(size):
        r = pivot[c]
        if r >= 0:
            system[r, size] /= system[r, c]
    if sign == 0:
        take_least(system, pivot, size)
    return sign


@compiled
def take_least(system, pivot, size):
    """The least of all solutions in place of the first one: contacts that depend on each other share their forces.

    A solution with forces that others of them take back is none of bodies at rest, and limits of friction end it.
    Changes of f that change no equation are one per column without a pivot; they go into the rows that are left.
    """
    first = size
    for d in range(size):
        if pivot[d] >= 0:
            continue
        row = -1 - pivot[d]
        first = min(first, row)
        for c in range(size):
            r = pivot[c]
            system[row, c] = -system[r, d] / system[r, c] if r >= 0 else 0.0
        system[row, d] = 1.0
    for row in range(first, size):
        for other in range(first, row):
            take_out(system, row, other, size)
        length = math.sqrt(along(system, row, row, size))
        share = 0.0
        for c in range(size):
            system[row, c] /= length
            share += system[row, c] * system[place_of(pivot, c), size]
        for c in range(size):
            system[place_of(pivot, c), size] -= share * system[row, c]


@compiled
def doubt(m, n, unsure):
    """Note that the force of contact n is not unique; unsure: see `UNSURE`."""
    m.contact_memory[n, at.UNSURE] = max(m.contact_memory[n, at.UNSURE], unsure)


@compiled
def note_shares(m, count):
    """Note contacts of the last solution whose normal force others might bear: see `take_least`, which comes before."""
    size, first, column = 0, 0, 0
    for k in range(count):
        size += unknowns_of(m.candidate[k])
    for c in range(size):
        first += 1 if m.pivots[c] >= 0 else 0
    for k in range(count):
        for row in range(first, size):
            if m.candidate[k] != OFF and abs(m.system[row, column]) > SHARES:
                doubt(m, m.active[k], 1.0)
        column += unknowns_of(m.candidate[k])


@compiled
def along(system, row, other, size):
    """Inner product of two rows."""
    total = 0.0
    for c in range(size):
        total += system[row, c] * system[other, c]
    return total


@compiled
def take_out(system, row, other, size):
    """Subtract from a row what lies along another one, of unit length."""
    share = along(system, row, other, size)
    for c in range(size):
        system[row, c] -= share * system[other, c]


@compiled
def take_solution(m, count, size, rough):
    """Forces f of all contacts from the solution of their equations, and the rates a = b + G f."""
    delassus, side, system, candidate = m.delassus, m.side, m.system, m.candidate
    column = 0
    for k in range(count):
        side[F, 2 * k], side[F, 2 * k + 1] = 0.0, 0.0
        if candidate[k] == OFF:
            continue
        for d in range(2 if candidate[k] == STICK else 1):
            side[F, 2 * k + d] = system[place_of(m.pivots, column), size]
            column += 1
        if candidate[k] == STICK:
            continue
        if rough == 1:
            mu = friction_of(m, m.active[k])
            side[F, 2 * k + 1] = (mu if candidate[k] == FORWARD else -mu) * side[F, 2 * k]
    for r in range(2 * count):
        value = side[B, r]
        for s in range(2 * count):
            value += delassus[r, s] * side[F, s]
        side[A, r] = value


@compiled
def eliminate(m, count, rough):
    """`modes_kernel` with G as a full matrix."""
    size, scale = fill_rows(m, count, rough)
    sign = solve_least(m.system, m.pivots, size, max(scale, m.held[at.NOISE] / EXACT))
    take_solution(m, count, size, rough)
    return sign


@compiled
def resolution(m, count):
    """Magnitudes of f and of a below which they count as zero, in the units of f and a."""
    side, delassus = m.side, m.delassus
    force, rate = 0.0, m.held[at.SCALE]
    if m.held[at.SPARSE] == 0.0:
        rate = 0.0
        for r in range(2 * count):
            rate = max(rate, abs(side[B, r]))
            for s in range(2 * count):
                rate = max(rate, abs(delassus[r, s] * side[F, s]))
    for r in range(2 * count):
        force = max(force, abs(side[F, r]))
    return EXACT * force, max(EXACT * rate, m.held[at.FAINT])


@compiled
def set_floor(m, size):
    """Note below which magnitude a is rounding; size: that of the motion without f, as a root of its energy.

    By Schwarz's inequality a row w has no more than |w| sqrt(v M v) of rates, and |w| sqrt(Q M^-1 Q) of accelerations;
    what the joints cancel of |w| is known from G.
    """
    if m.held[at.SPARSE] == 0.0:
        m.held[at.FAINT] = OF_TERMS * math.sqrt(m.held[at.NOISE] / ROUNDING) * size


@compiled
def mode_of_closing(slide, mu):
    """The first mode of a contact that closes: as it slides, or sticking."""
    if slide != 0 or mu == 0.0:
        return BACKWARD if slide < 0 else FORWARD
    return STICK


@compiled
def better_friction(m, k, mode, force, rate):
    """The mode of friction that closed contact k should have according to the present solution."""
    slip, mu = m.side[A, 2 * k + 1], friction_of(m, m.active[k])
    if mode == STICK:
        held = m.side[F, 2 * k + 1]
        if abs(held) > mu * m.side[F, 2 * k] + force:
            return FORWARD if held > 0.0 else BACKWARD
        if mu > 0.0 and abs(slip) > LOOSE * rate:  # no force along the wall can hold it
            return FORWARD if slip < 0.0 else BACKWARD
        return STICK
    if m.slide[k] == 0 and ((mode == FORWARD and mu > 0.0 and slip > rate) or (mode == BACKWARD and slip < -rate)):
        return STICK
    return mode


@compiled
def better_mode(m, k, force, rate):
    """The mode that contact k should have according to the present solution; the present mode if it is consistent."""
    side, mode = m.side, m.candidate[k]
    if mode == OFF:
        return OFF if side[A, 2 * k] >= -rate else mode_of_closing(m.slide[k], friction_of(m, m.active[k]))
    if side[F, 2 * k] < -force or side[A, 2 * k] > LOOSE * rate:  # no force can keep it closed
        return OFF
    return better_friction(m, k, mode, force, rate)


@compiled
def is_solution(m, count, slack):
    """True if the solution satisfies all conditions of the modes in `candidate`; slack: multiple of `resolution`."""
    side, candidate = m.side, m.candidate
    force, rate = resolution(m, count)
    for k in range(count):
        if better_mode(m, k, slack * force, slack * rate) != candidate[k]:
            return False
        if candidate[k] != OFF and not abs(side[A, 2 * k]) <= LOOSE * rate:
            return False
    return True


@compiled
def change_where_broken(m, count):
    """Change the modes in `candidate` where a condition is violated, until none is; True if that converges."""
    candidate = m.candidate
    together = 6 + 2 * min(count, FEW)  # then one at a time, to avoid cycling
    for sweep in range(12 + 6 * min(count, FEW)):
        linear(m, count)
        force, rate = resolution(m, count)
        changed = False
        for k in range(count):
            mode = better_mode(m, k, force, rate)
            if mode != candidate[k] and not (changed and sweep > together):
                candidate[k] = mode
                changed = True
        if not changed:
            return is_solution(m, count, 1.0)
    return False


@kernel("problem")
def search_kernel(m, count):
    """Find modes, f and a of the active contacts, units as of `linear`, starting from the modes in `candidate`.

    Returns SOLVED, IMPOSSIBLE, JAMMED or UNDECIDED.
    """
    held = m.held
    held[at.OUTCOME] = SOLVED
    if change_where_broken(m, count):
        return SOLVED
    outcome = call_problem(m.problem_table[FOLLOW], (m, count))
    if outcome == SOLVED and not change_where_broken(m, count):
        # rows that depend on each other, or forces of rounding size: take the end of the path
        call_problem(m.problem_table[FOLLOW], (m, count))
        linear(m, count)
        outcome = SOLVED if is_solution(m, count, LOOSE) else UNDECIDED
    if outcome != SOLVED and count <= MOST_TRIED:
        outcome = SOLVED if call_problem(m.problem_table[TRY_ALL], (m, 2 * count)) > 0 else IMPOSSIBLE
    held[at.OUTCOME] = outcome
    return outcome


KERNELS = (rows_kernel, search_kernel, modes_kernel)
