"""Energetic impacts along their path: rates as functions of growing impulses, friction opposing slip at any moment.

    one contact        dT = +-mu dN while it slides, or what keeps it from sliding (Darboux, Keller); compression ends
                       at g' = 0, expansion where the work of N is -e^2 times that in compression (Stronge)
    several contacts   all approach rates are reduced to zero together, g'(s) = (1 - s) g'-; then every contact expands,
                       dg'/ds >= e |g'-|, complementary to dN >= 0, until its work is done;
                       contacts without approach keep 0 <= g', dN >= 0, complementary

Impulses grow along straight pieces, from one instant to the next at which slip ends or reverses, a contact
opens, closes or has done its work; each piece is a contact problem for rates.  Normal impulses remove energy while
g' < 0 and return at most e^2 times of it while g' > 0, and friction always removes energy: no impact creates energy.
The impulse of a contact depends neither on inactive contacts nearby, nor on how two contacts at the same place share
the load.

Source: Stronge, Impact Mechanics (2000), chapters 3 and 8; Darboux, Keller, Impact with friction, J. Appl. Mech. 53
(1986) 1-4.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import (
    BACKWARD,
    FORWARD,
    OFF,
    ROWS_OF,
    SEARCH,
    STICK,
    A,
    B,
    F,
    fill_delassus,
    friction_of,
)
from rattle.jit import layout as at
from rattle.jit.families import call_problem
from rattle.jit.functions import compiled, kernel
from rattle.solvers.nonsmooth.rubbing_impacts import rub

# rows of `bounce`, two columns for every contact of the model: restitution e and rate of the gap before the impact
# (first column), impulses so far, present rates, work of N in this phase (first column) and the work it may still do
# in expansion (second column)
E, BEFORE, SO_FAR, NOW, WORK = range(5)
ZERO = 1e-13  # share of the largest rate below which a rate is zero
CREATED = 1e-14  # share of its terms below which the energy of an impact is rounding


@compiled
def way_of(g, mu, w):
    """How rates and the tangential impulse of the only contact grow with its normal one, from its slip w on [m/s].

    Slope of the rate of the gap, tangential impulse, and slope of w; the last one is 0 if it sticks.
    """
    if mu <= 0.0 or not g[1, 1] > 0.0:
        return g[0, 0], 0.0, 0.0
    if w != 0.0 or abs(g[0, 1]) > mu * g[1, 1]:
        sense = (-1.0 if w > 0.0 else 1.0) if w != 0.0 else (-1.0 if g[0, 1] > 0.0 else 1.0)
        return g[0, 0] + sense * mu * g[0, 1], sense * mu, g[0, 1] + sense * mu * g[1, 1]
    return g[0, 0] - g[0, 1] * g[0, 1] / g[1, 1], -g[0, 1] / g[1, 1], 0.0


@compiled
def whole_phase(rate, slope, expands, rest):
    """Normal impulse to the end of a phase: rate 0 in compression, the work `rest` [J] done in expansion; or inf."""
    if not slope > 0.0:
        return math.inf
    if expands:
        return (math.sqrt(rate * rate + 2.0 * slope * max(rest, 0.0)) - rate) / slope
    return -rate / slope


@compiled
def follow_path(m):
    """Impulses f [N s] of the only active contact, from the rates b [m/s] before the impact; e is in `bounce`.

    False if its compression does not end: joints that stick hold the contact, and one of them has to slip.
    """
    side, g, e = m.side, m.delassus, m.bounce[E, 2 * m.active[0]]
    mu = friction_of(m, m.active[0])
    rate, w = side[B, 0], side[B, 1]  # g' and -slip
    pressed, held, work, target, expands = 0.0, 0.0, 0.0, 0.0, False
    for _ in range(8):  # slide, stick or reverse, before and after the end of compression: four pieces at most
        if rate >= 0.0 and not expands:
            break
        slope, grip, turn = way_of(g, mu, w)
        piece = -w / turn if w * turn < 0.0 else math.inf  # of N to where slip ends
        whole = whole_phase(rate, slope, expands, target - work)
        ends = whole <= piece
        piece = min(piece, whole)
        if not piece < math.inf:
            break
        work += piece * (rate + 0.5 * slope * piece)
        pressed += piece
        held += grip * piece
        rate += slope * piece
        w = w + turn * piece if ends else 0.0
        if ends and expands:
            break
        if ends:
            expands, rate, target, work = True, 0.0, -e * e * work, 0.0
    side[F, 0], side[F, 1] = pressed, held
    for r in range(2):
        side[A, r] = side[B, r] + g[r, 0] * pressed + g[r, 1] * held
    return expands or side[B, 0] >= 0.0


@compiled
def as_full_matrix(m, count):
    """Form G of the active contacts as a full matrix, if it is not yet."""
    if m.held[at.SPARSE] == 1.0:
        m.held[at.SPARSE] = 0.0
        fill_delassus(m, count)


@compiled
def sort_contacts(m, count, expands):
    """Sort the active contacts: first those that press or may press, then those that open. Forms their rows of W.

    The responses are formed anew with the rows, and the friction of joints in an impact belongs to them.

    Returns the number of the first.
    """
    active, bounce = m.active, m.bounce
    moving = 0
    for k in range(count):
        n = active[k]
        if bounce[NOW, 2 * n] <= 0.0 or (expands and bounce[WORK, 2 * n + 1] > 0.0):
            active[k], active[moving] = active[moving], n
            moving += 1
    call_problem(m.problem_table[ROWS_OF], (m, count))
    as_full_matrix(m, count)
    if m.dry.shape[0] > 0:
        rub(m, count)
    return moving


@compiled
def lead_of(m, n, expands, left):
    """What drives the impulse of contact n [m/s]: its rate over the rest of compression, or its share in expansion."""
    bounce = m.bounce
    if not expands:
        return bounce[NOW, 2 * n] / left
    return bounce[E, 2 * n] * bounce[BEFORE, 2 * n] if bounce[WORK, 2 * n + 1] > 0.0 else 0.0


@compiled
def growth(m, moving, expands, left):
    """Solve for the rates at which impulses grow; 1 if they grow, 0 at the end of a phase, -1 without a solution.

    left: remaining share of compression.
    """
    active, bounce, side = m.active, m.bounce, m.side
    slide, candidate = m.slide, m.candidate
    drives = False
    for k in range(moving):
        n = active[k]
        lead = lead_of(m, n, expands, left)
        side[B, 2 * k], side[B, 2 * k + 1] = lead, 0.0
        drives = drives or lead < 0.0
        w = bounce[NOW, 2 * n + 1]
        slide[k] = 0 if w == 0.0 else (-1 if w > 0.0 else 1)
        candidate[k] = STICK if slide[k] == 0 and friction_of(m, n) > 0.0 else (BACKWARD if slide[k] < 0 else FORWARD)
    if not drives:
        return 0
    if call_problem(m.problem_table[SEARCH], (m, moving)) <= 0:
        return -1
    for k in range(moving):
        if not expands or (bounce[WORK, 2 * active[k] + 1] > 0.0 and side[F, 2 * k] > 0.0):
            return 1
    return 0


@compiled
def piece_of_one(m, k, moving, expands):
    """Length of the piece along which impulses grow until active contact k changes; its rates of change are in a."""
    bounce, side, n = m.bounce, m.side, m.active[k]
    now, w, rise = bounce[NOW, 2 * n], bounce[NOW, 2 * n + 1], side[A, 2 * k]
    grows = side[F, 2 * k] if k < moving else 0.0
    piece = math.inf
    if k < moving and friction_of(m, n) > 0.0 and w * side[A, 2 * k + 1] < 0.0:
        piece = -w / side[A, 2 * k + 1]
    if now * rise < 0.0 and (k >= moving or not (expands or grows > 0.0)):
        piece = min(piece, -now / rise)
    if expands and k < moving and bounce[WORK, 2 * n + 1] > 0.0 and grows > 0.0:
        rest = bounce[WORK, 2 * n + 1] - bounce[WORK, 2 * n]
        whole = rest / (grows * now) if now > 0.0 else math.inf
        if rise > 0.0:
            whole = (math.sqrt(now * now + 2.0 * rise * max(rest, 0.0) / grows) - now) / rise
        piece = min(piece, whole)
    return piece


@compiled
def piece_of(m, count, moving, expands, left):
    """Length of the piece along which impulses grow until a contact changes; rates of change of contacts go to a."""
    side, g = m.side, m.delassus
    piece = math.inf if expands else left
    for k in range(count):
        for r in range(2 * k, 2 * k + 2):
            side[A, r] = 0.0
            for s in range(2 * moving):
                side[A, r] += g[r, s] * side[F, s]
        piece = min(piece, piece_of_one(m, k, moving, expands))
    return piece


@compiled
def grow(m, count, moving, expands, piece, zero):
    """Let impulses grow by a piece; contacts that have done their work take no further part.

    zero: rates [m/s] below this count as zero.
    """
    active, bounce, side = m.active, m.bounce, m.side
    for k in range(count):
        n = active[k]
        grows = side[F, 2 * k] if k < moving else 0.0
        bounce[WORK, 2 * n] += piece * grows * (bounce[NOW, 2 * n] + 0.5 * side[A, 2 * k] * piece)
        for d in range(2):
            new = bounce[NOW, 2 * n + d] + side[A, 2 * k + d] * piece
            bounce[NOW, 2 * n + d] = new if abs(new) > zero else 0.0
            if k < moving:
                bounce[SO_FAR, 2 * n + d] += piece * side[F, 2 * k + d]
        if expands and bounce[WORK, 2 * n] >= bounce[WORK, 2 * n + 1] * (1.0 - ZERO):
            bounce[WORK, 2 * n + 1] = 0.0


@compiled
def follow_phase(m, count, expands, zero):
    """Compression or expansion of several contacts; False if a problem on the way has no solution."""
    left = 1.0
    for _ in range(20 + 10 * count):
        moving = sort_contacts(m, count, expands)
        status = growth(m, moving, expands, left)
        if status <= 0:
            return status == 0
        piece = piece_of(m, count, moving, expands, left)
        if not piece < math.inf:
            return False
        grow(m, count, moving, expands, piece, zero)
        left -= piece
        if not expands and left <= ZERO:
            return True
    return expands


@compiled
def gives_energy(m, count):
    """True if the impulses of an impact, f in `side`, would create energy; rates before it must be up to date."""
    side, g, kinematics, active = m.side, m.delassus, m.contact_kinematics, m.active
    energy, size = 0.0, 0.0
    for r in range(2 * count):
        n = active[r // 2]
        before = kinematics[n, at.DGAP] if r % 2 == 0 else -kinematics[n, at.SLIP]
        after = before
        for s in range(2 * count):
            after += g[r, s] * side[F, s]
        energy += 0.5 * side[F, r] * (before + after)
        size += abs(side[F, r]) * (abs(before) + abs(after))
    return energy > CREATED * size


@compiled
def follow_phases(m, count):
    """Impulses and rates of several contacts, by compression and expansion; False if there are none."""
    side, bounce, active, largest = m.side, m.bounce, m.active, 0.0
    for k in range(count):
        n = active[k]
        for d in range(2):
            bounce[NOW, 2 * n + d], bounce[SO_FAR, 2 * n + d] = side[B, 2 * k + d], 0.0
            bounce[WORK, 2 * n + d] = 0.0
            largest = max(largest, abs(side[B, 2 * k + d]))
    for k in range(count):
        for r in range(2 * active[k], 2 * active[k] + 2):
            if abs(bounce[NOW, r]) <= ZERO * largest:
                bounce[NOW, r] = 0.0
    if not follow_phase(m, count, False, ZERO * largest):
        return False
    for k in range(count):
        n = active[k]
        e = bounce[E, 2 * n]
        bounce[WORK, 2 * n + 1] = -e * e * min(bounce[WORK, 2 * n], 0.0)
        bounce[WORK, 2 * n] = 0.0
    follow_phase(m, count, True, ZERO * largest)  # at its end no contact approaches, no energy was created
    for k in range(count):
        for d in range(2):
            side[F, 2 * k + d] = bounce[SO_FAR, 2 * active[k] + d]
            side[A, 2 * k + d] = bounce[NOW, 2 * active[k] + d]
    return not gives_energy(m, count)


@kernel("problem")
def path_kernel(m, count):
    """Impulses f of an impact under the energetic law, and rates a after it, from the rates in b; 0: none found."""
    side, active, candidate = m.side, m.active, m.candidate
    if not (follow_path(m) if count == 1 else follow_phases(m, count)):
        return 0
    for k in range(count):
        candidate[k] = OFF
        if side[F, 2 * k] > 0.0:
            candidate[k] = FORWARD if side[A, 2 * k + 1] < 0.0 or friction_of(m, active[k]) == 0.0 else BACKWARD
            if side[A, 2 * k + 1] == 0.0 and friction_of(m, active[k]) > 0.0:
                candidate[k] = STICK
    return 1
