"""The command that writes a mechanism as a page that computes."""

from __future__ import annotations

import logging

import click

from rattle.answers.arguments import listed
from rattle.cli.command import Command
from rattle.cli.measured import measured_option
from rattle.cli.options import model_options, page_options, read_model, shows_progress, time
from rattle.cli.output import check_files, say_written


@click.command(cls=Command)
@model_options
@click.option(
    "-o", "--output", metavar="FILE", default="page.html", show_default=True, help="The page to write (.html)."
)
@click.option("--t-end", type=time, help="End of the motion, in s or as '20 ms'; default: as in the model.")
@click.option(
    "--over", "ranges", multiple=True, metavar="NAME=FIRST:LAST:COUNT",
    help="The page holds the runs for these values instead of computing: also NAME=VALUE,VALUE; given twice, all"
    " combinations.",
)  # fmt: skip
@page_options
@measured_option
@click.option(
    "--trust/--no-trust", default=True, help="Whether one can read why a run can be trusted, or see the word alone."
)
@click.pass_context
def page(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, output: str, t_end: float | None,
    ranges: tuple[str, ...], title: str, curves: tuple[str, ...], measured: tuple[str, ...], trust: bool,
    language: str,
) -> None:  # fmt: skip
    """Write a mechanism as one web page that computes: turn a parameter and the motion follows.

    FILE is a model file or the name of a shipped example.  The page is a single file without a server and without the
    internet, to be mailed or put on a site; it works on a phone.  Parameters with min and max in the model file become
    sliders, the others number boxes; two sets of them can be compared.  The page says how far its motion can be trusted
    in the words of `rattle run`.

    Contacts, impacts, friction, clutches and oil are computed in the page too, by rattle's own kernels.  Laws in Python
    are not: such a page holds the runs of a small sweep, three to seven values between min and max of every parameter,
    to choose from.  --over asks for such a page with values of your own.

    \b
    Examples: rattle page fourbar -o fourbar.html
              rattle page slider_crank --set "speed=3000 rpm" -o fast.html
              rattle page slider_crank_play --over "c=0.2 mm:0.6 mm:3" --t-end 6ms -o play.html
              rattle page fourbar --title "Task 3" --curves rocker.angle,O3.normal --no-trust -o task.html
              rattle page fourbar --with measured.csv:theta=rocker.angle -o beside.html
              rattle page slider_crank --title "Schubkurbel" --language de -o schubkurbel.html
    """
    from rattle.cli.over import axes_of
    from rattle.pages.page import page as write

    if not output.lower().endswith((".html", ".htm")):
        raise click.UsageError(f"-o {output}: a page needs a name that ends in .html")
    check_files(file, output)
    if t_end is not None and not t_end > 0.0:
        raise click.UsageError("--t-end must be positive")
    m, axes = axes_of(read_model(file, settings, ideal), ranges)
    why = write(
        m, output, t_end=t_end, over=axes or None, progress=shows_progress(ctx), title=title, curves=listed(*curves),
        trust=trust, language=language, measured=measured,
    )  # fmt: skip
    if why and not ranges:
        logging.getLogger("rattle").info(f"the page replays runs that were computed now, because {why}")
    say_written(output)
