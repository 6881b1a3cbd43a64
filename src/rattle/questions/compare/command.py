"""The command `rattle compare`."""

from __future__ import annotations

import click

from rattle.cli.options import time
from rattle.cli.output import STOPPED
from rattle.cli.question_command import Asked, Shown, json_option, model_command, picture_option


@model_command
@click.option(
    "--joint", metavar="JOINT", help="Joint whose force and orbit are shown; default: the first with clearance."
)
@click.option(
    "--curve", "curves", multiple=True, metavar="NAME",
    help="Curve of the motion to show, such as rocker.angle; may be given more than once; default: one of the last"
    " body.",
)  # fmt: skip
@click.option(
    "--law", metavar="NAME",
    help="Normal force law of the compliant run (`rattle kinds normal` lists them); default: the joint's own, "
    "otherwise exact.",
)  # fmt: skip
@click.option("--t-end", type=time, help="End of the runs, in s or as '20 ms'; default: one turn of the driver.")
@picture_option("Picture (.png, .svg, .pdf).", usual="compare.png")
@json_option("The table and its notes as JSON, in SI units.")
def compare(asked: Asked, joint: str | None, curves: tuple[str, ...], law: str | None, t_end: float | None) -> Shown:
    """Ideal joint, massless link, impact, compliant contact and oil on one page: motion, force, orbit, energy.

    FILE is a model file or the name of a shipped example.  Values that a compliant contact or oil needs and the file
    does not give are assumed; the page states them.

    \b
    Example:  rattle compare fourbar -o play.png
    """
    comparison = asked.model().compare(joint=joint, curve=curves, t_end=t_end, law=law, progress=asked.progress)
    results = comparison.results.values()
    stopped = any(result.cut_short for result in results)
    return Shown(
        lambda: str(comparison), comparison.record, () if stopped else asked.drawn(comparison.figure),
        status=STOPPED if stopped else int(not all(result.success for result in results)),
    )  # fmt: skip
