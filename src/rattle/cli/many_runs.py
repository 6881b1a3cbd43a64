"""What the commands that run many mechanisms share."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.options import time, value
from rattle.cli.output import STOPPED, check_files, check_pictures, say_written
from rattle.question import analysis_names

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.studies.ensemble.samples import Samples

MOST_VALUES = 2**20  # of one parameter of a sweep


def question_options(needed: bool = True) -> Callable[..., Any]:
    """Add to a command what is asked of every mechanism: --of (needed: at least one), --analysis, --t-end."""

    def add(function: Callable[..., Any]) -> Callable[..., Any]:
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


def check_written(file: str, csv: str | None, picture: str | None) -> None:
    """Refuse files that cannot be written."""
    if csv is not None:
        from rattle.results.result import require_table

        require_table(csv)
    check_pictures(file, picture)
    check_files(file, csv, picture)


def keep_runs(ctx: click.Context, runs: Samples, csv: str | None, picture: str | None, draw: Callable[[], Any]) -> None:
    """Write table and picture, and end with the exit status of the runs."""
    if csv is not None:
        runs.to_csv(csv)
        say_written(csv)
    if picture is not None:
        from rattle.plots.curves import save_figure

        save_figure(draw(), picture)
        say_written(picture)
    if runs.interrupted:
        ctx.exit(STOPPED)
    if not runs.counts()["ok"]:
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
