"""The command `rattle sensitivity`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rattle.answers.arguments import listed
from rattle.cli.command import Command
from rattle.cli.instants import span_options
from rattle.cli.options import given, model_options, read_model, time
from rattle.cli.output import as_json as to_json
from rattle.cli.output import check_pictures, check_results, fallback_option, finish, keep, say_written
from rattle.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result

PICTURES = (".svg", ".png", ".pdf")


@click.command(cls=Command)
@model_options
@click.option(
    "--of", "outputs", multiple=True, required=True, metavar="NAME",
    help="A curve, e.g. rocker.angle, coupler.P.x, O3.normal; several with commas, or give the option again.",
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
@click.option("--json", "as_json", is_flag=True, help="The table as JSON, in SI units.")
@click.pass_context
def sensitivity(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, outputs: tuple[str, ...],
    parameters: tuple[str, ...], analysis: str, t: float, t_end: float | None, points: int, output: str | None,
    fallback: str | None, as_json: bool,
) -> None:  # fmt: skip
    """Derivatives of curves by parameters: which dimension matters, when, and how much.

    For every curve and parameter: the largest derivative and when, and what it means for a change of the parameter by
    its tolerance (`tol` in the model file), else by 1 %.  All that is written with a parameter follows it, the start
    too.  The derivatives are exact, no small change is made and nothing is run twice; in a file of -o they are curves
    named d(rocker.angle)/d(l2), in SI units.

    A linear estimate fails where sensitivities grow exponentially: a note then says how fast, and until when it holds.
    Contacts begin and end, so they are refused: use massless links, or --ideal.

    FILE is a model file or the name of a shipped example.

    \b
    Examples: rattle sensitivity fourbar --of rocker.angle,O3.normal --to r3,M --t-end 30ms
              rattle sensitivity path_generator --ideal --analysis kinematics --of coupler.P.y -o dimensions.svg
              rattle sensitivity balanced_arm --analysis equilibrium --of arm.angle --to l,lamp_mass
    """
    _require_used(ctx, analysis, t_end)
    if output is not None:
        _require_name(output)
    if output is not None and Path(output).suffix.lower() in PICTURES:
        check_pictures(file, output)
    else:
        csv = output if output is not None and output.lower().endswith(".csv") else None
        check_results(file, None if csv else output, csv, fallback)
    m = read_model(file, settings, ideal)
    of, to = listed(*outputs), listed(*parameters) or _usual(m)
    result = m.sensitivity(of, to, _instants(m, analysis, t, t_end, points), analysis)
    if as_json:
        click.echo(to_json(_record(result)))
    elif len(result.t):
        click.echo(_table(result))
        click.echo("\n".join([result.trust.word, *result.trust.notes]))
    kept = output is None or _write(result, output, fallback, as_json)
    finish(ctx, result, kept)


def _require_used(ctx: click.Context, analysis: str, t_end: float | None) -> None:
    """Refuse options that this analysis would leave aside."""
    single = analysis == "equilibrium" and t_end is None
    if given(ctx, "t") and not single:
        raise click.UsageError(
            "--at is of one equilibrium: it needs --analysis equilibrium and no --t-end; curves begin at t = 0"
        )
    if given(ctx, "points") and single:
        raise click.UsageError("--points is of a path; --at is one equilibrium. Give --t-end for a path")


def _require_name(output: str) -> None:
    """Raise InputError for a name that is none of a result, a table or a picture."""
    from rattle.atomic_file import is_special
    from rattle.results.archive import SUFFIXES

    if Path(output).suffix.lower() not in (*SUFFIXES, ".csv", *PICTURES) and not is_special(output):
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


def _instants(m: Mechanism, analysis: str, t: float, t_end: float | None, points: int) -> np.ndarray | float:
    import numpy as np

    if analysis == "equilibrium" and t_end is None:
        return t
    end = m.model.settings.t_end if t_end is None else t_end
    if not 0.0 < end < float("inf"):
        raise click.UsageError(f"--t-end must be positive, got {end}")
    return np.linspace(0.0, end, points)


def _table(result: Result) -> str:
    """Per output a line for each parameter, those with the largest effect first."""
    from rattle.questions.sensitivity.effects import effects

    entries = effects(result)
    rows = []
    for output in dict.fromkeys(effect.output for effect in entries):
        mine = [effect for effect in entries if effect.output == output]
        mine.sort(key=lambda effect: -effect.size)
        for n, effect in enumerate(mine):
            name = f"d({effect.output})" if n == 0 else ""
            at = f"{result.t[effect.largest]:.4g} s"
            rows.append((name, effect.parameter, effect.slope, at, effect.words, effect.effect))
    head = ("", "by", "largest derivative", "at t", "a change by", "moves it by")
    wide = [max(len(row[c]) for row in (head, *rows)) for c in range(len(head))]
    lines = ["  ".join(cell.ljust(w) for cell, w in zip(row, wide, strict=True)).rstrip() for row in (head, *rows)]
    return "\n".join(lines)


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


def _write(result: Result, output: str, fallback: str | None, silent: bool) -> bool:
    """Save or draw the result; False if it could not be saved."""
    if Path(output).suffix.lower() not in PICTURES:
        csv = output.lower().endswith(".csv")
        return keep(result, None if csv else output, output if csv else None, fallback)
    from rattle.plots.curves import save_figure
    from rattle.questions.sensitivity.pictures import plot_effects

    if len(result.t):
        save_figure(plot_effects(result), output)
        if not silent:
            say_written(output)
    return True
