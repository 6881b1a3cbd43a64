"""Moreau-Jean time stepping: contacts as percussions over a step, no events to locate.

    q_M  = q + h/2 v                                 contacts with g(q_M) <= 0 take part
    v_M  = v + h/2 (change of v in the step before)  for the forces
    M (v+ - v) = h Q(q_M, v_M, t_M) - Phi_q^T Lambda - W P,   Phi_q v+ = nu
    0 <= g'+ + e_N g'-,  0 <= P_N,  complementary;   P_T in -mu P_N Sgn(-(u_t+ + e_T u_t-))
    q+   = q_M + h/2 v+

The contact problem is solved by `unilateral.solve_contacts`, started from the modes of the step before.  A bounce takes
its approach speed where it hits, at the time that g(q_M) says, and the motion without contact before and after it.
Then positions are corrected with the least mass-weighted change: a contact that hit at the depth d, having come with
v- and leaving with v+, by d (1 + v+/v-), which it lost by turning too late; lasting contacts onto the wall; the
joints.  The force of a contact is its percussion divided by h.

The order is one where contacts close, and the energy balance closes to O(h).  An approach counts as an impact, with
restitution and as an event, when it is faster than what two steps of free motion bring about; a contact lasts from
LASTING pressed steps in a row on and ends with as many free ones.

Source: Jean, The non-smooth contact dynamics method, Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257; Moreau,
Unilateral contact and dry friction in finite freedom dynamics (1988); position correction as in Acary, Projected
event-capturing time-stepping schemes for nonsmooth mechanical systems, ibid. 256 (2013) 224-250.
"""

from __future__ import annotations

import math

from rattle.equations.complementarity import FORWARD, OFF, STICK, A, B, F, friction_of
from rattle.equations.compliant import touch_all
from rattle.equations.motion import (
    DONE,
    NOT_FINITE,
    PAUSED,
    accelerate,
    constraints,
    correct,
    drive,
    loads,
    place,
    rate_residual,
    residual,
)  # fmt: skip
from rattle.equations.schur import factorise
from rattle.equations.unilateral import along, contact_rows, ending, push_all, shift, solve_contacts, solve_modes
from rattle.jit.functions import compiled, native
from rattle.jit.layout import (
    CLOSED,
    CONTACT_EVENT,
    DGAP,
    DGAP_1,
    GAMMA_N,
    GAP,
    GAP_1,
    IMPACT_EVENT,
    IMPULSE_0,
    LOSS_0,
    N_0,
    N_1,
    NORMAL,
    NORMAL_P,
    NU,
    OPEN,
    PEAK,
    RELEASE_EVENT,
    SHAPE_P,
    SHUT,
    SINCE,
    SLIP,
    SLIP_EVENT,
    SPEED,
    STEPS_IN,
    STICK_EVENT,
    TANGENT,
    VX,
)  # fmt: skip
from rattle.jit.workspace import (
    ACCELERATION,
    AUDIT,
    BODY,
    CALLED,
    CHANGE,
    CHOSEN,
    CLOCK,
    CONTACT,
    EVENTS,
    GRIP,
    MODE,
    MULTIPLIER,
    POWER,
    PUSHED,
    RATE,
    ROWS,
    SIDE,
    SIGN,
    SLIDE,
    STAGE,
    STATE,
    STATE_NEW,
    TALLY,
    TOUCH,
    TRIAL,
    VALUES,
    imat,
    ivec,
    mat,
    vec,
)  # fmt: skip
from rattle.solvers.gap_search import ESCAPED, deepest
from rattle.solvers.nonsmooth.contact_projection import note
from rattle.solvers.output_row import write
from rattle.solvers.peaks import START, add_step, gauge
from rattle.solvers.step_audit import STARTED, SUNK, UNSOUND, note_drift, stands
from rattle.solvers.step_loop import (
    DRIFT_ROW,
    EVALUATIONS,
    EVENT_COUNT,
    FOUND,
    H_MIN,
    OUTPUTS,
    STEPS,
    TROUBLE,
    H,
    T,
    cross_at_once,
    project,
)  # fmt: skip

ACTIVE = 1e-8  # share of the clearance within which a contact takes part
# columns of `grip` as they are used here: 1 for an impact, its tangential restitution, the rate of the gap that it is
# to leave with, by how much its gap comes out too small
HITS, E_T, AFTER, SHIFT = N_0, N_1, DGAP_1, GAP_1
KEPT = 1e-4  # the same for one that pressed in the step before: curved paths part by O(h^2) without letting go
LASTING = 3  # steps in a row after which a contact counts as lasting, or as released


