"""Contacts of lanes: where each begins and ends, found by steps that end there, and what they leave behind.

A step counts only if it is proven that no contact begins or ends inside of it; else the lane tries a shorter one.
Where a gap is beyond its zero at the end, the next try ends at the zero of a polynomial through what is known of the
gap: values and rates at both ends, and the value midway.  A try that ends there to rounding counts, and the contact
turns.  The next trip of the lane takes no time: it finds what holds from there on.

The proof takes the bounds of `solvers.contacts.gap_search`: the chord, a rate that cannot turn, or a polynomial.  Its
polynomial, a quartic, is off by the fifth derivative, which is bounded for bodies that turn evenly; to that comes what
the rate midway shows of it.  In Bernstein's form it shows its sign even where it starts or ends at zero.

Source: Farouki, The Bernstein polynomial basis, Computer Aided Geometric Design 29 (2012) 379-419.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from rattle.jit import layout as at
from rattle.language.recorded import Flag, Operand
from rattle.solvers.contacts import gap_search
from rattle.solvers.contacts.contact_events import AFTER_CONTACT, FIRST_STEP
from rattle.solvers.contacts.penetration import DEEP
from rattle.solvers.nonsmooth.impacts import LOW, LOW_OF_GAP, NOTICED
from rattle.trace.graph import apply, both, select
from rattle.trace.lane_chain import Function
from rattle.trace.lane_methods import Method, Recorded, inputs, largest, least, root
from rattle.trace.peak import peak
from rattle.trace.recorded_rigid import DECIDES, HITS, OPEN, select_flag
from rattle.trace.recording import Recorder
from rattle.trace.reductions import Touches

# of a lane, whatever contact it is; the last ones count tries
LANE = ("closing", "hit length", "free length", "unsound", "doubts", "landings", "turned", "turns", "turned at")
COUNTED = ("doubts", "landings", "turned")
LEAVES = 2.0  # speed of a rigid contact whose force has just ended
RELEASED = 2.0  # of a compliant contact: without force inside its wall
# of contacts that forces hold, at the end of a step: force, reserve of slip or stick, slip, T, g'' and g' without what
# may be rounding, force that may be
HELD_STARTS = ("pressed", "reserve", "most pressed", "most reserve")  # force, reserve; their sizes while it is so
HELD_ENDS = ("pressed", "reserve", "slip", "tangent", "bend", "calm", "faint")
SHARP = 1e-11  # share of the step that first went beyond a contact by which the instant of the contact may be missed
SOON = 0.5  # share of that step within which a contact is landed on that was not reached
NEARER = 0.7  # share of the way to a contact that a step takes where all of it is too much: a force ends with a kink
RESOLVED = 1e-7  # share of a position by which it must change for the change to tell rates
NEWTON = 6  # iterations for a zero of a polynomial; a try that misses it is followed by another one
SHORT_OF = 1.0 - 1e-10  # largest share of a step to land at: shorter than the step
CAUTION = 0.7  # share of the longest step that a bound allows which is tried next
LEAST_SHARE, MOST_SHARE = 0.2, 0.5  # of a step in doubt that is tried next
HALVINGS = 2  # of a polynomial whose sign is asked for
TURNS_BACK, LEAST_SOON = 4.0, 1e-3  # depth at which it turns, as a share of that so far; share of the step tried next
MOST_LANDINGS, MOST_TURNS = 200, 60  # tries that do not land; turns at one instant
MOST_UNSOUND = 60  # tries of a run with stages that are not sound, as some are that go far beyond a contact
AT_ONCE = 1e-13  # share of the time within which turns are at one instant
SHORTEST_LANDING = 2e-15  # share of the time that a step to a contact takes at least
FAR, LITTLE = 1e300, 1e-300
SLIGHT = 1e-12  # share of a force, or of a slip, that may be rounding
NOTHING_LEFT = 1e-10  # share of it that counts as none where a step is to end with it


class Row(NamedTuple):
    """A number that differs from sample to sample: a row of the state."""

    place: int


class Meets(NamedTuple):
    """The contacts of a model, n of them, as lanes follow them."""

    table: np.ndarray  # (n, columns) of the system
    lever: Sequence[Sequence[float | Row]]  # (n, columns) of the system
    nq: int  # positions in a state
    touched: Function  # of a state: what ENDS says
    midway: Function  # of a state: gaps, their rates, then forces of those whose peaks are asked for
    struck: Function  # of a state: y and what `Struck` says
    peaks: tuple[int, ...] = ()  # contacts whose largest forces are asked for
    held: tuple[int, ...] = ()  # rigid contacts, and those that end where their force does

    @property
    def n(self) -> int:
        """Number of contacts."""
        return len(self.table)

    @property
    def rigid(self) -> tuple[int, ...]:
        """The rigid ones."""
        return tuple(n for n in self.held if self.table[n, at.IMPACT] == 1)

    @property
    def touch_rows(self) -> int:
        """Rows that a lane keeps, see `Touch`."""
        return 4 * self.n + 2 * len(self.peaks) + len(HELD_STARTS) * len(self.held) + len(LANE)

    @property
    def end_rows(self) -> int:
        """Rows that tell of the end of a step, see `Ends`."""
        return 4 * self.n + 2 * len(self.peaks) + len(HELD_ENDS) * len(self.held)

    @property
    def midway_rows(self) -> int:
        """Rows that tell of its middle."""
        return 2 * self.n + len(self.peaks) + 2 * len(self.held)

    @property
    def struck_rows(self) -> int:
        """Rows that `struck` writes after y, see `Struck`."""
        return 3 * len(self.rigid) + 1

    @property
    def met_rows(self) -> int:
        """Rows that `meet` writes, see `Met`."""
        return 5 + self.n + len(self.peaks) + 2 * len(self.held)


class Touch:
    """Rows of a lane: shut (0 or 1) and approach speed of its contacts; gap and rate of each at the start of a step;
    forces and their rates likewise, of those whose peaks are asked for; HELD_STARTS of those that forces hold; LANE.

    A rigid contact is OPEN, SHUT, HITS or DECIDES, see `recorded_rigid`; its speed is the sense of its slip, 0: none.
    A compliant one that ends where its force does is RELEASED after that, inside its wall.
    """

    def __init__(self, meets: Meets, rows: Sequence[Operand]) -> None:
        n, p, r = meets.n, len(meets.peaks), len(meets.held)
        self.shut, self.speed, self.gap, self.rate, self.force, self.change, *held, lane = _parted(
            rows, [n, n, n, n, p, p, r, r, r, r, len(LANE)]
        )
        self.held = dict(zip(HELD_STARTS, held, strict=True))
        self.lane = dict(zip(LANE, lane, strict=True))

    @property
    def rows(self) -> list[Operand]:
        """All of them in order."""
        lists = (self.shut, self.speed, self.gap, self.rate, self.force, self.change, *self.held.values())
        return [*(x for rows in lists for x in rows), *self.lane.values()]


class Ends:
    """At the end of a step: gaps, their rates, speeds across the normal, how long contacts will last about [s], by
    contact; forces and their rates, of those whose peaks are asked for; HELD_ENDS of those that forces hold."""

    def __init__(self, meets: Meets, rows: Sequence[Operand]) -> None:
        n, p, r = meets.n, len(meets.peaks), len(meets.held)
        self.gap, self.rate, self.across, self.lasting, self.force, self.change, *held = _parted(
            rows, [n, n, n, n, p, p, *[r] * len(HELD_ENDS)]
        )
        self.held = dict(zip(HELD_ENDS, held, strict=True))


class Met:
    """What a step says of contacts.

    It is cut, and how long the next try is; it is cut as it went beyond a contact; time from its end to the next
    contact, about; an open one is deep in its wall; by contact, that it turns at the end; largest forces in it; of
    those that forces hold, that nothing is left of their reserve, and a height of bounces that are not followed.
    """

    def __init__(self, meets: Meets, rows: Sequence[Operand]) -> None:
        r = len(meets.held)
        first, self.near, self.peaks, self.spent, self.low = _parted(rows, [5, meets.n, len(meets.peaks), r, r])
        self.cut, self.ahead, self.hit, self.due, self.deep = first


class Struck:
    """Of rigid contacts: shut, sense of slip, impulses after a trip that took no time; a flag that there are such."""

    def __init__(self, meets: Meets, rows: Sequence[Operand]) -> None:
        r = len(meets.rigid)
        self.shut, self.slide, self.impulse, (self.sound,) = _parted(rows, [r, r, r, 1])


def _parted(rows: Sequence[Operand], sizes: Sequence[int]) -> list[list[Operand]]:
    parts, first = [], 0
    for size in sizes:
        parts.append(list(rows[first : first + size]))
        first += size
    return parts


# ---------------------------------------------------------------- a curve in a step
class _Polynomial:
    """A curve over a step by its coefficients."""

    def __init__(self, powers: list[Operand], ends: Operand) -> None:
        """ends: change per step at the end."""
        self.powers, self.ends = powers, ends

    def value(self, s: Operand) -> Operand:
        """At the share s of the step."""
        total = self.powers[-1]
        for c in reversed(self.powers[:-1]):
            total = total * s + c
        return total

    def slope(self, s: Operand) -> Operand:
        """Change per step there."""
        total: Operand = 0.0
        for k in reversed(range(1, len(self.powers))):
            total = total * s + float(k) * self.powers[k]
        return total

    def zero(self) -> Operand:
        """About where it falls through zero first, below zero at its end: a share of the step."""
        left, rises = self.powers[:2]
        secant = least(largest(left / largest(left - self.value(1.0), LITTLE), 1e-3), 1.0)
        s = select(rises > 0.0, select(self.ends < 0.0, 1.0, 0.5), secant)
        for _ in range(NEWTON):
            s = least(largest(self._nearer(s), 0.5 * s), 0.5 + 0.5 * s)
        return least(s, SHORT_OF)

    def beyond(self) -> Operand:
        """Share of the step after its end at which it falls through zero, about; FAR if it rises there."""
        s = self._nearer(self._nearer(1.0))
        return select(s > 1.0, s - 1.0, FAR)

    def _nearer(self, s: Operand) -> Operand:
        slope = self.slope(s)
        return s - self.value(s) / select(slope < 0.0, slope, -FAR)


class _Quartic(_Polynomial):
    """The curve with these values and changes per step at the ends, and this value midway."""

    def __init__(self, left: Operand, rises: Operand, middle: Operand, right: Operand, ends: Operand) -> None:
        c2 = 3.0 * (right - left) - 2.0 * rises - ends
        c3 = 2.0 * (left - right) + rises + ends
        self.known, self.bulge = (left, rises, right, ends), 16.0 * middle - 8.0 * (left + right) - 2.0 * (rises - ends)
        super().__init__([left, rises, c2 + self.bulge, c3 - 2.0 * self.bulge, self.bulge], ends)

    def lowest(self, margin: Operand) -> Operand:
        """A number below all its values less 16 s^2 (1 - s)^2 times a margin."""
        left, rises, right, ends = self.known
        middle = 0.5 * (left + right) + (rises - ends) / 6.0 + (self.bulge - 16.0 * margin) / 6.0
        pieces = [[left, left + 0.25 * rises, middle, right - 0.25 * ends, right]]
        for _ in range(HALVINGS):
            pieces = [half for piece in pieces for half in _halves(piece)]
        low: Operand = FAR
        for piece in pieces:
            for x in piece:
                low = least(low, x)
        return low


def _halves(b: Sequence[Operand]) -> tuple[list[Operand], list[Operand]]:
    """Coefficients of the two halves of a polynomial in Bernstein's form, by de Casteljau."""
    left, right, rest = [b[0]], [b[-1]], list(b)
    while len(rest) > 1:
        rest = [0.5 * (x + y) for x, y in itertools.pairwise(rest)]
        left.append(rest[0])
        right.append(rest[-1])
    return left, right[::-1]


