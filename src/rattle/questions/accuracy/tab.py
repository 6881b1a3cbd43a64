"""What play does to the accuracy of an output, in the studio."""

from __future__ import annotations

import numpy as np

from rattle.answers.blocks import Content, bars, content, curves, line, words
from rattle.plots.curves import axis_label
from rattle.results.handy_units import handy_unit
from rattle.studio.jobs.motion import usual_output
from rattle.studio.shelf import Shelf, Source

POINTS = 61  # positions at which a band is computed


def tab(shelf: Shelf, source: Source, of: str = "") -> Content:
    """How far play lets an output deviate over the motion, and which joint to tighten first."""
    m = shelf.mechanism(source)
    end = m.model.settings.t_end
    of = of.strip() or usual_output(shelf.motion(source))
    answer = m.accuracy(of, np.linspace(0.0, end, POINTS))
    factor, unit = handy_unit(answer.unit, float(answer.worst.max(initial=0.0)))
    t, bands = answer.t, [("all pins at their worst, to first order", answer.worst, -answer.worst)]
    bands.append(("root sum square", answer.rss, -answer.rss))
    if not np.isnan(answer.low).all():
        bands.append(("exact extremes", answer.high - answer.nominal, answer.low - answer.nominal))
    lines = []
    for k, (name, up, down) in enumerate(bands):
        dash = name.startswith("exact")
        lines += [line(name, t, factor * up, dash=dash), line("", t, factor * down, like=2 * k, dash=dash)]
    if not np.isnan(answer.loaded).all():
        lines.append(line("under the loads, at rest", t, factor * answer.loaded))
    k = int(np.argmax(answer.worst))
    sentences = str(answer).replace("+-", "±").splitlines()
    return content(
        sentences[-1 - len(answer.notes)],
        curves(f"What play lets {of} deviate", "time [s]", axis_label("deviation", unit), lines),
        bars(
            f"Which joint does how much, at t = {t[k]:.4g} s",
            axis_label("deviation", unit),
            answer.joints,
            factor * answer.contributions[k],
        ),
        words("\n".join(sentences)),
        words("\n".join(answer.notes), "care"),
    )
