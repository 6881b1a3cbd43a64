"""Ports between elements and bodies: generalised forces at an instant, and the work of impulses.

    P_eb = Q_eb . v_b      power that element e gives to body b [W];  v_b = (x', y', phi'), Q about the mass centre
    W_eb = I_eb . (v_b- + v_b+)/2      the same of an impulse [J]; their sum over e is the jump of the kinetic energy

Elements are joints and drivers, with all contacts of a joint, and loads.  Gravity follows from masses and rates.
Source: Karnopp, Margolis, Rosenberg, System Dynamics (2012), chapter 9; docs/power.md.
"""

from __future__ import annotations

from rattle.equations.complementarity import F
from rattle.equations.motion import place
from rattle.jit import layout as at
from rattle.jit.families import call_load
from rattle.jit.functions import compiled, native
from rattle.jit.geometry import ends


@compiled
def first_port(m):
    """First column of ports in a row that has them: the width of other output rows."""
    bodies, joints, quantities = m.body.shape[0] - 1, m.joint.shape[0], m.state_rate.shape[0] + m.signal.shape[0]
    own = 0
    for n in range(m.contact.shape[0]):
        own += 1 if m.contact[n, at.OWN_COLUMN] >= 0 else 0
    return at.PER_BODY * bodies + at.PER_JOINT * joints + own + quantities + at.ENERGIES


@native("void", "h", "f", "v", "i")
def write_ports(m, t, row, first):
    """Write the ports of all elements at t [s] into an output row from column `first` on; see `layout.PER_PORT`.

    The motion at this instant has been solved; afterwards `force` and `energy` are those of the last load.
    """
    rows, joint, multiplier = m.rows, m.joint, m.multiplier
    c = first
    for n in range(joint.shape[0]):
        for k in range(at.PER_PORT):
            row[c + k] = 0.0
        end = joint[n + 1, at.FIRST_ROW] if n + 1 < joint.shape[0] else rows.shape[0]
        for r in range(joint[n, at.FIRST_ROW], end):
            for q in range(3):
                row[c + at.PORT_A + q] -= rows[r, at.AX + q] * multiplier[r]
                row[c + at.PORT_B + q] -= rows[r, at.BX + q] * multiplier[r]
            row[c + at.SUPPLIED] -= rows[r, at.NU] * multiplier[r]
        c += at.PER_PORT
    write_contact_ports(m, row, first)
    write_friction_ports(m, row, first)
    write_load_ports(m, t, row, c)


@compiled
def write_contact_ports(m, row, first):
    """Add forces, losses and storage of all contacts to the ports of their joints, from column `first` on."""
    contact, kinematics = m.contact, m.contact_kinematics
    for n in range(contact.shape[0]):
        c = first + at.PER_PORT * contact[n, at.OWNER]
        normal, tangent = kinematics[n, at.NORMAL], kinematics[n, at.TANGENT]
        fx = normal * kinematics[n, at.NX] - tangent * kinematics[n, at.NY]
        fy = normal * kinematics[n, at.NY] + tangent * kinematics[n, at.NX]
        couple = normal * kinematics[n, at.TURN]
        row[c + at.PORT_A] += fx
        row[c + at.PORT_A + 1] += fy
        row[c + at.PORT_A + 2] += kinematics[n, at.PAX] * fy - kinematics[n, at.PAY] * fx + couple
        row[c + at.PORT_B] -= fx
        row[c + at.PORT_B + 1] -= fy
        row[c + at.PORT_B + 2] -= kinematics[n, at.PBX] * fy - kinematics[n, at.PBY] * fx + couple
        if contact[n, at.FILM_LAW] >= 0:
            write_film_port(m, n, row, c)
        row[c + at.WASTED] += kinematics[n, at.LOSS]
        row[c + at.KEPT] += kinematics[n, at.STORE]


@compiled
def write_film_port(m, n, row, c):
    """Add force, moments and loss of the oil film of contact n to the port of its joint at column c."""
    contact, kinematics = m.contact, m.contact_kinematics
    fx, fy = kinematics[n, at.FILM_X], kinematics[n, at.FILM_Y]
    a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
    sax, say, sbx, sby, _, _, _, _ = ends(m.body, a, b, m.values, contact[n, at.SHAPE_P])
    row[c + at.PORT_A] -= fx
    row[c + at.PORT_A + 1] -= fy
    row[c + at.PORT_A + 2] += kinematics[n, at.FILM_A] - (sax * fy - say * fx)
    row[c + at.PORT_B] += fx
    row[c + at.PORT_B + 1] += fy
    row[c + at.PORT_B + 2] += kinematics[n, at.FILM_B] + (sbx * fy - sby * fx)
    row[c + at.WASTED] += kinematics[n, at.FILM_LOSS]


@compiled
def write_friction_ports(m, row, first):
    """Add dry friction of joints without play, and what it loses, to the ports of these joints from `first` on."""
    dry, line, memory = m.dry, m.dry_rows, m.dry_memory
    for n in range(dry.shape[0]):
        c, tau = first + at.PER_PORT * dry[n, at.DRY_JOINT], memory[n, at.DRY_FORCE]
        for q in range(3):
            row[c + at.PORT_A + q] += line[n, at.AX + q] * tau
            row[c + at.PORT_B + q] += line[n, at.BX + q] * tau
        row[c + at.WASTED] -= tau * memory[n, at.DRY_RATE]


