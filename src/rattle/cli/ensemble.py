"""The commands that run many mechanisms: ensembles with tolerances, and sweeps over grids."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model, shows_progress, time, value
from rattle.cli.output import STOPPED, as_json, check_files, check_pictures, say_written
from rattle.cli.requirements import (
    asked_outputs,
    check_every,
    check_limits,
    finish_required,
    judge_every,
    judge_share,
    of_share,
    required_share,
)

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.studies.ensemble.samples import Samples

MOST_VALUES = 2**20  # of one parameter of a sweep
ANALYSES = ("simulate", "kinematics", "inverse-dynamics", "equilibrium", "accuracy", "modes")


def question_options(needed: bool = True) -> Callable[..., Any]:
    """Add to a command what is asked of every mechanism: --of (needed: at least one), --analysis, --t-end."""

    def add(function: Callable[..., Any]) -> Callable[..., Any]:
        function = click.option(
            "--t-end", type=time,
            help="End of the runs, in s or as '20 ms'.  [default: as in the model; t = 0 for equilibrium and modes]",
        )(function)  # fmt: skip
        function = click.option(
            "--analysis", type=click.Choice(ANALYSES), default="simulate", show_default=True,
            help="What is run; accuracy has curves such as rocker.angle.high (band of play), modes mode1.frequency.",
        )(function)  # fmt: skip
        return click.option(
            "--of", "outputs", multiple=True, required=needed, metavar="OUTPUT",
            help='A number of a run, e.g. "max(O3.force)" or "at(rocker.angle, 0.3)"; may be given more than once.',
        )(function)  # fmt: skip

    return add


def engine_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add to a command where runs take place, and where they are kept."""
    for option in (
        click.option("--json", "json_too", is_flag=True, help="The answer as JSON, in SI units."),
        click.option("--plot", "picture", metavar="FILE", help="Draw the first output (.svg, .png, .pdf)."),
        click.option("--csv", metavar="FILE", help="Write one row per mechanism, in SI units."),
        click.option(
            "-o", "--output", "folder", metavar="FOLDER",
            help="Keep the runs there as they come (Parquet); the same command goes on after any interruption.",
        ),
        click.option("--scheduler", metavar="ADDRESS", help="Run on a Dask cluster, e.g. tcp://host:8786."),
        click.option("--workers", type=click.IntRange(1), metavar="N", help="Run in N processes of this machine."),
        click.option("--threads", type=click.IntRange(1), metavar="N", help="Threads.  [default: one per core]"),
    ):  # fmt: skip
        function = option(function)
    return function


