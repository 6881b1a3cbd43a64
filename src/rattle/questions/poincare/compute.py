"""Poincare section: a motion sampled once per turn of its driver, or whenever a curve crosses a level."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.driver_period import driver_period
from rattle.description.toml_locations import caret_under
from rattle.errors import InputError, ModelError, Problem, SolverError, suggest
from rattle.language import arrays
from rattle.language.expression import dimension
from rattle.language.syntax import ExpressionError, Name, Node, parse, walk
from rattle.language.times import Seconds, seconds
from rattle.language.units import TIME, describe, dimension_of
from rattle.results.display import quantity, table
from rattle.results.sampled_curve import SampledCurve

PER_STEP = 4  # instants for each step, in which a curve may rise and fall: between two of them a rise is not seen
MOST_INSTANTS = 1_000_000
NARROWINGS, PARTS = 3, 16  # an interval of outputs around a crossing is cut so often into so many parts, of which a
# parabola through three points loses the cube: 1e-11 of it
NEWTON = 4  # steps to the root of a parabola that is nearly straight
FARTHEST = 2.0  # halves of the last interval that a crossing may lie from its middle: beyond, there is none

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


def period_of(m: Mechanism, period: Seconds | None) -> float:
    """The given period [s], or that of the driver; a text may be an expression over parameters, such as "2*pi/w".

    Raises InputError if there is none, or if it is not positive, ModelError for a text that cannot be read.
    """
    duration = driver_period(m.system) if period is None else _seconds(m, period)
    if duration is None:
        raise InputError("no driver turns at constant rate; give the period in s, or a crossing")
    if not 0.0 < duration < math.inf:
        raise InputError(f"period must be positive and finite, got {duration}")
    return duration


def _seconds(m: Mechanism, period: Seconds) -> float:
    """A given period [s] with the present values of the parameters."""
    if not isinstance(period, str) or (text := _expression(period)) is None:
        return seconds(period, "period")
    parameters = m.model.parameters
    try:
        for part in walk(text):
            if isinstance(part, Name) and part.name not in parameters:
                raise ExpressionError(f"no parameter '{part.name}'{suggest(part.name, parameters)}", part.column)
        seen = dimension(text, lambda name: dimension_of(parameters[name].unit) if parameters[name].unit else None)
        if seen not in (None, TIME):
            raise ExpressionError(f"this is {describe(seen)}; expected {describe(TIME)}", text.column)
    except ExpressionError as error:
        problem = Problem((), f"period: {error}", column=error.column)
        problem.caret = caret_under(period, error.column + 1)
        raise ModelError([problem]) from None
    with np.errstate(all="ignore"):
        return float(arrays.evaluate(text, lambda name: parameters[name].value))


def _expression(text: str) -> Node | None:
    """A text as an expression, which "20 ms" is too; None for what is none."""
    try:
        return parse(text)
    except ExpressionError:
        return None


@dataclass(frozen=True, repr=False)
class Section:
    """Points of a Poincare section."""

    t: np.ndarray  # (n,) [s]
    values: Mapping[str, np.ndarray]  # name -> (n,) [SI]
    units: Mapping[str, str]
    rule: str  # when the points were taken
    interrupted: bool = False  # stopped by the user
    clearances: Mapping[str, float] = field(default_factory=dict)  # of the pins [m]
    message: str = ""  # why its run stopped early, so that points are missing

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[name]

    def _repr_html_(self) -> str:
        rows = [
            (name, quantity(float(curve.min()), unit, 6), quantity(float(curve.max()), unit, 6))
            for (name, curve), unit in zip(self.values.items(), map(self.units.__getitem__, self.values), strict=True)
            if len(curve)
        ]
        title = f"Poincare section: {len(self.t)} points, {self.rule}"
        return table(("curve", "least", "greatest"), rows, title, [self.message] if self.message else [], "s.plot()")

    def __repr__(self) -> str:
        return f"<rattle.Section: {len(self.t)} points of {', '.join(self.values)}, {self.rule}>"

    @overload
    def plot(self, x: str | None = None, y: str | None = None, ax: None = None) -> Figure: ...
    @overload
    def plot(self, x: str | None = None, y: str | None = None, *, ax: Axes) -> Axes: ...
    def plot(self, x: str | None = None, y: str | None = None, ax: Axes | None = None) -> Figure | Axes:
        """Plot the points of two of the names (default: the first two), coloured by time.

        Returns a new figure, or `ax` if it is given.  Raises InputError for a section with one name.
        """
        from rattle.questions.poincare.pictures import plot_section

        names = list(self.values)
        if x is None or y is None:
            if len(names) < 2:
                raise InputError(f"a plot of a section needs two curves, this one has {', '.join(names)}")
            x, y = names[:2]
        return plot_section(self, x, y, ax)


def section(
    m: Mechanism, names: Sequence[str], *, period: Seconds | None = None, crossing: str | None = None,
    level: float = 0.0, skip: int = 50, points: int = 500, method: str | None = None, rtol: float | None = None,
    atol: float | None = None, step: float | None = None,
) -> Section:  # fmt: skip
    """Values [SI] of some names of a result once per period, or whenever a curve rises through a level.

    period: [s] or an expression over parameters (default: one turn of the driver).
    crossing: a name; its rises through `level` [SI] are located on the dense output of the steps, between at least 200
    outputs per period or mean distance of crossings.  A jump from below to above, as of a rate in an impact, is a rise
    too: its point has the values just after it.
    skip: points left out at the start.  points: number of points (there may be fewer crossings).
    method, rtol, atol, step: as in `simulate`.  Raises InputError for wrong arguments or if nothing crosses,
    SolverError if the run stops before the first point, UnknownName for a name that the result does not have.
    """
    arguments.whole("skip", skip, 0)
    arguments.whole("points", points, 1)
    settings: dict[str, Any] = {"method": method, "rtol": rtol, "atol": atol, "step": step}
    if crossing is None:
        T = period_of(m, period)
        times = T * (skip + np.arange(points))
        r = m.simulate(float(times[-1]), t_eval=times, **settings)
        if not len(r.t):
            require_run(r, f"the first point is that at t = {times[0]:.4g} s, after {skip} periods")
        return Section(
            r.t, {n: r[n] for n in names}, {n: r.unit(n) for n in names}, f"every {T:.4g} s{stopped(r)}",
            r.interrupted, pins(m), r.message,
        )  # fmt: skip
    span = (skip + points) * period_of(m, period) if period is not None else m.model.settings.t_end
    count = 200 * (skip + points)
    r = m.simulate(span, t_eval=np.linspace(0.0, span, count + 1), **settings)
    if (finer := min(PER_STEP * int(r.stats["steps"]), MOST_INSTANTS)) > count and not r.interrupted:
        r = m.simulate(span, t_eval=np.linspace(0.0, span, finer + 1), **settings)
    rises = Rises.of(r, crossing, level)
    kept = rises.part(slice(skip, skip + points))
    if not len(kept.t):
        require_crossings(r, crossing, level, len(rises.t), skip)
    times, values = _located(m, r, crossing, level, kept, names, {**settings, "t_end": span})
    rule = f"{crossing} rises through {level:g}{stopped(r)}"
    return Section(times, values, {n: r.unit(n) for n in names}, rule, r.interrupted, pins(m), r.message)


class Rises(NamedTuple):
    """Instants at which a curve rises through a level, on the cubics through its outputs."""

    t: np.ndarray  # (n,) [s]
    width: np.ndarray  # (n,) of the interval of outputs [s]; 0 where it jumps
    after: np.ndarray  # (n,) row of the output that ends it

    @classmethod
    def of(cls, r: Result, name: str, level: float) -> Rises:
        """All rises of a curve of a result through a level [SI]."""
        whole = r.with_breaks
        if len(whole.t) < 2:
            return cls(np.zeros(0), np.zeros(0), np.zeros(0, np.int64))
        interval, t = SampledCurve(whole.t, whole[name]).rises(level)
        return cls(t, np.diff(whole.t)[interval], interval + 1)

    def part(self, which: slice) -> Rises:
        """Some of them."""
        return Rises(self.t[which], self.width[which], self.after[which])


def _located(
    m: Mechanism, r: Result, crossing: str, level: float, rises: Rises, names: Sequence[str], settings: dict[str, Any]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Instants (n,) [s] of rises, and the values [SI] of some names there.

    The same run again gives the dense output where it is asked for: around each rise, in ever narrower intervals, as
    there may be a contact between two outputs, and at last at three instants, through which a parabola is within
    rounding of it.  At a jump the values are those of the row just after it.
    """
    times = rises.t.copy()
    values = {name: r.with_breaks[name][rises.after] for name in names}
    smooth = np.flatnonzero(rises.width > 0.0)
    ends = r.with_breaks.t[rises.after[smooth, None] + [-1, 0]]
    for _ in range(NARROWINGS if len(smooth) else 0):
        ends = _narrower(m, ends, crossing, level, settings)
    middle, near = ends.mean(axis=1), 0.5 * np.diff(ends)[:, 0]
    around = middle[:, None] + near[:, None] * [-1.0, 0.0, 1.0]
    again = m.simulate(t_eval=np.unique(around), **settings) if len(around) else r
    for k, t, h in zip(smooth, around, near, strict=True):
        rows = np.searchsorted(again.t, t)
        if len(again.t) <= rows[2]:  # stopped by the user
            continue
        u = _root(again[crossing][rows] - level)
        times[k] = t[1] + h * u
        for name in names:
            values[name][k] = _parabola(again[name][rows], u)
    return times, values


