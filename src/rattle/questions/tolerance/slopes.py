"""Slopes of an output by parameters at the nominal mechanism: exact where there are derivatives, else differences."""

from __future__ import annotations

import logging
from typing import NamedTuple

import numpy as np

from rattle.errors import AssemblyError, ModelError, SolverError
from rattle.questions.ensemble.contributors import half_widths, nominal
from rattle.questions.ensemble.fields import Fields
from rattle.questions.optimise.asked import ANALYSES, Question
from rattle.questions.optimise.designs import Designs, LostError
from rattle.questions.tolerance.trials import Trials
from rattle.studies.runs.task import Task

log = logging.getLogger("rattle")
STEP = 0.05  # of differences, as a share of the half width of a field: far above errors of runs
SMALL = 1e-6  # half width of a field without one, as a share of the nominal value
EXACT = "exact derivatives"
ALIKE = 0.1  # share of the largest deviation by which those of slopes and of runs beside may differ
PLACES = (-2, -1, 1, 2)  # steps at which the output is taken


class Slopes(NamedTuple):
    """dF/dp (k,) [SI], nan where there is none, and how they were found."""

    values: np.ndarray
    how: str


def slopes(trials: Trials, fields: Fields, value: float) -> Slopes:
    """Slopes of an output with this nominal value [SI]."""
    why = f"{trials.task.analysis} has none of the output"
    if trials.task.analysis in ANALYSES:
        level = log.level
        log.setLevel(max(level, logging.ERROR))  # what is to be said of the nominal mechanism is said of its own run
        try:
            return _seen(_by_derivatives(trials.task, fields), trials, fields, value)
        except (LostError, ModelError, AssemblyError, SolverError) as error:
            why = str(error)
        finally:
            log.setLevel(level)
    return _by_differences(trials, fields, value, why)


def _reach(fields: Fields) -> np.ndarray:
    """(k,) half widths [SI], positive also where a table has the nominal value alone."""
    half = half_widths(fields)
    return np.where(half > 0.0, half, SMALL * np.maximum(np.abs(nominal(fields)), 1.0))


def _by_derivatives(task: Task, fields: Fields) -> Slopes:
    """Slopes of outputs of motions and driven positions.  Raises LostError."""
    m = task.mechanism
    middle, half = nominal(fields), _reach(fields)
    every = [m.model.parameters[name] for name in fields.names]
    least = np.array([-np.inf if parameter.minimum is None else parameter.minimum for parameter in every])
    most = np.array([np.inf if parameter.maximum is None else parameter.maximum for parameter in every])
    low, high = np.maximum(middle - half, least), np.minimum(middle + half, most)
    asked = Question(m, fields.names, low, high, task.t_end, task.analysis, task.outputs[0])
    designs = Designs(asked)
    design = designs.at(asked.places(m.parameters))
    if not design.sound:
        raise LostError(design.message)
    slopes = designs.slopes(design)[0] / asked.width
    if not designs.differenced:
        return Slopes(slopes, EXACT)
    return Slopes(slopes, f"differences of whole runs, because {next(iter(designs.differenced))}")


def _seen(exact: Slopes, trials: Trials, fields: Fields, value: float) -> Slopes:
    """Exact slopes, with what runs beside the nominal mechanism show of them where contacts begin and end: derivatives
    of motions that are near chaotic hold for smaller changes than tolerances."""
    if not len(trials.task.mechanism.system.arrays["contact"]) or exact.how != EXACT:
        return exact
    beside, reach = _by_differences(trials, fields, value, "").values, _reach(fields)
    off, size = np.abs(exact.values - beside) * reach, np.abs(exact.values) * reach
    if np.nanmax(off, initial=0.0) <= ALIKE * size.max(initial=0.0):
        return exact
    return exact._replace(how=f"{EXACT}, which hold for smaller changes than these tolerances: runs show other slopes")


def _by_differences(trials: Trials, fields: Fields, value: float, why: str) -> Slopes:
    """Slopes from runs beside the nominal mechanism, four for every parameter."""
    middle, steps = nominal(fields), STEP * _reach(fields)
    columns = np.repeat(middle[:, None], len(PLACES) * len(middle), axis=1)
    for k, step in enumerate(steps):
        columns[k, k * len(PLACES) : (k + 1) * len(PLACES)] += step * np.array(PLACES)
    beside = trials.outputs(columns).reshape(len(middle), len(PLACES))
    slopes = [_difference(row, value) / step for row, step in zip(beside.tolist(), steps, strict=True)]
    return Slopes(np.array(slopes), f"differences of whole runs, because {why}")


def _difference(beside: list[float], here: float) -> float:
    """Difference per step from values at PLACES, and here; nan where too few are known."""
    down2, down, up, up2 = beside
    orders = (
        (8.0 * (up - down) - (up2 - down2)) / 12.0,
        (up - down) / 2.0,
        (4.0 * up - up2 - 3.0 * here) / 2.0,
        (3.0 * here - 4.0 * down + down2) / 2.0,
    )
    return next((slope for slope in orders if np.isfinite(slope)), float("nan"))
