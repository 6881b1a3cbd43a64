"""The arrays of a model as a recorded function of its parameters.

A run computes with arrays of numbers.  Reading the model with watched numbers says how each of their entries follows
from the parameters that may be chosen, in exact operations, so that a page can enter other values without reading.
Whatever takes a value without its record is noticed.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rattle.analyses.assembly.start_constants import constants_of, flat, with_constants
from rattle.analyses.model_form import FAILURES, beside, plan_of, read_watched, recorded_places
from rattle.description.model import Model
from rattle.description.read_parameters import chosen_parameters
from rattle.description.read_values import LARGEST
from rattle.equations.system import System, compile_system, length_of
from rattle.errors import TraceError
from rattle.language.recorded import Operand, Recorded, symbol_of
from rattle.language.watched import Watch, Watched
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph, both
from rattle.trace.recording import Recorder
from rattle.value_types import Tree


@dataclass(frozen=True)
class RecordedArrays:
    """Entries of arrays that follow from parameters; see `entries` for what the outputs of the graph are.

    Inputs of the graph are the parameters, then the constants that the start sets [m or rad].
    """

    names: tuple[str, ...]  # parameters
    graph: Graph  # of exact operations
    entries: dict[str, np.ndarray]  # by array of a workspace: flat indices of the entries that follow
    facts: tuple[str, ...]  # numbers beside the arrays that follow: size, extent [m], settings of a run
    outputs: list[Operand]  # entries, array after array, then facts
    holds: Operand  # flag: with these inputs the model has the same form

    @property
    def operations(self) -> int:
        """Number of operations."""
        return self.graph.count([self.holds, *self.outputs])

    def inputs(self, system: System) -> np.ndarray:
        """(n_in,) inputs [SI] with which the arrays are those of a system."""
        parameters = system.model.parameters
        return np.array([*(parameters[name].value for name in self.names), *flat(constants_of(system.model))])

    def at(self, inputs: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, float]] | None:
        """Values [SI] of the entries by array, and of the facts, for inputs (n_in,); None for another form."""
        holds, *values = self.graph.evaluate([self.holds, *self.outputs], inputs[:, None])[:, 0]
        if not holds:
            return None
        numbers, first, arrays = np.array(values), 0, {}
        for name, where in self.entries.items():
            arrays[name] = numbers[first : first + len(where)]
            first += len(where)
        return arrays, dict(zip(self.facts, numbers[first:].tolist(), strict=True))


Values = Mapping[str, Mapping[int, Operand]]  # of arrays by name: numbers by flat index, recorded ones among them


def recorded_arrays(
    document: Tree, system: System, names: Sequence[str] | None = None, *,
    form: Callable[[Model], Model] | None = None, more: Callable[[System], Values] | None = None,
) -> RecordedArrays:  # fmt: skip
    """Record how the arrays of a system follow from parameters (default: all that do not follow from others).

    document: the tables of the model file, of which the system was made.  form: what was made of its model first.
    more: values of further arrays, from the system with recorded numbers; those that follow become the last entries.
    Raises TraceError, with the place, where a value is taken without its record; ModelError.
    """
    asked = tuple(chosen_parameters(document) if names is None else names)
    graph = Graph()
    recorder, watch = Recorder(graph), Watch()
    numbers: list[Operand] = []  # symbols of the numbers of the model that follow
    try:
        read = read_watched(document, asked, recorder, watch)
        model = beside(read if form is None else form(read), system.model)
        model = with_constants(model, dict(_counting(system.model, recorder, watch)))
        plan_of(model, system.model, numbers)
        recorded = compile_system(model, length_of(model))
        watch.require_record()
        facts = dict(_facts(recorded))
        further = more(recorded) if more is not None else {}
        watch.require_record()
    except FAILURES as error:
        raise TraceError(f"the arrays cannot be recorded: {error}") from error
    _require_alike(recorded, system)
    places = recorded_places(recorded) | dict(_following({**_own_states(recorded), **further}))
    follow = [x for _, symbols in places.values() for x in symbols] + list(facts.values())
    sound = [abs(x) <= LARGEST for x in (*numbers, *follow)]
    flag = both(graph, [*recorder.assumed.values(), *sound])
    exact, (holds, *outputs) = lower(graph, [flag, *follow])
    return RecordedArrays(
        asked, exact, {name: where for name, (where, _) in places.items()}, tuple(facts), outputs, holds,
    )  # fmt: skip


def _counting(model: Model, recorder: Recorder, watch: Watch) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """Constants that the start sets, by joint, as new inputs."""
    for name, values in constants_of(model).items():
        yield name, tuple(Watched(value, recorder.graph.input(), recorder, watch) for value in values)


def _facts(recorded: System) -> Iterator[tuple[str, Operand]]:
    """Symbols of numbers beside the arrays that follow."""
    settings = recorded.model.settings
    held = {field.name: getattr(settings, field.name) for field in dataclasses.fields(settings)}
    for name, value in {"size": recorded.size, "extent": recorded.extent, **held}.items():
        if isinstance(value, Recorded):
            yield name, symbol_of(value)


def _own_states(recorded: System) -> Values:
    """Where the start of the states of a model stands in the arrays of a workspace."""
    starts = [state.start for state in recorded.model.states.values()]
    first = recorded.element_states - len(starts)
    return {"signals": dict(enumerate(starts)), "element_state": dict(enumerate(starts, first))}


def _following(values: Values) -> Iterator[tuple[str, tuple[np.ndarray, list[Operand]]]]:
    """Flat indices and symbols of those that follow, by array."""
    for name, numbers in values.items():
        where = [k for k, value in numbers.items() if isinstance(value, Recorded)]
        if where:
            yield name, (np.array(where, dtype=int), [symbol_of(numbers[k]) for k in where])


def _require_alike(recorded: System, system: System) -> None:
    """Raise TraceError unless the recorded arrays are those of the system, to the bit."""
    for name, array in system.arrays.items():
        copy = recorded.arrays[name]
        if copy.dtype == object:
            copy = np.array([getattr(x, "bare", x) for x in copy.ravel()], dtype=float).reshape(copy.shape)
        if not np.array_equal(copy, array, equal_nan=array.dtype == float):
            raise TraceError(f"the array '{name}' differs when it is recorded; this is a fault of rattle")
