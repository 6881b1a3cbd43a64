"""The start of a motion and its derivatives by parameters.

Positions solve q = N(q, p), a step of Newton's method, so dq/dp = (I - N_q)^-1 N_p; rates are functions of them.
"""

from __future__ import annotations

import numpy as np

from rattle.analyses.straight_line.linearised import Linearised
from rattle.analyses.straight_line.machine_code import MachineFunctions
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.analyses.straight_line.start_kept import lacking
from rattle.analyses.straight_line.starts import Starts
from rattle.errors import TraceError
from rattle.questions.sensitivity.parameters import Parameters

ALL = "give positions and rates of all bodies, so that they fit together"
NUDGE = 1e-6  # change of a parameter, as a share, at which the start must still be the one that [initial] gives


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
        self._constants = None
        if model.first.constants:
            self._constants = Linearised(model.graph, model.first.constants, functions.add)

    def at(self, model: RecordedModel, chosen: Parameters) -> tuple[np.ndarray, Parameters]:
        """y and its derivatives at t = 0, (ny, 1 + k) [SI], for the start and the parameters of this model.

        Also these parameters, with the derivatives of the constants that the start sets.

        Raises TraceError where assembly had to change what [initial] gives.
        """
        self._begin.model = model
        begun = self._begin.begin(chosen.values[:, None])
        if begun.assembled[0]:
            raise TraceError(
                "no sensitivities: the start is not determined by the values in [initial] alone, assembly had to"
                f" change them; {lacking(model.system, model.start) or ALL}"
            )
        _require_kept(self._begin, chosen)
        y, nq, k = begun.y[:, 0], 3 * model.system.body_count, len(chosen.values)
        chosen = chosen._replace(constants=begun.constants[:, 0])
        x = np.concatenate([[0.0], y, chosen.inputs, [0.0]])
        parameters = slice(1 + len(y), 1 + len(y) + k)
        along = np.zeros((len(x), nq + k))
        along[1 : 1 + nq, :nq] = np.eye(nq)
        along[parameters, nq:] = chosen.directions
        _, slopes = self._correct(x, along)
        moved = np.zeros((len(x), k))
        moved[1 : 1 + nq] = np.linalg.solve(np.eye(nq) - slopes[:nq, :nq], slopes[:nq, nq:])
        moved[parameters] = chosen.directions
        if self._constants is not None:
            _, counted = self._constants(x, moved)
            changing = chosen.constant_rates.copy()  # of contacts there are others, which do not change
            changing[: len(counted) - 1] = counted[:-1]
            chosen = chosen._replace(constant_rates=changing)
            moved[parameters.stop : -1] = changing
        _, rates = self._close_rates(x, moved)
        z = np.zeros((len(y), 1 + k))
        z[:, 0] = y
        z[:nq, 1:], z[nq : 2 * nq, 1:] = moved[1 : 1 + nq], rates[:nq]
        return z, chosen


def start(model: RecordedModel, chosen: Parameters, functions: MachineFunctions) -> tuple[np.ndarray, Parameters]:
    """As `StartDerivatives.at`; compiles the functions.  Raises TraceError."""
    derivatives = StartDerivatives(model, functions)
    functions.compile()
    return derivatives.at(model, chosen)


def counted(model: RecordedModel, chosen: Parameters) -> Parameters:
    """The parameters with the derivatives of the constants that the start sets, if it sets any.  Raises TraceError."""
    return start(model, chosen, MachineFunctions())[1] if len(model.constants) else chosen


def _require_kept(begin: Starts, chosen: Parameters) -> None:
    """Raise TraceError for parameters without which the values in [initial] contradict each other."""
    size = np.where(chosen.values != 0.0, np.abs(chosen.values), 1.0)
    change = NUDGE * chosen.directions * size
    kept = begin.determined(chosen.values[:, None] + np.hstack([-change, change])).reshape(2, -1)
    lost = [name for n, name in enumerate(chosen.names) if not kept[:, n].any()]
    if lost:
        raise TraceError(
            f"no sensitivities to {', '.join(lost)}: changed alone, the values in [initial] can no longer all be kept,"
            " and what assembly does then has no derivative; give fewer of them, or write them and other parameters"
            f" as expressions of {'it' if len(lost) == 1 else 'these'}, so that they fit"
        )
