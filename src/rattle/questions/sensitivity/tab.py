"""Exact derivatives of a curve in the studio: which dimension matters, when, and how much."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.answers.arguments import listed
from rattle.answers.blocks import MOST_LINES, Block, Content, bars, content, curves, line, table, words
from rattle.errors import InputError, ModelError, SolverError, TraceError
from rattle.plots.curves import axis_label
from rattle.questions.sensitivity.effects import Effect, effects
from rattle.results.handy_units import handy_unit
from rattle.results.result import Result
from rattle.studio.jobs.motion import usual_output
from rattle.studio.shelf import Shelf, Source

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

POINTS = 201


def tab(shelf: Shelf, source: Source, of: str = "", to: str = "") -> Content:
    """What a usual change of each parameter does to an output: its tolerance, or 1 % of it."""
    m = shelf.mechanism(source)
    every = m.model.parameters
    if not every:
        raise InputError("the model has no parameters; write a dimension as one in Text")
    parameters = listed(to) or [name for name, parameter in every.items() if parameter.tol] or list(every)
    outputs = listed(of) or [usual_output(shelf.motion(source))]
    t = np.linspace(0.0, m.model.settings.t_end, POINTS)
    result, note = _of_motion(m, outputs, parameters, t)
    entries = sorted(effects(result), key=lambda effect: -effect.size)
    idle = [effect.parameter for effect in entries if not np.any(effect.derivative)]
    if idle and note:
        note += f".\n{', '.join(dict.fromkeys(idle))} changes nothing there; Accuracy and Ensemble are with play"
    rows = [
        (
            effect.output,
            effect.parameter,
            effect.words,
            effect.slope,
            effect.effect,
            "whole run" if effect.of_whole_run else f"{result.t[effect.largest]:.4g} s",
        )
        for effect in entries
    ]
    return content(
        "exact derivatives, no small change is made",
        words(note, "care"),
        *_pictures(result, entries, outputs),
        table(("curve", "parameter", "changed by", "largest derivative", "so it changes by", "at t"), rows),
        words(str(result.trust)),
    )


def _pictures(result: Result, entries: list[Effect], outputs: list[str]) -> tuple[Block | None, Block | None]:
    """The changes over time and the largest of each, for effects of the unit of the first."""
    largest = max((effect.size for effect in entries), default=0.0)
    factor, unit = handy_unit(entries[0].unit, largest) if entries else (1.0, "")
    alike = [effect for effect in entries if effect.unit == entries[0].unit][:MOST_LINES]
    names = [effect.parameter if len(outputs) == 1 else f"{effect.output} by {effect.parameter}" for effect in alike]
    lines = [
        line(f"{name} by {effect.words}", result.t, factor * effect.derivative * effect.change)
        for name, effect in zip(names, alike, strict=True)
        if not effect.of_whole_run
    ]
    title = f"Change of {', '.join(outputs)} by a usual change of each parameter"
    return (
        curves(title, "time [s]", axis_label("change", unit), lines) if lines or not alike else None,
        bars("The largest of each", axis_label("change", unit), names, [factor * effect.size for effect in alike]),
    )


def _of_motion(m: Mechanism, outputs: list[str], parameters: list[str], t: np.ndarray) -> tuple[Result, str]:
    """Of the motion in time; where contacts begin and end, of the driven mechanism without play, and a note."""
    try:
        return m.sensitivity(outputs, parameters, t), ""
    except (ModelError, TraceError) as error:
        why = str(error).splitlines()[0]
        because = why.partition("; ")[0].removeprefix("no sensitivities: ")  # the rest is for those who write Python
    try:
        answer = m.ideal().sensitivity(outputs, parameters, t, "kinematics", strict=True)
    except (ModelError, TraceError, SolverError):
        raise ModelError([]) from None if not why else InputError(why)
    return answer, f"These are of the mechanism without play, driven through its motion, because {because}"
