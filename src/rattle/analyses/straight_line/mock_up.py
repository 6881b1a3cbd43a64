"""A model as a Functional Mock-up Unit (FMI 3.0) for other simulation tools.

Parameters of the model file can be set there, as long as the start follows from them by equations that hold near the
one at hand; parameters given by others follow them.  Those that act only through forces and torques, like a motor's,
are inputs: other parts of a simulation, a controller say, may change them during a run.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import NamedTuple

from rattle.analyses.arguments import TIGHTEST
from rattle.analyses.straight_line.code import all_curves, units_of, with_parameters
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.analyses.straight_line.starts import CLOSED, FAR, MISSED, ROUNDS, SMALL
from rattle.equations.state import state_layout
from rattle.errors import TraceError
from rattle.jit.layout import OUTPUT_ENERGY
from rattle.language.recorded import Operand
from rattle.language.units import TIME, dimension_of, unit_name
from rattle.registry import kinds
from rattle.solvers.stepper import ATOL, FREE, RTOL, tableau_of, usual_stepper
from rattle.solvers.tableau import Tableau
from rattle.trace import fmu
from rattle.trace.elementary import lower
from rattle.trace.fmu_description import Experiment, Kind, Variable, description
from rattle.trace.hoist import hoist
from rattle.trace.program import PIECES
from rattle.version import __version__

DRIFT = 1e-6  # share of its size by which a state may be off the constraints in model exchange if no tolerance is given
SMALLEST_DRIFT = 1e-9  # the least such share: going back to the constraints makes integrators start anew
SAID = {  # what columns of results mean, by the last part of their names
    "x": "place of the mass centre", "y": "place of the mass centre", "angle": "angle", "vx": "speed", "vy": "speed",
    "omega": "angular speed", "ax": "acceleration", "ay": "acceleration", "alpha": "angular acceleration",
    "fx": "force on the second body", "fy": "force on the second body", "moment": "moment on the second body",
    "ex": "pin centre minus bush centre", "ey": "pin centre minus bush centre",
    "normal": "normal force, positive when pin and bush press", "tangential": "friction", "penetration": "depth",
    "tight": "force in the tight strand", "slack": "force in the slack strand",
    "eccentricity": "eccentricity over clearance", "film_thickness": "least thickness of the oil film",
    "film_pressure": "largest pressure of the oil film", "film_fx": "force of the oil film",
    "film_fy": "force of the oil film", "friction_torque": "moment of film and dry friction on the pin",
    "friction_power": "power lost to friction", "leakage": "oil that leaves both ends",
    "sommerfeld": "Sommerfeld number", "regime": "0 film, 1 mixed, 2 dry",
    "lambda_ratio": "film thickness over roughness",
    "slip": "relative speed", "locked": "1 where it is locked", "friction": "dry friction",
    "torque": "torque", "force": "force", "power": "power", "stop": "force or moment of the stop",
    "position": "position along the line", "length": "length", "rate": "rate of the coordinate or length",
    "kinetic": "kinetic energy", "potential": "potential energy", "work": "work done on the mechanism",
    "dissipated": "energy dissipated by loads", "balance": "energy that nothing accounts for: an error",
}  # fmt: skip


class MockUp(NamedTuple):
    """An FMU."""

    content: bytes  # of the file
    notes: list[str]  # what it lacks


def mock_up(model: RecordedModel, name: str, stop: float) -> MockUp:
    """An FMU of a model that was recorded without parameters.

    name: a short one, of which files are named; stop: when a run probably ends [s].
    The file holds the C sources, and a library for this platform if there is a C compiler.
    """
    identifier = fmu.identifier(name)
    settings, title = model.system.model.settings, model.system.model.name or name
    experiment = Experiment(stop, settings.rtol or RTOL, settings.output)
    model, constants = with_parameters(model)
    notes = [
        f"the parameter {parameter} is fixed: {why}"
        for parameter, why in constants.items()
        if parameter not in model.dependent
    ]
    curves = _curves(model)
    inputs = _inputs(model, curves)
    variables, equations = _variables(model, curves, inputs), _equations(model, curves, inputs)
    operations = equations.derivative[0].count(equations.derivative[1])
    header = f"{title}, written by rattle {__version__}; {operations} operations for rates"
    content = fmu.equations_text(equations, header, "").encode() + description(
        variables, identifier, title, "", experiment
    )
    token = fmu.token(content)
    files = fmu.sources(equations, header, token)
    entries = {"modelDescription.xml": description(variables, identifier, title, token, experiment)}
    entries["sources/buildDescription.xml"] = fmu.build_description(identifier)
    entries |= {f"sources/{name}": text.encode() for name, text in files.items()}
    try:
        entries[fmu.library_name(identifier)] = fmu.shared_library(files, fmu.MAIN)
    except TraceError as error:
        notes.append(f"{error}: the FMU holds C sources only, which the importing tool has to compile")
    return MockUp(fmu.archive(entries), notes)


def _curves(model: RecordedModel) -> dict[str, Operand]:
    """Result columns and points of bodies that are not states."""
    states = dict(state_layout(model.system).units())
    return {name: x for name, x in all_curves(model).items() if name not in states}


def _equations(model: RecordedModel, curves: Mapping[str, Operand], inputs: set[str]) -> fmu.Equations:
    graph, ny, system = model.graph, model.state_size, model.system
    parts = [model.derivative, model.projection, [*curves.values(), model.sound_curves]]
    exact, every = lower(graph, [x for part in parts for x in part])
    early, prepared, late, outputs = hoist(exact, every, exact.inputs[1 + ny :])
    ends = itertools.accumulate(map(len, parts), initial=0)
    derivative, project, rows = ((late, outputs[a:b]) for a, b in itertools.pairwise(ends))
    settings, names = system.model.settings, list(curves)
    rtol = settings.rtol or RTOL
    states = [name for name, _ in state_layout(system).units()]
    first = model.first
    energies = {key.upper(): names.index(f"energy.{key}") for key in ("kinetic", "potential", "balance")}
    return fmu.Equations(
        derivative, project, rows, (early, prepared), lower(graph, [curves["energy.balance"]]),
        lower(graph, [*model.dependent.values(), model.readable]),
        None if first is None else lower(graph, first.correction), None if first is None else lower(graph, first.rates),
        [fmu.Input(name, value, *_limits(model, name), name in inputs) for name, value in model.parameters.items()],
        model.start_state.tolist(), 3 * system.body_count, {**energies, "WORK": states.index("energy.work")},
        {
            "SIZE": system.size, "TOLERANCE": rtol, "ABSOLUTE": (settings.atol or ATOL * rtol) / rtol,
            "SMALLEST_TOLERANCE": TIGHTEST, "DRIFT": DRIFT, "SMALLEST_DRIFT": SMALLEST_DRIFT,
            "LAST_STEP": SMALL, "STILL_OPEN": CLOSED, "FAR": FAR,
            "MISSED": MISSED, "ROUNDS": ROUNDS, "MOST_PARTS": PIECES,
        },
        _tableau(settings.method),
    )  # fmt: skip


def _tableau(method: str | None) -> Tableau:
    """Of the model's method if that is explicit and adaptive, else of the usual one."""
    asked = tableau_of(kinds("stepper")[method]) if method else None
    if asked is not None and asked.adaptive:
        return asked
    usual = tableau_of(kinds("stepper")[usual_stepper(FREE)])
    assert usual is not None, "the usual method of smooth motion is explicit"
    return usual


