"""Step size control: the next step, shorter after a rejected one, longer after an accepted one.

A stepper returns the error of its step relative to the tolerance; `step_size` says what length follows from it.  One
with fixed steps returns 0, or inf if the new state is not finite.  Steps that fail `step_audit`, or cross a switch, are
rejected too.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.4.
"""

from __future__ import annotations

import math

from rattle.equations.motion import OK, derivative
from rattle.equations.state import states_at
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.dense_output import prepare_dense
from rattle.solvers.state_switches import REPEAT, SLIDES, arrive, crossed, land, release
from rattle.solvers.step_audit import UNSOUND, keep_energies, stands
from rattle.solvers.step_size import SAFETY, STANDSTILL, STANDSTILL_OF_RUN, first_length, longer, shorter, trial_step

TRY_AGAIN = -1  # the step must be repeated, with the length in `clock`
SHORT = 1e-9  # share of the remaining time down to which a step that fails the audit is repeated with a shorter length
COUNTS = 1e-2  # of the tolerances, from which differences between stages show that a step is not stable
STABLE_SHARE = 0.9  # of the longest stable step, the next one
REGROWTH = 1.005  # growth of the longest stable step from one step to the next
COLLAPSED = 1e-12  # share of the run below which a step gets nowhere
MOST_COLLAPSED = 1000  # such steps in a row, repeated ones included, after which a run stops: a contact takes far fewer
AS_LONG = 0.999  # of the step that is to end at a switch: a shorter one was cut on the way, and ends before it
ROUNDING = 1e-15  # share of the time by which a step may be shorter than planned
TOO_LARGE = 1e130  # of a derivative in SI units
LAST = 1.000001  # times a step, within which the end of the run lies in it: no tiny step is left behind
LEAST_STABLE = 0.2  # share of a step that is not stable which the next one has at least


@compiled
def has_room(m, steps):
    """True while fewer than `steps` steps are done and there is room for the events of one more."""
    tally, most = m.tally, m.crossings.shape[0] // 2
    return tally[at.STEPS] < steps and tally[at.FOUND] < most and tally[at.EVENT_COUNT] < most


@compiled
def next_step(m, t_end):
    """Length of the next step [s], 0 if it would be too short, and True for the last one before t_end [s]."""
    clock = m.clock
    t, h = clock[at.T], clock[at.H]
    last = t + (LAST if m.landing[at.LANDS] == 0.0 else 1.0) * h >= t_end
    if last:
        h = t_end - t
    clock[at.COLLAPSED] = clock[at.COLLAPSED] + 1.0 if h < COLLAPSED * t_end and not last else 0.0
    if h <= STANDSTILL * abs(t) or h <= STANDSTILL_OF_RUN * t_end or t + h == t or clock[at.COLLAPSED] > MOST_COLLAPSED:
        return 0.0, last
    return h, last


@compiled
def largest_rate(m, f):
    """Largest of the derivatives f that the tolerances apply to [m/s, m/s^2 ...].

    inf if one is not a number, or so large that its square over the tolerance is none.
    """
    most = 0.0
    for n in range(2 * m.change.shape[0]):
        most = most if abs(f[n]) <= most else abs(f[n])
        if not most < TOO_LARGE:
            return math.inf
    return most


@compiled
def first_step(m, t, y, f, longest, rtol, atol):
    """Length [s] of a step from (t [s], y) with the derivative f, where nothing is known of steps before.

    Source: Hairer, Norsett, Wanner, section II.4, starting step size.
    """
    stage, k1 = m.stage, m.slopes[1]
    ny = 2 * m.change.shape[0]
    size, slope = 0.0, 0.0
    for n in range(ny):
        scale = atol + rtol * abs(y[n])
        size += (y[n] / scale) ** 2
        slope += (f[n] / scale) ** 2
    h = trial_step(size, slope, longest)
    for n in range(y.shape[0]):
        stage[n] = y[n] + h * f[n]
    derivative(m, t + h, stage, k1)
    bend = 0.0
    for n in range(ny):
        bend += ((k1[n] - f[n]) / (atol + rtol * abs(y[n]))) ** 2
    m.tally[at.EVALUATIONS] += 2
    return first_length(h, slope, bend, ny, m.stepper[at.ERROR_POWER], longest)


@compiled
def refuse(m, t, h, error):
    """Reject the step from t of length h [s]; True if switches were released, so that the next attempt may succeed."""
    m.tally[at.REJECTED] += m.stepper[at.ADAPTIVE]
    m.clock[at.TROUBLE] = t + h
    m.landing[at.LANDS] = 0.0
    return m.switch.shape[0] > 0 and not error < math.inf and release(m)


@compiled
def shorten(m, h, error):
    """Choose a step shorter than h [s], whose error (share of the tolerance) was too large."""
    m.clock[at.H] = shorter(h, error, m.stepper[at.ERROR_POWER], SAFETY)


@compiled
def lengthen(m, h, error, last, h_max):
    """Choose the step after one of length h [s]; last: the step was shortened to end at a given instant."""
    clock = m.clock
    ahead = longer(h, error, m.stepper[at.ERROR_POWER], SAFETY)
    clock[at.H_STABLE] *= REGROWTH
    clock[at.H] = min(h_max, clock[at.H_STABLE], max(ahead, clock[at.H] if last else 0.0))


