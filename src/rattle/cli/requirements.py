"""What a result has to keep, on the command line: `--require "max(B.force) < 2 kN"`, with an exit status for scripts.

Of one motion a requirement holds or not.  Of many mechanisms it has to hold for a share of them, 99.73 % (three
standard deviations) unless another one is given: `--require "max(B.force) < 2 kN: 95 %"`; `--require 95%` is about the
limit of `--limit`.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from rattle.cli.options import value

if TYPE_CHECKING:
    from rattle.analyses.accuracy.clearance_error import Accuracy
    from rattle.mechanism import Mechanism
    from rattle.results.reductions import Output
    from rattle.results.result import Result
    from rattle.studies.ensemble.ensemble import Ensemble
    from rattle.studies.ensemble.statistics import Bounded
    from rattle.studies.ensemble.sweep import Sweep

MOST = 0.9973  # share of the mechanisms that a limit is for unless another one is asked for: three standard deviations
EQUAL = 1e-9  # share of its size within which a number is the one required by ==: what a run resolves
FORCES = ("force", "normal", "pressing")  # of a rigid joint, which elastic bushes bracket
_PERCENT = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*%\s*")
ORDER = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
_COMPARISON = re.compile(r"[<>=]=|[<>]")

require_option = click.option(
    "--require", "required", multiple=True, metavar="CONDITION",
    help='What has to hold, e.g. "max(B.force) < 2 kN"; exit status 1 where it does not; may be given more than once.',
)  # fmt: skip
require_share_option = click.option(
    "--require", "required", metavar="SHARE",
    help="With --limit: how many mechanisms have to keep it, e.g. 99%, or the exit status is 1.  [default: 99.73%]",
)  # fmt: skip


def required_share(text: str | None) -> float:
    """The share of `--require 99%`; 0.9973 without one.  Raises click.UsageError."""
    if text is None:
        return MOST
    match = _PERCENT.fullmatch(text)
    if match is None or not 0.0 < float(match[1]) <= 100.0:
        raise click.UsageError(f"--require takes a share of the mechanisms, such as 99%, got '{text}'")
    return float(match[1]) / 100.0


def said_required(share: float, kept: bool) -> str:
    """How many mechanisms had to, and whether they do."""
    return f"required {100 * share:.6g} %: {'kept' if kept else 'NOT KEPT'}"


class Condition(NamedTuple):
    """A requirement as written: an output, a comparison, a value or output, and a share of the mechanisms."""

    text: str
    output: str
    comparison: str
    limit: str
    share: float

    @classmethod
    def read(cls, text: str) -> Condition:
        """Take a requirement apart.  Raises click.UsageError."""
        body, colon, share = text.rpartition(":")
        written = body if colon else text
        depth = 0
        for place, letter in enumerate(written):
            depth += (letter == "(") - (letter == ")")
            match = _COMPARISON.match(written, place)
            if match and depth == 0:
                output, limit = written[:place].strip(), written[match.end() :].strip()
                if output and limit:
                    return cls(written.strip(), output, match[0], limit, required_share(share if colon else None))
        raise click.UsageError(f"--require takes a comparison, such as \"max(B.force) < 2 kN\", got '{text}'")


class Verdict(NamedTuple):
    """Whether a requirement holds, in words and as a record for JSON."""

    kept: bool
    said: str
    record: dict[str, Any]


def check_required(
    m: Mechanism, required: Sequence[str], analysis: str = "simulate", t_end: float | None = None
) -> None:
    """Refuse requirements that cannot be asked of an analysis, before it runs.  Raises UsageError, ModelError."""
    from rattle.studies.runs.task import task_of

    for condition in map(Condition.read, required):
        task_of(m, (), [condition.output], analysis=analysis, t_end=t_end)


def judge(result: Result, required: Sequence[str]) -> list[Verdict]:
    """Whether one motion keeps what is required.  Raises ModelError for what cannot be asked of it."""
    from rattle.results.contact_summary import bracket, no_number
    from rattle.results.display import quantity
    from rattle.results.evaluation import evaluate, unread_curves
    from rattle.results.reductions import Known, read, read_constraint

    verdicts = []
    known = Known.of(result)
    for condition in map(Condition.read, required):
        equal = condition.comparison == "=="
        constraint = read_constraint(condition.text, known)
        margin = evaluate(constraint.margin, result)
        output = read(condition.output, known)
        number = evaluate(output, result)
        holds = abs(margin) <= EQUAL * max(abs(number), abs(number - margin)) if equal else margin >= 0.0
        towers = unread_curves(constraint.margin, result)
        apart = _apart(constraint.margin, result)
        elastic = evaluate(constraint.margin, _with_elastic_bushes(result, apart)) if apart and not equal else math.inf
        kept = bool(result.success and holds and not towers and elastic >= 0.0)
        seen = f"is {quantity(number, output.unit)}" if math.isfinite(number) else "has no value"
        if towers:
            seen = f"cannot be judged: {no_number(towers[0])}"
        elif apart:
            seen += "".join(f"; elastic bushes in {name} would show about {bracket(result, name)}" for name in apart)
        said = f"required {condition.text}: {'kept' if kept else 'NOT KEPT'}, {condition.output} {seen}"
        value_read = math.nan if towers else number
        record = {"condition": condition.text, "kept": kept, "value": value_read, "unit": output.unit}
        verdicts.append(Verdict(kept, said, record))
    return verdicts


def _apart(margin: Output, result: Result) -> tuple[str, ...]:
    """Rigid joints whose force a requirement is about, and which elastic bushes would load far more."""
    from rattle.results.contact_summary import far_apart

    return tuple(name for name in far_apart(result) if any(f"{name}.{kind}" in margin.names for kind in FORCES))


def _with_elastic_bushes(result: Result, joints: Sequence[str]) -> Result:
    """The result with the largest forces of elastic bushes in place of those of rigid joints."""
    from copy import copy

    changed = copy(result)
    changed.__dict__.pop("with_breaks", None)  # it is made anew, with these peaks
    changed.peaks = dict(result.peaks)
    for joint in joints:
        for name in (f"{joint}.{kind}" for kind in FORCES):
            if name in changed.peaks:
                changed.peaks[name] = changed.peaks[name]._replace(value=result.trust.elastic[joint][1])
    return changed


def check_deviations(m: Mechanism, curves: Sequence[str], limit: str | None) -> None:
    """Refuse a limit that is no deviation of every curve, before anything runs.  Raises InputError."""
    from rattle.studies.ensemble.limits import limit_of
    from rattle.studies.runs.task import task_of

    for curve in curves if limit is not None else ():
        band = task_of(m, (), [f"max({curve}.worst)"], analysis="accuracy").outputs[0]
        if limit_of(value(str(limit)), band.unit, f"--limit, for {curve}") < 0.0:
            raise click.UsageError(f"--limit is a deviation to either side, so not negative; got {limit}")


def judge_deviation(answer: Accuracy, limit: str) -> Verdict:
    """Whether an output with play stays within a deviation to either side."""
    from rattle.results.display import quantity
    from rattle.studies.ensemble.limits import limit_of

    allowed = limit_of(value(limit), answer.unit, "--limit")
    kept = bool(answer.largest <= allowed)
    deviation = quantity(answer.largest, answer.unit)
    said = f"limit {limit}: {'kept' if kept else 'EXCEEDED'}, {answer.of} deviates by {deviation}"
    return Verdict(kept, said, {"limit": allowed, "kept": kept, "largest": answer.largest})


def check_every(m: Mechanism, required: Sequence[str], varied: Sequence[str], **question: Any) -> None:
    """Refuse requirements that cannot be asked of every combination, before anything runs."""
    from rattle.studies.ensemble.limits import limit_of
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

    from rattle.studies.ensemble.limits import limit_of

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
        said = f"required {condition.text}: {'kept' if kept else 'NOT KEPT'} {where}"
        verdicts.append(Verdict(kept, said, {"condition": condition.text, "kept": kept, "not_kept": beyond.tolist()}))
    return verdicts


def judge_share(ensemble: Ensemble, required: Sequence[str]) -> list[Verdict]:
    """Whether enough mechanisms of an ensemble keep what is required."""
    verdicts = []
    for condition in map(Condition.read, required):
        above = condition.comparison in (">", ">=")
        share = (ensemble.yield_above if above else ensemble.yield_below)(condition.output, value(condition.limit))
        verdicts.append(of_share(f"keep {condition.text}", share, condition.share))
    return verdicts


def of_share(what: str, share: Bounded, required: float) -> Verdict:
    """Whether enough mechanisms keep something; share: of the mechanisms, with its bounds."""
    kept = bool(share[0] >= required)
    part, low, high = (100 * number for number in share)
    said = f"{part:.4g} % of the mechanisms {what} (95 %: {low:.4g} to {high:.4g} %); {said_required(required, kept)}"
    return Verdict(kept, said, {"condition": what, "kept": kept, "required": required, "share": share._asdict()})


def check_limits(m: Mechanism, required: Sequence[str], vary: Any, **question: Any) -> None:
    """Refuse limits of requirements that are no values of their outputs, before anything runs."""
    from rattle.studies.ensemble.ensemble import require_limit

    for condition in map(Condition.read, required):
        require_limit(m, condition.output, value(condition.limit), vary, **question)


def asked_outputs(required: Sequence[str]) -> list[str]:
    """The outputs that requirements are about.  Raises click.UsageError for what many mechanisms cannot be asked."""
    conditions = [Condition.read(text) for text in required]
    for condition in conditions:
        if condition.comparison == "==":
            raise click.UsageError(f"--require {condition.text}: of many mechanisms none keeps an equation")
    return [condition.output for condition in conditions]


def finish_required(ctx: click.Context, verdicts: Sequence[Verdict], say: Callable[[str], Any] | None) -> None:
    """Say what holds, unless `say` is None, and end with exit status 1 if something does not."""
    for verdict in verdicts:
        if say is not None:
            say(verdict.said)
    if not all(verdict.kept for verdict in verdicts):
        ctx.exit(1)
