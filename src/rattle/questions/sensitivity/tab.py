"""Exact derivatives of a curve in the studio: which dimension matters, when, and how much."""

from __future__ import annotations

import numpy as np

from rattle.answers.blocks import MOST_LINES, Content, bars, content, curves, line, table, words
from rattle.errors import InputError, ModelError, SolverError, TraceError
from rattle.plots.curves import axis_label
from rattle.questions.sensitivity.effects import effects
from rattle.results.handy_units import handy_unit
from rattle.results.result import Result
from rattle.studio.jobs.motion import usual_output
from rattle.studio.shelf import Shelf, Source

POINTS = 201


def tab(shelf: Shelf, source: Source, of: str = "", to: str = "") -> Content:
    """What a usual change of each parameter does to an output: its tolerance, or 1 % of it."""
    m = shelf.mechanism(source)
    every = m.model.parameters
    if not every:
        raise InputError("the model has no parameters; write a dimension as one in Text")
    parameters = [one.strip() for one in to.split(",") if one.strip()]
    parameters = parameters or [name for name, one in every.items() if one.tol] or list(every)
    outputs = [one.strip() for one in of.split(",") if one.strip()] or [usual_output(shelf.motion(source))]
    t = np.linspace(0.0, m.model.settings.t_end, POINTS)
    result, note = _of_motion(m, outputs, parameters, t)
    found = sorted(effects(result), key=lambda one: -float(np.abs(one.derivative).max(initial=0.0)) * one.change)
    largest = max((float(np.abs(one.derivative).max(initial=0.0)) * one.change for one in found), default=0.0)
    factor, unit = handy_unit(found[0].unit, largest) if found else (1.0, "")
    alike = [one for one in found if one.unit == found[0].unit][:MOST_LINES]
    name = (lambda one: one.parameter) if len(outputs) == 1 else (lambda one: f"{one.output} by {one.parameter}")
    lines = [line(f"{name(one)} by {one.words}", result.t, factor * one.derivative * one.change) for one in alike]
    idle = [one.parameter for one in found if not np.any(one.derivative)]
    if idle and note:
        note += f".\n{', '.join(dict.fromkeys(idle))} changes nothing there; Accuracy and Ensemble are with play"
    rows = [
        (one.output, one.parameter, one.words, one.slope, one.effect, f"{result.t[one.largest]:.4g} s") for one in found
    ]
    return content(
        "exact derivatives, no small change is made",
        words(note, "care"),
        curves(
            f"Change of {', '.join(outputs)} by a usual change of each parameter",
            "time [s]",
            axis_label("change", unit),
            lines,
        ),
        bars(
            "The largest of each",
            axis_label("change", unit),
            [name(one) for one in alike],
            [factor * float(np.abs(one.derivative).max(initial=0.0)) * one.change for one in alike],
        ),
        table(("curve", "parameter", "changed by", "largest derivative", "so it changes by", "at t"), rows),
        words(str(result.trust)),
    )


def _of_motion(m, outputs: list[str], parameters: list[str], t: np.ndarray) -> tuple[Result, str]:  # type: ignore[no-untyped-def]
    """Of the motion in time; where contacts begin and end, of the driven mechanism without play, and a note."""
    try:
        return m.sensitivity(outputs, parameters, t), ""
    except (ModelError, TraceError) as error:
        why = str(error).splitlines()[0]
        because = why.partition("; ")[0].removeprefix(
            "no sensitivities: "
        )  # what follows is for those who write Python
    try:
        found = m.ideal().sensitivity(outputs, parameters, t, "kinematics", strict=True)
    except (ModelError, TraceError, SolverError):
        raise ModelError([]) from None if not why else InputError(why)
    return found, f"These are of the mechanism without play, driven through its motion, because {because}"
