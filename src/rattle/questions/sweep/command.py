"""The command `rattle sweep`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.options import value
from rattle.cli.over import axes_of
from rattle.cli.question_command import Asked, Shown, model_command
from rattle.cli.requirements import ORDER, Condition, Verdict, asked_outputs, required_record
from rattle.questions.ensemble.options import engine_options, question_options, shown_runs

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.sweep.compute import Sweep


@model_command
@click.option(
    "--over", "ranges", multiple=True, required=True, metavar="NAME=FIRST:LAST:COUNT",
    help='A parameter and its values: r3=0.001:0.005:21, "r3=1 mm:5 mm:21", or a list r3=0.001,0.002,0.005; '
    "once for each parameter.",
)  # fmt: skip
@question_options(needed=False)
@click.option(
    "--require", "required", multiple=True, metavar="CONDITION",
    help='What every combination has to keep, e.g. "max(B.force) < 2 kN"; exit status 1 where one does not; may be'
    " given more than once.",
)  # fmt: skip
@engine_options
def sweep(
    asked: Asked, ranges: tuple[str, ...], outputs: tuple[str, ...], analysis: str, t_end: float | None, **engine: Any
) -> Shown:
    """Numbers over all combinations of values of parameters: a curve for one, a map for two.

    FILE is a model file or the name of a shipped example.  --over also takes the path of a number of the model, such as
    joints.B.contact.restitution.

    \b
    Examples: rattle sweep slider_crank_play --over "c=0.1 mm:0.5 mm:9" --of "max(B.normal)" --t-end 6ms
              rattle sweep slider_crank --analysis kinematics --over "rod_length=.1:.2:11" --of "max(slider.ax)"
    """
    outputs = tuple(dict.fromkeys([*outputs, *asked_outputs(asked.required)]))
    if not outputs:
        raise click.UsageError('--of names what is asked of every combination, e.g. --of "max(O3.force)"')
    m, axes = axes_of(asked.model(), ranges)
    check_every(m, asked.required, list(axes), analysis=analysis, t_end=t_end)
    answer = m.sweep(axes, list(outputs), analysis=analysis, t_end=t_end, progress=asked.progress, **engine)
    verdicts = judge_every(answer, asked.required)
    return shown_runs(
        asked, answer, lambda: answer.plot(outputs[0]), record=required_record(verdicts), verdicts=verdicts
    )


def check_every(m: Mechanism, required: Sequence[str], varied: Sequence[str], **question: Any) -> None:
    """Refuse requirements that cannot be asked of every combination, before anything runs."""
    from rattle.studies.runs.limits import limit_of
    from rattle.studies.runs.task import task_of

    for text in required:
        condition = Condition.read(text)
        if condition.text != text.strip():
            raise click.UsageError(
                f"--require {text}: a share is one of an ensemble; of a sweep every combination counts"
            )
        output = task_of(m, varied, [condition.output], **question).outputs[0]
        limit_of(value(condition.limit), output.unit, f"--require {text}", output.dimension)


def judge_every(sweep: Sweep, required: Sequence[str]) -> list[Verdict]:
    """Whether every combination of a sweep keeps what is required; one without a number does not."""
    import numpy as np

    from rattle.studies.runs.limits import limit_of

    verdicts = []
    for condition in map(Condition.read, required):
        limit = limit_of(value(condition.limit), sweep.unit(condition.output))
        keeps = ORDER[condition.comparison](sweep[condition.output], limit)
        beyond = np.flatnonzero(~keeps)
        kept = not len(beyond)
        where = (
            "in every combination"
            if kept
            else f"in {len(beyond)} of {len(sweep)}, first at {sweep.told(int(beyond[0]))}"
        )
        line = f"required {condition.text}: {'kept' if kept else 'NOT KEPT'} {where}"
        verdicts.append(Verdict(kept, line, {"condition": condition.text, "kept": kept, "not_kept": beyond.tolist()}))
    return verdicts
