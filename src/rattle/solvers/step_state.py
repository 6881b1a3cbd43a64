"""Values that a run carries from step to step: times, counts, and the arrays of the time integration."""

from __future__ import annotations

import math

import numpy as np

from rattle.jit import functions
from rattle.jit import layout as at
from rattle.registry import Kind, kinds
from rattle.solvers.shifted_matrices import implicit_arrays

# stepper: 1 if it is adaptive, power of the step with which the error of a step grows, stages of a step, layout of its
# stages (see `peaks.samples`), further stages of its dense output, where it stops to be stable (0: not watched);
# stepper_table: its kernels
ADAPTIVE, POWER, STAGES, SAMPLES, DENSE_STAGES, STABLE = range(6)
STEP, DENSE = range(2)


def step_loop_arrays(y: np.ndarray, watched: int) -> dict[str, np.ndarray]:
    """Arrays of a run that starts at y, besides those of one instant; watched: number of monitored forces."""
    ny = y.shape[0]
    clock = np.zeros(at.width("clock"))
    clock[at.H_MIN] = math.inf
    clock[at.FEWEST] = math.inf
    clock[at.H_STABLE] = math.inf
    return {
        "state": y.copy(),
        **{name: np.zeros(ny) for name in ("rate", "state_new", "rate_new", "stage")},
        "slopes": np.zeros((16, ny)),
        "dense": np.zeros((7, ny)),
        "clock": clock,
        "tally": np.zeros(at.width("tally"), np.int64),
        "sign": np.zeros(watched),
        "crossings": np.zeros((4096, at.width("crossings"))),
        "events": np.zeros((4096, at.width("events"))),
        "landing": np.zeros(at.width("landing")),
    }


def stepper_arrays(stepper: Kind, stiff: bool, bodies: int, states: int, ny: int) -> dict[str, np.ndarray]:
    """Arrays that describe this stepper, or the one whose kernels it calls; empty if it has no kernels.

    stiff: the model has oil films.  An implicit one works with further arrays, whose sizes follow from the numbers of
    bodies, of states of elements and of all numbers of y.
    """
    by = (stepper.leaf.if_stiff if stiff else "") or stepper.leaf.integrates_by
    one = kinds("stepper")[by] if by else stepper
    if one.kernel is None:
        return {}
    leaf = one.leaf
    power = leaf.error_order or leaf.order
    return (implicit_arrays(bodies, states, ny) if leaf.implicit else {}) | {
        "stepper": np.array(
            [leaf.adaptive, power, leaf.stages, leaf.samples, leaf.dense_stages, leaf.stable], np.int64
        ),
        "stepper_table": functions.entries((one.kernel, leaf.dense_output)),
    }
