"""Starts of many samples of a recorded model: by the recorded equations where they hold, else by assembly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import Assembled, assemble, near_places, put_together
from rattle.analyses.assembly.start_constants import constants_of, flat
from rattle.analyses.assembly.start_values import Places
from rattle.analyses.dynamics.run import start_state
from rattle.analyses.model_form import FORM_PAYS, ModelForm
from rattle.analyses.straight_line.recorded_model import RecordedModel, read_at
from rattle.description.model import Model
from rattle.description.read_parameters import with_values
from rattle.description.reader import read
from rattle.equations.system import System
from rattle.errors import AssemblyError, ModelError, TraceError
from rattle.jit import functions
from rattle.language.recorded import Operand
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph
from rattle.trace.lane_chain import Function
from rattle.trace.lane_program import Compile, filled

CLOSED = 1e-11  # share of the mechanism's size by which a start may stay open
MISSED = 1e-8  # share of the largest rate by which a rate that the user gave may be missed
FAR = 0.5  # largest change from the start of the model itself [rad, sizes of the mechanism]; beyond, assembly decides
ROUNDS = 30  # of Newton's method
SETTLED = 1e-12  # the same, up to which positions count as found
SMALL = 1e-14  # its last step [rad, sizes of the mechanism]
OTHER = "with these parameters the model has another form"


class Begun(NamedTuple):
    """Starts of k samples."""

    y: np.ndarray  # (ny, k) states [SI]; nan where there is none
    constants: np.ndarray  # (nc, k) those that the starts set [m or rad]
    messages: dict[int, str]  # by sample: why it cannot be put together
    assembled: np.ndarray  # (k,) True: not by the recorded equations


class Starts:
    """Makes starts of a recorded model."""

    def __init__(self, model: RecordedModel, compile_function: Compile) -> None:
        self.model = model
        self._assembled = 0  # starts
        self._set = len(model.first.constants) - 1 if model.first else 0  # constants; those of contacts are others
        self._readable, *self._first = (compile_function(*lowered) for lowered in _lowered(model))
        ideal = None if model.first is None else model.first.ideal
        self._ideal = [] if ideal is None else [
            compile_function(*lower(model.graph, outputs)) for outputs in (ideal.correction, ideal.rates)
        ]  # fmt: skip

    def begin(self, values: np.ndarray) -> Begun:
        """Starts at values (np, k) of the chosen parameters [SI]."""
        count = values.shape[1]
        y = np.repeat(self.model.start_state[:, None], count, axis=1)
        constants = np.zeros((len(self.model.constants), count))
        good = np.isfinite(values).all(axis=0)
        if self._first:
            good &= self.solve(y, np.where(good, values, 1.0), constants)
        else:
            good[:] = False
        messages: dict[int, str] = {}
        alike = self._alike(values)
        if not good.all():
            functions.start()  # for one of them already: a sample has the same bits however many there are beside it
        for n in np.flatnonzero(~good):
            try:
                system, start = self.assemble(values[:, n])
                if not alike[n]:
                    y[:, n], messages[int(n)] = np.nan, OTHER
                    continue
                y[:, n], own = start_state(system, start), flat(constants_of(system.model))
                constants[: len(own), n] = own
            except (ModelError, AssemblyError) as error:
                y[:, n], messages[int(n)] = np.nan, str(error)
        return Begun(y, constants, messages, ~good)

    def _alike(self, values: np.ndarray) -> np.ndarray:
        """(k,) True where the model has the parts and forms of the recorded one."""
        count = values.shape[1]
        fill = filled(count)
        readable = np.empty((1, len(fill)))
        inputs = np.zeros((len(self.model.graph.inputs), len(fill)))
        first = 1 + self.model.state_size
        inputs[first : first + len(values)] = values[:, fill]
        self._readable(inputs, readable)
        return np.asarray(readable[0, :count] == 1.0)

    def determined(self, values: np.ndarray) -> np.ndarray:
        """(k,) True where the recorded equations give the start at values (np, k) of the chosen parameters [SI]."""
        if not self._first:
            return np.zeros(values.shape[1], dtype=bool)
        return self.solve(np.repeat(self.model.start_state[:, None], values.shape[1], axis=1), values)

    def assemble(self, values: np.ndarray) -> tuple[System, Assembled]:
        """The model with values (np,) of the chosen parameters [SI], assembled.  Raises ModelError, AssemblyError."""
        self._assembled += 1
        form = self._form if self._assembled >= FORM_PAYS else None
        formed = form.at(values.tolist()) if form is not None and np.isfinite(values).all() else None
        if formed is not None:
            system = put_together(formed.model) if formed.system is None else formed.system
        else:
            model = read_at(self.model, dict(zip(self.model.parameters, values.tolist(), strict=True)))
            system = put_together(self._beside(model))
        return system, assemble(system, told=False)

    def _beside(self, model: Model) -> Model:
        """A model whose start is on the branch of the recorded one."""
        near, shut = self._near
        initial = replace(model.initial, near=near, near_shut=shut)
        return replace(model, initial=initial.with_places(self.model.system.model.initial.held))

    @cached_property
    def _near(self) -> tuple[Places, Places]:
        return near_places(self.model.system, self.model.start)

    @cached_property
    def _form(self) -> ModelForm | None:
        """The form of the model, with the chosen parameters as numbers; None if it is not known."""
        document = with_values(self.model.document, self.model.parameters)
        try:
            return ModelForm(document, self._beside(read(document)), list(self.model.parameters))
        except (ModelError, TraceError):
            return None

    def solve(self, y: np.ndarray, values: np.ndarray, constants: np.ndarray | None = None) -> np.ndarray:
        """Positions and rates by the recorded equations, into y (ny, k); (k,) True where they hold.

        constants: (nc, k) to write those into that the start sets.
        """
        system, (correct, close_rates, *count_from) = self.model.system, self._first
        nq, count = 3 * system.body_count, y.shape[1]
        fill = filled(count)
        size = np.tile([system.size, system.size, 1.0], system.body_count)[:, None]
        inputs = np.zeros((len(self.model.graph.inputs), len(fill)))  # t = 0, y, parameters, constants, E_0
        last = 1 + len(y) + len(values)
        inputs[1 : 1 + len(y)], inputs[1 + len(y) : last] = y[:, fill], values[:, fill]
        rates, readable = (np.empty((n, len(fill))) for n in (nq + 2, 1))
        q = inputs[1 : nq + 1]
        with np.errstate(invalid="ignore", over="ignore"):
            good, ideal = self._without_play(inputs, size)
            inputs[1 + nq : 1 + 2 * nq] = ideal[:nq]
            good &= self._closed(correct, inputs, size)
            inputs[1 + nq : 1 + 2 * nq] = ideal[nq:]
            for count_constants in count_from:
                set_ = np.empty((self._set + 1, len(fill)))
                count_constants(inputs, set_)
                inputs[last : last + self._set] = set_[:-1]
                good &= set_[-1] == 1.0
            close_rates(inputs, rates)
            self._readable(inputs, readable)
            missed, sound_rates = rates[nq], rates[nq + 1]
            good &= sound_rates == 1.0
            good &= missed <= MISSED * np.maximum(1.0, np.abs(rates[:nq]).max(axis=0))
            good &= readable[0] == 1.0
        if constants is not None:
            constants[:] = inputs[last:-1, :count]
        y[:nq], y[nq : 2 * nq] = q[:, :count], rates[:nq, :count]
        return good[:count]

    def _without_play(self, inputs: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(k,) True where there is a start without play, or none is needed, and (6 nb, k) its positions and rates.

        size: as in `_closed`.
        """
        ideal, nq = None if self.model.first is None else self.model.first.ideal, len(size)
        if ideal is None:
            return np.ones(inputs.shape[1], dtype=bool), inputs[1 : 1 + 2 * nq].copy()
        correct, close_rates = self._ideal
        beside, rates = inputs.copy(), np.empty((nq + 2, inputs.shape[1]))
        beside[1 : nq + 1] = ideal.places[:, None]
        closed = self._closed(correct, beside, size)
        close_rates(beside, rates)
        sound = closed & (rates[nq] <= MISSED * np.maximum(1.0, np.abs(rates[:nq]).max(axis=0)))
        return sound & (rates[nq + 1] == 1.0), np.concatenate([beside[1 : nq + 1], rates[:nq]])

    def _closed(self, correct: Function, inputs: np.ndarray, size: np.ndarray) -> np.ndarray:
        """Positions closed by Newton's method, into the inputs; True where they are, near where it began.

        size: (3 nb, 1) what steps are compared with [m, m, rad].
        """
        nq = len(size)
        corrected, q = np.empty((nq + 2, inputs.shape[1])), inputs[1 : nq + 1]
        began, left, last = q.copy(), *np.full((2, q.shape[1]), np.inf)
        moving, good = np.ones((2, q.shape[1]), dtype=bool)
        for _ in range(ROUNDS):  # a sample's own steps decide when it ends, so that others do not change it
            correct(inputs, corrected)
            step = np.abs((corrected[:nq] - q) / size).max(axis=0)
            q[:, moving], left[moving], last[moving] = corrected[:nq, moving], corrected[nq, moving], step[moving]
            good[moving] = corrected[nq + 1, moving] == 1.0
            moving &= step > SMALL
            if not moving.any():
                break
        near = np.abs((q - began) / size).max(axis=0) <= FAR
        return np.asarray(good & (left <= CLOSED * self.model.system.size) & (last <= SETTLED) & near)


def _lowered(model: RecordedModel) -> list[tuple[Graph, list[Operand]]]:
    parts: list[Sequence[Operand]] = [[model.readable]]
    if model.first is not None:
        parts += [
            model.first.correction,
            model.first.rates,
            *([model.first.constants] if model.first.constants else []),
        ]
    return [lower(model.graph, outputs) for outputs in parts]
