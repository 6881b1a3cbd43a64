"""A model as data with which a page moves it: the run before its first step, and what follows from parameters.

The compiled kernels of the engine take the steps (`pages.engine`).  What is a model's own are the numbers in the arrays
of its run, which follow from the parameters as `recorded_arrays` says, its start (`pages.start_data`), the curves that
rows are turned into (`pages.result_data`), and the numbers of its drawing.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.dynamics.peak_values import measures_of_peaks
from rattle.analyses.dynamics.run import Run
from rattle.analyses.dynamics.simulate import POINTS
from rattle.analyses.dynamics.soundness import measures_of_rows
from rattle.analyses.straight_line.recorded_arrays import RecordedArrays, Values, recorded_arrays
from rattle.description.model import Parameter
from rattle.description.read_parameters import chosen_parameters
from rattle.equations.state import state_layout
from rattle.equations.system import System
from rattle.errors import AssemblyError, InputError, ModelError, TraceError
from rattle.jit import layout as at
from rattle.mechanism import Mechanism
from rattle.pages.result_data import result_data
from rattle.pages.run_image import planned_run, run_image
from rattle.pages.start_data import start_data
from rattle.pages.tape import Tape, add_arrays
from rattle.results.columns import geometry
from rattle.solvers.peaks import samples
from rattle.solvers.stepper import RTOL, SMOOTH

MOST_STEPS = 1_000_000  # of a run in a page
TRIED = (-0.3, -0.07, 0.01, 0.4)  # changes of a parameter at which something is looked at, in shares of it
FOLLOWS = "it follows from others"
DRAWING = "drawing"  # entries that are numbers of the drawing
Place = tuple[str | int, ...]


class LiveModel(NamedTuple):
    """A model that computes in a page."""

    data: dict[str, Any]  # for JSON, with bytes, see `packed.as_json`
    tape: Tape  # its functions, and those of the same mechanism without play
    parameters: Mapping[str, Parameter]  # that a page can change
    fixed: Mapping[str, str]  # parameters that it cannot change, and why
    names: tuple[str, ...]  # of curves
    t_end: float  # of its run [s]
    notes: tuple[str, ...]  # that a reader needs
    contacts: bool  # whether its kernels are those of the engine with contacts
    ideal: LiveModel | None = None  # the same mechanism without play


def live_model(
    m: Mechanism, t_end: float | None = None, *, alone: bool = False, tape: Tape | None = None, derived: bool = False
) -> LiveModel:  # fmt: skip
    """What a page needs to move a mechanism up to t_end [s], by default the model's.

    alone: not the same mechanism without play too.  tape: to which its functions are added, by default a new one.
    derived: with curves that the viewer derives, for programs without one.
    Raises TraceError for what a page cannot compute, with the reason; ModelError, AssemblyError.
    """
    tape = Tape() if tape is None else tape
    try:
        run = planned_run(m, t_end)
        image = run_image(run)
    except InputError as error:
        raise TraceError(str(error)) from error
    recorded, fixed = _changeable(m, run)
    arrays, places, drawing = recorded
    names = arrays.names
    result, start = result_data(m, tape, t_end, names, derived), start_data(m, tape, names)
    data = {
        "run": image.description,
        "content": image.content,
        "parameters": [_written(name, m.model.parameters[name]) for name in names],
        "entries": [[name, where.tolist()] for name, where in arrays.entries.items() if name != DRAWING],
        "facts": list(arrays.facts),
        "drawing": json.loads(json.dumps(drawing, default=_bare)),
        "drawn": [list(place) for place in places],
        "settings": _settings(m, run, t_end),
        "method": {"name": run.stepper.name, "refinement": run.stepper.leaf.refinement, "usual": RTOL},
        "functions": {"arrays": add_arrays(tape, arrays), **result.functions},
        "start": {"description": start.description, "content": start.content},
        "result": result.data,  # the last, see `page.worker_text`
    }  # fmt: skip
    parameters = {name: m.model.parameters[name] for name in names}
    notes = (f"the model as it is written: {note}" for note in m.start.notes)
    return LiveModel(
        data, tape, parameters, fixed, tuple(result.data["names"]), run.t_end, tuple(notes), touches(run),
        None if alone else _without_play(m, t_end, tape),
    )  # fmt: skip


def touches(run: Run) -> bool:
    """Whether a run needs kernels of contacts, oil or friction in joints."""
    arrays = run.system.arrays
    return len(arrays["contact"]) > 0 or len(arrays["dry"]) > 0 or run.stepper.leaf.loop != SMOOTH


def _written(name: str, parameter: Parameter) -> list[Any]:
    """A parameter: name, value, limits or None [SI], unit."""
    return [name, parameter.value, parameter.minimum, parameter.maximum, parameter.unit]


def _default_step(run: Run) -> dict[str, Any]:
    """The longest step of a method with equal steps that is not told one [s], and their number in a short run."""
    if run.stepper.leaf.adaptive:
        return {}
    default = run.stepper.leaf.step.default
    return {"longest": default(1e12), "fewest": 1e-12 / default(1e-12)}


def _settings(m: Mechanism, run: Run, t_end: float | None) -> dict[str, Any]:
    """What is given for runs, and does not follow from their end."""
    settings = m.model.settings
    return {
        "interval": settings.output, "outputs": POINTS, "end_given": t_end is not None,
        "tightest": arguments.TIGHTEST, **_default_step(run),
        "step_given": settings.step is not None, "atol_given": settings.atol is not None, "most_steps": MOST_STEPS,
    }  # fmt: skip


def _without_play(m: Mechanism, t_end: float | None, tape: Tape) -> LiveModel | None:
    """The same mechanism without play, if it has play; None too where a page cannot move it."""
    if not _is_open(m):
        return None
    try:
        ideal = m.ideal()
        if _is_open(ideal):  # a belt always has its contacts
            return None
        return live_model(ideal, t_end, alone=True, tape=tape)
    except (TraceError, ModelError, AssemblyError):
        return None


def _is_open(m: Mechanism) -> bool:
    """Whether a joint has a contact that `Mechanism.ideal` would close, which need not hold the mechanism together."""
    return any(joint.contact is not None and not joint.contact.closed for joint in m.model.joints.values())


# ---------------------------------------------------------------- what follows from parameters
def _changeable(m: Mechanism, run: Run) -> tuple[_Recorded, dict[str, str]]:
    """The arrays of a run and its drawing, recorded for all parameters that a page can change; the others, and why."""
    asked = list(chosen_parameters(m._document))
    fixed = {name: FOLLOWS for name in m.model.parameters if name not in asked}
    recorded = _recordable(m, run, asked, fixed)
    kept = recorded.arrays.names
    fixed |= dict.fromkeys(_structural(m, recorded.arrays), "it changes the form of the model")
    left = [name for name in kept if name not in fixed]
    return (recorded if len(left) == len(kept) else _recorded(m, run, left)), fixed


def _recordable(m: Mechanism, run: Run, asked: Sequence[str], fixed: dict[str, str]) -> _Recorded:
    """As recorded for all of the parameters that can be; the others go to `fixed`."""
    try:
        return _recorded(m, run, asked)
    except TraceError:
        for name in asked:
            try:
                _recorded(m, run, [name])
            except TraceError:
                fixed[name] = "only rattle itself can follow what depends on it"
    return _recorded(m, run, [name for name in asked if name not in fixed])


def _tried(parameter: Parameter) -> list[float]:
    """Values of a parameter at which something is looked at [SI]: some around its own, and its limits."""
    values = [parameter.value + share * (parameter.value or 1.0) for share in TRIED]
    return values + [x for x in (parameter.minimum, parameter.maximum) if x is not None]


def _structural(m: Mechanism, arrays: RecordedArrays) -> Iterator[str]:
    """Parameters that stand for another form of the model wherever they are changed."""
    own = arrays.inputs(m.system)
    for k, name in enumerate(arrays.names):
        values = _tried(m.model.parameters[name])
        tried = np.repeat(own[:, None], len(values), axis=1)
        tried[k] = values
        if not arrays.graph.evaluate([arrays.holds], tried).any():
            yield name


class _Recorded(NamedTuple):
    arrays: RecordedArrays  # as functions of parameters
    places: list[Place]  # of the drawing's numbers that follow, the last entries
    drawing: Any


def _recorded(m: Mechanism, run: Run, names: Sequence[str]) -> _Recorded:
    """The arrays of a run and its drawing as functions of parameters.

    Raises TraceError where something takes a value without its record.
    """
    drawings: list[Any] = []

    def further(recorded: System) -> Values:
        drawings.append(geometry(recorded.model))
        numbers = (value for _, value in _numbers(drawings[0]))
        return {**_of_run(recorded, run), DRAWING: dict(enumerate(numbers))}  # the last entries

    arrays = recorded_arrays(m._document, m.system, names, more=further)
    places = [place for place, _ in _numbers(drawings[0])]
    return _Recorded(arrays, [places[k] for k in arrays.entries.get(DRAWING, ())], drawings[0])


def _of_run(recorded: System, run: Run) -> Values:
    """Values of the arrays of a run, besides those of its system, that may follow from parameters."""
    columns = run.workspace.peaks.shape[1]
    peaks = {
        row * columns + column: value
        for row, pair in enumerate(measures_of_peaks(recorded) if len(run.workspace.peaks) else ())
        for column, value in zip((samples.ARM, samples.NOTHING), pair, strict=True)
    }
    starts = (state.start for state in recorded.model.states.values())
    return {
        "measure": dict(enumerate(measures_of_rows(recorded))),
        "peaks": peaks,
        "held": {at.SIZE: recorded.size} if len(run.workspace.held) else {},
        "driver_leap": _scales(recorded, run.workspace.driver_leap),
        "state": dict(enumerate(starts, state_layout(recorded).own_states.start)),
    }


def _scales(recorded: System, leap: np.ndarray) -> dict[int, Any]:
    """Lengths by which jumps of drivers in position are judged, by their places in `driver_leap`."""
    lengths = (k for k, row in enumerate(leap) if recorded.rows[int(row[at.LEAP_ROW])].unit == "m")
    return {k * leap.shape[1] + at.LEAP_SCALE: recorded.size for k in lengths}


def _numbers(tree: Any, place: Place = ()) -> Iterator[tuple[Place, Any]]:
    """All numbers of a nested dictionary or list, with their places."""
    if isinstance(tree, Mapping):
        for key, inner in tree.items():
            yield from _numbers(inner, (*place, key))
    elif isinstance(tree, list | tuple):
        for k, inner in enumerate(tree):
            yield from _numbers(inner, (*place, k))
    elif isinstance(tree, float | int) and not isinstance(tree, bool):
        yield place, tree


def _bare(value: Any) -> Any:
    """A number of the drawing without its record."""
    return getattr(value, "bare", value)
