"""A batch of lanes: tiles of memory in whose columns samples take their steps.

A tile holds all rows of a few lanes, so that they stay in the nearest cache while these take many steps in one call.
Rows that a function reads or writes stand next to each other, so that no row is gathered: a state is t, y, constants;
slopes follow y; what `settle` reads is one report.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rattle.trace.crossings import bracketed
from rattle.trace.lane_chain import Aside, Call, Calls
from rattle.trace.lane_contacts import COUNTED, Touch
from rattle.trace.lane_control import (
    CONTROL,
    GOING_ON,
    NUMBER,
    RUNNING,
    STATUS,
    STEPS,
    TRIES,
    Status,
)
from rattle.trace.lane_methods import PLAN
from rattle.trace.lane_program import EIGHT, Program, filled
from rattle.trace.lane_rows import ASIDE
from rattle.trace.lane_start import Stock
from rattle.trace.reductions import NEVER

LINE = 8  # numbers in a line of the cache
TILE = 200_000  # bytes: less than half of what is near to a core; twice as many is as fast, half as many 5 % slower


def _aligned(*shape: int) -> np.ndarray:
    """Zeros that begin with a line of the cache."""
    raw = np.zeros(math.prod(shape) + LINE)
    skip = -raw.ctypes.data // 8 % LINE
    return raw[skip : skip + math.prod(shape)].reshape(shape)


class Tallies(NamedTuple):
    """What samples took, in all."""

    evaluations: int = 0  # of the right-hand side
    tries: int = 0  # steps that were tried
    doubts: int = 0  # of these, not proven free of contacts
    landings: int = 0  # to end at a contact
    turns: int = 0  # contacts that began or ended, or changed

    def plus(self, other: Tallies) -> Tallies:
        """Both together."""
        return Tallies(*(a + b for a, b in zip(self, other, strict=True)))


class Batch:
    """At least n lanes; `sample` (lanes,) is the number of the sample in each, -1 where there is none."""

    def __init__(self, program: Program, n: int, looks: int) -> None:
        """looks: steps of a lane after which Python looks what came of it."""
        self.program, self.rows = program, program.rows
        fitting = EIGHT * max(1, TILE // (8 * EIGHT * self.rows.count))
        self.tile = tile = min(n, fitting if program.tiled else n)
        self.memory = _aligned(-(-n // tile), self.rows.count, tile)
        self.n = len(self.memory) * tile
        self.sample = np.full(self.n, -1)
        self._wide = (1 + program.model.ny) * tile  # components of a state, seen flat
        self._block = program.model.ny + 2 + len(program.ledger.watched)  # rows of a block
        for name in ("blocks", ASIDE + "blocks") if program.ledger.watched else ("blocks",):
            self._all(name).reshape(len(self.memory), -1, self._block, tile)[:, 3:, 0] = 1.0  # slopes of t
        running = self.rows.places["control"].start + RUNNING
        before, after = self._calculation(), self._settling()
        conditions = bool(program.ledger.conditions)
        chains: list[Calls] = [before, after] if conditions else [[*before, *after]]
        self._chains = [program.chain(chain, self.memory, running, 1 if conditions else looks) for chain in chains]

    def _all(self, name: str) -> np.ndarray:
        """Rows of a group (tiles, rows, lanes of a tile)."""
        return self.memory[:, self.rows.places[name]]

    def _first(self, name: str) -> np.ndarray:
        """Rows of a group in the first tile."""
        return self.memory[0, self.rows.places[name]]

    def _flat(self, name: str, rows: int) -> np.ndarray:
        """A group in the first tile as so many flat rows of components."""
        columns: np.ndarray = self._first(name).reshape(rows, -1)[:, : self._wide]
        return columns

    def _lane(self, name: str, lanes: np.ndarray) -> np.ndarray:
        """Rows of a group in some lanes (rows, k)."""
        columns: np.ndarray = self._all(name)[lanes // self.tile, :, lanes % self.tile].T
        return columns

    def _put(self, name: str, lanes: np.ndarray, rows: np.ndarray) -> None:
        self._all(name)[lanes // self.tile, : len(rows), lanes % self.tile] = rows.T

    def _blocks(self, aside: str = "") -> np.ndarray:
        """Blocks in the first tile (blocks, rows, lanes)."""
        return self._first(aside + "blocks").reshape(-1, self._block, self.tile)

    def _moved(self, aside: str = "") -> np.ndarray:
        """t and y of the state in the first tile as one row."""
        return self._first(aside + "state")[: 1 + self.program.model.ny].reshape(1, -1)

    def _stage(self, s: int, aside: str = "") -> list[Call]:
        """The slopes at a stage."""
        program, model, blocks = self.program, self.program.model, self._blocks(aside)
        flat = self._flat(aside + "blocks", len(blocks))
        watch = model.watch if program.ledger.watched and s in program.method.seen else None
        rate, rows = (watch, blocks[3 + s, 1:]) if watch is not None else (model.rate, blocks[3 + s, 1 : 2 + model.ny])
        return [
            (program.stages[s], flat[1 : 3 + s], self._moved(aside)), (rate, self._first(aside + "state"), rows),
        ]  # fmt: skip

    def _calculation(self) -> list[Call]:
        """What a step takes: stages, end, projection, curves; slopes and flags go to the blocks."""
        program, stages, copy, wide = (
            self.program,
            self.program.method.stages,
            self.program.copy,
            self._wide // self.tile,
        )
        blocks, state, moved = self._blocks(), self._first("state"), self._moved()
        flat, squares, planned = self._flat("blocks", len(blocks)), self._flat_squares(), self._first("planned")
        judged = self.memory[0, self.rows.span("errors", "planned")]
        calls: list[Call] = [
            (program.plan, self._first("control")[-len(PLAN) :], planned),
            (program.spread, planned[:1], blocks[1, :wide]),
            *(call for s in range(1, stages) for call in self._stage(s)),
            (program.end, flat[1 : 3 + stages], squares), (program.judge, judged, self._first("verdict")),
            (copy, squares[:1], moved), (copy, planned[1:2], state[:1]), *self._striking(), *self._arrival(),
            *self._meeting(),
        ]  # fmt: skip
        if program.ledger.sampled:
            calls += self._samples()
        return [
            *calls, (program.checks, self._first("blocks"), self.memory[0, self.rows.span("flags", "seen")]),
            (program.curve_checks, self._first("later"), self._first("curve flags")),
        ]  # fmt: skip

    def _arrival(self) -> list[Call]:
        """The end of the step, its slopes and its curves, from the state before it is projected."""
        program, model, copy, blocks = self.program, self.program.model, self.program.copy, self._blocks()
        state, time, wide = self._first("state"), self._first("planned")[1:2], 1 + model.ny
        ends = blocks[0, 1 : 1 + wide], blocks[3 + program.method.stages, 1 : 1 + wide]
        last = self._first("later")[-(model.curves + 1) :]
        if model.project is not None:
            flat = self._flat("blocks", len(blocks))
            return [
                (model.project, state, ends[0]), (copy, time, blocks[0, :1]), (copy, flat[:1], self._moved()),
                (model.rate, state, ends[1]), (model.outputs, state, last),
            ]  # fmt: skip
        assert model.arrive is not None
        arrived, row, curves = self._first("arrived"), (1, -1), 2 * wide + model.curves + 1
        parts = arrived[:wide], arrived[wide : 2 * wide], arrived[2 * wide : curves], arrived[curves:]
        targets = zip(parts, (*ends, last, self._first("ends")), strict=True)
        return [
            (model.arrive, state, arrived), (copy, time, blocks[0, :1]),
            *((copy, rows.reshape(row), target.reshape(row)) for rows, target in targets if len(rows)),
        ]  # fmt: skip

    def _striking(self) -> list[Call]:
        """What rigid contacts do to the state at the end of the step, and what they become."""
        meets, ny, copy, row = self.program.model.meets, self.program.model.ny, self.program.copy, (1, -1)
        if meets is None:
            return []
        after, state = self._first("after"), self._first("state")
        return [
            (meets.struck, state, after), (copy, after[:ny].reshape(row), state[1 : 1 + ny].reshape(row)),
            (copy, after[ny:].reshape(row), self._first("struck").reshape(row)),
        ]  # fmt: skip

    def _meeting(self) -> list[Call]:
        """What the step says of contacts."""
        program, meets = self.program, self.program.model.meets
        if meets is None:
            return []
        step = self._first("blocks")[: (4 + program.method.stages) * self._block]
        return [
            (program.middle, step, self._first("state")[: 1 + program.model.ny]),
            (meets.midway, self._first("state"), self._first("midway")),
            (program.meet, self.memory[0], self._first("met")),
        ]  # fmt: skip

    def _samples(self, aside: str = "") -> list[Call]:
        """Dense output, and the curves at the ends of all parts of a step but the last."""
        program, model, moved = self.program, self.program.model, self._moved(aside)
        dense, samples = 5 + len(program.method.upper), program.ledger.samples
        flat = self._flat(aside + "blocks", len(self._blocks(aside)))
        inside = self._flat(aside + "inside", dense + samples - 1)
        later = self._first(aside + "later").reshape(samples, model.curves + 1, -1)
        calls = [call for s in program.later for call in self._stage(s, aside)]
        calls.append((program.dense, flat, inside[1:]))
        for k, row in enumerate(range(dense, len(inside))):
            calls += [
                (program.copy, inside[row : row + 1], moved), (model.outputs, self._first(aside + "state"), later[k]),
            ]  # fmt: skip
        return calls

    def _aside(self) -> Aside:
        """Samples of steps that ask for them."""
        program, wide = self.program, 1 + self.program.model.ny
        blocks, columns = (self._blocks(where)[:, :wide] for where in ("", ASIDE))
        curves, held = program.model.curves + 1, self._first("rows")
        copies = [
            *((blocks[k], columns[k]) for k in (0, 1, 2, *(3 + s for s in program.method.dense_slopes))),
            (self._first("state")[wide:], self._first(ASIDE + "state")[wide:]),
            (self._first("curves"), self._first(ASIDE + "curves")),
            (self._first("later"), self._first(ASIDE + "later")[-curves:]),
        ]
        sampled = self.memory[0, self.rows.span(ASIDE + "curves", ASIDE + "blocks")]
        rows = [*program.ledger.screened.values(), program.ledger.aside_row]
        return Aside(
            self._first("asks")[0], copies, self._first(ASIDE + "lane")[0], self._first(ASIDE + "taken")[0],
            [*self._samples(ASIDE), (program.aside, sampled, self._first(ASIDE + "larger"))],
            [(larger, held[row]) for larger, row in zip(self._first(ASIDE + "larger"), rows, strict=True)],
        )  # fmt: skip

    def _flat_squares(self) -> np.ndarray:
        """The end of the step and squares of errors, as flat rows."""
        squares: np.ndarray = self.memory[0, self.rows.span("y new", "errors")].reshape(-1, self._wide)
        return squares

    def _settling(self) -> Calls:
        """What makes the end of a good step the start of the next."""
        program, blocks, row = self.program, self._blocks(), (1, -1)
        flat, merged = self._flat("blocks", len(blocks)), self._flat("merged", 2)
        step = blocks[1, : 1 + program.model.ny]
        new, curves = self._first("next"), program.model.curves + 1
        report, held = (self.memory[0, self.rows.span(name, "control")] for name in ("planned", "curves"))
        return [
            (program.settle, report, self.memory[0, self.rows.span("good", "next")]),
            (program.copy, new[curves:].reshape(row), held[curves:].reshape(row)),
            *([self._aside()] if program.ledger.watched else []),  # it reads the old curves, and writes new rows
            (program.copy, new[:curves].reshape(row), held[:curves].reshape(row)),
            *self._touching(),
            (program.spread, self._first("good"), step),
            (program.merged, flat[: 4 + program.method.stages], merged), (program.copy_two, merged, flat[2:4]),
        ]  # fmt: skip

    def _touching(self) -> list[Call]:
        """Which contacts are shut, and how fast they closed, becomes part of the state."""
        if (meets := self.program.model.meets) is None:
            return []
        count, wide = meets.inputs, 1 + self.program.model.ny
        pair = self._first("touch")[:count], self._first("state")[wide : wide + count]
        return [(self.program.copy, pair[0].reshape(1, -1), pair[1].reshape(1, -1))]

    def take(self, lanes: np.ndarray, stock: Stock, columns: np.ndarray, samples: np.ndarray) -> None:
        """Put samples that stand in columns of a stock into lanes."""
        program, ny, k = self.program, self.program.model.ny, len(lanes)
        self.sample[lanes] = samples
        tiles, lane = lanes // self.tile, lanes % self.tile
        blocks = self._all("blocks").reshape(len(self.memory), -1, self._block, self.tile)
        blocks[tiles, 2, 0, lane] = 0.0
        blocks[tiles, 2, 1 : 1 + ny, lane] = stock.y[:, columns].T
        blocks[tiles, 3, 1 : 1 + ny, lane] = stock.rate[:, columns].T
        self._all("state")[tiles, 1 + ny :, lane] = stock.constants[:, columns].T
        self._put("curves", lanes, stock.curves[:, columns])
        self._put("touch", lanes, stock.touch[:, columns])
        self._put("rows", lanes, stock.rows[:, columns])
        control = np.zeros((len(CONTROL), k))
        control[RUNNING], control[STATUS] = 1.0, GOING_ON
        plan = control[len(CONTROL) - len(PLAN) :]
        plan[1], plan[2], plan[5] = stock.ahead[columns], program.stops[0], program.counts[0]
        plan[PLAN.index("still")] = stock.still[columns]
        self._put("control", lanes, control)

    def go_on(self, lanes: np.ndarray, stop: float | np.ndarray) -> None:
        """Let lanes that are through, at a stop of the program, go on to another one [s], or each to its own; the step
        length is kept."""
        control = self._lane("control", lanes)
        control[RUNNING], control[STATUS], control[NUMBER] = 1.0, GOING_ON, 0.0
        control[len(CONTROL) - len(PLAN) + PLAN.index("stop")] = stop
        self._put("control", lanes, control)

    def states(self, lanes: np.ndarray) -> np.ndarray:
        """State y (ny, k) of lanes after their last step."""
        blocks = self._all("blocks").reshape(len(self.memory), -1, self._block, self.tile)
        states: np.ndarray = blocks[lanes // self.tile, 2, 1 : 1 + self.program.model.ny, lanes % self.tile].T
        return states

    def step(self) -> np.ndarray:
        """Some steps of every lane, accepted or not.  Returns the lanes whose samples are through."""
        self._chains[0]()
        if len(self._chains) > 1:
            self._cross()
            self._chains[1]()
        return np.flatnonzero((self.sample >= 0) & (self._all("control")[:, RUNNING].reshape(-1) == 0.0))

    def ended(self, lanes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, Tallies]:
        """Status, steps (k,) of lanes whose samples are through; values of the reductions (reductions, k); what they
        took."""
        program, control, count = self.program, self._lane("control", lanes), len(lanes)
        rows = np.ascontiguousarray(self._lane("rows", lanes[filled(len(lanes))]))
        values = np.zeros((len(program.ledger.reductions), rows.shape[1]))
        program.close(rows, values)
        status, steps, tries = (control[k].astype(np.int64) for k in (STATUS, STEPS, TRIES))
        spent = program.evaluations * int(tries.sum())
        if program.ledger.watched:
            states, asked = rows[program.ledger.aside_row :][:2, :count].astype(np.int64)
            status = np.where(status == Status.DONE, states, status)
            spent += len(program.later) * int(asked.sum())
        tallies = Tallies(spent, int(tries.sum()))
        if program.model.meets is not None:
            touch = Touch(program.model.meets, list(self._lane("touch", lanes)))
            tallies = Tallies(
                spent, tallies.tries, *(int(np.sum(np.asarray(touch.lane[name], dtype=float))) for name in COUNTED)
            )
        return status, steps, values[:, :count], tallies

    def _cross(self) -> None:
        """Where in the step conditions begin and end, in the lanes that ask."""
        ledger, parts = self.program.ledger, self.program.ledger.parts
        first = self._all("curves").shape[1]
        span = self.memory[:, self.rows.span("later", "curves")]
        samples = np.roll(span.reshape(len(span), parts + 1, first, -1), 1, axis=1)  # the start of the step last
        verdict, flags = self._all("verdict")[:, 1], self.memory[:, self.rows.span("curve flags", "flags")]
        asks = (verdict != 0.0) & (flags != 0.0).all(axis=1) & (self._all("control")[:, RUNNING] != 0.0)
        for n, curve in enumerate(ledger.conditions):
            g = samples[:, :, curve].swapaxes(0, 1).reshape(parts + 1, -1)
            on = g > 0.0
            turns = (on[1:] != on[:-1]) & asks.reshape(-1)
            total, begin = np.zeros(self.n), np.full(self.n, NEVER)
            while (few := np.flatnonzero(turns.any(0))).size:
                k = turns[:, few].argmax(0)
                turns[k, few] = False
                theta = self._zero(curve, few, k / parts, (k + 1) / parts, g[k, few], g[k + 1, few])
                begins = on[k + 1, few]
                total[few] += np.where(begins, theta, -theta)
                begin[few] = np.where(begins & (begin[few] == NEVER), theta, begin[few])
            crossings = self._all("crossings")
            crossings[:, 2 * n], crossings[:, 2 * n + 1] = (x.reshape(-1, self.tile) for x in (total, begin))

    def _zero(
        self, curve: int, lanes: np.ndarray, a: np.ndarray, b: np.ndarray, ga: np.ndarray, gb: np.ndarray
    ) -> np.ndarray:
        """Shares of the step, between a and b, where a curve crosses zero in a few lanes."""
        model, wide, count = self.program.model, 1 + self.program.model.ny, len(lanes)
        fill = filled(count)
        lanes, a, b, ga, gb = (column[fill] for column in (lanes, a, b, ga, gb))
        dense, k = 5 + len(self.program.method.upper), len(fill)
        inside = np.ascontiguousarray(self._lane("inside", lanes)[: dense * wide]).reshape(dense, wide * k)
        state, curves = np.ascontiguousarray(self._lane("state", lanes)), np.empty((model.curves + 1, k))
        moved = state[:wide].reshape(1, -1)

        def value(theta: np.ndarray) -> np.ndarray:
            inside[0].reshape(wide, k)[:] = theta
            self.program.inside(inside, moved)
            model.outputs(state, curves)
            return np.array(curves[curve])

        return bracketed(value, a, b, ga, gb)[:count]
