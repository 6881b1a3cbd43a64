"""Dry friction in joints without play, by the joint's own reaction.

Along the free coordinate of a joint, the row w with u = w . v (turning: rad/s, sliding: m/s), acts tau = w . force:

    slips in the sense s = +-1     tau = -s mu L(lambda)                        (coulomb)
    rests at its limit             tau = -s mu_static L(lambda), as others hold it that stick
    sticks                         w . dv = gamma,   |tau| <= mu_static L       (coulomb)
    always                         tau = -T(arm u, N) arm                       (a law of the family "friction")

    L = arm N,   N = hypot(lambda_1, lambda_2) of a pin,   max(|lambda_1|, |lambda_2| / a) of a block of length 2 a,
                 |lambda_1| of a joint with one row,  NU |lambda_1| of a surface, by the column NU of its row w,
                 hypot(lambda_1, NU (tau - tau')) of a rod, NU = 1/L, tau' of its other pin,
                 N of its contact of a disc that rolls,
                 1 where the size of the friction is stated: mu and mu_static are then that size, arm is 1

The reaction lambda depends on tau.  With the responses to unit forces,

    Z = S^-1 Phi_q M^-1 w,   Y = M^-1 (w - Phi_q^T Z),

    lambda = lambda_0 + Z tau,   dv = dv_0 + Y tau,

so that tau of all joints follows from a few Newton steps.  N is convex; one joint has one solution if mu L(Z) < 1.
A determinant that is not positive, or no convergence, means that friction locks the joint: then tau is nan.

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5; the coupling: this package.
"""

from __future__ import annotations

import math

from rattle.equations.dependent_rows import FIXED, STAYS, fixed_value, is_fixed
from rattle.equations.massless import prepare, take_out_of_response
from rattle.equations.schur import solve
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.families import call_friction, call_joint
from rattle.jit.functions import compiled, native

ROUNDS = 40  # Newton steps after which there is no solution
GRIPS = 16  # parts in which friction is let grow where Newton's method alone finds no solution
CLOSE = 4e-16  # share of tau that ends them
TILT = 1e-6  # share of N by which the slope of a law is measured
FIRM = 1e-12  # share of its own mobility below which other joints or drivers hold a coordinate, beside massless bodies
DEPENDENT = 1e-10  # pivot below which a coordinate depends on others, as a share of its diagonal
LOST = 1e-3  # share of a mobility without joints that is left from which on DEPENDENT is more: of more cancels
REST = 1e-13  # rate (or its derivative) [m, rad, s] below which a coordinate is at rest, besides rounding of its terms
ROUNDED = 1e-13  # share of the terms of a rate that is rounding
CONVERGED = 1e-12  # share of tau: changes below it end Newton's method once they do not decrease
BEYOND = 1e-12  # share of its limit by which tau may exceed it by rounding


@compiled
def along(m, n, values, column):
    """w_n . values; values (nb + 1, ...) has x, y, angle from `column` on."""
    dry, rows = m.dry, m.dry_rows
    a, b = dry[n, at.DRY_A], dry[n, at.DRY_B]
    total = 0.0
    for k in range(3):
        total += rows[n, at.AX + k] * values[a, column + k] + rows[n, at.BX + k] * values[b, column + k]
    return total


@compiled
def rounding(m, n):
    """Rate [m/s or rad/s] below which that of coordinate n is zero or rounding."""
    dry, rows, body = m.dry, m.dry_rows, m.body
    a, b = dry[n, at.DRY_A], dry[n, at.DRY_B]
    total = 0.0
    for k in range(3):
        total += abs(rows[n, at.AX + k] * body[a, at.VX + k]) + abs(rows[n, at.BX + k] * body[b, at.VX + k])
    return REST + ROUNDED * total


