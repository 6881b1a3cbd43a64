"""The analyses of which samples may be asked: which names their results have, and how one is run.

| analysis | names inside of outputs |
|---|---|
| simulate, kinematics, inverse-dynamics, equilibrium | those of its result |
| accuracy | of a result of inverse-dynamics with .nominal .low .high .worst .rss: "max(rocker.angle.high)" |
| modes | mode1.frequency [Hz], mode1.damping, mode1.growth [1/s], mode2 ... |
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rattle.analyses.dynamics.methods import contacts_of
from rattle.errors import InputError, SolverError, suggest
from rattle.question import Question, analysis_names, questions
from rattle.registry import kinds
from rattle.results.build import build_result
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.solvers.stepper import FREE
from rattle.trace.lane_program import MOST_STEPS

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

WRITTEN_AS = {"play": "accuracy", "inverse_dynamics": "inverse-dynamics"}


class Stepping(NamedTuple):
    """How motions are integrated."""

    method: str | None
    rtol: float
    atol: float
    step: float | None  # [s]


Run = Callable[["Mechanism", np.ndarray, Collection[str], Stepping], Result]


class Analysis(NamedTuple):
    """An analysis of a mechanism at increasing instants [s]."""

    run: Run  # of a mechanism, at instants (n,) [s], for these names
    names: Callable[[Mechanism], dict[str, str]]  # of its results, with their SI units
    points: int  # intervals between instants where outputs need whole curves
    at_rest: bool = False  # its instants are t = 0 alone, unless an end is given


def analysis_named(name: str) -> str:
    """The analysis of this name.  Raises InputError."""
    written = WRITTEN_AS.get(str(name), str(name))
    if written not in analysis_names():
        raise InputError(f"unknown analysis '{name}'{suggest(str(name), analysis_names())}")
    return written


def complete(result: Result) -> Result:
    """A result that came to its end.  Raises SolverError."""
    if not result.success:
        raise SolverError(result.message, result)
    return result


def steps_at_most(m: Mechanism, how: Stepping) -> int | None:
    """Steps after which a sample is given up, so that one does not hold up all others; None: no limit.

    Without contacts only a motion that is not credible needs so many steps that follow the tolerances.
    """
    follow = how.method is None or kinds("stepper")[how.method].leaf.adaptive
    return MOST_STEPS if follow and contacts_of(m.system) == FREE else None


def given_up(most: int) -> str:
    """What is said of a sample that takes too many steps."""
    return f"takes more than {most} steps: its motion is not credible; simulate it alone to see why"


def table_of(m: Mechanism, analysis: str, times: np.ndarray, data: np.ndarray, units: dict[str, str]) -> Result:
    """Numbers (n, k) of an analysis at instants (n,) [s] as a result."""
    trust = Trust(drift=0.0, t_end=float(times[-1]))
    return build_result(m.model, analysis, t=times, data=data, names=units, units=units, trust=trust, drawn=False)


def names_from(run: Run) -> Callable[[Mechanism], dict[str, str]]:
    """Names from the result of a run at t = 0."""

    def names(m: Mechanism) -> dict[str, str]:
        result = run(m, np.zeros(1), (), Stepping("", 0.0, 0.0, None))
        return {name: result.unit(name) for name in result.names}

    return names


def over_times(ask: Callable[[Mechanism, np.ndarray], Result], points: int, at_rest: bool = False) -> Analysis:
    """An analysis that makes curves at instants (n,) [s]; ask: of a mechanism.  Raises SolverError if it ends early."""

    def run(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
        return complete(ask(m, times))

    return Analysis(run, names_from(run), points, at_rest)


# ---------------------------------------------------------------- all of them
@functools.cache
def analysis_of(name: str) -> Analysis:
    """The analysis of a name, one of `analysis_names`: that of its question's folder, or the numbers of its answer."""
    asked = next(question for question in questions().values() if question.written == name)
    part = asked.part("samples")
    return _of_numbers(asked) if part is None else part.ANALYSIS


def _of_numbers(asked: Question) -> Analysis:
    """The numbers that a question answers, as curves that stay the same."""

    def run(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
        numbers = asked.answer(m).numbers
        data = np.tile([number.value for number in numbers.values()], (len(times), 1))
        return table_of(m, asked.written, times, data, {name: number.unit for name, number in numbers.items()})

    return Analysis(run, names_from(run), 1, at_rest=True)
