"""The command `rattle check`."""

from __future__ import annotations

import click

from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model
from rattle.cli.output import as_json as to_json


@click.command(cls=Command)
@model_options
@click.option("--json", "as_json", is_flag=True, help="The report as JSON.")
def check(file: str, settings: tuple[str, ...], ideal: bool, as_json: bool) -> None:
    """Bodies, joints, mobility, redundant joints, loops, branches, range of the driver.

    FILE is a model file or the name of a shipped example.

    \b
    Example:  rattle check fourbar
    """
    report = read_model(file, settings, ideal).check()
    if as_json:
        from dataclasses import asdict

        click.echo(to_json(asdict(report)))
    else:
        click.echo(str(report))
