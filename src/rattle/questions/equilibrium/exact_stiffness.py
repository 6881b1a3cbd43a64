"""Stiffness and damping at a position at rest, by exact derivatives of the recorded forces.

    K = -d(Q - Phi_q^T lambda)/dq  with lambda fixed,     C = -dQ/dv,     both along the free motions Z

Source: docs/theory.md, section 7; Griewank and Walther, Evaluating Derivatives, 2nd ed. (2008), ch. 3.
"""

from __future__ import annotations

import numpy as np

from rattle.analyses.straight_line.linearised import Linearised, by_numpy, switching_functions
from rattle.analyses.straight_line.recorded_model import require_written_loads
from rattle.equations.motion import drive, loads, place
from rattle.equations.rest_force import force_at
from rattle.errors import TraceError
from rattle.jit.functions import KernelFunction
from rattle.language.recorded import Operand
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.trace.graph import Graph
from rattle.trace.recording import Recorder, Recording

SAME = 1e-9  # share of the largest force by which recorded forces may differ from the kernels': rounding, amplified
MOVED = 1e-3  # displacement at which they are compared, in sizes of the mechanism and rad
BESIDE = 1e-8  # the same to either side of a position at which a switch shows
CLOSER = 1e-3  # of it: derivatives that are continuous differ there by so much less
ROUNDING = 1e-9  # share of the largest by which derivatives may differ


class RestForces:
    """Forces of a mechanism at rest and their derivatives, its drivers and multipliers as in a static problem."""

    def __init__(self, problem: StaticProblem) -> None:
        """Raises TraceError, with the reason, where the forces cannot be recorded."""
        require_written_loads(problem.system)
        self.problem, n = problem, 3 * problem.system.body_count
        graph = Graph()
        recorder = Recorder(graph)
        recording = Recording(problem.system, recorder)
        q, v = (np.array([graph.input() for _ in range(n)], dtype=object) for _ in range(2))
        balance = np.zeros(n, dtype=object)
        workspace = recorder.workspace(problem.system)
        workspace.multiplier[:] = problem.workspace.multiplier

        def run(function: KernelFunction, *operands: object) -> None:
            recorder.recorded(function.python)(workspace, *operands)

        def forces() -> list[Operand]:
            run(drive, problem.t)
            run(force_at, problem.t, q, balance)
            run(place, q, v)
            run(loads, problem.t)
            return [*balance, *workspace.force[1:].ravel()]

        outputs, sound = recording.guarded(forces)
        self.forces = Linearised(graph, [*outputs, sound], by_numpy)
        margins = switching_functions(graph, outputs)
        self.margins = Linearised(graph, margins, by_numpy) if margins else None

    def slopes(self, q: np.ndarray, v: np.ndarray, null: np.ndarray) -> np.ndarray:
        """Z^T K Z [N/m] and Z^T C Z [N*s/m], (2, dof, dof), at q and v (3 nb,), with Z = null (3 nb, dof)."""
        n, dof = null.shape
        along = np.zeros((2 * n, 2 * dof))
        along[:n, :dof] = along[n:, dof:] = null
        value, derivative = self.forces(np.concatenate([q, v]), along)
        reduced = -np.array([null.T @ derivative[:n, :dof], null.T @ derivative[n : 2 * n, dof:]])
        if not (value[-1] == 1.0 and np.isfinite(reduced).all()):
            raise TraceError("a force has no finite derivative at the equilibrium")
        return reduced

    def require_same(self, q: np.ndarray) -> None:
        """Compare the record with the kernels near q (3 nb,).  Raises TraceError where they differ."""
        problem, n, random = self.problem, len(q), np.random.default_rng(0)
        size = MOVED * problem.scale * problem.system.size
        q, v = q + size * random.standard_normal(n), size * random.standard_normal(n)
        want = np.zeros(2 * n)
        force_at(problem.workspace, problem.t, q, want[:n])
        place(problem.workspace, q, v)
        loads(problem.workspace, problem.t)
        want[n:] = problem.workspace.force[1:].ravel()
        got, _ = self.forces(np.concatenate([q, v]), np.zeros((2 * n, 1)))
        if not np.abs(want - got[:-1]).max() <= SAME * np.abs(want).max():
            raise TraceError("the recorded forces differ from the kernels'; this is a fault of rattle")

    def require_smooth(self, q: np.ndarray, null: np.ndarray) -> None:
        """Raise TraceError if stiffness or damping jumps at q (3 nb,), because an expression switches there."""
        if self.margins is None:
            return
        way = null @ np.random.default_rng(0).standard_normal(null.shape[1])
        rest = np.zeros_like(way)
        sides, apart = [], []
        for share in (BESIDE, CLOSER * BESIDE):
            step = share * self.problem.system.size * way
            sides += [
                np.sign(self.margins(np.concatenate(x), np.zeros((2 * len(q), 1)))[0])
                for x in ((q - step, -step), (q, rest), (q + step, step))
            ]
            slopes = np.array([self.slopes(q + s * step, s * step, null) for s in (-1.0, 0.0, 1.0)])
            apart.append(np.ptp(slopes, axis=0).max(axis=(1, 2)))
        largest = np.abs(slopes).max(axis=(0, 2, 3))
        jumps = (apart[1] > 0.5 * apart[0]) & (apart[1] > ROUNDING * largest)
        if np.ptp(np.array(sides), axis=0).any() and jumps.any():
            names = ", ".join(sorted({switch.name for switch in self.problem.system.switches})) or "an expression"
            raise TraceError(f"{names} switches right at the equilibrium, where it has no derivative")


def exact_stiffness(problem: StaticProblem, q: np.ndarray, null: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Z^T K Z [N/m] and Z^T C Z [N*s/m], (dof, dof), at rest at q (3 nb,), with Z = null (3 nb, dof).

    Call `StaticProblem.reduce` first, for the multipliers.
    Raises TraceError, with the reason, where the forces cannot be recorded or have no derivative.
    """
    forces = RestForces(problem)
    forces.require_same(q)
    force_at(problem.workspace, problem.t, q, problem.out)
    forces.require_smooth(q, null)
    stiffness, damping = forces.slopes(q, np.zeros_like(q), null)
    return stiffness, damping
