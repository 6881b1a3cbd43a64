"""Writing one output row; the columns are named in `recording`."""

from __future__ import annotations

from rattle.equations.motion import set_bristles, solve_motion
from rattle.jit.functions import compiled, native
from rattle.jit.layout import (
    B_BODY,
    BP,
    BX,
    BY,
    CORNER,
    COS,
    GAP,
    NORMAL,
    NU,
    NX,
    NY,
    OWNER,
    PBX,
    PBY,
    SIN,
    TANGENT,
    VX,
    X,
    Y,
)  # fmt: skip
from rattle.jit.workspace import (
    ACCELERATION,
    BODY,
    CHANGE,
    CONTACT,
    JOINT,
    MASS,
    MULTIPLIER,
    POWER,
    ROWS,
    SIGNAL,
    SIGNALS,
    TOUCH,
    VALUES,
    imat,
    mat,
    vec,
)  # fmt: skip


@native("void", "h", "f", "v", "v")
def record(m, t, y, row):
    """Write one output row for the state y; the columns are laid out in `recording`."""
    nq = vec(m, CHANGE).shape[0]
    set_bristles(m, y)
    solve_motion(m, t, y[:nq], y[nq : 2 * nq])
    lost = y[2 * nq + 1]
    for k in range(2 * nq + 2, y.shape[0], 4):
        lost += y[k + 2]
        vec(m, POWER)[0] += y[k + 3]
    write(m, y[2 * nq], lost, row)


@native("void", "h", "f", "f", "v")
def write(m, work_done, dissipated, row):
    """Copy what the memory holds at this instant into one output row."""
    body, signal, signals = mat(m, BODY), imat(m, SIGNAL), vec(m, SIGNALS)
    mass, acceleration, power = mat(m, MASS), mat(m, ACCELERATION), vec(m, POWER)
    c = 0
    kinetic = 0.0
    for i in range(1, body.shape[0]):
        for k in range(3):
            row[c + k] = body[i, X + k]
            row[c + 3 + k] = body[i, VX + k]
            row[c + 6 + k] = acceleration[i, k]
            kinetic += 0.5 * mass[i, k] * body[i, VX + k] ** 2
        c += 9
    c = write_joints(m, row, c)
    for n in range(signal.shape[0]):
        row[c] = signals[signal[n, 2]]
        c += 1
    row[c] = kinetic
    row[c + 1] = power[0]
    row[c + 2] = work_done
    row[c + 3] = dissipated


@native("i", "h", "v", "i")
def write_joints(m, row, first):
    """Forces, offsets and efforts of joints and drivers from column `first` on; returns the column behind them."""
    body, rows, values, joint, multiplier = (
        mat(m, BODY),
        mat(m, ROWS),
        vec(m, VALUES),
        imat(m, JOINT),
        vec(m, MULTIPLIER),
    )
    c = first
    for n in range(joint.shape[0]):
        a, b, p, r = joint[n, 1], joint[n, 2], joint[n, 3], joint[n, 4]
        end = joint[n + 1, 4] if n + 1 < joint.shape[0] else rows.shape[0]
        fx, fy, moment, effort_power = 0.0, 0.0, 0.0, 0.0
        for k in range(r, end):
            fx -= rows[k, BX] * multiplier[k]
            fy -= rows[k, BY] * multiplier[k]
            moment -= rows[k, BP] * multiplier[k]
            effort_power -= rows[k, NU] * multiplier[k]
        sax = body[a, COS] * values[p] - body[a, SIN] * values[p + 1]
        say = body[a, SIN] * values[p] + body[a, COS] * values[p + 1]
        sbx = body[b, COS] * values[p + 2] - body[b, SIN] * values[p + 3]
        sby = body[b, SIN] * values[p + 2] + body[b, COS] * values[p + 3]
        row[c] = fx
        row[c + 1] = fy
        row[c + 2] = moment - sbx * fy + sby * fx
        row[c + 3] = body[b, X] + sbx - body[a, X] - sax
        row[c + 4] = body[b, Y] + sby - body[a, Y] - say
        row[c + 5] = -multiplier[r] if end > r else 0.0
        row[c + 6] = effort_power
        row[c + 7] = 0.0
        c += 8
    write_contacts(m, row, first)
    return c


@compiled
def write_contacts(m, row, first):
    """Forces of all contacts on their joints' columns, which start at `first`."""
    contact, touch, joint, body, values = imat(m, CONTACT), mat(m, TOUCH), imat(m, JOINT), mat(m, BODY), vec(m, VALUES)
    for n in range(contact.shape[0]):
        c = first + 8 * contact[n, OWNER]
        b, p = contact[n, B_BODY], joint[contact[n, OWNER], 3]
        normal, tangent = touch[n, NORMAL], touch[n, TANGENT]
        fx = -normal * touch[n, NX] + tangent * touch[n, NY]
        fy = -normal * touch[n, NY] - tangent * touch[n, NX]
        sbx = body[b, COS] * values[p + 2] - body[b, SIN] * values[p + 3]
        sby = body[b, SIN] * values[p + 2] + body[b, COS] * values[p + 3]
        row[c] += fx
        row[c + 1] += fy
        row[c + 2] += (touch[n, PBX] - sbx) * fy - (touch[n, PBY] - sby) * fx
        row[c + 5] += normal
        row[c + 6] += tangent
        row[c + 7] = -touch[n, GAP] if contact[n, CORNER] == 0 else max(row[c + 7], -touch[n, GAP])
