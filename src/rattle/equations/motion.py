"""The equations of motion at one instant: M, Q, Phi, Phi_q, nu, gamma, lambda, accelerations.

    M dv + Phi_q^T lambda = Q,     Phi_q dv = gamma        (docs/theory.md, section 3)
    S lambda = Phi_q M^-1 Q - gamma,     S = Phi_q M^-1 Phi_q^T

Kernels of joints, drivers and loads are called here only, by address; no kind is named.  All values in SI units.
"""

from __future__ import annotations

import math

from rattle.equations.compliant import add_contact_forces, locate_contacts, locate_near
from rattle.equations.dry_friction import add_dry_friction, end_dry_friction
from rattle.equations.massless import take_out
from rattle.equations.schur import WEAK, factorise, solve
from rattle.equations.state import (
    DISSIPATED,
    IMPULSE,
    LOSS,
    STORED,
    WORK,
    account_at,
    energies_at,
    states_at,
    take_states,
)
from rattle.equations.travel import travel_to
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.choices import select, usually
from rattle.jit.families import call_closed_contacts, call_joint, call_load
from rattle.jit.functions import compiled, native
from rattle.language.bytecode import evaluate
from rattle.language.jets import evaluate_jet

OK, NOT_CLOSED, NOT_FINITE, STEP_TOO_SMALL, PAUSED, DONE = range(6)


@compiled
def place(m, q, v):
    """Copy positions q [m, rad] and rates v [m/s, rad/s] (3 nb each) into `body`, with cosine and sine of angles."""
    body = m.body
    for i in range(1, body.shape[0]):
        k = 3 * i - 3
        body[i, at.X] = q[k]
        body[i, at.Y] = q[k + 1]
        body[i, at.PHI] = q[k + 2]
        body[i, at.VX] = v[k]
        body[i, at.VY] = v[k + 1]
        body[i, at.W] = v[k + 2]
        body[i, at.COS] = math.cos(q[k + 2])
        body[i, at.SIN] = math.sin(q[k + 2])


@native("void", "h", "f")
def drive(m, t):
    """Functions of time t [s]: value and exact first and second derivative of every driver [m or rad, s]."""
    jet_signal, jet, out = m.jet_signal, m.jet, m.jet_out
    code, const, jets, stack, values = m.code, m.const, m.jets, m.jet_stack, m.values
    if m.travelled.shape[0] > 0 and m.travelled[0] == m.travelled[0]:
        travel_to(m, t)
    for n in range(jet_signal.shape[0]):
        evaluate_jet(code, const, jet_signal[n, at.FIRST_CODE], jet_signal[n, at.END_CODE], t, jets, stack, out)
        k = jet_signal[n, at.TARGET]
        jets[k, 0], jets[k, 1], jets[k, 2] = out[0], out[1], out[2]
    for n in range(jet.shape[0]):
        evaluate_jet(code, const, jet[n, at.FIRST_CODE], jet[n, at.END_CODE], t, jets, stack, out)
        k, state = jet[n, at.TARGET], jet[n, at.TRAVEL]
        if state < 0:
            values[k], values[k + 1], values[k + 2] = out[0], out[1], out[2]
        else:
            values[k], values[k + 1], values[k + 2] = m.signals[state], out[0], out[1]


@compiled
def constraints(m):
    """Residual [m or rad], nu, gamma [per s, s^2] and Jacobian of every constraint row at the state in `body`."""
    table, joint, body, values, rows = m.joint_table, m.joint, m.body, m.values, m.rows
    for n in range(joint.shape[0]):
        if joint[n, at.KERNEL] < 0:  # only contacts act on this joint
            continue
        a, b, p = joint[n, at.END_A], joint[n, at.END_B], joint[n, at.FIRST_P]
        call_joint(table[joint[n, at.KERNEL]], (body, a, b, values, p, joint[n, at.FIRST_ROW], rows))


