"""The command `rattle optimise`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rattle.cli.options import time, value
from rattle.cli.output import STOPPED, check_files
from rattle.cli.question_command import Asked, Shown, Written, json_option, model_command

if TYPE_CHECKING:
    from rattle.questions.optimise.optimum import Optimum


@model_command
@click.option(
    "--minimise", "objective", metavar="OUTPUT", required=True,
    help='The number to be made as small as possible, e.g. "max(O3.force)" or "(final(block.x) - 0.3)**2".',
)  # fmt: skip
@click.option(
    "--vary", "varied", metavar="NAME=LOW:HIGH", multiple=True, required=True,
    help='A parameter that may change and its bounds, in SI or as "5 mm:20 mm"; once for each parameter.',
)  # fmt: skip
@click.option(
    "--subject-to", "constraints", metavar="CONDITION", multiple=True,
    help='What must hold, e.g. "max(O3.force) <= 500" or "l2 + l3 == 0.9 m"; may be given more than once.',
)  # fmt: skip
@click.option("--t-end", type=time, help="End of the runs, in s or as '20 ms'; default: as in the model.")
@click.option(
    "--analysis", type=click.Choice(["simulate", "kinematics", "inverse-dynamics"]), default="simulate",
    show_default=True, help="What is run for a design; a fully driven mechanism needs no simulation.",
)  # fmt: skip
@click.option(
    "--starts", default=5, show_default=True,
    help="Searches: the first from the present design, the others from designs drawn between the bounds.",
)  # fmt: skip
@click.option("--seed", default=0, show_default=True, help="Of the designs drawn; the same seed, the same answer.")
@click.option(
    "-o", "--output", "design", metavar="FILE",
    help="Model file to write with the best values: .toml (comments are kept) or .json.",
)  # fmt: skip
@json_option("The best design and how it was found as JSON, in SI units.")
def optimise(
    asked: Asked, objective: str, varied: tuple[str, ...], constraints: tuple[str, ...], design: str | None,
    **how: Any,
) -> Shown:  # fmt: skip
    """The best design between bounds: which lengths, stiffnesses, masses make a number as small as possible.

    FILE is a model file or the name of a shipped example.

    A number is made of curves by max min mean rms sd range integral at(x, t) final share first quantile count, with
    arithmetic around it.  ideal.NAME is the curve of the same mechanism without play.  Write an error as a sum of
    squares, or as rms(...): searches then need far fewer runs.  A distance to a point that may be passed at any time is
    min((P.x - 0.1)**2 + (P.y - 0.2)**2).  To make a number large, minimise its negative.

    A search finds the nearest valley, so several begin at different designs; how many ended at the best one is
    reported, and if it is only one, more --starts may find a better one.

    \b
    Examples: rattle optimise path_generator --ideal --analysis kinematics --minimise "sd(coupler.P.y)" --vary a=.03:.05
              rattle optimise slider_crank --minimise "max(motor.torque)" --vary rod_length=0.12:0.2 -o long.toml

    The report lists what changed, which constraints and bounds hold the optimum, how many searches came to it, and
    whether a finer run confirms it.  Exit status 1 if no design meets the constraints or the finer run disagrees.
    """
    from rattle.description.file import wants_json

    if design is not None:
        wants_json(design)  # refuses other names
    check_files(asked.file, design)
    m = asked.model()
    vary = dict(map(_bounds, varied))
    if len(vary) < len(varied):
        raise click.UsageError("--vary: every parameter once")
    optimum = m.optimise(objective, vary, constraints, progress=asked.progress, **how)
    return Shown(
        lambda: optimum.report, lambda: _record(optimum),
        () if design is None else (Written(design, optimum.mechanism.save),),
        status=STOPPED if optimum.interrupted else int(not optimum.success),
    )  # fmt: skip


def _record(optimum: Optimum) -> dict[str, object]:
    """The best design and what is known of it; margins of constraints are positive where they hold."""
    asked, before = optimum.question, optimum.question.mechanism
    parameters = {
        name: {"value": value, "before": before.parameters[name], "unit": before.model.parameters[name].unit}
        for name, value in optimum.values.items()
    }
    constraints = [
        {"condition": constraint.text, "margin": margin, "unit": constraint.margin.unit}
        for constraint, margin in zip(asked.constraints, optimum.numbers[1:].tolist(), strict=True)
    ]
    searches = [{"value": search.value, "feasible": search.feasible} for search in optimum.searches]
    return {
        "minimise": asked.objective.text, "value": optimum.value, "before": optimum.searches[0].begun_value,
        "unit": asked.objective.unit, "parameters": parameters, "constraints": constraints,
        "active": optimum.active, "success": optimum.success, "feasible": optimum.feasible,
        "confirmed": optimum.confirmed, "message": optimum.best_search.message or optimum.check.message,
        "squares": optimum.squares, "searches": searches, "runs": optimum.runs, "failures": optimum.failures,
    }  # fmt: skip


def _bounds(text: str) -> tuple[str, tuple[float | str, float | str]]:
    """A parameter and its bounds from NAME=LOW:HIGH."""
    name, _, rest = text.partition("=")
    ends = rest.split(":")
    if len(ends) != 2 or not name.strip():
        raise click.UsageError(f"--vary needs NAME=LOW:HIGH, as in l2=0.5:0.7, got '{text}'")
    low, high = map(value, ends)
    return name.strip(), (low, high)