# ---------------------------------------------------------------- functions of a trip
def middle(method: Method, ny: int, nq: int, watched: int) -> Recorded:
    """Blocks as in `checks` up to the last stage: t and y midway, positions by the quintic, rates by its slope."""
    size = ny + 2 + watched
    graph, row = inputs((4 + method.stages) * size)
    end, step, start, first, last = (row[k * size : (k + 1) * size] for k in (0, 1, 2, 3, 3 + method.stages))
    h, state = step[0], [start[0] + 0.5 * step[0]]
    for i in range(1, 1 + ny):
        y0, y1, f0, f1 = start[i], end[i], first[i], last[i]
        if i <= nq:
            bends = first[nq + i] + last[nq + i]
            state.append(0.5 * (y0 + y1) + h * (0.15625 * (f0 - f1) + h * (0.015625 * bends)))
        elif i <= 2 * nq:
            here, there = start[i - nq], end[i - nq]
            usual = 1.875 * (there - here) / h - 0.4375 * (y0 + y1) + 0.03125 * h * (f1 - f0)
            told = h * (abs(y0) + abs(y1)) > RESOLVED * (abs(here) + abs(there))
            state.append(select(told, usual, 0.5 * (y0 + y1) + 0.125 * h * (f0 - f1)))
        else:
            state.append(0.5 * (y0 + y1) + 0.125 * h * (f0 - f1))
    return graph, state


