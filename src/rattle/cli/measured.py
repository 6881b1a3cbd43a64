"""The option --with of commands that show curves: measured ones beside them."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rattle.exchange.residuals import Residual
    from rattle.results.result import Result

measured_option = click.option(
    "--with", "measured", multiple=True, metavar="FILE[:COLUMN[=CURVE]][@TIME]",
    help="A measured curve beside that of the run: a column of a text file with names and units in its head, such as"
    ' "force [kN]"; @0.2s is added to its times; may be given more than once.',
)  # fmt: skip


def say_residual(result: Result, part: Residual) -> None:
    """Say on stderr how far a measured curve is from that of a run."""
    from rattle.results.handy_units import handy_unit, units_of_result

    factor, unit = handy_unit(part.unit, part.rms, units_of_result(result.provenance))
    taken = [f"no unit in its head, taken as {part.unit or 'plain numbers'}"] if part.measured.unitless else []
    words = ", ".join([*part.told(factor, unit), *taken])
    logging.getLogger("rattle").info(f"{part.measured.label} beside {part.curve}: {words}")
