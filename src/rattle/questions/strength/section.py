"""What bars and necks of a mechanism bear, in a report."""

from __future__ import annotations

from rattle.pages.report_html import Section, figure, listed, sentence, table
from rattle.pages.report_study import Study, tried
from rattle.questions.strength.answer import Strength
from rattle.questions.strength.compute import strengths, stressed_of
from rattle.questions.strength.pictures import draw_stressed
from rattle.questions.strength.words import HEAD, NOTHING, in_rows, remarks_of, worst_of


class Strengths(dict[str, Strength]):
    """The strength of every bar and neck, by name."""


def gather(study: Study) -> None:
    run = study.run
    if run is None or not run.success:
        return
    if not stressed_of(study.m.model):
        study.reasons["strength"] = NOTHING
        return
    study.keep(
        "strength", tried(study, "strength", "the strength of bars and necks", lambda: Strengths(strengths(run)))
    )


def section(s: Study) -> Section:
    """A row for every bar and neck, the mechanism when the worst of them bears most, and remarks."""
    bars = s.answer("strength", Strengths)
    if bars is None:
        return s.left_out("Strength", "strength")
    every = list(bars.values())
    worst = worst_of(every)
    drawing = figure(
        draw_stressed(every, worst.peak_at[0]),
        f"The mechanism when the stress in {worst.name} is largest; moments stand on the side that is pulled.",
    )
    rows = table(HEAD, in_rows(every), "What bars and necks bear at the instants of the motion")
    return Section("Strength", drawing + rows + listed(map(sentence, remarks_of(every))))


SECTIONS = ((85, section),)
