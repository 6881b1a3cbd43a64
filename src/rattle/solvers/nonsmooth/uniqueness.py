"""Existence and uniqueness of the solution of a contact problem: all modes are tried."""

from __future__ import annotations

from rattle.equations.complementarity import (
    BACKWARD,
    FOLLOW,
    FORWARD,
    LOOSE,
    MOST_TRIED,
    OFF,
    OTHER,
    SOLVED,
    STICK,
    TRY_ALL,
    A,
    B,
    F,
    doubt,
    friction_of,
    is_solution,
    linear,
    resolution,
)
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.jit.families import call_problem
from rattle.jit.functions import compiled, kernel

MOST_COMBINED = 2**16  # combinations of modes that are tried
EDGE = 1e-5  # share of a limit within which a force is about to pass it: see test_rough_pins
KEPT_MODES, KEPT = 4, 5  # rows of `path`, after those of `lemke`: modes, and forces of a first solution
DEFINITE = 1e-9  # share of its diagonal above which a pivot is positive whatever the rounding
APART = 1e-6  # share of the largest rate, or of both forces, by which two solutions differ: more than rounding


@compiled
def weaken(m, k, size):
    """Subtract from `system` the bound for the friction of active contact k; False if there is none."""
    system, delassus, n, t = m.system, m.delassus, 2 * k, 2 * k + 1
    mu, slide = friction_of(m, m.active[k]), m.slide[k]
    if mu > 0.0 and slide == 0:
        weight = (delassus[n, n] * delassus[t, t]) ** 0.5
        if not weight > 0.0:
            return False
        system[n, n] -= 0.5 * mu * weight
        for r in range(size):
            for s in range(size):
                system[r, s] -= 0.5 * mu * delassus[t, r] * delassus[t, s] / weight
    elif mu > 0.0:
        for r in range(size):
            system[r, n] += 0.5 * mu * slide * delassus[t, r]
            system[n, r] += 0.5 * mu * slide * delassus[t, r]
    return True


@compiled
def is_definite(m, size):
    """True if `system` is positive definite; it is factored."""
    system, delassus = m.system, m.delassus
    for c in range(size):
        if not system[c, c] > DEFINITE * max(delassus[c, c], TINY):
            return False
        for r in range(c + 1, size):
            share = system[r, c] / system[c, c]
            for s in range(c + 1, size):
                system[r, s] -= share * system[c, s]
    return True


@compiled
def surely_one(m, count):
    """True if friction is too weak for a second solution.

    T = mu sigma N with sigma from -1 to 1.  For the difference of two solutions, e = (dN, dT - mu sigma dN) satisfies
    e^T G (e + mu sigma (0, dN)) <= 0, since each contact's law is monotone in it.  So there is only one if G, less
    a bound for the friction term, is positive definite.  If the direction of slip is known that term is exact;
    otherwise it is at most mu (g dN^2 + (G_t e)^2 / g) / 2 at each contact, with any g > 0.
    """
    system, size = m.system, 2 * count
    for r in range(size):
        for s in range(size):
            system[r, s] = m.delassus[r, s]
    for k in range(count):
        if not weaken(m, k, size):
            return False
    for k in range(count):  # if the direction of slip is known, or without friction, dT - mu sigma dN = 0
        if m.slide[k] != 0 or friction_of(m, m.active[k]) == 0.0:
            for r in range(size):
                system[r, 2 * k + 1], system[2 * k + 1, r] = 0.0, 0.0
            system[2 * k + 1, 2 * k + 1] = 1.0
    return is_definite(m, size)


@compiled
def take_lasting(m, count):
    """Take modes that last instead of the present ones, if there are any with the same a."""
    path, candidate = m.path, m.candidate
    for k in range(count):
        path[KEPT_MODES, k] = candidate[k]
    if call_problem(m.problem_table[TRY_ALL], (m, 2 * count)) <= 0:
        for k in range(count):
            candidate[k] = int(path[KEPT_MODES, k])
        linear(m, count)


