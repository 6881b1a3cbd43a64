"""The section of a report with measured curves beside those of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rattle.pages.report_figures import AXIS, HALF, HIGHER, names_above, over_time, with_time
from rattle.pages.report_html import Section, figure, gallery, handy, paragraph, table
from rattle.pages.report_study import Study
from rattle.plots import curves as style
from rattle.results.handy_units import handy_unit, units_of_result
from rattle.results.within_steps import largest, shown_curve

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.exchange.residuals import Residual
    from rattle.results.result import Result

TITLE, PLACE = "Measured curves", 25  # behind the motion
LOW = 0.9  # of the panel of what they differ by [inches]
LEAD = (
    "Dots are measured values, lines the motion of the model at the same times. Their difference is measured minus"
    " computed; only values within the run are compared."
)


def measured_section(s: Study) -> Section:
    """A picture for each curve with measured values, and how far they are from it."""
    run = s.run
    if run is None or not s.measured:
        return s.left_out(TITLE, "measured")
    curves = dict.fromkeys(part.curve for part in s.measured)
    figures = [_figure(run, name, [part for part in s.measured if part.curve == name]) for name in curves]
    head = ("curve", "measured", "values within the run", "rms of the difference", "largest difference")
    rows = [
        (part.curve, part.measured.label, f"{len(part.t)} of {part.count}", handy(part.rms, part.unit, 3),
         handy(part.largest, part.unit, 3))
        for part in s.measured
    ]  # fmt: skip
    return Section(TITLE, paragraph(LEAD) + gallery(figures) + table(head, rows))


def _figure(run: Result, name: str, parts: Sequence[Residual]) -> str:
    labels = " and ".join(part.measured.label for part in parts)
    return figure(_panels(run, name, parts), f"{name} and {labels}; below, what they differ by.")


def _panels(run: Result, name: str, parts: Sequence[Residual]) -> Figure:
    above, below = axes = style.new_axes(HALF, HIGHER + LOW + AXIS, rows=2, heights=(HIGHER, LOW))
    factor, unit = handy_unit(run.unit(name), largest(run, name), units_of_result(run.provenance))
    above.plot(run.t, factor * shown_curve(run, name), color=style.BLUE, linewidth=0.9, label=name)
    style.draw_measured(above, run, [name], parts, lambda result: result.t, factor, None)
    above.set_ylabel(style.axis_label("", unit).strip() or "no unit", fontsize=8)
    names_above(above)
    style.draw_residuals(below, run, run.unit(name), [name], parts, lambda result: result.t)
    below.yaxis.label.set_fontsize(8)
    for ax in axes:
        over_time(ax, run)
    return with_time(axes)
