"""First guesses of positions, the positions at which a mechanism is least open, and why it stays so."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from rattle.analyses.assembly.first_guess import passed_angles, place_positions
from rattle.analyses.assembly.unclosed import why_open, without_value
from rattle.analyses.assembly.vector_loops import VectorLoops
from rattle.equations.closure import place_only
from rattle.equations.dense import LARGE, dense_rows
from rattle.equations.motion import constraints, drive
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace

LONG = 3000  # rows above which no closings are looked for: lists of ways through long chains take the square of it
STARTS = 48  # guesses that are tried for angles that are not given


class Guesses:
    """First guesses (3 nb,): bodies placed by the joints from the ground outwards, then all closings of its loops.

    Angles that are not given are tried where the loops do not determine all.
    """

    def __init__(
        self, system: System, workspace: Workspace, t: float, offsets: dict[str, Any], ideal: np.ndarray | None
    ) -> None:
        """ideal: (3 nb,) positions of the ideal mechanism, if they are known."""
        model = system.model
        drive(workspace, t)
        self.system, self.offsets, self.ideal = system, offsets, ideal
        self.functions = {name: float(workspace.values[system.driver_slot(name)]) for name in model.drivers}
        self.angles, self.free = passed_angles(model, self.functions)  # of bodies [rad]; bodies whose angle is sought
        self.discrete = False  # True: all closings are known that keep the given values
        self.settled = not self.free  # True: no later guess is better than one that keeps all given values

    def __iter__(self) -> Iterator[np.ndarray]:
        system, angles, free, ideal = self.system, self.angles, self.free, self.ideal
        if ideal is not None:  # the ideal mechanism gives the angles that were not given
            rough = {**angles, **{name: float(ideal[3 * system.bodies.index(name) + 2]) for name in free}}
            yield place_positions(system, rough, self.offsets, self.functions)
            # the given angles may be rough: those of the ideal mechanism are right within the clearance
            closed = {name: float(ideal[3 * n + 2]) for n, name in enumerate(system.bodies)}
            yield place_positions(system, {**rough, **closed}, self.offsets, self.functions)
            return
        yield place_positions(system, angles, self.offsets, self.functions)
        if system.row_count > LONG:
            return
        loops = VectorLoops(system, self.functions)
        for q in loops:
            self.settled, self.discrete = not free or not loops.complete, loops.complete
            yield q
        self.discrete = loops.complete
        if not free or loops.complete or system.row_count > LARGE:
            return
        turns = [math.radians(x) for x in (60, -60, 120, -120, 180, 30, -30)]
        tried: Iterator[tuple[float, ...]] = itertools.product(turns, repeat=len(free))
        if len(turns) ** len(free) > STARTS:
            random = np.random.default_rng(0)
            tried = iter([tuple(random.uniform(-math.pi, math.pi, len(free))) for _ in range(STARTS)])
        for turn in itertools.islice(tried, STARTS):
            varied = {**angles, **dict(zip(free, turn, strict=True))}
            yield place_positions(system, varied, self.offsets, self.functions)

    def away(self, q: np.ndarray) -> tuple[float, float]:
        """How far angles that are sought are from 0, squared, without whole turns and with them [rad^2].

        From those of a start near by where there is one.  Rounded, for those that are equal but for rounding.
        """
        sought = [float(q[3 * self.system.bodies.index(name) + 2]) - self.angles[name] for name in self.free]
        every = (sum(math.remainder(angle, math.tau) ** 2 for angle in sought), sum(angle**2 for angle in sought))
        return round(every[0], 9), round(every[1], 9)


def least_open(system: System, workspace: Workspace, t: float, q: np.ndarray) -> None:
    """Minimise |Phi|^2 over q, in place: Levenberg-Marquardt in mass-weighted coordinates, also where rank is lost."""
    scale = np.sqrt(system.arrays["weight"][1:].ravel() / system.arrays["weight"][1:].max())
    damping = 1e-2

    def rows_at(q: np.ndarray) -> np.ndarray:
        place_only(workspace, q)
        constraints(workspace)
        return workspace.rows[:, at.RES].copy()

    drive(workspace, t)
    phi = rows_at(q)
    for _ in range(80):
        jacobian = dense_rows(system, workspace) * scale
        normal = jacobian.T @ jacobian
        gradient = jacobian.T @ phi
        if not np.isfinite(gradient).all() or np.abs(gradient).max() < 1e-14:
            break
        step = -scale * np.linalg.solve(normal + damping * np.trace(normal) / len(q) * np.eye(len(q)), gradient)
        step *= min(1.0, 0.5 / max(np.abs(step[2::3]).max(), 1e-300))
        trial = rows_at(q + step)
        if trial @ trial < phi @ phi:
            small = trial @ trial > (1 - 1e-9) * (phi @ phi)
            q += step
            phi, damping = trial, max(damping / 5, 1e-12)
            if small:
                break
        else:
            damping *= 4
            rows_at(q)
            if damping > 1e8:
                break


def why_open_from(system: System, workspace: Workspace, t: float, q: np.ndarray) -> str:
    """Why the joints cannot be closed from q, in words; q is moved in place to where the residual is least."""
    drive(workspace, t)
    if system.row_count <= LARGE and not without_value(system, workspace, t):
        least_open(system, workspace, t, q)
    place_only(workspace, q)
    constraints(workspace)
    return why_open(system, workspace, t)
