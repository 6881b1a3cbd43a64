"""The motion that commands about strength follow, and where their answer goes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from rattle.cli.instants import span_times
from rattle.cli.options import time
from rattle.cli.question_command import Asked
from rattle.errors import InputError

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.results.result import Result

ANALYSES = ("simulate", "inverse-dynamics")
Command = TypeVar("Command", bound=Callable[..., Any])


def motion_options(command: Command) -> Command:
    """--analysis, --t-end and --points: which motion, until when, at how many instants."""
    options = (
        click.option(
            "--analysis", type=click.Choice(ANALYSES), default=ANALYSES[0], show_default=True,
            help="Which motion: in time, or as driven with all joints closed.",
        ),
        click.option("--t-end", type=time, help="End of the motion, in s or as '20 ms'; default: as in the model."),
        click.option(
            "--points", type=click.IntRange(2, 10_000_000), default=1001, show_default=True,
            help="Number of instants, evenly spaced in time.",
        ),
    )  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


def by_suffix(asked: Asked, what: str) -> Asked:
    """-o taken for a picture or a table.  Raises InputError for another file; what: is written, in words."""
    from rattle.plots.curves import SUFFIXES

    if asked.output is not None and Path(asked.output).suffix.lower() not in (*SUFFIXES, ".csv"):
        raise InputError(f"{asked.output}: {what} written as .csv, or as a picture in .svg, .png or .pdf")
    return asked.by_suffix()


def moved(asked: Asked, m: Mechanism, analysis: str, t_end: float | None, points: int) -> Result:
    """The motion at so many instants."""
    instants = span_times(m, t_end, points)
    if analysis == ANALYSES[0]:
        return m.simulate(float(instants[-1]), t_eval=instants, progress=asked.progress)
    return m.inverse_dynamics(instants)
