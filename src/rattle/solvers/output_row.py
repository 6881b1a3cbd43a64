"""Writing one output row, in SI units; its columns are declared in `jit.layout`."""

from __future__ import annotations

from rattle.equations.motion import solve_motion
from rattle.equations.state import DISSIPATED, LOSS, STORED, WORK, account_at, energies_at, take_states
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.choices import select
from rattle.jit.functions import compiled, native
from rattle.jit.geometry import ends, turn_x, turn_y
from rattle.solvers.ports import first_port, write_ports


@native("void", "h", "f", "v", "v")
def record(m, t, y, row):
    """Write one output row for the state y at t [s]."""
    nq = m.change.shape[0]
    take_states(m, y)
    solve_motion(m, t, y[:nq], y[nq : 2 * nq])
    energies = energies_at(m)
    lost = y[energies + DISSIPATED]
    for n in range(m.contact.shape[0]):
        lost += y[account_at(m, n) + LOSS]
        m.power[at.POTENTIAL_ENERGY] += y[account_at(m, n) + STORED]
    write(m, y[energies + WORK], lost, row)
    first = first_port(m)
    if row.shape[0] > first:
        write_ports(m, t, row, first)


@native("void", "h", "f", "f", "v")
def write(m, work_done, dissipated, row):
    """Copy the values of this instant from the workspace into one output row; work and dissipated energy [J]."""
    body, signals = m.body, m.signals
    mass, acceleration, power = m.mass, m.acceleration, m.power
    c = 0
    kinetic = 0.0
    for i in range(1, body.shape[0]):
        for k in range(3):
            row[c + at.PLACE + k] = body[i, at.X + k]
            row[c + at.RATE + k] = body[i, at.VX + k]
            row[c + at.RATE_RATE + k] = acceleration[i, k]
            kinetic += 0.5 * mass[i, k] * body[i, at.VX + k] ** 2
        c += at.PER_BODY
    c = write_joints(m, row, c)
    c = write_own(m, row, c)
    for n in range(m.state_rate.shape[0] + m.signal.shape[0]):
        row[c] = signals[n]
        c += 1
    row[c + at.KINETIC] = kinetic
    row[c + at.STORED] = power[at.POTENTIAL_ENERGY]
    row[c + at.WORK] = work_done
    row[c + at.LOST] = dissipated


@native("i", "h", "v", "i")
def write_joints(m, row, first):
    """Forces, offsets and efforts of joints and drivers from column `first` on; returns the next free column."""
    body, rows, values, joint, multiplier = (
        m.body,
        m.rows,
        m.values,
        m.joint,
        m.multiplier,
    )
    c = first
    for n in range(joint.shape[0]):
        a, b, p, r = joint[n, at.END_A], joint[n, at.END_B], joint[n, at.FIRST_P], joint[n, at.FIRST_ROW]
        end = joint[n + 1, at.FIRST_ROW] if n + 1 < joint.shape[0] else rows.shape[0]
        fx, fy, moment, effort_power = 0.0, 0.0, 0.0, 0.0
        for k in range(r, end):
            fx -= rows[k, at.BX] * multiplier[k]
            fy -= rows[k, at.BY] * multiplier[k]
            moment -= rows[k, at.BP] * multiplier[k]
            effort_power -= rows[k, at.NU] * multiplier[k]
        _, _, sbx, sby, dx, dy, _, _ = ends(body, a, b, values, p)
        row[c + at.FX] = fx
        row[c + at.FY] = fy
        row[c + at.MOMENT] = moment - sbx * fy + sby * fx
        row[c + at.EX], row[c + at.EY] = dx, dy
        row[c + at.EFFORT] = -multiplier[r] if end > r else 0.0
        row[c + at.POWER] = effort_power
        row[c + at.JOINT_NORMAL] = -multiplier[r] if end > r else 0.0
        row[c + at.JOINT_TANGENT] = -multiplier[r + 1] if end > r + 1 else 0.0
        row[c + at.PENETRATION] = 0.0
        row[c + at.STOP] = 0.0
        c += at.PER_JOINT
    write_contacts(m, row, first)
    write_friction(m, row, first)
    return c


