"""Forces of compliant contacts and oil films over a step of Moreau-Jean: those at its end, so that it stays stable.

    u = J v        four rates of each of them: ddelta and slip of its dry contact, the velocity that its film sees
    phi(u)         the forces that belong to them, phi . u their power: -N(delta + h/2 ddelta, ddelta), -T, F
    M (v+ - v) = h Q + h J^T phi(J v+) - Phi_q^T Lambda - W P

delta and the place of the pin in its film are those of the middle of the step, the same for all v+.  A film is minus
the gradient of a convex potential and a contact pushes the more, the deeper it is: then v+ is unique, kinetic energy
is only lost, however stiff they are and however long the step, and the error is O(h).

Newton's method about u_k, with D = dphi/du, G = J M^-1 J^T between the joints, and P the percussions:

    (1 - h G D) u = J (v + h a) + h G (phi_k - D u_k) - J M^-1 W^T P

so that contacts see the responses M^-1 W^T + h M^-1 J^T D (1 - h G D)^-1 J M^-1 W^T.  Friction is linearised
for the normal force at hand.

Source: Acary, Brogliato, Numerical Methods for Nonsmooth Dynamical Systems (2008), chapter 10, on stiff forces in time
stepping.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import contact_row, friction_of, respond
from rattle.equations.compliant import locate_contacts, push
from rattle.equations.massless import prepare
from rattle.equations.state import DISSIPATED, IMPULSE, LOSS, STORED, account_at, energies_at
from rattle.jit import layout as at
from rattle.jit.families import call_film, call_friction
from rattle.jit.functions import compiled, native
from rattle.jit.geometry import ends
from rattle.jit.small_matrices import factor_lu, solve_lu
from rattle.solvers.contacts.contact_events import open_up, shut, spend, strain_energy

PER = 4  # rows of each: normal, tangent, film along x and y
PHI, U, FREE, BASE, AT_BASE, NEW, LINEAR, TRUE, WORK = range(9)  # rows of `soft_force`
FORWARD = 1e-7  # increments of rates, as a share of them
LEAST = 1e-10  # and at least [m/s, rad/s]
SAME = 1e-10  # change of rates by what the linear law leaves, as a share of them, that ends the iteration
BEARABLE = 1e-4  # the same, which may remain after MOST rounds
MOST = 40
LEAST_OF_FILM = 1e-3  # of LEAST, for rates in a film


@compiled
def rate_of(m, r, n, values, column):
    """J_r . values for row r of contact n; values (nb + 1, ...) has x, y, phi from `column` on."""
    a, b, j = m.contact[n, at.A_BODY], m.contact[n, at.B_BODY], m.soft_jacobian
    total = 0.0
    for q in range(3):
        total += j[r, q] * values[a, column + q] + j[r, 3 + q] * values[b, column + q]
    return total


@compiled
def film_rows(m, n, r):
    """Rows r and r + 1 of J: the velocity that the film of contact n sees; the place of its pin [m]."""
    j, a, b = m.soft_jacobian, m.contact[n, at.A_BODY], m.contact[n, at.B_BODY]
    sax, say, sbx, sby, ex, ey, _, _ = ends(m.body, a, b, m.values, m.contact[n, at.SHAPE_P])
    j[r, 0], j[r, 1], j[r, 2] = -1.0, 0.0, say + 0.5 * ey
    j[r, 3], j[r, 4], j[r, 5] = 1.0, 0.0, -sby + 0.5 * ey
    j[r + 1, 0], j[r + 1, 1], j[r + 1, 2] = 0.0, -1.0, -sax - 0.5 * ex
    j[r + 1, 3], j[r + 1, 4], j[r + 1, 5] = 0.0, 1.0, sbx - 0.5 * ex
    return ex, ey


@native("void", "h", "f", "f")
def take_out(m, t, h):
    """Rows of J in the middle of the step from t [s] of length h [s]; their forces are taken out of Q and the losses.

    Contacts that would penetrate by the end of the step start.  Of films the friction of their shear stays in Q.
    """
    soft, contact, kinematics, memory, force = m.soft, m.contact, m.contact_kinematics, m.contact_memory, m.force
    j, body = m.soft_jacobian, m.body
    for s in range(soft.shape[0]):
        n, r = soft[s], PER * s
        for k in range(r, r + PER):
            for q in range(6):
                j[k, q] = 0.0
        contact_row(m, n, 0, j, r)
        contact_row(m, n, 1, j, r + 1)
        phi = m.soft_force[PHI]
        phi[r], phi[r + 1], phi[r + 2], phi[r + 3] = -kinematics[n, at.NORMAL], -kinematics[n, at.TANGENT], 0.0, 0.0
        if contact[n, at.FILM_LAW] >= 0:
            ex, ey = film_rows(m, n, r + 2)
            fx, fy = kinematics[n, at.FILM_X], kinematics[n, at.FILM_Y]
            phi[r + 2], phi[r + 3] = fx, fy
            half = 0.5 * (ex * fy - ey * fx)
            m.soft_place[s, 0], m.soft_place[s, 1] = ex, ey
            kinematics[n, at.FILM_A] += half
            kinematics[n, at.FILM_B] += half
            pressed = fx * rate_of(m, r + 2, n, body, at.VX) + fy * rate_of(m, r + 3, n, body, at.VX)
            kinematics[n, at.FILM_LOSS] += pressed
            m.power[at.LOSS_RATE] += pressed
        for end in range(2):
            i = contact[n, at.A_BODY + end]
            for q in range(3):
                for k in range(PER):
                    force[i, q] -= j[r + k, 3 * end + q] * phi[r + k]
        rate = kinematics[n, at.DGAP]
        if memory[n, at.CLOSED] == at.OPEN and kinematics[n, at.GAP] + 0.5 * h * rate < 0.0:
            late = min(max(kinematics[n, at.GAP] / rate, -0.5 * h), 0.5 * h) if rate < 0.0 else 0.5 * h
            shut(m, n, t + 0.5 * h - late, m.state_new)
            m.tally[at.CONTACTS] += 1


@compiled
def respond_all(m):
    """Responses to all rows of J, and G."""
    soft, contact, g, response = m.soft, m.contact, m.soft_delassus, m.soft_response
    if m.massless.shape[0] > 0:
        prepare(m)
    size = PER * soft.shape[0]
    for r in range(size):
        n = soft[r // PER]
        respond(m, contact[n, at.A_BODY], contact[n, at.B_BODY], m.soft_jacobian, response, m.soft_reaction, r)
    for i in range(size):
        for k in range(size):
            g[i, k] = row_on(m, i, response, k)


@compiled
def row_on(m, r, response, k):
    """J_r of row k of responses (rows, 3 nb)."""
    n, j = m.soft[r // PER], m.soft_jacobian
    total = 0.0
    for end in range(2):
        i = m.contact[n, at.A_BODY + end]
        if i > 0:
            for q in range(3):
                total += j[r, 3 * end + q] * response[k, 3 * i - 3 + q]
    return total


@compiled
def normal_at(m, n, h, rate):
    """N [N] of the dry contact n at the end of a step of length h [s] in which delta changes at this rate [m/s]."""
    gap = m.contact_kinematics[n, at.GAP] - 0.5 * h * rate
    if gap >= 0.0 or m.contact_memory[n, at.CLOSED] == at.OPEN:
        return 0.0
    normal = push(m, n, gap, -rate)[1]
    return max(0.0, normal) if m.contact[n, at.BY_FORCE] == 1 else normal


@compiled
def tangent_at(m, n, slip, normal):
    """T [N] of the dry contact n at a slip [m/s] under this normal force [N]."""
    contact, first = m.contact, m.contact[n, at.FIRST_STATE]
    if contact[n, at.FRICTION] < 0 or normal <= 0.0:
        return 0.0
    arguments = (slip, normal, m.element_state[first:], m.values, contact[n, at.FRICTION_P], m.element_rate[first:])
    return call_friction(m.friction_table[contact[n, at.FRICTION]], arguments)


@compiled
def film_at(m, s, ux, uy):
    """Force [N] of the film of entry s on its pin that sees the velocity u [m/s]."""
    n, out = m.soft[s], m.film_force
    arguments = (
        m.soft_place[s, 0], m.soft_place[s, 1], ux, uy, 0.0, 0.0, m.values, m.contact[n, at.FILM_P],
        m.film_coefficients, out,
    )  # fmt: skip
    call_film(m.film_table[m.contact[n, at.FILM_LAW]], arguments)
    return out[0], out[1]


@compiled
def evaluate(m, h, at_row, into):
    """phi of all entries at the rates in one row of `soft_force`, into another."""
    table = m.soft_force
    for s in range(m.soft.shape[0]):
        n, r = m.soft[s], PER * s
        normal = normal_at(m, n, h, table[at_row, r])
        table[into, r] = -normal
        table[into, r + 1] = -tangent_at(m, n, table[at_row, r + 1], normal)
        table[into, r + 2], table[into, r + 3] = 0.0, 0.0
        if m.contact[n, at.FILM_LAW] >= 0:
            table[into, r + 2], table[into, r + 3] = film_at(m, s, table[at_row, r + 2], table[at_row, r + 3])


@compiled
def differentiate(m, h):
    """D at U, where phi is known; symmetric, and no force may grow with its rate."""
    phi, u, d = m.soft_force[PHI], m.soft_force[U], m.soft_slope
    for s in range(m.soft.shape[0]):
        n, r = m.soft[s], PER * s
        for k in range(PER):
            for c in range(PER):
                d[r + k, c] = 0.0
        step = FORWARD * abs(u[r]) + LEAST
        d[r, 0] = min(-(normal_at(m, n, h, u[r] + step) + phi[r]) / step, 0.0)
        step = FORWARD * abs(u[r + 1]) + LEAST
        d[r + 1, 1] = min(-(tangent_at(m, n, u[r + 1] + step, -phi[r]) + phi[r + 1]) / step, 0.0)
        if m.contact[n, at.FILM_LAW] >= 0:
            step = FORWARD * math.hypot(u[r + 2], u[r + 3]) + LEAST_OF_FILM * LEAST
            fx, fy = film_at(m, s, u[r + 2] + step, u[r + 3])
            d[r + 2, 2] = min((fx - phi[r + 2]) / step, 0.0)
            across = (fy - phi[r + 3]) / step
            fx, fy = film_at(m, s, u[r + 2], u[r + 3] + step)
            d[r + 3, 3] = min((fy - phi[r + 3]) / step, 0.0)
            across = 0.5 * (across + (fx - phi[r + 2]) / step)
            most = math.sqrt(d[r + 2, 2] * d[r + 3, 3])
            d[r + 2, 3] = d[r + 3, 2] = min(max(across, -most), most)


@compiled
def sloped(m, x, r):
    """Row r of D x."""
    total, first = 0.0, PER * (r // PER)
    for c in range(PER):
        total += m.soft_slope[r, c] * x[first + c]
    return total


@compiled
def linearise(m, h):
    """phi and D at U, the matrix of the step factored; rates and forces without percussions into AT_BASE and BASE."""
    table, g, matrix, d = m.soft_force, m.soft_delassus, m.soft_matrix, m.soft_slope
    size = matrix.shape[0]
    evaluate(m, h, U, PHI)
    differentiate(m, h)
    for i in range(size):
        table[WORK, i] = table[PHI, i] - sloped(m, table[U], i)
        for k in range(size):
            total, first = 0.0, PER * (k // PER)
            for c in range(PER):
                total += g[i, first + c] * d[first + c, k - first]
            matrix[i, k] = (1.0 if i == k else 0.0) - h * total
    for i in range(size):
        total = table[FREE, i]
        for k in range(size):
            total += h * g[i, k] * table[WORK, k]
        table[AT_BASE, i] = total
    factor_lu(matrix, m.soft_order)
    solve_lu(matrix, m.soft_order, table[AT_BASE])
    for i in range(size):
        table[BASE, i] = table[WORK, i] + sloped(m, table[AT_BASE], i)


@compiled
def keep_free(m):
    """Keep accelerations and multipliers without these forces; rates at the end of a free step into FREE."""
    nb = m.acceleration.shape[0]
    for i in range(nb):
        for q in range(3):
            m.soft_free[3 * i + q] = m.acceleration[i, q]
    for row in range(m.multiplier.shape[0]):
        m.soft_free[3 * nb + row] = m.multiplier[row]


@compiled
def start_rates(m, h):
    """Rates of all rows at the start of the step, as in `body`, into U, and at the end of a free one into FREE."""
    table = m.soft_force
    for r in range(PER * m.soft.shape[0]):
        n = m.soft[r // PER]
        table[U, r] = rate_of(m, r, n, m.body, at.VX)
        table[FREE, r] = table[U, r] + h * rate_of(m, r, n, m.acceleration, 0)


@compiled
def add_base(m):
    """Accelerations and multipliers of the step without percussions."""
    nb, response, reaction, base = m.acceleration.shape[0], m.soft_response, m.soft_reaction, m.soft_force[BASE]
    for i in range(1, nb):
        for q in range(3):
            total = m.soft_free[3 * i + q]
            for r in range(response.shape[0]):
                total += response[r, 3 * i - 3 + q] * base[r]
            m.acceleration[i, q] = total
    for row in range(m.multiplier.shape[0]):
        total = m.soft_free[3 * nb + row]
        for r in range(response.shape[0]):
            total += reaction[r, row] * base[r]
        m.multiplier[row] = total


@compiled
def soften_responses(m, h, count):
    """Responses of the active contacts as these forces change them."""
    response, reaction, x = m.velocity_response, m.multiplier_response, m.soft_force[WORK]
    size = m.soft_matrix.shape[0]
    for c in range(2 * count):
        if c % 2 == 1 and friction_of(m, m.active[c // 2]) == 0.0:
            continue
        for i in range(size):
            x[i] = row_on(m, i, response, c)
        solve_lu(m.soft_matrix, m.soft_order, x)
        for i in range(size):
            share = h * sloped(m, x, i)
            for k in range(response.shape[1]):
                response[c, k] += share * m.soft_response[i, k]
            for row in range(reaction.shape[1]):
                reaction[c, row] += share * m.soft_reaction[i, row]


@compiled
def soften(m, h, count):
    """Responses of the active contacts and their G as these forces change them."""
    contact, active, w, response = m.contact, m.active, m.contact_jacobian, m.velocity_response
    soften_responses(m, h, count)
    for r in range(2 * count):
        n = active[r // 2]
        for c in range(2 * count):
            total = 0.0
            for end in range(2):
                i = contact[n, at.A_BODY + end]
                if i > 0:
                    for q in range(3):
                        total += w[r, 3 * end + q] * response[c, 3 * i - 3 + q]
            smooth = (r % 2 == 1 and friction_of(m, n) == 0.0) or (c % 2 == 1 and friction_of(m, active[c // 2]) == 0.0)
            m.delassus[r, c] = 0.0 if smooth else total


@native("f", "h", "f")
def settle(m, h):
    """Rates and forces at the end of the step with the response to the percussions in `velocity_change`.

    Returns by how much the law would change the rates, as a share of them; U moves there for the next round.
    """
    table, g, dv = m.soft_force, m.soft_delassus, m.velocity_change
    size, worst, scale = g.shape[0], 0.0, LEAST
    for r in range(size):
        n = m.soft[r // PER]
        table[NEW, r] = table[AT_BASE, r] - rate_of(m, r, n, dv, 0)
        table[WORK, r] = table[NEW, r] - table[U, r]
    for r in range(size):
        table[LINEAR, r] = table[PHI, r] + sloped(m, table[WORK], r)
    evaluate(m, h, NEW, TRUE)
    for r in range(size):
        off = 0.0
        for k in range(size):
            off += h * g[r, k] * (table[TRUE, k] - table[LINEAR, k])
        worst, scale = max(worst, abs(off)), max(scale, abs(table[NEW, r]), abs(table[FREE, r]))
    return worst / scale


@compiled
def go_to(m, share):
    """Move U by a share of the way to the rates just found."""
    table = m.soft_force
    for r in range(table.shape[1]):
        table[U, r] += share * (table[NEW, r] - table[U, r])


@compiled
def keep_forces(m, h, v, v_new, y):
    """Forces and powers of the step into `contact_kinematics`; impulses and what films lose into y.

    v, v_new: (3 nb,) rates at both ends of the step.
    """
    kinematics, contact, linear, j = m.contact_kinematics, m.contact, m.soft_force[LINEAR], m.soft_jacobian
    memory = m.contact_memory
    for s in range(m.soft.shape[0]):
        n, r = m.soft[s], PER * s
        for k in range(r, r + PER):  # the mean rate, with which they do work
            total = 0.0
            for end in range(2):
                i = contact[n, at.A_BODY + end]
                if i > 0:
                    for q in range(3):
                        total += j[k, 3 * end + q] * 0.5 * (v[3 * i - 3 + q] + v_new[3 * i - 3 + q])
            m.soft_force[WORK, k] = total
        mean = m.soft_force[WORK]
        kinematics[n, at.NORMAL], kinematics[n, at.TANGENT] = -linear[r], -linear[r + 1]
        account, depth = account_at(m, n), 0.5 * h * m.soft_force[NEW, r] - kinematics[n, at.GAP]
        taken, stored = -linear[r] * mean[r] - linear[r + 1] * mean[r + 1], 0.0
        if memory[n, at.CLOSED] == at.SHUT:
            stored = ((strain_energy(m, n, depth) if depth > 0.0 else 0.0) - y[account + STORED]) / h
        kinematics[n, at.STORE], kinematics[n, at.LOSS] = stored, taken - stored
        y[account + IMPULSE] -= h * linear[r]
        if contact[n, at.FILM_LAW] >= 0:
            fx, fy = linear[r + 2], linear[r + 3]
            half = 0.5 * (m.soft_place[s, 0] * fy - m.soft_place[s, 1] * fx)
            kinematics[n, at.FILM_X], kinematics[n, at.FILM_Y] = fx, fy
            kinematics[n, at.FILM_A] -= half
            kinematics[n, at.FILM_B] -= half
            lost = -fx * mean[r + 2] - fy * mean[r + 3]
            kinematics[n, at.FILM_LOSS] += lost
            y[energies_at(m) + DISSIPATED] += h * lost


@native("void", "h", "f", "f", "v")
def book(m, t, h, y):
    """Energy of compliant contacts over the step that ended at t [s], in the state y; those that are open again end."""
    kinematics, memory, soft = m.contact_kinematics, m.contact_memory, m.soft
    locate_contacts(m)
    for s in range(soft.shape[0]):
        n, account = soft[s], account_at(m, soft[s])
        if memory[n, at.CLOSED] == at.RELEASED and kinematics[n, at.NORMAL] > 0.0:
            shut(m, n, t - h, y)
            m.tally[at.CONTACTS] += 1
        released = memory[n, at.CLOSED] == at.RELEASED
        if memory[n, at.CLOSED] != at.SHUT and not released:
            continue
        depth = -kinematics[n, at.GAP]
        stored = 0.0
        if depth > 0.0:
            stored = float(y[account + STORED]) if released else strain_energy(m, n, depth)
        y[account + LOSS] += h * (kinematics[n, at.LOSS] + kinematics[n, at.STORE]) - stored + y[account + STORED]
        y[account + STORED] = stored
        if released:
            if depth <= 0.0:
                memory[n, at.CLOSED] = at.OPEN
            continue
        memory[n, at.PEAK] = max(memory[n, at.PEAK], kinematics[n, at.NORMAL])
        memory[n, at.STEPS_IN] += 1.0
        if depth <= 0.0:
            m.clock[at.FEWEST] = min(m.clock[at.FEWEST], memory[n, at.STEPS_IN])
            speed = kinematics[n, at.DGAP]
            early = min(-depth / speed, h) if speed > 0.0 else 0.0
            open_up(m, n, t - early, y)
        elif m.contact[n, at.BY_FORCE] == 1 and kinematics[n, at.NORMAL] <= 0.0 and kinematics[n, at.DGAP] > 0.0:
            spend(m, n, t, y)
