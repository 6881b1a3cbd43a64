"""Sensitivities of curves to parameters: what is asked, which analysis answers it, and the result.

Source: docs/theory.md, section 10; Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), ch. 10.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.simulate import output_times
from rattle.analyses.history import require_no_states
from rattle.analyses.straight_line.derived_curves import derived_curve, derived_names
from rattle.analyses.straight_line.machine_code import MachineFunctions
from rattle.analyses.straight_line.recorded_model import BESIDE, RecordedModel, record_model, require_parameters
from rattle.equations.system import System
from rattle.errors import InputError, SolverError, TraceError, suggest
from rattle.jit import layout as at
from rattle.language.recorded import Operand
from rattle.questions.equilibrium.compute import equilibria
from rattle.questions.equilibrium.quasistatic import quasistatic
from rattle.questions.kinematics.compute import analyse, instants
from rattle.questions.sensitivity.at_rest import AtRest, record_rest
from rattle.questions.sensitivity.contacts import ContactMotion
from rattle.questions.sensitivity.driven import Driven, positions
from rattle.questions.sensitivity.effects import derivative_name, quotient, usual_change
from rattle.questions.sensitivity.events import CROWDED
from rattle.questions.sensitivity.functions import Functions
from rattle.questions.sensitivity.growth import growth, horizon, linear_until
from rattle.questions.sensitivity.motion import UNSOUND, Motion
from rattle.questions.sensitivity.nearby import Nearby
from rattle.questions.sensitivity.numbers import curves_of, number_slopes, numbers_in, read_off
from rattle.questions.sensitivity.numbers import instants as all_instants
from rattle.questions.sensitivity.of_contacts import (
    contacts_in,
    require_same_contacts,
    require_same_start,
    with_contacts,
)
from rattle.questions.sensitivity.parameters import Parameters
from rattle.questions.sensitivity.start import counted, start
from rattle.questions.sensitivity.touching import Touching
from rattle.results.build import build_result
from rattle.results.reductions import Output, Reduction
from rattle.results.result import Result, UnknownName
from rattle.results.trust import Trust
from rattle.solvers.stepper import ATOL
from rattle.trace.elementary import lower
from rattle.value_types import Tree

ANALYSES = ("simulate", "kinematics", "inverse-dynamics", "equilibrium")
RTOL = 1e-10  # default relative tolerance of a motion with its derivatives
SAME = 1e-6  # share of the largest of its unit by which a curve may differ from that of the analysis itself
STILL = 1e-12  # [SI] scale of curves that are all 0, beside which nothing is told from rounding
NUDGE = 1e-7  # change of a parameter, as a share, that must not change the parts of the model


@dataclass
class Found:
    """Curves and derivatives at the first n of the instants."""

    values: np.ndarray  # (n, nc)
    derivatives: np.ndarray  # (n, nc, k)
    trust: Trust
    stats: dict[str, Any] = field(default_factory=dict)
    message: str = ""
    settings: dict[str, Any] = field(default_factory=dict)
    nearby: Nearby | None = None  # how numbers of the whole run change; None where it does not come to its end


@dataclass
class Asked:
    """A question: derivatives of which curves, by which parameters, when."""

    model: RecordedModel
    parameters: Parameters
    outputs: tuple[str, ...]
    t_eval: np.ndarray  # (n,) [s]
    rtol: float
    atol: float  # [m, rad, m/s, rad/s]
    of_contacts: Mapping[str, Reduction] = field(default_factory=dict)  # those outputs that are of a contact
    read_off: np.ndarray | None = None  # instants that numbers of the whole run read off [s]; None: there are none

    def curves(self, columns: Mapping[str, Operand]) -> tuple[dict[str, Operand], dict[str, str]]:
        """Symbols and SI units of the outputs.  columns: result columns by name."""
        model, symbols, units = self.model, {}, {}
        for name in self.outputs:
            if name in self.of_contacts:
                continue
            if name in columns:
                symbols[name], units[name] = columns[name], model.units[name]
                continue
            derived = derived_curve(model.graph, model.recorded, columns, name)
            if derived is None:
                choices = [*columns, *derived_names(model.recorded.model, columns)]
                raise UnknownName(f"no curve '{name}' to take derivatives of{suggest(name, choices)}")
            symbols[name], units[name] = derived
        return symbols, units


def sensitivity(
    document: Tree, system: System, begin: Assembled, outputs: Sequence[str], parameters: Sequence[str],
    t_eval: Any = None, analysis: str = "simulate", *, rtol: float | None = None, atol: float | None = None,
    strict: bool = False,
) -> Result:  # fmt: skip
    """Curves and their derivatives by parameters; see `Mechanism.sensitivity`.

    document: the tables of the model file, of which `system` was made; begin: its start.
    """
    began = time.perf_counter()
    if analysis not in ANALYSES:
        raise InputError(f"unknown analysis '{analysis}'{suggest(str(analysis), ANALYSES)}")
    rtol = arguments.relative_tolerance(RTOL if rtol is None else rtol)
    atol = arguments.positive("atol", ATOL * rtol if atol is None else atol)
    outputs, parameters = _names("outputs", outputs), _names("parameters", parameters)
    require_parameters(system, parameters)
    if analysis != "simulate":
        require_no_states(system.model, analysis)
    times = _times(system, t_eval, analysis)
    arguments.require_room(len(times), len(outputs) * (1 + len(parameters)))
    of_contacts = contacts_in(system, outputs, analysis)

    def recorded(beside: float, crowded: bool) -> Asked:
        model = _recorded(document, system, begin, parameters, analysis == "simulate", beside, crowded)
        return Asked(model, Parameters.of(model), outputs, times, rtol, atol, of_contacts)

    asked, answer, units = _answered(recorded, analysis)
    answer.stats["wall_time"] = time.perf_counter() - began
    result = _result(asked, analysis, answer, units)
    if strict and answer.message:
        raise SolverError(answer.message, result)
    return result


def _answered(recorded: Callable[[float, bool], Asked], analysis: str) -> tuple[Asked, Found, dict[str, str]]:
    """The question and its answer; next to a singular position, and where many contacts take part, by another record.

    recorded: the question by a record of the model, see `trace.recording.Recorder` for what it takes.
    """
    beside, crowded = 0.0, False
    while True:
        asked = recorded(beside, crowded)
        numbers = numbers_in(asked.model, asked.outputs, asked.of_contacts)
        answer, units = _with_numbers(asked, numbers, analysis) if numbers else FIND[analysis](asked)
        contacts = asked.model.contacts
        near = answer.message.endswith(UNSOUND) and beside == 0.0
        crowd = CROWDED in answer.message and not crowded and contacts is not None and contacts.are.may_crowd
        if analysis != "simulate" or not (near or crowd):
            return asked, answer, units
        beside, crowded = BESIDE if near else beside, crowded or crowd


# ---------------------------------------------------------------- the question
def _names(what: str, asked: Sequence[str]) -> tuple[str, ...]:
    names = (asked,) if isinstance(asked, str) else tuple(dict.fromkeys(asked or ()))
    if not names or not all(isinstance(name, str) for name in names):
        example = '["rocker.angle"]' if what == "outputs" else '["l2", "r3"]'
        raise InputError(f"{what}: expected a list of names such as {example}")
    return names


def _times(system: System, t_eval: Any, analysis: str) -> np.ndarray:
    """(n,) instants [s]."""
    if t_eval is None:
        return np.zeros(1) if analysis == "equilibrium" else output_times(system.model.settings, None, None)[1]
    times = instants(t_eval)
    return output_times(system.model.settings, None, times)[1] if analysis == "simulate" else times


def _recorded(
    document: Tree, system: System, begin: Assembled, parameters: Sequence[str], in_time: bool, beside: float,
    crowded: bool,
) -> RecordedModel:  # fmt: skip
    """The recorded model.  Raises TraceError with what can be done, also where a parameter changes its parts."""
    try:
        states = bool(system.arrays["dry"][:, at.DRY_STATES].any())  # of friction in joints
        model = record_model(
            document, system, begin, parameters, contacts=in_time and (system.turns or states), beside=beside,
            crowded=crowded,
        )  # fmt: skip
    except TraceError as error:
        remedy = ""
        joints = system.model.joints.items()
        stopped = [
            f"joints.{name}{'' if joint.held_by_stops else '.stop'}" for name, joint in joints if joint.stop is not None
        ]
        if "clutch" in str(error):
            remedy = "; compare two runs with set()"
        elif stopped:
            remedy = f"; take derivatives of the mechanism without stops (set {', '.join(stopped)} to None), or compare"
            remedy += " two runs with set()"
        elif len(system.arrays["contact"]):
            remedy = (
                "; take derivatives of the mechanism without play (ideal(), --ideal) or with massless links, or compare"
                " two runs with set()"
            )
        raise TraceError(f"no sensitivities: {error}{remedy}") from None
    functions = MachineFunctions()
    readable = functions.add(*lower(model.graph, [model.readable]))
    functions.compile()
    for n, (name, value) in enumerate(model.parameters.items()):
        columns = np.repeat(model.inputs(0.0, model.start_state)[:, None], 8, axis=1)
        nudge = NUDGE * (abs(value) or 1.0)
        columns[1 + model.state_size + n, :2] += (-nudge, nudge)
        flags = np.empty((1, 8))
        readable(columns, flags)
        if not flags[0, :2].any():
            raise TraceError(
                f"no sensitivities: at its value {value:g} '{name}' decides which parts the model has; any other value"
                " makes another model"
                + ("; leave it out: the others have derivatives" if len(model.parameters) > 1 else "")
            )
    return model


def _with_numbers(asked: Asked, numbers: Mapping[str, Output], analysis: str) -> tuple[Found, dict[str, str]]:
    """What is found where some outputs are numbers of the whole run, which are the same at every instant."""
    if analysis == "equilibrium":
        raise InputError(f"{next(iter(numbers))!r}: a number of a whole motion; an equilibrium has curves only")
    kept = read_off(numbers, {name: p.value for name, p in asked.model.system.model.parameters.items()})
    begin = 0.0 if analysis == "simulate" else float(asked.t_eval[0])
    times = all_instants(asked.t_eval, kept, begin)
    kept = np.union1d(kept, [begin, times[-1]])
    plain = [name for name in asked.outputs if name not in numbers]
    curves = [name for name in curves_of(numbers) if name not in plain]
    answer, units = FIND[analysis](replace(asked, outputs=(*plain, *curves), t_eval=times, read_off=kept))
    rows = np.isin(times[: len(answer.values)], asked.t_eval)
    columns = {name: (answer.values[rows, n], answer.derivatives[rows, n]) for n, name in enumerate(plain)}
    names = [name for name in (*plain, *curves) if name not in asked.of_contacts]
    for text, (value, slopes) in _slopes_of(asked, numbers, names, answer).items():
        columns[text] = np.full(rows.sum(), value), np.tile(slopes, (rows.sum(), 1))
        units[text] = numbers[text].unit
    answer.values = np.array([columns[name][0] for name in asked.outputs]).T
    answer.derivatives = np.array([columns[name][1] for name in asked.outputs]).transpose(1, 0, 2)
    return answer, units


def _slopes_of(
    asked: Asked, numbers: Mapping[str, Output], curves: Sequence[str], answer: Found
) -> dict[str, tuple[float, np.ndarray]]:  # fmt: skip
    """Value and derivatives (k,) of every number, nan and a note where there are none; curves: names of the columns."""
    lacking = np.nan, np.full(answer.derivatives.shape[2], np.nan)
    slopes, nearby = dict.fromkeys(numbers, lacking), answer.nearby
    if nearby is not None:
        held = {text: output for text, output in numbers.items() if nearby.holds(output, asked.model.values)}
        slopes |= number_slopes(held, asked.model, curves, nearby) if held else {}
    if texts := [text for text, pair in slopes.items() if pair is lacking]:
        answer.trust = replace(answer.trust, notes=(*answer.trust.notes, f"no derivative of {', '.join(texts)}"))
    return slopes


# ---------------------------------------------------------------- the analyses
def _simulate(asked: Asked) -> tuple[Found, dict[str, str]]:
    model = asked.model
    curves, units = asked.curves(model.curves)
    compiled = MachineFunctions()
    functions = Functions(model, asked.parameters, curves, compiled.add)
    touching = None if model.contacts is None else Touching(functions, model.contacts, compiled.add)
    z, functions.parameters = start(model, asked.parameters, compiled)
    if touching is not None:
        require_same_start(model, z[:, 0])
    how = asked.t_eval, asked.rtol, asked.atol
    run = Motion(functions, z, *how) if touching is None else ContactMotion(functions, touching, z, *how)
    run.moments = None if asked.read_off is None else []
    run.go()
    notes, reach = _growth_notes(asked, run)
    if isinstance(run, ContactMotion) and run.t > 0.0:
        require_same_contacts(model, run, reach, asked.rtol, asked.atol)
    count, k = len(curves), len(model.parameters)
    trust = Trust(
        drift=run.drift, drift_angle=run.drift_angle, energy_balance=run.balance, energy_share=run.share, t_end=run.t,
        horizon=reach, stopped=bool(run.message), notes=(*model.start.notes, *notes),
    )  # fmt: skip
    stats = {"steps": run.steps, "rejected": run.rejected, "switchings": run.switched}
    if run.interrupted:
        stats["interrupted"] = True
    n = len(run.values)
    nearby, unread = _nearby(asked, run, reach)
    trust = replace(trust, notes=(*trust.notes, *unread))
    values, derivatives = np.array(run.values).reshape(n, count), np.array(run.derivatives).reshape(n, count, k)
    if isinstance(run, ContactMotion):
        own = {name: (values[:, c], derivatives[:, c]) for c, name in enumerate(curves)}
        values, derivatives, more = with_contacts(asked.outputs, asked.of_contacts, run, reach, own)
        units |= {name: reduction.unit for name, reduction in asked.of_contacts.items()}
        trust = replace(trust, notes=(*trust.notes, *more))
    return Found(
        values, derivatives, trust, stats, run.message, {"method": "dop853", "rtol": asked.rtol, "atol": asked.atol},
        nearby,
    ), units  # fmt: skip


def _nearby(asked: Asked, run: Motion, reach: float) -> tuple[Nearby | None, list[str]]:
    """How numbers of the whole run change, if some are asked for and it comes to its end, and notes on what is lacking.

    An event at an instant that one number reads off leaves the others, which do not.
    """
    grazed = isinstance(run, ContactMotion) and run.grazed < run.t
    if asked.read_off is None or run.message or grazed or reach < run.t:
        return None, []
    notes: list[str] = []
    for kept in (asked.read_off, np.array([0.0, run.t])):
        try:
            return Nearby.of(run, kept), notes
        except TraceError as error:
            notes = list(dict.fromkeys([*notes, str(error).removeprefix("no sensitivities: ")]))
    return None, notes


def _growth_notes(asked: Asked, run: Motion) -> tuple[list[str], float]:
    """Notes on exponential growth, and the time up to which curves can be trusted [s]."""
    t = np.array([moment[0] for moment in run.history])
    if len(t) < 2:
        return [], run.t
    sizes, notes = np.array([moment[1] for moment in run.history]), []
    for name, size in zip(asked.parameters.names, sizes.T, strict=True):
        growing = growth(t, size)
        if growing is None:
            continue
        change = usual_change(asked.model.system, name)
        until = linear_until(t, size, change["size"])
        reach = f"linearly only until about t = {until:.2g} s" if until < t[-1] else "linearly over the whole run"
        notes.append(
            f"sensitivities to {name} grow tenfold every {growing.tenfold:.2g} s: a change of {name} by"
            f" {change['words']} acts {reach}"
        )
    return notes, horizon(t, sizes, asked.parameters.values, asked.rtol)


def _kinematics(asked: Asked, forces: bool = False) -> tuple[Found, dict[str, str]]:
    model = asked.model
    nominal = analyse(model.system, model.start, asked.t_eval, forces=forces)
    curves, units = asked.curves({name: curve for name, curve in model.curves.items() if name in nominal.stored})
    compiled = MachineFunctions()
    driven = Driven(model, counted(model, asked.parameters), curves, compiled.add)
    compiled.compile()
    bodies = list(model.system.bodies)
    instants = [driven.at(float(t), *positions(nominal, bodies, k)) for k, t in enumerate(nominal.t)]
    trust = nominal.trust
    return _checked(asked, nominal, instants, trust), units


def _inverse_dynamics(asked: Asked) -> tuple[Found, dict[str, str]]:
    return _kinematics(asked, True)


def _equilibrium(asked: Asked) -> tuple[Found, dict[str, str]]:
    model, t_eval = asked.model, asked.t_eval
    notes: tuple[str, ...] = ()
    if len(t_eval) == 1:
        first = equilibria(model.system, float(t_eval[0])).first_at(float(t_eval[0]))
        nominal, notes = first.result, (f"the equilibrium is {first}",)
        neutral = np.array([bool(first.neutral)])
    else:
        nominal = quasistatic(model.system, t_eval)
        neutral = nominal["equilibrium.stiffness"] == 0.0
    rest = record_rest(model)
    curves, units = asked.curves({name: curve for name, curve in rest.curves.items() if name in nominal.stored})
    compiled = MachineFunctions()
    at_rest = AtRest(model, counted(model, asked.parameters), rest, curves, compiled.add)
    compiled.compile()
    bodies = list(model.system.bodies)
    instants = []
    for k, t in enumerate(nominal.t):
        q = np.array([nominal[f"{body}.{key}"][k] for body in bodies for key in ("x", "y", "angle")])
        values, derivatives, sound = at_rest.at(float(t), q)
        instants.append((values, derivatives, sound and not neutral[k]))
    answer = _checked(asked, nominal, instants, nominal.trust)
    answer.trust = replace(answer.trust, notes=(*answer.trust.notes, *notes))
    return answer, units


Finding = Callable[[Asked], tuple[Found, dict[str, str]]]
FIND: dict[str, Finding] = {
    "simulate": _simulate, "kinematics": _kinematics, "inverse-dynamics": _inverse_dynamics,
    "equilibrium": _equilibrium,
}  # fmt: skip


def _checked(asked: Asked, nominal: Result, instants: list[tuple[np.ndarray, np.ndarray, bool]], trust: Trust) -> Found:
    """What was found at every instant of the analysis itself, as far as it agrees with it and is sound."""
    count, k = len(asked.outputs), len(asked.model.parameters)
    values = np.array([instant[0] for instant in instants]).reshape(-1, count)
    derivatives = np.array([instant[1] for instant in instants]).reshape(-1, count, k)
    sound = np.array([instant[2] for instant in instants], dtype=bool) & np.isfinite(derivatives).all(axis=(1, 2))
    message = nominal.message
    if not sound.all():
        end = int(np.argmin(sound))
        values, derivatives = values[:end], derivatives[:end]
        message = (
            f"no derivatives at t = {nominal.t[end]:.6g} s: the position is singular or free to change there, or a load"
            " or expression has no finite value or derivative"
        )
    for n, name in enumerate(asked.outputs):
        want = nominal[name][: len(values)]
        scale = max(np.abs(want).max(initial=0.0), _typical(asked, nominal, name))
        if (np.abs(values[:, n] - want) > SAME * scale).any():
            raise TraceError(f"no sensitivities: the recorded '{name}' differs from the analysis; a fault of rattle")
    nearby = None if message else Nearby(nominal.t, np.zeros((len(values), k)), values, derivatives)
    return Found(values, derivatives, trust, {"positions": len(values)}, message, nearby=nearby)


def _typical(asked: Asked, nominal: Result, name: str) -> float:
    """The largest value of the curves of the same unit [SI]."""
    unit = nominal.unit(name)
    same = [name for name in nominal.stored if nominal.unit(name) == unit]
    return max((float(np.nanmax(np.abs(nominal[name]), initial=0.0)) for name in same), default=0.0) or STILL


# ---------------------------------------------------------------- the result
def _result(asked: Asked, analysis: str, answer: Found, units: Mapping[str, str]) -> Result:
    model, n = asked.model.system.model, len(answer.values)
    names, columns = list(asked.outputs), [answer.values[:, c] for c in range(len(asked.outputs))]
    all_units = {name: units[name] for name in names}
    changes = {name: usual_change(asked.model.system, name) for name in asked.model.parameters}
    for c, output in enumerate(asked.outputs):
        for k, parameter in enumerate(asked.model.parameters):
            name = derivative_name(output, parameter)
            names.append(name)
            columns.append(answer.derivatives[:, c, k])
            all_units[name] = quotient(units[output], model.parameters[parameter].unit)
    return build_result(
        model, "sensitivity", t=asked.t_eval[:n], data=np.array(columns).T.reshape(n, len(names)), names=names,
        units=all_units, trust=answer.trust, stats=answer.stats, message=answer.message, drawn=False,
        settings={"of": list(asked.outputs), "changes": changes, "along": analysis, **answer.settings},
    )  # fmt: skip
