"""Samples of a smooth mechanism side by side, as straight-line machine code: compiled once, run batch by batch.

Where drivers determine every position, kinematics and inverse dynamics have the curves of a motion in time: every step
ends on the constraints, those of the drivers among them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from rattle.analyses.straight_line.lane_model import Asked, lane_model, needs_short_steps, why_not_lanes
from rattle.analyses.straight_line.machine_code import MachineFunctions
from rattle.analyses.straight_line.recorded_model import BESIDE, RecordedModel
from rattle.analyses.straight_line.starts import Starts
from rattle.description.model import within_limits
from rattle.errors import TraceError
from rattle.jit import layout as at
from rattle.language import arrays
from rattle.language.local_function import LocalFunction
from rattle.language.syntax import names
from rattle.registry import kinds
from rattle.results.contact_summary import TOWERS
from rattle.solvers.stepper import FREE, LONGEST, tableau_of, usual_stepper
from rattle.studies.runs.analyses import given_up, steps_at_most
from rattle.studies.runs.task import Task
from rattle.trace import lane_methods, lanes
from rattle.trace.copying import bind
from rattle.trace.elementary import lower
from rattle.trace.lane_batch import Tallies
from rattle.trace.lane_control import SHORT, Status
from rattle.trace.lane_program import MOST_STEPS, Program
from rattle.trace.lane_strobe import Strobe
from rattle.trace.reductions import EXTREMES

MOST_OPERATIONS = 20_000  # of right-hand side, projection and curves; beyond, machine code is slow to make
DRIVEN = ("kinematics", "inverse-dynamics")  # a motion that drivers determine: its integral is put on the constraints
EVENT_DRIVEN = "event"  # the method of models with rigid contacts: steps of the usual one, which end at events
MAY_TOWER = 0.5  # share of what is too high above the mean, as what is usual may be less than that


class Together(NamedTuple):
    """What became of n samples."""

    values: np.ndarray  # (outputs, n) [SI], nan where `open`
    open: np.ndarray  # (n,) samples for which this cannot vouch
    messages: dict[int, str]  # of those among them that no other program need try, by their place
    reasons: dict[str, int]  # why not the others, and how many
    steps: int
    tallies: Tallies


class SideBySide:
    """Straight-line code for all samples of a task.

    Raises TraceError, with the reason, where there is none.
    """

    def __init__(self, task: Task, span: float | None = None) -> None:
        """span: time beside which steps are short that miss nothing [s]; the whole run, if not given."""
        self.task, self._span = task, task.t_end if span is None else span
        usual = task.analysis in DRIVEN or task.how.method in (None, EVENT_DRIVEN)
        self._method = usual_stepper(FREE) if usual else str(task.how.method)
        _require_lanes(task, self._method)
        self.model = self._recorded()
        follow = {*task.names, *self.model.dependent}
        if why := next((why for output in task.outputs if (why := why_not_lanes(output, dict.fromkeys(follow)))), ""):
            raise TraceError(why)
        size = self.model.graph.count([*self.model.derivative, *self.model.projection])
        if size > MOST_OPERATIONS:
            raise TraceError(
                f"its {size} operations are more than the {MOST_OPERATIONS} up to which straight-line code pays"
            )
        self.asked = Asked(self.model, task.outputs)
        self.program = _program(self.model, self.asked, task, self._method, self._span)

    def _recorded(self, beside: float = 0.0, crowded: bool = False) -> RecordedModel:
        system = self.task.mechanism.system
        contact, dry = system.arrays["contact"], system.arrays["dry"]
        rubs = (dry[:, at.DRY_LAW] < 0) | (dry[:, at.DRY_STATES] > 0)
        touches = len(contact) > 0 or bool(rubs.any()) or bool(system.switches)
        return self.task.mechanism.recorded(list(self.task.names), contacts=touches, beside=beside, crowded=crowded)

    @cached_property
    def _careful(self) -> Program | None:
        """The program for samples that come nearer to singular positions, whose equations it solves more exactly."""
        return self._other(self._recorded(beside=BESIDE))

    @cached_property
    def _crowded(self) -> Program | None:
        """The program for samples that come to more contacts at once."""
        are = None if self.model.contacts is None else self.model.contacts.are
        return self._other(self._recorded(crowded=True)) if are is not None and are.may_crowd else None

    def _other(self, model: RecordedModel) -> Program | None:
        """The same for another record of the model; None if it is asked for otherwise there."""
        asked = Asked(model, self.task.outputs)
        same = asked.reductions == self.asked.reductions and asked.rows == self.asked.rows
        return _program(model, asked, self.task, self._method, self._span) if same else None

    def _outcome(self, values: np.ndarray, threads: int, progress: Callable[[int, int], None] | None) -> lanes.Outcome:
        """Samples side by side; those that come next to a singular position again, by the careful program, and those
        that come to many contacts at once."""
        outcome = lanes.run(self.program, values, threads=threads, progress=progress)
        for status in (Status.ASSUMPTION, Status.CROWDED):
            left = np.flatnonzero(outcome.status == status)
            if not len(left):
                continue
            program = self._careful if status == Status.ASSUMPTION else self._crowded
            if program is None:
                continue
            again = lanes.run(program, values[:, left], threads=min(threads, len(left)))
            outcome.values[:, left], outcome.status[left], outcome.steps[left] = again.values, again.status, again.steps
            outcome = outcome._replace(tallies=outcome.tallies.plus(again.tallies))
        return outcome

    def run(self, values: np.ndarray, threads: int = 1, progress: Callable[[int, int], None] | None = None) -> Together:
        """Samples with values (k, n) [SI] of the parameters that differ."""
        outcome = self._outcome(values, threads, progress)
        dependent = _dependent(self.model, self.task, values)
        beyond = self._beyond(values, dependent)
        rows = [[outcome.values[k] for k in places] for places in self.asked.rows]
        computed = [self._output(n, reduced, values, dependent) for n, reduced in enumerate(rows)]
        failed = outcome.status != Status.DONE
        towers = ~failed & self._towering(outcome.values)
        most = steps_at_most(self.task.mechanism, self.task.how) if self.task.analysis == "simulate" else None
        endless = (outcome.status == Status.TOO_MANY_STEPS) & (most is not None)
        reasons = {}
        for status in np.unique(outcome.status[failed & ~endless]):
            reasons[Status(int(status)).words] = int((outcome.status == status).sum())
        if (count := int((beyond & ~failed).sum())) > 0:
            reasons["beyond the limits of a parameter"] = count
        if towers.any():
            reasons["a force may tower with a rigid contact, which only a run alone tells"] = int(towers.sum())
        failed |= towers
        outputs = np.where(failed | beyond, np.nan, np.array(computed))
        messages = dict.fromkeys(np.flatnonzero(endless & ~beyond).tolist(), given_up(most or 0))
        return Together(outputs, failed | beyond, messages, reasons, int(outcome.steps.sum()), outcome.tallies)

    def strobe(self, values: np.ndarray, times: np.ndarray) -> Strobe:
        """Samples with values (k, n) [SI] of the parameters that differ, to be seen at times (n, p) [s] of their own.

        Raises TraceError where what is asked for may be a force that towers with a rigid contact.
        """
        if self.asked.forces:
            raise TraceError("forces may tower with rigid contacts, which only runs alone tell")
        return Strobe(self.program, values, times)

    def _towering(self, values: np.ndarray) -> np.ndarray:
        """(n,) samples in which the largest force of a joint with a rigid contact is far above what is usual."""
        towering = np.zeros(values.shape[1], dtype=bool)
        for most, usual in self.asked.forces.values():
            towering |= values[most] > MAY_TOWER * TOWERS * values[usual]
        return towering

    def _beyond(self, values: np.ndarray, dependent: Mapping[str, np.ndarray]) -> np.ndarray:
        """(n,) samples with a parameter beyond its limits, which the reader of the model refuses."""
        beyond = np.zeros(values.shape[1], dtype=bool)
        parameters = {**dependent, **dict(zip(self.task.names, values, strict=True))}
        for name, parameter in self.task.mechanism.model.parameters.items():
            if name in parameters:
                beyond |= ~np.asarray(within_limits(np.asarray(parameters[name]), parameter.minimum, parameter.maximum))
        return beyond

    def _output(
        self, n: int, rows: Sequence[np.ndarray], values: np.ndarray, dependent: Mapping[str, np.ndarray]
    ) -> np.ndarray:
        """An output of all samples from the values of its reductions; dependent: parameters (n,) that follow [SI]."""
        task = self.task
        numbers = {**task.mechanism.parameters, **dependent, **dict(zip(task.names, values, strict=True))}
        numbers |= {f"#{k}": row for k, row in enumerate(rows)}
        output = arrays.evaluate(task.outputs[n].outer, numbers.__getitem__)
        return np.where(np.isfinite(rows).all(axis=0) & np.isfinite(output), output, np.nan)


def _require_lanes(task: Task, method: str) -> None:
    """Raise TraceError for what is known to have no straight-line code before anything is recorded."""
    if task.histories:
        raise TraceError("whole curves are kept")
    if task.analysis not in ("simulate", *DRIVEN):
        raise TraceError(f"{task.analysis} runs position by position")
    if why := next((why for output in task.outputs if (why := why_not_lanes(output, dict.fromkeys(task.names)))), ""):
        raise TraceError(why)
    tableau = tableau_of(kinds("stepper")[method])
    if tableau is None:
        raise TraceError(f"'{task.how.method}' has no straight-line code")
    _require_smooth_joints(task)
    _require_followed(task, tableau.adaptive)
    if task.mechanism.system.switches and not tableau.adaptive:
        switching = ", ".join(sorted({switch.name for switch in task.mechanism.system.switches}))
        raise TraceError(f"steps of equal length do not end where expressions switch ({switching})")


def _require_smooth_joints(task: Task) -> None:
    """Raise TraceError where largest values are asked for and curves may jump inside of steps."""
    extreme = any(reduction.kind in EXTREMES for output in task.outputs for reduction in output.reductions)
    for name, joint in task.mechanism.model.joints.items() if extreme else ():
        if any(isinstance(field, LocalFunction) and field.switches for field in joint.fields.values()):
            raise TraceError(f"curves may jump where the function of the joint '{name}' switches (abs, if, a table)")


def _require_followed(task: Task, adaptive: bool) -> None:
    """Raise TraceError for contacts that lanes cannot follow."""
    system = task.mechanism.system
    curves = {name for output in task.outputs for name in output.names}
    for entry, lever in zip(system.arrays["contact"], system.arrays["lever"], strict=True):
        joint = system.joints[entry[at.OWNER]]
        if not adaptive:
            raise TraceError(f"steps of equal length do not end at contacts (joint {joint})")
        if lever[at.ONE_WAY] > 0.0 and f"{joint}.gap" in curves:
            raise TraceError(f"the gap of a segment (joint {joint}) is not followed beyond its ends")


def _program(model: RecordedModel, asked: Asked, task: Task, method: str, span: float) -> Program:
    functions, how, tableau = MachineFunctions(), task.how, tableau_of(kinds("stepper")[method])
    assert tableau is not None, "others have no straight-line code, see `_require_lanes`"
    longest = span / SHORT if needs_short_steps(task.outputs, model) else np.inf
    program = Program(
        lane_model(model, asked, functions.add, Starts(model, functions.add)), functions.add,
        lane_methods.Method(tableau), asked.reductions, task.t_end,
        tolerances=lane_methods.Tolerances(how.rtol, how.atol, min(how.step or np.inf, longest)),
        step=min(how.step or LONGEST, longest), short=span / SHORT, chain=functions.chain, tiled=True,
        most_steps=steps_at_most(task.mechanism, how) or MOST_STEPS,
    )  # fmt: skip
    functions.compile()
    return program


def _dependent(model: RecordedModel, task: Task, values: np.ndarray) -> dict[str, np.ndarray]:
    """Values (n,) [SI] of parameters that follow from those that differ (k, n): outside of reductions, or limited."""
    limited = {
        name
        for name, parameter in task.mechanism.model.parameters.items()
        if (parameter.minimum, parameter.maximum) != (None, None)
    }
    asked = {name for output in task.outputs for name in names(output.outer)}
    used = sorted((asked | limited) & model.dependent.keys())
    if not used:
        return {}
    graph, symbols = lower(model.graph, [model.dependent[name] for name in used])
    first = 1 + model.state_size  # after t and y
    chosen = range(first, first + len(task.names))
    others = {place: 0.0 for n, place in enumerate(graph.inputs) if n not in chosen}  # no parameter follows from them
    graph, symbols = bind(graph, symbols, others)
    return dict(zip(used, graph.evaluate(symbols, list(values)), strict=True))
