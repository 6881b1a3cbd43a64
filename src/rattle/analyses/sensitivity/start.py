"""The start of a motion and its derivatives by parameters.

Positions solve q = N(q, p), a step of Newton's method, so dq/dp = (I - N_q)^-1 N_p; rates are functions of them.
"""

from __future__ import annotations

import numpy as np

from rattle.analyses.sensitivity.linearised import Linearised
from rattle.analyses.straight_line.machine_code import MachineFunctions
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.analyses.straight_line.recorded_start import lacking
from rattle.analyses.straight_line.starts import Starts
from rattle.errors import TraceError


class StartDerivatives:
    """The start of a model and its derivatives, compiled once for any values of the parameters."""

    def __init__(self, model: RecordedModel, functions: MachineFunctions) -> None:
        """Raises TraceError, with what [initial] must give, if the start does not follow from the parameters."""
        if model.first is None:
            raise TraceError(
                "no sensitivities: how the start changes with the parameters is not determined by [initial];"
                f" {lacking(model.system, model.start)}"
            )
        self._begin = Starts(model, functions.add)
        self._correct = Linearised(model.graph, model.first.correction, functions.add)
        self._close_rates = Linearised(model.graph, model.first.rates, functions.add)

    def at(self, model: RecordedModel) -> np.ndarray:
        """y and its derivatives at t = 0, (ny, 1 + k) [SI], for the start and the parameters of this model.

        Raises TraceError where assembly had to change what [initial] gives.
        """
        self._begin.model = model
        values = np.array(list(model.parameters.values()))
        begun = self._begin.begin(values[:, None])
        if begun.assembled[0]:
            raise TraceError(
                "no sensitivities: the start is not determined by the values in [initial] alone, assembly had to"
                f" change them; {lacking(model.system, model.start)}"
            )
        y, nq, k = begun.y[:, 0], 3 * model.system.body_count, len(values)
        x = np.concatenate([[0.0], y, values, [0.0]])
        parameters = slice(1 + len(y), 1 + len(y) + k)
        along = np.zeros((len(x), nq + k))
        along[1 : 1 + nq, :nq] = np.eye(nq)
        along[parameters, nq:] = np.eye(k)
        _, found = self._correct(x, along)
        moved = np.zeros((len(x), k))
        moved[1 : 1 + nq] = np.linalg.solve(np.eye(nq) - found[:nq, :nq], found[:nq, nq:])
        moved[parameters] = np.eye(k)
        _, rates = self._close_rates(x, moved)
        z = np.zeros((len(y), 1 + k))
        z[:, 0] = y
        z[:nq, 1:], z[nq : 2 * nq, 1:] = moved[1 : 1 + nq], rates[:nq]
        return z


def start(model: RecordedModel, functions: MachineFunctions) -> np.ndarray:
    """y and its derivatives at t = 0, (ny, 1 + k) [SI]; compiles the functions.  Raises TraceError."""
    derivatives = StartDerivatives(model, functions)
    functions.compile()
    return derivatives.at(model)
