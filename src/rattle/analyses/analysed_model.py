"""A model with the analyses of one run: motion, kinematics, equilibrium, vibrations, accuracy, sensitivities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

from rattle.description.written_model import WrittenModel
from rattle.errors import ModelError, TraceError
from rattle.value_types import Tree

if TYPE_CHECKING:
    from rattle.analyses.assembly.assembly import Assembled
    from rattle.analyses.model_form import ModelForm
    from rattle.analyses.straight_line.recorded_model import RecordedModel
    from rattle.equations.system import System


class AnalysedModel(WrittenModel):
    """A model that can be analysed; every analysis checks it first and raises ModelError with all problems at once."""

    @cached_property
    def system(self) -> System:
        """The model as flat arrays, in SI units, with the constants of gears that its start sets.

        Raises ModelError; AssemblyError if such a mechanism cannot be put together.
        """
        from rattle.analyses.assembly.assembly import put_together
        from rattle.analyses.assembly.computable import computable

        model = self.model
        with computable(self._file):
            return put_together(model)

    @cached_property
    def start(self) -> Assembled:
        """Assembled positions [m, rad] and rates [m/s, rad/s] at t = 0. Raises ModelError, AssemblyError."""
        from rattle.analyses.assembly.assembly import assemble
        from rattle.analyses.assembly.computable import computable

        system = self.system
        with computable(self._file):
            return assemble(system, told=self._told)

    def neighbour(self, values: Tree, told: bool = True) -> Self:
        """As `set`, but what is not given of the start is looked for near the start of this mechanism.

        So samples of one study start on one branch, and none of them a turn away.  told: False for a mechanism that is
        run once: its start has no notes, and its results do not hold the model.  Raises ModelError.
        """
        beside = self._beside_its_start
        neighbour = beside._of_its_form(values, told) or beside.set(values)
        neighbour._told = told
        return neighbour

    def near(self, places: Mapping[str, tuple[float, float, float]]) -> Self:
        """This mechanism, which is put together near these places of its bodies, (x, y, angle) [m, m, rad]."""
        mechanism = self._changed({})
        mechanism._near = mechanism._near_shut = dict(places)
        return mechanism

    def _of_its_form(self, values: Mapping[str, Any], told: bool) -> Self | None:
        """As `neighbour` for numbers of parameters, without reading; None where the model has to be read.

        The form of the model is found when the same parameters are given for the third time.
        """
        from rattle.analyses.model_form import FORM_PAYS

        if not values or not all(isinstance(value, float) and math.isfinite(value) for value in values.values()):
            return None
        names = tuple(values)
        form, asked = self._forms.get(names, (None, 0))
        if asked < FORM_PAYS:
            if asked + 1 == FORM_PAYS:
                form = self._form(names)
            self._forms[names] = form, asked + 1
        if form is None or (formed := form.at(list(values.values()))) is None:
            return None
        mechanism = self._changed(values, shared=not told)
        mechanism.__dict__["model"] = formed.model
        if formed.system is not None:
            mechanism.__dict__["system"] = formed.system
        return mechanism

    @cached_property
    def _forms(self) -> dict[tuple[str, ...], tuple[ModelForm | None, int]]:
        """Forms by the names of their parameters, None where there is none, and how often they were asked for."""
        return {}

    def _form(self, names: Sequence[str]) -> ModelForm | None:
        """What is left of this model without the numbers that follow from these parameters; None if that is unknown."""
        from rattle.analyses.model_form import ModelForm

        parameters = self.parameters
        if not set(names) <= parameters.keys():
            return None
        try:
            mechanism = self.set({name: parameters[name] for name in names})
            return ModelForm(mechanism._document, mechanism.model, names)
        except (TraceError, ModelError):
            return None

    @cached_property
    def _beside_its_start(self) -> Self:
        """This mechanism, so that those that `set` makes of it start near its start; itself if it has none."""
        start = self._start_or_none()
        if start is None:
            return self
        from rattle.analyses.assembly.assembly import near_places

        mechanism = self.set()
        mechanism._near, mechanism._near_shut = near_places(self.system, start)
        mechanism._held = self.system.model.initial.held
        return mechanism

    def recorded(
        self,
        parameters: Sequence[str] = (),
        *,
        contacts: bool = False,
        lanes: bool = True,
        beside: float = 0.0,
        crowded: bool = False,
    ) -> RecordedModel:
        """The model as a graph whose inputs are time, state and these parameters; contacts: with them, for lanes or,
        if not lanes, for derivatives; beside: nearer to singular positions, crowded: with more contacts at once, see
        `trace.recording.Recorder`.

        Raises TraceError, with the reason, if it has contacts or cannot be recorded; UnknownName.
        """
        from rattle.analyses.straight_line.recorded_model import record_model

        return record_model(
            self._document,
            self.system,
            self.start,
            parameters,
            contacts=contacts,
            lanes=contacts and lanes,
            as_alone=lanes,
            beside=beside,
            crowded=crowded,
        )

    # ------------------------------------------------------------ analyses

    def _start_or_none(self) -> Assembled | None:
        """The start at t = 0, or None if the mechanism cannot be assembled there."""
        from rattle.errors import AssemblyError
        from rattle.jit import functions

        functions.start()
        try:
            return self.start
        except AssemblyError:
            return None