def _narrower(m: Mechanism, ends: np.ndarray, crossing: str, level: float, settings: dict[str, Any]) -> np.ndarray:
    """The parts of intervals (n, 2) [s] in which a curve rises through a level: the first ones."""
    grid = np.linspace(ends[:, 0], ends[:, 1], PARTS + 1, axis=1)
    grid[:, PARTS] = ends[:, 1]  # not beyond the run by rounding
    finer = m.simulate(t_eval=np.unique(grid), **settings)
    narrowed = ends.copy()
    for k, instants in enumerate(grid):
        rows = np.searchsorted(finer.t, instants)
        if rows[PARTS] >= len(finer.t):  # stopped by the user
            continue
        below = finer[crossing][rows] < level
        up = np.flatnonzero(below[:-1] & ~below[1:])
        if len(up):
            narrowed[k] = instants[up[0] : up[0] + 2]
    return narrowed


def _root(y: np.ndarray) -> float:
    """Where the parabola through y (3,) at -1, 0, 1 is zero: the root nearest to 0."""
    slope, bend = 0.5 * (y[2] - y[0]), 0.5 * (y[2] + y[0]) - y[1]
    u = -y[1] / slope if slope else 0.0
    for _ in range(NEWTON):
        rate = slope + 2.0 * bend * u
        u -= (y[1] + u * (slope + bend * u)) / rate if rate else 0.0
    return float(u) if abs(u) < FARTHEST else 0.0