class Tile(NamedTuple):
    """Where groups of rows stand in a tile."""

    places: dict[str, slice]
    size: int  # rows in all


def meet(tile: Tile, meets: Meets, method: Method, ny: int, watched: int) -> Recorded:
    """All rows of a tile: the rows of `Met`."""
    graph, row = inputs(tile.size)
    group = {name: row[place] for name, place in tile.places.items()}
    touch, ends, midway = Touch(meets, group["touch"]), Ends(meets, group["ends"]), group["midway"]
    h, still = group["planned"][0], group["control"][-2]
    reach = select(group["control"][-1] > 0.0, touch.lane["hit length"], 0.0)
    recorder = Recorder(graph)
    m = _step_arrays(tile, meets, method, ny, watched, row)
    hit: Flag = False
    doubt: Flag = False
    short: Operand = h
    theta: Operand = FAR
    due: Operand = FAR
    deep: Flag = False
    near: list[Flag] = []
    spent: list[Flag] = []
    low: list[Operand] = []
    for n in range(meets.n):
        m.contact_kinematics[n, at.ACROSS] = ends.across[n]
        code = touch.shut[n]
        shut: Flag = (code > 0.5) & (code < 1.5)
        released: Flag = False
        if n in meets.held and n not in meets.rigid:
            released = code > 1.5
        gap = _Gap(
            recorder, m, n, shut | released, h, (touch.gap[n], touch.rate[n]), (ends.gap[n], ends.rate[n]),
            (midway[n], midway[meets.n + n]),
        )  # fmt: skip
        deep = deep | ((code < 0.5) & (gap.end < -DEEP * m.lever[n, at.GAP_SCALE]))
        looks = [gap.looked_at(reach)]
        if n in meets.held:
            k, first = meets.held.index(n), 2 * meets.n + len(meets.peaks)
            values = [
                (touch.held[name][k], midway[first + place * len(meets.held) + k], ends.held[name][k],
                 touch.held[f"most {name}"][k], floor)
                for place, (name, floor) in enumerate((
                    ("pressed", ends.held["faint"][k]),
                    ("reserve", select(apply("equal", touch.speed[n], 0.0), 2.0 * ends.held["faint"][k], 0.0)),
                ))
            ]  # fmt: skip
            looks = _held_looks(meets, n, looks[0], values, h, reach, shut, released)
            spent.append(looks[1].arrives)
            low.append(gap.low_bounce(m, n))
        for look in looks:
            hit, doubt = hit | look.below, doubt | apply("not", look.free)
            theta = select(look.below, least(theta, look.zero), theta)
            short = select(
                look.free, short, least(short, least(MOST_SHARE * h, largest(look.allowed, LEAST_SHARE * h)))
            )
            due = least(due, look.due * h)
        near.append(looks[0].arrives)
    moves = apply("not", still > 0.0)
    cut = moves & (hit | doubt)
    turned, ended = (
        [_one(both(graph, [moves, apply("not", hit | doubt), flag])) for flag in flags] for flags in (near, spent)
    )
    forces = [
        peak([
            _Quartic(touch.force[k], h * touch.change[k], midway[2 * meets.n + k], ends.force[k],
                     h * ends.change[k]).value(0.25 * part)
            for part in range(5)
        ])
        for k in range(len(meets.peaks))
    ]  # fmt: skip
    return graph, [
        _one(cut),
        select(hit, theta * h, short),
        _one(moves & hit),
        due,
        _one(deep),
        *turned,
        *forces,
        *ended,
        *low,
    ]


