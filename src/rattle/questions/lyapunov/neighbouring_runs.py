"""Growth of a small difference between two neighbouring runs, rescaled after every stretch of time.

Source: Benettin, Galgani, Strelcyn, Kolmogorov entropy and numerical experiments, Phys. Rev. A 14 (1976) 2338.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rattle.analyses.dynamics.methods import choose_stepper, new_run
from rattle.analyses.dynamics.run import How
from rattle.equations.motion import DONE, PAUSED
from rattle.equations.state import state_layout
from rattle.errors import InputError
from rattle.jit import layout as at
from rattle.solvers import step_loop
from rattle.solvers.contacts.contact_events import pass_on, remember_end
from rattle.solvers.stepper import ATOL, EVENT_DRIVEN

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

APART = 1e-7  # distance to which the second run is rescaled, positions in mechanism lengths
LARGEST_GROWTH = 1e4  # of that distance in a stretch; above it the growth is not linear
GONE = 1e-7  # of that distance in a stretch; below it what is left is rounding
LOST = 1e-2  # share of that distance that the rounding of positions and rates may be
BEGINNING = 20  # part of the run in which a state that begins at rest reaches its range
ROUGHLY = 1e-6  # relative tolerance of the run that shows the range of states
RESTS = 1e-9  # share of its value below which the range of a state is rounding
LATE = 6  # how often the end of a stretch is postponed if one of the two runs has just had an impact


class Apart(NamedTuple):
    """What two motions differ in: positions, rates, and the states of elements and of the model."""

    places: np.ndarray  # (n,) in the state y
    motion: np.ndarray  # (6 nb,) weight of positions and rates in the size of a difference [1/SI]
    ranges: np.ndarray  # (stretches, n - 6 nb) range of every state until the end of a stretch [SI]

    def weight(self, stretch: int) -> np.ndarray:
        """(n,) of each in the size of a difference [1/SI], in one of the stretches: a state may grow all the time."""
        return np.concatenate([self.motion, 1.0 / self.ranges[stretch]])


def parts_of(m: Mechanism, length: float, times: np.ndarray) -> Apart:
    """What can differ: positions in lengths of the mechanism, rates in these per stretch, a state in its range so far.

    length: of a stretch [s].  times: (n,) at which stretches end [s].  Raises ValueError if the run cannot go on.
    """
    layout, size = state_layout(m.system), m.system.size
    weight = np.tile([1.0 / size, 1.0 / size, 1.0], layout.motion.stop // 3)
    weight[len(weight) // 2 :] *= length
    return Apart(np.r_[layout.motion, layout.states], weight, _ranges(m, layout.states, times))


def _ranges(m: Mechanism, states: slice, times: np.ndarray) -> np.ndarray:
    """(n, ns) range of every state until these times [SI]; of one that rests its value, 1 of one that rests at zero."""
    if states.stop == states.start:
        return np.zeros((len(times), 0))
    span = float(times[-1])
    stepper, _ = choose_stepper(m.system, None, None, span)
    run = new_run(m.system, m.start, np.zeros(0), span, How(stepper, ROUGHLY, ATOL * ROUGHLY, None))
    _must(run, run.begin(m.start.t))
    values = [run.workspace.state[states].copy()]
    for t in times:
        _go(run, t)
        values.append(run.workspace.state[states].copy())
    highest, lowest = np.maximum.accumulate(values)[1:], np.minimum.accumulate(values)[1:]
    begun = len(times) // BEGINNING
    highest[:begun], lowest[:begun] = highest[begun], lowest[begun]
    largest = np.maximum(np.abs(highest), np.abs(lowest))
    rests = highest - lowest <= RESTS * largest
    return np.where(rests, np.where(largest > 0.0, largest, 1.0), highest - lowest)


def growths(m: Mechanism, first: np.ndarray, apart: Apart, times: np.ndarray, rtol: float) -> np.ndarray | None:
    """(n,) natural logarithm of the growth of a difference in every stretch that ends at times (n,) [s].

    None if the growth in a stretch is not linear; -inf from a stretch on in which the difference vanishes.
    first: (n,) direction of the difference at the start, weighted.  apart: what differs, and how it counts.
    Raises InputError if a run cannot go on.
    """
    span, length = float(times[-1]), float(times[0])
    stepper, _ = choose_stepper(m.system, None, None, span)
    how = How(stepper, rtol, ATOL * rtol, None)
    none = np.zeros(0)
    base, two = (new_run(m.system, m.start, none, span, how) for _ in range(2))
    for run in (base, two):
        _must(run, run.begin(m.start.t))
    two.workspace.state[apart.places] += APART / math.sqrt(len(first)) * (first / apart.weight(0))
    _renew(base, two)
    growth = np.full(len(times), -math.inf)
    for k, t in enumerate(times):
        weight = apart.weight(k)
        before = _distance(base, two, apart.places, weight)
        _require_seen(base, apart.places, weight, k * length)
        if before < GONE * APART:
            return growth
        for late in range(LATE + 1):
            for run in (base, two):
                _go(run, t + late * length / 64.0)
            now = _distance(base, two, apart.places, weight)
            if now < LARGEST_GROWTH * APART:
                break
            if late == LATE or stepper.leaf.loop != EVENT_DRIVEN:
                return None
        if now < GONE * before:
            return growth
        growth[k] = math.log(now / before)
        _renew(base, two, APART / _distance(base, two, apart.places, apart.weight(min(k + 1, len(times) - 1))))
    return growth


def _distance(base: Any, two: Any, places: np.ndarray, weight: np.ndarray) -> float:
    return float(np.linalg.norm(weight * (two.workspace.state[places] - base.workspace.state[places])))


def _require_seen(base: Any, places: np.ndarray, weight: np.ndarray, t: float) -> None:
    """Raise InputError where a difference is lost in the rounding of a state that grows without end."""
    largest = float(np.abs(weight * base.workspace.state[places]).max(initial=0.0))
    if not np.finfo(float).eps * largest < LOST * APART:
        raise InputError(
            f"by t = {t:.6g} s the motion has grown to {largest:.1g} times the size of the mechanism, or as many rad:"
            " small differences are lost in rounding there, so there is no exponent; end the run earlier, or add what"
            " limits it"
        )


def _renew(base: Any, two: Any, share: float = 1.0) -> None:
    """Scale the distance of the second run by `share`, project it, and give it the contact memory of the first."""
    t = float(base.clock[at.T])
    y, other = base.workspace.state, two.workspace.state
    layout = state_layout(base.system)
    scaled = [layout.motion, layout.states]  # energies and impulses are those of `base`
    kept = [y[part] + share * (other[part] - y[part]) for part in scaled]
    other[:] = y
    for part, values in zip(scaled, kept, strict=True):
        other[part] = values
    memory, old = base.workspace.contact_memory, two.workspace.contact_memory
    both = (memory[:, at.CLOSED] == at.SHUT) & (old[:, at.CLOSED] == at.SHUT)
    speed = np.where(both, memory[:, at.SPEED] + share * (old[:, at.SPEED] - memory[:, at.SPEED]), memory[:, at.SPEED])
    old[:] = memory
    old[:, at.SPEED] = speed
    if base.stepper.leaf.loop == EVENT_DRIVEN:
        two.workspace.mode[:] = base.workspace.mode
        _must(two, two.begin(t))
    else:
        handle = two.workspace
        step_loop.finish_step(handle, t, other, two.workspace.rate)
        two.workspace.audit[at.STARTED] = 0.0  # energies are counted anew
        remember_end(handle)
        pass_on(handle)
    two.clock[:] = base.clock


def _go(run: Any, t: float) -> None:
    status = PAUSED
    while status == PAUSED:
        status = run.advance(t, 2000)
        run.tally[at.FOUND] = run.tally[at.EVENT_COUNT] = 0
    _must(run, status)


def _must(run: Any, status: int) -> None:
    if status not in (PAUSED, DONE):
        raise InputError(f"{run.trouble(status)}; so there is no exponent")
