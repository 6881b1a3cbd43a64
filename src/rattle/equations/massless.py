"""Bodies without mass or inertia: the equations are solved with one, which is taken out again exactly.

A coordinate p . q without inertia is given a fictitious one, e, so that M + P e P^T has an inverse.  The force f that
makes up for it, f = e p . dv, follows from the responses of the mechanism with fictitious inertia to unit forces along
these coordinates,

    Z = S^-1 Phi_q M^-1 P,   Y = M^-1 (P - Phi_q^T Z),      lambda = lambda_0 + Z f,   dv = dv_0 + Y f,

    (1/e - P^T Y) f = P^T dv_0

The matrix is positive definite where the joints determine the motion of these bodies, that is where no motion that
they allow moves massless coordinates only; the result does not depend on e.  A change of rates is treated alike.

Source: the matrix inversion lemma, Hager, SIAM Review 31 (1989) 221-239.
"""

from __future__ import annotations

import math

from rattle.equations.schur import solve
from rattle.jit import layout as at
from rattle.jit.choices import assume
from rattle.jit.functions import compiled, native

HELD = 1e-9  # share of its diagonal below which a pivot says that nothing holds a massless coordinate


@compiled
def respond(m, n):
    """Responses of accelerations and multipliers to a unit force along massless coordinate n; S is factored."""
    rows, weight, x, massless = m.rows, m.weight, m.solution, m.massless
    response, reaction, place_of, row_body = m.massless_response, m.massless_reaction, m.place, m.row_body
    i, k = massless[n, 0], massless[n, 1]
    for c in range(response.shape[1]):
        response[n, c] = 0.0
    response[n, 3 * i + k] = weight[i, k]
    for r in range(rows.shape[0]):
        value = 0.0
        if row_body[r, at.ROW_A] == i:
            value += rows[r, at.AX + k] * weight[i, k]
        if row_body[r, at.ROW_B] == i:
            value += rows[r, at.BX + k] * weight[i, k]
        x[place_of[r]] = value
    solve(m)
    for r in range(rows.shape[0]):
        value = x[place_of[r]]
        reaction[n, r] = value
        a, b = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
        for c in range(3):
            response[n, 3 * a + c] -= weight[a, c] * rows[r, at.AX + c] * value
            response[n, 3 * b + c] -= weight[b, c] * rows[r, at.BX + c] * value


@native("void", "h")
def prepare(m):
    """Responses to unit forces along all massless coordinates, and 1/e - P^T Y factored; S is factored.

    A pivot becomes nan where nothing holds its coordinate.
    """
    massless, response, system = m.massless, m.massless_response, m.massless_system
    count = massless.shape[0]
    for n in range(count):
        respond(m, n)
    for n in range(count):
        i, k = massless[n, 0], massless[n, 1]
        for o in range(n + 1):
            system[n, o] = -response[o, 3 * i + k]
        system[n, n] += m.weight[i, k]
    for n in range(count):  # L D L^T, D on the diagonal
        i, k = massless[n, 0], massless[n, 1]
        for o in range(n):
            share = system[n, o]
            for c in range(o):
                share -= system[n, c] * system[o, c] * system[c, c]
            system[n, o] = share / system[o, o]
        for c in range(n):
            system[n, n] -= system[n, c] * system[n, c] * system[c, c]
        if not assume(system[n, n] > HELD * m.weight[i, k]):
            system[n, n] = math.nan


@compiled
def find_forces(m):
    """f of all massless coordinates in `massless_force`, which holds P^T dv_0 on entry; needs `prepare`."""
    system, force = m.massless_system, m.massless_force
    count = force.shape[0]
    for n in range(count):
        for o in range(n):
            force[n] -= system[n, o] * force[o]
    for n in range(count):
        force[n] /= system[n, n]
    for n in range(count - 1, -1, -1):
        for o in range(n + 1, count):
            force[n] -= system[o, n] * force[o]


@native("void", "h")
def take_out(m):
    """Accelerations and multipliers without the fictitious inertia."""
    massless, response, reaction, force = m.massless, m.massless_response, m.massless_reaction, m.massless_force
    acceleration, multiplier = m.acceleration, m.multiplier
    for n in range(massless.shape[0]):
        force[n] = acceleration[massless[n, 0], massless[n, 1]]
    prepare(m)
    find_forces(m)
    for n in range(massless.shape[0]):
        for i in range(1, acceleration.shape[0]):
            for k in range(3):
                acceleration[i, k] += response[n, 3 * i + k] * force[n]
        for r in range(multiplier.shape[0]):
            multiplier[r] += reaction[n, r] * force[n]


@compiled
def take_out_of_change(m):
    """The change of rates that `motion.correct` has found, and the impulses in `solution`, without that inertia.

    It stays as it is where nothing holds a massless coordinate.
    """
    massless, response, reaction, force = m.massless, m.massless_response, m.massless_reaction, m.massless_force
    change, x, place_of, before = m.change, m.solution, m.place, m.massless_impulse
    for r in range(before.shape[0]):
        before[r] = x[place_of[r]]
    for n in range(massless.shape[0]):
        force[n] = change[3 * massless[n, 0] - 3 + massless[n, 1]]
    prepare(m)
    find_forces(m)
    for r in range(before.shape[0]):
        x[place_of[r]] = before[r]
    for n in range(massless.shape[0]):
        if not abs(force[n]) < math.inf:
            return
    for n in range(massless.shape[0]):
        for c in range(change.shape[0]):
            change[c] += response[n, 3 + c] * force[n]
        for r in range(before.shape[0]):
            x[place_of[r]] += reaction[n, r] * force[n]


@compiled
def take_out_of_response(m, responses, first, reactions, n):
    """Row n of responses, in which x of the first body stands in column `first`, and of reactions, to some unit force.

    Needs `prepare` at these positions.
    """
    massless, response, reaction, force = m.massless, m.massless_response, m.massless_reaction, m.massless_force
    for o in range(massless.shape[0]):
        force[o] = responses[n, first + 3 * massless[o, 0] - 3 + massless[o, 1]]
    find_forces(m)
    for o in range(massless.shape[0]):
        for c in range(first, responses.shape[1]):
            responses[n, c] += response[o, 3 + c - first] * force[o]
        for r in range(reactions.shape[1]):
            reactions[n, r] += reaction[o, r] * force[o]
