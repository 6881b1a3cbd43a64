"""Predictability horizon: the time up to which two runs agree, and the curve that deviates first.

Source: docs/theory.md, section 8.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rattle.analyses.dynamics.run import Run
from rattle.equations.state import state_layout
from rattle.jit import layout as at
from rattle.results.columns import columns, motion, states_of
from rattle.solvers.output_row import record

AGREE = 0.01  # share of its range within which two curves agree
STILL = 1e-7  # a curve whose range is below this share of the widest of its unit counts as constant
NOISE = 10.0  # perturbation of a state, in tolerances, that shows how much of a curve is rounding
MOST_NOISE = 1e-3  # share of the widest of its unit that may count as rounding
SHAKEN = 12  # instants at which the state is perturbed
MOTION = ("m", "rad", "m/s", "rad/s")  # units of positions and rates
LIKE = (("m", "rad"), ("m/s", "rad/s"), ("m/s^2", "rad/s^2"), ("N", "N*m"))


class Reach(NamedTuple):
    """How long two runs agree."""

    time: float  # up to which every curve agrees [s]
    first: str  # the curve that deviates first; "" if none does
    motion: float  # up to which all positions and rates agree [s]


def tighter(rtol: float, usual: float) -> float:
    """Relative tolerance [-] of the second run: a tenth of the first, and at most the usual one.

    Two loose runs might miss the same contact and therefore agree.
    """
    return min(rtol / 10.0, usual) if rtol > usual else rtol / 10.0


def agreement(run: Run, second: Run) -> Reach:
    """Time [s] up to which every curve of two runs agrees within 1 % of its range."""
    n = int(min(run.tally[at.OUTPUTS], second.tally[at.OUTPUTS]))
    first, names, units = columns(run.system, run.raw[:n])
    other, _, _ = columns(second.system, second.raw[:n])
    keep = [k for k, name in enumerate(names) if not name.startswith("energy.")]
    first, other = first[:, keep], other[:, keep]
    span = np.ptp(first, axis=0)
    widest: dict[str, float] = {}
    for k, width_ in zip(keep, span, strict=True):
        widest[units[names[k]]] = max(widest.get(units[names[k]], 0.0), float(width_))
    for linear, angular in LIKE:  # a length of the mechanism's size compares with an angle of 1 rad
        arm = 1.0 / run.system.size if angular == "N*m" else run.system.size
        wide = max(widest.get(linear, 0.0), widest.get(angular, 0.0) * arm)
        widest[linear], widest[angular] = wide, wide / arm
    # a curve that is constant beside others of its unit, or varies less than the tolerance, has no range of its own
    wide_ = np.array([widest[units[names[k]]] for k in keep])
    signal = np.array([names[k] in run.system.model.recorded for k in keep])
    shaken = _rounding(run, n)[keep]
    floor = np.maximum(STILL * wide_, np.where(signal, shaken, np.minimum(shaken, MOST_NOISE * wide_)))
    apart = np.abs(first - other) > np.maximum(AGREE * span, floor)
    moving = np.array([units[names[k]] in MOTION and names[k] not in run.system.model.recorded for k in keep])

    def until(some: np.ndarray) -> float:
        parted = some.any(axis=1)
        return float(run.t_eval[max(0, int(np.argmax(parted)) - 1) if parted.any() else n - 1])

    which = np.argmax(apart[np.argmax(apart.any(axis=1))])
    return Reach(until(apart), names[keep[which]] if apart.any() else "", until(apart[:, moving]))


def _rounding(run: Run, n: int) -> np.ndarray:
    """(columns,) change [SI] of every curve when positions and rates are perturbed by NOISE tolerances."""
    nq, own = 3 * run.system.body_count, state_layout(run.system).own_states
    y = np.zeros_like(run.workspace.state)
    random = np.random.default_rng(0)
    rows = np.zeros((2, run.raw.shape[1]))
    most = np.zeros(len(columns(run.system, rows[:1])[1]))
    for k in np.unique(np.linspace(0, n - 1, SHAKEN).astype(int)):
        y[:nq], y[nq : 2 * nq], _ = motion(run.system, run.raw[k])
        y[own] = run.raw[k, states_of(run.system)]
        record(run.workspace, run.t_eval[k], y, rows[0])
        near = y.copy()
        near[: 2 * nq] += NOISE * (run.atol + run.rtol * np.abs(y[: 2 * nq])) * random.uniform(-1.0, 1.0, 2 * nq)
        record(run.workspace, run.t_eval[k], near, rows[1])
        curves = columns(run.system, rows)[0]
        change = np.abs(curves[1] - curves[0])
        most = np.maximum(most, np.where(np.isfinite(change), change, 0.0))
    return most
