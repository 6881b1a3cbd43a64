"""What turns the end of a compiled run into a result: names, units and numbers as data, columns as recorded functions.

The columns that `results.columns` computes are recorded from that very code, so pages hold no second set of formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, islice
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.dynamics import horizon, soundness
from rattle.analyses.dynamics.events import KINDS
from rattle.analyses.dynamics.peak_values import peak_names
from rattle.analyses.model_form import FAILURES, beside, read_watched
from rattle.analyses.straight_line.derived_curves import derived_curve, derived_names
from rattle.description.model import Point
from rattle.description.read_parameters import chosen_parameters
from rattle.elements.film_table import read_ratios
from rattle.elements.long_film import long_peaks
from rattle.elements.short_film import short_peaks
from rattle.equations import complementarity, motion, unilateral
from rattle.equations.state import IMPULSE, LOSS, state_layout
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import layout as at
from rattle.jit.functions import KernelFunction
from rattle.language.recorded import Operand, Recorded, symbol_of
from rattle.language.watched import Watch
from rattle.mechanism import Mechanism
from rattle.pages.run_image import planned_run
from rattle.pages.tape import PARAMETER, Tape
from rattle.pages.trust_data import facts, trust_data
from rattle.results.columns import columns, quantities, reaction_columns, states_of, width
from rattle.results.film_columns import film_columns, of_law
from rattle.solvers.contacts.penetration import ESCAPED
from rattle.solvers.peaks import samples
from rattle.solvers.state_switches import SLIDES
from rattle.solvers.step_audit import UNSOUND
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph, Symbol
from rattle.trace.recording import Recorder
from rattle.trace.symbol_arrays import Column, Table, arrays

WORDS = {  # why a run ends before its end, by status; `rattle run` tells more
    motion.NOT_FINITE: "a load, driver or signal has no finite value, or the motion diverges",
    motion.STEP_TOO_SMALL: "no step is short enough: a singular position, friction that locks, or a load without a"
    " finite value",
    ESCAPED: "a contact is inside its wall",
    UNSOUND: "the loops do not close, or the energy error is above its limit",
    SLIDES: "an expression switches to and fro without end",
    unilateral.NO_SOLUTION: "the forces of the contacts have no solution",
    unilateral.NOT_UNIQUE: "the forces of the contacts are not unique",
    unilateral.LOCKED: "friction locks a contact",
    unilateral.CHATTER: "contacts change without end",
    unilateral.NOT_FOUND: "the forces of the contacts were not found",
}
STATUSES = {  # and constants by which what has happened is told
    "ESCAPED": ESCAPED, "SLIDES": SLIDES, "NOT_FINITE": motion.NOT_FINITE, "STEP_TOO_SMALL": motion.STEP_TOO_SMALL,
    "JAMMED": complementarity.JAMMED,
    "OFF": complementarity.OFF, "MU": at.MU,
    **{name: getattr(unilateral, name) for name in ("NO_SOLUTION", "NOT_UNIQUE", "LOCKED", "CHATTER", "NOT_FOUND")},
}  # fmt: skip
CALLS = (short_peaks, long_peaks, read_ratios)  # what symbols cannot follow: kernels of the engine, by their names
ENDINGS = ("tables", "before", "columns", "facts", "belts")  # functions that `result_data` writes


class ResultData(NamedTuple):
    """What `viewer/core_result.js` needs besides a run."""

    data: dict[str, Any]
    functions: dict[str, int]  # numbers on the tape of `ENDINGS`


def result_data(
    m: Mechanism, tape: Tape, t_end: float | None = None, names: Sequence[str] | None = None, derived: bool = False
) -> ResultData:  # fmt: skip
    """Names, numbers and functions on a tape with which the end of a run of a mechanism becomes a result.

    t_end: of its runs [s].  names: of the parameters, by default those of `chosen_parameters`.  derived: also curves
    that results derive, which pages derive themselves: points of bodies, forces and coordinates of joints.
    Raises TraceError where a value is taken without its record.
    """
    system, names = m.system, chosen_parameters(m._document) if names is None else names
    try:
        record = _record(m, names, derived)
    except FAILURES as error:
        raise TraceError(f"the columns cannot be recorded: {error}") from error
    counts = {"row": width(system), "energy": at.ENERGIES, "call": len(record.calls)}
    keys = [(PARAMETER, name) for name in names] + [(kind, k) for kind, n in counts.items() for k in range(n)]
    functions = {name: tape.add(record.graph, record.outputs[name], keys) for name in ENDINGS}
    titles, model, layout = list(record.units), system.model, state_layout(system)
    run = planned_run(m, t_end)
    moving = [name for name in titles if name not in model.recorded and record.units[name] in horizon.MOTION]
    return ResultData(
        {
            "names": titles, "units": record.units, "places": record.places, "parameters": list(names),
            "values": [model.parameters[name].value for name in names], "calls": record.calls,
            "width": width(system), "energies": width(system) - at.ENERGIES, "peaks": _peaks(system),
            "words": {name: dict(words) for name, joint in model.joints.items() if (words := joint.leaf.events)},
            "contacts": len(system.arrays["contact"]), "first_account": layout.account(0).start,
            "account": {"size": layout.account(0).stop - layout.account(0).start, "IMPULSE": IMPULSE, "LOSS": LOSS},
            "rows": [[row.owner, row.unit] for row in system.rows], "watched": list(system.watched),
            "reactions": [titles[k] for k in np.flatnonzero(reaction_columns(system, record.units))],
            "extent": float(system.extent), "size": float(system.size), "notes": list(m.start.notes),
            "signals": list(model.recorded), "moving": moving, "bodies": system.body_count,
            "own_states": [layout.own_states.start, layout.own_states.stop], "states": states_of(system).start,
            "facts": record.facts, "belts": record.belts, "told": trust_data(run, model.settings.method), **ALIKE,
        },
        functions,
    )  # fmt: skip


HORIZON = ("AGREE", "STILL", "NOISE", "MOST_NOISE", "SHAKEN", "LIKE")
NEEDED = {  # columns of arrays of a run that become parts of a result
    "clock": ("T", "H", "FEWEST", "TROUBLE", "H_MIN"),
    "tally": ("DRIFT_ROW", "CONTACTS", "LEAPS", "SERIES", "LOST_ROWS"),
    "course": ("EXTENT", "JAMS", "FIRST_JAM", "MAY_PASS"),
    "held": ("LOCK_SHARE", "LOCK_AT", "LOCK_CONTACT", "OUTCOME"),
    "driver_jump": ("JUMP_AT", "JUMP_IMPULSE", "JUMP_WORK", "JUMP_SIZE", "JUMP_DRIVER"),
    "driver_leap": ("LEAP_COUNT", "LEAP_AT", "LEAP_SIZE"),
    "dry_memory": ("DRY_UNSURE", "DRY_LOCKS"),
    "contact": ("OWNER", "IMPACT", "LEVEL", "NORMAL_P", "FORCE_COLUMN", "JOINT_NORMAL"),
    "contact_kinematics": ("GAP", "DGAP"),
    "lever": ("GAP_SCALE", "GAP_SIZE", "ANGULAR"),
    "stuck": ("EVENT_WHO", "EVENTS_IN_A_ROW"),
    "audit": (
        *("MOST_KINETIC", "MOST_WORK", "MOST_POTENTIAL", "LEAST_POTENTIAL", "FLOOR", "MOST_UNREST", "OPEN_LENGTH"),
        *("OPEN_ANGLE", "OPENNESS", "OPEN_ROW", "UNREST", "UNREST_LIMIT", "CORRECTION", "SUNK"),
    ),
    "contact_memory": ("CLOSED", "SHUT", "SINCE", "SPEED", "PEAK", "IMPULSE_0", "LOSS_0", "UNSURE", "LEFT_END", "OPEN"),
    "timed": ("OWN_CODE", "RESOLVED", "FIRST_FOUND"),
    "switchings": ("SIDE_AFTER",),
    "passage": ("PASSED", "PASSED_AT", "PASSED_FROM", "PASSED_UNTIL", "NEARBY", "CLOSEST_ROOT", "NEAR_SINCE"),
}
ALIKE = {  # for every model
    "sample": {key: getattr(samples, key) for key in ("BEST", "WHEN", "SQUARES")},
    "kinds": KINDS,
    "limit": soundness.LIMIT,
    "unsound": UNSOUND,
    "loose": soundness.LOOSE,
    "words_of_end": WORDS,
    "statuses": STATUSES,
    "horizon": {key: getattr(horizon, key) for key in HORIZON},
    "at": {array: {name: getattr(at, name) for name in wanted} for array, wanted in NEEDED.items()},
}


def _peaks(system: System) -> dict[str, Any]:
    """Names of the rows of `peaks`, and what else has which of these values."""
    plain = {name for name, *_ in quantities(system)}
    also = {name: f"{name.removesuffix('.normal')}.force" for name in peak_names(system) - plain}
    return {"names": [name for name, *_ in quantities(system)], "same": also}


class _Record(NamedTuple):
    """The columns of one raw row as a graph of exact operations.

    Its inputs are the parameters [SI], the row, the energies of the first row [J], then what each call returns.
    """

    graph: Graph
    outputs: dict[str, list[Any]]
    places: list[int]  # of every column: its place in the row, or -1 - place among the outputs `columns`
    units: dict[str, str]
    calls: list[dict[str, Any]]  # kernel, and how many coefficients it reads
    facts: list[list[str | int]]  # where in the data of trust the outputs `facts` stand
    belts: list[dict[str, Any]]  # that may slip


def _record(m: Mechanism, names: Sequence[str], further: bool) -> _Record:
    system, graph = m.system, Graph()
    recorder, watch, calls = Recorder(graph), Watch(), _Calls(graph)
    model = beside(read_watched(m._document, names, recorder, watch), system.model) if names else system.model
    row = [graph.input() for _ in range(width(system))]
    first = [0.0] * (width(system) - at.ENERGIES) + [graph.input() for _ in range(at.ENERGIES)]
    for kernel in CALLS:
        recorder.replace(kernel, calls.of(kernel))
    recorder.replace(of_law, lambda method, *arguments: recorder.recorded(method.__func__)(method.__self__, *arguments))
    recorder.recorded(film_columns)
    recorded = replace(system, model=model)
    table, titles, units = recorder.recorded(columns)(recorded, Table([first, row]))
    curves = {name: values[-1] for name, values in zip(titles, table, strict=True)}
    units = dict(units)
    for name, curve, unit in list(_further(graph, recorded, curves)) if further else ():
        curves[name], units[name] = curve, unit
    watch.require_record()
    places, derived = _in_row(row, curves.values())
    sizes, belts = dict(facts(model, system.watched)), _belts(recorded, recorder, row)
    exact, outputs = _lowered(graph, {
        "tables": [*chain.from_iterable(call.table for call in calls.made)],
        "before": [*chain.from_iterable(call.between for call in calls.made)],
        "columns": derived,
        "facts": [symbol_of(size) for size in sizes.values()],
        "belts": [*chain.from_iterable(belt.holds for belt in belts)],
    })  # fmt: skip
    return _Record(
        exact, outputs, places, units, [{"kernel": call.kernel, "table": len(call.table)} for call in calls.made],
        [list(place) for place in sizes], [belt._asdict() | {"holds": len(belt.holds)} for belt in belts],
    )  # fmt: skip


def _further(graph: Graph, recorded: System, stored: Mapping[str, Operand]) -> Iterator[tuple[str, Any, str]]:
    """Names, symbols and SI units of the curves that results derive from stored ones."""
    for name in derived_names(recorded.model, stored):
        if (curve := derived_curve(graph, recorded, stored, name)) is not None:
            yield name, *curve


def _in_row(row: Sequence[Symbol], curves: Iterable[Any]) -> tuple[list[int], list[Any]]:
    """Places of curves in a row, or -1 - place among those that follow from it; these."""
    rank, derived, places = {symbol.place: k for k, symbol in enumerate(row)}, list[Any](), list[int]()
    for curve in curves:
        place = rank.get(curve.place) if isinstance(curve, Symbol) else None
        if place is None:
            derived.append(curve)
        places.append(-len(derived) if place is None else place)
    return places, derived


class _Belt(NamedTuple):
    """A belt that may slip."""

    joint: str
    columns: list[str]  # of its tight and its slack strand
    source: str  # of its coefficient of friction
    holds: list[Any]  # symbols: the ratio of both that friction holds, the angle of wrap [rad], its coefficient


def _lowered(graph: Graph, parts: Mapping[str, Sequence[Any]]) -> tuple[Graph, dict[str, list[Any]]]:
    """The graph of these values as pages compute it, and the places of the values there."""
    exact, lowered = lower(graph, [x for values in parts.values() for x in values])
    rest = iter(lowered)
    return exact, {name: list(islice(rest, len(values))) for name, values in parts.items()}


def _belts(system: System, recorder: Recorder, row: Sequence[Symbol]) -> list[_Belt]:
    """All belts that may slip, for an output row, see `analyses.grip`."""
    belts, numpy = [], arrays(recorder.graph)

    def place(end: Point) -> list[Any]:
        if end.body == "ground":
            return [Column([symbol_of(x)]) for x in end.at]
        first = at.PER_BODY * system.bodies.index(end.body) + at.PLACE
        x, y, angle = (Column([symbol]) for symbol in row[first : first + 3])
        cos, sin = numpy.cos(angle), numpy.sin(angle)
        px, py = (symbol_of(x) for x in end.at)
        return [x + cos * px - sin * py, y + sin * px + cos * py]

    for name, joint in system.model.joints.items():
        if joint.one_sided is None or not joint.one_sided.records:
            continue
        (ax, ay), (bx, by) = place(joint.a), place(joint.b)
        fields = {key: _in_columns(value) for key, value in joint.fields.items()}
        grip = recorder.recorded(joint.leaf.grip)(fields, numpy.hypot(bx - ax, by - ay))
        if grip is not None:
            columns_ = [f"{name}.{key}" for key in joint.one_sided.records]
            belts.append(_Belt(name, columns_, grip.source, [grip.ratio[0], grip.wrap[0], _first(grip.mu)]))
    return belts


def _in_columns(value: object) -> Any:
    """A field of a joint with columns of one symbol in place of recorded numbers."""
    if isinstance(value, tuple | list):
        return [_in_columns(inner) for inner in value]
    return Column([value.symbol]) if isinstance(value, Recorded) else value


def _first(value: Any) -> Any:
    return value[0] if isinstance(value, Column) else symbol_of(value)


class _Call(NamedTuple):
    kernel: str
    between: list[Any]  # two symbols
    table: list[Any]  # coefficients


class _Calls:
    """Calls of kernels over arrays: each becomes an input more."""

    def __init__(self, graph: Graph) -> None:
        self.graph, self.made = graph, list[_Call]()

    def of(self, kernel: KernelFunction) -> Callable[..., None]:
        """What is recorded in place of a kernel (first, second, coefficients or none, what it fills)."""

        def call(first: Column, second: Column, *rest: Any) -> None:
            *table, filled = rest
            coefficients = [symbol_of(x) for coefficient in table for x in coefficient]
            self.made.append(_Call(kernel.python.__name__, [first[-1], second[-1]], coefficients))
            filled[-1] = self.graph.input()

        return call
