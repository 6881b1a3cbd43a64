"""The command `rattle sensitivity`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rattle.answers.arguments import listed
from rattle.cli.instants import span_options, span_times
from rattle.cli.options import given, time
from rattle.cli.output import fallback_option
from rattle.cli.question_command import Asked, Shown, json_option, model_command
from rattle.errors import InputError

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


@model_command
@click.option(
    "--of", "outputs", multiple=True, required=True, metavar="NAME",
    help="A curve, e.g. rocker.angle, coupler.P.x, O3.normal, or a number such as max(O3.normal); several with commas,"
    " or give the option again.",
)  # fmt: skip
@click.option(
    "--to", "parameters", multiple=True, metavar="NAME",
    help="Parameters, e.g. l2,r3.  [default: those with a tolerance, or all if none has one]",
)  # fmt: skip
@click.option(
    "--analysis", type=click.Choice(["simulate", "kinematics", "inverse-dynamics", "equilibrium"]),
    default="simulate", show_default=True, help="What makes the curves; equilibrium: at --at, or a path to --t-end.",
)  # fmt: skip
@click.option(
    "--at", "t", type=time, default=0.0, help="One equilibrium: time at which the drivers are held.  [default: 0]"
)
@span_options(201)
@click.option(
    "-o", "--output", metavar="FILE",
    help="Save all curves and derivatives (.nc, .npz, .csv), or draw what each change does (.svg, .png, .pdf).",
)  # fmt: skip
@fallback_option
@json_option("The table as JSON, in SI units.")
def sensitivity(
    asked: Asked, outputs: tuple[str, ...], parameters: tuple[str, ...], analysis: str, t: float, t_end: float | None,
    points: int,
) -> Shown:  # fmt: skip
    """Derivatives of curves by parameters: which dimension matters, when, and how much.

    For every curve and parameter: the largest derivative and when, and what it means for a change of the parameter by
    its tolerance (`tol` in the model file), else by 1 %.  All that is written with a parameter follows it, the start
    too.  The derivatives are exact, no small change is made and nothing is run twice; in a file of -o they are curves
    named d(rocker.angle)/d(l2), in SI units.

    A linear estimate fails where sensitivities grow exponentially: a note then says how fast, and until when it holds.
    Numbers of the whole run are outputs too: max(abs(O3.normal)), mean(...), of contacts time(B.contacts,2), speed(...)
    and peak(...). What cannot be followed (oil, wear, clutches) is named: use massless links, or --ideal.

    FILE is a model file or the name of a shipped example.

    \b
    Examples: rattle sensitivity fourbar --of rocker.angle,O3.normal --to r3,M --t-end 30ms
              rattle sensitivity path_generator --ideal --analysis kinematics --of coupler.P.y -o dimensions.svg
              rattle sensitivity balanced_arm --analysis equilibrium --of arm.angle --to l,lamp_mass
    """
    from rattle.questions.sensitivity.pictures import plot_effects

    single = analysis == "equilibrium" and t_end is None
    _require_used(single)
    _require_name(asked.output)
    asked = asked.by_suffix()
    m = asked.model()
    of, to = listed(*outputs), listed(*parameters) or _usual(m)
    result = m.sensitivity(of, to, t if single else span_times(m, t_end, points), analysis)
    return asked.shown(
        result, lambda: "\n".join([*_table(result), result.trust.word, *result.trust.notes]), lambda: _record(result),
        asked.drawn(lambda: plot_effects(result)),
    )  # fmt: skip


def _require_used(single: bool) -> None:
    """Refuse options that one equilibrium, or curves over time, would leave aside."""
    ctx = click.get_current_context()
    if given(ctx, "t") and not single:
        raise click.UsageError(
            "--at is of one equilibrium: it needs --analysis equilibrium and no --t-end; curves begin at t = 0"
        )
    if given(ctx, "points") and single:
        raise click.UsageError("--points is of a path; --at is one equilibrium. Give --t-end for a path")


def _require_name(output: str | None) -> None:
    """Raise InputError for a name that is none of a result, a table or a picture."""
    from rattle.atomic_file import is_special
    from rattle.plots.curves import SUFFIXES as PICTURES
    from rattle.results.archive import SUFFIXES

    written = (*SUFFIXES, ".csv", *PICTURES)
    if output is not None and Path(output).suffix.lower() not in written and not is_special(output):
        raise InputError(
            f"{output}: curves and derivatives are saved as {', '.join(SUFFIXES)} or .csv, a drawing as"
            f" {', '.join(PICTURES)}; give a name ending in one of them"
        )


def _usual(m: Mechanism) -> list[str]:
    """Parameters with a tolerance, or all."""
    every = m.model.parameters
    if not every:
        raise click.UsageError("the model has no [parameters]; write the dimension of interest as one")
    return [name for name, parameter in every.items() if parameter.tol] or list(every)


def _table(result: Result) -> list[str]:
    """Per output a line for each parameter, those with the largest effect first."""
    from rattle.questions.sensitivity.effects import effects
    from rattle.results.display import in_columns

    entries = effects(result)
    rows = []
    for output in dict.fromkeys(effect.output for effect in entries):
        mine = [effect for effect in entries if effect.output == output]
        mine.sort(key=lambda effect: -effect.size)
        for n, effect in enumerate(mine):
            name = f"d({effect.output})" if n == 0 else ""
            at = "whole run" if effect.of_whole_run else f"{result.t[effect.largest]:.4g} s"
            rows.append((name, effect.parameter, effect.slope, at, effect.words, effect.effect))
    head = ("", "by", "largest derivative", "at t", "a change by", "moves it by")
    return in_columns([head, *rows])


def _record(result: Result) -> dict[str, object]:
    from rattle.questions.sensitivity.effects import effects

    entries = [
        {
            "of": effect.output, "to": effect.parameter, "largest": float(effect.derivative[effect.largest]),
            "t": float(result.t[effect.largest]), "change": effect.change,
            "effect": float(effect.derivative[effect.largest]) * effect.change, "unit": effect.unit,
            "parameter_unit": effect.by,
        }
        for effect in (effects(result) if len(result.t) else [])
    ]  # fmt: skip
    return {
        "success": result.success, "message": result.message, "sensitivities": entries,
        "trust": result.trust.to_dict(),
    }  # fmt: skip
