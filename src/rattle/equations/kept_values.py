"""Given values of positions and rates, kept as far as joints and drivers allow: compiled iterations.

Positions and rates change in two stages: first the given values, by the least change that the constraints require,
then all others by the least change still needed; both are weighted by mass.  With G the columns of the given values,
O the others, P the left null space of Phi_q O, and r the way back to the given values:

    min |e|, P^T Phi_q (G (r + e)) = -P^T Phi;   then   Phi_q (G (r + e) + O o) = -Phi

The null space and both least changes follow from reflections with pivoting (`jit.small_matrices`).
"""

from __future__ import annotations

import math

from rattle.equations.closure import CLOSED, ITERATIONS, SHUT, close_position, open_by
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.jit.functions import compiled, native
from rattle.jit.small_matrices import into_basis, out_of_basis, solve_lower, solve_upper, triangulate

NOISE = 1e-15  # share of the terms of a residual that is rounding
RANK = 1e-10  # share of the longest row below which the remainder of a row is dependent on others
EASY = 1e4  # by how much more coordinates without mass move than the inverse root of their fictitious mass says
ROUNDS = 40  # of Newton's method
AS_GIVEN, MOVED, NOT_CLOSED, NOT_FINITE = range(4)  # what became of positions and rates
# rows of `kept_places`, (3 nb,) each, and of `kept_sides`, (nr,) each
ATTEMPT, EXACT, START, STILL, THERE, CHANGE, MORE, ROOT, TURNED = range(9)
WANTED, ROUNDING, SIDE, REST, ORDERED = range(5)
SAME = 1e-14  # change or residual [sizes, rad] that is rounding
CLOSED_LAST = 1e-12  # sizes of the mechanism to which joints are closed once given values are kept
MOST_LAST = 30  # iterations of that
MOST_CHANGE = 0.5  # rotation [rad], or displacement [sizes], of one step
MOST_PINS = 6  # times that pins are moved anew: their places depend on the angles of their bushes
NOISE_OF_RATES = 8.0  # times NOISE, of the terms of a rate


@compiled
def scale_rows(m, rows, side):
    """Weight the first rows of `kept_wide` and scale them, and side, to length 1; True if one asks for a change."""
    wide, root, asked = m.kept_wide, m.kept_places[ROOT], False
    n = root.shape[0]
    for i in range(rows):
        square = 0.0
        for k in range(n):
            wide[i, k] *= root[k]
            square += wide[i, k] * wide[i, k]
        length = math.sqrt(square)
        if length > 0.0:
            for k in range(n):
                wide[i, k] /= length
            side[i] /= length
        asked = asked or side[i] != 0.0
    return asked


@compiled
def fit_dependent(m, rows, rank, ordered, turned):
    """Least squares of rows that depend on others, and need not agree with them; their triangle is in `kept_wide`."""
    wide, tall, pivot, second, pivot_tall = m.kept_wide, m.kept_tall, m.kept_pivot, m.kept_order[1], m.kept_pivot_tall
    for j in range(rank):
        for i in range(tall.shape[1]):
            tall[j, i] = 0.0
        tall[j, j] = pivot[0, j]
        for i in range(j + 1, rows):
            tall[j, i] = wide[i, j]
    for i in range(rows, ordered.shape[0]):
        ordered[i] = 0.0
    width = triangulate(tall, rank, second, pivot_tall, 0.0)
    into_basis(tall, pivot_tall, width, ordered)
    solve_upper(tall, pivot_tall, width, ordered)
    for j in range(width):
        turned[second[j]] = ordered[j]


