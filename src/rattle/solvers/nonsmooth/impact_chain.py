"""Impacts of several contacts by the energy that each stores: the distributing law of Liu, Zhao and Brogliato.

Every contact is compliant, F = K x^eta with its energy E = K x^(eta+1)/(eta+1), while all bodies stay where they are:
impulses grow with the forces, and their shares follow from the energies alone,

    dP_i/dP_j = F_i/F_j = (K_i/K_j)^(1/(eta+1)) (E_i/E_j)^(eta/(eta+1))
    dE = -g' dP in compression, g' < 0         dE = -g' dP/e^2 in expansion, g' > 0

so that each contact returns e^2 of the work that it has taken (Stronge), in as many compressions and expansions as the
others make of it.  With x for E and a time s that is common to all,

    dP/ds = K x^eta,     dx/ds = -g' (1/e^2 where it expands),     g' = g'- + G P

A contact that has given back its energy is open: x < 0 is its gap, of the size of the deformations, and it closes again
where that vanishes.  The impact ends when all contacts are open and none approaches another any more.  K and s have any
unit: if all have one eta, only ratios of K matter.

e = 0 is the limit of small e, whose expansion takes no time.  Where compression ends, at x = x_1, the others press with
N = -sum_j G_ij F_j / G_ii < F; x falls through F = N to where the contact has come to rest again,
E - N x = E_1 - N x_1, or to x = 0.

Impulses do not depend on paths of friction: there is none.  The steps are those of Dormand and Prince, of order 5.

Source: Liu, Zhao, Brogliato, Frictionless multiple impacts in multibody systems, Proc. R. Soc. A 464 (2008) 3193-3211;
Nguyen, Brogliato, Multiple Impacts in Dissipative Granular Chains (2014), chapter 3.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import EXACT, FORWARD, OFF, A, B, F
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel
from rattle.solvers.nonsmooth.impact_path import E, as_full_matrix
from rattle.solvers.tableau import Tableau

STAGES = 7
# rows of `chain`, two columns for every active contact: compression x and impulse P; those of a stage; their slopes at
# the stages; the sizes of x and of P by which their errors are measured
NOW, STAGE, SLOPES, SIZES = 0, 1, 2, 2 + STAGES
ROWS = SIZES + 1
ROWS_OF_STAGES = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
TABLEAU = Tableau(
    order=5,
    times=(0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0),
    rows=ROWS_OF_STAGES,
    weights=(*ROWS_OF_STAGES[-1], 0.0),  # its last stage is the first one of the next step
    errors=((71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40),),
)
STAGE_WEIGHTS, ERROR_WEIGHTS = TABLEAU.a, TABLEAU.ends[1]
CLOSE = 1e-11  # error of a step, as a share of the sizes
FIRST = 1e-3  # first step, as a share of the shortest compression
GROWS, SHRINKS, SAFE = 4.0, 0.2, 0.9  # most and least by which a step changes, and the share of what the error allows
MOST_STEPS = 400_000
APPROACH = 1e-14  # share of the largest rate up to which contacts may approach at the end, and its square of energy
HOLDS = 60  # rounds in which the forces of several contacts at rest are found
SETTLED = 1e-15  # share of the force of a contact at rest that ends them
HALVINGS = 60  # of an interval of compressions, to rounding


@compiled
def stiffness_of(m, n):
    """K of contact n [N/m^eta, or N m/rad^eta]."""
    return m.values[m.contact[n, at.NORMAL_P] + at.CHAIN_STIFFNESS]


@compiled
def exponent_of(m, n):
    """Exponent eta of contact n."""
    return m.values[m.contact[n, at.NORMAL_P] + at.CHAIN_EXPONENT]


@compiled
def pressed(m, n, x):
    """Force of contact n at the compression x."""
    return stiffness_of(m, n) * x ** exponent_of(m, n) if x > 0.0 else 0.0


@compiled
def rate_at(m, k, count, row):
    """Rate of the gap of active contact k [m/s] by the impulses in a row of `chain`."""
    rate = m.side[B, 2 * k]
    for j in range(count):
        rate += m.delassus[2 * k, 2 * j] * m.chain[row, 2 * j + 1]
    return rate


@compiled
def rests(m, k, rate, x):
    """True if active contact k returns nothing, and has been compressed as far as it will be."""
    return m.bounce[E, 2 * m.active[k]] == 0.0 and x > 0.0 and rate >= 0.0


@compiled
def hold_at_rest(m, count, row, slopes):
    """Forces of contacts that return nothing: N, with which the others press, into the row `slopes` of `chain`.

    So they stay at rest up to the end of a step, after which their compressions fall.
    """
    g, chain, active = m.delassus, m.chain, m.active
    for _ in range(HOLDS):
        settled = True
        for k in range(count):
            x = chain[row, 2 * k]
            if not rests(m, k, rate_at(m, k, count, row), x):
                continue
            others = 0.0
            for j in range(count):
                if j != k:
                    others += g[2 * k, 2 * j] * chain[slopes, 2 * j + 1]
            force = min(max(-others / g[2 * k, 2 * k], 0.0), pressed(m, active[k], x))
            settled = settled and abs(force - chain[slopes, 2 * k + 1]) <= SETTLED * force
            chain[slopes, 2 * k + 1] = force
        if settled:
            break


@compiled
def slopes_at(m, count, row, slopes):
    """dx/ds and dP/ds of all contacts, at the state in one row of `chain`, into another row."""
    chain, active, bounce = m.chain, m.active, m.bounce
    plastic = False
    for k in range(count):
        n, x, rate = active[k], chain[row, 2 * k], rate_at(m, k, count, row)
        e = bounce[E, 2 * n]
        chain[slopes, 2 * k + 1] = pressed(m, n, x)
        chain[slopes, 2 * k] = -rate
        if rate > 0.0 and x > 0.0:
            chain[slopes, 2 * k] = -rate / (e * e) if e > 0.0 else 0.0
        plastic = plastic or rests(m, k, rate, x)
    if plastic:
        hold_at_rest(m, count, row, slopes)


@compiled
def begin(m, count):
    """Sizes of compressions and impulses, and the first step; 0 if nothing approaches, -1 if something cannot stop."""
    chain, side, g, active = m.chain, m.side, m.delassus, m.active
    largest, scale, energy = 0.0, 0.0, 0.0
    for k in range(count):
        scale = max(scale, g[2 * k, 2 * k])
        largest = max(largest, -side[B, 2 * k])
    for k in range(count):
        chain[NOW, 2 * k], chain[NOW, 2 * k + 1] = 0.0, 0.0
        if abs(side[B, 2 * k]) <= APPROACH * largest:
            side[B, 2 * k] = 0.0
        if not side[B, 2 * k] < 0.0:
            continue
        if not g[2 * k, 2 * k] > EXACT * scale:
            return -1.0
        energy += 0.5 * side[B, 2 * k] ** 2 / g[2 * k, 2 * k]
    step = 0.0
    for k in range(count):
        n = active[k]
        more = exponent_of(m, n) + 1.0
        chain[SIZES, 2 * k] = (more * energy / stiffness_of(m, n)) ** (1.0 / more)
        chain[SIZES, 2 * k + 1] = largest / max(g[2 * k, 2 * k], EXACT * scale)
        if side[B, 2 * k] < 0.0:
            alone = FIRST * chain[SIZES, 2 * k] / -side[B, 2 * k]
            step = alone if step == 0.0 else min(step, alone)
    return step


@compiled
def try_step(m, count, step):
    """State at the end of a step into the row STAGE, its slopes into the last row of slopes; returns its error."""
    chain = m.chain
    for s in range(1, STAGES):
        for c in range(2 * count):
            value = 0.0
            for r in range(s):
                value += STAGE_WEIGHTS[s, r] * chain[SLOPES + r, c]
            chain[STAGE, c] = chain[NOW, c] + step * value
        slopes_at(m, count, STAGE, SLOPES + s)
    error = 0.0
    for c in range(2 * count):
        value = 0.0
        for r in range(STAGES):
            value += ERROR_WEIGHTS[r] * chain[SLOPES + r, c]
        error = max(error, abs(step * value) / chain[SIZES, c])
    return error / CLOSE


@compiled
def fallen(m, n, x, press):
    """Compression of contact n after its expansion with e = 0, from x, while others press with a force less than F."""
    more = exponent_of(m, n) + 1.0
    share = stiffness_of(m, n) / more
    rest = share * x**more - press * x
    if rest >= 0.0:
        return 0.0
    low, high = 0.0, (press / stiffness_of(m, n)) ** (1.0 / exponent_of(m, n))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if share * middle**more - press * middle > rest:
            low = middle
        else:
            high = middle
    return high


@compiled
def take_step(m, count):
    """The end of the step becomes the present state; contacts that are at rest and return nothing lose energy."""
    chain, active, falls = m.chain, m.active, False
    for c in range(2 * count):
        chain[NOW, c] = chain[STAGE, c]
        chain[SLOPES, c] = chain[SLOPES + STAGES - 1, c]
    for k in range(count):
        n, x, force = active[k], chain[NOW, 2 * k], chain[SLOPES, 2 * k + 1]
        if force < pressed(m, n, x):
            chain[NOW, 2 * k] = fallen(m, n, x, force)
            falls = True
    if falls:
        slopes_at(m, count, NOW, SLOPES)


@compiled
def goes_on(m, count, least):
    """True while a contact has energy, or approaches faster than `least` [m/s]."""
    for k in range(count):
        share = m.chain[NOW, 2 * k] / m.chain[SIZES, 2 * k]
        if share > 0.0 and share ** (exponent_of(m, m.active[k]) + 1.0) > APPROACH**2:
            return True
        if rate_at(m, k, count, NOW) < -least:
            return True
    return False


@compiled
def way_ahead(m, count, step):
    """The longest next step: not far beyond where an open contact closes."""
    for k in range(count):
        x, rate = m.chain[NOW, 2 * k], -m.chain[SLOPES, 2 * k]
        if x < 0.0 and rate < 0.0:
            step = min(step, x / rate + FIRST * m.chain[SIZES, 2 * k] / -rate)
    return step


@compiled
def follow_chain(m, count):
    """Impulses P of all contacts into the row NOW of `chain`; False if they do not end."""
    step = begin(m, count)
    if step <= 0.0:
        return step == 0.0
    largest = 0.0
    for k in range(count):
        largest = max(largest, -m.side[B, 2 * k])
    slopes_at(m, count, NOW, SLOPES)
    for _ in range(MOST_STEPS):
        if not goes_on(m, count, APPROACH * largest):
            return True
        step = way_ahead(m, count, step)
        error = try_step(m, count, step)
        if not error < math.inf:
            return False
        if error <= 1.0:
            take_step(m, count)
        step *= min(max(SAFE * error**-0.2, SHRINKS), GROWS) if error > 0.0 else GROWS
    return False


@compiled
def conserving(m, count):
    """Factor of all impulses with which rounding and errors of steps create no energy: 1, or hardly less."""
    side, g, linear, square = m.side, m.delassus, 0.0, 0.0
    for k in range(count):
        linear += side[B, 2 * k] * side[F, 2 * k]
        for j in range(count):
            square += 0.5 * side[F, 2 * k] * g[2 * k, 2 * j] * side[F, 2 * j]
    return -linear / square if linear + square > 0.0 and square > 0.0 else 1.0


@kernel("problem")
def chain_kernel(m, count):
    """Impulses f of an impact under the distributing law, and rates a after it, from the rates in b; 0: none found."""
    side, g, candidate = m.side, m.delassus, m.candidate
    as_full_matrix(m, count)
    if not follow_chain(m, count):
        return 0
    for k in range(count):
        side[F, 2 * k], side[F, 2 * k + 1] = m.chain[NOW, 2 * k + 1], 0.0
    factor = conserving(m, count)
    for k in range(count):
        side[F, 2 * k] *= factor
        candidate[k] = FORWARD if side[F, 2 * k] > 0.0 else OFF
    for r in range(2 * count):
        side[A, r] = side[B, r]
        for j in range(count):
            side[A, r] += g[r, 2 * j] * side[F, 2 * j]
    return 1
