"""Whether a contact problem has one solution only."""

from __future__ import annotations

from rattle.catalog import call_problem, compiled, kernel
from rattle.complementarity import FOLLOW, LOOSE, MOST_TRIED, SOLVED, A, B, all_modes, friction_of, linear, settled
from rattle.memory import CHOSEN, DELASSUS, PATH, PROBLEM_TABLE, SIDE, SLIDE, SYSTEM, TRIAL, ivec, mat

KEPT_MODES, KEPT_A = 4, 5  # rows of `path`, after those of following


@compiled
def surely_one(m, count):
    """True when this friction is too weak for a second solution.

    T = mu sigma N with sigma from -1 to 1.  Of the differences of two solutions e = (dN, dT - mu sigma dN) has
    e^T G (e + mu sigma (0, dN)) <= 0, since each contact's law is monotone in it.  So there is one only where G, less
    what friction can take from it, is positive definite.  Where the sense of slip is known it takes what it takes;
    elsewhere at most mu (g dN^2 + (G_t e)^2 / g) / 2 at each contact, with any g > 0.
    """
    system, delassus, chosen, slide = mat(m, SYSTEM), mat(m, DELASSUS), ivec(m, CHOSEN), ivec(m, SLIDE)
    size = 2 * count
    for r in range(size):
        for s in range(size):
            system[r, s] = delassus[r, s]
    for k in range(count):
        n, t = 2 * k, 2 * k + 1
        mu = friction_of(m, chosen[k])
        if mu > 0.0 and slide[k] == 0:
            weight = (delassus[n, n] * delassus[t, t]) ** 0.5
            if not weight > 0.0:
                return False
            system[n, n] -= 0.5 * mu * weight
            for r in range(size):
                for s in range(size):
                    system[r, s] -= 0.5 * mu * delassus[t, r] * delassus[t, s] / weight
        elif mu > 0.0:
            for r in range(size):
                system[r, n] += 0.5 * mu * slide[k] * delassus[t, r]
                system[n, r] += 0.5 * mu * slide[k] * delassus[t, r]
    for k in range(count):  # where the sense of slip is known, or nothing rubs, dT - mu sigma dN = 0
        if slide[k] != 0 or friction_of(m, chosen[k]) == 0.0:
            for r in range(size):
                system[r, 2 * k + 1], system[2 * k + 1, r] = 0.0, 0.0
            system[2 * k + 1, 2 * k + 1] = 1.0
    for c in range(size):
        if not system[c, c] > 1e-9 * max(delassus[c, c], 1e-300):
            return False
        for r in range(c + 1, size):
            share = system[r, c] / system[c, c]
            for s in range(c + 1, size):
                system[r, s] -= share * system[c, s]
    return True


@compiled
def is_another(m, count):
    """True when the path leads to another a than that of the solution at hand, which stays at hand."""
    side, path, trial = mat(m, SIDE), mat(m, PATH), ivec(m, TRIAL)
    for k in range(count):
        path[KEPT_MODES, k] = trial[k]
    for r in range(2 * count):
        path[KEPT_A, r] = side[A, r]
    apart, largest = 0.0, 0.0
    if call_problem(ivec(m, PROBLEM_TABLE)[FOLLOW], (m, count)) == SOLVED:
        linear(m, count)
        if settled(m, count, LOOSE):
            for r in range(2 * count):
                largest = max(largest, abs(side[B, r]))
                apart = max(apart, abs(side[A, r] - path[KEPT_A, r]))
    for k in range(count):
        trial[k] = int(path[KEPT_MODES, k])
    linear(m, count)
    return apart > 1e-6 * largest


@kernel("problem")
def count_kernel(m, count):
    """Number of different solutions of the problem as far as it is known, at most 2.

    Of more contacts than are tried, the solution at hand tells: one with the wrong sign of the determinant never
    stands alone, unless contacts that neither press nor part lend it their sign; then another one is looked for.
    """
    if count > MOST_TRIED:
        return 2 if linear(m, count) < 0 and is_another(m, count) else 1
    return 1 if surely_one(m, count) else all_modes(m, count, 2)


KERNEL = count_kernel