@compiled
def write_own(m, row, first):
    """N of contacts that have a column of their own, from column `first` on; returns the next free column."""
    contact, c = m.contact, first
    for n in range(contact.shape[0]):
        if contact[n, at.OWN_COLUMN] >= 0:
            row[c] = m.contact_kinematics[n, at.NORMAL]
            c += 1
    return c


@compiled
def write_friction(m, row, first):
    """Add the friction of joints without play [N, N m] to the columns of their joints, which start at `first`."""
    dry, line, joint, body, values = m.dry, m.dry_rows, m.joint, m.body, m.values
    for n in range(dry.shape[0]):
        c, b = first + at.PER_JOINT * dry[n, at.DRY_JOINT], dry[n, at.DRY_B]
        p, tau = joint[dry[n, at.DRY_JOINT], at.FIRST_P], m.dry_memory[n, at.DRY_FORCE]
        fx, fy = line[n, at.BX] * tau, line[n, at.BY] * tau
        sbx, sby = turn_x(body, b, values[p + 2], values[p + 3]), turn_y(body, b, values[p + 2], values[p + 3])
        row[c + at.FX] += fx
        row[c + at.FY] += fy
        row[c + at.MOMENT] += line[n, at.BP] * tau - sbx * fy + sby * fx
        row[c + dry[n, at.DRY_COLUMN]] = tau


@compiled
def write_contacts(m, row, first):
    """Add the forces of all contacts [N, N m] to the columns of their joints, which start at `first`."""
    contact, kinematics, joint, body, values = m.contact, m.contact_kinematics, m.joint, m.body, m.values
    for n in range(contact.shape[0]):
        c = first + at.PER_JOINT * contact[n, at.OWNER]
        b, p = contact[n, at.B_BODY], joint[contact[n, at.OWNER], at.FIRST_P]
        normal, tangent = kinematics[n, at.NORMAL], kinematics[n, at.TANGENT]
        if contact[n, at.VANISHES] == 1:  # at its end by rounding
            normal = max(0.0, normal)
        fx = -normal * kinematics[n, at.NX] + tangent * kinematics[n, at.NY]
        fy = -normal * kinematics[n, at.NY] - tangent * kinematics[n, at.NX]
        sbx, sby = turn_x(body, b, values[p + 2], values[p + 3]), turn_y(body, b, values[p + 2], values[p + 3])
        row[c + at.FX] += fx
        row[c + at.FY] += fy
        row[c + at.MOMENT] += (kinematics[n, at.PBX] - sbx) * fy - (kinematics[n, at.PBY] - sby) * fx
        row[c + at.MOMENT] -= normal * kinematics[n, at.TURN]
        if contact[n, at.FILM_LAW] >= 0:
            row[c + at.FX] += kinematics[n, at.FILM_X]
            row[c + at.FY] += kinematics[n, at.FILM_Y]
            row[c + at.MOMENT] += kinematics[n, at.FILM_B]
        column = contact[n, at.FORCE_COLUMN]
        row[c + column] += contact[n, at.SENSE] * normal
        if column == at.EFFORT:  # of a joint that is nothing but this contact
            closed = m.contact_memory[n, at.CLOSED]
            presses, shut = select(normal > 0.0, 1.0, 0.0), select(closed == at.SHUT, 1.0, 0.0)
            row[c + at.JOINT_TANGENT] = select(closed == at.AUTO, presses, shut)
        if column != at.JOINT_NORMAL:
            continue
        row[c + at.JOINT_TANGENT] += tangent
        depth = -kinematics[n, at.GAP]
        alone = n == 0 or contact[n - 1, at.OWNER] != contact[n, at.OWNER]
        row[c + at.PENETRATION] = depth if alone else max(row[c + at.PENETRATION], depth)