def _parabola(y: np.ndarray, u: float) -> float:
    """Value at u of the parabola through y (3,) at -1, 0, 1."""
    return float(y[1] + u * (0.5 * (y[2] - y[0]) + u * (0.5 * (y[2] + y[0]) - y[1])))


def require_crossings(r: Result, name: str, level: float, count: int, skip: int) -> None:
    """Say why no point is left of the `count` rises of a curve through a level [SI]; see `section`."""
    low, high, unit = min(r[name], default=math.nan), max(r[name], default=math.nan), r.unit(name)
    often = f"it rises through {level:g} {unit} {count} times" if count else f"it never rises through {level:g} {unit}"
    facts = (
        f"{name} goes from {low:.4g} to {high:.4g} {unit}; {often} in {r.trust.t_end:.4g} s, and skip leaves out {skip}"
    )
    require_run(r, facts)
    if not r.interrupted:
        raise InputError(
            f"no point: {facts}; give another crossing, level or period (its run is skip + points periods long)"
        )


def require_run(r: Result, facts: str) -> None:
    """Raise SolverError for a run that has stopped before the first point; facts: what is known about that point."""
    if not r.success and not r.interrupted:
        raise SolverError(f"no point: the run stopped at t = {r.trust.t_end:.6g} s, {r.message}; {facts}", r)


def pins(m: Mechanism) -> dict[str, float]:
    """Clearances of the pins [m]."""
    return {n: joint.clearance for n, joint in m.model.joints.items() if joint.clearance > 0.0 and joint.play.orbit}


def stopped(r: Result) -> str:
    """The end of a title for a run that ended early; "" for others."""
    if r.success and not r.interrupted:
        return ""
    return f", stopped {'by the user ' if r.interrupted else ''}at t = {r.trust.t_end:.4g} s"
