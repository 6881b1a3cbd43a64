"""Derivatives of an equilibrium.

At an equilibrium the accelerations from rest vanish, drivers held where they are, and the joints are closed:

    a(q, p) = 0,  Phi(q, p) = 0      =>      [Z^T a_q; Phi_q] dq/dp = -[Z^T a_p; Phi_p]

Z are the motions that the joints leave, in coordinates in which lengths are shares of the mechanism's size.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rattle.analyses.straight_line.linearised import Linearised
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.equations import motion, schur
from rattle.jit import layout as at
from rattle.jit.functions import KernelFunction
from rattle.language.recorded import Operand
from rattle.questions.sensitivity.parameters import Parameters
from rattle.results.columns import columns, width
from rattle.solvers.output_row import write
from rattle.trace.graph import Symbol
from rattle.trace.lane_program import Compile
from rattle.trace.recording import Recorder, Recording
from rattle.trace.symbol_arrays import Table

NEUTRAL = 1e-10  # share of the forces along the free motions below which they do not depend on these
RANK = 1e-9  # share of the largest singular value below which constraints are dependent


@dataclass(frozen=True)
class Rest:
    """What the kernels do at rest, on the inputs of a recorded model; its y holds the positions."""

    acceleration: list[Operand]  # (3 nb,) [m/s^2, rad/s^2]
    residual: list[Operand]  # (nr,) of the constraint rows [m or rad]
    curves: dict[str, Operand]  # result columns by name [SI]
    sound: Operand  # flag


def record_rest(model: RecordedModel) -> Rest:
    """Record a model at rest, its drivers held where they are at t.  Raises TraceError."""
    system, recorder = model.recorded, Recorder(model.graph)
    recording = Recording(system, recorder)
    places = [Symbol(model.graph, place) for place in model.graph.inputs]
    t, q = places[0], np.array(places[1 : 1 + 3 * system.body_count], dtype=object)
    workspace = recorder.workspace(system)
    row = np.zeros(width(system), dtype=object)

    def rest() -> None:
        def run(function: KernelFunction, *arguments: object) -> None:
            recorder.recorded(function.python)(workspace, *arguments)

        run(motion.drive, t)
        for name in system.model.drivers:
            slot = system.driver_slot(name)
            workspace.values[slot + 1] = workspace.values[slot + 2] = 0.0
        run(motion.place, q, np.zeros(len(q), dtype=object))
        run(motion.constraints)
        run(motion.loads, t)
        run(schur.factorise)
        run(motion.accelerate)
        run(write, 0.0, 0.0, row)

    _, sound = recording.guarded(rest)
    table, titles, _ = recording.plain(columns)(system, Table([[0.0] * len(row), list(row)]))
    curves = dict(zip(titles, (rows[1] for rows in table), strict=True))
    residual = list(workspace.rows[:, at.RES])
    return Rest(list(workspace.acceleration[1:].ravel()), residual, curves, sound)


class AtRest:
    """Curves of a model at rest and their derivatives."""

    def __init__(
        self, model: RecordedModel, parameters: Parameters, rest: Rest, curves: Mapping[str, Operand],
        compile_function: Compile,
    ) -> None:  # fmt: skip
        self.model, self.parameters = model, parameters
        balance = [*rest.acceleration, *rest.residual, rest.sound]
        self._balance = Linearised(model.graph, balance, compile_function)
        self._curves = Linearised(model.graph, [*curves.values(), rest.sound], compile_function)

    def at(self, t: float, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
        """Curves (nc,), derivatives (nc, k), whether they are sound, at an equilibrium q (3 nb,) at t [s], SI units.

        Where the position is free to change (a neutral equilibrium) it has no derivatives: nan.
        """
        n, k, ny = len(q), len(self.parameters.values), self.model.state_size
        x = np.concatenate([[t], q, np.zeros(ny - n), self.parameters.inputs, [0.0]])
        along = np.zeros((len(x), n + k))
        along[1 : 1 + n, :n] = np.eye(n)
        along[1 + ny : -1, n:] = self.parameters.along
        value, slopes = self._balance(x, along)
        size = np.tile([self.model.system.size, self.model.system.size, 1.0], n // 3)
        moved = np.zeros((len(x), k))
        slopes[:n] /= size[:, None]
        moved[1 : 1 + n] = size[:, None] * _solved(slopes[:-1, :n] * size, -slopes[:-1, n:], n)
        moved[1 + ny : -1] = self.parameters.along
        values, derivatives = self._curves(x, moved)
        return values[:-1], derivatives[:-1], bool(value[-1] == 1.0 and values[-1] == 1.0)


def _solved(rows: np.ndarray, right: np.ndarray, n: int) -> np.ndarray:
    """(n, k) solution of rows x = right, of which the first n are accelerations and the others constraints.

    Accelerations count along the motions Z that the constraints leave; nan where they do not determine these.
    """
    if not (np.isfinite(rows).all() and np.isfinite(right).all()):
        return np.full((n, right.shape[1]), np.nan)
    forces, joints = rows[:n], rows[n:]
    length = np.linalg.norm(joints, axis=1)[:, None]
    length[length == 0.0] = 1.0
    _, singular, turned = np.linalg.svd(joints / length)
    rank = int((singular > RANK * singular.max(initial=0.0)).sum())
    x = np.linalg.lstsq(joints / length, right[n:] / length, rcond=RANK)[0]
    free = turned[rank:].T
    if not free.shape[1]:
        return np.asarray(x)
    along = free.T @ forces
    stiffness = along @ free
    if np.linalg.svd(stiffness, compute_uv=False)[-1] <= NEUTRAL * np.linalg.norm(along):
        return np.full((n, right.shape[1]), np.nan)
    return np.asarray(x + free @ np.linalg.solve(stiffness, free.T @ right[:n] - along @ x))
