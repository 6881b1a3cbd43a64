"""A model as a program that computes its motion in a web page: recorded functions, drawing, settings and sliders.

The functions are those of `rattle code`, and what a page needs besides: the forces of massless links with the
right-hand side, how far joints are open, masses, and every number of the drawing that depends on parameters.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.dynamics import soundness
from rattle.analyses.straight_line.code import straight_line, with_parameters
from rattle.analyses.straight_line.recorded_model import RecordedModel, read_at, record_curves, record_model
from rattle.equations.closure import open_by
from rattle.equations.motion import derivative
from rattle.equations.state import state_layout
from rattle.errors import AssemblyError, ModelError, TraceError
from rattle.jit import layout as at
from rattle.language.recorded import Recorded, symbol_of
from rattle.mechanism import Mechanism
from rattle.pages.live_text import LIVE
from rattle.pages.same_start import tried_values, with_the_ideal_start, with_the_same_start
from rattle.registry import kinds
from rattle.results.columns import geometry
from rattle.solvers import step_audit
from rattle.solvers.stepper import ATOL, FREE, LONGEST, RTOL, usual_stepper
from rattle.trace import javascript
from rattle.trace.elementary import lower
from rattle.trace.graph import Symbol, both
from rattle.trace.hoist import hoist
from rattle.trace.program import Program
from rattle.trace.recording import Recorder, Recording
from rattle.trace.sides import landed_on, stand_on_sides, switching_functions

ENERGIES = 5  # result curves that come last
DRAWN = 1e-12  # share of the largest number of a drawing by which a recorded one may be off: rounding
MOST_STEPS = 400_000  # steps of a run in a page
MOVING = ("rates", "refined", "residual")  # further functions of the state
Place = tuple[str | int, ...]


class LiveProgram(NamedTuple):
    """A model that computes in a page."""

    module: str  # text of an ES module
    program: Program
    settings: dict[str, Any]  # of a run, see viewer/engine.js
    constants: Mapping[str, str]  # parameters that the page cannot change, and why
    notes: tuple[str, ...]
    ideal: LiveProgram | None = None  # the same mechanism without play, with all parameters


def live_program(m: Mechanism, t_end: float | None = None) -> LiveProgram:
    """The program of a mechanism.  t_end: of its runs [s], instead of the model's.

    Raises TraceError, with the reason, for what straight-line code cannot follow; ModelError, AssemblyError.
    """
    constants: Mapping[str, str]
    model, constants = with_parameters(m.recorded())
    ideal, beside = _without_play(m, t_end), False
    if not model.parameters and ideal is not None:
        model, constants, beside = with_the_ideal_start(m, model, constants)
    if not model.parameters:
        model, constants = with_the_same_start(m, model, constants)
    model, undrawn = _drawable(m, model)
    constants = {**constants, **undrawn}
    drawing, places, sizes, sound = drawn(model)
    model, recorders, switching = _on_sides(replace(model, readable=sound))
    further = {**_functions(model, recorders, switching), "geometry": sizes}
    if model.parameters and model.first is None:
        further["readable"] = [sound]
    made = straight_line(model, constants, further)
    if beside and made.begin is not None:
        made = made._replace(begin=made.begin._replace(beside=True))
    known = () if ideal is None else {one.name for one in ideal.program.parameters}
    if ideal is not None and not set(known) >= {one.name for one in made.parameters}:
        if beside:
            raise TraceError("its start follows from the mechanism without play, which has other parameters")
        ideal = None
    settings, notes = run_settings(m, t_end)
    module = _module(model, made, drawing, places, beside)
    asked = [f"the model as it is written: {note}" for note in m.start.notes]
    return LiveProgram(module, made, settings, constants, (*notes, *asked, *_uncertain(model)), ideal)


def _without_play(m: Mechanism, t_end: float | None) -> LiveProgram | None:
    """The program of the same mechanism without play, if it has play; None too where there is no such program."""
    if not any(one.contact is not None and not one.contact.closed for one in m.model.joints.values()):
        return None
    try:
        return live_program(m.ideal(), t_end)
    except (TraceError, ModelError, AssemblyError):
        return None


# ---------------------------------------------------------------- functions of a run
def _on_sides(model: RecordedModel) -> tuple[RecordedModel, tuple[Recorder, Recorder], list[Any]]:
    """The model with an input more for every switch, its side; what records it, and its switching functions.

    The second recorder records what holds next to singular positions.
    """
    recorders, recorded = (Recorder(model.graph), Recorder(model.graph, usual=False)), model.recorded
    switches = landed_on(recorded)
    if not switches:
        return model, recorders, []
    t, y, energy = model.time, _state(model), Symbol(model.graph, model.graph.inputs[-1])
    sides = {one.row: model.graph.input() for one in switches}
    for one in recorders:
        stand_on_sides(one, sides)
    recording = Recording(recorded, recorders[0])
    rate, sound_rate = recording.guarded(lambda: recording.derivative(t, y))
    curves, _, sound = record_curves(recording, t, y)
    curves["energy.balance"] = curves["energy.balance"] - energy
    functions = switching_functions(recorders[0], recorded, t, y)
    return replace(model, derivative=[*rate, sound_rate], curves=curves, sound_curves=sound), recorders, functions


def _uncertain(model: RecordedModel) -> tuple[str, ...]:
    """Switches at which the steps of a page do not end, in words."""
    known = {one.row for one in landed_on(model.system)}
    names = sorted({one.name for one in model.system.switches if one.row not in known})
    return (f"steps go across the switches of {', '.join(names)} (floor, mod, tables with kinks)",) if names else ()


def _functions(
    model: RecordedModel, recorders: tuple[Recorder, Recorder], switching: Sequence[Any]
) -> dict[str, list[Any]]:
    """What a page computes at every step, as symbols."""
    recorded = model.recorded
    recording = Recording(recorded, recorders[0])
    t, y = model.time, _state(model)
    nq = 3 * recorded.body_count
    opened = recording.run(open_by, t, y[:nq], y[nq : 2 * nq])
    rate = np.zeros(len(y), dtype=object)
    moved, refined = recording.run(derivative, t, y, rate), _refined(model, recorders[1])
    links = [model.curves[f"{name}.normal"] for name in recorded.watched]
    residuals = [opened.rows[n, at.RES] for n in range(len(recorded.rows))]
    weight = recorded.arrays["weight"][1:]
    masses = [1.0 / symbol_of(x) for x in weight.ravel()]
    push: list[Any] = [0.0, 0.0]
    for fx, fy, moment in moved.force[1:]:
        push = [push[0] + abs(moment), push[1] + abs(fx) + abs(fy)]
    beside = [moved.power[at.PIVOT_SHARE], *links, *switching]
    energies = [model.curves["energy.kinetic"], model.curves["energy.potential"]]
    return {
        "rates": [*model.derivative, *beside],
        "refined": [*refined, *beside], "residual": [*residuals, *energies], "fixed": [*masses, *push],
    }  # fmt: skip


def _refined(model: RecordedModel, recorder: Recorder) -> list[Any]:
    """dy/dt (ny,) [SI/s] and a flag, as computed next to singular positions."""
    recording = Recording(model.recorded, recorder)
    rate, sound = recording.guarded(lambda: recording.derivative(model.time, _state(model)))
    return [*rate, sound]


def _state(model: RecordedModel) -> np.ndarray:
    """(ny,) symbols of the state."""
    places = model.graph.inputs[1 : 1 + model.state_size]
    return np.array([Symbol(model.graph, place) for place in places], dtype=object)


def _layout(model: RecordedModel, made: Program, prepared: int) -> dict[str, Any]:
    """Where what stands: names and places that the page's engine reads."""
    system, states = model.system, state_layout(model.system)
    own = states.own_states
    count = len(model.curves) - ENERGIES  # columns of a result that are no energies; they come first
    signals = [made.names.index(name) for name in system.model.recorded]
    return {
        "ny": model.state_size, "prepared": prepared, "nb": system.body_count,
        "controlled": [*range(6 * system.body_count), *range(own.start, own.stop)],
        "links": list(system.watched),
        "switches": [[one.name, one.timed] for one in landed_on(system)],
        "rows": [[row.owner, row.unit] for row in system.rows],
        "extent": float(system.extent), "size": float(system.size), "compared": count, "signals": signals,
        "states": [made.names.index(name) for name in system.model.states], "first_state": own.start,
    }  # fmt: skip


