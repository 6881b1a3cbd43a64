"""Pins that are not rigid at rest: those that sink into their bush, and those that float in oil.

Both are started from an equilibrium in which the pin is held: on a massless link that presses, or, in oil, without
play.  A film carries by turning: its pin is where film and dry contact together exert the reaction,

    f(e, w_A, w_B) = F        e' = 0

with the rates that the drivers give the bodies while every such pin stays in its place.  The film is the same in every
direction: the size of e follows from the size of F, and its direction from that of F.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import ideal_system
from rattle.analyses.assembly.rank import RANK
from rattle.equations.dense import dense_rows
from rattle.equations.rest_force import force_at
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.position import Equilibrium
from rattle.questions.equilibrium.starts import opened, same
from rattle.solvers.mobility import film_at, still_force

DEPTHS = (1e-4, 1e-3, 1e-2, 1e-5, 1e-1)  # to which pins are let sink in at first, in clearances
NEAREST = 1e-6  # [of the clearance] film up to which it is halved in the search for a load; then the pin sinks in
FIRST_DEPTH = 1e-9  # [of the clearance] first depth there, which is doubled
PLACE = (1e-16, 1e-14)  # [of the clearance, relative] how near the place of a pin is found: as near as rounding allows
DEEPEST = 1e3  # of the clearance


class Loaded:
    """Pins that sink in or float: the mechanism with them, and without play."""

    def __init__(self, problem: StaticProblem, ideal: StaticProblem) -> None:
        self.problem, self.ideal = problem, ideal
        self._drag: list[tuple[int, float]] = []  # bodies and moments [N*m] of films on them

    def at(self, t: float) -> None:
        """Set the drivers to time t [s]."""
        self.problem.at(t)
        self.ideal.at(t)

    def starts(self, play: StaticProblem, rest: Equilibrium) -> list[np.ndarray]:
        """Positions (3 nb,) [m, m, rad] near an equilibrium of `play` from which to look for that of loaded pins."""
        links = dict(zip(play.links, play.offsets(rest.q), strict=True))
        floating = self._floating(rest)
        sinking = {name: e for name, e in links.items() if name not in self.problem.links}
        kept = {name: e for name, e in links.items() if name in self.problem.links}
        depths = DEPTHS if sinking else DEPTHS[:1]
        ways = [floating | kept | {name: e * (1 + depth) for name, e in sinking.items()} for depth in depths]
        if floating and kept:
            ways.append(ways[0] | self._dragged(rest.q, list(kept)))
        return [opened(self.ideal, rest.q, way) for way in ways]

    def _dragged(self, q: np.ndarray, links: list[str]) -> dict[str, np.ndarray]:
        """Offset (2,) [m] of pins that press, of a mechanism that hardly anything but the drag of films loads."""
        ideal, q = self.ideal, q.copy()
        ideal.close(q)
        ideal.workspace.multiplier[:] = 0.0
        force_at(ideal.workspace, ideal.t, q, ideal.out)
        applied = ideal.out.copy()
        for body, moment in self._drag:
            if body:
                applied[3 * body - 1] += moment
        rows = dense_rows(ideal.system, ideal.workspace) * ideal.scale
        reaction = np.linalg.lstsq(rows.T, applied * ideal.scale, rcond=RANK)[0]
        offsets = {}
        for name in links:
            first = ideal.system.first_row(name)
            lines = ideal.workspace.rows[first : first + 2, at.BX : at.BY + 1]
            force = -lines.T @ reaction[first : first + 2]  # on B
            size = float(np.hypot(*force))
            if size > 0.0:
                offsets[name] = -ideal.system.model.joints[name].clearance / size * force
        return offsets

    def _floating(self, rest: Equilibrium) -> dict[str, np.ndarray]:
        """Offset (2,) [m] of every pin in oil that carries its reaction in an equilibrium without its play."""
        if not self.problem.oiled:
            return {}
        turning = self.problem.turn(rest.q)
        self._drag = []
        offsets = {}
        for name, number, a, b in self.problem.oiled:
            force = np.array([rest[f"{name}.fx"], rest[f"{name}.fy"]])
            offsets[name] = self._place(
                number, self.problem.system.model.joints[name].clearance, force, turning[[a, b]]
            )
            ex, ey = offsets[name].tolist()
            film_at(self.problem.workspace, number, ex, ey, 0.0, 0.0, float(turning[a]), float(turning[b]))
            self._drag += zip((a, b), self.problem.workspace.film_force[2:4].tolist(), strict=True)
        return offsets

    def _place(self, number: int, clearance: float, force: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Offset (2,) [m] at which a film with its dry contact exerts a force (2,) [N] on its pin."""
        from scipy.optimize import brentq

        out, load = np.zeros(2), float(np.hypot(*force))

        def exerted(size: float) -> np.ndarray:
            still_force(self.problem.workspace, number, size, float(rates[0]), float(rates[1]), out)
            return out

        def excess(place: float) -> float:
            return float(np.hypot(*exerted(clearance * place))) - load

        low, high = 0.0, 0.5
        while excess(high) < 0.0 and high < DEEPEST:  # towards the bush, then into it
            low = high
            high = 0.5 * (1.0 + high) if high < 1.0 - NEAREST else 1.0 + 2.0 * max(high - 1.0, FIRST_DEPTH)
        if load == 0.0 or not excess(high) >= 0.0:
            return np.zeros(2)
        size = clearance * float(brentq(excess, low, high, xtol=PLACE[0], rtol=PLACE[1]))
        fx, fy = exerted(size)
        angle = math.atan2(force[1], force[0]) - math.atan2(fy, fx)
        return np.array([size * math.cos(angle), size * math.sin(angle)])


class Pressed(NamedTuple):
    """Equilibria with pins that sink in or float."""

    found: list[Equilibrium]
    work: float
    stopped: bool  # True: cut short
    moving: tuple[str, ...]  # bodies that the drivers move, if films see their rates


def pressed(
    play: StaticProblem,
    system: System,
    held: list[Equilibrium],
    most: float,
    price: Callable[[StaticProblem, int, bool], float],
) -> Pressed:
    """Equilibria with pins that sink in or float, from those in which `play` holds them, the lowest first.

    most: work after which only the first is looked for; price: the work of a search by the positions that it tried and
    whether it found one.
    """
    problem = StaticProblem(system, play.t)
    loaded = Loaded(problem, StaticProblem(ideal_system(system.model), play.t))
    equilibria: list[Equilibrium] = []
    work = 0.0
    moving: dict[str, None] = {}
    for rest in held:
        if equilibria and work >= most:
            return Pressed(equilibria, work, True, tuple(moving))
        for start in loaded.starts(play, rest):
            before = problem.trials
            solution = problem.find(start)
            work += price(problem, problem.trials - before, solution is not None)
            if solution is not None:
                if not equilibria or not same(system, solution[0], np.array([other.q for other in equilibria])):
                    equilibria.append(problem.finish(*solution))
                    moving |= dict.fromkeys(problem.moving)
                break
    return Pressed(equilibria, work, False, tuple(moving))
