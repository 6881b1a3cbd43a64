"""How long joints and links last, in a report."""

from __future__ import annotations

from rattle.answers.html import html_of
from rattle.pages.report_html import Section, paragraph
from rattle.pages.report_study import Headline, Study, tried
from rattle.questions.durability.compute import Durability


def gather(study: Study) -> None:
    model = study.m.model
    bars = any(body.beam is not None and body.beam.section is not None for body in model.bodies.values())
    if not (model.duty or bars or any(joint.wears is not None for joint in model.joints.values())):
        study.reasons["durability"] = "no joint says how it wears, and no bar has a section"
        return
    study.keep("durability", tried(study, "durability", "computing how long it lasts", study.m.durability))


def section(s: Study) -> Section:
    """How long everything lasts, and what fails first."""
    answer = s.answer("durability", Durability)
    if answer is None:
        return s.left_out("Durability", "durability")
    return Section("Durability", paragraph(answer.told) + "".join(map(html_of, answer.shown)))


def headline(s: Study) -> list[Headline]:
    """What fails first."""
    answer = s.answer("durability", Durability)
    if answer is None or not 0.0 < answer.first.hours < float("inf"):
        return []
    return [("Fails first", f"{answer.first.hours:.4g} h", f"{answer.first.name}, by {answer.first.what}")]


SECTIONS = ((85, section),)
