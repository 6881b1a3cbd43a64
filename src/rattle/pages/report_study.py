"""What a report is about: a mechanism with the analyses that apply to it, and the reasons why others do not."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from types import ModuleType
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from rattle.answers.answer import Answer
from rattle.answers.html import html_of
from rattle.errors import AssemblyError, MissingPackage, ModelError, SolverError
from rattle.pages.report_html import Section, paragraph
from rattle.question import Question, questions

if TYPE_CHECKING:
    from rattle.exchange.residuals import Residual, Source
    from rattle.mechanism import Mechanism
    from rattle.results.result import Result

POSITIONS = 61  # of studies that go through positions of the driver
TURNS = 0.02  # [rad] a body turns if its angle changes by more
FAILURES = (ModelError, AssemblyError, SolverError, MissingPackage, ValueError, ArithmeticError)
MOTION, FORCES = "Motion", "Forces and efforts"  # titles of sections
NOT_READ = "not to be read"  # in place of a force that says nothing of a real one
Found = TypeVar("Found")
Headline = tuple[str, str, str]  # what it is, number, where or when
_log = logging.getLogger("rattle")


@dataclass
class Study:
    """A mechanism and what was found out about it; None: it does not apply, or could not be done."""

    m: Mechanism
    trouble: list[str] = field(default_factory=list)  # what went wrong, in words: it stands at the top in red
    reasons: dict[str, str] = field(default_factory=dict)  # why a study is not in the report
    run: Result | None = None
    ideal: Result | None = None  # the same motion without play
    measured: tuple[Residual, ...] = ()  # measured curves beside those of the motion
    path: Result | None = None  # the quasi-static motion of a mechanism that is fully driven
    answers: dict[str, object] = field(default_factory=dict)  # of questions, by name

    def keep(self, name: str, answer: object) -> None:
        """Keep what a question answered; None: it has no answer."""
        if answer is not None:
            self.answers[name] = answer

    def answer(self, name: str, kind: type[Found]) -> Found | None:
        """What a question answered; None if it was not asked, or could not be answered."""
        answer = self.answers.get(name)
        return answer if isinstance(answer, kind) else None

    def run_beside(self, measured: Sequence[Source]) -> tuple[Residual, ...]:
        """Measured curves beside those of the motion; what is shown is its output."""
        return self.run.residuals(measured, [self.output]) if self.run is not None else ()

    def left_out(self, title: str, name: str, otherwise: str = "") -> Section:
        """The section without a body of a question that has no answer, with the reason."""
        return Section(title, "", self.reasons.get(name, otherwise))

    @property
    def loose(self) -> list[str]:
        """Joints with clearance that is not closed."""
        joints = self.m.model.joints.items()
        return [name for name, joint in joints if joint.clearance > 0.0 and joint.contact and not joint.contact.closed]

    @property
    def output(self) -> str:
        """The curve that shows best what the mechanism does: of the last body that moves and is not itself driven."""
        run = self.run
        if run is None:
            return ""
        every = self.m.model.moving_bodies
        bodies = [body for body in every[::-1] if body not in self.driven] or every
        moving = (motion_of(run, body) for body in bodies)
        return next((name for name in moving if np.ptp(run[name]) > 0.0), f"{bodies[0]}.angle" if bodies else "")

    @property
    def driven(self) -> set[str]:
        """Bodies whose motion against the ground a driver prescribes."""
        model, bodies = self.m.model, set[str]()
        for driver in model.drivers.values():
            joint = model.joints.get(driver.joint)
            ends = {joint.a.body, joint.b.body} if joint else {driver.point.body if driver.point else "", "ground"}
            bodies |= ends - {"ground"} if "ground" in ends else set()
        return bodies


def motion_of(run: Result, body: str) -> str:
    """The coordinate by which a body moves: its angle if it turns, else the larger of its translations."""
    if np.ptp(run[f"{body}.angle"]) > TURNS:
        return f"{body}.angle"
    return max((f"{body}.x", f"{body}.y"), key=lambda name: float(np.ptp(run[name])))


def study(
    m: Mechanism, t_end: float | None = None, progress: bool = False, measured: Sequence[Source] = ()
) -> Study:  # fmt: skip
    """Run the analyses that apply to a mechanism.

    t_end: end of the motion [s].  measured: measured curves, as of `Result.residuals`.  Raises ModelError for a model
    that cannot be read, ValueError for such an end and for measured curves that do not fit; what goes wrong later is in
    `trouble`.
    """
    _ = m.model
    results = Study(m)
    results.keep("check", tried(results, "check", "checking the mechanism", m.check, fatal=True))
    if "check" not in results.answers:
        return results
    results.run = tried(
        results, "motion", "computing the motion, twice: the second run tells how far the first can be trusted",
        lambda: m.simulate(t_end, horizon=True, progress=progress).whole(), fatal=True,
    )  # fmt: skip
    if results.run is None:
        return results
    if not results.run.success:
        results.trouble.append(f"The motion ends early, at t = {results.run.trust.t_end:.4g} s: {results.run.message}")
    if measured:
        found = tried(
            results, "measured", "comparing with what was measured", lambda: results.run_beside(measured),
            fatal=results.run.success,
        )  # fmt: skip
        results.measured = found or ()
    for question in questions().values():
        gather = getattr(question.part("section"), "gather", None)
        if gather is not None:
            gather(results)
    for question in in_blocks():
        words = f"asking: {question.asks[0].lower()}{question.asks[1:].rstrip('.')}"
        subject = m if question.of == "mechanism" else results.run
        results.keep(question.name, tried(results, question.name, words, partial(question.answer, subject)))
    return results


def tried(results: Study, what: str, words: str, action: Callable[[], Found], fatal: bool = False) -> Found | None:
    """What an analysis returns, or None and its reason."""
    _log.info(f"report: {words}")
    try:
        return action()
    except FAILURES as error:
        if fatal and isinstance(error, ValueError) and not isinstance(error, ModelError | AssemblyError):
            raise
        results.reasons[what] = in_words(error)
        if fatal:
            results.trouble.append(results.reasons[what])
        return None


def in_words(error: Exception) -> str:
    """What an error says, of a model without the file and the lines where it is: the report has no use for them."""
    if not isinstance(error, ModelError):
        return str(error)
    places: dict[str, list[str]] = {}
    for problem in error.problems:
        places.setdefault(problem.message, []).append(problem.key)
    return "; ".join(f"{', '.join(filter(None, keys))}: {text}".lstrip(": ") for text, keys in places.items())


def late(run: Result, t: float) -> bool:
    """True for an instant [s] after the horizon: what happens there is one of many possible motions."""
    return run.trust.horizon is not None and t > run.trust.horizon


def section_parts() -> list[ModuleType]:
    """What questions add to a report, in their order."""
    return [part for question in questions().values() if (part := question.part("section")) is not None]


def in_blocks() -> list[Question]:
    """Questions without a section of their own whose answer shows itself, and which need no argument."""
    asked = questions().values()
    return [each for each in asked if each.answers_in_blocks and not each.has("section") and not each.needed]


def answer_section(s: Study, question: Question) -> Section:
    """The section of an answer in blocks."""
    answer = s.answer(question.name, Answer)
    if answer is None:
        return s.left_out(question.title, question.name)
    body = tried(s, question.name, f"drawing: {question.title}", lambda: "".join(map(html_of, answer.blocks)))
    if body is None:  # numbers that no axis can hold
        return s.left_out(question.title, question.name)
    return Section(question.title, paragraph(answer.told) + body)