@native("void", "h", "f")
def loads(m, t):
    """Applied forces Q [N, N m], potential energy [J], work rate and dissipation [W] at the state in `body`, and rates.

    The rates are those of the states of elements and of the model, which are at hand: see `equations.state`.
    """
    force, body, energy, power = m.force, m.body, m.energy, m.power
    mass, gravity, load, table, values = (
        m.mass,
        m.gravity,
        m.load,
        m.load_table,
        m.values,
    )
    signal, live, signals = m.signal, m.live, m.signals
    code, const, stack = m.code, m.const, m.stack
    potential, rate, lost = 0.0, 0.0, 0.0
    for n in range(signal.shape[0]):
        signals[signal[n, at.TARGET]] = evaluate(
            code, const, signal[n, at.FIRST_CODE], signal[n, at.END_CODE], t, body, signals, stack
        )
    for n in range(live.shape[0]):
        values[live[n, at.TARGET]] = evaluate(
            code, const, live[n, at.FIRST_CODE], live[n, at.END_CODE], t, body, signals, stack
        )
    state_rate, element_rate = m.state_rate, m.element_rate
    for n in range(state_rate.shape[0]):
        element_rate[state_rate[n, at.TARGET]] = evaluate(
            code, const, state_rate[n, at.FIRST_CODE], state_rate[n, at.END_CODE], t, body, signals, stack
        )
    gx, gy = gravity[0], gravity[1]
    if m.falling.shape[0] > 0:
        fall(m, t)
        k, n = m.falling[0, at.TARGET], m.falling[1, at.TARGET]
        gx, gy = values[k], values[n]
        for i in range(body.shape[0]):
            rate -= mass[i, 0] * (values[k + 1] * body[i, at.X] + values[n + 1] * body[i, at.Y])
    for i in range(body.shape[0]):
        force[i, 0] = mass[i, 0] * gx
        force[i, 1] = mass[i, 0] * gy
        force[i, 2] = 0.0
        potential -= mass[i, 0] * (gx * body[i, at.X] + gy * body[i, at.Y])
    for n in range(load.shape[0]):
        for k in range(4):
            energy[k] = 0.0
        a, b, p = load[n, at.END_A], load[n, at.END_B], load[n, at.FIRST_P]
        call_load(table[load[n, at.KERNEL]], (t, body, a, b, values, p, force, energy))
        rate += energy[at.OUTSIDE]
        lost += energy[at.DISSIPATED]
        if load[n, at.CHANGES] == 0:
            potential += energy[at.POTENTIAL]
        else:  # its values change with time: the stored energy is not a function of position alone
            rate += energy[at.ELASTIC]
    power[at.POTENTIAL_ENERGY], power[at.WORK_RATE], power[at.LOSS_RATE] = potential, rate, lost
    if m.contact.shape[0] > 0:
        if m.power[at.CULLS] == 1.0:
            locate_near(m)
        else:
            locate_contacts(m)
        add_contact_forces(m)


@native("void", "h", "f")
def fall(m, t):
    """Gravity at t [s], a function of time, and its rates."""
    falling, values, out = m.falling, m.values, m.jet_out
    for n in range(falling.shape[0]):
        first, last, k = falling[n, at.FIRST_CODE], falling[n, at.END_CODE], falling[n, at.TARGET]
        evaluate_jet(m.code, m.const, first, last, t, m.jets, m.jet_stack, out)
        values[k], values[k + 1], values[k + 2] = out[0], out[1], out[2]


@compiled
def potential_of_fall(m, t, y):
    """Potential energy [J] in gravity that is a function of time, at the state y and t [s]."""
    fall(m, t)
    energy = 0.0
    for i in range(1, m.body.shape[0]):
        for n in range(2):
            energy -= m.mass[i, 0] * m.values[m.falling[n, at.TARGET]] * y[3 * i - 3 + n]
    return energy


@compiled
def correct(m):
    """change = -M^-1 Phi_q^T S^-1 r [m, rad, or per s]: the least mass-weighted change that removes a residual r.

    On entry the right-hand side holds r, from `residual` or `rate_residual`, and S is factored.
    """
    solve(m)
    change, rows, weight, x = m.change, m.rows, m.weight, m.solution
    place_of, row_body = m.place, m.row_body
    for k in range(change.shape[0]):
        change[k] = 0.0
    for r in range(rows.shape[0]):
        force = x[place_of[r]]
        a, b = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
        if a > 0:
            for k in range(3):
                change[3 * a - 3 + k] -= weight[a, k] * rows[r, at.AX + k] * force
        if b > 0:
            for k in range(3):
                change[3 * b - 3 + k] -= weight[b, k] * rows[r, at.BX + k] * force


@compiled
def residual(m):
    """Write the position residuals to the right-hand side; returns the largest [m or rad]."""
    rows, x, place_of = m.rows, m.solution, m.place
    largest = 0.0
    for r in range(rows.shape[0]):
        value = rows[r, at.RES]
        x[place_of[r]] = value
        largest = select(abs(value) <= largest, largest, abs(value))  # nan stays
    return largest


@compiled
def rate_residual(m):
    """Write Phi_q v - nu to the right-hand side; returns the largest [m/s or rad/s]."""
    rows, body, x = m.rows, m.body, m.solution
    place_of, row_body = m.place, m.row_body
    largest = 0.0
    for r in range(rows.shape[0]):
        a, b = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
        value = -rows[r, at.NU]
        for k in range(3):
            value += rows[r, at.AX + k] * body[a, at.VX + k] + rows[r, at.BX + k] * body[b, at.VX + k]
        x[place_of[r]] = value
        largest = select(abs(value) <= largest, largest, abs(value))
    return largest


