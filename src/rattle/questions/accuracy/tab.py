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
    found = m.accuracy(of, np.linspace(0.0, end, POINTS))
    factor, unit = handy_unit(found.unit, float(found.worst.max(initial=0.0)))
    exact = not np.isnan(found.low).all()
    t = found.t
    lines = [
        line("all pins at their worst, to first order", t, factor * found.worst),
        line("", t, -factor * found.worst, like=0),
    ]
    lines += [line("root sum square", t, factor * found.rss), line("", t, -factor * found.rss, like=2)]
    if exact:
        lines += [
            line("exact extremes", t, factor * (found.high - found.nominal), dash=True),
            line("", t, factor * (found.low - found.nominal), like=4, dash=True),
        ]
    if not np.isnan(found.loaded).all():
        lines.append(line("under the loads, at rest", t, factor * found.loaded))
    k = int(np.argmax(found.worst))
    said = str(found).replace("+-", "±").splitlines()
    return content(
        said[-1 - len(found.notes)],
        curves(f"What play lets {of} deviate", "time [s]", axis_label("deviation", unit), lines),
        bars(
            f"Which joint does how much, at t = {t[k]:.4g} s",
            axis_label("deviation", unit),
            found.joints,
            factor * found.contributions[k],
        ),
        words("\n".join(said)),
        words("\n".join(found.notes), "care"),
    )
