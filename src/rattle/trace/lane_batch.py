"""A batch of lanes: arrays in whose columns samples take their steps.

Rows that a function reads or writes stand next to each other, so that no row is gathered: a state is t, y, constants;
slopes follow y.  What all lanes calculate in a step is one chain of calls on arrays that stay where they are.
"""

from __future__ import annotations

import numpy as np

from rattle.trace.crossings import bracketed
from rattle.trace.lane_methods import PLAN, PLANNED
from rattle.trace.lane_program import Function, Program, Status
from rattle.trace.lane_start import Stock
from rattle.trace.reductions import NEVER

EIGHT = 8  # columns of a gathered few are a multiple of it


class Batch:
    """n lanes; `sample` (n,) is the number of the sample in each, -1 where there is none."""

    def __init__(self, program: Program, n: int) -> None:
        model, method, ledger = program.model, program.method, program.ledger
        ny, wide, parts = model.ny, model.curves + 1, ledger.parts
        self.program, self.n = program, n
        self.sample = np.full(n, -1)
        self.steps, self.tries, self._stop = (np.zeros(n, dtype=np.int64) for _ in range(3))
        # end, step, y, slopes: blocks of ny rows and a flag; seen flat, a block is one row of components
        self._blocks = np.zeros((3 + len(method.a), ny + 1, n))
        self._flat = self._blocks.reshape(len(self._blocks), -1)[:, : ny * n]
        self._end, self._h, self._y, *self._slopes = self._blocks[:, :ny]
        self._state = np.zeros((1 + ny + model.nc, n))
        # end of the step and squares of errors, then the plan
        self._errors = np.zeros(((3 if method.adaptive else 1) * ny + len(PLAN) + len(PLANNED), n))
        self._plan, self._planned = self._errors[-len(PLAN + PLANNED) : -len(PLANNED)], self._errors[-len(PLANNED) :]
        self._verdict = np.zeros((2, n))
        self._times = np.zeros((len(method.c) + parts - 1, n))
        # share of the step, y, dense output, states between parts
        self._inside = np.zeros((5 + len(method.upper) + parts - 1, ny * n))
        # step, crossings, curves, rows
        self._report = np.zeros((ledger.step_rows, n))
        first = 4 + 2 * len(ledger.conditions)
        self._crossings = self._report[4:first]
        ends = first + wide * (parts + 1)
        self._curves = self._report[first:ends].reshape(parts + 1, wide, n)
        self._rows, self._rows_new = self._report[ends:], np.zeros((ledger.rows, n))
        self.values = np.zeros((len(ledger.reductions), n))
        self._flags, self._curve_flags = np.zeros((3, n)), np.zeros((2, n))
        self._good, self._merged = np.zeros((1, n)), np.zeros((2, ny * n))
        self._calculate, self._merge = program.chain(self._calls()), program.chain(self._merging())

    def _calls(self) -> list[tuple[Function, np.ndarray, np.ndarray]]:
        """What a step takes: stages, end, projection, curves; slopes and flags go to the blocks."""
        program, model, stages = self.program, self.program.model, self.program.method.stages
        ny, n, flat, blocks = model.ny, self.n, self._flat, self._blocks
        state, copy = self._state, program.copy
        now, moved = state[:1], state[1 : 1 + ny].reshape(1, ny * n)
        plan = self._errors[-len(PLAN + PLANNED) :]

        def stage(s: int) -> list[tuple[Function, np.ndarray, np.ndarray]]:
            return [
                (copy, self._times[s : s + 1], now),
                (program.stages[s], flat[1 : 3 + s], moved),
                (model.rate, state, blocks[3 + s]),
            ]

        squares = self._errors[: -len(plan)].reshape(-1, ny * n)
        calls = [
            (program.plan, self._plan, self._planned), (program.spread, self._planned[:1], self._h),
            (program.times, plan, self._times), *(call for s in range(1, stages) for call in stage(s)),
            (program.end, flat[1 : 3 + stages], squares), (program.judge, self._errors[ny:], self._verdict),
            (copy, self._planned[1:2], now), (copy, squares[:1], moved), (model.project, state, blocks[0]),
            (copy, flat[:1], moved), (model.rate, state, blocks[3 + stages]), (model.outputs, state, self._curves[-1]),
        ]  # fmt: skip
        whole = [
            (program.checks, blocks.reshape(-1, n), self._flags),
            (program.curve_checks, self._curves.reshape(-1, n), self._curve_flags),
        ]
        if not program.ledger.sampled:
            return calls + whole
        calls += [call for s in program.later for call in stage(s)]
        calls.append((program.dense, flat, self._inside[1:]))
        between = 5 + len(program.method.upper)
        for k in range(1, program.ledger.parts):
            at, row = len(program.method.c) + k - 1, between + k - 1
            calls += [
                (copy, self._times[at : at + 1], now), (copy, self._inside[row : row + 1], moved),
                (model.outputs, state, self._curves[k]),
            ]  # fmt: skip
        return calls + whole

    def _merging(self) -> list[tuple[Function, np.ndarray, np.ndarray]]:
        """What makes the end of a good step the start of the next: its state and right-hand side."""
        program, flat = self.program, self._flat
        return [
            (program.spread, self._good, self._h),
            (program.merged, flat[: 4 + program.method.stages], self._merged),
            (program.copy_two, self._merged, flat[2:4]),
        ]

    def take(self, lanes: np.ndarray, stock: Stock, columns: np.ndarray, samples: np.ndarray) -> None:
        """Put samples that stand in columns of a stock into lanes."""
        self.sample[lanes], self.steps[lanes], self.tries[lanes], self._stop[lanes] = samples, 0, 0, 0
        self._y[:, lanes], self._slopes[0][:, lanes] = stock.y[:, columns], stock.rate[:, columns]
        self._state[1 + self.program.model.ny :, lanes] = stock.constants[:, columns]
        self._curves[0][:, lanes], self._rows[:, lanes] = stock.curves[:, columns], stock.rows[:, columns]
        program = self.program
        zero = np.zeros(len(lanes))
        self._plan[:, lanes] = [
            zero, stock.ahead[columns], zero + program.stops[0], zero, zero, zero + program.counts[0],
        ]  # fmt: skip

    def step(self) -> np.ndarray:
        """One step of every lane, accepted or not.  Returns the `Status` of the lanes that are through, else -1."""
        program, planned = self.program, self._planned
        self._calculate()
        active = self.sample >= 0
        accepted = active & (self._verdict[1] != 0.0)
        kept, sound, finite = self._flags != 0.0
        sound &= self._curve_flags[0] != 0.0
        finite &= self._curve_flags[1] != 0.0
        self._cross(accepted & sound & finite)
        self._report[0], self._report[1], self._report[2] = planned[0], self._plan[0], self._stop
        self._report[3] = planned[2]
        program.step(self._report, self._rows_new)
        held = program.ledger.sound_row
        accounted = np.ones(self.n, dtype=bool) if held is None else self._rows_new[held] != 0.0
        status = np.full(self.n, -1)
        for fails, why in (  # the last one that holds counts
            (self.tries >= program.most_steps, Status.TOO_MANY_STEPS), (accepted & ~accounted, Status.ENERGY),
            (accepted & ~sound, Status.ASSUMPTION), (accepted & ~finite, Status.NOT_FINITE),
            (~kept, Status.ASSUMPTION), (planned[3] != 0.0, Status.STEP_TOO_SMALL), (~active, -1),
        ):  # fmt: skip
            np.copyto(status, int(why), where=fails)
        return self._go_on(active, accepted & (status < 0), status)

    def _cross(self, lanes: np.ndarray) -> None:
        """Where in the step conditions begin and end; lanes (n,): those that ask."""
        parts = self.program.ledger.parts
        for n, curve in enumerate(self.program.ledger.conditions):
            total, first = self._crossings[2 * n : 2 * n + 2]
            total[:], first[:] = 0.0, NEVER
            g = self._curves[:, curve]
            on = g > 0.0
            turns = (on[1:] != on[:-1]) & lanes
            while (few := np.flatnonzero(turns.any(0))).size:
                k = turns[:, few].argmax(0)
                turns[k, few] = False
                theta = self._zero(curve, few, k / parts, (k + 1) / parts, g[k, few], g[k + 1, few])
                begins = on[k + 1, few]
                total[few] += np.where(begins, theta, -theta)
                first[few] = np.where(begins & (first[few] == NEVER), theta, first[few])

    def _zero(
        self, curve: int, lanes: np.ndarray, a: np.ndarray, b: np.ndarray, ga: np.ndarray, gb: np.ndarray
    ) -> np.ndarray:
        """Shares of the step, between a and b, where a curve crosses zero in a few lanes."""
        model, ny, count = self.program.model, self.program.model.ny, len(lanes)
        fill = np.minimum(np.arange(-(-count // EIGHT) * EIGHT), count - 1)
        a, b, ga, gb = (one[fill] for one in (a, b, ga, gb))
        lanes, k, dense = lanes[fill], len(fill), 5 + len(self.program.method.upper)
        inside = np.take(self._inside[:dense].reshape(dense, ny, self.n), lanes, axis=2).reshape(dense, ny * k)
        state, curves = np.take(self._state, lanes, axis=1), np.empty((model.curves + 1, k))
        t, h = self._plan[0, lanes], self._planned[0, lanes]
        moved = state[1 : 1 + ny].reshape(1, ny * k)

        def value(theta: np.ndarray) -> np.ndarray:
            inside[0].reshape(ny, k)[:] = theta
            self.program.inside(inside, moved)
            state[0] = t + h * theta
            model.outputs(state, curves)
            return np.array(curves[curve])

        return bracketed(value, a, b, ga, gb)[:count]

    def _go_on(self, active: np.ndarray, good: np.ndarray, status: np.ndarray) -> np.ndarray:
        """Make the end of the step the start of the next where it is good; returns the status."""
        program, plan = self.program, self._plan
        self._good[0] = good
        self._merge()
        np.copyto(plan[0], self._planned[1], where=good)
        np.copyto(plan[1], self._verdict[0], where=active)
        np.copyto(self._curves[0], self._curves[-1], where=good)
        np.copyto(self._rows, self._rows_new, where=good)
        plan[4] += good
        self.steps += good
        self.tries += active
        landed = np.flatnonzero(good & (self._planned[2] != 0.0))
        if landed.size:
            self._stop[landed] += 1
            through = self._stop[landed] == len(program.stops)
            status[landed[through]] = Status.DONE
            if through.any():
                program.close(self._rows, self.values)
            on = landed[~through]
            plan[2, on], plan[3, on], plan[4, on] = program.stops[self._stop[on]], program.stops[self._stop[on] - 1], 0
            if not program.method.adaptive:
                plan[1, on], plan[5, on] = program.lengths[self._stop[on]], program.counts[self._stop[on]]
        return status
