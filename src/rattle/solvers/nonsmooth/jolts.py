"""Jolts: if the speed of a driver jumps, all rates jump.

    M (v+ - v-) = -Phi_q^T Lambda - W P,    Phi_q v+ = nu+
    0 <= g'+ (+ e g'-, e = 0),  0 <= P_N, complementary, and Coulomb's law for P_T, at closed set-valued contacts

Contacts closed at this instant rest on each other before the jolt or close by it: restitution is zero.  The work of
the drivers is -Lambda . (nu+ + nu-)/2; contacts lose P times the mean of their velocities before and after.

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 8; Haug, Computer Aided
Kinematics and Dynamics of Mechanical Systems (1989), section 6.6 (impulsive motion).
"""

from __future__ import annotations

from rattle.equations.complementarity import FORWARD, OFF, STICK, B, friction_of
from rattle.equations.compliant import locate_contacts
from rattle.equations.massless import take_out_of_change
from rattle.equations.motion import OK, constraints, correct, drive, place, rate_residual
from rattle.equations.schur import factorise
from rattle.equations.state import WORK, energies_at, take_travels
from rattle.equations.unilateral import (
    NOT_UNIQUE,
    add_forces,
    approach,
    contact_rows,
    count_solutions,
    ending,
    is_rough,
    shift,
    solve_contacts,
    velocity_scale,
)  # fmt: skip
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.clutches import takes_impulses
from rattle.solvers.nonsmooth.contact_projection import at_wall
from rattle.solvers.nonsmooth.impacts import book_impulses, rates_of_contacts
from rattle.solvers.nonsmooth.rubbing_impacts import forget_rubbing
from rattle.solvers.ports import add_port_work

ROUNDS = 2  # the second removes rounding


@compiled
def speeds(m, t, out):
    """nu of every row [m/s or rad/s] at t and the state y into out (nr,), on the present branches of switches."""
    y, nq, rows = m.state, m.change.shape[0], m.rows
    place(m, y[:nq], y[nq : 2 * nq])
    take_travels(m, y)
    drive(m, t)
    constraints(m)
    for r in range(rows.shape[0]):
        out[r] = rows[r, at.NU]


@native("i", "h", "f", "v", "v")
def jolt(m, t, before, percussion):
    """Let rates in y jump to those that the drivers require from t on; work is added, percussion (nr,) is Lambda.

    before: (nr,) nu just before t.  Units: Lambda [N s or N m s], nu [m/s or rad/s].  Returns OK, or why the contact
    problem has no solution.
    """
    y, rows, place_of, x = m.state, m.rows, m.place, m.solution
    change, old = m.change, m.rate_new
    nq = change.shape[0]
    q, v = y[:nq], y[nq : 2 * nq]
    for k in range(nq):
        old[k] = v[k]
    place(m, q, v)
    take_travels(m, y)
    drive(m, t)
    constraints(m)
    factorise(m)
    for r in range(rows.shape[0]):
        percussion[r] = 0.0
    for _ in range(ROUNDS):
        rate_residual(m)
        correct(m)
        if m.massless.shape[0] > 0:
            take_out_of_change(m)
        for r in range(rows.shape[0]):
            percussion[r] += x[place_of[r]]
        for k in range(nq):
            v[k] += change[k]
        place(m, q, v)
    status, count = OK, 0
    if m.mode.shape[0] > 0:
        status, count = with_contacts(m, t, y, old, percussion)
    work = 0.0
    for r in range(rows.shape[0]):
        work -= 0.5 * percussion[r] * (rows[r, at.NU] + before[r])
    y[energies_at(m) + WORK] += work
    if m.dry.shape[0] > 0:
        forget_rubbing(m)
    add_port_work(m, count, percussion, old, v)
    return status


@compiled
def with_contacts(m, t, y, old, percussion):
    """Impulses by which closed contacts prevent penetration in a jolt, in one problem; a status, and their number."""
    contact, kinematics, mode, memory = m.contact, m.contact_kinematics, m.mode, m.contact_memory
    active, candidate, slide, side = m.active, m.candidate, m.slide, m.side
    multiplier, nq = m.multiplier, m.change.shape[0]
    v = y[nq : 2 * nq]
    locate_contacts(m)
    count = 0
    for n in range(contact.shape[0]):
        touches = contact[n, at.IMPACT] == 1 and (mode[n] != OFF or at_wall(m, n))
        if touches and takes_impulses(m, n):
            active[count] = n
            count += 1
    if count == 0:
        return OK, 0
    contact_rows(m, count)
    for k in range(count):
        n = active[k]
        memory[n, at.BOUNCES_END], memory[n, at.STEPS_ON] = 0.0, 0.0
        memory[n, at.ROUNDING] = max(velocity_scale(m, 2 * k, n), velocity_scale(m, 2 * k + 1, n))
        side[B, 2 * k], side[B, 2 * k + 1] = approach(m, k, n), -kinematics[n, at.SLIP]
        slide[k] = 0
        candidate[k] = STICK if friction_of(m, n) > 0.0 else FORWARD
    if not solve_contacts(m, count):
        return ending(m), 0
    if is_rough(m, count) and count_solutions(m, count) > 1:
        return NOT_UNIQUE, 0
    shift(m, count, v, -1.0)
    for r in range(multiplier.shape[0]):
        multiplier[r] = 0.0
    add_forces(m, count, m.acceleration, multiplier)
    for r in range(multiplier.shape[0]):
        percussion[r] += multiplier[r]
    rates_of_contacts(m, y, count, old)
    book_impulses(m, t, y, count)
    return OK, count
