"""Sensitivities of one mechanism at many values of its parameters: recorded and compiled once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.straight_line.machine_code import MachineFunctions
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.questions.kinematics.compute import analyse
from rattle.questions.sensitivity.compute import Asked
from rattle.questions.sensitivity.contacts import ContactMotion
from rattle.questions.sensitivity.driven import Driven, positions
from rattle.questions.sensitivity.functions import Functions
from rattle.questions.sensitivity.growth import horizon
from rattle.questions.sensitivity.motion import Motion
from rattle.questions.sensitivity.nearby import Nearby
from rattle.questions.sensitivity.of_contacts import require_same_contacts, require_same_start
from rattle.questions.sensitivity.parameters import Parameters
from rattle.questions.sensitivity.start import StartDerivatives
from rattle.questions.sensitivity.touching import Touching
from rattle.trace.elementary import lower


class RepeatedSensitivities:
    """Curves and their derivatives by parameters, along one analysis: simulate, kinematics or inverse-dynamics.

    Raises TraceError, with the reason, where there are no sensitivities; UnknownName.
    """

    def __init__(self, model: RecordedModel, outputs: Sequence[str], analysis: str, rtol: float, atol: float) -> None:
        """model: recorded with the parameters.  rtol, atol: of a motion [m, rad, m/s, rad/s]."""
        self.model, self.analysis, self.rtol, self.atol = model, analysis, rtol, atol
        chosen = _alone(model)
        asked = Asked(model, chosen, tuple(outputs), np.zeros(1), rtol, atol)
        compiled = MachineFunctions()
        self._readable = compiled.add(*lower(model.graph, [model.readable]))
        if analysis == "simulate":
            curves, _ = asked.curves(self.model.curves)
            self._functions = Functions(model, chosen, curves, compiled.add)
            if model.contacts is not None:
                self._touching = Touching(self._functions, model.contacts, compiled.add)
            self._start = StartDerivatives(model, compiled)
        else:
            nominal = analyse(model.system, model.start, np.zeros(1), forces=analysis == "inverse-dynamics")
            curves, _ = asked.curves({name: curve for name, curve in model.curves.items() if name in nominal.stored})
            self._driven = Driven(model, chosen, curves, compiled.add)
            if len(model.constants):
                self._start = StartDerivatives(model, compiled)
        compiled.compile()

    def at(
        self, system: System, start: Assembled, t_eval: np.ndarray, read_off: np.ndarray | None = None
    ) -> Nearby:  # fmt: skip
        """Curves and derivatives [SI] at t_eval (n,) [s], of the model with other values.

        system, start: of that model.  read_off: if given, curves are known all along a motion and on both sides of
        events, and of t_eval at these instants [s], at which no event may be.  Raises TraceError where the derivatives
        do not exist or the run stops.
        """
        values = {name: system.model.parameters[name].value for name in self.model.parameters}
        model = replace(self.model, system=system, start=start, parameters=values)
        self._require_same_parts(model)
        if self.analysis == "simulate":
            return self._along_motion(model, t_eval, read_off)
        return self._along_positions(model, t_eval)

    def _require_same_parts(self, model: RecordedModel) -> None:
        inputs = np.repeat(model.inputs(0.0, model.start_state)[:, None], 8, axis=1)
        flag = np.empty((1, 8))
        self._readable(inputs, flag)
        if flag[0, 0] != 1.0:
            raise TraceError("no sensitivities: with these values the model has other parts")

    def _along_motion(self, model: RecordedModel, t_eval: np.ndarray, read_off: np.ndarray | None) -> Nearby:
        functions = self._functions
        z, functions.parameters = self._start.at(model, _alone(model))
        functions.model = model
        how = t_eval, self.rtol, self.atol
        if model.contacts is None:
            run = Motion(functions, z, *how)
        else:
            require_same_start(model, z[:, 0])
            self._touching.begin()
            run = ContactMotion(functions, self._touching, z, *how)
        run.moments = None if read_off is None else []
        run.go()
        if run.interrupted:
            raise KeyboardInterrupt
        if run.message:
            raise TraceError(run.message)
        if isinstance(run, ContactMotion):
            self._require_contacts(model, run)
        return Nearby.of(run, read_off)

    def _require_contacts(self, model: RecordedModel, run: ContactMotion) -> None:
        """Raise TraceError unless derivatives hold to the end of a motion with contacts."""
        t, sizes = (np.array(row) for row in zip(*run.history, strict=True))
        reach = horizon(t, sizes, self._functions.parameters.values, self.rtol) if len(t) > 1 else run.t
        require_same_contacts(model, run, reach, self.rtol, self.atol)
        if reach < run.t:
            raise TraceError(
                f"a chaotic motion: after t = {reach:.3g} s derivatives say nothing, an ensemble has those of means"
            )
        if run.grazed < run.t:
            raise TraceError(f"a contact only grazes at t = {run.grazed:.6g} s, from there on there are no derivatives")

    def _along_positions(self, model: RecordedModel, t_eval: np.ndarray) -> Nearby:
        nominal = analyse(model.system, model.start, t_eval, forces=False)
        if not nominal.success:
            raise TraceError(nominal.message)
        self._driven.model, self._driven.parameters = model, _alone(model)
        if len(model.constants):
            self._driven.parameters = self._start.at(model, _alone(model))[1]
        bodies = list(model.system.bodies)
        instants = [self._driven.at(float(t), *positions(nominal, bodies, k)) for k, t in enumerate(nominal.t)]
        if not all(instant[2] and np.isfinite(instant[1]).all() for instant in instants):
            raise TraceError("no sensitivities: a position is singular, or a load or expression has no derivative")
        values, slopes = (np.array([instant[part] for instant in instants]) for part in (0, 1))
        return Nearby(nominal.t, np.zeros((len(values), slopes.shape[2])), values, slopes)


def _alone(model: RecordedModel) -> Parameters:
    """The parameters of a model, each of which changes alone, whatever expressions the file has for them."""
    return Parameters.along_directions(model, np.eye(len(model.parameters)))
