"""Models of one form: the same parts with other numbers, without reading the description again.

Reading with recorded numbers (`language.recorded`) says how every number of the model, and of its arrays, follows from
chosen parameters, and which comparisons led to this form.  The operations are written as a Python function with the
functions that reading itself calls, so that its numbers have the same bits.  A form is used only if it gives the very
model that reading gives at several other values; where a comparison goes another way, or an operation fails, it says
nothing, and the model has to be read.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import has_play
from rattle.analyses.assembly.start_constants import constants_of
from rattle.analyses.assembly.without_play import ideal_model
from rattle.description.model import Model
from rattle.description.read_parameters import with_values
from rattle.description.read_values import is_computable
from rattle.description.reader import read
from rattle.equations.system import System, compile_system, length_of
from rattle.errors import ModelError, TraceError
from rattle.language.operations import OPERATIONS
from rattle.language.recorded import Operand, Recorded
from rattle.language.watched import Watch, Watched
from rattle.trace.graph import Graph, both
from rattle.trace.recording import Recorder
from rattle.value_types import Plain, Tree

FORM_PAYS = 3  # models with other numbers of the same parameters from which on a form pays
MOST = 20_000  # operations beyond which a form is not worth its making
TRIED = (1e-7, -1e-7, 1e-4, -1e-4, 0.01, -0.01, 0.1, -0.1)  # changes of all parameters, in shares of them
LEAST_TRIED = 4  # of these, at which the form holds
TEXTS = {  # of exact operations
    "add": "{0} + {1}", "sub": "{0} - {1}", "mul": "{0} * {1}", "div": "{0} / {1}", "neg": "-{0}", "abs": "abs({0})",
    "less": "{0} < {1}", "at_most": "{0} <= {1}", "equal": "{0} == {1}", "both": "{0} and {1}",
    "either": "{0} or {1}", "not": "not {0}", "select": "{1} if {0} else {2}",
}  # fmt: skip
CALLED: dict[str, Plain] = {
    **{record.recorded: record.value.python for record in OPERATIONS.values() if record.recorded},
    "floor": OPERATIONS["floor"].value.python, "copysign": math.copysign,
}  # fmt: skip
FAILURES = (
    ArithmeticError,
    AttributeError,
    TypeError,
    ValueError,
)  # of operations, where the model has another form or none

Plan = Any  # None: nothing follows; a number: place among the numbers that follow; a dictionary: plans of the parts


class Made(NamedTuple):
    """A model of a form."""

    model: Model
    system: System | None  # None where the start sets constants of it, or its arrays are not known to have the form


class ModelForm:
    """What is left of a model when the numbers that follow from chosen parameters are taken out.

    Raises TraceError where there is nothing that can be vouched for.
    """

    def __init__(self, document: Tree, model: Model, names: Sequence[str]) -> None:
        """document: of which `model` was read, but for `initial.near`; names: parameters that are numbers in it."""
        self._model, self._names = model, tuple(names)
        graph = Graph()
        recorder, watch = Recorder(graph), Watch()
        follow: list[Operand] = []  # symbols of the numbers that follow
        try:
            recorded = beside(read_watched(document, names, recorder, watch), model)
            self._plan = plan_of(recorded, model, follow)
            self._system, self._shut = None, None
            if not constants_of(model):
                self._system = _SystemForm.of(recorded, model, follow, watch)
                if has_play(model):
                    self._shut = _SystemForm.of(ideal_model(recorded), ideal_model(model), follow, watch)
            self._numbers = _function(graph, [both(graph, recorder.assumed.values()), *follow])
        except (ModelError, *FAILURES) as error:
            raise TraceError(f"numbers of the model cannot be recorded: {error}") from error
        self._check(document)

    def at(self, values: Sequence[float]) -> Made | None:
        """The model with these values [SI] of the parameters; None where it has, or may have, another form."""
        try:
            holds, *numbers = self._numbers(*values)
        except FAILURES:
            return None
        if not holds or not all(x == 0.0 or is_computable(x) for x in numbers):
            return None
        model: Model = _filled(self._model, self._plan, numbers)
        if self._system is None:
            return Made(model, None)
        every = np.array(numbers)
        system = self._system.at(model, every)
        if self._shut is not None:
            same = not self._shut.arrays and _only_play(self._plan)
            system.__dict__["shut"] = self._shut.base if same else self._shut.at(ideal_model(model), every)
        return Made(model, system)

    def _check(self, document: Tree) -> None:
        """Raise TraceError where the form differs from what reading gives; where arrays do, they are left out."""
        own = [self._model.parameters[name].value for name in self._names]
        tried = 0
        for share in (0.0, *TRIED):
            values = [x + share * (x or 1.0) / (1.0 + 0.1 * n) for n, x in enumerate(own)]
            formed = self.at(values)
            if formed is None:
                continue
            wanted = _read_at(document, dict(zip(self._names, values, strict=True)), self._model)
            if wanted is None or not alike(formed.model, wanted):
                raise TraceError("numbers of the model follow from parameters in a way that is not recorded")
            if formed.system is not None and not _alike_systems(formed.system, compile_system(wanted)):
                self._system = None
            shut = formed.system.__dict__.get("shut") if formed.system is not None else None
            if shut is not None and not _alike_systems(shut, compile_system(ideal_model(wanted))):
                self._shut = None
            tried += 1
        if tried <= LEAST_TRIED:
            raise TraceError("the form of the model changes with its parameters")


def read_watched(document: Tree, names: Sequence[str], recorder: Recorder, watch: Watch) -> Model:
    """The model with parameters that are watched: each is a new input of the graph, in this order.

    Raises TraceError where a value is taken without its record; ModelError.
    """

    def watched(value: float, symbol: Operand) -> Any:
        return Watched(value, symbol, recorder, watch)

    inputs = [recorder.graph.input() for _ in names]
    model = read(document, chosen={x: functools.partial(watched, symbol=y) for x, y in zip(names, inputs, strict=True)})
    watch.require_record()
    return model


def recorded_places(system: System) -> dict[str, tuple[np.ndarray, list[Operand]]]:
    """Where numbers that follow stand in the arrays of a system, as flat indices, and their symbols."""
    recorded = {}
    for name, array in system.arrays.items():
        flat = array.ravel()
        where = [k for k, entry in enumerate(flat) if isinstance(entry, Recorded)] if array.dtype == object else []
        if where:
            recorded[name] = np.array(where), [flat[k].symbol for k in where]
    return recorded


def _read_at(document: Tree, values: Mapping[str, float], like: Model) -> Model | None:
    """The model as it is read with other values; None where it cannot be read."""
    try:
        model = read(with_values(document, values))
    except ModelError:
        return None
    return beside(model, like)


def beside(model: Model, other: Model) -> Model:
    """A model whose start is looked for where that of another one is."""
    initial = dataclasses.replace(model.initial, near=other.initial.near, near_shut=other.initial.near_shut)
    return dataclasses.replace(model, initial=initial.with_places(other.initial.held))


# ---------------------------------------------------------------- which numbers follow
def plan_of(recorded: Any, plain: Any, follow: list[Operand]) -> Plan:
    """Where numbers that follow stand in something that was read; their symbols are appended to `follow`.

    plain: the same, read without recording.  Raises TraceError where the two differ in other things.
    """
    if isinstance(recorded, Recorded):
        follow.append(recorded.symbol)
        return len(follow) - 1
    parts: dict[Any, tuple[Operand, Operand]] = {}
    if isinstance(recorded, Mapping):
        if list(recorded) != list(plain):
            raise TraceError("reading again gives other parts")
        parts = {key: (part, plain[key]) for key, part in recorded.items()}
    elif isinstance(recorded, tuple | list):
        if len(recorded) != len(plain):
            raise TraceError("reading again gives other parts")
        parts = dict(enumerate(zip(recorded, plain, strict=True)))
    elif dataclasses.is_dataclass(recorded):
        keys = [field.name for field in dataclasses.fields(recorded)]
        parts = {key: (getattr(recorded, key), getattr(plain, key)) for key in keys}
    elif not alike(recorded, plain):
        raise TraceError("reading again gives other parts")
    plans = {key: plan for key, (part, other) in parts.items() if (plan := plan_of(part, other, follow)) is not None}
    return plans or None


class _SystemForm(NamedTuple):
    """Arrays of which some numbers follow from parameters."""

    base: System
    size: int  # which number is the length of the mechanism, -1 where none follows
    arrays: Mapping[str, tuple[np.ndarray, np.ndarray]]  # where such numbers stand in an array, and which they are

    @classmethod
    def of(cls, recorded: Model, model: Model, follow: list[Operand], watch: Watch) -> _SystemForm | None:
        """The form of the system of a model; None where a value is taken without its record.

        Symbols of the numbers that follow are appended to `follow`.
        """
        arrays, first, length, size = {}, len(follow), length_of(recorded), -1
        for name, (where, symbols) in recorded_places(compile_system(recorded, length)).items():
            arrays[name] = where, np.arange(len(follow), len(follow) + len(where))
            follow += symbols
        if watch.lost:
            watch.lost.clear()
            del follow[first:]
            return None
        if isinstance(length, Recorded):
            size = len(follow)
            follow.append(length.symbol)
        return cls(compile_system(model), size, arrays)

    def at(self, model: Model, numbers: np.ndarray) -> System:
        """The system of a model of this form."""
        changed = {}
        for name, (flat, places) in self.arrays.items():
            array = changed[name] = self.base.arrays[name].copy()
            array.ravel()[flat] = numbers[places]
        return self.base.with_numbers(model, changed, float(numbers[self.size]) if self.size >= 0 else self.base.size)


def _only_play(plan: Plan) -> bool:
    """True if no number of the mechanism without play follows."""
    joints = plan.get("joints") or {}
    of_play = {"clearance", "contact", "dimensions", "stop", "wear"}
    return plan.keys() <= {"parameters", "constants", "joints"} and all(
        joint.keys() <= of_play for joint in joints.values()
    )


def _filled(plain: Any, plan: Plan, numbers: Sequence[float]) -> Any:
    """The same with other numbers; what holds none of them is shared."""
    if isinstance(plan, int):
        return numbers[plan]
    if isinstance(plain, Mapping):
        return {**plain, **{key: _filled(plain[key], part, numbers) for key, part in plan.items()}}
    if isinstance(plain, tuple):
        parts = list(plain)
        for k, part in plan.items():
            parts[k] = _filled(parts[k], part, numbers)
        return type(plain)._make(parts) if hasattr(plain, "_make") else tuple(parts)
    if not hasattr(plain, "__dict__"):
        return dataclasses.replace(
            plain, **{key: _filled(getattr(plain, key), part, numbers) for key, part in plan.items()}
        )
    copy = object.__new__(type(plain))
    attributes = vars(plain)
    copy.__dict__.update(attributes)
    for key, part in plan.items():
        copy.__dict__[key] = _filled(attributes[key], part, numbers)
    return copy


def _function(graph: Graph, outputs: Sequence[Operand]) -> Plain:
    """A Python function of the inputs of a graph that returns these outputs.  Raises TraceError."""
    live = graph.live(outputs)
    if len(live) > MOST:
        raise TraceError(f"its {len(live)} operations are more than the {MOST} up to which a form pays")
    rank = {place: n for n, place in enumerate(graph.inputs)}
    names = {place: f"p{rank[place]}" if place in rank else f"x{place}" for place in live}
    space: dict[str, Any] = {f"f_{name}": function for name, function in CALLED.items()}
    lines = [f"def numbers({', '.join(f'p{n}' for n in range(len(graph.inputs)))}):"]
    for place in live:
        op = graph.ops[place]
        operands = [names[k] for k in graph.operands[place]]
        if place in graph.numbers:
            space[names[place]] = graph.numbers[place]
        elif op in TEXTS:
            lines.append(f" {names[place]} = {TEXTS[op].format(*operands)}")
        elif op in CALLED:
            lines.append(f" {names[place]} = f_{op}({', '.join(operands)})")
        elif op != "input":
            raise TraceError(f"the operation {op} has no form in Python")
    lines.append(f" return ({''.join(f'{names[graph.place(output)]}, ' for output in outputs)})")
    exec("\n".join(lines), space)  # of names and operations of a graph alone
    function: Plain = space["numbers"]
    return function


# ---------------------------------------------------------------- whether two are the same
def alike(first: Any, other: Any) -> bool:
    """Whether two things that were read say the same: numbers with the same bits, expressions with the same trees."""
    if first is other:
        return True
    if isinstance(first, float | int) and isinstance(other, float | int):
        return bool(_same(first, other))
    if type(first) is not type(other):
        return False
    if isinstance(first, np.ndarray):
        return first.shape == other.shape and bool(np.all(_same(first, other)))
    if isinstance(first, Mapping):
        return list(first) == list(other) and all(alike(first[key], other[key]) for key in first)
    if isinstance(first, tuple | list):
        return len(first) == len(other) and all(map(alike, first, other))
    if dataclasses.is_dataclass(first):
        return all(alike(getattr(first, x.name), getattr(other, x.name)) for x in dataclasses.fields(first))
    return bool(first == other)


def _same(first: Any, other: Any) -> Any:
    """Whether two numbers, or the numbers of two arrays, are equal or both nan."""
    return (first == other) | ((first != first) & (other != other))


def _alike_systems(first: System, other: System) -> bool:
    """Whether two systems are the same, and new workspaces of them begin with the same numbers."""
    same = all(
        alike(getattr(first, x.name), getattr(other, x.name)) for x in dataclasses.fields(System) if x.name != "model"
    )
    return same and alike(first.plain_workspace()._block, other.plain_workspace()._block)
