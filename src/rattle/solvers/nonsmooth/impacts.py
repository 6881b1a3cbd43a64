"""Impacts of set-valued contacts: impulses, energy lost, and the end of infinite sequences of impacts.

A bounce that would rise less than LOW clearances (of a stop: of its range), or less than the rounding of its gap
(4e-15 of the size of the mechanism, more where coordinates or angles are large), is not followed: restitution is taken
as zero, and the contact counts as closed from the end of the geometric series of bounces on,
t + 2 v / (|g''| (1 - e)).  In a clearance of 1 mm such a bounce has a few 1e-6 m/s.

The same holds if one contact lifts because another one hits, as under a rocking block: one that would rise less
is held down, and its rate is lost like that of a bounce.  The intervals d between impacts of a contact shrink
geometrically there too, by a ratio that follows from the last two of them, so that the sequence ends at
t + d r / (1 - r), r = d / (the d before).
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import BACKWARD, FORWARD, OFF, OTHER, STICK, A, B, F, friction_of
from rattle.equations.compliant import locate_contacts
from rattle.equations.motion import OK, constraints, place
from rattle.equations.state import IMPULSE, LOSS, WORK, account_at, energies_at
from rattle.equations.unilateral import (
    CHAIN,
    EXPAND,
    NOT_FOUND,
    NOT_UNIQUE,
    TRACE,
    add_forces,
    along,
    approach,
    contact_rows,
    count_solutions,
    ending,
    floor_of_rates,
    is_rough,
    lasting_side,
    reach,
    shift,
    solve_contacts,
    solve_modes,
    velocity_scale,
)
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.families import call_problem
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.clutches import takes_impulses
from rattle.solvers.contacts.event_rows import note_impact
from rattle.solvers.contacts.gap_search import rounding
from rattle.solvers.contacts.penetration import scale_of
from rattle.solvers.nonsmooth.contact_projection import STILL, at_rest, at_wall, motion_without
from rattle.solvers.nonsmooth.impact_path import BEFORE, E
from rattle.solvers.nonsmooth.impact_phases import ENERGETIC, LZB, NEWTON, law_of
from rattle.solvers.nonsmooth.rubbing_impacts import (
    AGREES,
    MOST_ROUNDS,
    add_rubbing,
    begin_rubbing,
    book_rubbing,
    change_rubbing,
    combinations_of_rubbing,
    rate_alone,
    rub,
    take_rubbing,
    take_rubbing_modes,
    total_rubbing,
)
from rattle.solvers.ports import add_port_work

NOTICED = 1e-11  # share of the largest impulse of an impact below which one is rounding and no event
AHEAD = 1e-6  # share of the rates of its bodies, or rate [rad/s], up to which a clutch takes without an impact
LOW = 1e-11  # bounces that rise less than this share of the scale of the gap are not followed
LOW_OF_GAP = 4e-15  # the same, as a share of the typical size of the gap: its rounding


@compiled
def gather_touching(m, who):
    """Contacts that touch, contact `who` (-1: none) included, and take impulses become active. Returns their number."""
    contact, count = m.contact, 0
    for n in range(contact.shape[0]):
        touches = contact[n, at.IMPACT] == 1 and (n == who or m.mode[n] != OFF or at_wall(m, n))
        if touches and takes_impulses(m, n):
            m.active[count] = n
            m.contact_memory[n, at.BOUNCES_END] = 0.0
            count += 1
    return count


@native("i", "h", "f", "v", "i")
def collide(m, t, y, who):
    """Impact at (t [s], y): contact `who` and all others that are closed, in one problem; rates in y jump.

    Bounces that are too low to follow get restitution 0.  Returns OK, NO_SOLUTION, NOT_FOUND or NOT_UNIQUE.
    """
    nq = m.change.shape[0]
    v, before = y[nq : 2 * nq], m.rate_new
    count = gather_touching(m, who)
    for k in range(count):
        m.contact_memory[m.active[k], at.ROUNDING] = 0.0
    for c in range(nq):
        before[c] = v[c]
    for _ in range(2 * count + 1):
        contact_rows(m, count)
        if m.dry.shape[0] > 0:
            begin_rubbing(m)
        status = percussions(m, count)
        if status == OK and m.dry.shape[0] > 0:
            status = rubbing_percussions(m, count)
        if status != OK:
            return status
        note_terms(m, count)
        press_down(m, count)
        shift(m, count, v, -1.0)
        if m.dry.shape[0] > 0:
            add_rubbing(m, v)
        if not low_bounce(m, t, y, count):
            break
        for c in range(nq):
            v[c] = before[c]
        motion_without(m, t, y)
    # rows and kinematics are those of the rates before the impact again, to compute its impulses and losses
    count_impulses(m, t, y, count, before)
    if m.dry.shape[0] > 0:
        book_rubbing(m, y, before)
    return OK


@compiled
def rub_in_modes(m, count):
    """`percussions` with the friction of joints in their present modes; a status."""
    for turn in range(MOST_ROUNDS):
        contact_rows(m, count)
        rub(m, count)
        status = percussions(m, count)
        if status != OK:
            return status
        if take_rubbing(m, count) <= AGREES and turn > 0:
            break
    return OK


@compiled
def rubbing_percussions(m, count):
    """`percussions` with the friction of joints, from those without it; a status."""
    take_rubbing(m, count)
    for _ in range(4 * m.dry.shape[0] + 4):
        status = rub_in_modes(m, count)
        if status != OK or not change_rubbing(m, count):
            break
        status = NOT_FOUND
    if status == OK:
        return OK
    for code in range(combinations_of_rubbing(m)):
        take_rubbing_modes(m, code)
        if rub_in_modes(m, count) == OK and not change_rubbing(m, count):
            return OK
    return status


@compiled
def rates_before(m, count, law, first, end):
    """b of an impact [m/s] from the rates before it in `contact_kinematics`, times 1 + e under Newton's law.

    Active contacts from `first` up to before `end` may not bounce: their e is zero.
    """
    contact, kinematics, memory, values = m.contact, m.contact_kinematics, m.contact_memory, m.values
    active, candidate, slide, side, bounce = m.active, m.candidate, m.slide, m.side, m.bounce
    floor_of_rates(m)
    for k in range(count):
        n, p = active[k], contact[active[k], at.NORMAL_P]
        memory[n, at.ROUNDING] = max(velocity_scale(m, 2 * k, n), velocity_scale(m, 2 * k + 1, n))
        rate = approach(m, k, n)
        hits = rate < -STILL * memory[n, at.ROUNDING]
        bounces = memory[n, at.BOUNCES_END] == 0.0 and not first <= k < end
        bounce[E, 2 * n] = values[p + at.RESTITUTION] if bounces else 0.0
        bounce[BEFORE, 2 * n] = rate if hits else 0.0
        e, e_t = (
            (bounce[E, 2 * n], values[p + at.TANGENTIAL_RESTITUTION])
            if law == NEWTON and hits and not first <= k < end
            else (0.0, 0.0)
        )
        side[B, 2 * k], side[B, 2 * k + 1] = (1.0 + e) * rate, -(1.0 + e_t) * kinematics[n, at.SLIP]
        if m.dry.shape[0] > 0:
            for r in range(2 * k, 2 * k + 2):
                alone, size = rate_alone(m, r, n), abs(side[B, r])
                side[B, r] -= alone
                if abs(side[B, r]) <= STILL * (size + abs(alone)):
                    side[B, r] = 0.0
        slide[k] = 0
        candidate[k] = STICK if friction_of(m, n) > 0.0 else FORWARD


@compiled
def clip_restitution(m, count):
    """Solve an impact without the rebounds that other contacts forbid, as a backstop does; False if it has no solution.

    Newton's law asks for g'+ = -e g'- whatever the others allow.  One contact after the other is tried without rebound,
    then ever more of them together.
    """
    for k in range(2 * count):
        rates_before(m, count, NEWTON, k if k < count else 0, k % count + 1)
        if solve_contacts(m, count):
            return True
    return False


@compiled
def percussions(m, count):
    """Impulses [N s] of the active contacts by their restitution law; returns a status as `collide` does."""
    law = law_of(m, m.active[0])
    rates_before(m, count, law, 0, 0)
    if law == ENERGETIC or (law == LZB and count == 1):  # of one contact both are the same
        if call_problem(m.problem_table[TRACE], (m, count)) > 0:
            return OK
        rates_before(m, count, law, 0, 0)
    if law == LZB:
        return OK if call_problem(m.problem_table[CHAIN], (m, count)) > 0 else NOT_FOUND
    if not solve_contacts(m, count) and not (law == NEWTON and clip_restitution(m, count)):
        return ending(m)
    if is_rough(m, count) and count_solutions(m, count) > 1:
        return NOT_UNIQUE
    if law != NEWTON and call_problem(m.problem_table[EXPAND], (m, count)) == 0:
        return NOT_FOUND
    return OK


@compiled
def note_terms(m, count):
    """Add what the impulses change, each by itself, to the magnitudes relative to which rates have rounding.

    In a row of contacts a body at rest gets impulses from both sides: what they leave of each other is rounding, though
    the rates are zero before and after the impact.
    """
    side, dv, w, weight, response = m.side, m.velocity_change, m.contact_jacobian, m.weight, m.velocity_response
    contact, active, memory, sparse = m.contact, m.active, m.contact_memory, m.held[at.SPARSE] == 1.0
    for i in range(dv.shape[0]):
        for q in range(3):
            dv[i, q] = 0.0
    for r in range(2 * count):
        f = abs(side[F, r])
        if f == 0.0:
            continue
        if sparse:
            a, b = contact[active[r // 2], at.A_BODY], contact[active[r // 2], at.B_BODY]
            for q in range(3):
                dv[a, q] += abs(weight[a, q] * w[r, q]) * f
                dv[b, q] += abs(weight[b, q] * w[r, 3 + q]) * f
            continue
        for i in range(1, dv.shape[0]):
            for q in range(3):
                dv[i, q] += abs(response[r, 3 * i - 3 + q]) * f
    for k in range(count):
        n = active[k]
        for r in range(2 * k, 2 * k + 2):
            memory[n, at.ROUNDING] = max(memory[n, at.ROUNDING], reach(m, r, n, dv, 0))


@compiled
def press_down(m, count):
    """Add the impulses that keep contacts marked as closed from lifting.

    Contacts that stay closed keep zero rates meanwhile; the change removes energy, because these rates are zero after
    it.
    """
    memory, active, candidate, side, bounce = m.contact_memory, m.active, m.candidate, m.side, m.bounce
    lifts = False
    for k in range(count):
        n = active[k]
        closed, parts = memory[n, at.BOUNCES_END] != 0.0, side[A, 2 * k]
        if law_of(m, n) == NEWTON:
            parts -= bounce[E, 2 * n] * bounce[BEFORE, 2 * n]
        lifts = lifts or (closed and parts > 0.0)
        for r in range(2 * k, 2 * k + 2):
            side[OTHER, r] = side[F, r]
        stays = side[F, 2 * k] > 0.0 and parts <= STILL * memory[n, at.ROUNDING]
        side[B, 2 * k], side[B, 2 * k + 1] = parts if closed else 0.0, 0.0
        if closed or stays:
            candidate[k] = STICK if candidate[k] == STICK and stays else FORWARD
        else:
            candidate[k] = OFF
    if not lifts:
        return
    solve_modes(m, count, 0)
    for r in range(2 * count):
        side[F, r] += side[OTHER, r]


@compiled
def stay_together(m, count):
    """Forces [N] after an impact of the active contacts that neither open nor would have to pull; see `solve_modes`."""
    kinematics, memory, active = m.contact_kinematics, m.contact_memory, m.active
    candidate, side = m.candidate, m.side
    for k in range(count):
        n = active[k]
        candidate[k] = OFF
        if at_rest(m, 2 * k, n, kinematics[n, at.DGAP], memory[n, at.ROUNDING]):
            candidate[k] = STICK
            if friction_of(m, n) == 0.0 or not at_rest(m, 2 * k + 1, n, kinematics[n, at.SLIP], memory[n, at.ROUNDING]):
                candidate[k] = FORWARD if kinematics[n, at.SLIP] >= 0.0 else BACKWARD
    lasting_side(m, count)
    for _ in range(count):
        solve_modes(m, count, 1)
        pulls = False
        for k in range(count):
            if side[F, 2 * k] < 0.0:
                candidate[k] = OFF
                pulls = True
        if not pulls:
            break


@compiled
def rises(m, k, n):
    """True if active contact n, the k-th, opens after an impact; its rate may be rounding of the rates before that.

    Such a rate over the acceleration, which is rounding too, would be any time.
    """
    rate = m.contact_kinematics[n, at.DGAP]
    return rate > 0.0 and not at_rest(m, 2 * k, n, rate, m.contact_memory[n, at.ROUNDING])


@compiled
def force_afterwards(m, t, y, count):
    """The motion after the impact, with the forces that press then; impulses stay in `side`."""
    side = m.side
    motion_without(m, t, y)
    for r in range(2 * count):
        side[OTHER, r] = side[F, r]
    stay_together(m, count)
    add_forces(m, count, m.acceleration, m.multiplier)
    for r in range(2 * count):
        side[F, r] = side[OTHER, r]


@compiled
def low_pull(m, k, n):
    """Acceleration that brings contact n, the k-th active one, back from a bounce too low to follow; 0: none."""
    if m.contact[n, at.LEVEL] == 1 or m.contact_memory[n, at.BOUNCES_END] != 0.0 or not rises(m, k, n):
        return 0.0
    least = max(LOW * scale_of(m, n), LOW_OF_GAP * m.lever[n, at.GAP_SIZE], rounding(m, n))
    speed, pull = m.contact_kinematics[n, at.DGAP], m.contact_kinematics[n, at.GAMMA_N]
    pull -= along(m, 2 * k, n, m.acceleration, 0)
    return pull if pull < 0.0 and speed * speed < -2.0 * pull * least else 0.0


@compiled
def end_of_series(m, t, n, came, pull):
    """Time [s] at which the bounces of contact n end that follow an impact at the speed `came` [m/s]."""
    speed, e = m.contact_kinematics[n, at.DGAP], m.values[m.contact[n, at.NORMAL_P] + at.RESTITUTION]
    if law_of(m, n) != NEWTON:
        e = min(speed / came, 1.0)
    m.tally[at.SERIES] += 1 if 0.0 < e < 1.0 else 0
    return t + (2.0 * speed / (-pull * (1.0 - e)) if e < 1.0 else 0.0)


@compiled
def end_together(m, t, count, end):
    """Bounces of contacts that press each other up end together, at `end` [s] or as the series of impacts tells."""
    memory, active, side, recent = m.contact_memory, m.active, m.side, m.recent
    m.tally[at.SERIES] += 1
    for k in range(count):
        n = active[k]
        last, before = t - recent[n, at.LAST_IMPACT], recent[n, at.LAST_IMPACT] - recent[n, at.IMPACT_BEFORE]
        if side[F, 2 * k] > 0.0 and last < before < math.inf:
            end = max(end, t + last * last / (before - last))
    for k in range(count):
        n = active[k]
        if memory[n, at.BOUNCES_END] != 0.0 or (side[F, 2 * k] > 0.0 and not rises(m, k, n)):
            memory[n, at.BOUNCES_END] = end


@native("i", "h", "f", "v", "i")
def low_bounce(m, t, y, count):
    """Mark contacts that rise after the impact, but too low to follow; True if there is a new one."""
    memory, any_low, lifted, end = m.contact_memory, False, False, t
    force_afterwards(m, t, y, count)
    for k in range(count):
        n = m.active[k]
        pull, came = low_pull(m, k, n), -m.bounce[BEFORE, 2 * n]
        if pull == 0.0:
            continue
        any_low = True
        if m.side[F, 2 * k] > 0.0 and came > 0.0:
            memory[n, at.BOUNCES_END] = end_of_series(m, t, n, came, pull)
        else:
            lifted = True
            end = max(end, t - 2.0 * m.contact_kinematics[n, at.DGAP] / pull)
            memory[n, at.BOUNCES_END] = end
    if lifted:
        end_together(m, t, count, end)
    return any_low


@compiled
def count_impulses(m, t, y, count, before):
    """Add impulses [N s], losses and work [J] of an impact to y, and record its events.

    y holds the rates after the impact, `before` (3 nb,) [m/s, rad/s] those before it.
    """
    multiplier, work, rows = m.multiplier, 0.0, m.rows
    rates_of_contacts(m, y, count, before)
    for row in range(multiplier.shape[0]):
        multiplier[row] = 0.0
    add_forces(m, count, m.acceleration, multiplier)
    if m.dry.shape[0] > 0:
        total_rubbing(m, count, multiplier)
    for row in range(multiplier.shape[0]):
        work -= multiplier[row] * rows[row, at.NU]
    y[energies_at(m) + WORK] += work
    nq = m.change.shape[0]
    add_port_work(m, count, multiplier, before, y[nq : 2 * nq])
    book_impulses(m, t, y, count)


@compiled
def rates_of_contacts(m, y, count, before):
    """Store the rates of gaps and slips [m/s] for the rates `before` (3 nb,), for `book_impulses`."""
    kinematics, memory, active, nq = m.contact_kinematics, m.contact_memory, m.active, m.change.shape[0]
    place(m, y[:nq], before[:nq])
    constraints(m)
    locate_contacts(m)
    for k in range(count):
        n = active[k]
        memory[n, at.RATE_BEFORE], memory[n, at.SLIP_BEFORE] = kinematics[n, at.DGAP], kinematics[n, at.SLIP]


@compiled
def hits_hard(m, n):
    """True if A was ahead of B in clutch n before an impact, by more than the error of a step."""
    a, b = m.contact[n, at.A_BODY], m.contact[n, at.B_BODY]
    return -m.contact_memory[n, at.RATE_BEFORE] > AHEAD * (abs(m.body[a, at.W]) + abs(m.body[b, at.W]) + 1.0)


@compiled
def book_impulses(m, t, y, count):
    """Add impulses [N s] and losses [J] of the active contacts to y, and record events; needs `rates_of_contacts`."""
    kinematics, memory, active, side, recent = m.contact_kinematics, m.contact_memory, m.active, m.side, m.recent
    contact = m.contact
    nq, largest = m.change.shape[0], 0.0
    place(m, y[:nq], y[nq : 2 * nq])
    constraints(m)
    locate_contacts(m)
    for k in range(count):
        largest = max(largest, side[F, 2 * k])
    for k in range(count):
        n = active[k]
        pressed, held = side[F, 2 * k], side[F, 2 * k + 1]
        if pressed == 0.0 and held == 0.0:
            continue
        lost = 0.5 * (
            held * (memory[n, at.SLIP_BEFORE] + kinematics[n, at.SLIP])
            - pressed * (memory[n, at.RATE_BEFORE] + kinematics[n, at.DGAP])
        )
        account = account_at(m, n)
        y[account + IMPULSE] += pressed
        y[account + LOSS] += lost
        if pressed <= NOTICED * largest or (
            contact[n, at.LEVEL] == 1 and not hits_hard(m, n)
        ):  # held down, or rounding
            continue
        recent[n, at.IMPACT_BEFORE] = recent[n, at.LAST_IMPACT]
        recent[n, at.LAST_IMPACT] = t
        memory[n, at.SPEED] = max(-memory[n, at.RATE_BEFORE], 0.0)
        note_impact(m, n, t, memory[n, at.SPEED], pressed, lost)
