"""What a step of lanes says of contacts: which turn at its end, and a proof that none does before.

The proof takes the bounds of `solvers.contacts.gap_search`: the chord, a rate that cannot turn, or a polynomial.  Its
polynomial, a quartic through values and rates at both ends and the value midway, is off by the fifth derivative, which
is bounded for bodies that turn evenly; to that comes what the rate midway shows of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from rattle.jit import layout as at
from rattle.language.recorded import Flag, Operand
from rattle.solvers.contacts import gap_search
from rattle.solvers.contacts.penetration import DEEP
from rattle.solvers.nonsmooth.impacts import LOW, LOW_OF_GAP
from rattle.trace.graph import apply, both, select, select_flag
from rattle.trace.lane_contacts import Ends, Meets, Row, Touch, one
from rattle.trace.lane_methods import Method, Recorded, inputs, largest, least, root
from rattle.trace.lane_polynomials import FAR, LITTLE, Polynomial, Quartic
from rattle.trace.peak import peak
from rattle.trace.recording import Recorder

SHARP = 1e-11  # share of the step that first went beyond a contact by which the instant of the contact may be missed
OF_TIME = 2.3e-16  # share of the time with the speed of bodies by which their places may be rounding
IN_TIME = 8e-15  # share of the time likewise: so much is rounding of an instant
RESOLVED = 1e-7  # share of the largest position by which one must change for the change to tell rates
CAUTION = 0.7  # share of the longest step that a bound allows which is tried next
LEAST_SHARE, MOST_SHARE = 0.2, 0.5  # of a step in doubt that is tried next
TURNS_BACK, LEAST_SOON = 4.0, 1e-3  # depth at which it turns, as a share of that so far; share of the step tried next
KINKED = 0.1  # share of a force by which curves through it may differ that have its slopes and that have none
SLIGHT = 1e-12  # share of a force, or of a slip, that may be rounding
AT_ONCE = 4.0  # of the time by which a joint that comes to rest is too early: others have come to rest with it
BACK = 10.0  # of what may be rounding: so near zero a curve begins that may turn back, and so far from there it has
NOTHING_LEFT = 1e-10  # share of it that counts as none where a step is to end with it
HELD = 1e-11  # slip midway [m/s or rad/s] that may be rounding where others hold it at zero at both ends


def middle(method: Method, ny: int, nq: int, watched: int) -> Recorded:
    """Blocks as in `checks` up to the last stage: t and y midway, positions by the quintic, rates by its slope."""
    size = ny + 2 + watched
    graph, row = inputs((4 + method.stages) * size)
    end, step, start, first, last = (row[k * size : (k + 1) * size] for k in (0, 1, 2, 3, 3 + method.stages))
    h, state = step[0], [start[0] + 0.5 * step[0]]
    far: list[Operand] = [0.0, 0.0, 1.0]  # positions [m, m, rad], by whose rounding changes of positions tell rates
    for i in range(nq):
        far[i % 3] = largest(far[i % 3], abs(start[1 + i]))
    far[0] = far[1] = largest(far[0], far[1])
    for i in range(1, 1 + ny):
        y0, y1, f0, f1 = start[i], end[i], first[i], last[i]
        if i <= nq:
            bends = first[nq + i] + last[nq + i]
            state.append(0.5 * (y0 + y1) + h * (0.15625 * (f0 - f1) + h * (0.015625 * bends)))
        elif i <= 2 * nq:
            here, there = start[i - nq], end[i - nq]
            usual = 1.875 * (there - here) / h - 0.4375 * (y0 + y1) + 0.03125 * h * (f1 - f0)
            told = h * (abs(y0) + abs(y1)) > 2.0 * RESOLVED * far[(i - 1) % 3]
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
    t = group["planned"][1]
    missed = largest(SHARP * touch.lane["hit length"], IN_TIME * t)
    missed = select(group["control"][-1] > 0.0, missed, 0.0)
    recorder = Recorder(graph)
    m = _step_arrays(tile, meets, method, ny, watched, row)
    hit: Flag = False
    doubt: Flag = False
    short: Operand = h
    theta: Operand = FAR
    due: Operand = FAR
    deep: Flag = False
    looks: list[_Look] = []
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
        end_rate = ends.rate[n]
        if meets.clutches_hold and n in meets.rigid:  # what rests at its wall does not come to it by rounding
            end_rate = ends.held["calm"][meets.held.index(n)]
        gap = _Gap(
            recorder, m, n, shut | released, t, h, (touch.gap[n], touch.rate[n]), (ends.gap[n], end_rate),
            (midway[n], midway[meets.n + n]),
        )  # fmt: skip
        deep = deep | ((code < 0.5) & (gap.end < -DEEP * m.lever[n, at.GAP_SCALE]))
        seen = [gap.looked_at(missed)]
        if n in meets.held:
            k, first = meets.held.index(n), 2 * meets.n + len(meets.peaks)
            values = [
                (touch.held[name][k], midway[first + place * len(meets.held) + k], ends.held[name][k],
                 touch.held[f"most {name}"][k], floor)
                for place, (name, floor) in enumerate(_floors(meets, touch, n, ends.held["faint"][k]))
            ]  # fmt: skip
            seen = _held_looks(meets, n, seen[0], values, h, missed, shut, released)
            spent.append(seen[1].arrives)
            low.append(gap.low_bounce(m, n))
        near.append(seen[0].arrives)
        looks += seen
    rubs = _rubbing_looks(meets, touch, ends, midway, h, missed)
    spent += _together(meets, touch, ends, [look.arrives for look in rubs])
    others = [*rubs, *_switch_looks(meets, touch, ends, midway, h, missed)]
    spent += [look.arrives for look in others[len(rubs) :]]
    low += [0.0] * len(others)
    for look in (*looks, *others):
        hit, doubt = hit | look.below, doubt | apply("not", look.free)
        theta = select(look.below, least(theta, look.zero), theta)
        short = select(look.free, short, least(short, least(MOST_SHARE * h, largest(look.allowed, LEAST_SHARE * h))))
        due = least(due, look.due * h)
    moves = apply("not", still > 0.0)
    cut = moves & (hit | doubt)
    turned, ended = (
        [one(both(graph, [moves, apply("not", hit | doubt), flag])) for flag in flags] for flags in (near, spent)
    )
    forces = []
    for k in range(len(meets.peaks)):
        largest_in_step = _largest_force(
            touch.force[k], h * touch.change[k], midway[2 * meets.n + k], ends.force[k], h * ends.change[k]
        )
        forces.append(select(still > 0.0, ends.force[k], largest_in_step))  # that which holds from then on
    return graph, [
        one(cut),
        select(hit, theta * h, short),
        one(moves & hit),
        due,
        one(deep),
        _turning(m),
        *turned,
        *forces,
        *ended,
        *low,
    ]


def _turning(m: SimpleNamespace) -> Operand:
    """The largest speed of a body at the end of the step [rad/s]."""
    fastest: Operand = 0.0
    for speed in m.state_new[len(m.change) + 2 : 2 * len(m.change) : 3]:
        fastest = largest(fastest, abs(speed))
    return fastest


def _largest_force(start: Operand, rises: Operand, middle: Operand, end: Operand, falls: Operand) -> Operand:
    """In a step, by values at both ends and midway, and slopes per step at the ends.

    Where slopes may be infinite, as of a damper by the secant stiffness at its first touch, values alone count.
    """
    curve = Quartic(start, rises, middle, end, falls)
    size = largest(largest(abs(start), abs(end)), abs(middle))
    inside = []
    for part, nearer, farther in ((0.25, start, end), (0.75, end, start)):
        by_slopes, by_values = curve.value(part), 0.125 * (3.0 * nearer + 6.0 * middle - farther)
        inside.append(select(abs(by_slopes - by_values) <= KINKED * size, by_slopes, by_values))
    return peak([start, inside[0], middle, inside[1], end])


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


class _Fall(NamedTuple):
    """How a curve of which rates are known comes to zero in a step."""

    inside: Flag  # beyond zero already, by rounding or where it has turned back at once, and on its way farther
    arrives: Flag  # it is zero at the end
    low: Operand  # least value that is none below zero
    zero: Operand  # where its first zero is about: a share of the step


def _fall(
    curve: Quartic, h: Operand, start: tuple[Operand, Operand], last: tuple[Operand, Operand], slight: Operand,
    missed: Operand,
) -> _Fall:  # fmt: skip
    """start, last: value and rate at the ends of a step of length h [s]; slight: of a value, what may be rounding;
    missed: time by which an instant may be missed [s]."""
    (value, rate), (end, end_rate) = start, last
    inside = (value <= 0.0) & (rate <= 0.0)
    close = largest(slight, missed * abs(end_rate))
    close = select(inside, largest(close, TURNS_BACK * abs(value)), close)
    arrives = (end_rate < 0.0) & (abs(end) <= close)
    low = select(inside, 0.0, least(value, 0.0)) - select(arrives, close, slight)
    soon = least(0.5, abs(value) / largest(h * abs(rate), LITTLE))
    return _Fall(inside, arrives, low, select(inside, largest(soon, LEAST_SOON), curve.zero()))


_NOTHING = _Look(False, False, True, FAR, FAR, FAR)


def _held_looks(
    meets: Meets, n: int, gap: _Look, values: Sequence[tuple[Operand, ...]], h: Operand,
    missed: Operand, shut: Flag, released: Flag,
) -> list[_Look]:  # fmt: skip
    """What a step shows of a contact that ends where its force does, and whether it slips or sticks no longer.

    A compliant one that is without force inside its wall may push again instead; an open clutch waits for its rate.
    """
    pressed, reserve = (_reserve_at(h, missed, *row) for row in values)
    if meets.table[n, at.LEVEL]:
        waits = True if n in meets.limited else apply("not", shut)
        return [pressed.instead_of(_NOTHING, shut), reserve.instead_of(_NOTHING, waits)]
    looks = [pressed.instead_of(gap, shut)]
    if n in meets.rigid:  # what others hold does not slip, though it bears all that it can
        begins, middle, ends, *_ = values[1]
        held = apply("equal", begins, 0.0) & apply("equal", ends, 0.0) & (abs(middle) <= HELD)
        return [*looks, reserve.instead_of(_NOTHING, shut & apply("not", held))]
    start, middle, end, most, floor = values[0]
    again = _reserve_at(h, missed, -start, -middle, -end, most, floor)
    through = _NOTHING._replace(free=gap.free, allowed=gap.allowed)  # from wall to wall, without force between them
    return [*looks, again.instead_of(_NOTHING, released), through.instead_of(_NOTHING, shut)]


def _floors(meets: Meets, touch: Touch, n: int, faint: Operand) -> list[tuple[str, Operand]]:
    """What may be rounding of the force of a contact, and of what is left of its stick or slip."""
    if meets.table[n, at.LEVEL] and n not in meets.limited:  # it waits for a rate
        return [("pressed", faint), ("reserve", faint)]
    return [("pressed", faint), ("reserve", select(_bears(meets, touch, n), 2.0 * faint, 0.0))]


def _bears(meets: Meets, touch: Touch, n: int) -> Flag:
    """Whether what is left of a contact is a force: it sticks, or is a clutch that holds."""
    return touch.speed[n] > 0.5 if n in meets.limited else apply("equal", touch.speed[n], 0.0)


def _rubbing_looks(
    meets: Meets, touch: Touch, ends: Ends, midway: Sequence[Operand], h: Operand, missed: Operand
) -> list[_Look]:
    """What a step shows of how joints that rub slip, or stick."""
    looks, first = [], 2 * meets.n + len(meets.peaks) + len(meets.held)
    for n in meets.rubbing:
        k = meets.held.index(n)
        start, most = touch.held["reserve"][k], touch.held["most reserve"][k]
        end, floor = ends.held["reserve"][k], ends.held["faint"][k]
        looks.append(_reserve_at(h, missed, start, midway[first + k], end, most, floor))
    return looks


def _switch_looks(
    meets: Meets, touch: Touch, ends: Ends, midway: Sequence[Operand], h: Operand, missed: Operand
) -> list[_Look]:
    """What a step shows of expressions that switch: their switching functions and rates, in the sense of their sides.

    The quartic through these is off by what their rate midway shows.
    """
    looks, first, held = [], 2 * meets.n + len(meets.peaks), len(meets.held)
    for n in meets.switching:
        k = meets.held.index(n)
        start, rate = touch.held["reserve"][k], touch.held["pressed"][k]
        end, end_rate, slight = (ends.held[name][k] for name in ("reserve", "pressed", "faint"))
        half, half_rate = midway[first + held + k], midway[first + k]
        curve = Quartic(start, h * rate, half, end, h * end_rate)
        fall = _fall(curve, h, (start, rate), (end, end_rate), slight, missed)
        free = curve.lowest(abs(h * half_rate - curve.slope(0.5))) >= fall.low
        arrives = fall.arrives
        looks.append(_Look(arrives, end < fall.low, free | (arrives & fall.inside), 0.0, fall.zero, curve.beyond()))
    return looks


def _together(meets: Meets, touch: Touch, ends: Ends, arrive: Sequence[Flag]) -> list[Flag]:
    """Joints that come to rest, with those that are there at the same instant: they move together."""
    rates = [abs(ends.held["reserve"][meets.held.index(n)]) for n in meets.rubbing]
    slower = [-touch.speed[n] * ends.held["bend"][meets.held.index(n)] for n in meets.rubbing]
    slips = [apply("not", apply("equal", touch.speed[n], 0.0)) for n in meets.rubbing]
    late: Operand = 0.0
    for rate, loses, flag in zip(rates, slower, [a & b for a, b in zip(arrive, slips, strict=True)], strict=True):
        late = select(flag & (loses > 0.0), largest(late, rate / largest(loses, LITTLE)), late)
    return [
        flag | (slip & (late > 0.0) & (rate <= AT_ONCE * late * loses))
        for flag, slip, rate, loses in zip(arrive, slips, rates, slower, strict=True)
    ]


def _reserve_at(
    h: Operand, missed: Operand, start: Operand, middle: Operand, end: Operand, most: Operand, floor: Operand
) -> _Look:
    """What three values say of the force of a rigid contact, or of what keeps it slipping or sticking.

    most: size that it has had; floor: size that may be rounding.
    """
    bend = 2.0 * (start + end) - 4.0 * middle
    rises = end - start - bend
    curve = Polynomial([start, rises, bend], rises + 2.0 * bend)
    size = largest(largest(most, abs(middle)), largest(abs(start), abs(end)))
    slight = largest(SLIGHT * size, floor)
    close = largest(slight, missed / largest(h, LITTLE) * abs(curve.ends))
    arrives = ((curve.ends < 0.0) & (abs(end) <= close)) | ((missed > 0.0) & (abs(end) <= NOTHING_LEFT * size))
    begins = abs(start) <= BACK * slight  # at zero: it may turn back at once
    gives = begins & (end < least(start, -slight)) & ((h <= missed) | (end > start - BACK * slight))
    close = select(gives, largest(close, abs(end)), close)
    arrives = (arrives & (size > floor)) | gives
    close = select(arrives, largest(close, NOTHING_LEFT * size), slight)
    low = least(start, 0.0) - close
    turns = (bend > 0.0) & (rises < 0.0) & (curve.ends > 0.0)
    lowest = least(least(start, end), least(middle, select(turns, start - 0.25 * rises * rises / bend, middle)))
    from_zero = Polynomial([select(begins, 0.5 * BACK * slight, start), rises, bend], curve.ends)
    return _Look(arrives, end < low, lowest >= low, 0.0, from_zero.zero(), curve.beyond())


class _Gap:
    """The gap of one contact in a step of length h, as a curve that is positive while the contact stays as it is.

    The gap of a pin turns with its normal, so that it is no polynomial; |e|^2 is smoother.  So of a round of radius c
    the curve is c^2 - |e|^2 = g (2 c - g), or |e|^2 - c^2 outside of it.
    """

    def __init__(
        self, recorder: Recorder, m: SimpleNamespace, n: int, shut: Flag, t: Operand, h: Operand,
        start: tuple[Operand, Operand], last: tuple[Operand, Operand], midway: tuple[Operand, Operand],
    ) -> None:  # fmt: skip
        """t: at the end [s]; start, last, midway: gap and its rate."""
        (gap, rate), (end, end_rate) = start, last
        bounds, sweep, rounding = (
            recorder.recorded(f.python) for f in (gap_search.bounds, gap_search.sweep, gap_search.rounding)
        )
        side, self.h, self.shut = select(shut, -1.0, 1.0), h, shut
        self.gap, self.rate, self.end, self.end_rate = (side * x for x in (gap, rate, end, end_rate))
        self.bend, _, self.turning, _ = bounds(m, h, n)
        turns, distance = sweep(m, n, self.bend, h, select(shut, 0.0, largest(self.gap, self.end)))
        self.bent = self.bend + turns * turns * distance
        self.slight = rounding(m, n) + OF_TIME * abs(t) * _speed(m, n)
        rounded, radius = float(m.lever[n, at.ROUNDED]), m.lever[n, at.GAP_SCALE]
        way = {0.0: 0.0, 1.0: -1.0, 2.0: 1.0}[rounded]

        def smooth(g: Operand, change: Operand) -> tuple[Operand, Operand]:
            if not way:
                return side * g, side * h * change
            return side * g * (2.0 * radius + way * g), side * h * 2.0 * (radius + way * g) * change

        left, right = smooth(gap, rate), smooth(end, end_rate)
        halfway, slope = smooth(*midway)
        self.curve = Quartic(left[0], left[1], halfway, right[0], right[1])
        self.size = 2.0 * radius if way else 1.0  # of the curve to the gap next to zero
        self.missed = abs(slope - self.curve.slope(0.5))
        least_between, across_round = (
            recorder.recorded(f.python) for f in (gap_search.least_between, gap_search.across_round)
        )
        self.least = least_between(m, n, side, self.gap, self.rate, self.end, self.end_rate, h, self.bend)
        self.turned = largest(self.turning * h, across_round(m, n, side, self.rate, self.end_rate, h, self.bend))
        w, e = self.turning, self.bend
        self.fifth = e * w * w * w  # a bound of the fifth derivative
        if way:
            speed = root(end_rate * end_rate + m.contact_kinematics[n, at.ACROSS] ** 2) + e * h
            away = radius + largest(abs(gap), abs(end)) + 0.125 * e * h * h
            self.fifth = e * w * (20.0 * e + w * (10.0 * speed + w * (2.0 * away)))

    def low_bounce(self, m: SimpleNamespace, n: int) -> Operand:
        """Height of a bounce that is not followed [m or rad], see `solvers.nonsmooth.impacts`."""
        height = largest(LOW * m.lever[n, at.GAP_SCALE], LOW_OF_GAP * m.lever[n, at.GAP_SIZE])
        return largest(height, self.slight)

    def looked_at(self, missed: Operand) -> _Look:
        """missed: time by which an instant of contact may be missed [s], 0: this step does not try to end there."""
        h, bent = self.h, self.bent
        fall = _fall(self.curve, h, (self.gap, self.rate), (self.end, self.end_rate), self.slight, missed)
        inside, arrives, low, zero = fall
        margin = self.missed + self.fifth * h**4 * h / 3840.0
        smooth = self.turned <= gap_search.WHOLE_TURN
        proven = smooth & (self.curve.lowest(margin) >= self.size * low)
        nearest = least(self.gap, self.end)
        free = proven | (self.least >= low) | (abs(self.rate + self.end_rate) >= bent * h)
        allowed = CAUTION * root(8.0 * largest(nearest - low, LITTLE) / largest(bent, LITTLE))
        return _Look(arrives, self.end < low, free | (arrives & inside), allowed, zero, self.curve.beyond())


def _speed(m: SimpleNamespace, n: int) -> Operand:
    """Of the bodies of contact n at the end of the step [m/s or rad/s]: by so much places go with rounding of time, as
    of what a driver moves."""
    total: Operand = 0.0
    for end in range(2):
        i = m.contact[n, at.A_BODY + end]
        if i > 0:
            x, y, angle = m.state_new[len(m.change) + 3 * i - 3 : len(m.change) + 3 * i]
            turns = abs(angle)
            along = abs(x) + abs(y) + m.lever[n, end] * turns
            total = total + select(m.lever[n, at.ANGULAR] > 0.0, turns, along)
    return total


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
