"""What turns the end of a compiled run into a result: names, units and numbers as data, columns as recorded functions.

The columns that `results.columns` computes are recorded from that very code, so pages hold no second set of formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.dynamics import horizon, soundness
from rattle.analyses.dynamics.events import KINDS
from rattle.analyses.dynamics.peak_values import peak_names
from rattle.analyses.model_form import FAILURES, beside, read_watched
from rattle.analyses.timetable import timetable
from rattle.description.read_parameters import chosen_parameters
from rattle.elements.film_table import read_ratios
from rattle.elements.long_film import long_peaks
from rattle.elements.short_film import short_peaks
from rattle.equations import motion, unilateral
from rattle.equations.state import IMPULSE, LOSS, state_layout
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import layout as at
from rattle.jit.functions import KernelFunction
from rattle.language.recorded import symbol_of
from rattle.language.watched import Watch
from rattle.mechanism import Mechanism
from rattle.pages.tape import PARAMETER, Tape
from rattle.results.columns import columns, quantities, reaction_columns, states_of, width
from rattle.results.film_columns import film_columns, of_law
from rattle.solvers.contacts.penetration import ESCAPED
from rattle.solvers.peaks import samples
from rattle.solvers.state_switches import SLIDES
from rattle.solvers.step_audit import UNSOUND
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph, Symbol
from rattle.trace.recording import Recorder
from rattle.trace.symbol_arrays import Column, Table

WORDS = {  # why a run ends before its end, by status; `rattle run` tells more
    motion.NOT_FINITE: "a load, driver or signal has no finite value, or the motion diverges",
    motion.STEP_TOO_SMALL: "no step is short enough: a singular position, or a load without a finite value",
    ESCAPED: "a contact is inside its wall",
    UNSOUND: "the loops do not close, or the energy error is above its limit",
    SLIDES: "an expression switches to and fro without end",
    unilateral.NO_SOLUTION: "the forces of the contacts have no solution",
    unilateral.NOT_UNIQUE: "the forces of the contacts are not unique",
    unilateral.LOCKED: "friction locks a contact",
    unilateral.CHATTER: "contacts change without end",
    unilateral.NOT_FOUND: "the forces of the contacts were not found",
}
CALLS = (short_peaks, long_peaks, read_ratios)  # what symbols cannot follow: kernels of the engine, by their names
ENDINGS = ("tables", "before", "columns")  # functions that `result_data` writes


class ResultData(NamedTuple):
    """What `viewer/core_result.js` needs besides a run."""

    data: dict[str, Any]
    functions: dict[str, int]  # numbers on the tape of `ENDINGS`


def result_data(m: Mechanism, tape: Tape, t_end: float | None = None, names: Sequence[str] | None = None) -> ResultData:
    """Names, numbers and functions on a tape with which the end of a run of a mechanism becomes a result.

    t_end: of its runs [s].  names: of the parameters, by default those of `chosen_parameters`.
    Raises TraceError where a value is taken without its record.
    """
    system, names = m.system, chosen_parameters(m._document) if names is None else names
    try:
        record = _record(m, names)
    except FAILURES as error:
        raise TraceError(f"the columns cannot be recorded: {error}") from error
    counts = {"row": width(system), "energy": at.ENERGIES, "call": len(record.calls)}
    keys = [(PARAMETER, name) for name in names] + [(kind, k) for kind, n in counts.items() for k in range(n)]
    functions = {name: tape.add(record.graph, record.outputs[name], keys) for name in ENDINGS}
    titles, model = list(record.units), system.model
    layout, settings = state_layout(system), model.settings
    end = t_end or settings.t_end
    moving = [name for name in titles if name not in model.recorded and record.units[name] in horizon.MOTION]
    return ResultData(
        {
            "names": titles, "units": record.units, "places": record.places, "parameters": list(names),
            "values": [model.parameters[name].value for name in names], "calls": record.calls,
            "width": width(system), "energies": width(system) - at.ENERGIES, "peaks": _peaks(system),
            "sample": {key: getattr(samples, key) for key in ("BEST", "WHEN", "SQUARES")},
            "kinds": KINDS,
            "words": {name: dict(words) for name, joint in model.joints.items() if (words := joint.leaf.events)},
            "contacts": len(system.arrays["contact"]), "first_account": layout.account(0).start,
            "account": {"size": layout.account(0).stop - layout.account(0).start, "IMPULSE": IMPULSE, "LOSS": LOSS},
            "jumps": [{"t": one.t, "joint": one.driver, "size": one.size} for one in timetable(system, 0.0, end).jumps],
            "rows": [[row.owner, row.unit] for row in system.rows], "watched": list(system.watched),
            "reactions": [titles[k] for k in np.flatnonzero(reaction_columns(system, record.units))],
            "extent": float(system.extent), "size": float(system.size), "notes": list(m.start.notes),
            "limit": soundness.LIMIT, "unsound": UNSOUND, "loose": soundness.LOOSE, "words_of_end": WORDS,
            "signals": list(model.recorded), "moving": moving, "bodies": system.body_count,
            "own_states": [layout.own_states.start, layout.own_states.stop], "states": states_of(system).start,
            "horizon": {key: getattr(horizon, key) for key in HORIZON},
            "at": {
                array: {name: getattr(at, name) for name in wanted} for array, wanted in NEEDED.items()
            },
        },
        functions,
    )  # fmt: skip


HORIZON = ("AGREE", "STILL", "NOISE", "MOST_NOISE", "SHAKEN", "LIKE")
NEEDED = {  # columns of arrays of a run that become parts of a result
    "clock": ("T", "FEWEST", "TROUBLE", "H_MIN"),
    "tally": ("DRIFT_ROW", "CONTACTS", "LEAPS", "SERIES"),
    "audit": (
        *("MOST_KINETIC", "MOST_WORK", "MOST_POTENTIAL", "LEAST_POTENTIAL", "FLOOR", "MOST_UNREST", "OPEN_LENGTH"),
        *("OPEN_ANGLE", "OPENNESS", "OPEN_ROW", "UNREST", "UNREST_LIMIT", "CORRECTION"),
    ),
    "contact_memory": ("CLOSED", "SHUT", "SINCE", "SPEED", "PEAK", "IMPULSE_0", "LOSS_0"),
    "passage": ("PASSED", "PASSED_AT", "PASSED_FROM", "PASSED_UNTIL"),
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


def _record(m: Mechanism, names: Sequence[str]) -> _Record:
    system, graph = m.system, Graph()
    recorder, watch, calls = Recorder(graph), Watch(), _Calls(graph)
    model = beside(read_watched(m._document, names, recorder, watch), system.model) if names else system.model
    row = [graph.input() for _ in range(width(system))]
    first = [0.0] * (width(system) - at.ENERGIES) + [graph.input() for _ in range(at.ENERGIES)]
    for kernel in CALLS:
        recorder.replace(kernel, calls.of(kernel))
    recorder.replace(of_law, lambda method, *given: recorder.recorded(method.__func__)(method.__self__, *given))
    recorder.recorded(film_columns)
    table, titles, units = recorder.recorded(columns)(replace(system, model=model), Table([first, row]))
    watch.require_record()
    places: list[int] = []
    derived: list[Any] = []
    rank = {symbol.place: k for k, symbol in enumerate(row)}
    for _, values in zip(titles, table, strict=True):
        symbol = values[-1]
        place = rank.get(symbol.place) if isinstance(symbol, Symbol) else None
        if place is None:
            place = -1 - len(derived)
            derived.append(symbol)
        places.append(place)
    tables = [one for call in calls.made for one in call.table]
    given = [one for call in calls.made for one in call.given]
    exact, outputs = lower(graph, [*tables, *given, *derived])
    ends = len(tables), len(tables) + len(given)
    return _Record(
        exact, {"tables": outputs[: ends[0]], "before": outputs[ends[0] : ends[1]], "columns": outputs[ends[1] :]},
        places, dict(units), [{"kernel": call.kernel, "table": len(call.table)} for call in calls.made],
    )  # fmt: skip


class _Call(NamedTuple):
    kernel: str
    given: list[Any]  # two symbols
    table: list[Any]  # coefficients


class _Calls:
    """Calls of kernels over arrays: each becomes an input more."""

    def __init__(self, graph: Graph) -> None:
        self.graph, self.made = graph, list[_Call]()

    def of(self, kernel: KernelFunction) -> Callable[..., None]:
        """What is recorded in place of a kernel (first, second, coefficients or none, what it fills)."""

        def call(first: Column, second: Column, *rest: Any) -> None:
            *table, found = rest
            coefficients = [symbol_of(x) for one in table for x in one]
            self.made.append(_Call(kernel.python.__name__, [first[-1], second[-1]], coefficients))
            found[-1] = self.graph.input()

        return call
