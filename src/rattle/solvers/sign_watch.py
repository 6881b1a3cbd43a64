"""Monitored forces that must not become negative: their zero crossings are detected and located."""

from __future__ import annotations

from rattle.equations.motion import solve_motion
from rattle.equations.state import take_states
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.dense_output import HALVINGS, INSTANT, interpolate

SCAN = 8  # parts of a step searched for zero crossings
LOCATED = 1e-13  # share of the time to which a zero crossing is located: it is only reported, no step ends there


@compiled
def watched_change(m):
    """True if a monitored force has another sign than at the start of the step."""
    watch, sign, multiplier = m.watch, m.sign, m.multiplier
    for n in range(watch.shape[0]):
        if multiplier[watch[n]] * sign[n] < 0.0:
            return True
    return False


@compiled
def force_at(m, t, h, theta, n):
    """Monitored force n [N] at the share theta of the step."""
    stage, multiplier, watch = m.stage, m.multiplier, m.watch
    nq = m.change.shape[0]
    interpolate(m, theta, stage)
    take_states(m, stage)
    solve_motion(m, t + theta * h, stage[:nq], stage[nq : 2 * nq])
    m.tally[at.EVALUATIONS] += 1
    return multiplier[watch[n]]


@native("void", "h", "f", "f", "f")
def find_crossings(m, t, h, until):
    """Locate every zero crossing of monitored forces up to the share `until` of the step; needs the dense output."""
    sign = m.sign
    for n in range(sign.shape[0]):
        left = 0.0
        for part in range(1, SCAN + 1):
            right = until * part / SCAN
            if force_at(m, t, h, right, n) * sign[n] < 0.0:
                low, high = left, right
                for _ in range(HALVINGS):
                    if (high - low) * h <= LOCATED * abs(t) + INSTANT * h:
                        break
                    middle = 0.5 * (low + high)
                    if force_at(m, t, h, middle, n) * sign[n] < 0.0:
                        high = middle
                    else:
                        low = middle
                cross(m, t + high * h, n)
            left = right


@compiled
def cross(m, t, n):
    """Record that monitored force n changes its sign at t [s]."""
    sign, crossings, tally = m.sign, m.crossings, m.tally
    sign[n] = -sign[n]
    k = tally[at.FOUND]
    if k < crossings.shape[0]:
        crossings[k, at.CROSSING_T], crossings[k, at.CROSSING_FORCE], crossings[k, at.CROSSING_SIGN] = t, n, sign[n]
        tally[at.FOUND] = k + 1


@compiled
def cross_at_once(m, t):
    """Take the signs of the present monitored forces as those from t on: at an event they may jump."""
    watch, sign, multiplier = m.watch, m.sign, m.multiplier
    for n in range(watch.shape[0]):
        if multiplier[watch[n]] * sign[n] < 0.0:
            cross(m, t, n)