class _Look(NamedTuple):
    """What a step shows of a curve that is positive while a contact stays as it is."""

    arrives: Flag  # it is zero at the end: the contact turns
    below: Flag  # it is beyond zero at the end
    free: Flag  # it has no zero before
    allowed: Operand  # step that bounds allow [s]
    zero: Operand  # where its first zero is about, if it is beyond: a share of the step
    due: Operand  # where its next zero is about: shares of the step after its end

    def instead_of(self, other: _Look, shut: Flag) -> _Look:
        """This one where a contact is shut, the other one elsewhere."""
        flags = [select_flag(shut, a, b) for a, b in zip(self[:3], other[:3], strict=True)]
        return _Look(*flags, *(select(shut, a, b) for a, b in zip(self[3:], other[3:], strict=True)))


_NOTHING = _Look(False, False, True, FAR, FAR, FAR)


def _held_looks(
    meets: Meets, n: int, gap: _Look, values: Sequence[tuple[Operand, ...]], h: Operand,
    reach: Operand, shut: Flag, released: Flag,
) -> list[_Look]:  # fmt: skip
    """What a step shows of a contact that ends where its force does, and whether it slips or sticks no longer.

    A compliant one that is without force inside its wall may push again instead; an open clutch waits for its rate.
    """
    pressed, reserve = (_reserve_at(h, reach, *row) for row in values)
    if meets.table[n, at.LEVEL]:
        return [pressed.instead_of(_NOTHING, shut), reserve.instead_of(_NOTHING, apply("not", shut))]
    looks = [pressed.instead_of(gap, shut)]
    if n in meets.rigid:
        return [*looks, reserve.instead_of(_NOTHING, shut)]
    start, middle, end, most, floor = values[0]
    again = _reserve_at(h, reach, -start, -middle, -end, most, floor)
    return [*looks, again.instead_of(_NOTHING, released)]


