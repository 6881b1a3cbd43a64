"""Derivatives of an equilibrium.

At an equilibrium the accelerations from rest vanish, drivers held where they are, and the joints are closed:

    a(q, p) = 0,  Phi(q, p) = 0      =>      [a_q; Phi_q] dq/dp = -[a_p; Phi_p]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rattle.analyses.sensitivity.linearised import Linearised
from rattle.analyses.sensitivity.parameters import Parameters
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.equations import motion, schur
from rattle.jit import layout as at
from rattle.results.columns import columns, width
from rattle.solvers.output_row import write
from rattle.trace.graph import Symbol
from rattle.trace.lane_program import Compile
from rattle.trace.recording import Recorder, Recording, Table

NEUTRAL = 1e-10  # share of the largest singular value below which a position is not determined


@dataclass(frozen=True)
class Rest:
    """What the kernels do at rest, on the inputs of a recorded model; its y holds the positions."""

    acceleration: list[Any]  # (3 nb,) [m/s^2, rad/s^2]
    residual: list[Any]  # (nr,) of the constraint rows [m or rad]
    curves: dict[str, Any]  # result columns by name [SI]
    sound: Any  # flag


def record_rest(model: RecordedModel) -> Rest:
    """Record a model at rest, its drivers held where they are at t.  Raises TraceError."""
    system, recorder = model.recorded, Recorder(model.graph)
    recording = Recording(system, recorder)
    places = [Symbol(model.graph, place) for place in model.graph.inputs]
    t, q = places[0], np.array(places[1 : 1 + 3 * system.body_count], dtype=object)
    workspace = recorder.workspace(system)
    row = np.zeros(width(system), dtype=object)

    def rest() -> None:
        def run(function: Any, *arguments: Any) -> None:
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
    curves = dict(zip(titles, (one[1] for one in table), strict=True))
    residual = list(workspace.rows[:, at.RES])
    return Rest(list(workspace.acceleration[1:].ravel()), residual, curves, sound)


class AtRest:
    """Curves of a model at rest and their derivatives."""

    def __init__(
        self, model: RecordedModel, parameters: Parameters, rest: Rest, curves: Mapping[str, Any],
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
        x = np.concatenate([[t], q, np.zeros(ny - n), self.parameters.values, [0.0]])
        along = np.zeros((len(x), n + k))
        along[1 : 1 + n, :n] = np.eye(n)
        along[1 + ny : 1 + ny + k, n:] = self.parameters.directions
        value, found = self._balance(x, along)
        size = np.tile([self.model.system.size, self.model.system.size, 1.0], n // 3)
        moved = np.zeros((len(x), k))
        moved[1 : 1 + n] = size[:, None] * _solved(found[:-1, :n] * size, -found[:-1, n:], n)
        moved[1 + ny : 1 + ny + k] = self.parameters.directions
        values, derivatives = self._curves(x, moved)
        return values[:-1], derivatives[:-1], bool(value[-1] == 1.0 and values[-1] == 1.0)


def _solved(left: np.ndarray, right: np.ndarray, n: int) -> np.ndarray:
    """(n, k) solution of left x = right, of which the first n rows are accelerations; nan if it is not unique."""
    scale = np.abs(left).max(axis=1, initial=0.0)
    scale[:n] = scale[:n].max()
    scale[scale == 0.0] = 1.0
    left, right = left / scale[:, None], right / scale[:, None]
    if not np.isfinite(left).all():
        return np.full((n, right.shape[1]), np.nan)
    singular = np.linalg.svd(left, compute_uv=False)
    if singular[-1] <= NEUTRAL * singular[0]:
        return np.full((n, right.shape[1]), np.nan)
    return np.linalg.lstsq(left, right, rcond=None)[0]