def run_settings(m: Mechanism, t_end: float | None = None) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Settings of a run in a page, those of [simulate], and what a reader must know of them."""
    given = m.model.settings
    end = given.t_end if t_end is None else t_end
    method = given.method or usual_stepper(FREE)
    notes: tuple[str, ...] = ()
    if kinds("stepper")[method].leaf.tableau is None:
        notes = (f"the model's method {method} is not in this page: {usual_stepper(FREE)} computes here",)
        method = usual_stepper(FREE)
    rtol = given.rtol or RTOL
    interval = given.output or end / 1000
    return {
        **method_settings(method),
        "rtol": rtol, "atol": given.atol or ATOL * rtol, "step": given.step, "t_end": end,
        "outputs": max(1, round(end / interval)), "fixed_step": min(LONGEST, end / 1000), "usual": RTOL,
        "most_steps": MOST_STEPS,
        "limits": {"drift": soundness.LIMIT, "energy": 1e-3, "jump": step_audit.TOO_FAR},
    }, notes  # fmt: skip


def method_settings(method: str) -> dict[str, Any]:
    """The part of `run_settings` that an explicit method determines."""
    stepper = kinds("stepper")[method].leaf
    tableau = stepper.tableau
    return {
        "method": method, "refinement": stepper.refinement,
        "tableau": {
            "order": tableau.order, "stages": tableau.stages, "adaptive": tableau.adaptive,
            "stable": tableau.watched_stable, "C": tableau.c.tolist(), "A": _sparse(tableau.a),
            "ends": _sparse(tableau.ends), "D": _sparse(tableau.arrays["dense_weights"]),
        },
    }  # fmt: skip


def _sparse(rows: np.ndarray) -> list[list[list[Any]]]:
    """Places and values of what is not zero, row by row."""
    return [[np.flatnonzero(row).tolist(), row[np.flatnonzero(row)].tolist()] for row in rows]


# ---------------------------------------------------------------- the drawing
def drawn(model: RecordedModel) -> tuple[Any, list[Place], list[Any], Any]:
    """The drawing of the model, the places of its numbers that follow from parameters, these as symbols, and a flag.

    The flag is true where the parameters leave the drawing the same parts.
    """
    made = geometry(model.recorded.model)
    places = [place for place, value in _numbers(made) if isinstance(value, Recorded)]
    sizes = [_at(made, place) for place in places]
    flags = {id(one.journal): one.journal.assumed for one in sizes}
    sound = both(model.graph, [model.readable, *(flag for each in flags.values() for flag in each.values())])
    return made, places, [symbol_of(x) for x in sizes], sound


def _numbers(tree: Any, place: Place = ()) -> list[tuple[Place, Any]]:
    """All numbers of a nested dictionary or list, with their places."""
    if isinstance(tree, Mapping):
        return [one for key, inner in tree.items() for one in _numbers(inner, (*place, key))]
    if isinstance(tree, list | tuple):
        return [one for k, inner in enumerate(tree) for one in _numbers(inner, (*place, k))]
    return [(place, tree)] if isinstance(tree, float | int) and not isinstance(tree, bool) else []


def _at(tree: Any, place: Place) -> Any:
    for key in place:
        tree = tree[key]
    return tree


def _drawable(m: Mechanism, model: RecordedModel) -> tuple[RecordedModel, dict[str, str]]:
    """The model with those parameters whose drawing follows them exactly, the others and why they cannot be changed."""
    wrong = {name: why for name in model.parameters if (why := _misdrawn(model, name))}
    if wrong:
        kept = [name for name in model.parameters if name not in wrong]
        model = record_model(model.document, model.system, model.start, kept) if kept else m.recorded()
    return model, wrong


def _misdrawn(model: RecordedModel, name: str) -> str:
    """Why the drawing does not follow a parameter; "" if it does, at several values of it."""
    _, places, sizes, sound = drawn(model)
    graph, outputs = lower(model.graph, [*sizes, sound])
    for x in tried_values(model.system.model.parameters[name]):
        values = {**model.parameters, name: x}
        try:
            want = geometry(read_at(model, values))
        except ModelError:
            continue
        got = graph.evaluate(outputs, model.inputs(0.0, model.start_state, list(values.values()))[:, None])[:, 0]
        if got[-1] != 1.0:
            continue  # the page refuses this value
        every = dict(_numbers(want))
        scale = max((abs(v) for v in every.values()), default=1.0)
        mine = {**dict(_numbers(geometry(model.system.model))), **dict(zip(places, got[:-1], strict=True))}
        if every.keys() != mine.keys():
            return "the drawing gets other parts with it"
        off = [place for place, v in every.items() if not abs(mine[place] - v) <= DRAWN * scale]
        if off:
            return f"the page cannot draw how {' '.join(map(str, off[0][:3]))} follows from it"
    return ""


# ---------------------------------------------------------------- the module
def _module(model: RecordedModel, made: Program, drawing: Any, places: Sequence[Place], beside: bool) -> str:
    """The text: what parameters alone determine is computed once for a run, by `prepare`."""
    plain = json.loads(json.dumps(drawing, default=float))
    moving = {"project": made.projection, "outputs": made.outputs} | {name: made.further[name] for name in MOVING}
    once = made.starting | {name: one for name, one in made.further.items() if name not in MOVING}
    last = 1 + model.state_size + len(model.parameters) + 1  # sides of switches come after E_0
    early = made.graph.inputs[1 + model.state_size : last]
    hoisted = hoist(made.graph, [x for one in moving.values() for x in one], early)
    ends = np.cumsum([0, *map(len, moving.values())])
    texts = [javascript.function(made.graph, one, f"{name}Of") for name, one in once.items()]
    texts.append(javascript.function(hoisted.early, hoisted.prepared, "prepareOf"))
    for name, (first, end) in zip(moving, itertools.pairwise(ends), strict=True):
        texts.append(javascript.function(hoisted.late, hoisted.outputs[first:end], f"{name}Of"))
    text = LIVE
    for key, value in (
        ("layout", javascript.as_text(_layout(model, made, len(hoisted.prepared)))),
        ("drawing", javascript.as_text(plain)), ("places", javascript.as_text([list(place) for place in places])),
        ("needs", "true" if beside else "false"),
        ("functions", ", ".join(f"{name}: {name}Of" for name in (*once, "prepare", *moving))),
    ):  # fmt: skip
        text = text.replace(f"@{key}@", value)
    return "\n".join([*javascript.shared(made, texts), text.lstrip("\n")])
