"""The command `rattle draw`."""

from __future__ import annotations

import click

from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model
from rattle.cli.output import check_pictures, say_written


@click.command(cls=Command)
@model_options
@click.option(
    "-o", "--output", metavar="FILE", default=None,
    help="Picture to write (.png, .svg, .pdf); default: the name of FILE with .png, in the current folder.",
)  # fmt: skip
@click.pass_context
def draw(ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, output: str | None) -> None:
    """Draw a mechanism as put together, before any run: to scale, with everything in it by name.

    Bodies, joints with their play, points, mass centres, drivers, springs, the other loads as arrows of what they exert
    at the start, and the degrees of freedom.  A mechanism that cannot be put together is drawn with its bodies where
    they were first guessed to be, the open joints in red, and the exit status is 1.

    \b
    Example:  rattle draw fourbar -o fourbar.svg
              rattle draw fourbar --set l2="0.7 m"
    """
    from pathlib import Path

    from rattle.errors import AssemblyError
    from rattle.plots.curves import save_figure

    m = read_model(file, settings, ideal)
    target = Path(output) if output else Path(f"{Path(file).stem}.png")
    check_pictures(file, target)
    save_figure(m.plot(), target)
    say_written(target)
    try:
        _ = m.start
    except AssemblyError as error:
        click.echo(f"error: {error}", err=True)
        ctx.exit(1)
