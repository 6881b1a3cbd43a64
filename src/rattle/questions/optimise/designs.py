"""Designs: values of the parameters, what a run makes of them, and how that changes with the parameters.

With y the curves of a run and F an output, a functional of curves and parameters,

    dF/dp_k = lim (F[y + h dy/dp_k, p + h e_k] - F[y - h dy/dp_k, p - h e_k])/(2 h)

dy/dp is exact, on both sides of events too (see `sensitivity.nearby`); only F, which needs no run, is differenced.
Where there is no dy/dp, whole runs are differenced; both are counted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.errors import AssemblyError, ModelError, SolverError, TraceError
from rattle.questions.optimise.asked import RTOL, Question
from rattle.questions.optimise.squares import Square, is_root, squares
from rattle.questions.sensitivity.nearby import Nearby
from rattle.questions.sensitivity.numbers import difference, instants_of, moved_result
from rattle.questions.sensitivity.repeated import RepeatedSensitivities
from rattle.results.contact_summary import no_number
from rattle.results.evaluation import evaluate, unread_curves
from rattle.results.reductions import Output
from rattle.results.result import Result
from rattle.solvers.stepper import ATOL
from rattle.studies.runs.reasons import alike

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

STEP = 1e-5  # of differences of an output, as a share of the range of a parameter, but
OF_VALUE = 1e-3  # no more than this share of its value: ranges over decades reach past poles at 0, as of 4/x
LEAST_STEP = 1e-7  # share of the range below which rounding counts more than that
RUN_STEP = {"simulate": 1e-4}  # of differences of whole runs, whose errors are larger
RUN_STEP_DRIVEN = 1e-6  # the same for driven positions, exact to rounding
DOUBT = 1e-8  # errors of parts of a sum of squares, as a share of their changes over the ranges, at most
REMEMBERED = 8  # designs whose runs are kept
Numbers = Callable[[Result, Mapping[str, float], Result | None], Any]  # of a run, its parameters, the run without play


class LostError(Exception):
    """No derivatives at a design: designs beside it cannot be evaluated."""


@dataclass(frozen=True, eq=False)
class Run:
    """What was run for a design."""

    mechanism: Mechanism
    result: Result
    ideal: Mechanism | None  # without play, where the outputs ask for it
    ideal_result: Result | None

    def apply(self, numbers: Numbers) -> Any:
        """Numbers of the run."""
        return numbers(self.result, self.mechanism.parameters, self.ideal_result)


@dataclass(eq=False)
class Design:
    """A design and its numbers."""

    x: np.ndarray  # (k,) places of the parameters between their bounds
    message: str = ""  # why it has no numbers
    run: Run | None = None
    numbers: np.ndarray = field(default_factory=lambda: np.zeros(0))  # objective, then margins [SI]
    slopes: np.ndarray | None = None  # (1 + m, k) their derivatives by x
    parts: tuple[np.ndarray, np.ndarray] | None = None  # parts of a sum of squares, and their derivatives by x

    @property
    def ran(self) -> Run:
        """The run of a design that could be evaluated."""
        assert self.run is not None
        return self.run

    @property
    def sound(self) -> bool:
        """True if it could be evaluated."""
        return not self.message


class Designs:
    """Evaluates designs of one problem, the last few once only."""

    def __init__(self, question: Question, before: Designs | None = None) -> None:
        """before: whose counts go on."""
        self.question = question
        self.squares: list[Square] = squares(question.objective) or []
        self.runs = self.derived = 0  # designs that were run, and how many of them with derivatives
        self.failures: dict[str, int] = {}  # why designs could not be evaluated
        self.differenced: dict[str, int] = {}  # why whole runs were differenced, and at how many designs
        self._known: dict[bytes, Design] = {}
        self._exact: list[RepeatedSensitivities | None] | None = None  # of the mechanism, and of that without play
        self._why_not = ""
        if before is not None:
            self.runs, self.derived = before.runs, before.derived
            self.failures, self.differenced = before.failures, before.differenced
        self.on_run: Callable[[], None] = lambda: None

    def at(self, x: np.ndarray) -> Design:
        """The design at x (k,)."""
        place = np.clip(x, 0.0, 1.0)
        key = place.tobytes()
        if key not in self._known:
            self._known[key] = self._evaluated(place)
            if len(self._known) > REMEMBERED:
                del self._known[next(iter(self._known))]
        return self._known[key]

    def _evaluated(self, x: np.ndarray) -> Design:
        question = self.question
        self.runs += 1
        self.on_run()
        design = Design(x)
        try:
            m = question.mechanism.neighbour(question.values(x))
            result = _whole(question.run(m))
            ideal = m.ideal() if question.ideal_curves else None
            design.run = Run(m, result, ideal, None if ideal is None else _whole(question.run(ideal)))
            design.numbers = design.run.apply(self._numbers)
            bad = [output for output, x in zip(question.outputs, design.numbers, strict=True) if not np.isfinite(x)]
            why = design.message = _no_value(bad[0], result) if bad else ""
        except ModelError as error:
            why, design.message = str(error.problems[0]), str(error)
        except (AssemblyError, SolverError) as error:
            why = design.message = str(error)
        if design.message:
            self.failures[alike(why)] = self.failures.get(alike(why), 0) + 1
        return design

    def _numbers(self, result: Result, parameters: Mapping[str, float], ideal: Result | None) -> np.ndarray:
        return np.array([evaluate(output, result, parameters, ideal) for output in self.question.outputs])

    # ---------------------------------------------------------------- derivatives
    def slopes(self, design: Design) -> np.ndarray:
        """(1 + m, k) derivatives of objective and margins by x.  Raises LostError."""
        if design.slopes is None:
            design.slopes = self._slopes(design, self._numbers, self.question.is_between)
        return design.slopes

    def parts(self, design: Design) -> tuple[np.ndarray, np.ndarray]:
        """Parts r (n,) of the sum of squares, and derivatives (n, k) by x.  Raises LostError."""
        if design.parts is None:
            raw = design.ran.apply(self._raw)
            slopes = self._slopes(design, lambda *arguments: np.concatenate(self._raw(*arguments)), False)
            split = np.split(slopes, np.cumsum([len(part) for part in raw])[:-1])
            pairs = list(zip(self.squares, raw, split, strict=True))
            design.parts = (
                np.concatenate([square.residual(x) for square, x, _ in pairs]),
                np.concatenate([square.slope(x, dx) for square, x, dx in pairs]),
            )
        return design.parts

    def doubt(self, design: Design) -> float:
        """A sum of squares, or its root, below which it is as good as zero: its parts are errors of runs; else 0."""
        error = DOUBT * self._steepness(design)
        return error if self.is_root else error**2

    def gradient_doubt(self, design: Design) -> float:
        """Errors of the gradient of a sum of squares (of the square of a root) by those of its parts; else 0."""
        return 2.0 * DOUBT * self._steepness(design) ** 2

    def by_squares(self, design: Design) -> bool:
        """True if the objective is a sum of squares whose parts are the same in every design.

        Parts of a whole curve have their places between outputs; impacts come at other instants in every design.
        """
        return self._has_parts(design) and not self.question.constraints

    def _has_parts(self, design: Design) -> bool:
        curves = any(square.form == "curve" for square in self.squares)
        jumps = design.ran.result.breaks is not None
        return bool(self.squares) and not (curves and jumps)

    @property
    def is_root(self) -> bool:
        """True for the root of a sum of squares."""
        return is_root(self.question.objective)

    def _steepness(self, design: Design) -> float:
        """Size |J| of the changes of the parts over the ranges; 0 for what is no sum of squares."""
        try:
            return float(np.linalg.norm(self.parts(design)[1])) if self._has_parts(design) else 0.0
        except LostError:
            return 0.0

    def residuals(self, design: Design) -> np.ndarray:
        """Parts r (n,) of the sum of squares."""
        raw = design.ran.apply(self._raw)
        return np.concatenate([square.residual(x) for square, x in zip(self.squares, raw, strict=True)])

    def _raw(self, result: Result, parameters: Mapping[str, float], ideal: Result | None) -> list[np.ndarray]:
        return [square.raw(result, parameters, ideal) for square in self.squares]

    def _slopes(self, design: Design, numbers: Numbers, between: bool) -> np.ndarray:
        """between: whether numbers may be of other instants than those of the run."""
        self.derived += 1
        try:
            slopes = self._exact_slopes(design, numbers, between)
        except (TraceError, AssemblyError) as error:
            why = alike(str(error).removeprefix("no sensitivities: "))
            self.differenced[why] = self.differenced.get(why, 0) + 1
            slopes = self._difference_slopes(design, numbers)
        if not np.isfinite(slopes).all():
            raise LostError("an output has no finite derivative")
        return slopes

    def _exact_slopes(self, design: Design, numbers: Numbers, between: bool) -> np.ndarray:
        """(n, k) from the derivatives of the curves.  Raises TraceError."""
        question, run = self.question, design.ran
        asked = ((run.mechanism, question.curves), (run.ideal, question.ideal_curves))
        exact = self._sensitivities(asked)
        t, read_off = question.needed_times(run.mechanism), question.read_off(run.mechanism) if between else None
        curves: list[tuple[list[str], Nearby] | None] = [None] * len(asked)
        for place, ((m, names), derivatives) in enumerate(zip(asked, exact, strict=True)):
            if derivatives is not None and m is not None:
                curves[place] = names, derivatives.at(m.system, m.start, t, read_off)
        read = instants_of(question.outputs, run.mechanism.parameters)
        width, rows, geometry = question.width, [], run.result.geometry
        for k, name in enumerate(question.names):
            beside: dict[int, np.ndarray] = {}
            step = min(STEP, max(LEAST_STEP, OF_VALUE * abs(run.mechanism.parameters[name]) / width[k]))
            step = min([step, *(c[1].reach(k) / width[k] for c in curves if c is not None)])
            after = instants_of(question.outputs, question.moved(run.mechanism, name, step * width[k]))
            step *= min([1.0, *(c[1].passes_none(read, after) for c in curves if c is not None)])
            for n in (1, -1, 0, 2, -2):
                if n == 0 and len(beside) == 2:
                    break
                h = n * step * width[k]
                moved = [c if c is None else moved_result(c[0], geometry, *c[1].moved(k, h)) for c in curves]
                main = moved[0] if moved[0] is not None else moved_result([], geometry, t, np.zeros((len(t), 0)))
                with suppress(ValueError):  # an instant that moved out of the run
                    beside[n] = numbers(main, question.moved(run.mechanism, name, h), moved[1])
            rows.append(difference(beside, step))
        return np.ascontiguousarray(np.array(rows).T)

    def _sensitivities(self, asked: Sequence[tuple[Mechanism | None, list[str]]]) -> list[RepeatedSensitivities | None]:
        """Derivatives of the curves asked for, recorded once.  Raises TraceError."""
        if self._why_not:
            raise TraceError(self._why_not)
        if self._exact is None:
            question = self.question
            if question.counts_events:
                raise TraceError("numbers of events, and impulses, have no derivatives")
            rtol = min(RTOL, question.mechanism.model.settings.rtol or RTOL)
            touches = question.follows_contacts
            try:
                self._exact = [
                    RepeatedSensitivities(
                        m.recorded(question.names, contacts=touches, lanes=False),
                        names,
                        question.analysis,
                        rtol,
                        ATOL * rtol,
                    )
                    if m is not None and (names or touches)
                    else None
                    for m, names in asked
                ]
            except TraceError as error:
                self._why_not = str(error)
                raise
        return self._exact

    def _difference_slopes(self, design: Design, numbers: Numbers) -> np.ndarray:
        """(n, k) from runs of designs nearby, within the bounds.  Raises LostError."""
        h = RUN_STEP.get(self.question.analysis, RUN_STEP_DRIVEN)
        here = design.ran.apply(numbers)
        columns = []
        for k in range(len(design.x)):
            beside: dict[int, np.ndarray] = {0: here}
            inside = [n for n in (1, -1, 2, -2) if 0.0 <= design.x[k] + n * h <= 1.0]
            for n in inside if len(inside) < 4 else (1, -1):
                beside |= self._beside(design, k, n, h, numbers)
            try:
                columns.append(difference(beside, h))
            except TraceError:
                raise LostError("the designs beside it cannot be evaluated") from None
        return np.ascontiguousarray(np.array(columns).T)

    def _beside(self, design: Design, k: int, n: int, h: float, numbers: Numbers) -> dict[int, np.ndarray]:
        """Numbers of the design n steps h away along x_k, by n; none if it has none."""
        x = design.x.copy()
        x[k] += n * h
        beside = self._evaluated(x)
        if not beside.sound:
            return {}
        values = beside.ran.apply(numbers)
        return {n: values} if np.isfinite(values).all() else {}


def _no_value(output: Output, result: Result) -> str:
    """Why an output of a run is no number, in words."""
    unread = unread_curves(output, result)
    return f"{output.text}: {no_number(unread[0])}" if unread else f"{output.text} has no finite value"


def _whole(result: Result) -> Result:
    """The result, if its run came to its end.  Raises SolverError."""
    if not result.success:
        raise SolverError(result.message, result)
    return result
