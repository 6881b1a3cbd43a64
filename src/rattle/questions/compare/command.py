"""The command `rattle compare`."""

from __future__ import annotations

import click

from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model, shows_progress, time
from rattle.cli.output import STOPPED, check_pictures, say_written


@click.command(cls=Command)
@model_options
@click.option(
    "--joint", metavar="JOINT", help="Joint whose force and orbit are shown; default: the first with clearance."
)
@click.option(
    "--curve", "curves", multiple=True, metavar="NAME",
    help="Curve of the motion to show, such as rocker.angle; may be given more than once; default: one of the last"
    " body.",
)  # fmt: skip
@click.option(
    "--law",
    metavar="NAME",
    help="Normal force law of the compliant run (`rattle kinds normal` lists them); default: the joint's own, "
    "otherwise exact.",
)
@click.option("--t-end", type=time, help="End of the runs, in s or as '20 ms'; default: one turn of the driver.")
@click.option(
    "-o", "--output", metavar="FILE", default="compare.png", show_default=True, help="Picture (.png, .svg, .pdf)."
)
@click.pass_context
def compare(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, joint: str | None,
    curves: tuple[str, ...], law: str | None, t_end: float | None, output: str,
) -> None:  # fmt: skip
    """Ideal joint, massless link, impact, compliant contact and oil on one page: motion, force, orbit, energy.

    FILE is a model file or the name of a shipped example.  Values that a compliant contact or oil needs and the file
    does not give are assumed; the page states them.

    \b
    Example:  rattle compare fourbar -o play.png
    """
    from rattle.plots.curves import save_figure

    check_pictures(file, output)
    comparison = read_model(file, settings, ideal).compare(
        joint=joint, curve=curves, t_end=t_end, law=law, progress=shows_progress(ctx)
    )
    click.echo(str(comparison))
    if any(r.cut_short for r in comparison.results.values()):
        ctx.exit(STOPPED)
    save_figure(comparison.figure(), output)
    say_written(output)
    if not all(r.success for r in comparison.results.values()):
        ctx.exit(1)