@native("void", "h", "f")
def start(m, t):
    """Bring the start onto its constraints."""
    y, sign = vec(m, STATE), vec(m, SIGN)
    project(m, t, y)
    touch_all(m)
    for n in range(sign.shape[0]):  # what the first step finds
        sign[n] = 1.0
    for n in range(mat(m, GRIP).shape[0]):
        mat(m, GRIP)[n, CLOSED] = OPEN
    loads(m, t)
    vec(m, AUDIT)[STARTED] = 0.0
    stands(m, y)
    vec(m, CLOCK)[T] = t


@compiled
def choose_active(m):
    """Choose the contacts that are closed, starting from the modes of the step before; the others are off."""
    contact, touch, mode, values = imat(m, CONTACT), mat(m, TOUCH), ivec(m, MODE), vec(m, VALUES)
    chosen, trial, slide = ivec(m, CHOSEN), ivec(m, TRIAL), ivec(m, SLIDE)
    count = 0
    for n in range(contact.shape[0]):
        touch[n, NORMAL], touch[n, TANGENT] = 0.0, 0.0
        if touch[n, GAP] <= (ACTIVE if mode[n] == OFF else KEPT) * values[contact[n, SHAPE_P] + 4]:
            chosen[count], trial[count], slide[count] = n, mode[n], 0
            count += 1
    return count


@compiled
def late(h, gap, speed):
    """Time by which the middle of the step is later than the hit [s]: within the step, also where it began inside."""
    return min(max(-gap / speed, -0.5 * h), 0.5 * h)


@compiled
def impact_side(m, count, h):
    """b of the active contacts, without percussions: g'+ minus the rate a bounce is to have, and -(u_t+ + e_T u_t-).

    Rates are those of the end of the step at the place of its middle.
    """
    contact, touch, chosen, side = imat(m, CONTACT), mat(m, TOUCH), ivec(m, CHOSEN), mat(m, SIDE)
    acceleration, values, grip, body = mat(m, ACCELERATION), vec(m, VALUES), mat(m, GRIP), mat(m, BODY)
    for k in range(count):
        n, p = chosen[k], contact[chosen[k], NORMAL_P]
        touch[n, DGAP], touch[n, SLIP] = -along(m, 2 * k, n, body, VX), along(m, 2 * k + 1, n, body, VX)
        pull, bend = along(m, 2 * k, n, acceleration, 0), touch[n, GAMMA_N]
        least = 2.0 * h * abs(bend - pull)
        hits = touch[n, DGAP] < -least
        grip[n, HITS], grip[n, E_T] = 1.0 if hits else 0.0, values[p + 1] if hits else 0.0
        grip[n, AFTER] = grip[n, SHIFT] = 0.0  # what a jolt left there is of another kind
        if hits:
            when = 0.5 * h - late(h, touch[n, GAP], -touch[n, DGAP])  # after the start of the step
            speed = touch[n, DGAP] - pull * when + bend * (when - 0.5 * h)
            if -values[p] * speed > least:  # it bounces: free before and after
                grip[n, AFTER] = -values[p] * speed - bend * (when - 0.5 * h) - pull * (h - when)
        side[B, 2 * k] = touch[n, DGAP] - h * pull - grip[n, AFTER]
        side[B, 2 * k + 1] = -(1.0 + grip[n, E_T]) * touch[n, SLIP] - h * along(m, 2 * k + 1, n, acceleration, 0)


