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

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.results.reductions import Output
    from rattle.results.result import Result

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
    "--require", "enough", metavar="SHARE",
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
    words: str
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
    vocabulary = Known.of(result)
    for condition in map(Condition.read, required):
        equal = condition.comparison == "=="
        constraint = read_constraint(condition.text, vocabulary)
        margin = evaluate(constraint.margin, result)
        output = read(condition.output, vocabulary)
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
        line = f"required {condition.text}: {'kept' if kept else 'NOT KEPT'}, {condition.output} {seen}"
        value_read = math.nan if towers else number
        record = {"condition": condition.text, "kept": kept, "value": value_read, "unit": output.unit}
        verdicts.append(Verdict(kept, line, record))
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


def asked_outputs(required: Sequence[str]) -> list[str]:
    """The outputs that requirements are about.  Raises click.UsageError for what many mechanisms cannot be asked."""
    conditions = [Condition.read(text) for text in required]
    for condition in conditions:
        if condition.comparison == "==":
            raise click.UsageError(f"--require {condition.text}: of many mechanisms none keeps an equation")
    return [condition.output for condition in conditions]


def required_record(verdicts: Sequence[Verdict]) -> dict[str, list[dict[str, Any]]]:
    """What JSON holds of requirements: nothing without any."""
    return {"required": [verdict.record for verdict in verdicts]} if verdicts else {}


def finish_required(ctx: click.Context, verdicts: Sequence[Verdict], say: Callable[[str], Any] | None) -> None:
    """Say what holds, unless `say` is None, and end with exit status 1 if something does not."""
    for verdict in verdicts:
        if say is not None:
            say(verdict.words)
    if not all(verdict.kept for verdict in verdicts):
        ctx.exit(1)
