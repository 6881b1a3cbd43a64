"""The command `rattle ensemble`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from rattle.cli.options import value
from rattle.cli.question_command import Asked, Shown, model_command
from rattle.cli.requirements import asked_outputs, required_record, required_share
from rattle.questions.ensemble.options import (
    check_limits,
    engine_options,
    judge_share,
    of_share,
    question_options,
    shown_runs,
    tolerances,
    vary_option,
)


@model_command
@click.option("-n", "count", type=int, default=1000, show_default=True, help="How many mechanisms.")
@question_options(needed=False)
@vary_option
@click.option("--seed", default=0, show_default=True, help="Mechanism i depends on the seed and on i alone.")
@click.option(
    "--design", type=click.Choice(["sobol", "halton", "lhs", "random"]), default="sobol", show_default=True,
    help="How the fields are sampled: evenly (sobol, halton, lhs), or independently (random).",
)  # fmt: skip
@click.option(
    "--history", "histories", multiple=True, metavar="CURVE",
    help="Keep this curve of every mechanism too, at 201 instants (netCDF, with -o); may be given more than once.",
)  # fmt: skip
@click.option("--limit", metavar="VALUE", help='Also: how many stay at or below it, e.g. "5 kN"; for one --of.')
@click.option(
    "--require", "required", multiple=True, metavar="CONDITION",
    help='What 99.73 % of the mechanisms have to keep, or the exit status is 1: "max(B.force) < 2 kN", or for another'
    ' share "max(B.force) < 2 kN: 95 %"; 95% alone is about --limit.  May be given more than once.',
)  # fmt: skip
@engine_options
def ensemble(
    asked: Asked, count: int, outputs: tuple[str, ...], analysis: str, t_end: float | None, varied: tuple[str, ...],
    limit: str | None, histories: tuple[str, ...], folder: str | None, **more: Any,
) -> Shown:  # fmt: skip
    """What tolerances do: statistics of numbers over many mechanisms made with the same drawing.

    FILE is a model file or the name of a shipped example.  Tolerances stand there beside the values:
    r3 = { value = "5 mm", tol = "0.1 mm", dist = "normal" }.

    \b
    Examples: rattle ensemble slider_crank_play -n 32 --of "max(B.normal)" --t-end 12ms --limit 50kN
              rattle ensemble fourbar --vary "r3=0.5 mm" --of "rms(rocker.omega)" --t-end 50ms --plot spread.svg
              rattle ensemble fourbar -n 10000 --vary r3,r4 --of "final(rocker.angle)" --t-end 20ms -o runs

    Motion with play is chaotic: a single run says little, the distribution of many is the answer.  The table gives
    every mean with its 95 % confidence, quantiles, and how many mechanisms could not be run and why.  With --limit
    or --require the exit status is 1 if fewer than 99.73 % of the mechanisms keep it, or than the share asked for.
    """
    needed, conditions = _required(asked.required, limit)
    outputs = tuple(dict.fromkeys([*outputs, *asked_outputs(conditions)]))
    _require_sense(outputs, limit, histories, folder)
    m = asked.model()
    vary = tolerances(varied)
    if limit is not None:
        from rattle.questions.ensemble.compute import require_limit

        require_limit(m, outputs[0], value(limit), vary, analysis=analysis, t_end=t_end)
    check_limits(m, conditions, vary, analysis=analysis, t_end=t_end)
    answer = m.ensemble(
        count, list(outputs), vary, analysis=analysis, t_end=t_end, folder=folder, histories=histories,
        progress=asked.progress, **more,
    )  # fmt: skip
    verdicts, below = judge_share(answer, conditions), {}
    if limit is not None:
        share = answer.yield_below(outputs[0], value(limit))
        verdicts.insert(0, of_share(f"stay at or below {limit}", share, needed))
        below = {"share_below": share._asdict()}
    shown = shown_runs(
        asked, answer, lambda: answer.plot(outputs[0], limit=None if limit is None else value(limit)),
        [verdict.words for verdict in verdicts], record=below | required_record(verdicts),
    )  # fmt: skip
    return shown if all(verdict.kept for verdict in verdicts) else shown._replace(status=shown.status or 1)


def _required(required: Sequence[str], limit: str | None) -> tuple[float, list[str]]:
    """The share of the mechanisms that have to keep the limit, and the other conditions.  Raises UsageError."""
    shares = [text for text in required if "%" in text and not any(sign in text for sign in "<>=")]
    if len(shares) > (limit is not None):
        raise click.UsageError(
            f"--require {shares[-1]}: one share of the mechanisms, beside the --limit that they keep"
        )
    return required_share(shares[0] if shares else None), [text for text in required if text not in shares]


def _require_sense(outputs: Sequence[str], limit: str | None, histories: Sequence[str], folder: str | None) -> None:
    """Refuse a question without an output, and options that do not go together.  Raises UsageError."""
    if not outputs:
        raise click.UsageError('--of names what is asked of every mechanism, e.g. --of "max(O3.force)"')
    if limit is not None and len(outputs) > 1:
        raise click.UsageError(
            f'--limit is for one --of; with several say what each has to keep: --require "{outputs[0]} <= {limit}"'
        )
    if histories and folder is None:
        raise click.UsageError("--history keeps curves in a folder: give one with -o")