@compiled
def shortest(m, rows, side, x):
    """Least x (n,), weighted by 1 / root^2, with A x = side in the sense of least squares.

    A: in the first rows of `kept_wide`; overwritten, as is side.
    """
    wide, pivot, first = m.kept_wide, m.kept_pivot, m.kept_order[0]
    ordered, turned, root = m.kept_sides[ORDERED], m.kept_places[TURNED], m.kept_places[ROOT]
    n = x.shape[0]
    for k in range(n):
        x[k] = 0.0
        turned[k] = 0.0
    if not scale_rows(m, rows, side):
        return
    rank = triangulate(wide, rows, first, pivot, RANK)
    for i in range(rows):
        ordered[i] = side[first[i]]
    if rank == rows:
        solve_lower(wide, pivot, rank, ordered)
        for k in range(rank):
            turned[k] = ordered[k]
    else:
        fit_dependent(m, rows, rank, ordered, turned)
    out_of_basis(wide, pivot, rank, turned)
    for k in range(n):
        x[k] = root[k] * turned[k]


@compiled
def span_of_others(m, prescribed, size):
    """Columns of Phi_q of coordinates without a given value into `kept_span`; returns their number."""
    rows, span, others = m.kept_rows, m.kept_span, 0
    for k in range(prescribed.shape[0]):
        if prescribed[k] != prescribed[k]:
            scale = 1.0 / size if k % 3 == 2 else 1.0
            for r in range(rows.shape[0]):
                span[others, r] = rows[r, k] * scale
            others += 1
    return others


@compiled
def combine_rows(m, prescribed, rank, j):
    """Combination j of the rows that coordinates without given values cannot satisfy, as a row of these values."""
    rows, line, i, pivot = m.kept_rows, m.kept_left[j - rank], j - rank, m.kept_pivot
    wanted, noise = m.kept_sides[WANTED], m.kept_sides[ROUNDING]
    nr = rows.shape[0]
    for r in range(nr):
        line[r] = 0.0
    line[j] = 1.0
    out_of_basis(m.kept_span, pivot, rank, line)
    asked, rounding = 0.0, 0.0
    for r in range(nr):
        asked += line[r] * wanted[r]
        rounding += abs(line[r]) * noise[r]
    m.kept_sides[SIDE, i] = asked if abs(asked) > rounding else 0.0
    for k in range(prescribed.shape[0]):
        value = 0.0
        if prescribed[k] == prescribed[k]:
            for r in range(nr):
                value += line[r] * rows[r, k]
        m.kept_wide[i, k] = value


@compiled
def least_change(m, prescribed, size):
    """Change with Phi_q change = `WANTED` (nr,) into `CHANGE`; coordinates that are given, not nan, change least.

    Phi_q in `kept_rows`; `ROUNDING` (nr,): of `WANTED`; combinations of rows that are not larger do not change given
    coordinates.
    """
    rows, wide, change, more = m.kept_rows, m.kept_wide, m.kept_places[CHANGE], m.kept_places[MORE]
    wanted, rest, root = m.kept_sides[WANTED], m.kept_sides[REST], m.kept_places[ROOT]
    nr, n = rows.shape[0], prescribed.shape[0]
    for k in range(n):
        change[k] = 0.0
    others = span_of_others(m, prescribed, size)
    if others < n:
        rank = triangulate(m.kept_span, others, m.kept_order[0], m.kept_pivot, RANK) if others > 0 else 0
        for j in range(rank, nr):
            combine_rows(m, prescribed, rank, j)
        shortest(m, nr - rank, m.kept_sides[SIDE], change)
    for r in range(nr):
        value, whole, square = wanted[r], 0.0, 0.0
        for k in range(n):
            weighted = (rows[r, k] * root[k]) ** 2
            whole += weighted
            if prescribed[k] == prescribed[k]:
                value -= rows[r, k] * change[k]
                wide[r, k] = 0.0
            else:
                wide[r, k] = rows[r, k]
                square += weighted
        rest[r] = value
        if square < RANK * RANK * whole:  # others move next to nothing in this row, as at a dead centre
            rest[r] = 0.0
            for k in range(n):
                wide[r, k] = 0.0
    if others > 0:
        shortest(m, nr, rest, more)
        for k in range(n):
            if prescribed[k] != prescribed[k]:
                change[k] = more[k]


