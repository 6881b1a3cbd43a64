"""Tools for chaotic motion: Poincare section, bifurcation over a parameter, largest Lyapunov exponent.

Sources: Wolf, Swift, Swinney, Vastano, Determining Lyapunov exponents from a time series, Physica D 16 (1985)
285-317; Benettin, Galgani, Strelcyn, Kolmogorov entropy and numerical experiments, Phys. Rev. A 14 (1976) 2338.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.assembly.rank import rank
from rattle.analyses.assembly.unclosed import driver_slot
from rattle.analyses.dynamics.run import stop
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.equations.motion import DONE, PAUSED, drive
from rattle.equations.system import System
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.results.display import lines
from rattle.solvers import step_loop
from rattle.solvers.contact_events import pass_on, remember_end
from rattle.solvers.step_audit import STARTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result

APART = 1e-7  # distance at which the second run of a Lyapunov exponent starts anew, positions in mechanism lengths
LARGEST_GROWTH = 1e4  # of that distance between two renewals; beyond it the growth is no longer linear
UNSURE = 0.8  # uncertainty, as a share of the exponent, beyond which it is not determined
ROUGH = 0.3  # the same beyond which it is called rough
ENOUGH = 100.0  # growth of differences below which motion may be regular yet: there they grow in proportion to time
LATE = 6  # times that the end of a stretch is put off, where one of two runs has just had an impact
BLOCKS = 10  # parts of the run from whose scatter the uncertainty follows
SPREAD = 1.2  # variance of the slope of the best line through a random walk, as a share of that of its mean step
STUDENT = 2.262  # 95 % of Student's t with BLOCKS - 1 degrees of freedom


# ---------------------------------------------------------------- period of the driver
def driver_period(system: System) -> float | None:
    """Time of one turn [s] of the first driver that turns a joint at constant rate; None where there is none."""
    memory = system.memory()
    for n, name in enumerate(system.joints):
        if name not in system.model.drivers or system.rows[system.arrays["joint"][n, 4]].unit != "rad":
            continue
        slot = int(system.arrays["joint"][n, 3]) + driver_slot(system, n)
        rates = []
        for t in (0.0, 0.0137, 0.171, 1.93):
            drive(memory, t)
            rates.append(float(memory.values[slot + 1]))
        if rates[0] and max(rates) - min(rates) <= 1e-9 * abs(rates[0]):
            return 2.0 * math.pi / abs(rates[0])
    return None


def _period(m: Mechanism, period: float | None) -> float:
    found = period if period is not None else driver_period(m.system)
    if found is None:
        raise ValueError("no driver turns at constant rate; give the period in s, or a crossing")
    if not 0.0 < found < math.inf:
        raise ValueError(f"period must be positive and finite, got {found}")
    return found


# ---------------------------------------------------------------- Poincare section
@dataclass(frozen=True, repr=False)
class Section:
    """Points of a Poincare section."""

    t: np.ndarray  # (n,) [s]
    values: Mapping[str, np.ndarray]  # name -> (n,)
    units: Mapping[str, str]
    rule: str  # when the points were taken
    interrupted: bool = False  # the user stopped the run
    clearances: Mapping[str, float] = field(default_factory=dict)  # of the pins [m]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[name]

    def __repr__(self) -> str:
        return f"<rattle.Section: {len(self.t)} points of {', '.join(self.values)}, {self.rule}>"

    @overload
    def plot(self, x: str | None = None, y: str | None = None, ax: None = None) -> Figure: ...
    @overload
    def plot(self, x: str | None = None, y: str | None = None, *, ax: Axes) -> Axes: ...
    def plot(self, x: str | None = None, y: str | None = None, ax: Axes | None = None) -> Figure | Axes:
        """The points of two of the names (default: the first two), coloured by time.

        ax: draw there.  Returns a new figure, or `ax` where it is given.
        """
        from rattle.plots.chaos import plot_section

        names = list(self.values)
        if x is None or y is None:
            if len(names) < 2:
                raise ValueError(f"a picture of a section wants two curves, this one has {', '.join(names)}")
            x, y = names[:2]
        return plot_section(self, x, y, ax)


def section(
    m: Mechanism, names: Sequence[str], *, period: float | None = None, crossing: str | None = None, level: float = 0.0,
    skip: int = 50, points: int = 500, method: str | None = None, rtol: float | None = None, atol: float | None = None,
    step: float | None = None,
) -> Section:  # fmt: skip
    """Values of some names of a result once per period, or whenever a curve rises through a level.

    period: [s] (default: one turn of the driver).  crossing: a name; its rises through `level` [SI] are located on
    a cubic spline of the output, of which there are then at least 200 per period or mean distance of crossings.
    skip: points left out at the start.  points: how many are wanted (a crossing may come less often than that).
    method, rtol, atol, step: as in `simulate`.  Raises ValueError, UnknownName.
    """
    arguments.whole("skip", skip, 0)
    arguments.whole("points", points, 1)
    settings: dict[str, Any] = {"method": method, "rtol": rtol, "atol": atol, "step": step}
    if crossing is None:
        T = _period(m, period)
        times = T * (skip + np.arange(points))
        r = m.simulate(float(times[-1]), t_eval=times, **settings)
        return Section(
            r.t, {n: r[n] for n in names}, {n: r.unit(n) for n in names}, f"every {T:.4g} s{_stopped(r)}",
            r.interrupted, _pins(m),
        )  # fmt: skip
    from scipy.interpolate import CubicSpline

    span = (skip + points) * period if period is not None else m.model.settings.t_end
    r = m.simulate(span, t_eval=np.linspace(0.0, span, 200 * (skip + points) + 1), **settings)
    curve = r[crossing] - level
    roots = CubicSpline(r.t, curve).solve(0.0, extrapolate=False)
    rate = CubicSpline(r.t, curve).derivative()
    rises = np.array([t for t in np.ravel(roots) if rate(t) > 0.0])
    times = rises[skip:][:points]
    if not len(times) and not r.interrupted:
        low, high, unit = float(r[crossing].min()), float(r[crossing].max()), r.unit(crossing)
        why = f"it rises through {level:g} {unit} {len(rises)} times in {span:g} s" if len(rises) else (
            f"it never rises through {level:g} {unit}"
        )  # fmt: skip
        raise ValueError(
            f"no point: {crossing} goes from {low:.4g} to {high:.4g} {unit}; {why}, and skip leaves out {skip};"
            " give another crossing, level or period (its run is skip + points periods long)"
        )
    values = {n: CubicSpline(r.t, r[n])(times) if len(times) else np.zeros(0) for n in names}
    rule = f"{crossing} rises through {level:g}{_stopped(r)}"
    return Section(times, values, {n: r.unit(n) for n in names}, rule, r.interrupted, _pins(m))


def _pins(m: Mechanism) -> dict[str, float]:
    """Clearances of the pins [m]."""
    return {n: one.clearance for n, one in m.model.joints.items() if one.kind == "revolute" and one.clearance > 0.0}


def _stopped(r: Result) -> str:
    """What to say of a run that the user ended."""
    return f", stopped by the user at t = {r.trust.t_end:.4g} s" if r.interrupted else ""


# ---------------------------------------------------------------- bifurcation
@dataclass(frozen=True, repr=False)
class Bifurcation:
    """Points of a Poincare section over a parameter."""

    parameter: str
    values: np.ndarray  # (k,) of the parameter [SI]
    parameter_unit: str
    of: str  # the name of the output
    of_unit: str
    points: np.ndarray  # (k, points) of the output [SI]; nan where a run ended early
    rule: str
    interrupted: bool = False  # the user stopped it; values that were not reached have nan

    def __repr__(self) -> str:
        first, last = self.values[[0, -1]] if len(self.values) else (0.0, 0.0)
        shape = (
            f"{len(self.values)} values of {self.parameter} from {first:g} to {last:g} {self.parameter_unit}".rstrip()
        )
        return f"<rattle.Bifurcation: {self.of} over {shape}, {self.points.shape[1]} points each>"

    @overload
    def plot(self, ax: None = None) -> Figure: ...
    @overload
    def plot(self, ax: Axes) -> Axes: ...
    def plot(self, ax: Axes | None = None) -> Figure | Axes:
        """Points over the parameter, on a new figure; with `ax` there, and `ax` is returned."""
        from rattle.plots.chaos import plot_bifurcation

        return plot_bifurcation(self, ax)


def bifurcation(
    m: Mechanism, parameter: str, values: Sequence[float] | np.ndarray, of: str, *, period: float | None = None,
    skip: int = 100, points: int = 100, method: str | None = None, rtol: float | None = None,
    atol: float | None = None, step: float | None = None, threads: int | None = None, progress: bool = False,
) -> Bifurcation:  # fmt: skip
    """What an output does once per period, over the values of a parameter: bands, branches, chaos.

    Every run starts as the model says; `skip` periods go by before `points` points are taken.  period: [s] (default:
    one turn of the driver, anew for every value).  threads: runs at the same time (default: as many as cores);
    the result does not depend on it.  method, rtol, atol, step: as in `simulate`.
    Raises ModelError, ValueError, UnknownName.
    """
    arguments.whole("skip", skip, 0)
    arguments.whole("points", points, 1)
    given = np.asarray(values, dtype=float)
    if not given.size or given.ndim != 1:
        raise ValueError("values of the parameter: at least one is needed, in one row")
    changed = [m.set({parameter: float(value)}) for value in given]

    def run(one: Mechanism) -> tuple[np.ndarray, str]:
        times = _period(one, period) * (skip + np.arange(points))
        r = one.simulate(float(times[-1]), t_eval=times, method=method, rtol=rtol, atol=atol, step=step)
        if r.interrupted:
            raise KeyboardInterrupt
        found = np.full(points, np.nan)
        found[: len(r.t)] = r[of]
        return found, r.unit(of)

    bar = _bar(len(changed)) if progress else None
    rows: list[np.ndarray] = []
    unit = ""
    interrupted = False
    pool = ThreadPoolExecutor(threads)
    try:
        for k in range(len(changed)):
            if k == 0:  # compiles what is not compiled yet, alone
                row, unit = run(changed[0])
                waiting = [pool.submit(run, one) for one in changed[1:]]
            else:
                row, _ = waiting[k - 1].result()
            rows.append(row)
            if bar is not None:
                bar.update()
    except KeyboardInterrupt:
        if not rows:
            raise
        interrupted = True
        stop.set()  # the runs in other threads end now too
    finally:
        pool.shutdown(cancel_futures=True)
        if interrupted:
            stop.clear()
        if bar is not None:
            bar.close()
    what = m.model.parameters.get(parameter)
    rule = f"once every {period:.4g} s" if period is not None else "once per turn of the driver"
    if interrupted:
        rule += f", stopped by the user after {len(rows)} of {len(given)} values"
        rows += [np.full(points, np.nan)] * (len(given) - len(rows))
    return Bifurcation(parameter, given, what.unit if what else "", of, unit, np.array(rows), rule, interrupted)


def _bar(total: int) -> Any:
    from tqdm import tqdm

    return tqdm(total=total, desc="bifurcation", unit="run")


# ---------------------------------------------------------------- Lyapunov exponent
class Lyapunov(NamedTuple):
    """Largest Lyapunov exponent: small differences grow like exp(exponent t)."""

    exponent: float  # [1/s]
    uncertainty: float  # 95 %, from the scatter of 10 parts of the run [1/s]
    span: float  # time over which it was measured [s]
    growth: np.ndarray  # (n,) logarithm of the growth of every stretch
    stretch: float  # length of a stretch [s]

    @property
    def chaotic(self) -> bool:
        """True where the exponent is positive beyond its uncertainty, and was seen for long enough."""
        return self.exponent > self.uncertainty and self.exponent * self.span > math.log(ENOUGH)

    def horizon(self, error: float = 1e-9, seen: float = 1e-2) -> float:
        """Time [s] in which a relative error grows to what is seen; inf without growth."""
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
            return f"{said}: differences grew {seen:.2g}-fold only; a longer run tells whether that goes on"
        if not self.chaotic:
            return f"{said}: no exponential growth of errors beyond the uncertainty"
        tenfold = math.log(10.0) / self.exponent
        if self.uncertainty > ROUGH * self.exponent:
            said += f" (a rough number: uncertain by {100 * self.uncertainty / self.exponent:.0f} %)"
        return f"{said}: an error grows tenfold every {tenfold:.2g} s, from 1e-9 to 1 % in {self.horizon():.2g} s"


def lyapunov(
    m: Mechanism, t_end: float | None = None, *, stretch: float | None = None, skip: float = 0.2, rtol: float = 1e-10
) -> Lyapunov:
    """Largest Lyapunov exponent, from two runs next to each other.

    The second run starts 1e-7 away in a direction that is the same in every call; after every stretch of time the
    difference is measured, scaled back to 1e-7 and brought onto the constraints again, contact memory included.

    t_end: duration [s] (default: what the model says).  stretch: [s] (default: t_end/400, shorter where growth is
    too fast).  skip: share of the run left out at the start, until the difference has turned to the direction that
    grows most.  rtol: of both runs.
    The exponent is the slope of the line that fits the logarithm of the growth best, over time.
    With set-valued contacts both runs go from event to event; a stretch at whose end one of them has had an impact
    that the other is about to have lasts a little longer.
    Raises ValueError where the drivers fix every position (then nothing can grow), or the run cannot go on.
    """
    functions.start()
    span = arguments.positive("t_end", m.model.settings.t_end if t_end is None else t_end)
    length = span / 400 if stretch is None else arguments.positive("stretch", stretch)
    rtol = arguments.relative_tolerance(rtol)
    if 2 * BLOCKS * length > span * (1.0 + 1e-9):
        raise ValueError(f"a stretch of {length:g} s is too long for {span:g} s; wanted at most a {2 * BLOCKS}th of it")
    if not 0.0 <= skip < 1.0:
        raise ValueError(f"skip is a share of the run, from 0 to below 1; got {skip}")
    _require_freedom(m)
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
    """Mean growth per stretch: slope of the line that fits the sums of `growth` (n,) best.

    The plain mean knows the two ends alone, and differences that turn as they grow swing: by a bounded amount, which
    stands in it divided by n, but here divided by n^2.
    """
    n = len(growth)
    k = np.arange(1, n + 1)
    return float(6.0 / (n * (n + 1) * (n + 2)) * np.sum(k * (n + 1 - k) * growth))


def _require_freedom(m: Mechanism) -> None:
    """Refuse a mechanism in which nothing is free to grow apart."""
    system, memory = m.system, m.system.memory()
    if len(system.arrays["contact"]) or system.row_count > LARGE:
        return
    open_by(memory, m.start.t, m.start.q, m.start.v)
    if rank(system, memory) == 3 * system.body_count:
        raise ValueError(
            "the drivers fix every position: there is no freedom in which errors could grow, so no exponent"
            " (a joint with play, or a driver less, gives one)"
        )


def _growths(m: Mechanism, span: float, length: float, rtol: float) -> np.ndarray | None:
    """Logarithm of the growth in every stretch; None when one grows beyond linearity."""
    from rattle.analyses.dynamics.simulate import kind_of_run

    kind, method, _ = kind_of_run(m.system, "dop853", None, span)
    none = np.zeros(0)
    one, two = (kind(m.system, m.start, none, span, method, rtol, 1e-2 * rtol, None) for _ in range(2))
    nq = 3 * m.system.body_count
    weight = np.concatenate([np.tile([1.0 / m.system.size, 1.0 / m.system.size, 1.0], m.system.body_count)] * 2)
    weight[nq:] *= length
    for run in (one, two):
        _must(run, run.begin(m.start.t))
    offset = np.random.default_rng(1).normal(size=2 * nq) / weight
    two.memory.state[: 2 * nq] += APART / math.sqrt(2 * nq) * offset
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
            if late == LATE or method != "event":
                return None
        growth[k] = math.log(now / apart) if now > 0.0 < apart else 0.0
        _renew(one, two, APART / now if now > 0.0 else 1.0)
        apart = _distance(one, two, weight)
    return growth


def _distance(one: Any, two: Any, weight: np.ndarray) -> float:
    n = len(weight)
    return float(np.linalg.norm(weight * (two.memory.state[:n] - one.memory.state[:n])))


def _renew(one: Any, two: Any, share: float = 1.0) -> None:
    """Bring the second run to a share of its distance, onto its constraints, with the contact memory of the first."""
    t = float(one.clock[step_loop.T])
    y, other = one.memory.state, two.memory.state
    motion = 2 * len(one.memory.change)
    scaled = [slice(0, motion), slice(motion + 2, None, 4)]  # positions, rates and bristles; accounts are those of one
    kept = [y[part] + share * (other[part] - y[part]) for part in scaled]
    other[:] = y
    for part, values in zip(scaled, kept, strict=True):
        other[part] = values
    grip, old = one.memory.grip, two.memory.grip
    both = (grip[:, at.CLOSED] == at.SHUT) & (old[:, at.CLOSED] == at.SHUT)
    speed = np.where(both, grip[:, at.SPEED] + share * (old[:, at.SPEED] - grip[:, at.SPEED]), grip[:, at.SPEED])
    old[:] = grip
    old[:, at.SPEED] = speed
    if one.method == "event":
        two.memory.mode[:] = one.memory.mode
        _must(two, two.begin(t))
    else:
        handle = two.memory
        step_loop.finish_step(handle, t, other, two.memory.rate)
        two.memory.audit[STARTED] = 0.0  # energies are counted anew
        remember_end(handle)
        pass_on(handle)
    two.clock[:] = one.clock


def _go(run: Any, t: float) -> None:
    status = PAUSED
    while status == PAUSED:
        status = run.advance(t, 2000)
        run.tally[step_loop.FOUND] = run.tally[step_loop.EVENT_COUNT] = 0
    _must(run, status)


def _must(run: Any, status: int) -> None:
    if status not in (PAUSED, DONE):
        raise ValueError(f"{run.trouble(status)}; so there is no exponent")
