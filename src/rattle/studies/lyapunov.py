"""Largest Lyapunov exponent: the rate at which neighbouring motions separate.

Sources: Wolf, Swift, Swinney, Vastano, Determining Lyapunov exponents from a time series, Physica D 16 (1985)
285-317; Benettin, Galgani, Strelcyn, Kolmogorov entropy and numerical experiments, Phys. Rev. A 14 (1976) 2338.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.assembly.rank import rank
from rattle.analyses.dynamics.methods import choose_stepper, new_run
from rattle.analyses.dynamics.run import How
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.equations.motion import DONE, PAUSED
from rattle.equations.state import state_layout
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.results.display import lines
from rattle.solvers import step_loop
from rattle.solvers.contacts.contact_events import pass_on, remember_end
from rattle.solvers.stepper import ATOL, EVENT_DRIVEN, FREE, usual_stepper

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

APART = 1e-7  # distance to which the second run is rescaled, positions in mechanism lengths
LARGEST_GROWTH = 1e4  # of that distance in a stretch; above it the growth is not linear
UNSURE = 0.8  # uncertainty, as a share of the exponent, above which the exponent is not determined
ROUGH = 0.3  # the same above which it is called rough
ENOUGH = 100.0  # growth of differences below which the motion may be regular: there they grow in proportion to time
LATE = 6  # how often the end of a stretch is postponed if one of the two runs has just had an impact
BLOCKS = 10  # parts of the run from whose scatter the uncertainty follows
SPREAD = 1.2  # variance of the slope of the best line through a random walk, as a share of that of its mean step
STUDENT = 2.262  # 95 % of Student's t with BLOCKS - 1 degrees of freedom


class Lyapunov(NamedTuple):
    """Largest Lyapunov exponent: small differences grow as exp(exponent t)."""

    exponent: float  # [1/s]
    uncertainty: float  # 95 %, from the scatter of 10 parts of the run [1/s]
    span: float  # time over which it was measured [s]
    growth: np.ndarray  # (n,) natural logarithm of the growth in every stretch [-]
    stretch: float  # length of a stretch [s]

    @property
    def chaotic(self) -> bool:
        """True if the exponent exceeds its uncertainty and differences grew at least a hundredfold."""
        return self.exponent > self.uncertainty and self.exponent * self.span > math.log(ENOUGH)

    def horizon(self, error: float = 1e-9, seen: float = 1e-2) -> float:
        """Time [s] in which a relative error [-] grows to the size `seen` [-]; inf without growth."""
        return math.log(seen / error) / self.exponent if self.exponent > 0.0 else math.inf

    def __repr__(self) -> str:
        return f"<rattle.Lyapunov: {self.exponent:.3g} +- {self.uncertainty:.2g} 1/s over {self.span:.4g} s>"

    def _repr_html_(self) -> str:
        return lines(str(self))

    def __str__(self) -> str:
        said = f"largest Lyapunov exponent {self.exponent:.3g} +- {self.uncertainty:.2g} 1/s over {self.span:.4g} s"
        if not self.uncertainty <= UNSURE * abs(self.exponent) and self.uncertainty * self.span > math.log(ENOUGH):
            return f"{said}: not determined, the uncertainty is as large as the exponent; run much longer"
        if self.exponent > self.uncertainty and not self.chaotic:
            seen = math.exp(self.exponent * self.span)
            return f"{said}: differences grew only {seen:.2g}-fold; a longer run shows whether the growth continues"
        if not self.chaotic:
            return f"{said}: no exponential growth of errors beyond the uncertainty"
        tenfold = math.log(10.0) / self.exponent
        if self.uncertainty > ROUGH * self.exponent:
            said += f" (rough: uncertain by {100 * self.uncertainty / self.exponent:.0f} %)"
        return f"{said}: an error grows tenfold every {tenfold:.2g} s, from 1e-9 to 1 % in {self.horizon():.2g} s"


def lyapunov(
    m: Mechanism, t_end: float | None = None, *, stretch: float | None = None, skip: float = 0.2, rtol: float = 1e-10
) -> Lyapunov:
    """Largest Lyapunov exponent, from two neighbouring runs.

    The second run starts at a distance of 1e-7 in a direction that is the same in every call.  After every stretch of
    time the difference is measured, scaled back to 1e-7 and projected onto the constraints, contact memory included.

    t_end: duration [s] (default: that of the model).  stretch: [s] (default: t_end/400, shorter if the growth is
    too fast).  skip: share [-] of the run left out at the start, until the difference has turned to the direction of
    largest growth.  rtol: relative tolerance [-] of both runs.
    The exponent is the slope of the best line through the logarithm of the growth over time.
    With set-valued contacts both runs are event-driven; a stretch lasts a little longer if at its end one run has had
    an impact that the other is about to have.
    Raises ValueError if the drivers determine every position (then nothing can grow), or if a run cannot go on.
    """
    functions.start()
    span = arguments.positive("t_end", m.model.settings.t_end if t_end is None else t_end)
    length = span / 400 if stretch is None else arguments.positive("stretch", stretch)
    rtol = arguments.relative_tolerance(rtol)
    if 2 * BLOCKS * length > span * (1.0 + 1e-9):
        raise ValueError(f"a stretch of {length:g} s is too long for {span:g} s; take at most a {2 * BLOCKS}th of it")
    if not 0.0 <= skip < 1.0:
        raise ValueError(f"skip must be a share of the run, from 0 to below 1; got {skip}")
    _require_mobility(m)
    for _ in range(6):
        growth = _growths(m, span, length, rtol)
        if growth is not None:
            break
        length /= 4.0
    else:
        raise ValueError(f"differences grow too fast even over {length:.3g} s; give a shorter stretch")
    kept = growth[int(skip * len(growth)) :]
    blocks = np.array([part.mean() for part in np.array_split(kept, BLOCKS)]) / length
    error = STUDENT * float(blocks.std(ddof=1)) * math.sqrt(SPREAD / BLOCKS)
    return Lyapunov(_slope(kept) / length, error, len(kept) * length, growth, length)


def _slope(growth: np.ndarray) -> float:
    """Mean growth per stretch [-]: slope of the best line through the sums of `growth` (n,).

    The plain mean depends only on the two ends.  Differences that rotate while they grow oscillate by a bounded amount,
    which enters the plain mean divided by n, but the slope divided by n^2.
    """
    n = len(growth)
    k = np.arange(1, n + 1)
    return float(6.0 / (n * (n + 1) * (n + 2)) * np.sum(k * (n + 1 - k) * growth))


def _require_mobility(m: Mechanism) -> None:
    """Raise ValueError for a mechanism without a degree of freedom in which motions could separate."""
    system, workspace = m.system, m.system.workspace()
    if len(system.arrays["contact"]) or system.row_count > LARGE:
        return
    open_by(workspace, m.start.t, m.start.q, m.start.v)
    if rank(system, workspace) == 3 * system.body_count:
        raise ValueError(
            "the drivers fix every position: there is no degree of freedom in which errors could grow, so no exponent"
            " (a joint with clearance, or one driver less, gives one)"
        )


def _growths(m: Mechanism, span: float, length: float, rtol: float) -> np.ndarray | None:
    """(n,) logarithm of the growth in every stretch of `length` [s] over `span` [s]; None if one is not linear."""
    stepper, _ = choose_stepper(m.system, usual_stepper(FREE), None, span)
    how = How(stepper, rtol, ATOL * rtol, None)
    none = np.zeros(0)
    one, two = (new_run(m.system, m.start, none, span, how) for _ in range(2))
    nq = 3 * m.system.body_count
    weight = np.concatenate([np.tile([1.0 / m.system.size, 1.0 / m.system.size, 1.0], m.system.body_count)] * 2)
    weight[nq:] *= length
    for run in (one, two):
        _must(run, run.begin(m.start.t))
    offset = np.random.default_rng(1).normal(size=2 * nq) / weight
    two.workspace.state[: 2 * nq] += APART / math.sqrt(2 * nq) * offset
    _renew(one, two)
    apart = _distance(one, two, weight)
    count = max(BLOCKS * 2, round(span / length))
    growth = np.zeros(count)
    for k in range(count):
        t = m.start.t + (k + 1) * length
        for late in range(LATE + 1):
            for run in (one, two):
                _go(run, t + late * length / 64.0)
            now = _distance(one, two, weight)
            if now < LARGEST_GROWTH * APART:
                break
            if late == LATE or stepper.leaf.loop != EVENT_DRIVEN:
                return None
        growth[k] = math.log(now / apart) if now > 0.0 < apart else 0.0
        _renew(one, two, APART / now if now > 0.0 else 1.0)
        apart = _distance(one, two, weight)
    return growth


def _distance(one: Any, two: Any, weight: np.ndarray) -> float:
    n = len(weight)
    return float(np.linalg.norm(weight * (two.workspace.state[:n] - one.workspace.state[:n])))


def _renew(one: Any, two: Any, share: float = 1.0) -> None:
    """Scale the distance of the second run by `share`, project it, and give it the contact memory of the first."""
    t = float(one.clock[at.T])
    y, other = one.workspace.state, two.workspace.state
    layout = state_layout(one.system)
    scaled = [layout.motion, layout.states]  # energies and impulses are those of `one`
    kept = [y[part] + share * (other[part] - y[part]) for part in scaled]
    other[:] = y
    for part, values in zip(scaled, kept, strict=True):
        other[part] = values
    memory, old = one.workspace.contact_memory, two.workspace.contact_memory
    both = (memory[:, at.CLOSED] == at.SHUT) & (old[:, at.CLOSED] == at.SHUT)
    speed = np.where(both, memory[:, at.SPEED] + share * (old[:, at.SPEED] - memory[:, at.SPEED]), memory[:, at.SPEED])
    old[:] = memory
    old[:, at.SPEED] = speed
    if one.stepper.leaf.loop == EVENT_DRIVEN:
        two.workspace.mode[:] = one.workspace.mode
        _must(two, two.begin(t))
    else:
        handle = two.workspace
        step_loop.finish_step(handle, t, other, two.workspace.rate)
        two.workspace.audit[at.STARTED] = 0.0  # energies are counted anew
        remember_end(handle)
        pass_on(handle)
    two.clock[:] = one.clock


def _go(run: Any, t: float) -> None:
    status = PAUSED
    while status == PAUSED:
        status = run.advance(t, 2000)
        run.tally[at.FOUND] = run.tally[at.EVENT_COUNT] = 0
    _must(run, status)


def _must(run: Any, status: int) -> None:
    if status not in (PAUSED, DONE):
        raise ValueError(f"{run.trouble(status)}; so there is no exponent")
