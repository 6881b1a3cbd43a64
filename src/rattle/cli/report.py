"""The command report."""

from __future__ import annotations

from collections.abc import Iterable

import click

from rattle.cli.command import Command
from rattle.cli.measured import measured_option
from rattle.cli.options import model_options, read_model, shows_progress, time
from rattle.cli.output import check_files, say_written


@click.command(cls=Command)
@model_options
@click.option(
    "-o", "--output", metavar="FILE", default=None, help="File to write: .html, or .pdf printed by a browser."
)
@click.option("--t-end", type=time, help="End of the motion, in s or as '20 ms'; default: as in the model.")
@click.option("--title", default="", help="Title of the report; default: the name of the model.")
@click.option("--author", default="", help="Who made it, below the title.")
@click.option("--paper", type=click.Choice(["A4", "Letter"]), default="A4", show_default=True, help="Paper of a .pdf.")
@measured_option
@click.pass_context
def report(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, output: str | None, t_end: float | None,
    title: str, author: str, paper: str, measured: tuple[str, ...],
) -> None:  # fmt: skip
    """A report to hand on: model, drawing, assumptions, motion, forces, contacts, power, and how far to trust them.

    One page that needs nothing else and prints well, by default FILE.html.  What does not apply to the mechanism is
    left out, with the reason.  A motion that fails gives a report that says so at its top, and exit status 1.

    FILE is a model file or the name of a shipped example.

    \b
    Example:  rattle report slider_crank -o engine.html
              rattle report slider_crank --set speed="3000 rpm" --author "A. Engineer" -o slower.html
              rattle report fourbar --with measured.csv:theta=rocker.angle
    """
    from pathlib import Path

    from rattle.pages.report import require_name, write_report

    m = read_model(file, settings, ideal)
    target = Path(output) if output else Path(f"{Path(file).stem}.html")
    require_name(target, paper)
    check_files(file, target)
    command = _typed(ctx, file, target)
    written = write_report(
        m, target, title=title, author=author, t_end=t_end, paper=paper, command=command,
        progress=shows_progress(ctx), measured=measured,
    )  # fmt: skip
    say_written(target)
    if written.trouble:
        for problem in written.trouble:
            click.echo(f"error: {problem}", err=True)
        ctx.exit(1)


def _typed(ctx: click.Context, file: str, target: object) -> str:
    """The command as it was typed, files by their names alone: folders of a machine are no business of a reader."""
    import shlex
    from pathlib import Path

    from rattle.exchange.measured import without_folder

    words = ["rattle", "report", Path(file).name]
    options = {param.name: param for param in ctx.command.params if isinstance(param, click.Option)}
    for name, value in ctx.params.items():
        option = options.get(name)
        if option is not None and name != "output" and value and value != option.default:
            entries = map(without_folder, value) if name == "measured" else value
            words += _flags(option.opts[-1], entries if isinstance(value, tuple) else (value,))
    words += ["--units", units] if (units := ctx.meta.get("rattle.units")) else []
    words += [part for path in ctx.meta.get("rattle.without", ()) for part in ("--without", path)]
    words += [part for path in ctx.meta.get("rattle.laws", ()) for part in ("--laws", Path(path).name)]
    return shlex.join([*words, "-o", Path(str(target)).name])


def _flags(flag: str, entries: Iterable[object]) -> list[str]:
    """An option with all that it was given."""
    return [word for entry in entries for word in ([flag] if entry is True else [flag, str(entry)])]
