"""How long joints and links last, in a report."""

from __future__ import annotations

import math

from rattle.answers.html import html_of
from rattle.catalogue.bearings import BearingPlay
from rattle.description.model import Joint
from rattle.pages.report_html import Section, paragraph
from rattle.pages.report_study import Headline, Study, tried
from rattle.questions.durability.compute import Durability
from rattle.questions.strength.compute import stressed_of


def gather(study: Study) -> None:
    model = study.m.model
    if not (model.duty or stressed_of(model) or any(map(_ages, model.joints.values()))):
        study.reasons["durability"] = (
            "no joint says how it wears or tires, no bar has section and material, and no plate has necks"
        )
        return
    study.keep("durability", tried(study, "durability", "computing how long it lasts", study.m.durability))


def _ages(joint: Joint) -> bool:
    """True of a joint that says how it wears, and of a rolling bearing with its capacity."""
    rolls = isinstance(joint.named, BearingPlay) and not math.isnan(joint.named.capacity)
    return joint.wears is not None or rolls


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


SECTIONS = ((87, section),)
