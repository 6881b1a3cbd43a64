"""What lanes hold of their contacts: rows that each keeps, and what a step says of them.

A step counts only if it is proven that no contact begins or ends inside of it; else the lane tries a shorter one.
Where a gap is beyond its zero at the end, the next try ends at the zero of a polynomial through what is known of the
gap.  A try that ends there to rounding counts, and the contact turns.  The next trip of the lane takes no time: it
finds what holds from there on.  See `lane_gaps` for the proof, `lane_turns` for what comes of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle.jit import layout as at
from rattle.language.recorded import Flag, Operand
from rattle.trace.graph import select
from rattle.trace.lane_chain import Function

# of a lane, whatever contact it is; the last ones count tries
LANE = (
    "closing",
    "hit length",
    "free length",
    "unsound",
    "doubts",
    "landings",
    "turned",
    "turns",
    "tried",
    "flown",
    "turned at",
    "crawls",
)
COUNTED = ("doubts", "landings", "turned")
# of contacts that forces hold, at the end of a step: force, reserve of slip or stick, slip, T, g'' and g' without what
# may be rounding, force that may be
HELD_STARTS = ("pressed", "reserve", "slip", "most pressed", "most reserve")  # at the start; sizes while it is so
HELD_ENDS = ("pressed", "reserve", "slip", "tangent", "bend", "calm", "faint")


class Row(NamedTuple):
    """A number that differs from sample to sample: a row of the state."""

    place: int


class Meets(NamedTuple):
    """The contacts of a model, n of them, after them the joints that rub and what switches, as lanes follow them."""

    table: np.ndarray  # (n, columns) of the system
    lever: Sequence[Sequence[float | Row]]  # (n, columns) of the system
    nq: int  # positions in a state
    touched: Function  # of a state: what ENDS says
    midway: Function  # of a state: gaps, their rates, then forces of those whose peaks are asked for
    struck: Function  # of a state: y and what `Struck` says
    peaks: tuple[int, ...] = ()  # contacts whose largest forces are asked for
    held: tuple[int, ...] = ()  # rigid contacts, and those that end where their force does
    pulsates: bool = False  # loads may change faster than what moves
    rubs: int = 0  # number of joints with dry friction: they slip in the sense of their speed, or stick
    switches: int = 0  # number of expressions that switch: their speed is their side
    limited: tuple[int, ...] = ()  # clutches with a largest torque: their speed is -1 where they slip at it

    @property
    def n(self) -> int:
        """Number of contacts."""
        return len(self.table)

    @property
    def rigid(self) -> tuple[int, ...]:
        """The rigid ones."""
        return tuple(n for n in self.held if n < self.n and self.table[n, at.IMPACT] == 1)

    @property
    def clutches_hold(self) -> bool:
        """Whether clutches without slip may hold what joints that rub keep at rest."""
        return self.rubs > 0 and any(self.table[n, at.LEVEL] for n in self.rigid)

    @property
    def rubbing(self) -> range:
        """Numbers of the joints that rub, after those of contacts."""
        return range(self.n, self.n + self.rubs)

    @property
    def switching(self) -> range:
        """Numbers of the expressions that switch, after those of joints."""
        return range(self.n + self.rubs, self.all_of)

    @property
    def all_of(self) -> int:
        """Number of contacts, joints and expressions."""
        return self.n + self.rubs + self.switches

    @property
    def inputs(self) -> int:
        """Rows of `Touch` that are inputs of the equations: the first ones."""
        return 2 * self.all_of

    @property
    def touch_rows(self) -> int:
        """Rows that a lane keeps, see `Touch`."""
        return self.inputs + 2 * self.n + 2 * len(self.peaks) + len(HELD_STARTS) * len(self.held) + len(LANE)

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
        return 3 * len(self.rigid) + 2 * self.rubs + 2

    @property
    def met_rows(self) -> int:
        """Rows that `meet` writes, see `Met`."""
        return 6 + self.n + len(self.peaks) + 2 * len(self.held)


class Touch:
    """Rows of a lane: shut (0 or 1) and approach speed of its contacts; gap and rate of each at the start of a step;
    forces and their rates likewise, of those whose peaks are asked for; HELD_STARTS of those that forces hold; LANE.

    A rigid contact is OPEN, SHUT, HITS or DECIDES, see `recorded_rigid`; its speed is the sense of its slip, 0: none.
    A compliant one that ends where its force does is RELEASED after that, inside its wall.  A joint that rubs is SHUT
    or DECIDES, likewise; so is what switches.
    """

    def __init__(self, meets: Meets, rows: Sequence[Operand]) -> None:
        n, p, r, all_of = meets.n, len(meets.peaks), len(meets.held), meets.all_of
        self.shut, self.speed, self.gap, self.rate, self.force, self.change, *held, lane = _parted(
            rows, [all_of, all_of, n, n, p, p, *[r] * len(HELD_STARTS), len(LANE)]
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
    contact, about; an open one is deep in its wall; how fast bodies turn [rad/s]; by contact, that it turns at the end;
    largest forces in it; of those that forces hold, that nothing is left of their reserve, and a height of bounces that
    are not followed.
    """

    def __init__(self, meets: Meets, rows: Sequence[Operand]) -> None:
        r = len(meets.held)
        first, self.near, self.peaks, self.spent, self.low = _parted(rows, [6, meets.n, len(meets.peaks), r, r])
        self.cut, self.ahead, self.hit, self.due, self.deep, self.turning = first


class Struck:
    """Of rigid contacts: shut, sense of slip, impulses after a trip that took no time; modes of joints that rub to be
    tried next in an impact, and whether they may have any; a flag that there are such; whether these joints agree with
    the impulses of an impact (1, 0), or there are neither impulses nor forces in their modes (-1)."""

    def __init__(self, meets: Meets, rows: Sequence[Operand]) -> None:
        r = len(meets.rigid)
        self.shut, self.slide, self.impulse, self.rubs, self.free, (self.sound, self.agreed) = _parted(
            rows, [r, r, r, meets.rubs, meets.rubs, 2]
        )


def _parted(rows: Sequence[Operand], sizes: Sequence[int]) -> list[list[Operand]]:
    parts, first = [], 0
    for size in sizes:
        parts.append(list(rows[first : first + size]))
        first += size
    return parts


def one(on: Flag) -> Operand:
    """1 or 0."""
    return select(on, 1.0, 0.0)
