"""A recorded model together with one small difference between two of its motions, for lanes.

    du/dt = W f_y W^-1 u,   ds/dt = 0                 the difference W dy = exp(s) u of what moves, weighted
    y <- P(t, y),   u <- W P_y W^-1 u                 after every step: onto the constraints, and then
    u <- u/|u|,   s <- s + ln |u|                     to unit length again

Positions, rates and states have differences, the accounts of energies and impulses have none.  f is the recorded
right-hand side, P the projection; their derivatives are exact.

Source: Benettin, Galgani, Giorgilli, Strelcyn, Lyapunov characteristic exponents for smooth dynamical systems,
Meccanica 15 (1980) 9-20; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section I.14.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rattle.analyses.straight_line.lane_model import ENERGY
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.equations.state import state_layout
from rattle.language.recorded import Operand
from rattle.trace.copying import bind
from rattle.trace.derivative import tangent
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph, Symbol
from rattle.trace.lane_methods import total
from rattle.trace.lane_program import EIGHT, Compile, Model


class VariationalModel:
    """The functions of a model without chosen parameters and of a difference; its state is z = y, E_0, u, s.

    y (ny,) [SI]; E_0: energy from which the balance counts [J]; u (n,): unit difference of positions, rates and states,
    weighted; s: natural logarithm of its size.
    """

    def __init__(self, model: RecordedModel, places: np.ndarray, weight: np.ndarray) -> None:
        """places: (n,) of what may differ in y.  weight: (n,) of each in the size of a difference."""
        self.model, self.places, self.weight = model, places, weight
        self.ny, n = model.state_size, len(weight)
        self.difference, self.logarithm = slice(self.ny + 1, self.ny + 1 + n), self.ny + 1 + n
        energies = [model.curves[f"energy.{key}"] for key in ENERGY]
        parts = [model.derivative, model.projection, [*energies, model.sound_curves]]
        graph, symbols = bind(model.graph, [x for part in parts for x in part], {})
        rate, closed, row = symbols[: self.ny + 1], symbols[self.ny + 1 : 2 * self.ny + 2], symbols[2 * self.ny + 2 :]
        energy = Symbol(graph, graph.inputs[-1])
        u, s = [graph.input() for _ in range(n)], graph.input()
        moved = self._along(graph, closed, u)
        length = graph.apply("sqrt", total([x * x for x in moved]))
        grown = s + graph.apply("log", length)
        self.rate = [*rate[:-1], 0.0, *self._along(graph, rate, u), 0.0, rate[-1]]
        self.projection = [*closed[:-1], energy, *(x / length for x in moved), grown, closed[-1]]
        self.curves, self.graph = row, graph

    def _along(self, graph: Graph, outputs: Sequence[Operand], u: Sequence[Operand]) -> list[Operand]:
        """(n,) what these outputs change by along u, weighted as u is."""
        seeds = {graph.inputs[1 + k]: x / w for k, x, w in zip(self.places, u, self.weight, strict=True)}
        changed = tangent(graph, [outputs[k] for k in self.places], seeds)
        return [x * w for x, w in zip(changed, self.weight, strict=True)]

    @property
    def operations(self) -> int:
        """Number of operations of right-hand side and projection."""
        return self.graph.count([*self.rate, *self.projection])

    def lane_model(self, u: np.ndarray, compile_function: Compile) -> Model:
        """The functions for lanes, to be compiled; the start has the difference u (n,), of any length."""
        graph, exact = lower(self.graph, [*self.rate, *self.projection, *self.curves])
        nz = self.logarithm + 1
        rate, project, row = (
            compile_function(graph, exact[a:b]) for a, b in ((0, nz + 1), (nz + 1, 2 * nz + 2), (2 * nz + 2, None))
        )

        def begin(samples: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            state = np.zeros((1 + nz, EIGHT))
            state[1 : 1 + self.ny] = self.model.start_state[:, None]
            state[1:][self.difference] = u[:, None]
            closed, energies = np.empty((nz + 1, EIGHT)), np.empty((len(self.curves), EIGHT))
            project(state, closed)
            state[1:] = closed[:-1]
            row(state, energies)
            closed[self.ny] = energies[-2]  # the balance counts from here
            closed[self.logarithm] = 0.0
            count = samples.shape[1]
            return closed[:-1, :1].repeat(count, 1), np.zeros((0, count)), np.full(count, closed[-1, 0] == 1.0)

        controlled = (*self.places.tolist(), *range(self.difference.start, self.difference.stop))
        motion = int(state_layout(self.model.system).motion.stop)
        return Model(nz, 0, len(ENERGY), motion, controlled, begin, rate, project, row, (0, 1, 2, 3, 4))
