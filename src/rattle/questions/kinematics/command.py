"""The command `rattle kinematics`."""

from __future__ import annotations

from rattle.cli.instants import moved, ranges, span_options
from rattle.cli.output import save_options
from rattle.cli.question_command import Asked, Shown, json_option, model_command
from rattle.cli.requirements import require_option


@model_command
@span_options(1001)
@save_options()
@require_option
@json_option("Ranges, events and trust as JSON.")
def kinematics(asked: Asked, t_end: float | None, points: int) -> Shown:
    """Driven motion: position, velocity and acceleration, dead centres and branch points.

    FILE is a model file or the name of a shipped example. Joints must have no clearance (--ideal closes them).

    \b
    Example:  rattle kinematics path_generator --ideal --points 361
    """
    m = asked.model()
    curves = [f"{body}.{key}" for body in m.model.moving_bodies for key in ("x", "y", "angle", "omega")]
    return moved(asked, m, "kinematics", t_end, points, m.kinematics, lambda result: [ranges(m, result, curves)])
