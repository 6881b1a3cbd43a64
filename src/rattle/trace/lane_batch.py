"""A batch of lanes: arrays in whose columns samples take their steps.

Rows that a function reads or writes stand next to each other, so that no row is gathered: a state is t, y, constants;
slopes follow y; a flag that a function writes after its slopes is read at once, as the next slopes take its place.
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
        ny, wide = model.ny, model.curves + 1
        self.program, self.n = program, n
        self.sample = np.full(n, -1)
        self.steps, self.tries, self._stop = (np.zeros(n, dtype=np.int64) for _ in range(3))
        # end, step, y, slopes: a row of blocks has one component in a column
        blocks = 3 + len(method.a)
        self._blocks = np.zeros((blocks * ny + 1, n))
        self._flat = self._blocks[:-1].reshape(blocks, ny * n)
        self._end, self._h, self._y = (self._blocks[k * ny : (k + 1) * ny] for k in range(3))
        self._slopes = [self._blocks[(3 + s) * ny : (4 + s) * ny + 1] for s in range(len(method.a))]
        self._state = np.zeros((1 + ny + model.nc, n))
        self._moved, self._moved_flat = self._state[1 : 1 + ny], self._state[1 : 1 + ny].reshape(1, ny * n)
        # end of the step and squares of errors, then the plan
        parts = 3 if method.adaptive else 1
        self._errors = np.zeros((parts * ny + len(PLAN) + len(PLANNED), n))
        self._errors_flat = self._errors[: parts * ny].reshape(parts, ny * n)
        self._plan = self._errors[parts * ny : parts * ny + len(PLAN)]
        self._planned = self._errors[parts * ny + len(PLAN) :]
        self._verdict = np.zeros((2, n))
        self._closed = np.zeros((ny + 1, n))
        # share of the step, y, dense output
        self._inside = np.zeros((5 + len(method.upper), ny * n))
        # step, crossings, curves, rows
        self._report = np.zeros((ledger.step_rows, n))
        first = 4 + 2 * len(ledger.conditions)
        self._crossings = self._report[4:first]
        ends = first + wide * (ledger.parts + 1)
        self._curves = self._report[first:ends].reshape(ledger.parts + 1, wide, n)
        self._rows, self._rows_new = self._report[ends:], np.zeros((ledger.rows, n))
        self.values = np.zeros((len(ledger.reductions), n))
        self._sound = np.zeros(n, dtype=bool)

    def take(self, lanes: np.ndarray, stock: Stock, columns: np.ndarray, samples: np.ndarray) -> None:
        """Put samples that stand in columns of a stock into lanes."""
        self.sample[lanes], self.steps[lanes], self.tries[lanes], self._stop[lanes] = samples, 0, 0, 0
        self._y[:, lanes], self._slopes[0][:-1, lanes] = stock.y[:, columns], stock.rate[:, columns]
        self._state[1 + self.program.model.ny :, lanes] = stock.constants[:, columns]
        self._curves[0][:, lanes], self._rows[:, lanes] = stock.curves[:, columns], stock.rows[:, columns]
        program = self.program
        zero = np.zeros(len(lanes))
        self._plan[:, lanes] = [
            zero, stock.ahead[columns], zero + program.stops[0], zero, zero, zero + program.counts[0],
        ]  # fmt: skip

    def step(self) -> np.ndarray:
        """One step of every lane, accepted or not.  Returns the `Status` of the lanes that are through, else -1."""
        program, plan, planned = self.program, self._plan, self._planned
        program.plan(plan, planned)
        self._h[:] = planned[0]
        self._sound[:] = True
        for s in range(1, program.method.stages):
            self._evaluate(s)
        program.end(self._flat[1 : 3 + program.method.stages], self._errors_flat)
        program.judge(self._errors[self.program.model.ny :], self._verdict)
        active = self.sample >= 0
        accepted = active & (self._verdict[1] != 0.0)
        kept = self._sound.copy()
        self._arrive()
        finite = np.isfinite(self._closed[:-1]).all(0) & np.isfinite(self._slopes[program.method.stages][:-1]).all(0)
        if program.ledger.sampled:
            self._sample()
            self._cross(accepted & self._sound & finite)
        finite &= np.isfinite(self._curves[1:]).all((0, 1))
        self._report[0], self._report[1], self._report[2] = planned[0], plan[0], self._stop
        self._report[3] = planned[2]
        program.step(self._report, self._rows_new)
        held = program.ledger.sound_row
        accounted = np.ones(self.n, dtype=bool) if held is None else self._rows_new[held] != 0.0
        status = np.select(
            [
                ~active, planned[3] != 0.0, ~kept, accepted & ~finite, accepted & ~self._sound, accepted & ~accounted,
                self.tries >= program.most_steps,
            ],
            [
                -1, Status.STEP_TOO_SMALL, Status.ASSUMPTION, Status.NOT_FINITE, Status.ASSUMPTION, Status.ENERGY,
                Status.TOO_MANY_STEPS,
            ],
            -1,
        )  # fmt: skip
        return self._go_on(active, accepted & (status < 0), status)

    def _evaluate(self, s: int) -> None:
        """The right-hand side at stage s."""
        program = self.program
        program.stages[s](self._flat[1 : 3 + s], self._moved_flat)
        np.multiply(self._planned[0], program.method.c[s], out=self._state[0])
        self._state[0] += self._plan[0]
        self._call(program.model.rate, self._slopes[s])

    def _call(self, function: Function, out: np.ndarray) -> None:
        """A function of the present state; its flag counts."""
        function(self._state, out)
        np.logical_and(self._sound, out[-1], out=self._sound)

    def _arrive(self) -> None:
        """The end of the step, brought onto the constraints; right-hand side and curves there."""
        program, ny = self.program, self.program.model.ny
        self._state[0], self._moved[:] = self._planned[1], self._errors[:ny]
        self._call(program.model.project, self._closed)
        self._moved[:] = self._closed[:-1]
        self._end[:] = self._closed[:-1]
        self._call(program.model.rate, self._slopes[program.method.stages])
        self._call(program.model.outputs, self._curves[-1])

    def _sample(self) -> None:
        """Curves at equal parts of the step."""
        program, parts = self.program, self.program.ledger.parts
        for s in program.later:
            self._evaluate(s)
        program.dense(self._flat, self._inside[1:])
        for k in range(1, parts):
            self._inside[0] = k / parts
            program.inside(self._inside, self._moved_flat)
            np.multiply(self._planned[0], k / parts, out=self._state[0])
            self._state[0] += self._plan[0]
            self._call(program.model.outputs, self._curves[k])

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
        lanes, k = lanes[fill], len(fill)
        inside = np.take(self._inside.reshape(-1, ny, self.n), lanes, axis=2).reshape(-1, ny * k)
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
        np.copyto(self._y, self._end, where=good)
        np.copyto(self._slopes[0][:-1], self._slopes[program.method.stages][:-1], where=good)
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