@compiled
def write_load_ports(m, t, row, first):
    """Write the ports of all loads at t [s] from column `first` on; `values` are those of this instant."""
    body, load, force, energy, values, table = m.body, m.load, m.force, m.energy, m.values, m.load_table
    c = first
    for n in range(load.shape[0]):
        a, b = load[n, at.END_A], load[n, at.END_B]
        for q in range(3):
            force[a, q], force[b, q] = 0.0, 0.0
        for k in range(4):
            energy[k] = 0.0
        call_load(table[load[n, at.KERNEL]], (t, body, a, b, values, load[n, at.FIRST_P], force, energy))
        for q in range(3):
            row[c + at.PORT_A + q] = force[a, q] if a != b else 0.0
            row[c + at.PORT_B + q] = force[b, q]
        row[c + at.SUPPLIED], row[c + at.WASTED] = energy[at.OUTSIDE], energy[at.DISSIPATED]
        row[c + at.KEPT] = 0.0
        if load[n, at.CHANGES] == 0:
            row[c + at.KEPT] = -energy[at.ELASTIC]
        else:  # its values change with time: what it stores is not a function of position alone
            row[c + at.SUPPLIED] += energy[at.ELASTIC]
        c += at.PER_PORT


@compiled
def mean_rate(before, after, i, q):
    """Mean of the rates (3 nb,) before and after an impulse; body i, q = 0, 1, 2 for x, y, angle."""
    return 0.5 * (before[3 * i - 3 + q] + after[3 * i - 3 + q]) if i > 0 else 0.0


@compiled
def add_port_work(m, count, impulse, before, after):
    """Add the work [J] of an impulse to `port_work`, if powers are asked for.

    impulse: (nr,) of the rows of joints and drivers [N s, N m s]; those of the `count` active contacts are in `side`.
    before, after: (3 nb,) rates [m/s, rad/s].  Rows and `contact_jacobian` are those of this position.
    """
    work, joint, rows = m.port_work, m.joint, m.rows
    if work.shape[0] == 0:
        return
    for n in range(joint.shape[0]):
        a, b = joint[n, at.END_A], joint[n, at.END_B]
        work[n, at.A_NOW], work[n, at.B_NOW] = 0.0, 0.0
        end = joint[n + 1, at.FIRST_ROW] if n + 1 < joint.shape[0] else rows.shape[0]
        for r in range(joint[n, at.FIRST_ROW], end):
            for q in range(3):
                work[n, at.A_NOW] -= rows[r, at.AX + q] * impulse[r] * mean_rate(before, after, a, q)
                work[n, at.B_NOW] -= rows[r, at.BX + q] * impulse[r] * mean_rate(before, after, b, q)
    if count > 0:
        add_contact_work(m, count, before, after)
        add_friction_work(m, before, after)
    for n in range(joint.shape[0]):
        work[n, at.A_IN] += max(work[n, at.A_NOW], 0.0)
        work[n, at.A_OUT] += max(-work[n, at.A_NOW], 0.0)
        work[n, at.B_IN] += max(work[n, at.B_NOW], 0.0)
        work[n, at.B_OUT] += max(-work[n, at.B_NOW], 0.0)


@compiled
def add_contact_work(m, count, before, after):
    """Add the work [J] of the impulses of the `count` active contacts to the present one of their joints."""
    work, contact, active, side, w = m.port_work, m.contact, m.active, m.side, m.contact_jacobian
    for k in range(2 * count):
        i = active[k // 2]
        n, a, b = contact[i, at.OWNER], contact[i, at.A_BODY], contact[i, at.B_BODY]
        for q in range(3):
            work[n, at.A_NOW] -= w[k, q] * side[F, k] * mean_rate(before, after, a, q)
            work[n, at.B_NOW] -= w[k, 3 + q] * side[F, k] * mean_rate(before, after, b, q)


@compiled
def add_friction_work(m, before, after):
    """Add the work [J] of the impulses of friction in joints without play to the present one of these joints."""
    work, dry, line, memory = m.port_work, m.dry, m.dry_rows, m.dry_memory
    for i in range(dry.shape[0]):
        n, impulse = dry[i, at.DRY_JOINT], memory[i, at.IMPACT_FRICTION]
        for q in range(3):
            work[n, at.A_NOW] += line[i, at.AX + q] * impulse * mean_rate(before, after, dry[i, at.DRY_A], q)
            work[n, at.B_NOW] += line[i, at.BX + q] * impulse * mean_rate(before, after, dry[i, at.DRY_B], q)


# ---------------------------------------------------------------- time stepping
@compiled
def keep_ports(m, t, h):
    """Ports of a step of time stepping into `port_row`, if powers are asked for: forces of the step, mean rates.

    `state_new` holds positions of the middle and rates after the impulses of the step from t of length h [s], `rate`
    the accelerations with which the rates of the middle were found; rows and contacts are those of the middle.
    """
    row, y, y_new, stage, rate = m.port_row, m.state, m.state_new, m.stage, m.rate
    if row.shape[0] == 0:
        return
    nq = m.change.shape[0]
    for c in range(nq):
        stage[nq + c] = y[nq + c] + 0.5 * h * rate[c]
    place(m, y_new[:nq], stage[nq : 2 * nq])
    write_ports(m, t + 0.5 * h, row, first_port(m))
    for c in range(nq):
        k = at.PER_BODY * (c // 3) + c % 3
        row[k + at.PLACE] = y_new[c]
        row[k + at.RATE] = 0.5 * (y[nq + c] + y_new[nq + c])
        row[k + at.RATE_RATE] = (y_new[nq + c] - y[nq + c]) / h


@compiled
def show_ports(m, row):
    """Replace an output row by that with the ports of its step, if powers are asked for."""
    for c in range(m.port_row.shape[0]):
        row[c] = m.port_row[c]
