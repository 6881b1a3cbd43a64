"""Impacts in two phases, compression and expansion: restitution after Poisson and energetic restitution.

    compression    a_C = G f_C + a-,      0 <= g'_C, 0 <= N_C, complementary;        T_C in -mu N_C Sgn(a_Ct)
    expansion      a+  = G f_E + a_C,     0 <= g'+,  s N_C <= N_E, complementary;    T_E in -mu N_E Sgn(a+_t)
    a = (g', -u) of every contact [m/s], f = (N, T) impulses [N s]

    poisson      s = e                                                  (Glocker, Pfeiffer 1995)
    energetic    s so that the work of N in expansion is -e^2 times that in compression,
                 N_E (g'_C + g'+)/2 = -e^2 N_C (g'- + g'_C)/2           (Stronge 1990)

Compression removes energy: lost = -f . (a- + a_C)/2 >= f . G f / 2.  With s = 0 expansion does nothing.  So the
shares s of the energetic law are scaled down together, by bisection, if the impact as a whole would create energy
or the work of any contact in expansion would exceed its bound: no impact creates energy.

The energetic law is computed here only if `impact_path` finds no solution: both have the two phases, that module also
follows friction along the path.

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 8; Stronge, Impact Mechanics
(2000), chapter 3.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import BACKWARD, EXACT, FORWARD, OFF, STICK, A, B, F, friction_of
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel
from rattle.solvers.nonsmooth.impact_path import CREATED, E, as_full_matrix

NEWTON, POISSON, ENERGETIC, LZB = range(4)  # in the order of the choices of the contact table
# rows of `bounce` after those of `impact_path` that stay: impulses and rates after compression, least impulse in
# expansion and its share of that in compression, a copy of the impulses; two columns for every active contact
PRESSED, RATES, FLOOR, SHARE, KEPT = range(2, 7)
LARGEST_SHARE = 4.0
SWEEPS = 400  # of relaxation, before modes are read from it
MOST_EXPANDED = 4  # contacts up to which all modes of expansion are tried where relaxation fails
RELAXED = 1e-16  # share of the largest impulse: changes below it end the relaxation
FITS = 1e-10  # share of the largest impulse or rate by which conditions may be violated by rounding
FITS_AT_LAST = 1e-9  # the same where relaxation has not converged further
RETURNED = 1e-9  # share by which a contact may return more than its bound, and that of the largest bound
RETURNED_OF_LARGEST = 1e-13
SAME_WORK = 1e-13  # share of its bound, and of its factor, within which the work of a contact is what it may be
HALVINGS_OF_SHARE = 40  # of the common share of work in expansion


@compiled
def law_of(m, n):
    """Restitution law of contact n: NEWTON, POISSON, ENERGETIC or LZB."""
    return int(m.values[m.contact[n, at.NORMAL_P] + at.RESTITUTION_LAW])


@compiled
def rates_of(m, count):
    """a of the present impulses, added to the rates after compression [m/s]."""
    side, g, bounce = m.side, m.delassus, m.bounce
    for r in range(2 * count):
        side[A, r] = bounce[RATES, r]
        for s in range(2 * count):
            side[A, r] += g[r, s] * side[F, s]


@compiled
def relax(m, count, sweeps):
    """Projected Gauss-Seidel on the expansion; returns the last change of an impulse, as a share of the largest."""
    side, g, bounce, active = m.side, m.delassus, m.bounce, m.active
    change, scale = 0.0, 0.0
    for r in range(2 * count):
        scale = max(scale, g[r, r])
    for _ in range(sweeps):
        change, largest = 0.0, 0.0
        for k in range(count):
            mu = friction_of(m, active[k])
            for r in range(2 * k, 2 * k + (2 if mu > 0.0 else 1)):
                new = side[F, r]
                if g[r, r] > EXACT * scale:
                    new -= side[A, r] / g[r, r]
                limit = mu * side[F, 2 * k]
                new = max(new, bounce[FLOOR, 2 * k]) if r == 2 * k else min(max(new, -limit), limit)
                step = new - side[F, r]
                change, largest = max(change, abs(step)), max(largest, abs(new))
                side[F, r] = new
                if step != 0.0:
                    for s in range(2 * count):
                        side[A, s] += g[s, r] * step
        if change <= RELAXED * largest:
            return 0.0
        change /= largest
    return change


@compiled
def eliminate(m, size):
    """Solve `system` (size equations, right-hand side in column `size`); False if it is singular."""
    system = m.system
    for c in range(size):
        best = c
        for r in range(c + 1, size):
            if abs(system[r, c]) > abs(system[best, c]):
                best = r
        if not abs(system[best, c]) > 0.0:
            return False
        if best != c:
            for j in range(size + 1):
                system[c, j], system[best, j] = system[best, j], system[c, j]
        for r in range(size):
            if r != c and system[r, c] != 0.0:
                factor = system[r, c] / system[c, c]
                for j in range(c, size + 1):
                    system[r, j] -= factor * system[c, j]
    return True


@compiled
def polish(m, count):
    """Solve the equations of the modes that relaxation has reached; False if they are not consistent.

    OFF: N at its lower bound, and sliding or sticking according to T.
    """
    side, bounce = m.side, m.bounce
    for r in range(2 * count):
        bounce[KEPT, r] = side[F, r]
    return solve_kept(m, count)


@compiled
def solve_kept(m, count):
    """Solve the equations of the modes of the impulses in `kept`; False if they are not consistent."""
    side, g, bounce, system = m.side, m.delassus, m.bounce, m.system
    active = m.active
    size = 0
    for r in range(2 * count):
        if not is_free(m, r):
            continue
        column = 0
        right = -bounce[RATES, r]
        for k in range(count):
            mu, n, t = friction_of(m, active[k]), 2 * k, 2 * k + 1
            sense = 0.0 if mu == 0.0 or is_free(m, t) else (1.0 if bounce[KEPT, t] > 0.0 else -1.0)
            value = g[r, n] + sense * mu * g[r, t]
            if is_free(m, n):
                system[size, column] = value
                column += 1
            else:
                right -= value * bounce[FLOOR, n]
            if is_free(m, t):
                system[size, column] = g[r, t]
                column += 1
        system[size, column] = right
        size += 1
    if not eliminate(m, size):
        return False
    column = 0
    for k in range(count):
        mu, n, t = friction_of(m, active[k]), 2 * k, 2 * k + 1
        sticks, sense = is_free(m, t), 1.0 if bounce[KEPT, t] > 0.0 else -1.0
        side[F, n] = bounce[FLOOR, n]
        if is_free(m, n):
            side[F, n] = system[column, size] / system[column, column]
            column += 1
        side[F, t] = sense * mu * side[F, n]
        if sticks:
            side[F, t] = system[column, size] / system[column, column]
            column += 1
    rates_of(m, count)
    return True


@compiled
def is_free(m, r):
    """True if impulse r of the relaxation is at none of its bounds; they are in `kept`."""
    bounce = m.bounce
    n = r - r % 2
    if r == n:
        return bounce[KEPT, n] > bounce[FLOOR, n]
    mu = friction_of(m, m.active[n // 2])
    return mu > 0.0 and abs(bounce[KEPT, r]) < mu * bounce[KEPT, n]


@compiled
def fits(m, count, slack):
    """True if the present impulses and rates satisfy all conditions of expansion up to a share `slack`."""
    side, g, bounce, active = m.side, m.delassus, m.bounce, m.active
    force, rate = 0.0, 0.0
    for r in range(2 * count):
        force = max(force, abs(side[F, r]), abs(bounce[PRESSED, r]))
        rate = max(rate, abs(bounce[RATES, r]))
        for s in range(2 * count):
            rate = max(rate, abs(g[r, s] * side[F, s]))
    force, rate = slack * force, slack * rate
    for k in range(count):
        mu, n, t = friction_of(m, active[k]), 2 * k, 2 * k + 1
        if side[F, n] < bounce[FLOOR, n] - force or side[A, n] < -rate:
            return False
        if side[F, n] > bounce[FLOOR, n] + force and side[A, n] > rate:
            return False
        limit = mu * side[F, n]
        if abs(side[F, t]) > limit + force:
            return False
        if mu > 0.0 and side[F, t] < limit - force and side[A, t] < -rate:
            return False
        if mu > 0.0 and side[F, t] > force - limit and side[A, t] > rate:
            return False
    return True


@compiled
def expansion(m, count, scale):
    """Impulses f of expansion and rates a after it, with `scale` times the shares; False if none are found."""
    side, bounce = m.side, m.bounce
    for k in range(count):
        bounce[FLOOR, 2 * k] = scale * bounce[SHARE, 2 * k] * bounce[PRESSED, 2 * k]
        side[F, 2 * k], side[F, 2 * k + 1] = bounce[FLOOR, 2 * k], 0.0
    rates_of(m, count)
    for turn in range(4):
        relax(m, count, SWEEPS * (1 + 4 * turn))
        if polish(m, count) and fits(m, count, FITS):
            return True
        for r in range(2 * count):
            side[F, r] = bounce[KEPT, r]
        rates_of(m, count)
    return fits(m, count, FITS_AT_LAST) or (count <= MOST_EXPANDED and try_expansions(m, count))


@compiled
def keep_modes(m, count, code):
    """Combination `code` of modes of expansion into `kept`: N at its least or above it, T free or at either limit."""
    bounce, active = m.bounce, m.active
    for k in range(count):
        above, along = code % 2, code // 2 % 3
        code //= 6
        bounce[KEPT, 2 * k] = bounce[FLOOR, 2 * k] + above * (1.0 + bounce[PRESSED, 2 * k])
        bounce[KEPT, 2 * k + 1] = (along - 1.0) * friction_of(m, active[k]) * bounce[KEPT, 2 * k]


@compiled
def try_expansions(m, count):
    """Try all modes of expansion: friction that is strong keeps relaxation from converging. True if one fits."""
    combinations = 1
    for _ in range(count):
        combinations *= 6
    for code in range(combinations):
        keep_modes(m, count, code)
        if solve_kept(m, count) and fits(m, count, FITS_AT_LAST):
            return True
    return False


@compiled
def work_in_expansion(m, k):
    """Work of N of contact k in expansion [J]."""
    side, bounce = m.side, m.bounce
    return 0.5 * side[F, 2 * k] * (bounce[RATES, 2 * k] + side[A, 2 * k])


@compiled
def most_work(m, k):
    """Work [J] that N of contact k may do in expansion: e^2 times the energy it removed in compression."""
    side, bounce = m.side, m.bounce
    e = bounce[E, 2 * m.active[k]]
    taken = -0.5 * bounce[PRESSED, 2 * k] * (side[B, 2 * k] + bounce[RATES, 2 * k])
    return e * e * max(taken, 0.0)


@compiled
def takes_energy(m, count):
    """True if the impact as a whole loses energy and no contact returns more than its bound."""
    side, bounce = m.side, m.bounce
    lost, size, largest = 0.0, 0.0, 0.0
    for k in range(count):
        largest = max(largest, most_work(m, k))
    for r in range(2 * count):
        total = bounce[PRESSED, r] + side[F, r]
        lost -= 0.5 * total * (side[B, r] + side[A, r])
        size += abs(total) * (abs(side[B, r]) + abs(side[A, r]))
    for k in range(count):
        if work_in_expansion(m, k) > most_work(m, k) * (1.0 + RETURNED) + RETURNED_OF_LARGEST * largest:
            return False
    return lost >= -CREATED * size


@compiled
def find_shares(m, count):
    """Shares with which every contact does its allowed work in expansion, or less; False if that does not converge."""
    bounce, active = m.bounce, m.active
    for k in range(count):
        bounce[SHARE, 2 * k] = bounce[E, 2 * active[k]] if most_work(m, k) > 0.0 else 0.0
    for _ in range(60):
        if not expansion(m, count, 1.0):
            return False
        converged = True
        for k in range(count):
            may, does = most_work(m, k), work_in_expansion(m, k)
            if may == 0.0 or does <= 0.0 or abs(does - may) <= SAME_WORK * may:
                continue
            better = min(bounce[SHARE, 2 * k] * math.sqrt(may / does), LARGEST_SHARE)
            converged = converged and abs(better - bounce[SHARE, 2 * k]) <= SAME_WORK * better
            bounce[SHARE, 2 * k] = better
        if converged:
            return takes_energy(m, count)
    return takes_energy(m, count)


@compiled
def expand_with_energy(m, count):
    """Expansion in which contacts do the work they may, or the largest common share of it that creates no energy."""
    side, bounce = m.side, m.bounce
    if find_shares(m, count):
        return
    low, high = 0.0, 1.0
    for _ in range(HALVINGS_OF_SHARE):
        middle = 0.5 * (low + high)
        if expansion(m, count, middle) and takes_energy(m, count):
            low = middle
        else:
            high = middle
    # no expansion at all: the state after compression is a solution
    if not (expansion(m, count, low) and takes_energy(m, count)):
        for r in range(2 * count):
            side[F, r], side[A, r] = 0.0, bounce[RATES, r]


@kernel("problem")
def expand_kernel(m, count):
    """Impulses of both phases, from f and a of compression in `side` and the rates before it in its b.

    Writes f and a of the whole impact, and modes to `candidate`; returns 0 if no expansion was found.
    """
    side, bounce, active, candidate = m.side, m.bounce, m.active, m.candidate
    as_full_matrix(m, count)
    for r in range(2 * count):
        bounce[PRESSED, r], bounce[RATES, r] = side[F, r], side[A, r]
    expands = True
    if law_of(m, active[0]) == ENERGETIC:
        expand_with_energy(m, count)
    else:
        for k in range(count):
            bounce[SHARE, 2 * k] = bounce[E, 2 * active[k]]
        expands = expansion(m, count, 1.0)
    for k in range(count):
        n, t = 2 * k, 2 * k + 1
        side[F, n] += bounce[PRESSED, n]
        side[F, t] += bounce[PRESSED, t]
        candidate[k] = OFF if side[F, n] <= 0.0 else FORWARD
        if candidate[k] != OFF and friction_of(m, active[k]) > 0.0 and abs(side[A, t]) <= EXACT * abs(side[B, t]):
            candidate[k] = STICK
        elif candidate[k] != OFF and side[A, t] > 0.0:
            candidate[k] = BACKWARD
    return 1 if expands else 0
