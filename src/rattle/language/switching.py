"""Switches of expressions (abs, sign, step, floor, mod, min, max, comparisons), and the instants of those of time.

A switching function of time is bounded, with its rate, over spans of time.  A span is halved until the function has no
zero in it or is monotone there; then the signs at both ends decide, and false position finds the first instant after
the change of sign.  Nested switches are treated first: between their instants the function is smooth.

Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis (2009), section 8.1 (interval Newton, exclusion).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from rattle.language import bytecode, intervals
from rattle.language.intervals import SWITCHES
from rattle.language.span import Span

MOST = 200_000  # spans of one switching function that are examined together, at most
WORK = 4e7  # rows of programs times spans that are evaluated for all switching functions of a run, at most
CALL = 2000  # spans that take as long as the fixed cost of a call
NARROW = 2.0**-44  # share of the whole time below which a span is not halved
SAME = 1e-13  # share of the whole time within which two instants count as one


@dataclass
class Switch:
    """One switch in a program, in `row`, with its switching function, see `bytecode.switching`."""

    row: int
    first: int  # rows of the operands: first..last-1
    last: int
    count: int  # operands of the switching function, 1 or 2
    name: str  # path of the expression in the model
    timed: bool  # True: depends on time only
    driving: bool = False  # a driver depends on it
    instants: np.ndarray = field(default_factory=lambda: np.zeros(0))  # increasing [s]
    sides: np.ndarray = field(default_factory=lambda: np.zeros(1))  # before, between and after them
    resolved: bool = True


@dataclass(frozen=True)
class Signals:
    """Programs of all signals in order of evaluation; `rows` gives first row, last row + 1 and index of each.

    states: number of states of the model, whose indices come before those of signals and which have no program.

    code: (n, 4), const: (nc,) [SI], as in `language.expression.Program`.
    """

    code: np.ndarray
    const: np.ndarray
    rows: Sequence[tuple[int, int, int]]
    names: Sequence[str] = ()
    states: int = 0

    def used(self, spans: Iterable[tuple[int, int]]) -> set[int]:
        """Indices of the signals used by rows first..last-1 of any of the spans, directly or through other signals."""
        where = {k: (a, b) for a, b, k in self.rows}
        found: set[int] = set()
        ahead = list(spans)
        while ahead:
            a, b = ahead.pop()
            part = self.code[a:b]
            for k in part[part[:, 0] == bytecode.SIGNAL, 1].tolist():
                if k not in found and k >= self.states:
                    found.add(k)
                    ahead.append(where[k])
        return found

    def of_state(self) -> set[int]:
        """Indices of the signals that depend on the state."""
        found = set(range(self.states))
        for a, b, k in self.rows:  # in order: what a signal uses comes before it
            part = self.code[a:b]
            if (part[:, 0] == bytecode.STATE).any() or found & set(part[part[:, 0] == bytecode.SIGNAL, 1].tolist()):
                found.add(k)
        return found


def find_switches(signals: Signals, used: Sequence[tuple[int, int, str, bool]]) -> list[Switch]:
    """Switches of the programs `used` (first row, last row + 1, path, used by a driver), nested switches first.

    Signals that are only recorded are left out: the motion does not depend on them.
    """
    wanted = signals.used((a, b) for a, b, _, _ in used)
    driving = signals.used((a, b) for a, b, _, drives in used if drives)
    named = zip(signals.rows, signals.names, strict=True)
    spans = [(a, b, name, k in driving) for (a, b, k), name in named if k in wanted]
    of_state = signals.of_state()
    return [one for span in (*spans, *used) for one in _switches_of(signals.code, of_state, *span)]


def _switches_of(
    code: np.ndarray, of_state: set[int], first: int, last: int, name: str, driving: bool
) -> Iterator[Switch]:
    """Switches of one program in order of evaluation."""
    stack: list[tuple[int, bool]] = []  # operands on the stack: first row, depends on the state
    for row in range(first, last):
        op, k = int(code[row, 0]), int(code[row, 1])
        if op <= bytecode.SIGNAL:
            stack.append((row, op == bytecode.STATE or (op == bytecode.SIGNAL and k in of_state)))
            continue
        count = bytecode.operands_of(op)
        operands = stack[-count:]
        del stack[-count:]
        stack.append((operands[0][0], any(live for _, live in operands)))
        if op in SWITCHES:
            end = operands[2][0] if count == 4 else row
            timed = not any(live for _, live in operands[:2])
            yield Switch(row, operands[0][0], end, min(count, 2), name, timed, driving)


def locate_all(signals: Signals, switches: Sequence[Switch], start: float, end: float) -> None:
    """Find the instants and sides of every switch that depends on time only, between two times [s].

    A switch with too many instants, or reached after the work allowed for all of them is used up, is not `resolved`.
    """
    known = {switch.row: switch for switch in switches if switch.timed}
    spent = 0.0
    for switch in known.values():
        function = _Function(signals, switch, known)
        _locate(function, start, end, WORK - spent)
        spent += function.work


def side_at(switch: Switch, t: np.ndarray) -> np.ndarray:
    """Sides (n,), -1, 0 or 1, of a switch that depends on time only, at the times t (n,) [s]."""
    return switch.sides[np.searchsorted(switch.instants, t, side="right")]


class _Function:
    """Switching function of one switch; nested switches are on the side they have in the middle of each span."""

    def __init__(self, signals: Signals, switch: Switch, known: dict[int, Switch]) -> None:
        self.signals, self.switch = signals, switch
        self.needed = signals.used([(switch.first, switch.last)])
        self.spans = [(switch.first, switch.last), *((a, b) for a, b, k in signals.rows if k in self.needed)]
        inside = (row for a, b in self.spans for row in range(a, b))
        self.known = {row: known[row] for row in inside if row in known}
        self.length = sum(b - a for a, b in self.spans)
        self.work = 0.0

    def __call__(self, low: np.ndarray, high: np.ndarray, at: np.ndarray) -> Span:
        code, const = self.signals.code, self.signals.const
        self.work += self.length * (CALL + len(low))

        def side_of(row: int) -> np.ndarray | None:
            return side_at(self.known[row], at) if row in self.known else None

        with np.errstate(all="ignore"):
            spans: dict[int, Span] = {}
            for a, b, k in self.signals.rows:
                if k in self.needed:
                    spans[k] = intervals.enclose(code, const, a, b, low, high, spans, side_of)[0]
            stack = intervals.enclose(code, const, self.switch.first, self.switch.last, low, high, spans, side_of)
            op, k = code[self.switch.row, :2].tolist()
            return intervals.switching_function(const, op, k, stack)

    def value(self, t: np.ndarray, at: np.ndarray) -> np.ndarray:
        """The function at times t (n,) [s], with the nested switches on their sides at the times `at`."""
        return self(t, t, at).low


def _locate(function: _Function, start: float, end: float, work: float) -> None:
    switch = function.switch
    edges = np.unique(np.concatenate([[start, end], *(one.instants for one in function.known.values())]))
    edges = edges[(edges >= start) & (edges <= end)]
    tiny = (NARROW * (end - start), 1e-18 * (end - start))
    roots, switch.resolved = _roots(function, edges[:-1], edges[1:], tiny, work)
    if not switch.resolved:
        return
    roots = roots[(roots > start + SAME * (end - start)) & (roots < end)]
    cuts = np.unique(np.concatenate([edges, roots]))
    middle = 0.5 * (cuts[:-1] + cuts[1:])
    sides = np.nan_to_num(np.sign(function.value(middle, middle)))
    change = np.flatnonzero(sides[1:] != sides[:-1])
    switch.instants = cuts[1:-1][change]
    switch.sides = np.concatenate([sides[:1], sides[1:][change]])


def _roots(
    function: _Function, low: np.ndarray, high: np.ndarray, tiny: tuple[float, float], work: float
) -> tuple[np.ndarray, bool]:
    """First instants [s] after each change of sign in the spans low..high; False if there are too many."""
    found = [np.zeros(0)]
    with np.errstate(all="ignore"):
        while len(low):
            if len(low) > MOST or function.work > work:
                return np.zeros(0), False
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            s = function(low, high, middle)
            here = function.value(middle, middle)
            reach = half * np.maximum(np.abs(s.slow), np.abs(s.fast))
            reach = np.where(np.isfinite(reach), reach, np.inf) * (1.0 + 1e-12)
            least, most = np.fmax(s.low, here - reach), np.fmin(s.high, here + reach)
            undefined = np.isnan(s.low) | np.isnan(s.high)
            open_ = ~undefined & (least <= 0.0) & (most >= 0.0) & ((s.low != 0.0) | (s.high != 0.0))
            low, high, middle = low[open_], high[open_], middle[open_]
            monotone = (s.slow[open_] > 0.0) | (s.fast[open_] < 0.0)
            monotone &= np.isfinite(s.low[open_]) & np.isfinite(s.high[open_])  # it has no pole
            done = monotone | (high - low <= np.maximum(tiny[0], 8.0 * np.spacing(np.abs(high))))
            found.append(_far_side(function, low[done], high[done], middle[done], tiny[1]))
            low, high, middle = low[~done], high[~done], middle[~done]
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    return np.concatenate(found), True


def _far_side(function: _Function, low: np.ndarray, high: np.ndarray, at: np.ndarray, tiny: float) -> np.ndarray:
    """First instants [s] with another sign than at `low`, in every span whose ends differ in sign.

    False position (Illinois) with bisection in every third iteration, until the span is two neighbouring floats or
    shorter than `tiny` [s].
    """
    f_low, f_high = function.value(low, at), function.value(high, at)
    differ = np.sign(f_low) != np.sign(f_high)
    low, high, at, f_low, f_high = (one[differ] for one in (low, high, at, f_low, f_high))
    before = np.sign(f_low)
    found = np.where(before == 0.0, low, high)
    high = found.copy()  # a span that begins with zero needs no search
    ahead = np.arange(len(high))
    for turn in range(400):
        wide = high - low > np.maximum(tiny, np.spacing(np.abs(high)))
        found[ahead[~wide]] = high[~wide]
        low, high, at, f_low, f_high, before, ahead = (
            one[wide] for one in (low, high, at, f_low, f_high, before, ahead)
        )
        if not len(ahead):
            break
        middle = 0.5 * (low + high)
        if turn % 3 < 2:
            chord = low + f_low / (f_low - f_high) * (high - low)
            inside = np.clip(chord, np.nextafter(low, np.inf), np.nextafter(high, -np.inf))
            middle = np.where(np.isfinite(chord) & (inside > low) & (inside < high), inside, middle)
        value = function.value(middle, at)
        same = np.sign(value) == before
        f_high = np.where(same, 0.5 * f_high, value)
        f_low = np.where(same, value, 0.5 * f_low)
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return found


def merged(switches: Sequence[Switch], span: float) -> np.ndarray:
    """Instants [s] of all switches that depend on time only, increasing; equal within rounding of span [s] are one."""
    every = np.unique(np.concatenate([np.zeros(0), *(switch.instants for switch in switches if switch.timed)]))
    if not len(every):
        return every
    apart: np.ndarray = np.concatenate([[True], np.diff(every) > SAME * span])
    return np.asarray(every[apart])
