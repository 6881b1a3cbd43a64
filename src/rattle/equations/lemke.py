"""Contact problems followed from one with a trivial solution: Lemke's path through the modes.

    a = G f + b + theta d,     d_n > mu |d_t|

For large theta all contacts separate and f = 0.  Theta then decreases to zero while one contact after the other changes
its mode, each to the one that continues the solution; theta may increase on the way.  If contacts may stick or slip
either way, the path can only end at theta = 0, since f . (G f + b + theta d) <= 0 allows only f = 0 at large theta:
an impact has a solution.  If the directions of slip are prescribed the path may go to infinity (a ray): then the force
that presses contacts together makes them approach, as Painleve found.  In most cases there is no solution then; other
paths are tried, and a proof needs all combinations of modes.

For given modes everything is linear in theta, so that each change of mode costs two linear solutions, for any
number of contacts.  The entries of d differ, so that no two contacts change at once; the diagonal of G is raised by
RAISED, so that contacts that depend on each other share their forces.

Source: Lemke, Bimatrix equilibrium points and mathematical programming, Management Science 11 (1965) 681-689; Cottle,
Pang, Stone, The Linear Complementarity Problem (1992), section 4.4; Stewart, Trinkle, Int. J. Numer. Methods Eng. 39
(1996) 2673-2691 (existence of a solution for impacts with friction).
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import (
    BACKWARD,
    FORWARD,
    JAMMED,
    OFF,
    SOLVED,
    STICK,
    UNDECIDED,
    A,
    B,
    F,
    friction_of,
    linear,
)
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel

RAISED = 1e-11
ATTEMPTS = 4
GOLDEN = 0.6180339887498949  # its multiples modulo 1 are evenly spread and never equal
KEPT_B, UNEVEN, F_RATE, A_RATE = range(4)  # rows of `path`
# quantities that must stay positive: a_n and N; -a_t, a_t of sliding; the friction reserve when sticking
PARTING, PRESSING, FORWARDS, BACKWARDS, SHORT_OF_FORWARD, SHORT_OF_BACKWARD = range(6)
TILT = 0.2  # of the largest b: how far d leads sideways


@compiled
def margin(m, k, what, theta, slope):
    """The quantity `what` that must stay positive for contact k at theta; with slope = 1 its derivative by theta."""
    side, path = m.side, m.path
    n, t = 2 * k, 2 * k + 1
    if what in (PARTING, FORWARDS, BACKWARDS):
        r = n if what == PARTING else t
        value = path[A_RATE, r] if slope == 1 else side[A, r] + theta * path[A_RATE, r]
        return -value if what == FORWARDS else value
    pressed = path[F_RATE, n] if slope == 1 else side[F, n] + theta * path[F_RATE, n]
    if what == PRESSING:
        return pressed
    held = path[F_RATE, t] if slope == 1 else side[F, t] + theta * path[F_RATE, t]
    return friction_of(m, m.active[k]) * pressed - (held if what == SHORT_OF_FORWARD else -held)


@compiled
def margins(m, k):
    """Which two quantities must stay positive for contact k in its mode; equal if there is only one."""
    mode = m.candidate[k]
    if mode == OFF:
        return PARTING, PARTING
    if mode == STICK:
        return SHORT_OF_FORWARD, SHORT_OF_BACKWARD
    if m.slide[k] != 0 or friction_of(m, m.active[k]) == 0.0:
        return PRESSING, PRESSING
    return PRESSING, FORWARDS if mode == FORWARD else BACKWARDS


@compiled
def cross(m, k, what, theta):
    """Mode that contact k takes where a margin reaches zero, and the margin that is zero in the new mode."""
    slide = m.slide[k]
    if what == PARTING:
        if slide != 0 or friction_of(m, m.active[k]) == 0.0:
            return BACKWARD if slide < 0 else FORWARD, PRESSING
        return FORWARD if margin(m, k, BACKWARDS, theta, 0) < 0.0 else BACKWARD, PRESSING
    if what == PRESSING:
        return OFF, PARTING
    if what == FORWARDS:
        return STICK, SHORT_OF_FORWARD
    if what == BACKWARDS:
        return STICK, SHORT_OF_BACKWARD
    return (FORWARD, FORWARDS) if what == SHORT_OF_FORWARD else (BACKWARD, BACKWARDS)


@compiled
def begin(m, count, attempt):
    """Store b, choose a d for this attempt, set all contacts to off; returns a theta at which this is a solution."""
    side, path, candidate = m.side, m.path, m.candidate
    size = 0.0
    for r in range(2 * count):
        path[KEPT_B, r] = side[B, r]
        size = max(size, abs(side[B, r]))
    size = size if size > 0.0 else 1.0
    for k in range(count):
        candidate[k] = OFF
        spread = GOLDEN * (2 * count * attempt + 2 * k + 1)
        path[UNEVEN, 2 * k] = size * (0.75 + 0.5 * (spread - math.floor(spread)))
        spread += GOLDEN
        spread -= math.floor(spread) + 0.5
        path[UNEVEN, 2 * k + 1] = TILT * size * spread / (1.0 + friction_of(m, m.active[k]))
    return 2.0


@compiled
def both_parts(m, count):
    """Solve for b alone, f and a into `side`, and for d alone, into `path`."""
    side, path = m.side, m.path
    for r in range(2 * count):
        side[B, r] = path[UNEVEN, r]
    linear(m, count)
    for r in range(2 * count):
        path[F_RATE, r], path[A_RATE, r] = side[F, r], side[A, r]
        side[B, r] = path[KEPT_B, r]
    linear(m, count)


@compiled
def nearest_end(m, count, theta, sense, who, entered):
    """Where the path leaves its present piece: how far ahead, at which margin, of which contact (-1: nowhere).

    The margin that was crossed last, `entered` of contact `who`, does not count.
    """
    nearest, ends, next_who = math.inf, -1, -1
    for k in range(count):
        normal_margin, friction_margin = margins(m, k)
        for what in (normal_margin, friction_margin):
            falls = -sense * margin(m, k, what, theta, 1)
            if falls > 0.0 and not (k == who and what == entered):
                ahead = max(margin(m, k, what, theta, 0), 0.0) / falls
                if ahead < nearest:
                    nearest, ends, next_who = ahead, what, k
    return nearest, ends, next_who


@compiled
def follow(m, count, attempt):
    """Follow the path of one d; the modes at its end are in `candidate`.  Returns SOLVED, JAMMED or UNDECIDED."""
    candidate, path = m.candidate, m.path
    theta, sense, who, entered = begin(m, count, attempt), -1.0, -1, -1
    for _ in range(60 + 30 * count):
        both_parts(m, count)
        if who >= 0:
            growth = margin(m, who, entered, theta, 1)
            if not abs(growth) > 0.0:
                return UNDECIDED
            sense = 1.0 if growth > 0.0 else -1.0
        nearest, ends, next_who = nearest_end(m, count, theta, sense, who, entered)
        if sense < 0.0 and nearest >= theta:
            return SOLVED
        if next_who < 0:
            for k in range(count):
                if path[F_RATE, 2 * k] > 0.0:
                    return JAMMED
            return UNDECIDED
        theta += sense * nearest
        who = next_who
        candidate[who], entered = cross(m, who, ends, theta)
    return UNDECIDED


@kernel("problem")
def follow_kernel(m, count):
    """Modes of a solution into `candidate`; returns SOLVED, JAMMED (the path ends in a ray) or UNDECIDED."""
    held, side, path = m.held, m.side, m.path
    best = UNDECIDED
    held[at.RIDGE] = RAISED
    for attempt in range(ATTEMPTS):
        outcome = follow(m, count, attempt)
        for r in range(2 * count):
            side[B, r] = path[KEPT_B, r]
        best = max(best, outcome)
        if best == SOLVED:
            break
    held[at.RIDGE] = 0.0
    return best


KERNEL = follow_kernel
