"""Parameters that leave the start of a mechanism as it is, where only its assembly knows that of others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rattle.analyses.assembly.start_constants import constants_of
from rattle.analyses.straight_line.code import with_parameters
from rattle.analyses.straight_line.recorded_model import RecordedModel, record_model
from rattle.analyses.straight_line.starts import Starts
from rattle.description.model import Parameter
from rattle.errors import AssemblyError, ModelError, TraceError
from rattle.mechanism import Mechanism
from rattle.trace.graph import Graph

TRIED = (-0.3, -0.07, 0.01, 0.11, 0.4)  # changes of a parameter at which something is looked at, in shares of it
SAME = 1e-13  # size of the mechanism (per second), by which starts that count as the same may differ
NEARLY = 1e-9  # share of its largest number by which a recorded start may differ from that of the assembly
FOLLOWS = "it follows from"  # begin of the reason why a parameter is none that can be changed


def tried_values(one: Parameter) -> list[float]:
    """Values of a parameter at which something is looked at [SI]: some around its own, and its limits."""
    found = [one.value + change * (one.value or 1.0) for change in TRIED]
    return found + [x for x in (one.minimum, one.maximum) if x is not None]


def with_the_same_start(
    m: Mechanism, model: RecordedModel, constants: Mapping[str, str]
) -> tuple[RecordedModel, Mapping[str, str]]:
    """The model, recorded without parameters, with those that do not change its start; the others and why not.

    constants: all parameters, and why the start could not be recorded with them.
    """
    if constants_of(model.system.model):  # they follow from the start, and the page does not know how
        return model, constants
    known = model.system.model.parameters
    asked = [name for name, why in constants.items() if not why.startswith(FOLLOWS)]
    kept = [name for name in asked if all(_starts_alike(m, model, name, x) for x in tried_values(known[name]))]
    if not kept:
        return model, constants
    try:
        made = record_model(model.document, model.system, model.start, kept)
    except TraceError:
        return model, constants
    return made, {name: why for name, why in constants.items() if name not in kept}


def with_the_ideal_start(
    m: Mechanism, model: RecordedModel, constants: Mapping[str, str]
) -> tuple[RecordedModel, Mapping[str, str], bool]:
    """The model with parameters, where rates follow from those of the mechanism without play; True if they do."""
    made, others = with_parameters(m.recorded(), beside_ideal=True)
    if not made.parameters or not all(_starts_so(m, made, name) for name in made.parameters):
        return model, constants, False
    return made, others, True


def _starts_so(m: Mechanism, made: RecordedModel, name: str) -> bool:
    """Whether the recorded start is that of the assembly, at a few values of a parameter."""

    def evaluated(graph: Graph, outputs: Sequence[Any]) -> Callable[[np.ndarray, np.ndarray], None]:
        return lambda given, found: np.copyto(found, graph.evaluate(outputs, given))

    starts, nq = Starts(made, evaluated), 3 * made.system.body_count
    for x in tried_values(made.system.model.parameters[name])[1:4]:
        try:
            other = m.set(**{name: x})
            want, ideal = other.start, other.ideal().start
        except (ModelError, AssemblyError):
            continue
        y = made.start_state[:, None].copy()
        y[nq : 2 * nq, 0] = ideal.v
        values = np.array(list({**made.parameters, name: x}.values()))[:, None]
        if not starts.solve(y, values)[0]:
            continue  # the page says so
        near = np.concatenate([want.q, want.v])
        if not np.abs(y[: 2 * nq, 0] - near).max() <= NEARLY * max(1.0, np.abs(near).max()):
            return False
    return True


def _starts_alike(m: Mechanism, model: RecordedModel, name: str, value: float) -> bool:
    """Whether the start is the same with another value of a parameter, or there is none."""
    try:
        other = m.set(**{name: value}).start
    except (ModelError, AssemblyError):
        return True  # the page refuses what the model does
    near = model.system.size * SAME
    return bool(np.abs(other.q - model.start.q).max() <= near and np.abs(other.v - model.start.v).max() <= near)
