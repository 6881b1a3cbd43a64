"""Set-valued dry friction of joints without play in a run: when it sticks and slips.

Between events every joint keeps its mode.  A step ends at the first instant at which a mode cannot last, as at the
switches of expressions (`state_switches`):

    rate = 0 while it slips          sticks, or slips on, or back
    |tau| = mu_static L              slips against tau

There all joints at rest are decided together: all stick, then the one that is farthest beyond its limit slips against
its tau, until none is; one whose acceleration contradicts its sense sticks again.  If that does not settle, all
combinations are tried, those with most sticking joints first.  For impacts see `nonsmooth.rubbing_impacts`.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import OFF
from rattle.equations.dependent_rows import fixed_value
from rattle.equations.dry_friction import (
    REST,
    along,
    eliminate,
    is_smooth,
    lasting,
    limit,
    mobility,
    plain_row,
    rounding,
    sticking_row,
)
from rattle.equations.motion import solve_motion
from rattle.equations.state import take_states
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.gap_search import NONE
from rattle.solvers.dense_output import HALVINGS, INSTANT, interpolate

PARTS = 16  # pieces of a step that are searched
KEEP = -2
TAKEN = 1e-8  # share of its mobility that is left to a joint that others hold which stick
ROUNDED = 1e-9  # share of its terms below which the acceleration of a held coordinate is rounding
SLIGHT = 1e-5  # share of all rates, or of what a step adds, that the error of an event may leave to joints at rest
AT_ONCE = 1e-12  # share of the time within which two events are one
MOST_TRIED = 8  # joints at rest up to which all combinations are tried
OVER = 1e-11  # share of its limit by which a friction force may exceed it: more than its solution leaves
AGAINST = 1e-12  # share of the effect of a friction force below which an acceleration against its slip is rounding
OF_OTHERS = 1e-14  # share of the effect of all other forces likewise
AGAINST_LOOSE = 1e-6  # the same where joints have just been set free: their accelerations may be rounding


@compiled
def solve_at(m, t, y):
    """The motion at (t [s], y) in the present modes."""
    nq = m.change.shape[0]
    take_states(m, y)
    solve_motion(m, t, y[:nq], y[nq : 2 * nq])
    m.tally[at.EVALUATIONS] += 1


@compiled
def driven_ahead(m, n):
    """`sudden` of a coordinate that the joints and drivers hold, from their rows; 0 if it is rounding."""
    gamma = m.dry_rows[n, at.GAMMA]
    ahead = fixed_value(m, m.dry_reaction, n, at.GAMMA) - gamma
    return select(abs(ahead) > ROUNDED * abs(gamma), ahead, 0.0)


@compiled
def decided(m, t, n):
    """True if joint n is at rest at t [s] and its friction set-valued, so that its mode is open.

    Joints that one driver moves all come to rest at once, each but for its acceleration times the rounding of t.
    """
    rate, least = m.dry_memory[n, at.DRY_RATE], rounding(m, n)
    if m.dry_memory[n, at.DRY_HELD] == 1.0 and m.massless.shape[0] == 0:
        rate = fixed_value(m, m.dry_reaction, n, at.NU)
        least += AT_ONCE * abs(t * driven_ahead(m, n))
    return not is_smooth(m, n) and abs(rate) <= least


@compiled
def sudden(m, n):
    """Acceleration of coordinate n against that of sticking [m/s^2 or rad/s^2]."""
    return along(m, n, m.acceleration, 0) - m.dry_rows[n, at.GAMMA]


@compiled
def bring_to_rest(m, y):
    """Remove what rate is left to coordinates that are to stick, with the least mass-weighted change of the rates."""
    memory, system, response = m.dry_memory, m.dry_system, m.dry_response
    count, nq = memory.shape[0], m.change.shape[0]
    for n in range(count):
        plain_row(m, n)
        system[n, count] = 0.0
        if memory[n, at.DRY_MODE] == at.DRY_STICKS and memory[n, at.DRY_HELD] == 0.0 and m.dry[n, at.DRY_LAW] < 0:
            system[n, count] = memory[n, at.DRY_RATE] / sticking_row(m, n)
    if eliminate(system, count) > 0.0:
        for n in range(count):
            for k in range(nq):
                y[nq + k] -= system[n, count] * response[n, 3 + k]


@compiled
def stay_at_rest(m, t, y):
    """Remove from the rates in y what joints that stick have drifted within the error of the steps."""
    solve_at(m, t, y)
    bring_to_rest(m, y)


@compiled
def violation(m, n, loose):
    """How far the mode of a joint at rest is from being possible, as a share; 0 if it is.

    loose: -1 unless joints have just been set free, whose accelerations may be rounding.
    """
    memory = m.dry_memory
    mode, tau = memory[n, at.DRY_MODE], memory[n, at.DRY_FORCE]
    if memory[n, at.DRY_HELD] == 1.0:  # it moves as it has to, whatever friction does
        return 0.0
    if mode == at.DRY_STICKS:
        most = limit(m, n)
        beyond = abs(tau) - most * (1.0 + OVER)
        return beyond / (abs(tau) + most) if beyond > 0.0 else 0.0
    return 1.0 if sudden(m, n) * mode < -in_doubt(m, n, loose) else 0.0


@compiled
def in_doubt(m, n, loose):
    """Acceleration of joint n that may be rounding, by those that friction and all other forces cause.

    One that a rigid contact holds may bear nothing, and have no friction.
    """
    total, others = 0.0, 0.0
    for o in range(m.dry_memory.shape[0]):
        total += abs(mobility(m, n, o) * m.dry_memory[o, at.DRY_FORCE])
    for i in range(1, m.force.shape[0]):
        for k in range(3):
            others += abs(m.dry_response[n, 3 * i + k] * m.force[i, k])
    return (AGAINST if loose == -1 else AGAINST_LOOSE) * total + OF_OTHERS * others


@compiled
def follow_drivers(m):
    """Joints at rest whose coordinate others hold get the sense in which it is accelerated."""
    memory = m.dry_memory
    for n in range(memory.shape[0]):
        if memory[n, at.DRY_REST] == 1.0 and memory[n, at.DRY_HELD] == 1.0:
            ahead = sudden(m, n) if m.massless.shape[0] > 0 else driven_ahead(m, n)
            memory[n, at.DRY_MODE] = at.DRY_STICKS if abs(ahead) <= REST else math.copysign(1.0, ahead)


@compiled
def settle(m, t, y, loose):
    """Change modes of joints at rest one by one until all are possible; False if that does not end.

    A joint that cannot bear more than its limit bears that, by mu_static, while others still hold it.
    """
    memory = m.dry_memory
    for _ in range(8 * memory.shape[0] + 8):
        solve_at(m, t, y)
        if memory[0, at.DRY_LOCKS] == 0.0 and release(m):
            continue
        worst, who = 0.0, -1
        for n in range(memory.shape[0]):
            wrong = violation(m, n, loose) if memory[n, at.DRY_REST] == 1.0 else 0.0
            if wrong > worst:
                worst, who = wrong, n
        if who < 0:
            return memory[0, at.DRY_LOCKS] == 0.0
        if memory[who, at.DRY_MODE] == at.DRY_STICKS:
            memory[who, at.DRY_MODE] = -math.copysign(1.0, memory[who, at.DRY_FORCE])
            memory[who, at.DRY_FIRM] = 1.0
        else:
            memory[who, at.DRY_MODE], memory[who, at.DRY_FIRM] = at.DRY_STICKS, 0.0
    return False


@compiled
def release(m):
    """Let joints at their limits slip that those which stick do not hold; False if there are none."""
    memory, some = m.dry_memory, False
    for n in range(memory.shape[0]):
        firm = memory[n, at.DRY_REST] == 1.0 and memory[n, at.DRY_FIRM] == 1.0
        if firm and not held_by_others(m, n):
            memory[n, at.DRY_FIRM], some = 0.0, True
    return some


@compiled
def held_by_others(m, n):
    """True if joint n can move only as long as others do that stick: those take all of its mobility."""
    memory, system, count = m.dry_memory, m.dry_system, m.dry_memory.shape[0]
    for o in range(count):
        plain_row(m, o)
        system[o, count] = 0.0
        if memory[o, at.DRY_MODE] == at.DRY_STICKS and memory[o, at.DRY_HELD] == 0.0 and m.dry[o, at.DRY_LAW] < 0:
            system[o, count] = mobility(m, o, n) / sticking_row(m, o)
    eliminate(system, count)
    left = mobility(m, n, n)
    for o in range(count):
        left -= mobility(m, n, o) * system[o, count]
    return left <= TAKEN * mobility(m, n, n)


@compiled
def take_combination(m, code):
    """Combination number `code` of modes of the joints at rest that nothing holds; returns how many of them slip."""
    memory, slipping = m.dry_memory, 0
    for n in range(memory.shape[0]):
        if memory[n, at.DRY_REST] == 1.0 and memory[n, at.DRY_HELD] == 0.0:
            digit = code % 3
            code //= 3
            memory[n, at.DRY_MODE] = -1.0 if digit == 2 else float(digit)
            memory[n, at.DRY_FIRM] = 1.0 if digit > 0 else 0.0
            slipping += 1 if digit > 0 else 0
    return slipping


@compiled
def all_possible(m, loose):
    """True if the modes of all joints at rest are possible; loose: see `violation`."""
    memory = m.dry_memory
    possible = memory[0, at.DRY_LOCKS] == 0.0
    for n in range(memory.shape[0]):
        possible = possible and (memory[n, at.DRY_REST] == 0.0 or violation(m, n, loose) == 0.0)
    return possible


@compiled
def try_all(m, t, y, loose):
    """Try all combinations of modes of the joints at rest, those with fewest that slip first; False if none is one."""
    memory = m.dry_memory
    free, most = 0, 1
    for n in range(memory.shape[0]):
        if memory[n, at.DRY_REST] == 1.0 and memory[n, at.DRY_HELD] == 0.0:
            free += 1
            most *= 3
    if free > MOST_TRIED:
        return False
    for slipping in range(free + 1):
        for code in range(most):
            if take_combination(m, code) != slipping:
                continue
            solve_at(m, t, y)
            if release(m):
                solve_at(m, t, y)
            if all_possible(m, loose):
                return True
    return False


@compiled
def come_to_rest(m, t, y):
    """Bring joints at rest to rest exactly, and find others that are with them; the error of an event moves them on.

    Where that changes the motion itself, as near a dead centre, which only one joint reaches at rest, nothing is done.
    """
    memory, trial, nq = m.dry_memory, m.stage, m.change.shape[0]
    for k in range(y.shape[0]):
        trial[k] = y[k]
    for n in range(memory.shape[0]):
        if memory[n, at.DRY_REST] == 1.0:
            memory[n, at.DRY_MODE] = at.DRY_STICKS
    bring_to_rest(m, trial)
    change, size = 0.0, 0.0
    for k in range(nq):
        i, c = 1 + k // 3, k % 3
        gained = m.clock[at.H] * m.acceleration[i, c]
        change += (trial[nq + k] - y[nq + k]) ** 2 / m.weight[i, c]
        size += (y[nq + k] ** 2 + gained * gained) / m.weight[i, c]
    if not change <= SLIGHT * SLIGHT * size:
        return
    for k in range(nq):
        y[nq + k] = trial[nq + k]
    solve_at(m, t, y)
    for n in range(memory.shape[0]):
        memory[n, at.DRY_REST] = 1.0 if memory[n, at.DRY_REST] == 1.0 or decided(m, t, n) else 0.0


@compiled
def noted(m, n):
    """Mode of joint n as it is noted: three times as large while it rests at its limit."""
    mode = m.dry_memory[n, at.DRY_MODE]
    return 3.0 * mode if m.dry_memory[n, at.DRY_FIRM] == 1.0 else mode


@compiled
def shown(mode):
    """A noted mode as it is told: a joint that rests at its limit sticks."""
    return at.DRY_STICKS if abs(mode) > at.DRY_AUTO else mode


@compiled
def note_modes(m, t, who):
    """Note the modes before a decision, and which joints are at rest at t [s]; who: the joint that leaves its mode."""
    memory = m.dry_memory
    for n in range(memory.shape[0]):
        memory[n, at.DRY_BEFORE] = noted(m, n)
        memory[n, at.DRY_REST] = 1.0 if (n == who and memory[n, at.DRY_HELD] == 0.0) or decided(m, t, n) else 0.0


@compiled
def first_modes(m, t, who):
    """Modes from which a decision starts: joints at rest stick, others slip as they move, some keep theirs."""
    memory = m.dry_memory
    for n in range(memory.shape[0]):
        rests, before = memory[n, at.DRY_REST] == 1.0, memory[n, at.DRY_BEFORE]
        memory[n, at.DRY_FIRM] = 0.0
        begins = n != who and before != at.DRY_AUTO and t - memory[n, at.DRY_SINCE] <= AT_ONCE * abs(t)
        kept = begins or (who == KEEP and shown(before) == at.DRY_STICKS)
        if m.dry[n, at.DRY_LAW] < 0 and rests and kept:
            firm = begins and abs(before) > at.DRY_AUTO
            memory[n, at.DRY_MODE] = math.copysign(1.0, before) if firm else shown(before)
            memory[n, at.DRY_FIRM] = 1.0 if firm else 0.0
        elif m.dry[n, at.DRY_LAW] < 0:
            memory[n, at.DRY_MODE] = at.DRY_STICKS if rests else math.copysign(1.0, memory[n, at.DRY_RATE])


@compiled
def note_decision(m, t, told):
    """Note since when joints slip, and whose force is not determined; told: 1 to record stick and slip as events."""
    memory = m.dry_memory
    for n in range(memory.shape[0]):
        sticks = memory[n, at.DRY_MODE] == at.DRY_STICKS
        if memory[n, at.DRY_REST] == 1.0 and sticks and memory[n, at.DRY_HELD] == 1.0:
            memory[n, at.DRY_UNSURE] = 1.0
        if memory[n, at.DRY_REST] == 1.0 and not sticks:
            memory[n, at.DRY_SINCE] = t
        memory[n, at.DRY_REST], memory[n, at.DRY_OVER] = 0.0, 0.0
        if told == 1:
            tell(m, t, n)


@compiled
def breaking_force(m, n):
    """Friction that joint n does not bear any more: of the sense that it was found with where it is rounding here."""
    memory = m.dry_memory
    sought = memory[n, at.DRY_SOUGHT]
    return memory[n, at.DRY_FORCE] if sought == 0.0 or abs(memory[n, at.DRY_FORCE]) > limit(m, n) else sought


@native("i", "h", "f", "v", "i", "i")
def decide(m, t, y, who, told):
    """Modes of all joints at (t [s], y), whose rates are brought to rest where they stick; False if there are none.

    who: the joint whose mode cannot last (-1: none); KEEP: joints that begin to slip just now go on.
    told: 1 to record stick and slip as events.
    """
    memory = m.dry_memory
    breaks = who >= 0 and memory[who, at.DRY_MODE] == at.DRY_STICKS and memory[who, at.DRY_HELD] == 0.0
    solve_at(m, t, y)
    sense = -math.copysign(1.0, breaking_force(m, who)) if breaks else 0.0
    note_modes(m, t, who)
    come_to_rest(m, t, y)
    first_modes(m, t, who)
    solve_at(m, t, y)
    follow_drivers(m)
    if breaks:
        memory[who, at.DRY_MODE], memory[who, at.DRY_FIRM] = sense, 1.0
    loose = who if breaks or who == KEEP else -1
    settled = settle(m, t, y, loose) or try_all(m, t, y, loose)
    bring_to_rest(m, y)  # those that stick: near a dead centre the others would have to lose all rates
    solve_at(m, t, y)
    note_decision(m, t, told)
    if modes_changed(m):
        wake_contacts(m)
    return settled


@compiled
def wake_contacts(m):
    """Let closed contacts that were idle bear again, and look at slips that were none: what held them may slip now."""
    for n in range(m.mode.shape[0]):
        if m.mode[n] != OFF:
            m.contact_memory[n, at.IDLE], m.contact_memory[n, at.NO_SLIP] = 0.0, 0.0


@compiled
def modes_changed(m):
    """True if the last `decide` has changed a mode."""
    memory, changed = m.dry_memory, False
    for n in range(memory.shape[0]):
        changed = changed or shown(noted(m, n)) != shown(memory[n, at.DRY_BEFORE])
    return changed


@compiled
def tell(m, t, n):
    """Record that joint n sticks, or that it has begun to slip."""
    events, tally, memory = m.events, m.tally, m.dry_memory
    mode, before, k = shown(noted(m, n)), shown(memory[n, at.DRY_BEFORE]), tally[at.EVENT_COUNT]
    if mode == before or m.dry[n, at.DRY_LAW] >= 0 or k >= events.shape[0]:
        return
    c = m.dry[n, at.DRY_SECOND]
    if m.dry[n, at.DRY_FORM] == at.DRY_ROLLER and m.contact[c, at.IMPACT] == 1 and m.mode[c] == OFF:
        return  # a disc in the air rolls on nothing
    for column in range(events.shape[1]):
        events[k, column] = 0.0
    events[k, at.EVENT_T] = t
    events[k, at.EVENT_CONTACT] = m.contact.shape[0] + n
    events[k, at.EVENT_KIND] = at.STICK_EVENT if mode == at.DRY_STICKS else at.SLIP_EVENT
    tally[at.EVENT_COUNT] = k + 1


@compiled
def any_over(m):
    """True if a mode could not last at an instant since the last call."""
    memory, over = m.dry_memory, False
    for n in range(memory.shape[0]):
        over = over or memory[n, at.DRY_OVER] == 1.0
        memory[n, at.DRY_OVER] = 0.0
    return over


@compiled
def past(m, n):
    """True where the event sought of joint n is over: it slips backwards, or sticks beyond its limit.

    Only of joints whose event was found: one that others keep at rest while it slips has a rate of rounding.
    """
    memory = m.dry_memory
    if memory[n, at.DRY_SOUGHT] == 0.0:
        return False
    if memory[n, at.DRY_MODE] != at.DRY_STICKS and memory[n, at.DRY_MODE] != at.DRY_AUTO:
        return not is_smooth(m, n) and memory[n, at.DRY_MODE] * memory[n, at.DRY_RATE] < 0.0
    return lasting(m, n) < 0.0


@compiled
def look(m, t, h, share):
    """The motion at a share of the step from t [s] of length h [s]."""
    interpolate(m, share, m.stage)
    solve_at(m, t + share * h, m.stage)


@compiled
def seek_changes(m):
    """Note which joints have a mode that cannot last at the motion at hand; True if there are any."""
    over = False
    for n in range(m.dry_memory.shape[0]):
        m.dry_memory[n, at.DRY_SOUGHT] = 1.0 if lasting(m, n) < 0.0 else 0.0
        over = over or m.dry_memory[n, at.DRY_SOUGHT] == 1.0
    return over


@compiled
def locate_change(m, t, h, low, right):
    """Share of the step between low and right at which the first mode sought cannot last, and the joint.

    The sense of its force there is kept: the instant may be the start of the step, where the force is none yet.
    """
    high, who, count = right, -1, m.dry_memory.shape[0]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high or (high - low) * h <= INSTANT * abs(t):
            break
        look(m, t, h, middle)
        changed = False
        for n in range(count):
            changed = changed or past(m, n)
        if changed:
            high = middle
        else:
            low = middle
    look(m, t, h, high)
    for n in range(count):
        if who < 0 and (past(m, n) or (high == right and lasting(m, n) < 0.0)):
            who = n
            m.dry_memory[n, at.DRY_SOUGHT] = math.copysign(1.0, m.dry_memory[n, at.DRY_FORCE])
    return high, who


@native("fi", "h", "f", "f", "f", "f")
def first_change_of_modes(m, t, h, until, left):
    """Share of the step from `left` to `until` at which the first mode cannot last (NONE if all do), and the joint.

    Needs the dense output.
    """
    for part in range(1, PARTS + 1):
        right = part / PARTS
        if left >= until:
            break
        if right <= left:
            continue
        look(m, t, h, right)
        if seek_changes(m):
            return locate_change(m, t, h, left, right)
        left = right
    return NONE, -1
