"""What commands write: file names checked before the analysis, results that are not lost, valid JSON."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.command import Options
from rattle.errors import InputError

if TYPE_CHECKING:
    from rattle.results.result import Result

STOPPED = 130  # exit status after Ctrl-C, as shells have it


# ---------------------------------------------------------------- JSON
def as_json(record: Any) -> str:
    """JSON text; numbers that are not finite become null, because JSON has none."""
    return json.dumps(_finite(record), indent=2, allow_nan=False)


def _finite(value: Any) -> Any:
    to_python = getattr(value, "tolist", None)
    value = to_python() if callable(to_python) else value
    if isinstance(value, Mapping):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


# ---------------------------------------------------------------- before the analysis: what can be refused is refused
fallback_option = click.option(
    "--fallback", metavar="FOLDER", help="Where to write saved results if their own disk is full."
)


def save_options(note: str = "") -> Options:
    """Add the options -o, --csv and --fallback to a command; note: how their help texts begin."""

    def add(function: Callable[..., Any]) -> Callable[..., Any]:
        function = fallback_option(function)
        function = click.option("--csv", metavar="FILE", help=f"{note}Also write all curves: .csv, .xlsx or .mat.")(
            function
        )
        return click.option(
            "-o", "--output", metavar="FILE", help=f"{note}Save the result (.nc or .npz), for plot, animate and export."
        )(function)

    return add


def check_results(read: str, output: str | None, csv: str | None, fallback: str | None) -> None:
    """Refuse file names under which a result cannot be saved. Raises InputError, OSError, click.UsageError."""
    from rattle.exchange.curve_files import require_curve_file
    from rattle.results import archive
    from rattle.user_paths import expanded

    if output is not None and Path(output).suffix.lower() in (".csv", ".xlsx", ".mat"):
        raise click.UsageError(
            f"-o {output}: a result is saved as .nc or .npz; --csv {output} writes its curves, and `rattle export` does"
            " so later"
        )
    if output is not None:
        archive.require(output)
    if csv is not None:
        require_curve_file(csv)
    check_files(read, output, csv)
    if fallback is not None and not expanded(fallback).is_dir():
        raise click.UsageError(f"--fallback needs a folder; {fallback} is not one")


def check_pictures(read: str, *paths: str | Path | None, moving: bool = False) -> None:
    """Refuse file names under which a picture cannot be written; moving: animations are allowed too.

    Raises InputError, OSError, MissingProgram.
    """
    from rattle.plots.curves import SUFFIXES
    from rattle.plots.movie_file import FILMS, require_film

    for path in paths:
        suffix = Path(path or "").suffix.lower()
        if path is None or suffix in SUFFIXES:
            continue
        if not moving or suffix not in (*FILMS, ".html"):
            films = f", an animation one in {' or '.join(FILMS)}" if moving else ""
            raise InputError(f"{path}: a picture needs a name ending in {', '.join(SUFFIXES)}{films}")
        require_film(path)
    check_files(read, *paths)


def check_files(read: str, *paths: str | Path | None) -> None:
    """Refuse places that cannot be written, the file that is read, and the same name twice."""
    from rattle.atomic_file import is_special, refuse_input, writable

    targets = [writable(path) for path in paths if path is not None]
    for path in targets:
        refuse_input(path, read)
    plain = [path for path in targets if not is_special(path)]
    if len(set(plain)) < len(plain):
        raise click.UsageError(f"two files are to be written under the name {plain[0]}")


# ---------------------------------------------------------------- after the analysis
def keep(result: Result, output: str | None, csv: str | None, fallback: str | None) -> bool:
    """Save a result; an interrupted one does not replace a file that is there.  False if it could not be saved."""
    from rattle.exchange.curve_files import write_curves

    kept = True
    for path, save in ((output, result.save), (csv, partial(write_curves, result))):
        if path is None:
            continue
        place = beside(path) if result.interrupted else path
        try:
            written = save(place, fallback=fallback)
        except OSError as error:
            click.echo(f"error: {error}", err=True)
            again = _another_place(save)
            kept = kept and again
            continue
        if str(written) != path:
            click.echo(f"saved as {written}", err=True)
    return kept


def beside(path: str) -> str:
    """The name for an unfinished result: the one asked for, or NAME.partial.nc if that file exists already."""
    file = Path(path)
    return str(file.with_name(f"{file.stem}.partial{file.suffix}")) if file.is_file() else path


def _another_place(save: Callable[[str], Any]) -> bool:
    """Ask for another name if a user sits at a terminal; the result stays in memory meanwhile."""
    while sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty():
        path = click.prompt("save it as (empty: do not save)", default="", show_default=False, err=True)
        if not path:
            return False
        try:
            save(path)
            return True
        except (OSError, ValueError) as error:
            click.echo(f"error: {error}", err=True)
    click.echo("the result was computed but not saved; --fallback FOLDER names another place to write to", err=True)
    return False


def finish(ctx: click.Context, result: Result, kept: bool = True) -> None:
    """End a command with the exit status of its result; the reason of a failure goes to stderr."""
    if not result.success and ctx.obj["quiet"]:
        click.echo(f"stopped: {result.message}", err=True)
    if result.cut_short:
        ctx.exit(STOPPED)
    if not result.success:
        ctx.exit(1)
    if not kept:
        ctx.exit(2)


def say_written(path: str | Path) -> None:
    """Print the name of a file that was written; on stderr if that file is stdout itself."""
    from rattle.atomic_file import is_special

    click.echo(str(path), err=is_special(path))
