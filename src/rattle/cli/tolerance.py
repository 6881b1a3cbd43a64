"""The command that says what each tolerance does, and which one to tighten."""

from __future__ import annotations

from typing import Any

import click
from click.core import ParameterSource

from rattle.cli.ensemble import question_options, tolerances, value
from rattle.cli.options import model_options, read_model
from rattle.cli.output import as_json, check_pictures, say_written


@click.command()
@model_options
@question_options(several=False)
@click.option(
    "--vary", "varied", multiple=True, metavar="NAMES",
    help='Parameters with a tolerance in the file: r3,r4; or with one here: "r3=0.1 mm,l2=0.5 mm:normal".  '
    "[default: all that have a tolerance]",
)  # fmt: skip
@click.option(
    "--limit", metavar="VALUE",
    help='The deviation that is allowed, e.g. "0.1 deg": how many mechanisms keep it, and which tolerances would.',
)  # fmt: skip
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
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, outputs: str, analysis: str,
    t_end: float | None, varied: tuple[str, ...], limit: str | None, allocate: str, costs: tuple[str, ...],
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
    """
    _require_sense(ctx)
    check_pictures(file, picture)
    m = read_model(file, settings, ideal)
    vary, cost = tolerances(varied), _costs(costs)
    common: dict[str, Any] = {"vary": vary, "analysis": analysis, "t_end": t_end, "n": count, "seed": seed,
                              "threads": threads, "progress": not ctx.obj["quiet"]}  # fmt: skip
    if parameter is not None and limit is not None:
        largest = m.tolerance_for(outputs, value(limit), parameter, share, **common)
        record: dict[str, Any] = {
            "parameter": parameter, "value": float(largest), "unit": largest.unit, "share": largest.share,
        }  # fmt: skip
        click.echo(as_json(record) if json_too else largest.report)
        return
    if limit is not None:
        from rattle.studies.ensemble.tolerance_study import require_limit

        require_limit(m, outputs, value(limit), cost, vary, analysis=analysis, t_end=t_end)
    study = m.tolerance(outputs, **common)
    parts, record = [str(study)], study.record()
    refused = ""
    if limit is not None:
        within = study.yield_within(value(limit))
        part, low, high = (100 * one for one in within)
        said = (
            f"{part:.4g} % of the mechanisms are within {limit} of the nominal value (95 %: {low:.4g} to {high:.4g} %)"
        )
        record |= {"share_within": within._asdict()}
        try:
            allocation = study.allocate(value(limit), allocate, cost)
        except ValueError as error:  # what is known all the same is worth its runs
            refused = str(error)
            parts += ["", said, f"no tolerances: {refused}"]
            record |= {"allocation": None, "refused": refused}
        else:
            parts += ["", said, "", str(allocation)]
            record |= {"allocation": allocation.tolerances}
    click.echo(as_json(record) if json_too else "\n".join(parts))
    if picture is not None:
        from rattle.plots.curves import save_figure

        save_figure(study.plot(), picture)
        say_written(picture)
    if refused:
        ctx.exit(1)


NEEDED = {
    "costs": ("--cost", "--limit"),
    "allocate": ("--allocate", "--limit"),
    "parameter": ("--largest", "--limit"),
    "share": ("--share", "--largest"),
}  # options, and those without which they have no meaning
USELESS = {"costs": "--cost", "allocate": "--allocate", "picture": "--plot"}  # beside --largest


def _require_sense(ctx: click.Context) -> None:
    """Refuse options that would be left out of account.  Raises UsageError."""
    given = {name for name in ctx.params if ctx.get_parameter_source(name) == ParameterSource.COMMANDLINE}
    asked = {"--limit": "limit" in given, "--largest": "parameter" in given}
    for name, (option, other) in NEEDED.items():
        if name in given and not asked[other]:
            what = {"--limit": ": the deviation that is allowed", "--largest": ": the parameter that is meant"}[other]
            raise click.UsageError(f"{option} needs {other}{what}")
    for name, option in USELESS.items():
        if name in given and asked["--largest"]:
            raise click.UsageError(f"{option} says nothing to --largest, which looks for one value; leave it out")


def _costs(given: tuple[str, ...]) -> dict[str, float] | None:
    found: dict[str, float] = {}
    for one in given:
        name, _, text = one.partition("=")
        if name.strip() in found:
            raise click.UsageError(f"--cost: '{name.strip()}' is given twice")
        try:
            found[name.strip()] = float(text)
        except ValueError:
            raise click.UsageError(f"--cost needs NAME=COST with a number, as in l2=3, got '{one}'") from None
    return found or None
