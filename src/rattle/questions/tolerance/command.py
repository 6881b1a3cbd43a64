"""The command `rattle tolerance`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import click

from rattle.cli.options import given, value
from rattle.cli.question_command import Asked, Shown, alone_or_all, json_option, model_command, picture_option
from rattle.cli.requirements import require_share_option, required_share, said_required
from rattle.questions.ensemble.options import question_options, tolerances, vary_option

if TYPE_CHECKING:
    from rattle.questions.tolerance.largest import Largest
    from rattle.questions.tolerance.report import Tolerance


@model_command
@question_options()
@vary_option
@click.option(
    "--limit", metavar="VALUE",
    help='The deviation that is allowed, e.g. "0.1 deg": how many mechanisms keep it, and which tolerances would.',
)  # fmt: skip
@require_share_option
@click.option(
    "--allocate", type=click.Choice(["rss", "worst-case"]), default="rss", show_default=True,
    help="With --limit: tolerances of which 99.73 % of the mechanisms keep it, or all corners.",
)  # fmt: skip
@click.option(
    "--cost", "costs", multiple=True, metavar="NAME=COST",
    help="With --limit: what a tolerance costs, COST/tol; for all that vary.  [default: equal contributions]",
)  # fmt: skip
@click.option(
    "--largest", "parameter", metavar="NAME",
    help="With --limit: the largest tolerance of one parameter (or value of a clearance), all others as they are.",
)  # fmt: skip
@click.option(
    "--share", default=0.997, show_default=True, help="With --largest: of the mechanisms that keep the limit."
)
@click.option("-n", "count", type=click.IntRange(1), help="Rows of samples.  [default: 1024 side by side, else 512]")
@click.option("--seed", default=0, show_default=True, help="Of the samples; the same seed, the same answer.")
@click.option("--threads", type=click.IntRange(1), metavar="N", help="Threads.  [default: one per core]")
@picture_option("Draw the contributions (.svg, .png, .pdf).", "--plot")
@json_option("The answer as JSON, in SI units.")
def tolerance(
    asked: Asked, outputs: tuple[str, ...], varied: tuple[str, ...], limit: str | None, enough: str | None,
    allocate: str, costs: tuple[str, ...], parameter: str | None, share: float, count: int | None, **question: Any,
) -> Shown:  # fmt: skip
    """What each tolerance does to a number: worst case, root sum square and samples side by side.

    FILE is a model file or the name of a shipped example.  Tolerances stand there beside the values:
    l2 = { value = "0.6 m", tol = "0.1 mm", dist = "normal" }.

    \b
    Examples: rattle tolerance slider_crank --analysis kinematics --of "at(slider.x, 0.003)"
              rattle tolerance slider_crank --analysis kinematics --of "at(slider.x, 0.003)" --limit "0.04 mm"
              rattle tolerance fourbar --ideal --analysis kinematics --t-end .1 --of "at(rocker.angle, .1)" --plot t.svg

    The table has the slope of every parameter, exact where the mechanism can be recorded, and what its tolerance
    amounts to.  Sobol indices say which share of the scatter it causes, alone and together with others.
    With --limit the exit status is 1 if fewer than 99.73 % of the mechanisms keep it, or than --require asks for.
    """
    _require_sense(click.get_current_context())
    m = asked.model()
    vary, cost = tolerances(varied), _costs(costs)
    question |= {"vary": vary, "n": count, "progress": asked.progress}
    if parameter is not None and limit is not None:
        largest = [m.tolerance_for(output, value(limit), parameter, share, **question) for output in outputs]
        return Shown(
            lambda: "\n\n".join(answer.report for answer in largest), lambda: alone_or_all([*map(_record, largest)])
        )
    if limit is not None:
        from rattle.questions.tolerance.compute import require_limit

        for output in outputs:
            require_limit(m, output, value(limit), cost, vary, analysis=question["analysis"], t_end=question["t_end"])
    needed = required_share(enough)
    studies = [m.tolerance(output, **question) for output in outputs]
    answers = [_Answer.of(study, limit, allocate, cost, needed) for study in studies]
    return Shown(
        lambda: "\n\n".join(answer.text for answer in answers),
        lambda: alone_or_all([answer.record for answer in answers]),
        asked.drawn(*(study.plot for study in studies), named=range(1, len(studies) + 1)),
        status=0 if all(answer.kept for answer in answers) else 1,
    )


class _Answer(NamedTuple):
    """What is said of one output."""

    text: str
    record: dict[str, Any]
    kept: bool  # the limit is kept by as many mechanisms as required, and tolerances that do so were found

    @classmethod
    def of(
        cls, study: Tolerance, limit: str | None, allocate: str, cost: dict[str, float] | None, needed: float
    ) -> _Answer:
        """The study of one output, and with a limit: who keeps it, and which tolerances would."""
        parts, record = [str(study)], study.record()
        if limit is None:
            return cls("\n".join(parts), record, True)
        within = study.yield_within(value(limit))
        part, low, high = (100 * share for share in within)
        kept = within[0] >= needed
        parts += [
            "",
            f"{part:.4g} % of the mechanisms are within {limit} of the nominal value (95 %: {low:.4g} to {high:.4g} %);"
            f" {said_required(needed, kept)}",
        ]
        record |= {"share_within": within._asdict(), "required": needed, "kept": kept}
        try:
            allocation = study.allocate(value(limit), allocate, cost)
        except ValueError as error:  # what is known all the same is worth its runs
            parts.append(f"no tolerances: {error}")
            return cls("\n".join(parts), record | {"allocation": None, "refused": str(error)}, False)
        parts += ["", str(allocation)]
        return cls("\n".join(parts), record | {"allocation": allocation.tolerances}, kept)


def _record(largest: Largest) -> dict[str, float | str]:
    """The largest value of a parameter."""
    return {"parameter": largest.parameter, "value": float(largest), "unit": largest.unit, "share": largest.share}


NEEDED = {
    "costs": ("--cost", "--limit"),
    "allocate": ("--allocate", "--limit"),
    "parameter": ("--largest", "--limit"),
    "share": ("--share", "--largest"),
    "enough": ("--require", "--limit"),
}  # options, and those without which they have no meaning
USELESS = {  # beside --largest
    "costs": "--cost", "allocate": "--allocate", "picture": "--plot", "enough": "--require",
}  # fmt: skip


def _require_sense(ctx: click.Context) -> None:
    """Refuse options that would be left out of account.  Raises UsageError."""
    typed = {name for name in ctx.params if given(ctx, name)}
    asked = {"--limit": "limit" in typed, "--largest": "parameter" in typed}
    for name, (option, other) in NEEDED.items():
        if name in typed and not asked[other]:
            what = {"--limit": ": the deviation that is allowed", "--largest": ": the parameter that is meant"}[other]
            raise click.UsageError(f"{option} needs {other}{what}")
    for name, option in USELESS.items():
        if name in typed and asked["--largest"]:
            raise click.UsageError(f"{option} says nothing to --largest, which looks for one value; leave it out")


def _costs(texts: tuple[str, ...]) -> dict[str, float] | None:
    costs: dict[str, float] = {}
    for entry in texts:
        name, _, text = entry.partition("=")
        if name.strip() in costs:
            raise click.UsageError(f"--cost: '{name.strip()}' is given twice")
        try:
            costs[name.strip()] = float(text)
        except ValueError:
            raise click.UsageError(f"--cost needs NAME=COST with a number, as in l2=3, got '{entry}'") from None
    return costs or None
