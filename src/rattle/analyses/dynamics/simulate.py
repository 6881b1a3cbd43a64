"""Motion in time: a run from a consistent start, and its result with trust, statistics and provenance."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.events import require_workable
from rattle.analyses.dynamics.failure import PAST_END
from rattle.analyses.dynamics.horizon import agreement, tighter
from rattle.analyses.dynamics.methods import choose_stepper, new_run, note_choice
from rattle.analyses.dynamics.report import report
from rattle.analyses.dynamics.run import How
from rattle.analyses.law_check import law_faults
from rattle.equations.system import System
from rattle.errors import InputError, SolverError
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.registry import kinds
from rattle.results.columns import width
from rattle.results.result import Result
from rattle.solvers.stepper import ATOL, RTOL

log = logging.getLogger("rattle")

POINTS = 1000  # output intervals by default


def simulate(
    system: System, start: Assembled, *, t_end: float | None = None,
    t_eval: Sequence[float] | np.ndarray | None = None, method: str | None = None, rtol: float | None = None,
    atol: float | None = None, step: float | None = None, progress: bool = False, strict: bool = False,
    horizon: bool = False, most_steps: int | None = None,
) -> Result:  # fmt: skip
    """Integrate the equations of motion to t_end [s], with steps of at most `step` [s]; see `Mechanism.simulate`."""
    functions.start()
    settings = system.model.settings
    end, times = output_times(settings, t_end, t_eval)
    asked = _require_method(settings.method if method is None else method)
    rtol = arguments.relative_tolerance(_first_given(rtol, settings.rtol, RTOL))
    atol = arguments.positive("atol", _first_given(atol, settings.atol, ATOL * rtol))
    step = settings.step if step is None else step
    if step is not None:
        arguments.positive("step", step)
    arguments.require_room(len(times), width(system))
    require_workable(system)
    for fault in law_faults(system.model):
        log.warning(fault)
    stepper, step = choose_stepper(system, asked, step, end)
    how = How(stepper, rtol, atol, step)
    run = new_run(system, start, times, end, how)
    run.most_steps = _require_some(most_steps)
    run.notes = note_choice(system, asked, stepper)
    run.go(progress)
    second = None
    if horizon and run.tally[at.OUTPUTS] > 1 and not run.interrupted:
        second = new_run(system, start, times, end, _tighter(how))
        second.most_steps = None if most_steps is None else 10 * most_steps
        second.go(progress, "once more, tighter")
    result = report(run, None if second is None or second.interrupted else agreement(run, second))
    if run.interrupted:
        result.stats["interrupted"] = True
    elif second is not None and second.interrupted:
        result.stats["horizon_interrupted"] = True
    _require_success(result, strict)
    return result


def _require_method(asked: str | None) -> str | None:
    """The same method.  Raises InputError if there is none of this name."""
    steppers = kinds("stepper")
    if asked is not None and asked not in steppers:
        raise InputError(f"unknown method '{asked}'; expected {' or '.join(steppers)}")
    return asked


def _require_some(most_steps: int | None) -> int | None:
    """The same number.  Raises InputError if it is less than 1."""
    if most_steps is not None and most_steps < 1:
        raise InputError(f"most_steps must be at least 1, got {most_steps}")
    return most_steps


def _require_success(result: Result, strict: bool) -> None:
    """Log why a run failed, and raise SolverError if that is wanted."""
    if not result.success:
        log.error(result.message)
        if strict:
            raise SolverError(result.message, result)


def _tighter(how: How) -> How:
    """How a run is repeated that tells up to when the first is to be trusted."""
    fine = tighter(how.rtol, RTOL)
    finer = None if how.step is None else how.step / how.stepper.leaf.refinement
    return How(how.stepper, fine, how.atol * fine / how.rtol, finer)


def output_times(
    settings: Any, t_end: float | None, t_eval: Sequence[float] | np.ndarray | None
) -> tuple[float, np.ndarray]:
    """End of a run [s] and its output times (n,) [s], from the arguments and the model's settings.

    Raises InputError for times that are not increasing, negative or beyond the end, and for too many outputs.
    """
    if t_eval is not None:
        times = arguments.instants(t_eval)
        if (
            times.ndim != 1
            or len(times) == 0
            or not np.isfinite(times).all()
            or (np.diff(times) <= 0).any()
            or times[0] < 0
        ):
            raise InputError("t_eval must be increasing finite times in s, from 0 on")
        end = float(times[-1]) if t_end is None else arguments.positive("t_end", t_end)
        if times[-1] > end * PAST_END:
            raise InputError(f"t_eval goes to {times[-1]:g} s, beyond t_end = {end:g} s")
        return max(end, float(times[-1])), times
    end = arguments.positive("t_end", settings.t_end if t_end is None else t_end)
    interval = settings.output or end / POINTS
    count = max(1, round(end / interval))
    if count > arguments.MOST_POINTS:
        raise InputError(f"{count:.6g} outputs are too many; choose a larger output interval")
    return end, np.linspace(0.0, end, count + 1)


def _first_given(*values: float | None) -> float:
    return next(value for value in values if value is not None)
