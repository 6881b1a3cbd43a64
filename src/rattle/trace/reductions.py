"""Numbers that sum up a curve over a run, gathered step by step while samples run side by side.

A step gives samples of every curve at its ends and at equal parts of it.  Between them a curve counts as the polynomial
through all of them: extremes are found on it, see `peak`, and integrals by the closed formulas of Newton and Cotes
(Abramowitz, Stegun, Handbook of Mathematical Functions (1964), 25.4.16).

Where only extremes are asked for, the stages of a step show whether it can hold one; only such a step is sampled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from rattle.errors import InputError
from rattle.language.recorded import Flag, Operand
from rattle.trace.graph import Graph, apply, select
from rattle.trace.lane_methods import Recorded, extremes, inputs, largest, least, root, weighted
from rattle.trace.peak import peak

COTES = {  # by number of parts: weights of the samples
    1: (1 / 2, 1 / 2),
    2: (1 / 6, 4 / 6, 1 / 6),
    6: tuple(w / 840 for w in (41, 216, 27, 272, 27, 216, 41)),
}
NEVER = 9.0  # share of a step at which a condition begins that does not begin in it
AFTER = 1e-12  # rounding of energies, as a share of them
MARGIN = 0.5  # by which a curve may be above what stages and ends show of it, as a share of its range there


class Reduction(NamedTuple):
    """One number per run from one curve, or of contacts; `share` and `first` ask where the curve is positive."""

    kind: str  # a name of KINDS
    curve: int  # -1 of OF_CONTACTS
    t: float = 0.0  # [s] of `at`
    contacts: tuple[int, ...] = ()  # of OF_CONTACTS, in the order of those that begin at once
    number: int = 0  # of the contact asked for, from 1


class Touches(NamedTuple):
    """What one step says of contacts."""

    begins: list[Flag]  # at its end
    speeds: list[Operand]  # approach speeds there [m/s or rad/s]
    shut: list[Flag]  # in it
    peaks: dict[int, Operand]  # largest forces in it of those that are asked for [N or N m]


class Step(NamedTuple):
    """What one step says."""

    h: Operand  # [s]
    t: Operand  # start [s]
    end: Operand  # [s]
    stop: Operand  # number of the instant that it ends at, if it does
    lands: Flag  # a flag: it does
    curves: list[list[Operand]]  # (curves, samples)
    crossings: dict[
        int, tuple[Operand, Operand]
    ]  # by condition: sum of shares where it begins less where it ends; first begin
    seen: dict[int, tuple[Operand, Operand]]  # by watched curve: its least and largest value in the stages that see it
    touches: Touches | None = None


# ---------------------------------------------------------------- trackers: rows that a step changes
@dataclass(frozen=True)
class Highest:
    """The largest value of sign * curve."""

    curve: int
    sign: float
    rows = 1

    def start(self, curves: Sequence[Operand]) -> list[Operand]:
        """Rows at t = 0."""
        return [self.sign * curves[self.curve]]

    def step(self, held: Sequence[Operand], step: Step) -> list[Operand]:
        """Rows at the end of the step."""
        return [largest(held[0], peak([self.sign * x for x in step.curves[self.curve]]))]


@dataclass(frozen=True)
class Screened:
    """The largest value of sign * curve at the ends of steps and inside of those that ask for samples; at ends alone.

    Which steps ask follows from the ends alone, so it does not matter when the samples of a step come.
    """

    curve: int
    sign: float
    rows = 2

    def start(self, curves: Sequence[Operand]) -> list[Operand]:
        """Rows at t = 0."""
        return 2 * [self.sign * curves[self.curve]]

    def step(self, held: Sequence[Operand], step: Step) -> list[Operand]:
        """Rows at the end of the step."""
        end = self.sign * step.curves[self.curve][-1]
        return [largest(row, end) for row in held]

    def asks(self, new: Sequence[Operand], step: Step) -> Flag:
        """A flag: inside of the step the curve may be above the largest value at the ends so far."""
        low, high = extremes([self.sign * x for x in (*step.curves[self.curve], *step.seen[self.curve])])
        return high + MARGIN * (high - low) > new[1]


@dataclass(frozen=True)
class Aside:
    """The `Status` that samples inside of steps ended with, 0 if they are sound; number of the steps that asked."""

    rows = 2

    def start(self, curves: Sequence[Operand]) -> list[Operand]:
        """Rows at t = 0."""
        return [0.0, 0.0]

    def step(self, held: Sequence[Operand], step: Step) -> list[Operand]:
        """Rows at the end of the step, which does not ask."""
        return list(held)


@dataclass(frozen=True)
class Moment:
    """The integral over time of (curve - c)^power; c: 0, or if shifted the value at the start."""

    curve: int
    power: int
    shifted: bool
    rows = 2

    def start(self, curves: Sequence[Operand]) -> list[Operand]:
        """Rows at t = 0."""
        return [0.0, curves[self.curve] if self.shifted else 0.0]

    def step(self, held: Sequence[Operand], step: Step) -> list[Operand]:
        """Rows at the end of the step."""
        samples = [(x - held[1] if self.shifted else x) ** self.power for x in step.curves[self.curve]]
        return [held[0] + step.h * weighted(COTES[len(samples) - 1], samples), held[1]]


@dataclass(frozen=True)
class Reading:
    """The value at a stop; -1 is the start."""

    curve: int
    stop: int
    rows = 1

    def start(self, curves: Sequence[Operand]) -> list[Operand]:
        """Rows at t = 0."""
        return [curves[self.curve] if self.stop < 0 else math.nan]

    def step(self, held: Sequence[Operand], step: Step) -> list[Operand]:
        """Rows at the end of the step."""
        here = step.lands & apply("equal", step.stop, float(self.stop))
        return [select(here, step.curves[self.curve][-1], held[0])]


@dataclass(frozen=True)
class Lasting:
    """The time during which the curve is positive."""

    curve: int
    rows = 1

    def start(self, curves: Sequence[Operand]) -> list[Operand]:
        """Rows at t = 0."""
        return [0.0]

    def step(self, held: Sequence[Operand], step: Step) -> list[Operand]:
        """Rows at the end of the step."""
        on = select(step.curves[self.curve][-1] > 0.0, 1.0, 0.0)
        return [held[0] + step.h * (on - step.crossings[self.curve][0])]


@dataclass(frozen=True)
class Beginning:
    """The first instant at which the curve is positive; nan before it."""

    curve: int
    rows = 1

    def start(self, curves: Sequence[Operand]) -> list[Operand]:
        """Rows at t = 0."""
        return [select(curves[self.curve] > 0.0, 0.0, math.nan)]

    def step(self, held: Sequence[Operand], step: Step) -> list[Operand]:
        """Rows at the end of the step."""
        share = step.crossings[self.curve][1]
        begun = select(share < NEVER, step.t + step.h * share, math.nan)
        return [select(held[0] >= 0.0, held[0], begun)]


@dataclass(frozen=True)
class Energies:
    """The largest kinetic energy, least and largest potential, largest work; a flag: the balance is within limits.

    curves: kinetic and potential energy, work, energy dissipated, balance [J]; limit: see `Model`; weight: energy of
    lifting the mechanism by its size, of which a share is rounding.
    """

    curves: tuple[int, int, int, int, int]
    limit: float
    weight: float = 0.0  # [J]
    slight: float = 0.0  # what is no energy [J]
    rows = 5

    def start(self, curves: Sequence[Operand]) -> list[Operand]:
        """Rows at t = 0."""
        return self._held([0.0, math.inf, -math.inf, 0.0], curves)

    def step(self, held: Sequence[Operand], step: Step) -> list[Operand]:
        """Rows at the end of the step."""
        return self._held(held, [row[-1] for row in step.curves])

    def _held(self, held: Sequence[Operand], curves: Sequence[Operand]) -> list[Operand]:
        kinetic, potential, work, _, balance = (curves[n] for n in self.curves)
        kinetic, work = largest(kinetic, held[0]), largest(abs(work), held[3])
        low, high = least(potential, held[1]), largest(potential, held[2])
        turnover = largest(largest(kinetic, work), high - low)
        rounding = AFTER * (kinetic + work + largest(abs(low), abs(high)) + self.weight)
        sound = abs(balance) <= self.limit * turnover + rounding + self.slight
        return [kinetic, low, high, work, select(sound, 1.0, 0.0)]


@dataclass(frozen=True)
class Numbered:
    """Of the contact with this number: its begin [s], approach speed or largest force, nan before it; 0 counts them.

    Rows: contacts so far, the value, and 1 + that of the contacts whose largest force is looked for.
    """

    kind: str  # one of OF_CONTACTS
    contacts: tuple[int, ...]
    number: int
    rows = 3

    def start(self, curves: Sequence[Operand]) -> list[Operand]:
        """Rows at t = 0."""
        return [0.0, math.nan, 0.0]

    def step(self, held: Sequence[Operand], step: Step) -> list[Operand]:
        """Rows at the end of the step."""
        if not self.contacts:  # of a joint whose contact never ends, as of a massless link
            return list(held)
        assert step.touches is not None
        touches, (count, value, who) = step.touches, held
        if self.kind == "peak":
            for n in self.contacts:
                mine = touches.shut[n] & apply("equal", who, 1.0 + n)
                value = select(mine, largest(touches.peaks[n], value), value)
        for n in self.contacts:
            begins = touches.begins[n]
            count = count + select(begins, 1.0, 0.0)
            this = begins & apply("equal", count, float(self.number))
            new = {"time": step.end, "speed": touches.speeds[n], "peak": 0.0, "count": 0.0}[self.kind]
            value = select(this, new, value)
            other = begins & apply("equal", who, 1.0 + n)
            who = select(this, 1.0 + n, select(other, 0.0, who))
        return [count, value, who]


Tracker = Highest | Screened | Aside | Moment | Reading | Lasting | Beginning | Energies | Numbered


# ---------------------------------------------------------------- results from rows
def _value(
    reduction: Reduction, instant: int, rows: Callable[[Tracker], Sequence[Operand]], t_end: float,
    highest: Callable[[int, float], Tracker],
) -> Operand:  # fmt: skip
    kind, curve = reduction.kind, reduction.curve
    if kind in OF_CONTACTS:
        return rows(Numbered(kind, reduction.contacts, reduction.number))[0 if kind == "count" else 1]
    if kind in ("at", "final"):
        return rows(Reading(curve, instant))[0]
    if kind == "share":
        return rows(Lasting(curve))[0] / t_end
    if kind == "first":
        return rows(Beginning(curve))[0]
    if kind in ("max", "min", "range"):
        high, low = (
            (rows(highest(curve, sign))[0] if kind in (name, "range") else 0.0)
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
OF_CONTACTS = ("time", "speed", "peak", "count")
KINDS = (*SAMPLED, "at", "final", *OF_CONTACTS)
CONDITIONS = ("share", "first")
EXTREMES = ("max", "min", "range")
MOST_EXTREMES = 6  # with more of them most steps can hold one, and it is faster to sample all


def watched(reductions: Sequence[Reduction]) -> tuple[int, ...]:
    """The curves that stages must show, so that only steps are sampled that can hold an extreme; () if all must be."""
    sampled = [reduction for reduction in reductions if reduction.kind in SAMPLED]
    extremes = sum(2 if reduction.kind == "range" else 1 for reduction in sampled)
    if extremes > MOST_EXTREMES or any(reduction.kind not in EXTREMES for reduction in sampled):
        return ()
    return tuple(dict.fromkeys(reduction.curve for reduction in sampled))


class Ledger:
    """The rows that a run gathers for its reductions, and the graphs that start, change and close them."""

    def __init__(
        self, reductions: Sequence[Reduction], curves: int, stops: Sequence[float], samples: int,
        energies: Energies | None, shown: Sequence[int] = (),
    ) -> None:  # fmt: skip
        """stops: instants at which steps end [s], the last one is the end; samples: parts of a step that end at them;
        shown: curves that stages show."""
        for reduction in reductions:
            followed = reduction.kind in OF_CONTACTS or 0 <= reduction.curve < curves
            if reduction.kind not in KINDS or not followed:
                raise InputError(f"{reduction}: a kind of {', '.join(KINDS)} and a curve below {curves} expected")
        self.reductions, self.curves, self.stops = tuple(reductions), curves, tuple(stops)
        needed = watched(reductions)
        screened = bool(needed) and set(needed) <= set(shown)
        self.watched = tuple(shown) if screened else ()  # not empty: steps that ask are sampled, aside
        self.sampled = any(reduction.kind in SAMPLED for reduction in reductions) and not self.watched  # every step
        self.samples, self.parts = samples, samples if self.sampled else 1  # parts: of every step
        self.conditions = tuple(
            dict.fromkeys(reduction.curve for reduction in reductions if reduction.kind in CONDITIONS)
        )
        self._places: dict[Tracker, int] = {}
        self.rows = 0
        for tracker in [energies] if energies is not None else []:
            self._place(tracker)
        self.sound_row = 4 if energies is not None else None
        if self.watched:
            self._place(Aside())
        self.close()  # asks for all others

    def _place(self, tracker: Tracker) -> int:
        if tracker not in self._places:
            self._places[tracker] = self.rows
            self.rows += tracker.rows
        return self._places[tracker]

    def start(self) -> Recorded:
        """Curves and flag at t = 0: the rows."""
        graph, curves = inputs(self.curves + 1)
        return graph, [x for tracker in self._places for x in tracker.start(curves)]

    def advance(self, step: Step, held: Sequence[Operand], at_start: Flag) -> tuple[list[Operand], Flag]:
        """The rows at the end of a step, from those at its start; a flag: it asks for samples.

        at_start: the run is still at its start, where its contacts have been found to be as they are.
        """
        rows = list(held)
        asks: Flag = False
        for tracker, place in self._places.items():
            new = tracker.step(held[place : place + tracker.rows], step)
            if not isinstance(tracker, Numbered):
                first = tracker.start([curve[-1] for curve in step.curves])
                new = [select(at_start, a, b) for a, b in zip(first, new, strict=True)]
            rows[place : place + tracker.rows] = new
            if isinstance(tracker, Screened):
                asks = asks | tracker.asks(new, step)
        if self.watched:
            count = self.aside_row + 1
            rows[count] = held[count] + select(asks, 1.0, 0.0)
        return rows, asks

    @property
    def counting(self) -> set[int]:
        """The rows of what counts contacts."""
        places = [(place, tracker.rows) for tracker, place in self._places.items() if isinstance(tracker, Numbered)]
        return {place + k for place, count in places for k in range(count)}

    @property
    def screened(self) -> dict[Screened, int]:
        """Largest values that samples inside of steps may raise, and their rows."""
        return {tracker: place for tracker, place in self._places.items() if isinstance(tracker, Screened)}

    @property
    def aside_row(self) -> int:
        """The first row of `Aside`."""
        return self._places[Aside()]

    def close(self) -> Recorded:
        """Rows: the reductions."""
        graph = Graph()
        symbols: list[Operand] = []

        def rows(tracker: Tracker) -> Sequence[Operand]:
            place = self._place(tracker)
            while len(symbols) < self.rows:
                symbols.append(graph.input())
            return symbols[place : place + tracker.rows]

        while len(symbols) < self.rows:
            symbols.append(graph.input())
        highest = Screened if self.watched else Highest
        values = [
            _value(reduction, self._instant(reduction), rows, self.stops[-1], highest) for reduction in self.reductions
        ]
        return graph, values

    def _instant(self, reduction: Reduction) -> int:
        if reduction.kind != "at":
            return len(self.stops) - 1
        return -1 if reduction.t == 0.0 else self.stops.index(reduction.t)
