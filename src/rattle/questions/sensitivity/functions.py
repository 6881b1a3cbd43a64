"""Functions of a recorded model that sensitivities need, each with its derivatives by state and parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from rattle.analyses.straight_line.linearised import Columns, Linearised, live_without, switching_functions
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.language.recorded import Operand
from rattle.questions.sensitivity.parameters import Parameters
from rattle.trace.known_signs import SHALLOW
from rattle.trace.lane_program import Compile

RESTS = 1e-12  # value [SI] of a switching function that may be rounding, as the rate of what rests
ENERGIES = ("kinetic", "potential", "work", "dissipated")


class Rates(NamedTuple):
    """The right-hand side at one point."""

    values: np.ndarray  # (ny, 1 + k) dy/dt, then dY/dt
    sound: bool  # it stands on sound assumptions
    sides: np.ndarray  # (ns,) on which side of its switch every expression is


class Outputs(NamedTuple):
    """Curves at n instants."""

    values: np.ndarray  # (n, nc)
    slopes: np.ndarray  # (n, nc, k)
    sound: np.ndarray  # (n,) they stand on sound assumptions
    moved: np.ndarray  # (n, bodies, 3) by which positions were off the constraints still [m, m, rad]


class Functions:
    """Functions of one model at the values of its parameters.

    A state with its derivatives is an array z (ny, 1 + k): y, then dy/dp for each of the k parameters.
    """

    def __init__(
        self, model: RecordedModel, parameters: Parameters, curves: Mapping[str, Operand], compile_function: Compile
    ) -> None:  # fmt: skip
        self.model, self.size, self.parameters = model, model.state_size, parameters
        self.energy = 0.0  # at the start [J]
        self.energy_rates = np.zeros(len(parameters.values))  # its derivatives
        graph = model.graph
        margins = switching_functions(graph, model.derivative[:-1])
        self.resting = np.zeros(len(margins), dtype=bool)  # expressions that have no effect at present
        self.of_contact = _of_contacts(model, margins)
        self.resting |= self.of_contact[-1]
        self.still = np.zeros(len(margins), dtype=bool)  # those that rest on a kink
        self._rate = Linearised(graph, [*model.derivative, *(x < 0.0 for x in margins)], compile_function)
        self._margins = Linearised(graph, margins, compile_function) if margins else None
        self._project = Linearised(graph, model.projection, compile_function)
        self._curves = Linearised(graph, [*curves.values(), model.sound_curves], compile_function)
        energies = [*(model.curves[f"energy.{key}"] for key in ENERGIES), model.curves["energy.balance"]]
        self._energies = Linearised(graph, [energies[-1]], compile_function)
        self._energy_values = Columns(graph, energies, compile_function)

    def start_energy(self, z: np.ndarray) -> None:
        """Take the energy at the start, and its derivatives, from the state z there."""
        self.energy, self.energy_rates = 0.0, np.zeros_like(self.energy_rates)
        total, rates = self._energies(*self.at(0.0, z))
        self.energy, self.energy_rates = float(total[0]), rates[0]

    def inputs(self, t: float, y: np.ndarray) -> np.ndarray:
        """(n_in,) inputs of the graph."""
        return np.concatenate([[t], y, self.parameters.inputs, [self.energy]])

    def at(self, t: float, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        parameters = self.parameters.along
        along = np.vstack([np.zeros((1, parameters.shape[1])), z[:, 1:], parameters, self.energy_rates[None]])
        return self.inputs(t, z[:, 0]), along

    def rates(self, t: float, z: np.ndarray) -> Rates:
        """dz/dt."""
        values, along = self._rate(*self.at(t, z))
        n = self.size
        sides = np.where(self.resting | self.still, 0.0, values[n + 1 :])
        return Rates(np.column_stack([values[:n], along[:n]]), values[n] == 1.0, sides)

    def projected(self, t: float, z: np.ndarray) -> tuple[np.ndarray, bool]:
        """z on the constraints, and whether that is sound."""
        values, along = self._project(*self.at(t, z))
        return np.column_stack([values[:-1], along[:-1]]), values[-1] == 1.0

    def curves(self, t: float, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
        """Curves (nc,), their derivatives (nc, k), and whether they are sound."""
        values, along = self._curves(*self.at(t, z))
        return values[:-1], along[:-1], values[-1] == 1.0

    def outputs(self, t: np.ndarray, z: np.ndarray) -> Outputs:
        """What is kept of states z (n, ny, 1 + k) at the instants t (n,) [s]."""
        closed, sound = self._all_projected(t, z)
        values, slopes = self._curves.at_points(*self._points(t, closed))
        sound &= values[:, -1] == 1.0
        again, _ = self._all_projected(t, closed)
        moved = np.abs(again - closed)[:, : 3 * self.model.system.body_count, 0].reshape(len(t), -1, 3)
        return Outputs(values[:, :-1], slopes[:, :-1], sound, moved)

    def outputs_in_time(self, t: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Curves (n, nc) of states z (n, ny, 1 + k), and how they change with parameters and, last, in time."""
        closed, _ = self._all_projected(t, z)
        x, along = self._points(t, closed)
        rates = self._rate.at_points(x, along)[0][:, : self.size]
        in_time = np.zeros((*x.shape, 1))
        in_time[:, 0, 0], in_time[:, 1 : 1 + self.size, 0] = 1.0, rates
        values, slopes = self._curves.at_points(x, np.concatenate([along, in_time], axis=2))
        return values[:, :-1], slopes[:, :-1]

    def _all_projected(self, t: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values, along = self._project.at_points(*self._points(t, z))
        return np.concatenate([values[:, :-1, None], along[:, :-1]], axis=2), values[:, -1] == 1.0

    def _points(self, t: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Inputs (n, n_in) of the graph, and how they change (n, n_in, k)."""
        n, along = len(t), np.vstack([self.parameters.along, self.energy_rates[None]])
        constant = np.append(self.parameters.inputs, self.energy)
        x = np.concatenate([t[:, None], z[:, :, 0], np.tile(constant, (n, 1))], axis=1)
        still = np.zeros((n, 1, along.shape[1]))
        return x, np.concatenate([still, z[:, :, 1:], np.broadcast_to(along, (n, *along.shape))], axis=1)

    def energies(self, t: float, z: np.ndarray) -> np.ndarray:
        """Kinetic and potential energy, work, energy dissipated, balance [J]."""
        return self._energy_values(self.inputs(t, z[:, 0])[:, None])[:, 0]

    def curves_in_time(self, t: float, z: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
        """Curves (nc,), their derivatives (nc, k + 1), the last by time for dy/dt = rate (ny,), and their soundness."""
        values, along = self._curves(*self.directions(t, z, rate))
        return values[:-1], along[:-1], values[-1] == 1.0

    def margins(self, t: float, z: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives (ns, k) of the switching functions, and their time derivatives (ns,) for dy/dt = rate (ny,)."""
        assert self._margins is not None
        _, slopes = self._margins(*self.directions(t, z, rate))
        return slopes[:, :-1], slopes[:, -1]

    def let_rest(self, t: float, z: np.ndarray, some: np.ndarray) -> bool:
        """Leave switching functions (ns,) of these aside that are rounding at t [s] and z; False if there are none."""
        assert self._margins is not None
        values, _ = self._margins(*self.at(t, z))
        self.still[:] = some & (np.abs(values) <= RESTS)
        return bool(self.still.any())

    def directions(self, t: float, z: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Inputs (n_in,), and how they change with each parameter and, last, in time (n_in, k + 1); rate: dy/dt."""
        x, along = self.at(t, z)
        in_time = np.concatenate([[1.0], rate, np.zeros(len(x) - 1 - len(rate))])
        return x, np.column_stack([along, in_time])


def _of_contacts(model: RecordedModel, margins: list[Operand]) -> np.ndarray:
    """(n + 1, ns) which switching functions have an effect only while contact n is shut; last those that have none."""
    flags = [] if model.contacts is None else model.contacts.are.is_shut
    graph, outputs = model.graph, model.derivative[:-1]
    alone = np.zeros((len(flags), len(margins)), dtype=bool)
    for n, flag in enumerate(flags):
        others = {graph.place(x) for x in switching_functions(graph, outputs, live_without(graph, outputs, flag))}
        alone[n] = [graph.place(margin) not in others for margin in margins]
    beyond = set() if model.contacts is None else {graph.place(gap + SHALLOW) for gap in model.contacts.gap}
    return np.vstack([alone, np.array([[graph.place(margin) in beyond for margin in margins]], dtype=bool)])