def _reserve_at(
    h: Operand, reach: Operand, start: Operand, middle: Operand, end: Operand, most: Operand, floor: Operand
) -> _Look:
    """What three values say of the force of a rigid contact, or of what keeps it slipping or sticking.

    most: size that it has had; floor: size that may be rounding.
    """
    bend = 2.0 * (start + end) - 4.0 * middle
    rises = end - start - bend
    curve = _Polynomial([start, rises, bend], rises + 2.0 * bend)
    size = largest(largest(most, abs(middle)), largest(abs(start), abs(end)))
    slight = largest(SLIGHT * size, floor)
    close = largest(slight, SHARP * reach / largest(h, LITTLE) * abs(curve.ends))
    arrives = ((curve.ends < 0.0) & (abs(end) <= close)) | ((reach > 0.0) & (abs(end) <= NOTHING_LEFT * size))
    arrives = arrives & (size > floor)
    close = select(arrives, largest(close, NOTHING_LEFT * size), slight)
    low = least(start, 0.0) - close
    turns = (bend > 0.0) & (rises < 0.0) & (curve.ends > 0.0)
    lowest = least(least(start, end), least(middle, select(turns, start - 0.25 * rises * rises / bend, middle)))
    return _Look(arrives, end < low, lowest >= low, 0.0, curve.zero(), curve.beyond())


class _Gap:
    """The gap of one contact in a step of length h, as a curve that is positive while the contact stays as it is.

    The gap of a pin turns with its normal, so that it is no polynomial; |e|^2 is smoother.  So of a round of radius c
    the curve is c^2 - |e|^2 = g (2 c - g), or |e|^2 - c^2 outside of it.
    """

    def __init__(
        self, recorder: Recorder, m: SimpleNamespace, n: int, shut: Flag, h: Operand, start: tuple[Operand, Operand],
        last: tuple[Operand, Operand], midway: tuple[Operand, Operand],
    ) -> None:  # fmt: skip
        """start, last, midway: gap and its rate."""
        (gap, rate), (end, end_rate) = start, last
        bounds, sweep, rounding = (
            recorder.recorded(f.python) for f in (gap_search.bounds, gap_search.sweep, gap_search.rounding)
        )
        side, self.h, self.shut = select(shut, -1.0, 1.0), h, shut
        self.gap, self.rate, self.end, self.end_rate = (side * x for x in (gap, rate, end, end_rate))
        self.bend, _, self.turning, _ = bounds(m, h, n)
        turns, distance = sweep(m, n, self.bend, h, select(shut, 0.0, largest(self.gap, self.end)))
        self.bent = self.bend + turns * turns * distance
        self.slight = rounding(m, n)
        rounded, radius = float(m.lever[n, at.ROUNDED]), m.lever[n, at.GAP_SCALE]
        way = {0.0: 0.0, 1.0: -1.0, 2.0: 1.0}[rounded]

        def smooth(g: Operand, change: Operand) -> tuple[Operand, Operand]:
            if not way:
                return side * g, side * h * change
            return side * g * (2.0 * radius + way * g), side * h * 2.0 * (radius + way * g) * change

        left, right = smooth(gap, rate), smooth(end, end_rate)
        halfway, slope = smooth(*midway)
        self.curve = _Quartic(left[0], left[1], halfway, right[0], right[1])
        self.size = 2.0 * radius if way else 1.0  # of the curve to the gap next to zero
        self.missed = abs(slope - self.curve.slope(0.5))
        w, e = self.turning, self.bend
        self.fifth = e * w * w * w  # a bound of the fifth derivative
        if way:
            speed = root(end_rate * end_rate + m.contact_kinematics[n, at.ACROSS] ** 2) + e * h
            away = radius + largest(abs(gap), abs(end)) + 0.125 * e * h * h
            self.fifth = e * w * (20.0 * e + w * (10.0 * speed + w * (2.0 * away)))

    def low_bounce(self, m: SimpleNamespace, n: int) -> Operand:
        """Height of a bounce that is not followed [m or rad], see `solvers.nonsmooth.impacts`."""
        known = largest(LOW * m.lever[n, at.GAP_SCALE], LOW_OF_GAP * m.lever[n, at.GAP_SIZE])
        return largest(known, self.slight)

    def looked_at(self, reach: Operand) -> _Look:
        """reach: length of the step that first went beyond a contact [s], 0: this one does not try to land there."""
        h, bent = self.h, self.bent
        # beyond its zero already, by rounding or where it has turned back at once, and on its way farther
        inside = (self.gap <= 0.0) & (self.rate <= 0.0)
        close = largest(self.slight, SHARP * reach * abs(self.end_rate))
        close = select(inside, largest(close, TURNS_BACK * abs(self.gap)), close)
        arrives = (self.end_rate < 0.0) & (abs(self.end) <= close)
        low = select(inside, 0.0, least(self.gap, 0.0)) - select(arrives, close, self.slight)
        margin = self.missed + self.fifth * h**4 * h / 3840.0
        smooth = self.turning * h <= gap_search.WHOLE_TURN
        proven = smooth & (self.curve.lowest(margin) >= self.size * low)
        nearest = least(self.gap, self.end)
        chord = nearest - 0.125 * select(self.shut, bent, self.bend) * h * h >= low
        free = proven | chord | (abs(self.rate + self.end_rate) >= bent * h)
        allowed = CAUTION * root(8.0 * largest(nearest - low, LITTLE) / largest(bent, LITTLE))
        soon = least(0.5, abs(self.gap) / largest(h * abs(self.rate), LITTLE))
        zero = select(inside, largest(soon, LEAST_SOON), self.curve.zero())
        return _Look(arrives, self.end < low, free | (arrives & inside), allowed, zero, self.curve.beyond())


