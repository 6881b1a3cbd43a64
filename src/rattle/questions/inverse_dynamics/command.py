"""The command `rattle inverse-dynamics`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rattle.cli.instants import moved, ranges, span_options
from rattle.cli.output import save_options
from rattle.cli.question_command import Asked, Shown, json_option, model_command
from rattle.cli.requirements import require_option

if TYPE_CHECKING:
    from rattle.results.result import Result


@model_command
@span_options(1001)
@click.option(
    "--effort-at", metavar="JOINT",
    help="Effort and power that a motor on this joint would need in place of the driver [N m or N, W].",
)  # fmt: skip
@save_options()
@require_option
@json_option("Ranges, events and trust as JSON.")
def inverse_dynamics(asked: Asked, t_end: float | None, points: int, effort_at: str | None) -> Shown:
    """Driven motion with all reactions, and torque and power of the drivers.

    FILE is a model file or the name of a shipped example. Joints must have no clearance (--ideal closes them).

    \b
    Example:  rattle inverse-dynamics slider_crank
    """
    from rattle.results.contact_summary import joint_table

    m = asked.model()

    def words(result: Result) -> list[str]:
        efforts = [name for name in result.stored if name.endswith((".torque", ".thrust", ".power", ".force"))]
        return [joint_table(result), ranges(m, result, efforts)]

    return moved(
        asked, m, "inverse-dynamics", t_end, points, lambda t: m.inverse_dynamics(t, effort_at=effort_at), words
    )