@native("void", "h")
def accelerate(m):
    """Multipliers [N, N m] and accelerations [m/s^2, rad/s^2] from rows, factor and forces in the workspace."""
    rows, force, weight, x = m.rows, m.force, m.weight, m.solution
    acceleration, multiplier = m.acceleration, m.multiplier
    place_of, row_body = m.place, m.row_body
    for i in range(acceleration.shape[0]):
        for k in range(3):
            acceleration[i, k] = weight[i, k] * force[i, k]
    for r in range(rows.shape[0]):
        multiplier[r] = 0.0
    rounds = 1 if usually(m.power[at.PIVOT_SHARE] > WEAK) else 3  # near a singular position the solution is refined
    for _ in range(rounds):
        for r in range(rows.shape[0]):
            a, b = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
            x[place_of[r]] = (
                rows[r, at.AX] * acceleration[a, 0]
                + rows[r, at.AX + 1] * acceleration[a, 1]
                + rows[r, at.AX + 2] * acceleration[a, 2]
                + rows[r, at.BX] * acceleration[b, 0]
                + rows[r, at.BX + 1] * acceleration[b, 1]
                + rows[r, at.BX + 2] * acceleration[b, 2]
                - rows[r, at.GAMMA]
            )
        solve(m)
        for r in range(rows.shape[0]):
            value = x[place_of[r]]
            multiplier[r] += value
            a, b = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
            for k in range(3):
                acceleration[a, k] -= weight[a, k] * rows[r, at.AX + k] * value
                acceleration[b, k] -= weight[b, k] * rows[r, at.BX + k] * value
    if m.massless.shape[0] > 0:
        take_out(m)


@compiled
def move_freely(m, t, q, v):
    """The same as `free_motion`, compiled into each caller."""
    place(m, q, v)
    drive(m, t)
    constraints(m)
    loads(m, t)
    lost = factorise(m)
    accelerate(m)
    if m.dry.shape[0] > 0:
        add_dry_friction(m)
    return lost


@native("i", "h", "f", "v", "v")
def free_motion(m, t, q, v):
    """The equations at (t, q, v) without the forces of closed contacts. Returns the number of redundant rows."""
    return move_freely(m, t, q, v)


@compiled
def move(m, t, q, v):
    """The same as `solve_motion`, compiled into each caller."""
    lost = move_freely(m, t, q, v)
    closed = m.closed_contacts_table
    if len(closed) > 0:  # closed set-valued contacts
        call_closed_contacts(closed[0], (m,))
    if m.dry.shape[0] > 0:
        end_dry_friction(m)
    return lost


@native("i", "h", "f", "v", "v")
def solve_motion(m, t, q, v):
    """The equations at (t, q, v): rows, forces and multipliers [N, N m], accelerations [m/s^2, rad/s^2].

    Returns the number of redundant rows.
    """
    return move(m, t, q, v)


@compiled
def collect(m, v, dy):
    """dy/dt of y (layout: `equations.state`) from the solution in the workspace; v: (3 nb,) [m/s, rad/s]."""
    rows, multiplier, acceleration, power = m.rows, m.multiplier, m.acceleration, m.power
    kinematics = m.contact_kinematics
    nq = v.shape[0]
    rate = power[at.WORK_RATE]
    for r in range(rows.shape[0]):
        rate -= multiplier[r] * rows[r, at.NU]
    for k in range(nq):
        dy[k] = v[k]
    for i in range(1, acceleration.shape[0]):
        for k in range(3):
            dy[nq + 3 * i - 3 + k] = acceleration[i, k]
    dy[energies_at(m) + WORK] = rate
    dy[energies_at(m) + DISSIPATED] = power[at.LOSS_RATE]
    for n in range(kinematics.shape[0]):
        k = account_at(m, n)
        dy[k + IMPULSE] = kinematics[n, at.NORMAL]
        dy[k + LOSS] = kinematics[n, at.LOSS]
        dy[k + STORED] = kinematics[n, at.STORE]
    rates, first = m.element_rate, states_at(m)
    for k in range(rates.shape[0]):
        dy[first + k] = rates[k]


@native("i", "h", "f", "v", "v")
def derivative(m, t, y, dy):
    """dy/dt of y at t [s], see `equations.state`. Returns the number of redundant rows."""
    nq = m.change.shape[0]
    take_states(m, y)
    lost = move(m, t, y[:nq], y[nq : 2 * nq])
    collect(m, y[nq : 2 * nq], dy)
    return lost
