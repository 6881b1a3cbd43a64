"""Derivatives of numbers that are made of whole curves: maxima, means, times between two contacts."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress

import numpy as np

from rattle.analyses.straight_line.derived_curves import derived_units
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.description.reader import read as read_model
from rattle.errors import InputError, TraceError
from rattle.language.syntax import names
from rattle.questions.sensitivity.nearby import Nearby
from rattle.results.build import NOTHING_DRAWN
from rattle.results.columns import geometry
from rattle.results.evaluation import evaluate
from rattle.results.event import Event
from rattle.results.reductions import HARDEST, Known, Output, argument, meetings, needed_instants, read
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.value_types import Tree

STEP = 1e-6  # change of a parameter by which a number of its curves is differenced, as a share
FEWEST = 400  # intervals between the instants of a run


def numbers_in(model: RecordedModel, outputs: Sequence[str], of_contacts: Collection[str]) -> dict[str, Output]:
    """Outputs that are numbers of a whole run.  Raises InputError, ModelError."""
    texts = [text for text in outputs if "(" in text and text not in of_contacts]
    if not texts:
        return {}
    described = model.recorded.model
    units = {**derived_units(described, model.curves), **model.units}
    parameters = {name: parameter.unit for name, parameter in model.system.model.parameters.items()}
    known = Known(units, parameters, meetings(geometry(model.system.model)))
    numbers = {text: read(text, known) for text in texts}
    for text, output in numbers.items():
        kinds = {reduction.kind for reduction in output.reductions}
        if "count" in kinds:
            raise InputError(f"{text!r}: a number of contacts has no derivative: it jumps")
        if HARDEST in kinds or output.ideal_names:
            what = "impulses" if HARDEST in kinds else "the mechanism without play"
            raise InputError(f"{text!r}: there are no derivatives of {what}; compare two runs with set()")
    return numbers


def curves_of(numbers: Mapping[str, Output]) -> list[str]:
    """Names of the curves that numbers are made of."""
    return sorted({name for output in numbers.values() for name in output.names})


def read_off(numbers: Mapping[str, Output], parameters: Mapping[str, float]) -> np.ndarray:
    """Instants [s] that numbers read off, in order."""
    return np.unique([t for output in numbers.values() for t in needed_instants(output, parameters)])


def instants(times: np.ndarray, kept: np.ndarray, begin: float) -> np.ndarray:
    """Instants [s] of a run from `begin` whose numbers are asked for: those asked for, those read off, and between."""
    if len(kept) and not (begin <= kept[0] and kept[-1] <= times[-1]):
        outside = kept[0] if kept[0] < begin else kept[-1]
        raise InputError(f"the instant {outside:g} s is not between {begin:g} and {times[-1]:g} s")
    return np.union1d(np.union1d(times, kept), np.linspace(begin, times[-1], FEWEST + 1))


def number_slopes(
    numbers: Mapping[str, Output], model: RecordedModel, curves: Sequence[str], nearby: Nearby
) -> dict[str, tuple[float, np.ndarray]]:
    """Value and derivatives (k,) of every number; curves: names of the columns of `nearby`."""
    shown = geometry(model.system.model)
    values = {name: parameter.value for name, parameter in model.system.model.parameters.items()}

    def at(k: int, change: float, parameters: Mapping[str, float]) -> np.ndarray:
        result = moved_result(curves, shown, *nearby.moved(k, change))
        return np.array([evaluate(output, result, parameters) for output in numbers.values()])

    here, columns = at(0, 0.0, values), []
    used = {name for output in numbers.values() for name in parameters_of(output)} & values.keys()
    read = instants_of(numbers.values(), values)
    for k, name in enumerate(model.parameters):
        h = STEP * (abs(values[name]) or 1.0)
        changed = _parameters(model, name, h)
        if all(changed[other] == values[other] for other in used):  # it acts by the curves alone
            h = max(h, STEP * nearby.scale(k))
        h = min(h, nearby.reach(k))
        h *= nearby.passes_none(read, instants_of(numbers.values(), _parameters(model, name, h)))
        beside = {0: here}
        for n in (1, -1, 2, -2):
            with suppress(InputError):  # an instant that moves out of the run
                beside[n] = at(k, n * h, _parameters(model, name, n * h))
        columns.append(difference(beside, h))
    slopes = np.array(columns).T
    return {text: (float(here[n]), slopes[n]) for n, text in enumerate(numbers)}


def parameters_of(output: Output) -> set[str]:
    """Names that an output uses, of parameters and curves."""
    nodes = [output.outer, *(reduction.inner for reduction in output.reductions)]
    nodes += [reduction.argument for reduction in output.reductions if reduction.argument is not None]
    return {name for node in nodes for name in names(node)}


def instants_of(outputs: Iterable[Output], parameters: Mapping[str, float]) -> np.ndarray:
    """Instants [s] of all `at` in outputs, one after the other; parameters: values [SI]."""
    every = [reduction for output in outputs for reduction in output.reductions if reduction.kind == "at"]
    return np.array([argument(reduction, parameters) for reduction in every])


def difference(values: Mapping[int, np.ndarray], h: float) -> np.ndarray:
    """Derivative from values at multiples of h, which hold that at 0.  Raises TraceError."""
    if 1 in values and -1 in values:
        return np.asarray((values[1] - values[-1]) / (2.0 * h))
    for side in (1, -1):
        if side in values:
            if 2 * side in values:
                return np.asarray(side * (4.0 * values[side] - values[2 * side] - 3.0 * values[0]) / (2.0 * h))
            return np.asarray(side * (values[side] - values[0]) / h)
    raise TraceError("an instant is outside of the run whatever a parameter does")


def _parameters(model: RecordedModel, name: str, change: float) -> dict[str, float]:
    """Values [SI] of all parameters where one has changed, and with it those that are written with it."""
    changed = read_model(model.document, chosen={name: lambda value: value + change})
    return {other: parameter.value for other, parameter in changed.parameters.items()}


def moved_result(
    names: Sequence[str], shown: Tree, t: np.ndarray, data: np.ndarray, events: Sequence[Event] = ()
) -> Result:
    """Curves as a result; shown: geometry of a result, of which its joints are kept."""
    return Result(
        t=t, data=data, names=names, units=dict.fromkeys(names, ""), trust=Trust(drift=0.0), stats={}, provenance={},
        geometry={**NOTHING_DRAWN, "joints": shown["joints"]}, events=events,
    )  # fmt: skip
