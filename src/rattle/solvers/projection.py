"""Projection of a state onto the constraints."""

from __future__ import annotations

from rattle.equations.motion import constraints, correct, drive, place, rate_residual, residual
from rattle.equations.schur import factorise
from rattle.equations.state import take_travels
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.step_audit import note_drift, openness

CLOSE_ENOUGH = 1e-15  # residual below which positions are not corrected [m or rad]
QUADRATIC = 1e-9  # a correction that starts below this residual [m or rad] needs no second one


@native("i", "h", "f", "v", "v")
def project_on_constraints(m, t, y, unused):
    """Project y onto Phi = 0 and Phi_q v = nu with the least mass-weighted change; rows and factor are up to date then.

    t: [s].  Returns the number of redundant rows.
    """
    change = m.change
    nq = change.shape[0]
    q, v = y[:nq], y[nq : 2 * nq]
    place(m, q, v)
    take_travels(m, y)
    drive(m, t)
    constraints(m)
    lost = factorise(m)
    drift = residual(m)
    m.audit[at.CORRECTION] = openness(m)
    if drift > CLOSE_ENOUGH:
        for _ in range(3):
            correct(m)
            for k in range(nq):
                q[k] += change[k]
            place(m, q, v)
            constraints(m)
            before = drift
            drift = residual(m)
            if before < QUADRATIC or not drift < before:
                break
        lost = factorise(m)
    rate_residual(m)
    correct(m)
    for k in range(nq):
        v[k] += change[k]
    place(m, q, v)
    constraints(m)  # gamma at the corrected rates
    return lost


@native("void", "h", "f", "v")
def project(m, t, y):
    """Project y onto the constraints; the largest remaining drift and the number of redundant rows are recorded."""
    tally = m.tally
    lost = project_on_constraints(m, t, y, y)
    row = note_drift(m)
    if row >= 0:
        tally[at.DRIFT_ROW] = row
    if lost > tally[at.LOST_ROWS]:
        tally[at.LOST_ROWS] = lost


@compiled
def close_joints(m, t, y):
    """One correction of positions and rates onto the joint constraints."""
    change, nq = m.change, m.change.shape[0]
    q, v = y[:nq], y[nq : 2 * nq]
    take_travels(m, y)
    drive(m, t)
    constraints(m)
    factorise(m)
    residual(m)
    correct(m)
    for c in range(nq):
        q[c] += change[c]
    place(m, q, v)
    constraints(m)
    row = note_drift(m)
    if row >= 0:
        m.tally[at.DRIFT_ROW] = row
    rate_residual(m)
    correct(m)
    for c in range(nq):
        v[c] += change[c]
    place(m, q, v)
