"""The command `rattle accuracy`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.instants import span_options, span_times
from rattle.cli.options import value
from rattle.cli.question_command import Asked, Shown, alone_or_all, json_option, model_command, picture_option
from rattle.cli.requirements import Verdict

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.accuracy.compute import Accuracy


@model_command
@click.option(
    "--of", "curves", multiple=True, required=True, metavar="NAME",
    help="The output that may deviate, e.g. rocker.angle, coupler.P.x or a signal; may be given more than once.",
)  # fmt: skip
@span_options(73)
@click.option("--extremes/--no-extremes", default=True, show_default=True, help="Also compute the exact extremes.")
@click.option(
    "--limit", metavar="VALUE",
    help='The deviation that is allowed, e.g. "0.1 deg", of every --of; exit status 1 where it is exceeded.',
)  # fmt: skip
@picture_option("Draw the error band and contributions: .svg, .png or .pdf; of several --of FILE-NAME.")
@json_option("Everything as JSON.")
def accuracy(
    asked: Asked, curves: tuple[str, ...], t_end: float | None, points: int, extremes: bool, limit: str | None
) -> Shown:
    """What the play of the joints does to the accuracy of an output, and which joint to tighten first.

    FILE is a model file or the name of a shipped example.

    \b
    Examples: rattle accuracy path_generator --of coupler.P.y -o accuracy.svg
              rattle accuracy path_generator --of coupler.P.x --of coupler.P.y --limit "2 mm"
    """
    if asked.ideal:
        raise click.UsageError("accuracy is about play, and --ideal removes all of it; leave --ideal out")
    m = asked.model()
    times = span_times(m, t_end, points)
    check_deviations(m, curves, limit)
    answers = [m.accuracy(curve, times, extremes=extremes) for curve in curves]
    verdicts = [] if limit is None else [judge_deviation(answer, limit) for answer in answers]
    judged = [verdict.record for verdict in verdicts] or [{}] * len(answers)
    return Shown(
        lambda: "\n\n".join(map(str, answers)),
        lambda: alone_or_all([_record(answer) | limits for answer, limits in zip(answers, judged, strict=True)]),
        asked.drawn(*(answer.plot for answer in answers), named=[answer.of for answer in answers]),
        verdicts,
    )


def _record(answer: Accuracy) -> dict[str, Any]:
    """The play of one output as a record; arrays over time [SI]."""
    keys = ("t", "nominal", "worst", "rss", "low", "high", "loaded", "pressed", "rule")
    contributions = dict(zip(answer.joints, answer.contributions.T.tolist(), strict=True))
    record = {"of": answer.of, "unit": answer.unit, "share": answer.share, "tighten": answer.tighten}
    return {**record, **{key: getattr(answer, key).tolist() for key in keys}, "contributions": contributions}


def check_deviations(m: Mechanism, curves: Sequence[str], limit: str | None) -> None:
    """Refuse a limit that is no deviation of every curve, before anything runs.  Raises InputError."""
    from rattle.studies.runs.limits import limit_of
    from rattle.studies.runs.task import task_of

    for curve in curves if limit is not None else ():
        band = task_of(m, (), [f"max({curve}.worst)"], analysis="accuracy").outputs[0]
        if limit_of(value(str(limit)), band.unit, f"--limit, for {curve}") < 0.0:
            raise click.UsageError(f"--limit is a deviation to either side, so not negative; got {limit}")


def judge_deviation(answer: Accuracy, limit: str) -> Verdict:
    """Whether an output with play stays within a deviation to either side."""
    from rattle.results.display import quantity
    from rattle.studies.runs.limits import limit_of

    allowed = limit_of(value(limit), answer.unit, "--limit")
    kept = bool(answer.largest <= allowed)
    deviation = quantity(answer.largest, answer.unit)
    words = f"limit {limit}: {'kept' if kept else 'EXCEEDED'}, {answer.of} deviates by {deviation}"
    return Verdict(kept, words, {"limit": allowed, "kept": kept, "largest": answer.largest})
