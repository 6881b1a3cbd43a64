"""Compiled iterations that close the joints: damped Newton on positions and rates, with least mass-weighted change."""

from __future__ import annotations

import math

from rattle.equations.massless import take_out_of_change
from rattle.equations.motion import constraints, correct, drive, place, rate_residual, residual
from rattle.equations.schur import factorise
from rattle.jit import layout as at
from rattle.jit.functions import native

CLOSED = 1e-13  # sizes of the mechanism to which Newton's method goes on: positions are rounded to 1e-16 of it
SHUT = 1e-9  # sizes of the mechanism by which joints may stay open, and given places be missed
ITERATIONS = 60  # of Newton's method
MOST_TURN = 0.5  # rotation of a body in one step [rad]: rows are linear in no larger one
POLISH = 2  # steps below the tolerance


@native("f", "h", "f", "v", "v")
def open_by(m, t, q, v):
    """Largest position residual [m or rad] at a state; the constraint rows remain in the workspace."""
    place(m, q, v)
    drive(m, t)
    constraints(m)
    return residual(m)


@native("void", "h", "v")
def place_only(m, q):
    """Copy positions q (3 nb,) [m, rad] into `body`; rates there are unchanged."""
    body = m.body
    for i in range(1, body.shape[0]):
        body[i, at.X] = q[3 * i - 3]
        body[i, at.Y] = q[3 * i - 2]
        body[i, at.PHI] = q[3 * i - 1]
        body[i, at.COS] = math.cos(q[3 * i - 1])
        body[i, at.SIN] = math.sin(q[3 * i - 1])


@native("f", "h", "v")
def merit_at(m, q):
    """Sum of squared position residuals at q [m^2, rad^2]."""
    rows = m.rows
    place_only(m, q)
    constraints(m)
    value = 0.0
    for r in range(rows.shape[0]):
        value += rows[r, at.RES] * rows[r, at.RES]
    return value


@native("fi", "h", "f", "v", "v", "f", "i")
def close_position(m, t, q, start, tolerance, most):
    """Damped Newton on Phi(q, t) = 0, in place; returns the largest residual [m or rad] and the iterations.

    start: (3 nb,) scratch.  tolerance: [m or rad].  Two more steps below the tolerance reduce the residual to rounding.
    """
    change = m.change
    drive(m, t)
    merit = merit_at(m, q)
    gap = residual(m)
    polish = 0
    for iteration in range(most):
        if not gap > 0.0 or not gap < math.inf or polish == POLISH:
            return gap, iteration
        if gap <= tolerance:
            polish += 1
        factorise(m)
        correct(m)
        share = 1.0
        for k in range(2, q.shape[0], 3):
            if abs(change[k]) * share > MOST_TURN:
                share = MOST_TURN / abs(change[k])
        for k in range(q.shape[0]):
            start[k] = q[k]
        now = math.inf
        for _ in range(12):
            for k in range(q.shape[0]):
                q[k] = start[k] + share * change[k]
            now = merit_at(m, q)
            if now < merit:
                break
            share *= 0.5
        if not now < merit:
            for k in range(q.shape[0]):
                q[k] = start[k]
            merit_at(m, q)
            return residual(m), iteration
        merit = now
        gap = residual(m)
    return gap, most


@native("f", "h", "f", "v", "v")
def close_rate(m, t, q, v):
    """Project v onto Phi_q v = nu with the least mass-weighted change, in place.

    Returns the largest residual [m/s or rad/s].
    """
    change = m.change
    open_by(m, t, q, v)
    factorise(m)
    for _ in range(3):
        rate_residual(m)
        correct(m)
        if m.massless.shape[0] > 0:
            take_out_of_change(m)
        for k in range(v.shape[0]):
            v[k] += change[k]
        place(m, q, v)
    return rate_residual(m)
