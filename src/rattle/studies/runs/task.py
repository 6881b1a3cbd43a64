"""What is asked of every sample of a mechanism: which analysis, to what end, and which numbers of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.dynamics.peak_values import peak_names
from rattle.errors import InputError, ModelError, Problem, suggest
from rattle.language.syntax import names
from rattle.registry import kinds
from rattle.results.columns import geometry
from rattle.results.contact_summary import no_number
from rattle.results.evaluation import evaluate, may_tower, missing_curves, needs_curve, unread_curves
from rattle.results.reductions import Known, Output, argument, meetings, needed_instants, read
from rattle.results.result import Result, UnknownName
from rattle.solvers.stepper import ATOL
from rattle.studies.runs.analyses import Stepping, analysis_named, analysis_of

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

RTOL = 1e-8  # of motions, unless given
HISTORY_POINTS = 201  # of a curve that is kept
PER_FLIGHT = 4  # instants between two events, on the average: a cubic needs four values
PER_TURN = 40  # instants in a turn of the body that turns most: cubics between them miss some 1e-5 of a curve
MOST_INSTANTS = 100_000  # of a run


class Sample(NamedTuple):
    """What became of one sample."""

    outputs: list[float]  # [SI], nan where one is not finite
    curves: np.ndarray  # (h, m) [SI]
    unread: tuple[str, ...] = ()  # why outputs are no numbers: forces of rigid contacts that tower


@dataclass(frozen=True, eq=False)
class Task:
    """What is asked of every sample."""

    mechanism: Mechanism
    names: tuple[str, ...]  # (k,) parameters that differ
    outputs: tuple[Output, ...]
    analysis: str  # one of `analysis_names`
    t_end: float  # [s]
    how: Stepping
    histories: tuple[str, ...] = ()  # (h,) names of curves that are kept
    history_units: tuple[str, ...] = ()  # (h,) their SI units
    towers: bool = False  # whether an output depends on a force that may tower with a rigid contact

    @property
    def texts(self) -> list[str]:
        """The outputs as they were asked for."""
        return [output.text for output in self.outputs]

    def mechanism_at(self, values: Sequence[float] | np.ndarray, told: bool = True) -> Mechanism:
        """The mechanism with values (k,) [SI] of the parameters that differ.  Raises ModelError.

        told: see `neighbour`.
        """
        by_name = dict(zip(self.names, map(float, values), strict=True))
        bad = next((name for name, value in by_name.items() if not math.isfinite(value)), "")
        if bad:
            raise ModelError([Problem(("parameters", bad), f"{by_name[bad]} is not a finite number")])
        return self.mechanism.neighbour(by_name, told)

    @property
    def history_times(self) -> np.ndarray:
        """(m,) instants [s] of the curves that are kept."""
        return np.linspace(0.0, self.t_end, HISTORY_POINTS if self.histories else 0)

    def run(self, values: Sequence[float] | np.ndarray) -> Sample:
        """What became of one sample with these values (k,) [SI].

        Raises ModelError, AssemblyError, SolverError with why it has none.
        """
        outputs, result = self.look(self.mechanism_at(values, told=False))
        places = np.searchsorted(result.t, self.history_times)
        curves = np.array([result[name][places] for name in self.histories])
        return Sample(outputs, curves.reshape(len(self.histories), len(places)), self.unread(result))

    def unread(self, result: Result) -> tuple[str, ...]:
        """Why outputs are no numbers, in words: forces tower with rigid contacts, or are left out all the time."""
        unread = [(output.text, unread_curves(output, result)) for output in self.outputs]
        missing = [(output.text, missing_curves(output, result)) for output in self.outputs]
        return (
            *(f"{text}: {no_number(curves[0])}" for text, curves in unread if curves),
            *(f"{text}: {curves[0]} is left out all the time" for text, curves in missing if curves),
        )

    def look(self, m: Mechanism, whole: bool = False) -> tuple[list[float], Result]:
        """The outputs [SI] of a mechanism, and the result from which they come.  Raises as `run`.

        whole: with the curves of all outputs, also of those that are known from within the steps of a run.
        """
        if late := next((output for words in self.outputs if (output := outside(words, m.parameters, self.t_end))), ""):
            raise ModelError([Problem((), late)])
        intervals = self._intervals(m, whole)
        times = self.instants(m, intervals)
        needed = {name for output in self.outputs for name in output.names} | {*self.histories}
        result = self.result(m, times, needed)
        if intervals > 1 and (finer := self._resolving(result)) > intervals:
            times = self.instants(m, finer)
            result = self.result(m, times, needed)
        needed = {name for output in self.outputs for name in output.ideal_names}
        ideal = self.result(m.ideal(), times, needed) if needed else None
        return [evaluate(output, result, m.parameters, ideal) for output in self.outputs], result

    def result(self, m: Mechanism, times: np.ndarray, needed: Iterable[str]) -> Result:
        """The analysis of a mechanism at instants (n,) [s]."""
        return analysis_of(self.analysis).run(m, times, frozenset(needed), self.how)

    def _intervals(self, m: Mechanism, whole: bool) -> int:
        """Intervals between instants of a run, unless bodies turn often: 1 where no curve is needed; see `look`.

        What is usual of a force that may tower is told by its curve, whatever else is asked for.
        """
        of_run = peak_names(m.system) if self.analysis == "simulate" and not whole else ()
        every = [reduction for output in self.outputs for reduction in output.reductions]
        needed = self.towers or any(needs_curve(reduction, of_run, m.model.joints) for reduction in every)
        return analysis_of(self.analysis).points if needed else 1

    def _resolving(self, result: Result) -> int:
        """Intervals that resolve the turns of the bodies in a result, and the flights between its events."""
        bodies = [f"{name}.angle" for name in self.mechanism.model.bodies]
        angles = [result[name] for name in bodies if name in result]
        turns = float(np.abs(np.diff(angles)).sum(axis=1).max(initial=0.0)) / (2.0 * math.pi) if angles else 0.0
        flights = 0 if result.breaks is None else len(result.breaks.t) // 2
        wanted = max(PER_TURN * turns, PER_FLIGHT * flights)
        return min(math.ceil(wanted), MOST_INSTANTS) if math.isfinite(wanted) else 1

    def instants(self, m: Mechanism, intervals: int) -> np.ndarray:
        """(n,) instants [s] of a run: start, end, those that are read off; a grid of `intervals` for whole curves."""
        read_off = {t for output in self.outputs for t in needed_instants(output, m.parameters)}
        grid = np.linspace(0.0, self.t_end, intervals + 1)
        return np.asarray(np.unique(np.concatenate([grid, list(read_off), self.history_times])))


def task_of(
    m: Mechanism, varied: Iterable[str], outputs: Sequence[str], *, analysis: str = "simulate",
    t_end: float | None = None, method: str | None = None, rtol: float | None = None, atol: float | None = None,
    step: float | None = None, histories: Sequence[str] = (),
) -> Task:  # fmt: skip
    """A checked task; varied: parameters that differ from sample to sample; histories: curves that are kept.

    Raises InputError, TypeError, ModelError, and what an analysis of the present mechanism raises.
    """
    texts = _texts(outputs)
    analysis, varying = analysis_named(analysis), tuple(varied)
    end = _end(m, varying, analysis, t_end, step)
    how = _stepping(m, method, rtol, atol, step)
    units = {name: parameter.unit for name, parameter in m.model.parameters.items()}
    of_model = geometry(m.model)
    vocabulary = Known(analysis_of(analysis).names(m), units, meetings(of_model) if analysis == "simulate" else {})
    asked = tuple(_read(text, vocabulary, analysis) for text in texts)
    if text := next((output.text for output in asked if not output.reductions), ""):
        raise InputError(f"outputs: {text!r} follows from parameters alone; ask for a number of a run")
    follow = m.following(varying)
    fixed = {name: value for name, value in m.parameters.items() if name not in follow}
    if late := next((words for output in asked if (words := outside(output, fixed, end))), ""):
        raise InputError(late)
    curves = _histories(histories, vocabulary, end)
    towers = analysis == "simulate" and bool(
        may_tower(asked, lambda k: vocabulary.units.get(k, ""), of_model["joints"])
    )
    return Task(m, varying, asked, analysis, end, how, tuple(curves), tuple(curves.values()), towers)


def _stepping(m: Mechanism, method: str | None, rtol: float | None, atol: float | None, step: float | None) -> Stepping:
    """How all runs are stepped: what is given, or else what the model says.  Raises InputError, TypeError."""
    settings = m.model.settings
    method = settings.method if method is None else method
    if method is not None and method not in kinds("stepper"):
        raise InputError(f"unknown method '{method}'; expected {' or '.join(kinds('stepper'))}")
    rtol = arguments.relative_tolerance(RTOL if rtol is None else rtol)
    atol = arguments.positive("atol", ATOL * rtol if atol is None else atol)
    return Stepping(method, rtol, atol, settings.step if step is None else arguments.positive("step", step))


def _texts(outputs: Sequence[str]) -> list[str]:
    """Outputs as a list of texts.  Raises InputError."""
    texts = [] if isinstance(outputs, str) else list(outputs)
    if not texts or not all(isinstance(text, str) for text in texts):
        raise InputError('outputs: expected a list such as ["max(abs(O3.normal))"]')
    return texts


def _histories(curves: Sequence[str], vocabulary: Known, end: float) -> dict[str, str]:
    """Units of the curves that are kept, by name.  Raises InputError, UnknownName."""
    if isinstance(curves, str):
        raise InputError(f'histories: expected a list of curves; write histories=["{curves}"]')
    for name in curves:
        if name not in vocabulary.units:
            raise UnknownName(f"histories: no curve '{name}'{suggest(str(name), vocabulary.units)}")
    if curves and not end > 0.0:
        raise InputError("histories: curves need t_end; give it")
    return {name: vocabulary.units[name] for name in curves}


def _end(m: Mechanism, varied: Sequence[str], analysis: str, t_end: float | None, step: float | None) -> float:
    """The end of all runs [s].  Raises InputError if it would differ from sample to sample."""
    at_rest = analysis_of(analysis).at_rest
    if at_rest and not t_end:
        return 0.0
    follow = m.following(varied)
    for key, value in (("t_end", t_end), ("step", step)):
        if value is None and (differ := sorted(m.names_in_setting(key) & follow)):
            raise InputError(
                f"{key} follows from {', '.join(differ)} and would differ from sample to sample; give {key}"
            )
    return arguments.positive("t_end", m.model.settings.t_end if t_end is None else t_end)


def _read(text: str, vocabulary: Known, analysis: str) -> Output:
    """An output, with a remark where another analysis may have the name."""
    try:
        return read(text, vocabulary)
    except ModelError as error:
        if analysis == "kinematics" and "no curve" in str(error):
            error.args = (f"{error}\n(kinematics has positions and rates only; 'inverse-dynamics' has forces too)",)
        raise


def outside(output: Output, parameters: Mapping[str, float], end: float) -> str:
    """What is said of an instant outside the run, "" if there is none; those of other parameters are not looked at."""
    for reduction in output.reductions:
        if (
            reduction.kind == "at"
            and reduction.argument is not None
            and set(names(reduction.argument)) <= parameters.keys()
        ):
            instant = argument(reduction, parameters)
            if not 0.0 <= instant <= end:
                return f"{output.text}: the instant {instant:g} s is not between 0 and t_end = {end:g} s"
    return ""
