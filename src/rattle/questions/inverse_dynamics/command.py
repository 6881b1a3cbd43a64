"""The command `rattle inverse-dynamics`."""

from __future__ import annotations

import click

from rattle.cli.command import Command
from rattle.cli.instants import notes, ranges, record, span_options, span_times
from rattle.cli.options import model_options, read_model
from rattle.cli.output import check_results, finish, keep, save_options
from rattle.cli.requirements import (
    check_required,
    finish_required,
    judge,
    require_option,
)


@click.command(cls=Command)
@model_options
@span_options(1001)
@click.option(
    "--effort-at",
    metavar="JOINT",
    help="Effort and power that a motor on this joint would need in place of the driver [N m or N, W].",
)
@save_options()
@require_option
@click.option("--json", "as_json", is_flag=True, help="Ranges, events and trust as JSON.")
@click.pass_context
def inverse_dynamics(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, t_end: float | None, points: int,
    effort_at: str | None, output: str | None, csv: str | None, fallback: str | None,
    required: tuple[str, ...], as_json: bool,
) -> None:  # fmt: skip
    """Driven motion with all reactions, and torque and power of the drivers.

    FILE is a model file or the name of a shipped example. Joints must have no clearance (--ideal closes them).

    \b
    Example:  rattle inverse-dynamics slider_crank
    """
    from rattle.results.contact_summary import joint_table

    m = read_model(file, settings, ideal)
    check_results(file, output, csv, fallback)
    check_required(m, required, "inverse-dynamics", t_end)
    result = m.inverse_dynamics(span_times(m, t_end, points), effort_at=effort_at)
    verdicts = judge(result, required)
    if as_json:
        click.echo(record(result, verdicts))
    elif len(result.t):
        efforts = [name for name in result.stored if name.endswith((".torque", ".thrust", ".power", ".force"))]
        click.echo(joint_table(result))
        click.echo(ranges(m, result, efforts))
        click.echo(notes(result))
    finish(ctx, result, keep(result, output, csv, fallback))
    finish_required(ctx, verdicts, None if as_json else click.echo)