@compiled
def is_stable(m, h, rtol, atol):
    """False if a step of length h [s] was too long for the stiffest spring or contact; `clock` then has a shorter one.

    The last stage and the end of the step are two states at one instant.  With their differences dq, dv, da in the norm
    of the masses, w of |da| = w^2 |dq| + w |dv| is at most the highest natural frequency, or the fastest decay, and
    near to it where that shows in the step.  Beyond the limit of stability ends of steps may still be right, but not
    what lies within them.  Differences far below the tolerances do not count; a step is repeated once.
    """
    clock, last, weight = m.clock, m.stepper[at.STAGES] - 1, m.weight
    y, f, stage, slope = m.state_new, m.rate_new, m.stage, m.slopes
    nq, dq2, dv2, da2, masses, counts = m.change.shape[0], 0.0, 0.0, 0.0, 0.0, False
    for n in range(nq):
        mass = 1.0 / weight[1 + n // 3, n % 3]
        masses += mass
        dq, dv, da = y[n] - stage[n], y[nq + n] - stage[nq + n], f[nq + n] - slope[last, nq + n]
        dq2 += mass * dq * dq
        dv2 += mass * dv * dv
        da2 += mass * da * da
        counts |= abs(dq) > COUNTS * (atol + rtol * abs(y[n])) or abs(dv) > COUNTS * (atol + rtol * abs(y[nq + n]))
    for n in range(states_at(m), y.shape[0]):  # bristles move as bodies do; accelerations follow from them too
        dq2 += masses * (y[n] - stage[n]) * (y[n] - stage[n])
    again, clock[at.SHORTENED] = clock[at.SHORTENED], 0.0
    da = math.sqrt(da2)
    fall = math.sqrt(dv2) + math.sqrt(dv2 + 4.0 * da * math.sqrt(dq2))
    if again == 1.0 or not counts or not da < math.inf or 2.0 * da * h <= m.stepper[at.STABLE] * fall:
        return True
    clock[at.SHORTENED] = 1.0
    clock[at.H_STABLE] = max(LEAST_STABLE * h, STABLE_SHARE * m.stepper[at.STABLE] * fall / (2.0 * da))
    clock[at.H] = clock[at.H_STABLE]
    return False


@compiled
def quarter(m, h):
    """Choose a quarter of the rejected step h [s]."""
    m.clock[at.H] = 0.25 * h
    m.tally[at.REJECTED] += 1


@compiled
def end_stands(m, t, h, t_new, t_end):
    """OK if the end of the step passes `step_audit`; otherwise TRY_AGAIN with a quarter of it, or UNSOUND."""
    if stands(m, m.state_new):
        return OK
    m.clock[at.TROUBLE] = t_new
    m.landing[at.LANDS] = 0.0
    if m.stepper[at.ADAPTIVE] == 1 and h > SHORT * (t_end - t):
        quarter(m, h)
        return TRY_AGAIN
    return UNSOUND


@compiled
def never_switches(m):
    """True if there are neither switches of expressions nor joints with friction."""
    return m.switch.shape[0] == 0 and m.dry.shape[0] == 0


@compiled
def end_on_switch(m, t, h, t_end, dense):
    """OK, or TRY_AGAIN with a step that ends at the first switching instant inside this one, or SLIDES.

    dense: the dense output is ready.
    """
    clock, landing = m.clock, m.landing
    if landing[at.LANDS] != 0.0 and h < AS_LONG * landing[at.LANDS_IN] - ROUNDING * abs(t):
        landing[at.LANDS] = 0.0  # shortened since: it ends before the switch
    if never_switches(m) or landing[at.LANDS] != 0.0 or not crossed(m):
        return OK
    if not dense:
        prepare_dense(m, t, h)
        m.tally[at.EVALUATIONS] += m.stepper[at.DENSE_STAGES]
    verdict, shorter = land(m, t, h, t_end, clock[at.H])
    if verdict == SLIDES:
        return SLIDES
    if verdict == REPEAT:
        clock[at.H] = shorter
        return TRY_AGAIN
    return OK


@compiled
def turn_switch(m, t, located):
    """Change the branch of the switch at which the step has ended at t; True if there was one.

    located: an event has ended the step before.
    """
    clock, landing = m.clock, m.landing
    if never_switches(m):
        return False
    clock[at.H] = landing[at.GO_ON] if landing[at.LANDS] > 0.0 and not located else clock[at.H]
    landing[at.LANDS] = landing[at.LANDS] if not located else 0.0
    return arrive(m, t, m.state_new, m.rate_new, landing[at.GO_ON])


@compiled
def take_over(m, t, located):
    """Make the end of the step, at t, the start of the next; located: an event has ended the step."""
    y, f, y_new, f_new, clock = m.state, m.rate, m.state_new, m.rate_new, m.clock
    for n in range(y.shape[0]):
        y[n] = y_new[n]
        f[n] = f_new[n]
    if located:
        stands(m, y)
    keep_energies(m)
    clock[at.H_MIN] = min(clock[at.H_MIN], t - clock[at.T]) if not located else clock[at.H_MIN]
    clock[at.T] = t
    m.tally[at.STEPS] += 1


@compiled
def output_due(m, t, t_out):
    """True if the next output is not after t [s]."""
    k = m.tally[at.OUTPUTS]
    return k < t_out.shape[0] and t_out[k] <= t