@compiled
def take_percussions(m, t, count, h, y):
    """Percussions into rates, multipliers, forces and accounts; y holds q_M and the rates without percussions.

    Returns True when there was an impact.
    """
    contact, touch, chosen, trial = imat(m, CONTACT), mat(m, TOUCH), ivec(m, CHOSEN), ivec(m, TRIAL)
    side, pushed, called, multiplier = mat(m, SIDE), mat(m, PUSHED), vec(m, CALLED), vec(m, MULTIPLIER)
    grip, mode, nq = mat(m, GRIP), ivec(m, MODE), vec(m, CHANGE).shape[0]
    rows, power = mat(m, ROWS), vec(m, POWER)
    push_all(m, count)
    for c in range(nq):
        y[nq + c] -= pushed[1 + c // 3, c % 3]
    for row in range(multiplier.shape[0]):
        multiplier[row] -= called[row] / h
    y[2 * nq] += h * power[1]
    y[2 * nq + 1] += h * power[2]
    for row in range(multiplier.shape[0]):
        y[2 * nq] -= h * multiplier[row] * rows[row, NU]
    k, nc, impact = 0, contact.shape[0], False
    for n in range(nc):
        old = mode[n]
        mode[n] = OFF
        if k < count and chosen[k] == n:
            pressed, held = side[F, 2 * k], side[F, 2 * k + 1]
            if pressed > 0.0:
                mode[n] = trial[k]
                gap_rate = side[A, 2 * k] + grip[n, AFTER]
                slip = -side[A, 2 * k + 1] - grip[n, E_T] * touch[n, SLIP]
                if friction_of(m, n) == 0.0:
                    slip = touch[n, SLIP]
                lost = 0.5 * (held * (touch[n, SLIP] + slip) - pressed * (touch[n, DGAP] + gap_rate))
                j = y.shape[0] - 4 * nc + 4 * n
                y[j + 1] += pressed
                y[j + 2] += lost
                touch[n, NORMAL], touch[n, TANGENT] = pressed / h, held / h
                if old == OFF and grip[n, HITS] == 1.0:
                    speed = -touch[n, DGAP]
                    note(m, IMPACT_EVENT, n, t + 0.5 * h - late(h, touch[n, GAP], speed), y, speed, 0.0, pressed, lost)
                    grip[n, SPEED] = speed
                    grip[n, SHIFT] = gap_rate * late(h, touch[n, GAP], speed) - touch[n, GAP]
                    impact = True
            k += 1
        watch_contact(m, n, old, t, h, y)
    return impact


@compiled
def watch_contact(m, n, old, t, h, y):
    """Count pressed and free steps of contact n; note where it starts or ends to last, sticks or slips."""
    mode, grip, touch = ivec(m, MODE), mat(m, GRIP), mat(m, TOUCH)
    steps = grip[n, STEPS_IN]
    j = y.shape[0] - 4 * grip.shape[0] + 4 * n
    if mode[n] != OFF:
        steps = max(steps, 0.0) + 1.0
        if grip[n, CLOSED] == OPEN and steps >= LASTING:
            grip[n, CLOSED], grip[n, SINCE], grip[n, PEAK] = SHUT, t + h - steps * h, 0.0
            grip[n, IMPULSE_0], grip[n, LOSS_0] = y[j + 1], y[j + 2]
            if mode[n] == STICK and friction_of(m, n) > 0.0:
                note(m, STICK_EVENT, n, t, y, 0.0, 0.0, 0.0, 0.0)
        elif grip[n, CLOSED] == SHUT and (old == STICK) != (mode[n] == STICK) and friction_of(m, n) > 0.0:
            note(m, STICK_EVENT if mode[n] == STICK else SLIP_EVENT, n, t, y, 0.0, 0.0, 0.0, 0.0)
        grip[n, PEAK] = max(grip[n, PEAK], touch[n, NORMAL])
    else:
        steps = min(steps, 0.0) - 1.0
        if grip[n, CLOSED] == SHUT and steps <= -LASTING:
            note(m, CONTACT_EVENT, n, t + (steps + 1.0) * h, y, 0.0, 0.0, 0.0, 0.0)
            note(m, RELEASE_EVENT, n, t + (steps + 1.0) * h, y, 0.0, 0.0, 0.0, 0.0)
            grip[n, CLOSED], grip[n, SPEED] = OPEN, 0.0
    grip[n, STEPS_IN] = steps


@compiled
def lift(m, count, y):
    """Move contacts along the joints: bounces to where they belong had they hit in time, lasting ones onto the wall."""
    touch, chosen, trial, side = mat(m, TOUCH), ivec(m, CHOSEN), ivec(m, TRIAL), mat(m, SIDE)
    grip, nq = mat(m, GRIP), vec(m, CHANGE).shape[0]
    deep = False
    for k in range(count):
        n = chosen[k]
        trial[k] = OFF
        side[B, 2 * k], side[B, 2 * k + 1] = 0.0, 0.0
        if touch[n, NORMAL] > 0.0 and (touch[n, GAP] < 0.0 or grip[n, CLOSED] == SHUT or grip[n, SHIFT] > 0.0):
            trial[k] = FORWARD
            side[B, 2 * k] = grip[n, SHIFT] if grip[n, SHIFT] > 0.0 else -touch[n, GAP]
            deep = True
        grip[n, SHIFT] = 0.0
    if not deep:
        return
    solve_modes(m, count, 0)
    shift(m, count, y[:nq], 1.0)


@compiled
def close_joints(m, t, y):
    """One correction of positions and of rates onto the joints."""
    change, nq = vec(m, CHANGE), vec(m, CHANGE).shape[0]
    q, v = y[:nq], y[nq : 2 * nq]
    drive(m, t)
    constraints(m)
    factorise(m)
    residual(m)
    correct(m)
    for c in range(nq):
        q[c] += change[c]
    place(m, q, v)
    constraints(m)
    row = note_drift(m)
    if row >= 0:
        ivec(m, TALLY)[DRIFT_ROW] = row
    rate_residual(m)
    correct(m)
    for c in range(nq):
        v[c] += change[c]
    place(m, q, v)


@compiled
def write_until(m, t, h, t_out, out):
    """Outputs up to t + h: positions between those of both ends, rates of the end, forces of this step."""
    tally, y, y_new, stage = ivec(m, TALLY), vec(m, STATE), vec(m, STATE_NEW), vec(m, STAGE)
    acceleration, nq, nc = mat(m, ACCELERATION), vec(m, CHANGE).shape[0], mat(m, TOUCH).shape[0]
    while tally[OUTPUTS] < t_out.shape[0] and t_out[tally[OUTPUTS]] <= t + 1.0000001 * h:
        k = tally[OUTPUTS]
        share = min(max((t_out[k] - t) / h, 0.0), 1.0)
        for c in range(y.shape[0]):
            stage[c] = y[c] + share * (y_new[c] - y[c])
        for c in range(nq):
            stage[nq + c] = y[nq + c] if share == 0.0 else y_new[nq + c]
            acceleration[1 + c // 3, c % 3] = (y_new[nq + c] - y[nq + c]) / h
        place(m, stage[:nq], stage[nq : 2 * nq])
        drive(m, t_out[k])
        constraints(m)
        loads(m, t_out[k])
        lost = stage[2 * nq + 1]
        for n in range(nc):
            lost += stage[2 * nq + 4 + 4 * n]
        write(m, stage[2 * nq], lost, out[k])
        tally[OUTPUTS] = k + 1


@native("i", "h", "f", "f", "i", "v", "m", "i")
def advance(m, t_start, h, count, t_out, out, most_steps):
    """Take up to `most_steps` of the `count` steps of length h from t_start on; writes outputs on the way.

    Returns DONE, PAUSED, NOT_FINITE, NO_SOLUTION, NOT_FOUND, UNSOUND or ESCAPED.
    """
    y, y_new, clock, tally, body = vec(m, STATE), vec(m, STATE_NEW), vec(m, CLOCK), ivec(m, TALLY), mat(m, BODY)
    acceleration, nq, most_found = mat(m, ACCELERATION), vec(m, CHANGE).shape[0], mat(m, EVENTS).shape[0] // 2
    begun, rate, audit = tally[STEPS], vec(m, RATE), vec(m, AUDIT)
    clock[H] = clock[H_MIN] = h
    while (
        tally[STEPS] < begun + most_steps
        and tally[STEPS] < count
        and max(tally[EVENT_COUNT], tally[FOUND]) < most_found
    ):
        t = t_start + tally[STEPS] * h
        for c in range(y.shape[0]):
            y_new[c] = y[c]
        for c in range(nq):
            y_new[c] += 0.5 * h * y[nq + c]
            y_new[nq + c] += 0.5 * h * rate[c]
        place(m, y_new[:nq], y_new[nq : 2 * nq])
        drive(m, t + 0.5 * h)
        constraints(m)
        loads(m, t + 0.5 * h)
        vec(m, POWER)[3] = 1.0
        factorise(m)
        accelerate(m)
        active = choose_active(m)
        contact_rows(m, active)
        place(m, y_new[:nq], y[nq : 2 * nq])
        impact_side(m, active, h)
        for c in range(nq):
            y_new[nq + c] = y[nq + c] + h * acceleration[1 + c // 3, c % 3]
        if active > 0 and not solve_contacts(m, active):
            return ending(m)
        impact = take_percussions(m, t, active, h, y_new)
        cross_at_once(m, t)
        for c in range(nq):
            rate[c] = acceleration[1 + c // 3, c % 3] if impact else (y_new[nq + c] - y[nq + c]) / h
            y_new[c] += 0.5 * h * y_new[nq + c]
        place(m, y_new[:nq], y_new[nq : 2 * nq])
        if active > 0:
            touch_all(m)
            lift(m, active, y_new)
            place(m, y_new[:nq], y_new[nq : 2 * nq])
        close_joints(m, t + h, y_new)
        for i in range(1, body.shape[0]):
            if not abs(y_new[nq + 3 * i - 1]) + abs(y_new[nq + 3 * i - 2]) + abs(y_new[nq + 3 * i - 3]) < math.inf:
                return NOT_FINITE
        tally[EVALUATIONS] += 1
        gauge(m, START, t + 0.5 * h)
        add_step(m, h)
        loads(m, t + h)
        if not stands(m, y_new):
            clock[TROUBLE] = t + h
            return UNSOUND
        touch_all(m)
        audit[SUNK] = max(audit[SUNK], deepest(m))
        if audit[SUNK] > 1.0:
            clock[TROUBLE] = t + h
            return ESCAPED
        write_until(m, t, h, t_out, out)
        for c in range(y.shape[0]):
            y[c] = y_new[c]
        tally[STEPS] += 1
        clock[T] = t_start + tally[STEPS] * h
    return DONE if tally[STEPS] >= count else PAUSED
