"""Samples made ready to be taken over by lanes: state, right-hand side, curves and first step at t = 0."""

from __future__ import annotations

from typing import Any

import numpy as np

from rattle.jit import layout as at
from rattle.solvers.nonsmooth.event_driven import START_NEAR, START_SIZE
from rattle.trace.lane_contacts import HELD_STARTS, LANE, Ends, Meets, Row
from rattle.trace.lane_control import Status
from rattle.trace.lane_program import Program
from rattle.trace.recorded_rigid import DECIDES, HITS, OPEN, SHUT

LATER = 1e-3  # share of the first step after which it is seen whether a contact leaves its wall
AT_WALL = 1e-9  # share of its scale by which a contact may be in its wall at the start by rounding


Held = dict[int, dict[str, np.ndarray]]  # rows of HELD_ENDS by contact


class Stock:
    """Up to n samples at t = 0, in columns.

    y (ny, n), rate (ny, n), constants (nc, n), curves with flag (curves + 1, n), rows of the reductions, and `ahead`
    (n,), the first step [s].
    """

    def __init__(self, program: Program, n: int) -> None:
        model = program.model
        ny = model.ny
        self.program, self.n = program, n
        self._state = np.zeros((1 + ny + model.nc, n))  # t, y, constants
        # y | rate, flag | rate later, flag | short step, norm of the rate | y later
        self._try = np.zeros((4 * ny + 4, n))
        self.y, self.rate, self.constants = self._try[:ny], self._try[ny : 2 * ny], self._state[1 + ny :]
        self.curves = np.zeros((model.curves + 1, n))
        self.rows = np.zeros((program.ledger.rows, n))
        self.still = np.zeros(n)  # 1: the first trip takes no time
        self.touch = np.zeros((0 if model.meets is None else model.meets.touch_rows, n))  # see `lane_contacts.Touch`
        self._first = np.zeros((1, n))
        self.ahead = self._first[0]

    def fill(self, parameters: np.ndarray) -> np.ndarray:
        """Make ready the samples of parameters (np, k), k from 1 to n; returns their `Status` (k,)."""
        program, model = self.program, self.program.model
        ny, k = model.ny, parameters.shape[1]
        y, constants, sound = model.begin(parameters)
        fill = np.minimum(np.arange(self.n), k - 1)  # the last one fills up
        y, constants, sound = y[:, fill], constants[:, fill], sound[fill]
        state, tried = self._state, self._try
        state[0], state[1 : 1 + ny], state[1 + ny :] = 0.0, y, constants
        self.y[:] = y
        self._take_sides()
        model.outputs(state, self.curves)
        program.start(self.curves, self.rows)
        model.rate(state, tried[ny : 2 * ny + 1])
        fits = (tried[2 * ny] != 0.0) & (self.curves[-1] != 0.0)
        finite = np.isfinite(y).all(0) & np.isfinite(self.rate).all(0) & np.isfinite(self.curves).all(0)
        if program.method.adaptive:
            program.first_try(tried[: 2 * ny], tried[3 * ny + 2 :])
            state[0], state[1 : 1 + ny] = tried[3 * ny + 2], tried[3 * ny + 4 :]
            model.rate(state, tried[2 * ny + 1 : 3 * ny + 2])
            program.first_step(tried[: 3 * ny + 4], self._first)
        else:
            self.ahead[:] = program.lengths[0]
        apart = self._touch()
        held = program.ledger.sound_row
        accounted = np.ones(self.n, dtype=bool) if held is None else self.rows[held] != 0.0
        status = np.select(
            [~np.asarray(sound, dtype=bool), ~fits, ~finite, ~accounted, ~apart],
            [Status.START, Status.ASSUMPTION, Status.NOT_FINITE, Status.ENERGY, Status.PRESSED],
            Status.DONE,
        )
        return status[:k]

    def _take_sides(self) -> None:
        """Put expressions that switch on the sides of their switching functions."""
        meets, ny = self.program.model.meets, self.program.model.ny
        if meets is None or not meets.switches:
            return
        rows = np.zeros((meets.end_rows, self.n))
        for _ in range(meets.switches):  # of some, others are part
            meets.touched(self._state, rows)
            for n in meets.switching:
                k, ends = meets.held.index(n), Ends(meets, list(rows)).held
                self._state[1 + ny + meets.all_of + n] = _side(ends["slip"][k], ends["tangent"][k])

    def _touch(self) -> np.ndarray:
        """Contacts at the start; (n,) True where none is beyond its wall.  What rigid ones at theirs do is found in a
        trip that takes no time."""
        program, meets = self.program, self.program.model.meets
        self.still[:] = 0.0
        if meets is None:
            return np.ones(self.n, dtype=bool)
        count, all_of, ny = meets.n, meets.all_of, program.model.ny
        state = self._state.copy()
        state[0], state[1 : 1 + ny] = 0.0, self.y
        rows = np.zeros((meets.end_rows, self.n))
        meets.touched(state, rows)
        self.touch[:] = 0.0
        self.touch[2 * all_of : 2 * (all_of + count)] = rows[: 2 * count]
        for name, since in (("turned at", -np.inf), ("flown", np.inf)):  # no contact has turned yet
            self.touch[LANE.index(name) - len(LANE)] = since
        ends = Ends(meets, list(rows))
        held = {n: {name: np.asarray(x[k]) for name, x in ends.held.items()} for k, n in enumerate(meets.held)}
        apart = np.asarray(rows[:count] > 0.0)
        self._touch_rigid(meets, state, rows, held, apart)
        self._touch_elastic(meets, state, rows, held, apart)
        for n in (*meets.rubbing, *meets.switching):
            slip = held[n]["slip"]
            way = np.sign(slip) if n in meets.rubbing else _side(slip, held[n]["tangent"])
            self.touch[n], self.touch[all_of + n] = DECIDES, way
            self.still[:] = 1.0
        first = 2 * (all_of + count) + 2 * len(meets.peaks)
        for place, name in enumerate(HELD_STARTS):
            for k, n in enumerate(meets.held):
                value = held[n][name.removeprefix("most ")]
                self.touch[first + place * len(held) + k] = np.abs(value) if name.startswith("most ") else value
        self.constants[: 2 * all_of] = self.touch[: 2 * all_of]
        return np.asarray(apart.all(axis=0))

    def _touch_rigid(self, meets: Meets, state: np.ndarray, rows: np.ndarray, held: Held, apart: np.ndarray) -> None:
        """Rigid contacts: those at their walls hit if one does, else they decide; a clutch may be struck shut."""
        near = {}
        for n in meets.rigid:
            at_wall = np.minimum(START_NEAR * _size(meets, n, state), START_SIZE * _size(meets, n, state, at.GAP_SIZE))
            near[n] = (rows[n] <= at_wall) & (held[n]["calm"] <= 0.0)
            apart[n] = rows[n] > -at_wall
            if meets.table[n, at.LEVEL]:
                apart[n] = True
        hits = {n: near[n] & (held[n]["calm"] < 0.0) & (n not in meets.limited) for n in meets.rigid}
        any_hits = np.any([*hits.values(), np.zeros(self.n, dtype=bool)], axis=0)
        for n in meets.rigid:
            rests = np.where(any_hits, HITS, DECIDES)
            open_ = np.where(any_hits, HITS, OPEN) if meets.table[n, at.LEVEL] else OPEN
            self.touch[n] = np.where(hits[n], HITS, np.where(near[n], rests, open_))
            self.touch[meets.all_of + n] = np.where(near[n], np.sign(held[n]["slip"]), 0.0)
            self.still[near[n]] = 1.0
            if n in meets.limited:
                rate = held[n]["calm"]
                self.touch[n] = np.where(rate > 0.0, OPEN, np.where(rate < 0.0, SHUT, DECIDES))
                self.touch[meets.all_of + n] = np.where(rate < 0.0, -1.0, 0.0)

    def _touch_elastic(self, meets: Meets, state: np.ndarray, rows: np.ndarray, held: Held, apart: np.ndarray) -> None:
        """Compliant contacts: those that move into their walls, or are inside; clutches that take without an impact."""
        count, all_of = meets.n, meets.all_of
        at_wall, presses, inside = self._at_walls(meets, rows, self._later(state))
        for n in meets.held:  # one whose force would pull is left to a run alone
            if n < count and n not in meets.rigid:
                inside[n] &= held[n]["pressed"] >= 0.0
        at_once = (at_wall & presses) | inside
        apart |= (at_wall & ~presses) | (at_once & ~self.still.astype(bool))
        self.touch[:count][at_once] = 1.0
        self.touch[all_of : all_of + count][at_once] = np.maximum(-rows[count : 2 * count], 0.0)[at_once]
        self.touch[LANE.index("closing") - len(LANE)] = at_once.any(axis=0)
        self.still[at_once.any(axis=0)] = 1.0
        for n in range(count):
            if meets.table[n, at.LEVEL] and n not in meets.rigid:
                self.touch[n], apart[n] = rows[count + n] < 0.0, True
                self.still[:] = 1.0

    def _later(self, state: np.ndarray) -> np.ndarray:
        """State a little after the start, if no contact acts."""
        ny, later = self.program.model.ny, state.copy()
        later[1 : 1 + ny] += LATER * self.ahead * self.rate
        return later

    def _at_walls(self, meets: Meets, rows: np.ndarray, later: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(n contacts, n) True of compliant ones that start at their walls, inside them by no more than rounding; of
        those that move into them, or begin to; of those that start farther inside."""
        count, nq = meets.n, meets.nq
        at_wall, presses, inside, after = *np.zeros((3, count, self.n), dtype=bool), np.zeros_like(rows)
        meets.touched(later, after)
        slow = AT_WALL * np.abs(self.y[nq : 2 * nq]).max(axis=0)
        for n in range(count):
            if n not in meets.rigid and not meets.table[n, at.LEVEL]:
                size, rate = _size(meets, n, later), rows[count + n]
                at_wall[n] = (rows[n] <= 0.0) & (rows[n] >= -AT_WALL * size)
                if not meets.lever[n][at.ONE_WAY]:  # below a segment it touches nothing
                    inside[n] = rows[n] < -AT_WALL * size
                presses[n] = (rate < -slow) | ((rate <= slow) & (after[count + n] < rate))
        return at_wall, presses, inside

    @property
    def evaluations(self) -> int:
        """Right-hand sides that a sample takes."""
        return 2 if self.program.method.adaptive else 1


def _size(meets: Meets, n: int, state: np.ndarray, column: int = at.GAP_SCALE) -> Any:
    """Size of the gap of a contact [m or rad], or of the mechanism (GAP_SIZE), of each sample if these differ."""
    scale = meets.lever[n][column]
    return state[scale.place] if isinstance(scale, Row) else scale


def _side(value: Any, rate: Any) -> np.ndarray:
    """(n,) that on which a switching function with this value and rate (n,) is, or which it enters."""
    return np.where(np.where(value != 0.0, value, rate) < 0.0, -1.0, 1.0)
