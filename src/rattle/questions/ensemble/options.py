"""What the commands that run many mechanisms share."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.command import Options
from rattle.cli.options import time, value
from rattle.cli.output import STOPPED
from rattle.cli.question_command import Asked, Shown, Written, json_option, picture_option
from rattle.cli.requirements import Condition, Verdict, said_required
from rattle.question import analysis_names
from rattle.value_types import Plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.mechanism import Mechanism
    from rattle.questions.ensemble.compute import Ensemble
    from rattle.questions.ensemble.runs import Samples
    from rattle.questions.ensemble.statistics import Bounded


def question_options(needed: bool = True) -> Options:
    """Add to a command what is asked of every mechanism: --of (needed: at least one), --analysis, --t-end."""

    def add(function: Plain) -> Plain:
        function = click.option(
            "--t-end", type=time,
            help="End of the runs, in s or as '20 ms'.  [default: as in the model; t = 0 for equilibrium and modes]",
        )(function)  # fmt: skip
        function = click.option(
            "--analysis", type=click.Choice(analysis_names()), default="simulate", show_default=True,
            help="What is run; accuracy has curves such as rocker.angle.high (band of play), modes mode1.frequency.",
        )(function)  # fmt: skip
        return click.option(
            "--of", "outputs", multiple=True, required=needed, metavar="OUTPUT",
            help='A number of a run, e.g. "max(O3.force)" or "at(rocker.angle, 0.3)"; may be given more than once.',
        )(function)  # fmt: skip

    return add


vary_option = click.option(
    "--vary", "varied", multiple=True, metavar="NAMES",
    help='Parameters with a tolerance in the file: r3,r4; or with one here: "r3=0.1 mm,l2=0.5 mm:normal".  '
    "[default: all that have a tolerance]",
)  # fmt: skip


def _is_workbook(csv: str | None) -> bool:
    return Path(csv or "").suffix.lower() == ".xlsx"


def _require_table(ctx: click.Context, param: click.Parameter, csv: str | None) -> str | None:
    """Refuse a name under which no table of samples is written, before anything runs.  Raises InputError."""
    from rattle.results.table_file import require_table

    if csv is not None and not _is_workbook(csv):
        require_table(csv)
    return csv


def engine_options(function: Plain) -> Plain:
    """Add to a command where runs take place, and where they are kept."""
    for option in (
        json_option("The answer as JSON, in SI units."),
        picture_option("Draw the first output (.svg, .png, .pdf).", "--plot"),
        click.option(
            "--csv", metavar="FILE", callback=_require_table,
            help="Write one row per mechanism, in SI units: .csv or .xlsx.",
        ),
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


def shown_runs(
    asked: Asked, runs: Samples, draw: Callable[[], Figure], words: Sequence[str] = (), *,
    record: dict[str, Any], verdicts: Sequence[Verdict] = (),
) -> Shown:  # fmt: skip
    """What is shown of runs: their own words and record, and more; table and picture are written."""
    write = runs.to_excel if _is_workbook(asked.csv) else runs.to_csv
    table = () if asked.csv is None else (Written(asked.csv, write),)
    status = STOPPED if runs.interrupted else int(not runs.counts()["ok"])
    return Shown(
        lambda: "\n".join([str(runs), *words]), lambda: runs.record() | record, (*table, *asked.drawn(draw)), verdicts,
        status,
    )  # fmt: skip


# ---------------------------------------------------------------- words of the command line
def tolerances(varied: tuple[str, ...]) -> Any:
    """What `vary` of an ensemble is: None, or parameters with what was said of them."""
    if not varied:
        return None
    fields: dict[str, Any] = {}
    for option in varied:
        for entry in re.split(r",(?![^(]*\))", option):  # a tolerance may be an expression: min(a, b)
            name, equals, text = (part.strip() for part in entry.partition("="))
            tol, _, dist = (part.strip() for part in text.partition(":"))
            if not name or (equals and not tol):
                raise click.UsageError(f"--vary needs NAME or NAME=TOL, as in r3,r4 or \"r3=0.1 mm\", got '{option}'")
            if name in fields:
                raise click.UsageError(f"--vary: '{name}' is given twice")
            fields[name] = {"tol": value(tol)} | ({"dist": dist} if dist else {}) if equals else {}
    return fields


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
    words = f"{part:.4g} % of the mechanisms {what} (95 %: {low:.4g} to {high:.4g} %); {said_required(required, kept)}"
    return Verdict(kept, words, {"condition": what, "kept": kept, "required": required, "share": share._asdict()})


def check_limits(m: Mechanism, required: Sequence[str], vary: Any, **question: Any) -> None:
    """Refuse limits of requirements that are no values of their outputs, before anything runs."""
    from rattle.questions.ensemble.compute import require_limit

    for condition in map(Condition.read, required):
        require_limit(m, condition.output, value(condition.limit), vary, **question)
