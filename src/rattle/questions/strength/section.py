"""What the bars of a mechanism bear, in a report."""

from __future__ import annotations

from rattle.pages.report_html import Section, figure, listed, sentence, table
from rattle.pages.report_study import Study, tried
from rattle.questions.strength.compute import Strength, bars_of, strengths
from rattle.questions.strength.pictures import draw_bars
from rattle.questions.strength.words import HEAD, in_rows, remarks_of, worst_of

NO_BARS = "no bar has a section and a material"


class Bars(dict[str, Strength]):
    """The strength of every bar, by name."""


def gather(study: Study) -> None:
    run = study.run
    if run is None or not run.success:
        return
    if not bars_of(study.m.model):
        study.reasons["strength"] = NO_BARS
        return
    study.keep("strength", tried(study, "strength", "the strength of bars", lambda: Bars(strengths(run))))


def section(s: Study) -> Section:
    """A row for every bar, the mechanism when the worst of them bears most, and remarks."""
    bars = s.answer("strength", Bars)
    if bars is None:
        return s.left_out("Strength", "strength")
    every = list(bars.values())
    worst = worst_of(every)
    drawing = figure(
        draw_bars(every, worst.peak_at[0]),
        f"The mechanism when the stress in {worst.body} is largest; moments stand on the side that is pulled.",
    )
    rows = table(HEAD, in_rows(every), "What bars bear at the instants of the motion")
    return Section("Strength", drawing + rows + listed(map(sentence, remarks_of(every))))


SECTIONS = ((85, section),)