@compiled
def respond(m, n):
    """Responses of accelerations and multipliers to a unit force along coordinate n; S is factored."""
    dry, line, rows, weight, x = m.dry, m.dry_rows, m.rows, m.weight, m.solution
    response, reaction, place_of, row_body = m.dry_response, m.dry_reaction, m.place, m.row_body
    for k in range(response.shape[1]):
        response[n, k] = 0.0
    for k in range(3):
        a, b = dry[n, at.DRY_A], dry[n, at.DRY_B]
        response[n, 3 * a + k] += weight[a, k] * line[n, at.AX + k]
        response[n, 3 * b + k] += weight[b, k] * line[n, at.BX + k]
    free = 0.0
    for k in range(3):
        a, b = dry[n, at.DRY_A], dry[n, at.DRY_B]
        free += line[n, at.AX + k] * response[n, 3 * a + k] + line[n, at.BX + k] * response[n, 3 * b + k]
    for r in range(rows.shape[0]):
        a, b = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
        value = 0.0
        for k in range(3):
            value += rows[r, at.AX + k] * response[n, 3 * a + k] + rows[r, at.BX + k] * response[n, 3 * b + k]
        x[place_of[r]] = value
    solve(m)
    for r in range(rows.shape[0]):
        value = x[place_of[r]]
        reaction[n, r] = value
        a, b = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
        for k in range(3):
            response[n, 3 * a + k] -= weight[a, k] * rows[r, at.AX + k] * value
            response[n, 3 * b + k] -= weight[b, k] * rows[r, at.BX + k] * value
    if m.massless.shape[0] > 0:
        take_out_of_response(m, response, 3, reaction, n)
    hold(m, n, free)


@compiled
def hold(m, n, free):
    """Note whether the joints and drivers hold coordinate n, so that its friction moves nothing.

    free: mobility without them.  A coordinate that sticks stays held until positions differ by more than steps err;
    its rate is that of the joints and drivers, without the error of a step.
    """
    memory, response = m.dry_memory, m.dry_response
    if m.massless.shape[0] > 0:
        memory[n, at.DRY_HELD] = 1.0 if mobility(m, n, n) <= FIRM * free else 0.0
        return
    kept = memory[n, at.DRY_HELD] == 1.0 and memory[n, at.DRY_MODE] == at.DRY_STICKS
    fixed = is_fixed(m, response, 3, m.dry_reaction, n, free, STAYS if kept else FIXED)
    memory[n, at.DRY_HELD] = 1.0 if fixed else 0.0
    if fixed and kept:
        memory[n, at.DRY_RATE] = fixed_value(m, m.dry_reaction, n, at.NU)
    if fixed:
        for c in range(response.shape[1]):
            response[n, c] = 0.0


@compiled
def mobility(m, n, o):
    """Acceleration along coordinate n per unit force along coordinate o."""
    dry, line, response = m.dry, m.dry_rows, m.dry_response
    a, b = dry[n, at.DRY_A], dry[n, at.DRY_B]
    total = 0.0
    for k in range(3):
        total += line[n, at.AX + k] * response[o, 3 * a + k] + line[n, at.BX + k] * response[o, 3 * b + k]
    return total


@compiled
def bearing(m, n, multiplier, column):
    """What joint n bears: its multipliers, or force along a rod and across it by the frictions in `column`."""
    q = m.dry[n, at.DRY_SECOND]
    if m.dry[n, at.DRY_FORM] == at.DRY_ROLLER:
        return m.dry_memory[n, at.IMPACT_PRESS] if column == at.IMPACT_FRICTION else m.dry_memory[n, at.DRY_PRESS], 0.0
    if m.dry[n, at.DRY_FORM] == at.DRY_ROD:
        across = m.dry_rows[n, at.NU] * (m.dry_memory[n, column] - m.dry_memory[q, column])
        return multiplier[m.dry[n, at.DRY_ROW]], across
    return multiplier[m.dry[n, at.DRY_ROW]], multiplier[q]


@compiled
def borne(m, n, o):
    """What joint n bears per unit friction of joint o, as `bearing`."""
    q = m.dry[n, at.DRY_SECOND]
    if m.dry[n, at.DRY_FORM] == at.DRY_ROLLER:
        return 0.0, 0.0
    if m.dry[n, at.DRY_FORM] == at.DRY_ROD:
        across = m.dry_rows[n, at.NU] if o == n else (-m.dry_rows[n, at.NU] if o == q else 0.0)
        return m.dry_reaction[o, m.dry[n, at.DRY_ROW]], across
    return m.dry_reaction[o, m.dry[n, at.DRY_ROW]], m.dry_reaction[o, q]


