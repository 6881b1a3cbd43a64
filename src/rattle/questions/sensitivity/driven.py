"""Derivatives of a fully driven motion, position by position.

The projection P of a recorded model solves Phi(q, t, p) = 0 and Phi_q v = nu near a state, so a state on the
constraints is y = P(t, y, p), and dy/dp = (I - P_y)^-1 P_p.

Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), sections 3.6 and 10.4 (direct
differentiation of constraints).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from rattle.analyses.straight_line.linearised import Linearised
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.language.recorded import Operand
from rattle.questions.sensitivity.parameters import Parameters
from rattle.results.result import Result
from rattle.trace.lane_program import Compile


class Driven:
    """Curves of a fully driven model and their derivatives."""

    def __init__(
        self, model: RecordedModel, parameters: Parameters, curves: Mapping[str, Operand], compile_function: Compile
    ) -> None:  # fmt: skip
        self.model, self.parameters = model, parameters
        self.motion = 6 * model.system.body_count
        closed = [*model.projection[: self.motion], model.projection[-1]]
        self._project = Linearised(model.graph, closed, compile_function)
        self._curves = Linearised(model.graph, [*curves.values(), model.sound_curves], compile_function)

    def at(self, t: float, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
        """Curves (nc,), derivatives (nc, k), whether they are sound, at t [s] for positions q and rates v (3 nb,)."""
        n, k, ny = self.motion, len(self.parameters.values), self.model.state_size
        y = np.concatenate([q, v, np.zeros(ny - n)])
        x = np.concatenate([[t], y, self.parameters.inputs, [0.0]])
        along = np.zeros((len(x), n + k))
        along[1 : 1 + n, :n] = np.eye(n)
        along[1 + ny : -1, n:] = self.parameters.along
        closed, slopes = self._project(x, along)
        moved = np.zeros((len(x), k))
        moved[1 : 1 + n] = np.linalg.solve(np.eye(n) - slopes[:-1, :n], slopes[:-1, n:])
        moved[1 + ny : -1] = self.parameters.along
        x[1 : 1 + n] = closed[:-1]
        values, derivatives = self._curves(x, moved)
        return values[:-1], derivatives[:-1], bool(closed[-1] == 1.0 and values[-1] == 1.0)


def positions(result: Result, bodies: Sequence[str], k: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions and rates (3 nb,) [SI] of all bodies at instant k of a result."""
    q = [result[f"{body}.{key}"][k] for body in bodies for key in ("x", "y", "angle")]
    v = [result[f"{body}.{key}"][k] for body in bodies for key in ("vx", "vy", "omega")]
    return np.array(q), np.array(v)
