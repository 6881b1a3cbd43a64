"""The motion that commands about strength follow, and where their answer goes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rattle.cli.instants import span_times
from rattle.cli.question_command import Asked
from rattle.errors import InputError

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.results.result import Result

ANALYSES = ("simulate", "inverse-dynamics")


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
