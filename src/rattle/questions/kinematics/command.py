"""The command `rattle kinematics`."""

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
@save_options()
@require_option
@click.option("--json", "as_json", is_flag=True, help="Ranges, events and trust as JSON.")
@click.pass_context
def kinematics(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, t_end: float | None, points: int,
    output: str | None, csv: str | None, fallback: str | None, required: tuple[str, ...], as_json: bool,
) -> None:  # fmt: skip
    """Driven motion: position, velocity and acceleration, dead centres and branch points.

    FILE is a model file or the name of a shipped example. Joints must have no clearance (--ideal closes them).

    \b
    Example:  rattle kinematics path_generator --ideal --points 361
    """
    m = read_model(file, settings, ideal)
    check_results(file, output, csv, fallback)
    check_required(m, required, "kinematics", t_end)
    result = m.kinematics(span_times(m, t_end, points))
    verdicts = judge(result, required)
    if as_json:
        click.echo(record(result, verdicts))
    elif len(result.t):
        bodies = list(result.geometry["bodies"])
        click.echo(ranges(m, result, [f"{body}.{key}" for body in bodies for key in ("x", "y", "angle", "omega")]))
        click.echo(notes(result))
    finish(ctx, result, keep(result, output, csv, fallback))
    finish_required(ctx, verdicts, None if as_json else click.echo)