@click.command(cls=Command)
@model_options
@click.option("-n", "count", type=int, default=1000, show_default=True, help="How many mechanisms.")
@question_options(needed=False)
@click.option(
    "--vary", "varied", multiple=True, metavar="NAMES",
    help='Parameters with a tolerance in the file: r3,r4; or with one here: "r3=0.1 mm,l2=0.5 mm:normal".  '
    "[default: all that have a tolerance]",
)  # fmt: skip
@click.option("--seed", default=0, show_default=True, help="Mechanism i depends on the seed and on i alone.")
@click.option(
    "--design", type=click.Choice(["sobol", "halton", "lhs", "random"]), default="sobol", show_default=True,
    help="How the fields are sampled: evenly (sobol, halton, lhs), or independently (random).",
)  # fmt: skip
@click.option(
    "--history",
    "histories",
    multiple=True,
    metavar="CURVE",
    help="Keep this curve of every mechanism too, at 201 instants (netCDF, with -o); may be given more than once.",
)
@click.option("--limit", metavar="VALUE", help='Also: how many stay at or below it, e.g. "5 kN"; for one --of.')
@click.option(
    "--require", "required", multiple=True, metavar="CONDITION",
    help='What 99.73 % of the mechanisms have to keep, or the exit status is 1: "max(B.force) < 2 kN", or for another'
    ' share "max(B.force) < 2 kN: 95 %"; 95% alone is about --limit.  May be given more than once.',
)  # fmt: skip
@engine_options
@click.pass_context
def ensemble(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, count: int, outputs: tuple[str, ...],
    analysis: str, t_end: float | None, varied: tuple[str, ...], seed: int, design: str, limit: str | None,
    required: tuple[str, ...], histories: tuple[str, ...],
    threads: int | None, workers: int | None, scheduler: str | None, folder: str | None, csv: str | None,
    picture: str | None, json_too: bool,
) -> None:  # fmt: skip
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
    shares = [text for text in required if "%" in text and not any(sign in text for sign in "<>=")]
    conditions = [text for text in required if text not in shares]
    if len(shares) > (limit is not None):
        raise click.UsageError(
            f"--require {shares[-1]}: one share of the mechanisms, beside the --limit that they keep"
        )
    needed = required_share(shares[0] if shares else None)
    outputs = tuple(dict.fromkeys([*outputs, *asked_outputs(conditions)]))
    if not outputs:
        raise click.UsageError('--of names what is asked of every mechanism, e.g. --of "max(O3.force)"')
    if limit is not None and len(outputs) > 1:
        raise click.UsageError(
            f'--limit is for one --of; with several say what each has to keep: --require "{outputs[0]} <= {limit}"'
        )
    if histories and folder is None:
        raise click.UsageError("--history keeps curves in a folder: give one with -o")
    _check(file, csv, picture)
    m = read_model(file, settings, ideal)
    vary = tolerances(varied)
    if limit is not None:
        from rattle.studies.ensemble.ensemble import require_limit

        require_limit(m, outputs[0], value(limit), vary, analysis=analysis, t_end=t_end)
    check_limits(m, conditions, vary, analysis=analysis, t_end=t_end)
    found = m.ensemble(
        count, list(outputs), vary, seed=seed, analysis=analysis, t_end=t_end, design=design,
        threads=threads, workers=workers, scheduler=scheduler, folder=folder, histories=histories,
        progress=shows_progress(ctx),
    )  # fmt: skip
    share = None if limit is None else found.yield_below(outputs[0], value(limit))
    verdicts = judge_share(found, conditions)
    if share is not None:
        verdicts.insert(0, of_share(f"stay at or below {limit}", share, needed))
    if json_too:
        below = {} if share is None else {"share_below": share._asdict()}
        asked = {"required": [verdict.record for verdict in verdicts]} if verdicts else {}
        click.echo(as_json(found.record() | below | asked))
    else:
        click.echo(str(found))
        for verdict in verdicts:
            click.echo(verdict.said)
    _keep(ctx, found, csv, picture, lambda: found.plot(outputs[0], limit=None if limit is None else value(limit)))
    if not all(verdict.kept for verdict in verdicts):
        ctx.exit(1)


@click.command(cls=Command)
@model_options
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
@click.pass_context
def sweep(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, ranges: tuple[str, ...],
    outputs: tuple[str, ...], analysis: str, t_end: float | None, required: tuple[str, ...], threads: int | None,
    workers: int | None, scheduler: str | None, folder: str | None, csv: str | None, picture: str | None,
    json_too: bool,
) -> None:  # fmt: skip
    """Numbers over all combinations of values of parameters: a curve for one, a map for two.

    FILE is a model file or the name of a shipped example.  --over also takes the path of a number of the model, such as
    joints.B.contact.restitution.

    \b
    Examples: rattle sweep slider_crank_play --over "c=0.1 mm:0.5 mm:9" --of "max(B.normal)" --t-end 6ms
              rattle sweep slider_crank --analysis kinematics --over "rod_length=.1:.2:11" --of "max(slider.ax)"
    """
    _check(file, csv, picture)
    outputs = tuple(dict.fromkeys([*outputs, *asked_outputs(required)]))
    if not outputs:
        raise click.UsageError('--of names what is asked of every combination, e.g. --of "max(O3.force)"')
    m, axes = axes_of(read_model(file, settings, ideal), ranges)
    check_every(m, required, list(axes), analysis=analysis, t_end=t_end)
    found = m.sweep(
        axes, list(outputs), analysis=analysis, t_end=t_end, threads=threads, workers=workers, scheduler=scheduler,
        folder=folder, progress=shows_progress(ctx),
    )  # fmt: skip
    verdicts = judge_every(found, required)
    asked = {"required": [verdict.record for verdict in verdicts]} if verdicts else {}
    click.echo(as_json(found.record() | asked) if json_too else str(found))
    _keep(ctx, found, csv, picture, lambda: found.plot(outputs[0]))
    finish_required(ctx, verdicts, None if json_too else click.echo)


def _check(file: str, csv: str | None, picture: str | None) -> None:
    """Refuse files that cannot be written."""
    if csv is not None:
        from rattle.results.result import require_table

        require_table(csv)
    check_pictures(file, picture)
    check_files(file, csv, picture)