@compiled
def presses_roller(m, n, r):
    """True if row r of the active contacts is the normal force by which disc n, which rolls, is pressed."""
    if m.dry[n, at.DRY_FORM] != at.DRY_ROLLER or r % 2 == 1:
        return False
    return m.active[r // 2] == m.dry[n, at.DRY_SECOND]


@compiled
def borne_from(m, n, reaction, r):
    """What joint n bears per unit of the force, in row r of the active contacts, that changes multipliers by
    -reaction[r], with the other sign, as `bearing`."""
    if m.dry[n, at.DRY_FORM] == at.DRY_ROLLER:
        return -1.0 if presses_roller(m, n, r) else 0.0, 0.0
    q = 0 if m.dry[n, at.DRY_FORM] == at.DRY_ROD else m.dry[n, at.DRY_SECOND]
    second = 0.0 if m.dry[n, at.DRY_FORM] == at.DRY_ROD else reaction[r, q]
    return reaction[r, m.dry[n, at.DRY_ROW]], second


@compiled
def pressing(m, n, first, second):
    """N [N] of joint n by what it bears, and its slopes with respect to that; 1 where its friction is stated."""
    if m.dry[n, at.DRY_STATED] == 1:
        return 1.0, 0.0, 0.0
    reach = m.values[m.dry[n, at.DRY_P] + at.DRY_REACH]
    if m.dry[n, at.DRY_FORM] == at.DRY_SURFACE:
        size = m.dry_rows[n, at.NU]
        return size * abs(first), math.copysign(size, first), 0.0
    if m.dry[n, at.DRY_FORM] == at.DRY_PIN or m.dry[n, at.DRY_FORM] == at.DRY_ROD:
        size = math.hypot(first, second)
        divisor = select(size > 0.0, size, 1.0)
        return size, first / divisor, second / divisor
    middle = abs(first) >= reach * abs(second)
    size, slope = select(middle, abs(first), reach * abs(second)), math.copysign(1.0, first)
    return size, select(middle, slope, 0.0), select(middle, 0.0, math.copysign(reach, second))


@compiled
def resistance(m, n, N):
    """|tau| while coulomb friction slips, or tau of a law at the present rate, for the normal force N [N]."""
    p, values, memory = m.dry[n, at.DRY_P], m.values, m.dry_memory
    arm = values[p + at.DRY_ARM]
    if m.dry[n, at.DRY_LAW] < 0 and memory[n, at.DRY_FIRM] == 1.0:
        return values[p + at.DRY_MU_STATIC] * arm * N
    if m.dry[n, at.DRY_LAW] < 0:
        return values[p + at.DRY_MU] * arm * N
    u = arm * memory[n, at.DRY_RATE]
    law, first, end = m.friction_table[m.dry[n, at.DRY_LAW]], m.dry[n, at.DRY_STATE], m.element_state.shape[0]
    z, dz = m.element_state[first:end], m.element_rate[first:end]
    return arm * call_friction(law, (u, N, z, values, p + at.DRY_FIELDS, dz))


@compiled
def resisting(m, n, first, second):
    """`resistance` by what joint n bears, and its slopes with respect to that."""
    N, slope, slope2 = pressing(m, n, first, second)
    size = resistance(m, n, N)
    some = select(N > 0.0, N, 1.0)
    grows = select(N > 0.0, (resistance(m, n, some * (1.0 + TILT)) - size) / (TILT * some), 0.0)
    return size, grows * slope, grows * slope2


@compiled
def sense_of(m, n):
    """Factor of `resistance` in tau: minus the sense of slip, zero where nothing slips."""
    if m.dry[n, at.DRY_LAW] >= 0:
        return -1.0
    mode, rate = m.dry_memory[n, at.DRY_MODE], m.dry_memory[n, at.DRY_RATE]
    if mode == at.DRY_AUTO:
        return 0.0 if rate == 0.0 else -math.copysign(1.0, rate)
    return -mode


@compiled
def plain_row(m, n):
    """Row n of `dry_system` for a joint whose tau does not depend on others, but for its right-hand side: the identity.

    Its last number says how much less exactly it is known than rounding, see `eliminate`.
    """
    system = m.dry_system
    for o in range(system.shape[0]):
        system[n, o] = 1.0 if n == o else 0.0
    system[n, system.shape[0] + 1] = 1.0


@compiled
def sticking_row(m, n):
    """Row n for a joint that sticks, by its own mobility, which is returned."""
    system, line, dry, own = m.dry_system, m.dry_rows, m.dry, mobility(m, n, n)
    free = 0.0
    for k in range(3):
        a, b = dry[n, at.DRY_A], dry[n, at.DRY_B]
        free += m.weight[a, k] * line[n, at.AX + k] ** 2 + m.weight[b, k] * line[n, at.BX + k] ** 2
    for o in range(system.shape[0]):
        system[n, o] = mobility(m, n, o) / own
    system[n, system.shape[0] + 1] = max(1.0, LOST * free / own)
    return own


@compiled
def set_up(m, grip):
    """Residual and Jacobian of the equations of all tau at the present estimate, into `dry_system`.

    grip: share of all friction that slips.
    """
    memory, system, multiplier = m.dry_memory, m.dry_system, m.multiplier
    count = memory.shape[0]
    for n in range(count):
        tau = memory[n, at.DRY_FORCE]
        plain_row(m, n)
        system[n, count] = tau
        if memory[n, at.DRY_MODE] == at.DRY_STICKS and m.dry[n, at.DRY_LAW] < 0:
            if memory[n, at.DRY_HELD] == 1.0:
                continue
            value = (along(m, n, m.acceleration, 0) - m.dry_rows[n, at.GAMMA]) / sticking_row(m, n)
            for o in range(count):
                value += system[n, o] * (memory[o, at.DRY_FORCE] - memory[o, at.DRY_ADDED])
            system[n, count] = value
            continue
        sign = grip * sense_of(m, n)
        first, second = bearing(m, n, multiplier, at.DRY_ADDED)
        for o in range(count):
            more = memory[o, at.DRY_FORCE] - memory[o, at.DRY_ADDED]
            by_first, by_second = borne(m, n, o)
            first += by_first * more
            second += by_second * more
        size, slope, slope2 = resisting(m, n, first, second)
        system[n, count] = tau - sign * size
        for o in range(count):
            by_first, by_second = borne(m, n, o)
            system[n, o] -= sign * (slope * by_first + slope2 * by_second)


@compiled
def eliminate(system, count):
    """Solve system[:, :count] x = system[:, count] in place; x takes the place of the right-hand side.

    Rows have diagonals of about one, and pivots are taken from these.  Where nothing but rounding is left, x is zero:
    coordinates that sticking joints already hold need no friction of their own.  Rounding is what the last column says,
    of the row and of those before it.  Returns the sign of the determinant of the rest, 0 if it is not finite; it would
    depend on the way if rows that depend on each other were exchanged.
    """
    sign, rounded = 1.0, 1.0
    for k in range(count):
        pivot = system[k, k]
        if not abs(pivot) < math.inf:
            return 0.0
        if abs(pivot) <= DEPENDENT * max(rounded, system[k, count + 1]):
            for o in range(count + 1):
                system[k, o] = 1.0 if o == k else 0.0
            continue
        rounded = max(rounded, system[k, count + 1])
        sign = math.copysign(sign, sign * pivot)
        for n in range(k + 1, count):
            share = system[n, k] / pivot
            for o in range(k, count + 1):
                system[n, o] -= share * system[k, o]
    for k in range(count - 1, -1, -1):
        value = system[k, count]
        for o in range(k + 1, count):
            value -= system[k, o] * system[o, count]
        system[k, count] = value / system[k, k]
    return sign


@compiled
def find_forces(m):
    """tau of every joint into `dry_memory`; False if there is none.

    Several joints may have several solutions, and Newton's method from the present estimate may end at one where
    friction locks.  The one to which tau grows with all coefficients of friction is then followed from none of them.
    """
    if improve_forces(m, 1.0):
        return True
    for n in range(m.dry_memory.shape[0]):
        m.dry_memory[n, at.DRY_FORCE] = 0.0
    for part in range(GRIPS + 1):
        if not improve_forces(m, part / GRIPS):
            return False
    return True


@compiled
def improve_forces(m, grip):
    """Newton's method for tau, from its present estimate; False if it ends nowhere or where friction locks."""
    memory, system = m.dry_memory, m.dry_system
    count = memory.shape[0]
    last = math.inf
    for _ in range(ROUNDS):
        set_up(m, grip)
        sign = eliminate(system, count)
        if sign == 0.0:
            return False
        change, size = 0.0, 0.0
        for n in range(count):
            memory[n, at.DRY_FORCE] -= system[n, count]
            change += abs(system[n, count])
            size += abs(memory[n, at.DRY_FORCE])
        if not size < math.inf:
            return False
        if change <= CLOSE * size or (change <= CONVERGED * size and change >= last):
            return sign > 0.0
        last = change
    return False


@native("void", "h")
def complete_dry_friction(m):
    """Find tau of all joints for the present accelerations and multipliers, and add what these do not yet contain."""
    memory, response, reaction = m.dry_memory, m.dry_response, m.dry_reaction
    acceleration, multiplier = m.acceleration, m.multiplier
    solved = find_forces(m)
    for n in range(memory.shape[0]):
        tau = memory[n, at.DRY_FORCE] if solved else math.nan
        more = tau - memory[n, at.DRY_ADDED]
        memory[n, at.DRY_LOCKS] = 0.0 if solved else 1.0
        memory[n, at.DRY_FORCE], memory[n, at.DRY_ADDED] = tau, tau
        for i in range(1, acceleration.shape[0]):
            for k in range(3):
                acceleration[i, k] += response[n, 3 * i + k] * more
        for r in range(multiplier.shape[0]):
            multiplier[r] += reaction[n, r] * more


@native("void", "h")
def prepare_rows(m):
    """Rows and rates of the free coordinates of all joints with friction, and responses along them; S is factored."""
    dry, memory = m.dry, m.dry_memory
    if m.massless.shape[0] > 0:
        prepare(m)
    for n in range(dry.shape[0]):
        a, b, p = dry[n, at.DRY_A], dry[n, at.DRY_B], dry[n, at.DRY_P]
        if dry[n, at.DRY_FORM] >= at.DRY_SURFACE:  # its row has the parameters of the joint
            p = m.joint[dry[n, at.DRY_JOINT], at.FIRST_P]
        call_joint(m.joint_table[dry[n, at.DRY_KERNEL]], (m.body, a, b, m.values, p, n, m.dry_rows))
        memory[n, at.DRY_RATE] = along(m, n, m.body, at.VX)
        memory[n, at.DRY_FORCE], memory[n, at.DRY_ADDED] = 0.0, 0.0
        if dry[n, at.DRY_FORM] == at.DRY_ROLLER:  # set-valued contacts are yet to be solved
            c = dry[n, at.DRY_SECOND]
            memory[n, at.DRY_PRESS] = m.contact_kinematics[c, at.NORMAL] if m.contact[c, at.IMPACT] == 0 else 0.0
        respond(m, n)


@native("void", "h")
def add_dry_friction(m):
    """Add the response to the friction of all joints to accelerations and multipliers.

    Needs S factored and the motion without this friction.
    """
    prepare_rows(m)
    complete_dry_friction(m)


@native("void", "h")
def end_dry_friction(m):
    """Once all forces are known: power lost by friction, rates of states of its laws, and which modes cannot last."""
    dry, memory, multiplier = m.dry, m.dry_memory, m.multiplier
    for n in range(dry.shape[0]):
        m.power[at.LOSS_RATE] -= memory[n, at.DRY_FORCE] * memory[n, at.DRY_RATE]
        if dry[n, at.DRY_LAW] >= 0:
            first, second = bearing(m, n, multiplier, at.DRY_FORCE)
            N, _, _ = pressing(m, n, first, second)
            resistance(m, n, N)
        if lasting(m, n) < 0.0:
            memory[n, at.DRY_OVER] = 1.0


@compiled
def limit(m, n):
    """The largest |tau| at which joint n sticks, by the present multipliers."""
    p = m.dry[n, at.DRY_P]
    first, second = bearing(m, n, m.multiplier, at.DRY_FORCE)
    N, _, _ = pressing(m, n, first, second)
    return m.values[p + at.DRY_MU_STATIC] * m.values[p + at.DRY_ARM] * N


@compiled
def is_smooth(m, n):
    """True if joint n does not stick: its friction has a law, or no size."""
    return m.dry[n, at.DRY_LAW] >= 0 or m.values[m.dry[n, at.DRY_P] + at.DRY_MU_STATIC] == 0.0


@compiled
def lasting(m, n):
    """Negative where the mode of joint n cannot last: it slips backwards, or sticks beyond its limit."""
    memory = m.dry_memory
    mode, rate, tau = memory[n, at.DRY_MODE], memory[n, at.DRY_RATE], memory[n, at.DRY_FORCE]
    if is_smooth(m, n) or mode == at.DRY_AUTO:
        return 1.0
    if mode != at.DRY_STICKS and memory[n, at.DRY_PRESSED] == 1.0:  # a contact would have to open first
        return 1.0
    if mode == at.DRY_STICKS and memory[n, at.DRY_HELD] == 1.0:  # a driver decides
        return 1.0 if abs(rate) <= rounding(m, n) else -1.0
    if mode == at.DRY_STICKS:
        most = limit(m, n)
        return most * (1.0 + BEYOND) - abs(tau)
    return mode * rate + rounding(m, n)
