"""What lanes calculate: functions of a model, of a method and of reductions, ready to be called."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from rattle.trace import lane_methods as methods
from rattle.trace.graph import Graph
from rattle.trace.lane_methods import Method, Tolerances
from rattle.trace.reductions import Energies, Ledger, Reduction

# f(rows in (n_in, n), rows out (n_out, n)): column by column, for any n that is a multiple of 8 or of the width of a
# batch; arrays are float64, do not overlap, and each row is without gaps, at any distance from the next
Function = Callable[[np.ndarray, np.ndarray], None]
Compile = Callable[[Graph, Sequence[Any]], Function]  # of a graph of exact operations
Calls = Sequence[tuple[Function, np.ndarray, np.ndarray]]  # functions, each with its rows in and out
Chain = Callable[[Calls], Callable[[], None]]  # makes one call of many, on arrays that stay where they are


def one_by_one(calls: Calls) -> Callable[[], None]:
    """The chain that Python makes: one function after the other."""
    given = tuple(calls)

    def call() -> None:
        for function, rows, out in given:
            function(rows, out)

    return call


ENERGY_LIMIT = 1e-3  # share of the largest energy that may be unaccounted for
MOST_STEPS = 1_000_000
USUAL = Tolerances(1e-8, 1e-10)


class Status(IntEnum):
    """How the run of a sample ended; `words` says it."""

    DONE = 0
    START = 1
    ASSUMPTION = 2
    NOT_FINITE = 3
    ENERGY = 4
    TOO_MANY_STEPS = 5
    STEP_TOO_SMALL = 6

    @property
    def words(self) -> str:
        """As part of a message."""
        return WORDS[self]


WORDS = {
    Status.DONE: "done",
    Status.START: "has no start: the loops do not close, or the rates do not fit",
    Status.ASSUMPTION: "comes next to a singular position or coincident points, which straight-line code cannot pass",
    Status.NOT_FINITE: "has no finite value: a load or curve outside its domain, or a diverging motion",
    Status.ENERGY: "has an energy error above the limit",
    Status.TOO_MANY_STEPS: "takes too many steps",
    Status.STEP_TOO_SMALL: "needs steps that are too short",
}


class Model(NamedTuple):
    """Functions of one smooth model; rows in are t [s], y (ny), constants of the sample (nc)."""

    ny: int
    nc: int
    curves: int
    motion: int  # the first components of y: positions and rates [SI]
    controlled: tuple[int, ...]  # components whose errors choose the step
    begin: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
    # parameters (np, k) -> y at t = 0 (ny, k), constants (nc, k), it is sound (k,)
    rate: Function  # dy/dt (ny), flag: computed on sound assumptions
    project: Function  # y on the constraints (ny), flag
    outputs: Function  # curves [SI], flag
    energies: tuple[int, int, int, int, int] | None = None  # curves, see `Energies`; None: not checked


class Program:
    """A model, a method and reductions, compiled; it does not change while it runs, so that threads may share it."""

    def __init__(
        self, model: Model, compile: Compile, method: Method, reductions: Sequence[Reduction], t_end: float, *,
        tolerances: Tolerances = USUAL, step: float = math.inf, chain: Chain = one_by_one,
        energy_limit: float = ENERGY_LIMIT, most_steps: int = MOST_STEPS,
    ) -> None:  # fmt: skip
        """step: the longest one of a method with equal steps [s]; tolerances: of the others.

        Raises ValueError for reductions that the model or the span does not have.
        """
        for one in reductions:
            if one.kind == "at" and not 0.0 <= one.t <= t_end:
                raise ValueError(f"{one}: an instant from 0 to {t_end} s expected")
        inner = {float(one.t) for one in reductions if one.kind == "at" and 0.0 < one.t < t_end}
        self.model, self.method, self.t_end, self.most_steps = model, method, t_end, most_steps
        self.chain = chain
        self.stops = np.array([*sorted(inner), t_end])
        energies = None if model.energies is None else Energies(model.energies, energy_limit)
        self.ledger = ledger = Ledger(reductions, model.curves, self.stops.tolist(), method.samples, energies)
        counts, lengths = methods.segments(self.stops.tolist(), math.inf if method.adaptive else step)
        self.counts, self.lengths = np.array(counts, dtype=float), np.array(lengths)
        later = range(method.stages + 1, len(method.a)) if ledger.sampled else range(0)
        self.later = tuple(later)  # stages for the dense output alone
        self.evaluations = method.stages + len(self.later)  # of the right-hand side in a step
        self.stages = {s: compile(*methods.stage(method, s)) for s in (*range(1, method.stages), *later)}
        self.plan = compile(*methods.plan(method, t_end))
        self.end = compile(*methods.end(method, tolerances))
        self.judge = compile(*methods.judge(method, tolerances, model.ny, model.controlled, model.motion))
        self.dense, self.inside = compile(*methods.dense(method, ledger.parts)), compile(*methods.inside(method))
        self.checks = compile(*methods.checks(method, model.ny, self.later))
        self.curve_checks = compile(*methods.curve_checks(ledger.parts, model.curves))
        self.merged, self.copy_two = compile(*methods.merged(method)), compile(*methods.copied(2))
        self.copy, self.spread = compile(*methods.spread(1)), compile(*methods.spread(model.ny))
        self.times = compile(*methods.times([*method.c, *(k / ledger.parts for k in range(1, ledger.parts))]))
        if method.adaptive:
            self.first_try = compile(*methods.first_try(tolerances, model.ny, model.motion, t_end))
            self.first_step = compile(*methods.first_step(tolerances, model.ny, model.motion, t_end))
        self.start, self.step, self.close = (compile(*one()) for one in (ledger.start, ledger.step, ledger.close))