@compiled
def take_rows(m):
    """Write Phi_q of the rows in the workspace as a matrix; False if a number of it is not finite."""
    full, rows, row_body, total = m.kept_rows, m.rows, m.row_body, 0.0
    for r in range(full.shape[0]):
        for k in range(full.shape[1]):
            full[r, k] = 0.0
        a, b = row_body[r, at.ROW_A], row_body[r, at.ROW_B]
        for k in range(3):
            if a > 0:
                full[r, 3 * a - 3 + k] += rows[r, at.AX + k]
            if b > 0:
                full[r, 3 * b - 3 + k] += rows[r, at.BX + k]
        for k in range(full.shape[1]):
            total += abs(full[r, k])
    return total < math.inf


@compiled
def take_roots(m):
    """Inverse roots of the masses of all coordinates, larger for those without mass."""
    root, weight, massless = m.kept_places[ROOT], m.weight, m.massless
    for i in range(1, weight.shape[0]):
        for k in range(3):
            root[3 * i - 3 + k] = math.sqrt(weight[i, k])
    for n in range(massless.shape[0]):
        root[3 * massless[n, 0] - 3 + massless[n, 1]] *= EASY


@compiled
def distance(m, q, prescribed):
    """Squared distance of positions q from those given, weighted by mass."""
    weight, total = m.weight, 0.0
    for k in range(q.shape[0]):
        if prescribed[k] == prescribed[k]:
            off = q[k] - prescribed[k]
            total += off * off / weight[k // 3 + 1, k % 3]
    return total


@compiled
def ask_for_given(m, prescribed, size):
    """Way from the positions in `ATTEMPT` to given values into `THERE`, and what rows ask for beside it."""
    there, attempt, full = m.kept_places[THERE], m.kept_places[ATTEMPT], m.kept_rows
    for k in range(prescribed.shape[0]):
        there[k] = prescribed[k] - attempt[k] if prescribed[k] == prescribed[k] else 0.0
    for r in range(full.shape[0]):
        value, terms = -m.rows[r, at.RES], 0.0
        for k in range(prescribed.shape[0]):
            value -= full[r, k] * there[k]
            terms += abs(full[r, k]) * abs(attempt[k])
        m.kept_sides[WANTED, r], m.kept_sides[ROUNDING, r] = value, NOISE * (terms + size)


@compiled
def approach_given(m, t, prescribed, size):
    """One step of the positions in `ATTEMPT` towards given values: its length [sizes, rad], inf without a number."""
    attempt, there, change = m.kept_places[ATTEMPT], m.kept_places[THERE], m.kept_places[CHANGE]
    open_by(m, t, attempt, m.kept_places[STILL])
    if not take_rows(m):
        return math.inf
    ask_for_given(m, prescribed, size)
    least_change(m, prescribed, size)
    most = 0.0
    for k in range(attempt.shape[0]):
        change[k] += there[k]
        most = max(most, abs(change[k]) if k % 3 == 2 else abs(change[k]) / size)
    if not most < math.inf:
        return math.inf
    share = min(1.0, MOST_CHANGE / max(most, TINY))
    for k in range(attempt.shape[0]):
        attempt[k] += share * change[k]
    return share * most


@compiled
def off_prescribed(m, q, prescribed):
    """Largest deviation of positions q from given values [m or rad]."""
    off = 0.0
    for k in range(q.shape[0]):
        if prescribed[k] == prescribed[k]:
            off = max(off, abs(q[k] - prescribed[k]))
    return off


@native("i", "h", "f", "v", "v", "f")
def keep_given(m, t, q, prescribed, size):
    """Closed positions near q (3 nb,) that keep the given values as far as joints allow, in place; q if none are found.

    prescribed: (3 nb,), nan if not given; size: of the mechanism [m].  Returns what became of q.
    """
    attempt, exact, still = m.kept_places[ATTEMPT], m.kept_places[EXACT], m.kept_places[STILL]
    n = q.shape[0]
    if off_prescribed(m, q, prescribed) <= SAME * max(1.0, size):
        return AS_GIVEN
    for k in range(n):
        attempt[k] = q[k]
        still[k] = 0.0
    take_roots(m)
    for _ in range(ROUNDS):
        moved = approach_given(m, t, prescribed, size)
        if not moved < math.inf:
            return NOT_FINITE
        if moved < SAME:
            break
    for k in range(n):
        exact[k] = attempt[k]
    gap, _iterations = close_position(m, t, attempt, m.kept_places[START], CLOSED_LAST * size, MOST_LAST)
    if not gap <= SHUT * size:
        return NOT_CLOSED
    if open_by(m, t, exact, still) <= SAME * max(1.0, size):
        for k in range(n):
            attempt[k] = exact[k]
    if not distance(m, attempt, prescribed) < distance(m, q, prescribed):
        return AS_GIVEN
    for k in range(n):
        q[k] = attempt[k]
    return MOVED


@native("i", "h", "f", "v", "v", "v", "f")
def keep_given_rates(m, t, q, v, prescribed, size):
    """Rates near v (3 nb,) that satisfy the constraints and keep given ones as far as possible, in place.

    q: (3 nb,) closed positions; prescribed: (3 nb,), nan if not given.  Returns what became of v.
    """
    sides, change, full = m.kept_sides, m.kept_places[CHANGE], m.kept_rows
    wanted, noise, n = sides[WANTED], sides[ROUNDING], q.shape[0]
    for k in range(n):
        if prescribed[k] == prescribed[k]:
            v[k] = prescribed[k]
    open_by(m, t, q, v)  # Phi_q and nu follow from the positions
    if not take_rows(m):
        return NOT_FINITE
    take_roots(m)
    for _ in range(2):
        closed = True
        for r in range(full.shape[0]):
            value, terms = m.rows[r, at.NU], abs(m.rows[r, at.NU])
            for k in range(n):
                value -= full[r, k] * v[k]
                terms += abs(full[r, k]) * abs(v[k])
            wanted[r] = value
            noise[r] = NOISE_OF_RATES * NOISE * terms
            closed = closed and abs(value) <= noise[r]
        if closed:
            break
        least_change(m, prescribed, size)
        for k in range(n):
            v[k] += change[k]
    return MOVED


@native("ii", "h", "f", "v", "v", "f", "n", "m", "i", "m")
def hold_pins(m, t, q, prescribed, size, pins, offsets, keep, scratch):
    """Closed positions near q (3 nb,), in place, with the bushes of joints moved to where their pins lie.

    pins (k, 3): body A of a joint, where its point on A stands in `values`, and the row of `offsets` (n, 4): this point
    in the frame of A, and the pin's offset in ground axes [m].  keep: 1 to keep given values (3 nb,) too.
    scratch: (2, 3 nb) or more.  Returns what became of q, and the number of iterations.
    """
    values, before, total, rounds = m.values, scratch[1], 0, 1
    for n in range(pins.shape[0]):
        if offsets[pins[n, 2], 2] != 0.0 or offsets[pins[n, 2], 3] != 0.0:
            rounds = MOST_PINS
    for _ in range(rounds):
        for n in range(pins.shape[0]):
            angle = q[3 * pins[n, 0] - 1] if pins[n, 0] > 0 else 0.0
            c, s, p, held = math.cos(angle), math.sin(angle), pins[n, 1], offsets[pins[n, 2]]
            values[p] = held[0] + (c * held[2] + s * held[3])
            values[p + 1] = held[1] + (c * held[3] - s * held[2])
        for k in range(q.shape[0]):
            before[k] = q[k]
        gap, iterations = close_position(m, t, q, scratch[0], CLOSED * size, ITERATIONS)
        total += iterations
        if not gap <= SHUT * size:
            return NOT_CLOSED, total
        if keep > 0 and keep_given(m, t, q, prescribed, size) == NOT_FINITE:
            return NOT_FINITE, total
        most = 0.0
        for k in range(q.shape[0]):
            most = max(most, abs(q[k] - before[k]))
        if most < SAME * size:
            break
    return MOVED, total
