"""The command `rattle check`."""

from __future__ import annotations

from dataclasses import asdict

from rattle.cli.question_command import Asked, Shown, json_option, model_command


@model_command
@json_option("The report as JSON.")
def check(asked: Asked) -> Shown:
    """Bodies, joints, mobility, redundant joints, loops, branches, range of the driver.

    FILE is a model file or the name of a shipped example.

    \b
    Example:  rattle check fourbar
    """
    report = asked.model().check()
    return Shown(lambda: str(report), lambda: asdict(report))