@compiled
def moves_otherwise(m, count):
    """True if a of the present solution differs from that of the first one."""
    side, largest, apart = m.side, 0.0, 0.0
    for r in range(2 * count):
        largest = max(largest, abs(side[B, r]))
        apart = max(apart, abs(side[A, r] - side[OTHER, r]))
    return apart > max(APART * largest, LOOSE * m.held[at.FAINT])


@compiled
def is_another(m, count):
    """True if the path leads to another a than that of the present solution, which is kept."""
    side, path, candidate = m.side, m.path, m.candidate
    for k in range(count):
        path[KEPT_MODES, k] = candidate[k]
    for r in range(2 * count):
        side[OTHER, r] = side[A, r]
    another = False
    if call_problem(m.problem_table[FOLLOW], (m, count)) == SOLVED:
        linear(m, count)
        another = is_solution(m, count, LOOSE) and moves_otherwise(m, count)
    for k in range(count):
        candidate[k] = int(path[KEPT_MODES, k])
    linear(m, count)
    return another


@compiled
def modes_of(m, k):
    """Number of modes that contact k may have: off and sliding; if it may stick, also sticking and sliding back."""
    return 2 if m.slide[k] != 0 or friction_of(m, m.active[k]) == 0.0 else 4


@compiled
def combinations(m, count):
    """Number of combinations of modes; counting stops above MOST_COMBINED."""
    total = 1
    for k in range(count):
        total = min(total * modes_of(m, k), 2 * MOST_COMBINED)
    return total


@compiled
def take_modes(m, count, code):
    """Combination number `code` of modes into `candidate`."""
    candidate, slide = m.candidate, m.slide
    for k in range(count):
        most = modes_of(m, k)
        candidate[k] = code % most
        if most == 2 and candidate[k] != OFF:
            candidate[k] = BACKWARD if slide[k] < 0 else FORWARD
        code //= most


@compiled
def lasts(m, count):
    """True if no force of the present solution is about to pass its limit: those of sticking, and that of pressing.

    With more contacts than can be tried it is not asked: forces of rounding size are at their limits by chance.
    """
    side, candidate, largest = m.side, m.candidate, 0.0
    if count > MOST_TRIED:
        return True
    for k in range(count):
        largest = max(largest, side[F, 2 * k])
    for k in range(count):
        pressed, held = side[F, 2 * k], side[F, 2 * k + 1]
        limit = friction_of(m, m.active[k]) * pressed
        if candidate[k] != OFF and not pressed > EDGE * largest:
            return False
        if candidate[k] == STICK and limit > 0.0 and abs(held) > (1.0 - EDGE) * limit:
            return False
    return True


@compiled
def note_shared(m, count, unsure):
    """Note contacts whose force is not that of the first solution; unsure: 1 if they move alike, otherwise 2.

    Of those that move alike the normal force counts, of others friction too.
    """
    side, kept = m.side, m.path[KEPT]
    for k in range(count):
        for r in range(2 * k, 2 * k + (2 if unsure > 1.0 else 1)):
            if abs(side[F, r] - kept[r]) > APART * (abs(kept[r]) + abs(side[F, r])):
                doubt(m, m.active[k], unsure)


@compiled
def excludes(n, a, other_n, other_a, force, rate):
    """True if one of two forces N, and the acceleration a with the other one, are both more than rounding."""
    return (n > force and other_a > rate) or (other_n > force and a > rate)


@compiled
def slides_against(m, k, a_t, pressed, held, force, rate):
    """True if contact k, with a_t of one solution, needs another friction than that of the other solution."""
    if m.slide[k] != 0 or abs(a_t) <= rate:
        return False
    limit = friction_of(m, m.active[k]) * pressed
    return abs(held + (limit if a_t > 0.0 else -limit)) > force