def _one(on: Flag) -> Operand:
    return select(on, 1.0, 0.0)


def _step_arrays(
    tile: Tile, meets: Meets, method: Method, ny: int, watched: int, row: Sequence[Operand]
) -> SimpleNamespace:
    """What `gap_search` reads of a step."""
    size, blocks, state = ny + 2 + watched, row[tile.places["blocks"]], row[tile.places["state"]]
    block = [blocks[k * size + 1 : k * size + 1 + ny] for k in range(4 + method.stages)]
    levers = [[state[x.place] if isinstance(x, Row) else x for x in entry] for entry in meets.lever]
    stepper = np.zeros(at.width("stepper"), dtype=int)
    stepper[at.SLOPES] = method.stages + 1
    return SimpleNamespace(
        contact=meets.table, lever=np.array(levers, dtype=object), change=np.zeros(meets.nq), stepper=stepper,
        state=np.array(block[2], dtype=object), state_new=np.array(block[0], dtype=object),
        slopes=np.array(block[3:], dtype=object),
        contact_kinematics=np.zeros((meets.n, at.width("contact_kinematics")), dtype=object),
    )  # fmt: skip


# ---------------------------------------------------------------- what comes of it
class Turned(NamedTuple):
    """What a lane goes on with."""

    touch: list[Operand]
    ahead: Operand  # the step to try next [s]
    still: Operand  # 1: no time passes in the next trip
    landing: Operand  # number of tries that were to end at a contact
    lost: Flag  # a flag: the lane does not get on
    unkept: Flag  # its stages have failed too often


class Lane(NamedTuple):
    """What else is known of a lane after a trip."""

    running: Flag
    good: Flag  # its step counts
    fits: Flag  # its error is small enough
    still: Flag  # it took no time
    landing: Operand
    ahead: Operand  # the step that its error allows next [s]
    planned: Operand  # that which was to follow
    kept: Flag  # its stages are sound


