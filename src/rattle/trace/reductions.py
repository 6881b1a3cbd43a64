"""Numbers that sum up a curve over a run, gathered step by step while samples run side by side.

A step gives samples of every curve at its ends and at equal parts of it.  Between them a curve counts as the polynomial
through all of them: extremes are found on it by Newton's method, integrals by the closed formulas of Newton and Cotes
(Abramowitz, Stegun, Handbook of Mathematical Functions (1964), 25.4.16).  A maximum that this polynomial sees and the
parabola through the largest sample and its neighbours does not, as beside a kink, does not count.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from rattle.trace.graph import Graph, select
from rattle.trace.lane_methods import Recorded, inputs, largest, least, root, weighted

COTES = {  # by number of parts: weights of the samples
    1: (1 / 2, 1 / 2),
    2: (1 / 6, 4 / 6, 1 / 6),
    6: tuple(w / 840 for w in (41, 216, 27, 272, 27, 216, 41)),
}
NEWTON = 3  # iterations from the largest sample: the place is good to 1e-4 of a part, the value to rounding
STEEPEST = 2.0  # rise above the largest sample that counts, as a multiple of that of the parabola
NEVER = 9.0  # share of a step at which a condition begins that does not begin in it
AFTER = 1e-12  # rounding of energies, as a share of them


class Reduction(NamedTuple):
    """One number per run from one curve; `share` and `first` ask where the curve is positive."""

    kind: str  # a name of KINDS
    curve: int
    t: float = 0.0  # [s] of `at`


class Step(NamedTuple):
    """What one step says."""

    h: Any  # [s]
    t: Any  # start [s]
    stop: Any  # number of the instant that it ends at, if it does
    lands: Any  # a flag: it does
    curves: list[list[Any]]  # (curves, samples)
    crossings: dict[int, tuple[Any, Any]]  # by condition: sum of shares where it begins less where it ends; first begin


# ---------------------------------------------------------------- trackers: rows that a step changes
@dataclass(frozen=True)
class Highest:
    """The largest value of sign * curve."""

    curve: int
    sign: float
    rows = 1

    def start(self, curves: Sequence[Any]) -> list[Any]:
        """Rows at t = 0."""
        return [self.sign * curves[self.curve]]

    def step(self, held: Sequence[Any], step: Step) -> list[Any]:
        """Rows at the end of the step."""
        return [largest(held[0], peak([self.sign * x for x in step.curves[self.curve]]))]


@dataclass(frozen=True)
class Moment:
    """The integral over time of (curve - c)^power; c: 0, or if shifted the value at the start."""

    curve: int
    power: int
    shifted: bool
    rows = 2

    def start(self, curves: Sequence[Any]) -> list[Any]:
        """Rows at t = 0."""
        return [0.0, curves[self.curve] if self.shifted else 0.0]

    def step(self, held: Sequence[Any], step: Step) -> list[Any]:
        """Rows at the end of the step."""
        samples = [(x - held[1] if self.shifted else x) ** self.power for x in step.curves[self.curve]]
        return [held[0] + step.h * weighted(COTES[len(samples) - 1], samples), held[1]]


@dataclass(frozen=True)
class Reading:
    """The value at a stop; -1 is the start."""

    curve: int
    stop: int
    rows = 1

    def start(self, curves: Sequence[Any]) -> list[Any]:
        """Rows at t = 0."""
        return [curves[self.curve] if self.stop < 0 else math.nan]

    def step(self, held: Sequence[Any], step: Step) -> list[Any]:
        """Rows at the end of the step."""
        here = step.lands & step.stop.graph.apply("equal", step.stop, float(self.stop))
        return [select(here, step.curves[self.curve][-1], held[0])]


@dataclass(frozen=True)
class Lasting:
    """The time during which the curve is positive."""

    curve: int
    rows = 1

    def start(self, curves: Sequence[Any]) -> list[Any]:
        """Rows at t = 0."""
        return [0.0]

    def step(self, held: Sequence[Any], step: Step) -> list[Any]:
        """Rows at the end of the step."""
        on = select(step.curves[self.curve][-1] > 0.0, 1.0, 0.0)
        return [held[0] + step.h * (on - step.crossings[self.curve][0])]


@dataclass(frozen=True)
class Beginning:
    """The first instant at which the curve is positive; nan before it."""

    curve: int
    rows = 1

    def start(self, curves: Sequence[Any]) -> list[Any]:
        """Rows at t = 0."""
        return [select(curves[self.curve] > 0.0, 0.0, math.nan)]

    def step(self, held: Sequence[Any], step: Step) -> list[Any]:
        """Rows at the end of the step."""
        share = step.crossings[self.curve][1]
        begun = select(share < NEVER, step.t + step.h * share, math.nan)
        return [select(held[0] >= 0.0, held[0], begun)]


@dataclass(frozen=True)
class Energies:
    """The largest kinetic energy, least and largest potential, largest work; a flag: the balance is within limits.

    curves: kinetic and potential energy, work, energy dissipated, balance [J]; limit: see `Model`.
    """

    curves: tuple[int, int, int, int, int]
    limit: float
    rows = 5

    def start(self, curves: Sequence[Any]) -> list[Any]:
        """Rows at t = 0."""
        return self._held([0.0, math.inf, -math.inf, 0.0], curves)

    def step(self, held: Sequence[Any], step: Step) -> list[Any]:
        """Rows at the end of the step."""
        return self._held(held, [one[-1] for one in step.curves])

    def _held(self, held: Sequence[Any], curves: Sequence[Any]) -> list[Any]:
        kinetic, potential, work, _, balance = (curves[n] for n in self.curves)
        kinetic, work = largest(kinetic, held[0]), largest(abs(work), held[3])
        low, high = least(potential, held[1]), largest(potential, held[2])
        turnover = largest(largest(kinetic, work), high - low)
        rounding = AFTER * (kinetic + work + largest(abs(low), abs(high)))
        sound = abs(balance) <= self.limit * turnover + rounding
        return [kinetic, low, high, work, select(sound, 1.0, 0.0)]


Tracker = Highest | Moment | Reading | Lasting | Beginning | Energies


# ---------------------------------------------------------------- the polynomial through the samples of a step
def _polynomial(x: Sequence[Any]) -> list[Any]:
    """Coefficients of s, s^2, ... for s from -1 to 1 over the step, relative to the sample in the middle."""
    half = len(x) // 2
    nodes = [Fraction(j, half) for j in range(1, half + 1)]
    coefficients: list[Any] = [None] * (2 * half)
    for odd in (True, False):
        inverse = _inverse([[s ** (2 * k + (1 if odd else 2)) for k in range(half)] for s in nodes])
        parts = [
            0.5 * (x[half + j] - x[half - j]) if odd else 0.5 * ((x[half + j] - x[half]) + (x[half - j] - x[half]))
            for j in range(1, half + 1)
        ]
        for k in range(half):
            coefficients[2 * k if odd else 2 * k + 1] = weighted([float(w) for w in inverse[k]], parts)
    return coefficients


def _inverse(a: list[list[Fraction]]) -> list[list[Fraction]]:
    """The inverse of a small matrix, exactly."""
    n = len(a)
    rows = [[*row, *(Fraction(int(i == j)) for j in range(n))] for i, row in enumerate(a)]
    for i in range(n):
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for j in range(n):
            if j != i:
                rows[j] = [x - rows[j][i] * y for x, y in zip(rows[j], rows[i], strict=True)]
    return [row[n:] for row in rows]


def _horner(coefficients: Sequence[Any], s: Any) -> Any:
    value = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        value = value * s + c
    return value


def peak(x: Sequence[Any]) -> Any:
    """The largest value of a curve in a step, from its samples."""
    parts = len(x) - 1
    if parts < 2:
        return largest(*x)
    best, start = x[0], -1.0
    left, middle, right = x[:3]
    for i in range(1, parts + 1):
        above, c = x[i] > best, min(i, parts - 1)
        best, start = select(above, x[i], best), select(above, 2.0 * i / parts - 1.0, start)
        left, middle, right = (
            select(above, new, old) for new, old in ((x[c - 1], left), (x[c], middle), (x[c + 1], right))
        )
    bend, slope = (left - middle) + (right - middle), 0.5 * (right - left)
    within = (bend < 0.0) & (abs(slope) <= -bend)
    usual = select(within, (middle - best) - 0.5 * slope * slope / bend, 0.0)
    p = _polynomial(x)
    first = [(k + 1.0) * c for k, c in enumerate(p)]
    second = [(k + 1.0) * c for k, c in enumerate(first[1:])]
    width, s = 2.0 / parts, start
    low, high = largest(start - width, -1.0), least(start + width, 1.0)
    for _ in range(NEWTON):
        slope, bend = _horner(first, s), _horner(second, s)
        s = select(bend < 0.0, least(largest(s - slope / bend, low), high), s)
    rise = (x[parts // 2] - best) + s * _horner(p, s)
    return best + largest(least(rise, STEEPEST * usual), 0.0)


# ---------------------------------------------------------------- results from rows
def _value(kind: str, curve: int, instant: int, rows: Callable[[Tracker], Sequence[Any]], t_end: float) -> Any:
    if kind in ("at", "final"):
        return rows(Reading(curve, instant))[0]
    if kind == "share":
        return rows(Lasting(curve))[0] / t_end
    if kind == "first":
        return rows(Beginning(curve))[0]
    if kind in ("max", "min", "range"):
        high, low = (
            (rows(Highest(curve, sign))[0] if kind in (name, "range") else 0.0)
            for name, sign in (("max", 1.0), ("min", -1.0))
        )
        return high if kind == "max" else -low if kind == "min" else high + low
    if kind in ("mean", "integral"):
        integral = rows(Moment(curve, 1, False))[0]
        return integral if kind == "integral" else integral / t_end
    if kind == "rms":
        return root(rows(Moment(curve, 2, False))[0] / t_end)
    mean = rows(Moment(curve, 1, True))[0] / t_end
    variance = rows(Moment(curve, 2, True))[0] / t_end - mean * mean
    return root(select(variance < 0.0, 0.0, variance))


SAMPLED = ("max", "min", "range", "mean", "integral", "rms", "sd", "share", "first")  # need samples inside of steps
KINDS = (*SAMPLED, "at", "final")
CONDITIONS = ("share", "first")


class Ledger:
    """The rows that a run gathers for its reductions, and the graphs that start, change and close them."""

    def __init__(
        self, reductions: Sequence[Reduction], curves: int, stops: Sequence[float], parts: int,
        energies: Energies | None,
    ) -> None:  # fmt: skip
        """stops: instants at which steps end [s], the last one is the end; parts: of a step that end at samples."""
        for one in reductions:
            if one.kind not in KINDS or not 0 <= one.curve < curves:
                raise ValueError(f"{one}: a kind of {', '.join(KINDS)} and a curve below {curves} expected")
        self.reductions, self.curves, self.stops = tuple(reductions), curves, tuple(stops)
        self.sampled = any(one.kind in SAMPLED for one in reductions)
        self.parts = parts if self.sampled else 1
        self.conditions = tuple(dict.fromkeys(one.curve for one in reductions if one.kind in CONDITIONS))
        self._places: dict[Tracker, int] = {}
        self.rows = 0
        for tracker in [energies] if energies is not None else []:
            self._place(tracker)
        self.sound_row = 4 if energies is not None else None
        self.close()  # asks for all others

    def _place(self, tracker: Tracker) -> int:
        if tracker not in self._places:
            self._places[tracker] = self.rows
            self.rows += tracker.rows
        return self._places[tracker]

    def start(self) -> Recorded:
        """Curves and flag at t = 0: the rows."""
        graph, given = inputs(self.curves + 1)
        return graph, [x for one in self._places for x in one.start(given)]

    def advance(self, step: Step, held: Sequence[Any]) -> list[Any]:
        """The rows at the end of a step, from those at its start."""
        return [x for one, place in self._places.items() for x in one.step(held[place : place + one.rows], step)]

    def close(self) -> Recorded:
        """Rows: the reductions."""
        graph = Graph()
        symbols: list[Any] = []

        def rows(tracker: Tracker) -> Sequence[Any]:
            place = self._place(tracker)
            while len(symbols) < self.rows:
                symbols.append(graph.input())
            return symbols[place : place + tracker.rows]

        while len(symbols) < self.rows:
            symbols.append(graph.input())
        values = [_value(one.kind, one.curve, self._instant(one), rows, self.stops[-1]) for one in self.reductions]
        return graph, values

    def _instant(self, one: Reduction) -> int:
        if one.kind != "at":
            return len(self.stops) - 1
        return -1 if one.t == 0.0 else self.stops.index(one.t)
