"""Rows of velocities that the joints fix: can a force along such a row move anything?

P projects rows on the motions that the joints and drivers allow, in the norm of M^-1,

    P w = w - Phi_q^T z,   z = S^-1 Phi_q M^-1 w,       |P w|^2 = Y^T M Y = w . Y,   Y = M^-1 P w

A row w of a clutch, a stop or of friction with P w = 0 is a combination of those of the joints: its rate is z . nu and
its acceleration z . gamma whatever its force does, and that force only changes reactions.  Cancellation leaves
|P w| of about the rounding of its terms; as w . Y it would be lost at the root of that.  So |Y| is taken, and P is
applied twice where little is left.
"""

from __future__ import annotations

import math

from rattle.equations.schur import solve
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import compiled

LITTLE = 1e-4  # share of |w| left by P below which it is applied once more
FIXED = 1e-6  # share of the terms of P w that counts as zero: rounding leaves 1e-15, the error of an event at a dead
# centre 1e-8, a body that turns another one of 1e10 times its inertia 1e-5
STAYS = 1e-5  # the same for a row that was fixed: between projections, positions have the error of a step
CANCELLED = 1e-11  # share of its terms below which a rate or an acceleration of a fixed row is rounding


@compiled
def length(m, responses, first, n):
    """Y^T M Y of row n of responses, in which x of the first body stands in column `first`."""
    weight, total = m.weight, 0.0
    for i in range(1, weight.shape[0]):
        for k in range(3):
            value = responses[n, first + 3 * i - 3 + k]
            total += value * value / weight[i, k]
    return total


@compiled
def project_again(m, responses, first, reactions, n):
    """Apply P once more to row n of responses, and add to the reactions what it changes; S is factored."""
    rows, weight, x, place_of, row_body = m.rows, m.weight, m.solution, m.place, m.row_body
    for r in range(rows.shape[0]):
        value = 0.0
        for side in range(2):
            i = row_body[r, side]
            for k in range(3):
                if i > 0:
                    value += rows[r, at.AX + 3 * side + k] * responses[n, first + 3 * i - 3 + k]
        x[place_of[r]] = value
    solve(m)
    for r in range(rows.shape[0]):
        value = x[place_of[r]]
        reactions[n, r] += value
        for side in range(2):
            i = row_body[r, side]
            for k in range(3):
                if i > 0:
                    responses[n, first + 3 * i - 3 + k] -= weight[i, k] * rows[r, at.AX + 3 * side + k] * value


@compiled
def terms_of(m, reactions, n, size):
    """|w|_M + sum |z_i| |Phi_i|_M of row n, whose |w|^2 is `size`: what cancels in P w."""
    rows, weight, row_body, terms = m.rows, m.weight, m.row_body, math.sqrt(size)
    for r in range(rows.shape[0]):
        total = 0.0
        for side in range(2):
            for k in range(3):
                value = rows[r, at.AX + 3 * side + k]
                total += weight[row_body[r, side], k] * value * value
        terms += abs(reactions[n, r]) * math.sqrt(total)
    return terms


@compiled
def is_fixed(m, responses, first, reactions, n, size, share):
    """True if the joints fix the row whose response Y and reaction z stand in line n, and whose |w|^2 is `size`.

    share: FIXED or STAYS.  The response is refined if it is small.
    """
    if m.massless.shape[0] > 0 or not length(m, responses, first, n) <= LITTLE * LITTLE * size:
        return False
    project_again(m, responses, first, reactions, n)
    terms = share * terms_of(m, reactions, n, size)
    return length(m, responses, first, n) <= terms * terms


@compiled
def fixed_value(m, reactions, n, column):
    """z . nu or z . gamma of row n (column NU or GAMMA), its rate or acceleration if joints fix it; 0 if rounding."""
    rows, total, size = m.rows, 0.0, 0.0
    for r in range(rows.shape[0]):
        total += reactions[n, r] * rows[r, column]
        size += abs(reactions[n, r] * rows[r, column])
    return select(abs(total) > CANCELLED * size, total, 0.0)