def _keep(ctx: click.Context, found: Samples, csv: str | None, picture: str | None, draw: Callable[[], Any]) -> None:
    """Write table and picture, and end with the exit status of the runs."""
    if csv is not None:
        found.to_csv(csv)
        say_written(csv)
    if picture is not None:
        from rattle.plots.curves import save_figure

        save_figure(draw(), picture)
        say_written(picture)
    if found.interrupted:
        ctx.exit(STOPPED)
    if not found.counts()["ok"]:
        ctx.exit(1)


# ---------------------------------------------------------------- words of the command line
def tolerances(varied: tuple[str, ...]) -> Any:
    """What `vary` of an ensemble is: None, or parameters with what was said of them."""
    if not varied:
        return None
    found: dict[str, Any] = {}
    for given in varied:
        for one in re.split(r",(?![^(]*\))", given):  # a tolerance may be an expression: min(a, b)
            name, equals, text = (part.strip() for part in one.partition("="))
            tol, _, dist = (part.strip() for part in text.partition(":"))
            if not name or (equals and not tol):
                raise click.UsageError(f"--vary needs NAME or NAME=TOL, as in r3,r4 or \"r3=0.1 mm\", got '{given}'")
            if name in found:
                raise click.UsageError(f"--vary: '{name}' is given twice")
            found[name] = {"tol": value(tol)} | ({"dist": dist} if dist else {}) if equals else {}
    return found


def axes_of(m: Mechanism, ranges: tuple[str, ...]) -> tuple[Mechanism, dict[str, list[float | str]]]:
    """Parameters of --over and their values, and the mechanism in which a path of --over is a parameter."""
    axes: dict[str, list[float | str]] = {}
    for text in ranges:
        name, values = axis_values(text)
        if "." in name:
            m, name = _as_parameter(m, name, values)
        if name in axes:
            raise click.UsageError(f"--over: '{name}' is given twice")
        axes[name] = values
    return m, axes


def _as_parameter(m: Mechanism, path: str, values: list[float | str]) -> tuple[Mechanism, str]:
    """The mechanism with a parameter in place of the number at a path, and its name.  Raises ModelError."""
    import json
    import logging

    name = "_".join(path.split(".")[1:])
    while name in m.parameters:
        name += "_"
    before = json.loads(m.to_json())
    for key in path.split("."):
        before = before.get(key) if isinstance(before, dict) else None
    number = isinstance(before, int | float | str) and not isinstance(before, bool)
    m = m.set({f"parameters.{name}": before if number else values[0], path: name})
    logging.getLogger("rattle").info(f"{path} is the parameter {name} here")
    return m, name


def axis_values(text: str) -> tuple[str, list[float | str]]:
    """A parameter and its values from NAME=FIRST:LAST:COUNT or NAME=VALUE,VALUE."""
    from rattle.language.units import QuantityError, parse_quantity, unit_name

    name, _, rest = text.partition("=")
    parts = [one.strip() for one in rest.split(":")]
    if not name.strip() or not rest.strip() or len(parts) not in (1, 3):
        raise click.UsageError(f"--over needs NAME=FIRST:LAST:COUNT, as in r3=0.001:0.005:21, got '{text}'")
    if len(parts) == 1:
        return name.strip(), [value(one) for one in rest.split(",")]
    try:
        first, last = (parse_quantity(one) or (float(one), None) for one in parts[:2])
    except (QuantityError, ValueError) as error:
        raise click.UsageError(f"--over {text}: {error}") from None
    if not parts[2].isdecimal() or not 1 <= (count := int(parts[2])) <= MOST_VALUES:
        said = f"the number of values must be a whole number from 1 to {MOST_VALUES}, got '{parts[2]}'"
        raise click.UsageError(f"--over {text}: {said}")
    if first[1] != last[1] and all(end[0] or end[1] is not None for end in (first, last)):  # 0 has every unit
        raise click.UsageError(f"--over {text}: both ends need the same kind of unit, as in r3=1 mm:5 mm:21")
    import numpy as np

    dimension = last[1] if first[1] is None else first[1]
    unit = "" if dimension is None else unit_name(dimension) or "rad"  # kept: it may not be that of the parameter
    values = np.linspace(first[0], last[0], count).tolist()
    return name.strip(), [f"{x!r} {unit}" if unit else x for x in values]
