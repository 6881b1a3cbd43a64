"""The jobs that a session can have done, by name; each takes the shelf and plain data, and returns plain data."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from rattle.answers.answer import Answer
from rattle.answers.arguments import read
from rattle.answers.blocks import Content
from rattle.question import Question, tabs
from rattle.studio.jobs import live, motion, report, thumbnail
from rattle.studio.shelf import Shelf, Source

OWN: dict[str, Callable[..., Any]] = {
    "motion": motion.motion,
    "trust": motion.trust,
    "sample": motion.sample,
    "live": live.live,
    "report": report.report,
    "thumbnail": thumbnail.thumbnail,
}


@cache
def job(name: str) -> Callable[..., Any]:
    """A job: one of the studio's own, or what the tab of a question shows."""
    if name in OWN:
        return OWN[name]
    question, _ = next(entry for entry in tabs() if entry[1].name == name)
    part = question.part("tab")
    if part is not None:
        own: Callable[..., Any] = part.tab
        return own
    return lambda shelf, source, **options: _answered(question, shelf, source, **options)


def _answered(question: Question, shelf: Shelf, source: Source, **options: str) -> Content:
    """The answer of a question, with what was written into the fields of its form."""
    subject = shelf.motion(source) if question.of == "result" else shelf.mechanism(source)
    answer: Answer = question.answer(subject, **{name: read(question, name, text) for name, text in options.items()})
    return answer.content()