@compiled
def is_joined(m, count):
    """True if all between the first solution and the present one are solutions too, as a = G f + b is linear in f.

    So it is where closed contacts hold another one along its wall: any friction there up to its limit goes with
    them.  Such forces are not determined, as those of bodies at rest on many contacts.
    """
    side, kept = m.side, m.path[KEPT]
    force, rate = resolution(m, count)
    force, rate = LOOSE * force, LOOSE * rate
    for k in range(count):
        n, t = 2 * k, 2 * k + 1
        if excludes(kept[n], side[OTHER, n], side[F, n], side[A, n], force, rate):
            return False
        if slides_against(m, k, side[OTHER, t], side[F, n], side[F, t], force, rate):
            return False
        if slides_against(m, k, side[A, t], kept[n], kept[t], force, rate):
            return False
    return True


@compiled
def bears_less(m, count):
    """True if the forces of the present solution are less than those of the first one."""
    here, first = 0.0, 0.0
    for r in range(2 * count):
        here += m.side[F, r] * m.side[F, r]
        first += m.path[KEPT, r] * m.path[KEPT, r]
    return here < (1.0 - APART) * first


@compiled
def take_as_first(m, count):
    """Keep the present solution as the one that others are compared with."""
    for r in range(2 * count):
        m.side[OTHER, r] = m.side[A, r]
        m.path[KEPT, r] = m.side[F, r]


@compiled
def try_combinations(m, count, most, slack):
    """`try_kernel`, accepting solutions up to a tolerance `slack`."""
    motions, chosen, firm = 0, 0, False
    for code in range(combinations(m, count)):
        take_modes(m, count, code)
        linear(m, count)
        if not is_solution(m, count, slack):
            continue
        if motions == 0:
            motions = 1
            take_as_first(m, count)
            chosen, firm = code, lasts(m, count)
        elif moves_otherwise(m, count):
            if not is_joined(m, count):
                motions += 1
                break
            note_shared(m, count, 2.0)
            if bears_less(m, count):
                take_as_first(m, count)
                chosen, firm = code, lasts(m, count)
        else:
            note_shared(m, count, 1.0)
            if not firm and lasts(m, count):
                chosen, firm = code, True
        if motions > 1 or (firm and most == 1):
            break
    if motions > 0:
        take_modes(m, count, chosen)
        linear(m, count)
    return motions


@kernel("problem")
def try_kernel(m, number):
    """Try all modes; returns the number of solutions with different a, at most 2, and keeps the first one.

    Of modes with its a, those are kept whose forces do not pass a limit at once: bodies at rest on several contacts
    have many forces, and modes that end at the instant at which they begin may alternate without end.  Solutions that
    `is_joined` finds to be one with it count as it, though a differs; that of them with the least forces is kept.

    number is 2 * contacts + most - 1, most being 1 or 2.  Returns -1 if there are too many combinations.
    """
    count, most = number // 2, 1 + number % 2
    if combinations(m, count) > MOST_COMBINED:
        return -1
    solutions = try_combinations(m, count, most, 1.0) if count <= MOST_TRIED else 0
    return try_combinations(m, count, most, LOOSE) if solutions == 0 else solutions


@kernel("problem")
def count_kernel(m, count):
    """Number of different solutions of the problem as far as it is known, at most 2.

    With more contacts than can be tried, the present solution decides: one with the wrong sign of the determinant is
    never the only one, unless contacts that neither press nor open cause that sign; then another one is searched.
    With few contacts, modes that do not last are replaced by others with the same a, if there are any.
    """
    if count > MOST_TRIED:
        return 2 if linear(m, count) < 0 and is_another(m, count) else 1
    if not surely_one(m, count):
        return call_problem(m.problem_table[TRY_ALL], (m, 2 * count + 1))
    if not lasts(m, count):
        take_lasting(m, count)
    return 1


KERNELS = (count_kernel, try_kernel)