class Meeting:
    """The contacts of a lane in one trip."""

    def __init__(
        self, meets: Meets, touch: Sequence[Operand], ends: Sequence[Operand], met: Sequence[Operand],
        struck: Sequence[Operand],
    ) -> None:  # fmt: skip
        self.meets, self.touch, self.ends = meets, Touch(meets, touch), Ends(meets, ends)
        self.met, self.struck = Met(meets, met), Struck(meets, struck)
        self.near = [x > 0.0 for x in self.met.near]
        self.shut = [(x > 0.5) & (x < 1.5) for x in self.touch.shut]
        hits = [self.touch.shut[n] for n in meets.rigid]
        self.hits, self.decides = _any((x > 1.5) & (x < 2.5) for x in hits), _any(x > 2.5 for x in hits)

    @property
    def touches(self) -> Touches:
        """What the trip tells the reductions of contacts."""
        begins = [near & (code < 0.5) for near, code in zip(self.near, self.touch.shut, strict=True)]
        for k, n in enumerate(self.meets.held):  # one that pushes again, and a clutch that takes
            again = (self.met.spent[k] > 0.0) & apply("not", self.shut[n])
            begins[n] = begins[n] | again
        hardest: Operand = 0.0
        for impulse in self.struck.impulse:
            hardest = largest(impulse, hardest)
        speeds = [largest(-x, 0.0) for x in self.ends.rate]
        for n, impulse in zip(self.meets.rigid, self.struck.impulse, strict=True):
            struck = self.hits & (impulse > NOTICED * hardest)
            begins[n] = begins[n] | struck if self.meets.table[n, at.LEVEL] else struck
            speeds[n] = largest(-self.touch.rate[n], 0.0)
        return Touches(begins, speeds, self.shut, dict(zip(self.meets.peaks, self.met.peaks, strict=True)))

    def turn(self, planned: Sequence[Operand], flags: Lane) -> Turned:
        """What a trip to t leaves of the contacts; its step has the length h [s]."""
        h, t, still, touch, met = planned[0], planned[1], flags.still, self.touch, self.met
        lane, landing = touch.lane, flags.landing
        rigid = self.meets.rigid
        closes = _any(near & (touch.shut[n] < 0.5) for n, near in enumerate(self.near) if n not in rigid)
        strikes = _any(self.near[n] & apply("not", self.shut[n]) for n in rigid)
        turns = flags.good & (_any(self.near) | _any(x > 0.0 for x in met.spent))
        reach = select(landing > 0.0, lane["hit length"], h)
        hit = (met.hit > 0.0) & flags.kept  # also where an error is too large: beyond its contact a curve has a kink
        cut = hit | (flags.fits & (met.cut > 0.0))
        lands = landing > 0.0
        comes = lands & flags.good & apply("not", turns | still) & (met.due <= SOON * lane["hit length"])
        missed = lands & apply("not", hit | flags.fits)
        ahead = select(comes, met.due, self._ahead(h, flags, hit, cut, missed))
        landings = select(turns | still, 0.0, select(hit | comes | missed, landing + 1.0, 0.0))
        first = select(lane["closing"] > 0.0, least(flags.planned, FIRST_STEP * self._lasting()), flags.planned)
        after = select(closes | strikes, reach, largest(reach, AFTER_CONTACT * lane["free length"]))
        ahead = select(landings > 0.0, largest(ahead, SHORTEST_LANDING * t), ahead)
        ahead = select(turns, after, select(still, first, ahead))
        again = (t - lane["turned at"]) <= AT_ONCE * t
        count = select(turns, select(again, lane["turns"] + 1.0, 1.0), lane["turns"])
        values = {
            "closing": select(turns, _one(closes), select(still, 0.0, lane["closing"])),
            "hit length": select(hit & (landing <= 0.0), h, lane["hit length"]),
            "free length": select(turns & closes, largest(reach, 0.5 * lane["free length"]), lane["free length"]),
            "unsound": lane["unsound"] + _one(flags.running & apply("not", flags.kept)),
            **{
                name: lane[name] + _one(flags.running & event)
                for name, event in zip(COUNTED, (cut & apply("not", hit), hit | comes | missed, turns), strict=True)
            },
            "turns": count, "turned at": select(turns, t, lane["turned at"]),
        }  # fmt: skip
        shut, speed = self._states(flags.good & still, strikes)
        waits = _any(shut[n] > 2.5 for n in rigid) | (still & self.decides)
        state = [
            *self._moved(flags.good, shut, touch.shut), *self._moved(flags.good, speed, touch.speed),
            *(
                x
                for new, old in (
                    (self.ends.gap, touch.gap), (self.ends.rate, touch.rate), (self.ends.force, touch.force),
                    (self.ends.change, touch.change), *self._held(still),
                )
                for x in self._moved(flags.good, new, old)
            ),
            *(values[name] for name in LANE),
        ]  # fmt: skip
        unsound = flags.running & still & (self.hits | self.decides) & apply("not", self.struck.sound > 0.0)
        missed_one = flags.good & (met.deep > 0.0)  # see `solvers.contacts.penetration`
        lost = missed_one | (landings > float(MOST_LANDINGS)) | (count > float(MOST_TURNS)) | unsound
        unkept = values["unsound"] > float(MOST_UNSOUND)
        return Turned(state, ahead, _one(turns | (flags.good & waits)), landings, lost, unkept)

    def _held(self, still: Flag) -> list[tuple[list[Operand], list[Operand]]]:
        """HELD_STARTS of the next step, and those of this one."""
        pairs, sizes = [], []
        for name in ("pressed", "reserve"):
            ends, most = self.ends.held[name], self.touch.held[f"most {name}"]
            pairs.append((ends, self.touch.held[name]))
            sizes.append(([select(still, abs(x), largest(abs(x), y)) for x, y in zip(ends, most, strict=True)], most))
        return [*pairs, *sizes]

    def _ahead(self, h: Operand, flags: Lane, hit: Flag, cut: Flag, missed: Flag) -> Operand:
        """The step to try next [s] if no contact turns."""
        whole = flags.fits | (flags.ahead >= self.met.ahead)
        ahead = select(cut, select(hit & apply("not", whole), NEARER * self.met.ahead, self.met.ahead), flags.ahead)
        return select(missed, largest(flags.ahead, NEARER * h), ahead)

    def _lasting(self) -> Operand:
        """The shortest time that a contact will last about [s]."""
        lasting: Operand = FAR
        for shut, x in zip(self.shut, self.ends.lasting, strict=True):
            lasting = select(shut & (x > 0.0), least(lasting, x), lasting)
        return lasting

    def _states(self, still: Flag, strikes: Flag) -> tuple[list[Operand], list[Operand]]:
        """What contacts are after a good trip, and their speeds; still: it took no time."""
        shut, speed = list(self.touch.shut), list(self.touch.speed)
        for n in range(self.meets.n):
            if n not in self.meets.rigid:
                shut[n], speed[n] = self._compliant(n)
        ended = _any(
            (self.near[n] & self.shut[n]) | (self.met.spent[self.meets.held.index(n)] > 0.0) for n in self.meets.rigid
        )
        again = self._again()
        for n in self.meets.rigid:
            shut[n], speed[n] = self._rigid(n, still, strikes, ended, again)
        return shut, speed

    def _again(self) -> dict[int, Flag]:
        """Rigid contacts that decide once more though nothing has hit: those that others hold down to a bounce that is
        not followed, which shows only once these are shut, and with them all that are shut."""
        quiet = apply("not", self.hits | self.decides)
        low = {}
        for n in self.meets.rigid:
            k = self.meets.held.index(n)
            at_wall = (self.touch.shut[n] < 0.5) & (self.ends.gap[n] <= self.met.low[k])
            at_wall = at_wall & (self.touch.speed[n] < LEAVES)
            level = bool(self.meets.table[n, at.LEVEL])
            low[n] = False if level else quiet & at_wall & self._low(n, k)
        some = _any(low.values())
        return {n: flag | (some & self.shut[n]) for n, flag in low.items()}

    def _low(self, n: int, k: int) -> Flag:
        """Whether a contact at its wall leaves it by less than is followed."""
        rises, bend = self.ends.held["calm"][k], self.ends.held["bend"][k]
        return (bend < 0.0) & (rises >= 0.0) & (rises * rises <= -2.0 * bend * self.met.low[k])

    def _compliant(self, n: int) -> tuple[Operand, Operand]:
        """What a compliant contact is after a trip, and its approach speed."""
        code, near = self.touch.shut[n], self.near[n]
        begins = near & (code < 0.5)
        after = select(code > 0.5, 0.0, 1.0)
        if n in self.meets.held:
            again = self.met.spent[self.meets.held.index(n)] > 0.0
            after = select(self.shut[n] & (self.ends.gap[n] < 0.0), RELEASED, after)
            after, near, begins = select(again, 1.0, after), near | again, begins | again
        speed = select(begins, largest(-self.ends.rate[n], 0.0), self.touch.speed[n])
        return select(near, after, code), speed

    def _rigid(
        self, n: int, still: Flag, strikes: Flag, ended: Flag, again: dict[int, Flag]
    ) -> tuple[Operand, Operand]:
        """What a rigid contact is after a trip, and the sense of its slip."""
        touch, near, k, r = self.touch, self.near[n], self.meets.held.index(n), self.meets.rigid.index(n)
        end = {name: rows[k] for name, rows in self.ends.held.items()}
        level, spent = bool(self.meets.table[n, at.LEVEL]), self.met.spent[k] > 0.0
        # at the end of a step
        goes, way = touch.shut[n], touch.speed[n]
        part = (touch.shut[n] < 0.5) | self.shut[n] if level else self.shut[n]
        goes = select(part & strikes, HITS, select(self.shut[n] & ended, DECIDES, goes))
        goes = select(near, select(self.shut[n], OPEN, HITS), goes)
        way = select(near, select(self.shut[n], LEAVES, 0.0), select(touch.shut[n] < 0.5, 0.0, way))
        broken = select(end["tangent"] > 0.0, 1.0, -1.0)  # the force on B along t is -T: it begins to slip so
        way = select(spent, select(apply("equal", way, 0.0), broken, 0.0), way)
        goes = select(spent, DECIDES, goes) if level else goes
        # after an impact, and after a decision
        rises, took_part = end["calm"], touch.shut[n] > 0.5
        low = rises <= 0.0
        if not level:
            low = low | self._low(n, k)
        after = select(took_part & low, DECIDES, OPEN)
        sense = select(end["slip"] > 0.0, 1.0, select(end["slip"] < 0.0, -1.0, 0.0))
        shut = select(self.decides, self.struck.shut[r], select(again[n], DECIDES, touch.shut[n]))
        slide = select(again[n] & (touch.shut[n] < 0.5), sense, touch.speed[n])
        slide = select(self.decides & (touch.shut[n] > 0.5), self.struck.slide[r], slide)
        shut, slide = select(self.hits, after, shut), select(self.hits, sense, slide)
        return select(still, shut, goes), select(still, slide, way)

    @staticmethod
    def _moved(good: Flag, new: Sequence[Operand], old: Sequence[Operand]) -> list[Operand]:
        return [select(good, a, b) for a, b in zip(new, old, strict=True)]


def _any(flags: Iterable[Flag]) -> Flag:
    result: Flag = False
    for flag in flags:
        result = result | flag
    return result
