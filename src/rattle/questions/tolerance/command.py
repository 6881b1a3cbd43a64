"""The command `rattle tolerance`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click
from click.core import ParameterSource

from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model, shows_progress, value
from rattle.cli.output import as_json, check_pictures, say_written
from rattle.cli.requirements import require_share_option, required_share, said_required
from rattle.questions.ensemble.options import question_options, tolerances

if TYPE_CHECKING:
    from rattle.questions.tolerance.largest import Largest
    from rattle.questions.tolerance.report import Tolerance


@click.command(cls=Command)
@model_options
@question_options()
@click.option(
    "--vary", "varied", multiple=True, metavar="NAMES",
    help='Parameters with a tolerance in the file: r3,r4; or with one here: "r3=0.1 mm,l2=0.5 mm:normal".  '
    "[default: all that have a tolerance]",
)  # fmt: skip
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
@click.option("--plot", "picture", metavar="FILE", help="Draw the contributions (.svg, .png, .pdf).")
@click.option("--json", "json_too", is_flag=True, help="The answer as JSON, in SI units.")
@click.pass_context
def tolerance(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, outputs: tuple[str, ...], analysis: str,
    t_end: float | None, varied: tuple[str, ...], limit: str | None, required: str | None, allocate: str,
    costs: tuple[str, ...],
    parameter: str | None, share: float, count: int | None, seed: int, threads: int | None, picture: str | None,
    json_too: bool,
) -> None:  # fmt: skip
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
    _require_sense(ctx)
    check_pictures(file, picture)
    m = read_model(file, settings, ideal)
    vary, cost = tolerances(varied), _costs(costs)
    common: dict[str, Any] = {"vary": vary, "analysis": analysis, "t_end": t_end, "n": count, "seed": seed,
                              "threads": threads, "progress": shows_progress(ctx)}  # fmt: skip
    if parameter is not None and limit is not None:
        answer = [m.tolerance_for(output, value(limit), parameter, share, **common) for output in outputs]
        click.echo(_largest(answer, json_too))
        return
    if limit is not None:
        from rattle.questions.tolerance.compute import require_limit

        for output in outputs:
            require_limit(m, output, value(limit), cost, vary, analysis=analysis, t_end=t_end)
    needed = required_share(required)
    answers = []
    for number, output in enumerate(outputs, 1):
        study = m.tolerance(output, **common)
        answers.append(_Answer.of(study, limit, allocate, cost, needed))
        if picture is not None:
            from rattle.plots.curves import save_figure

            target = picture if len(outputs) == 1 else str(Path(picture).with_stem(f"{Path(picture).stem}-{number}"))
            save_figure(study.plot(), target)
            say_written(target)
    click.echo(as_json(_together([a.record for a in answers])) if json_too else "\n\n".join(a.text for a in answers))
    if not all(answer.kept for answer in answers):
        ctx.exit(1)


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


def _largest(answer: list[Largest], json_too: bool) -> str:
    """The largest values of a parameter for each output, as they are printed."""
    if not json_too:
        return "\n\n".join(largest.report for largest in answer)
    records = [
        {"parameter": largest.parameter, "value": float(largest), "unit": largest.unit, "share": largest.share}
        for largest in answer
    ]
    return as_json(_together(records))


def _together(records: list[dict[str, Any]]) -> Any:
    """What JSON holds: the record of one output, or a list of several."""
    return records[0] if len(records) == 1 else records


NEEDED = {
    "costs": ("--cost", "--limit"),
    "allocate": ("--allocate", "--limit"),
    "parameter": ("--largest", "--limit"),
    "share": ("--share", "--largest"),
    "required": ("--require", "--limit"),
}  # options, and those without which they have no meaning
USELESS = {
    "costs": "--cost",
    "allocate": "--allocate",
    "picture": "--plot",
    "required": "--require",
}  # beside --largest


def _require_sense(ctx: click.Context) -> None:
    """Refuse options that would be left out of account.  Raises UsageError."""
    typed = {name for name in ctx.params if ctx.get_parameter_source(name) == ParameterSource.COMMANDLINE}
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