def _inputs(model: RecordedModel, curves: Mapping[str, Operand]) -> set[str]:
    """Parameters on which rates depend, and neither the constraints, the start, stored energy nor other parameters."""
    graph, first = model.graph, model.first
    kept = [*model.projection, *model.dependent.values(), curves["energy.potential"]]
    kept += [] if first is None else [*first.correction, *first.rates]
    fixed, acting = set(graph.live(kept)), set(graph.live(model.derivative))
    places = zip(model.parameters, graph.inputs[1 + model.state_size :], strict=False)
    return {name for name, place in places if place in acting - fixed}


def _limits(model: RecordedModel, name: str) -> tuple[float, float]:
    parameter = model.system.model.parameters[name]
    return (
        -math.inf if parameter.minimum is None else parameter.minimum,
        math.inf if parameter.maximum is None else parameter.maximum,
    )


def _variables(model: RecordedModel, curves: Mapping[str, Operand], inputs: set[str]) -> list[Variable]:
    """All variables, in the order of their value references, which `fmu_sources` knows."""
    parameters, nq = model.system.model.parameters, 3 * model.system.body_count
    size = model.system.size
    variables = [Variable("t", Kind.TIME, "s", "time")]
    for name, value in model.parameters.items():
        parameter, kind = parameters[name], Kind.INPUT if name in inputs else Kind.PARAMETER
        meaning = "parameter of forces, may change during a run" if name in inputs else "parameter"
        variables.append(Variable(name, kind, parameter.unit, meaning, value, parameter.minimum, parameter.maximum))
    follows = "parameter that follows from others"
    variables += [Variable(name, Kind.FOLLOWING, parameters[name].unit, follows) for name in model.dependent]
    first, states = len(variables), state_layout(model.system).units()
    for k, (name, unit) in enumerate(states):
        nominal = size if k < nq and unit == "m" else 1.0
        meaning = meaning_of(name) if "." in name else "state of the model"
        variables.append(Variable(name, Kind.STATE, unit, meaning, nominal=nominal))
    for k, (name, unit) in enumerate(states):
        rate = {"m": "m/s", "rad": "rad/s", "m/s": "m/s^2", "rad/s": "rad/s^2", "J": "W"}.get(unit, "")
        if unit and not rate:
            rate = unit_name(dimension_of(unit).over(TIME))
        variables.append(Variable(f"der({name})", Kind.RATE, rate, f"rate of {name}", state=first + k))
    units = units_of(model, curves)
    return variables + [
        Variable(name, Kind.CURVE, unit, meaning_of(name)) for name, unit in zip(curves, units, strict=True)
    ]


def meaning_of(name: str) -> str:
    """What a column of results means."""
    owner, _, key = name.rpartition(".")
    if not owner:
        return "signal"
    if "." in owner:
        body, _, point = owner.partition(".")
        return f"{'speed' if key[0] == 'v' else 'place'} of the point {point} of {body} along {key[-1]}"
    axis = key[-1] if key not in ("moment", "power") and key[-1] in "xy" else ""
    along = f" along {axis}" if axis else ""
    what = SAID.get(key, key.replace("_", " "))
    return what if owner == "energy" and key in (*OUTPUT_ENERGY, "balance") else f"{what} of {owner}{along}"
