"""What lanes calculate: functions of a model, of a method and of reductions, ready to be called."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from rattle.errors import InputError
from rattle.language.recorded import Operand
from rattle.solvers.step_audit import energy_at_rest
from rattle.trace import lane_methods as methods
from rattle.trace.graph import Graph
from rattle.trace.lane_aside import results
from rattle.trace.lane_chain import Chain, Function, one_by_one
from rattle.trace.lane_contacts import Meets
from rattle.trace.lane_control import SHORT, Stops, settle
from rattle.trace.lane_gaps import Tile, meet, middle
from rattle.trace.lane_methods import Method, Tolerances
from rattle.trace.lane_rows import laid_out
from rattle.trace.reductions import Energies, Ledger, Reduction

Compile = Callable[[Graph, Sequence[Operand]], Function]  # of a graph of exact operations
EIGHT = 8  # functions take a multiple of so many columns


def filled(count: int) -> np.ndarray:
    """(n,) places 0 ... count - 1 of columns, count >= 1; the last one is repeated up to a multiple of EIGHT."""
    return np.minimum(np.arange(-(-count // EIGHT) * EIGHT), count - 1)


ENERGY_LIMIT = 1e-3  # share of the largest energy that may be unaccounted for
MOST_STEPS = 1_000_000
USUAL = Tolerances(1e-8, 1e-10)


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
    project: Function | None  # y on the constraints (ny), flag; None where `arrive` is given
    outputs: Function  # curves [SI], flag
    energies: tuple[int, int, int, int, int] | None = None  # curves, see `Energies`; None: not checked
    watch: Function | None = None  # as rate, then the curves of these numbers
    watched: tuple[int, ...] = ()
    arrive: Function | None = None  # project, then rate and outputs of the state that it gives, which share operations
    weight: float = 0.0  # energy of lifting it by its size [J]
    mass: float = 0.0  # of all bodies [kg]
    # contacts; then `arrive` ends with `Ends`, and constants begin with the first of `Touch`
    meets: Meets | None = None


class Program:
    """A model, a method and reductions, compiled; it does not change while it runs, so that threads may share it."""

    def __init__(
        self, model: Model, compile: Compile, method: Method, reductions: Sequence[Reduction], t_end: float, *,
        tolerances: Tolerances = USUAL, step: float = math.inf, short: float | None = None,
        chain: Chain = one_by_one, tiled: bool = False, energy_limit: float = ENERGY_LIMIT,
        most_steps: int = MOST_STEPS,
    ) -> None:  # fmt: skip
        """step: the longest one of a method with equal steps [s]; tolerances: of the others; short: a step that is
        short beside what is looked at [s]; tiled: lanes are worked on in tiles that fit into the cache, else all
        together.

        Raises InputError for reductions that the model or the span does not have.
        """
        inner = _instants_inside(reductions, t_end)
        self.model, self.method, self.t_end = model, method, t_end
        self.chain, self.tiled = chain, tiled
        self.stops = np.array([*sorted(inner), t_end])
        slight = energy_at_rest(model.mass, tolerances.atol)
        energies = None if model.energies is None else Energies(model.energies, energy_limit, model.weight, slight)
        self.ledger = ledger = Ledger(
            reductions, model.curves, self.stops.tolist(), method.samples, energies, model.watched
        )
        counts, lengths = methods.segments(self.stops.tolist(), math.inf if method.adaptive else step)
        self.counts, self.lengths = np.array(counts, dtype=float), np.array(lengths)
        later = range(method.stages + 1, method.slopes) if ledger.sampled or ledger.watched else range(0)
        self.later = tuple(later)  # stages for the dense output alone
        within = self.later if ledger.sampled else ()  # those of every step
        self.evaluations = method.stages + len(within)  # of the right-hand side in a step
        self.stages = {s: compile(*methods.stage(method, s)) for s in (*range(1, method.stages), *later)}
        self.rows = laid_out(model, method, ledger)
        self.plan = compile(*methods.plan(method, t_end, model.meets is not None))
        if model.meets is not None:
            watched = len(ledger.watched)
            tile = Tile(self.rows.places, self.rows.count)
            self.middle = compile(*middle(method, model.ny, model.meets.nq, watched))
            self.meet = compile(*meet(tile, model.meets, method, model.ny, watched))
        self.end = compile(*methods.end(method, tolerances))
        self.judge = compile(*methods.judge(method, tolerances, model.ny, model.controlled, model.motion))
        self.dense, self.inside = compile(*methods.dense(method, ledger.samples)), compile(*methods.inside(method))
        self.checks = compile(*methods.checks(method, model.ny, within, len(ledger.watched)))
        self.curve_checks = compile(*methods.curve_checks(ledger.parts, model.curves))
        self.merged, self.copy_two = compile(*methods.merged(method)), compile(*methods.copied(2))
        self.copy, self.spread = compile(*methods.spread(1)), compile(*methods.spread(1 + model.ny))
        if method.adaptive:
            self.first_try = compile(*methods.first_try(tolerances, model.ny, model.motion, t_end))
            self.first_step = compile(*methods.first_step(method, tolerances, model.ny, model.motion, t_end))
        self.start, self.close = compile(*ledger.start()), compile(*ledger.close())
        short = t_end / SHORT if short is None else short
        stops = Stops(self.stops.tolist(), [float(n) for n in counts], lengths, short)
        self.settle = compile(*settle(ledger, stops, method.adaptive, most_steps, model.meets))
        if ledger.watched:
            self.aside = compile(*results(ledger, method, model.ny, self.later))


def _instants_inside(reductions: Sequence[Reduction], t_end: float) -> set[float]:
    """Instants between start and end that reductions ask for [s].  Raises InputError for one outside."""
    instants = set()
    for reduction in reductions:
        if reduction.kind == "at":
            if not 0.0 <= reduction.t <= t_end:
                raise InputError(f"{reduction}: an instant from 0 to {t_end} s expected")
            instants.add(float(reduction.t))
    return instants - {0.0, float(t_end)}
