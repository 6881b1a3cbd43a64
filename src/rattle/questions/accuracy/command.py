"""The command `rattle accuracy`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.options import value

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.accuracy.compute import Accuracy

from pathlib import Path
from typing import TYPE_CHECKING

from rattle.cli.command import Command
from rattle.cli.instants import span_options, span_times
from rattle.cli.options import model_options, read_model
from rattle.cli.output import as_json as to_json
from rattle.cli.output import check_pictures, say_written
from rattle.cli.requirements import (
    Verdict,
    finish_required,
)

if TYPE_CHECKING:
    from rattle.questions.accuracy.compute import Accuracy


@click.command(cls=Command)
@model_options
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
@click.option(
    "-o", "--output", metavar="FILE",
    help="Draw the error band and contributions: .svg, .png or .pdf; of several --of FILE-NAME.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Everything as JSON.")
@click.pass_context
def accuracy(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, curves: tuple[str, ...],
    t_end: float | None, points: int, extremes: bool, limit: str | None, output: str | None, as_json: bool,
) -> None:  # fmt: skip
    """What the play of the joints does to the accuracy of an output, and which joint to tighten first.

    FILE is a model file or the name of a shipped example.

    \b
    Examples: rattle accuracy path_generator --of coupler.P.y -o accuracy.svg
              rattle accuracy path_generator --of coupler.P.x --of coupler.P.y --limit "2 mm"
    """
    from rattle.plots.curves import save_figure

    check_pictures(file, output)
    if ideal:
        raise click.UsageError("accuracy is about play, and --ideal removes all of it; leave --ideal out")
    m = read_model(file, settings, False)
    times = span_times(m, t_end, points)
    check_deviations(m, curves, limit)
    answers = [m.accuracy(curve, times, extremes=extremes) for curve in curves]
    verdicts = [] if limit is None else [judge_deviation(answer, limit) for answer in answers]
    if as_json:
        records = [_accuracy_record(answer) for answer in answers]
        if verdicts:
            records = [record | verdict.record for record, verdict in zip(records, verdicts, strict=True)]
        click.echo(to_json(records[0] if len(records) == 1 else records))
    else:
        click.echo("\n\n".join(map(str, answers)))
    for answer in answers if output is not None else ():
        target = Path(str(output))
        target = target if len(answers) == 1 else target.with_name(f"{target.stem}-{answer.of}{target.suffix}")
        save_figure(answer.plot(), target)
        if not as_json:
            say_written(target)
    finish_required(ctx, verdicts, None if as_json else click.echo)


def _accuracy_record(answer: Accuracy) -> dict[str, Any]:
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
