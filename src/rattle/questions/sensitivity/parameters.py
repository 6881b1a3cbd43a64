"""Parameters by which derivatives are taken, and what follows them."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.description.reader import read
from rattle.language.recorded import Recorded
from rattle.trace.derivative import tangent
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph
from rattle.trace.recording import Recorder


class Parameters(NamedTuple):
    """The chosen parameters of a recorded model, k of them."""

    names: tuple[str, ...]
    values: np.ndarray  # (k,) [SI]
    directions: np.ndarray  # (k, k) how all of them change with each one: columns; 1 on the diagonal
    constants: np.ndarray  # (nc,) that the start sets [m or rad]
    constant_rates: np.ndarray  # (nc, k) how these change; zero until `sensitivity.start` has found it

    @property
    def inputs(self) -> np.ndarray:
        """(k + nc,) inputs of the graph after t and y [SI]."""
        return np.concatenate([self.values, self.constants])

    @property
    def along(self) -> np.ndarray:
        """(k + nc, k) how these change."""
        return np.vstack([self.directions, self.constant_rates])

    @classmethod
    def of(cls, model: RecordedModel) -> Parameters:
        """The parameters of a model.  One that is an expression over another follows it, as it does in `set`."""
        names = tuple(model.parameters)
        return cls.along_directions(model, np.column_stack([_followers(model, name) for name in names]))

    @classmethod
    def along_directions(cls, model: RecordedModel, directions: np.ndarray) -> Parameters:
        """The parameters of a model that change as told (k, k)."""
        values = np.array(list(model.parameters.values()))
        constants = model.constants
        return cls(tuple(model.parameters), values, directions, constants, np.zeros((len(constants), len(values))))


def _followers(model: RecordedModel, name: str) -> np.ndarray:
    """(k,) derivatives of all chosen parameters by one of them."""
    graph = Graph()
    varied = graph.input()
    changed = read(model.document, chosen={name: functools.partial(Recorder(graph).number, symbol=varied)})
    values = [changed.parameters[other].value for other in model.parameters]
    symbols = [value.symbol if isinstance(value, Recorded) else 0.0 for value in values]
    exact, slopes = lower(graph, tangent(graph, symbols, {varied.place: 1.0}))
    return exact.evaluate(slopes, np.array([[model.parameters[name]]]))[:, 0]
