"""Values that a run carries from step to step: times, counts, and the arrays of the time integration."""

from __future__ import annotations

import math

import numpy as np

from rattle.interfaces.steppers import StepperKind
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.registry import Kind, kinds
from rattle.solvers.peaks.samples import sample_arrays
from rattle.solvers.shifted_matrices import implicit_arrays
from rattle.solvers.stepper import tableau_of
from rattle.value_types import Plain

SLOPES = 12  # rows of `slopes` of a step that a stepper without a tableau writes, or leaves at zero


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
        "dense": np.zeros((7, ny)),
        "clock": clock,
        "tally": np.zeros(at.width("tally"), np.int64),
        "sign": np.zeros(watched),
        "crossings": np.zeros((4096, at.width("crossings"))),
        "events": np.zeros((4096, at.width("events"))),
        "landing": np.zeros(at.width("landing")),
    }


def course(loop: int, extent: float) -> np.ndarray:
    """The array `course` of a run before its start; loop: as in its column, extent: of the mechanism [m]."""
    begins = np.zeros(at.width("course"))
    begins[at.LOOP], begins[at.EXTENT], begins[at.JAM_AT] = loop, extent, -math.inf
    return begins


def integrator(stepper: Kind[StepperKind], stiff: bool) -> Kind[StepperKind]:
    """The stepper whose kernels a run with this one calls: another one, or itself; stiff: the model has oil films."""
    by = (stepper.leaf.if_stiff if stiff else "") or stepper.leaf.integrates_by
    return kinds("stepper")[by] if by else stepper


def stepper_arrays(
    stepper: Kind[StepperKind], bodies: int, states: int, ny: int
) -> dict[str, np.ndarray | tuple[Plain, ...]]:
    """Arrays that describe a stepper; empty if it has no kernels.

    An implicit one works with further arrays, whose sizes follow from the numbers of bodies, of states of elements and
    of all numbers of y.
    """
    if stepper.kernel is None:
        return {}
    leaf, tableau = stepper.leaf, tableau_of(stepper)
    assert leaf.dense_output is not None, "a stepper with a kernel has a dense output"
    power = leaf.error_order or leaf.order
    slopes, stable = (leaf.stages, tableau.watched_stable) if tableau else (SLOPES, 0)
    return (implicit_arrays(bodies, states, ny) if leaf.implicit else {}) | {
        "stepper": np.array([leaf.adaptive, power, leaf.stages, slopes, leaf.dense_stages, stable], np.int64),
        "stepper_table": functions.entries((stepper.kernel, leaf.dense_output)),
        "slopes": np.zeros((max(2, len(tableau.c)) if tableau else SLOPES, ny)),
        **(tableau.arrays if tableau else {}),
        **sample_arrays(tableau),
    }
