"""How long a step may be: of kernels and, recorded as graphs, of the lanes of `rattle.trace`.

If the error of a step, as a share of the tolerance, grows with the power p of its length h, `safety` h error^(-1/p) is
the longest step that most likely satisfies it.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), sections II.4 and II.10.
"""

from __future__ import annotations

import math

from rattle.jit.choices import TINY, select
from rattle.jit.functions import compiled

SAFETY = 0.9  # share of the step that would just fulfil the tolerance, to be tried next
# Lanes in which a step is rejected wait for no other, but it costs as much as a good one: with 0.9 a quarter of them
# is; at equal errors of the result 0.65 takes 4 to 19 % less work (four-bar, squeezer, double pendulum, toggle)
SAFETY_OF_LANES = 0.65
LEAST, MOST = 0.2, 6.0  # change of the length from one step to the next, as factors
BROKEN = 0.1  # the same after a step whose error is no number
NEGLIGIBLE = 1e-7  # error that says nothing about the length but that it may grow
DAMPING = 0.01  # weight of the second error estimate: small where the first one is sound
SHARE, BLIND, SLOWEST = 0.01, 1e-6, 1e-15  # of the first step: of a tolerance, if nothing is known [s], of a rate
STANDSTILL = 1e-15  # share of the time that a step must exceed to get anywhere: a few spacings of numbers there
STANDSTILL_OF_RUN = 1e-16  # the same, as a share of the run
UNTOLD = 1e-10  # sum of squares, over the tolerances, of a state or its derivative that does not tell a time scale
LEAST_OF_TRIAL, MOST_OF_TRIAL = 1e-3, 100.0  # bounds of the first step, as factors of the trial step


@compiled
def root_of(x, power):
    """x^(1/power), x >= 0: exact square roots as far as they go."""
    while power % 2 == 0:
        x = math.sqrt(x)
        power = power // 2
    return x if power == 1 else x ** (1.0 / power)


@compiled
def error_share(h, first, second, count):
    """Error of a step of length h [s] from the sums of squares of its estimates / h over the tolerances.

    first, second: of an estimate and of another one, which damps it, or zero; count: of components of the motion.
    """
    return abs(h) * first / math.sqrt((first + DAMPING * second) * count + TINY)


@compiled
def fitting(error, power, safety):
    """Factor with which a step of this error most likely satisfies the tolerance."""
    return safety / root_of(max(error, TINY), power)


@compiled
def shorter(h, error, power, safety):
    """Length [s] of the next attempt after a step of length h [s] whose error was too large, or is no number."""
    return h * select(error < math.inf, max(fitting(error, power, safety), LEAST), BROKEN)


@compiled
def longer(h, error, power, safety):
    """Length [s] of the step after one of length h [s] and this error."""
    return h * select(error < NEGLIGIBLE, MOST, min(fitting(error, power, safety), MOST))


@compiled
def trial_step(size, slope, longest):
    """Length [s] of a step that shows how fast the derivative changes.

    size, slope: sums of squares of the state and of its derivative over the tolerances.
    """
    resolved = min(size, slope) > UNTOLD
    return min(select(resolved, SHARE * math.sqrt(size / max(slope, TINY)), BLIND), longest)


@compiled
def first_length(h, slope, bend, count, power, longest):
    """Length [s] of the first step, after the trial step of length h [s].

    bend: sum of squares of the change of the derivative in it, over the tolerances; count: of their components.
    """
    fastest = max(math.sqrt(slope), math.sqrt(bend) / h) / math.sqrt(count)
    within = min(max(fastest, SLOWEST), 1.0 / TINY)
    length = select(fastest == within, root_of(SHARE / within, power), max(LEAST_OF_TRIAL * h, BLIND))
    return min(min(MOST_OF_TRIAL * h, length), longest)
