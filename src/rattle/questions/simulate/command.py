"""The command `rattle run`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rattle.cli.command import Command
from rattle.cli.options import LateOption, model_options, read_model, shows_progress, time
from rattle.cli.output import as_json as to_json
from rattle.cli.output import check_results, finish, keep, save_options
from rattle.cli.requirements import check_required, finish_required, judge, require_option

if TYPE_CHECKING:
    from rattle.results.contact_summary import ContactSummary
    from rattle.results.result import Result


@click.command(cls=Command)
@model_options
@save_options()
@click.option("--contact", metavar="NAME", help="Contact model of every joint with clearance, e.g. impact or exact.")
@click.option("--t-end", type=time, help="End of the run, in s or as '20 ms'; default: as in the model.")
@click.option(
    "--method",
    metavar="NAME",
    cls=LateOption,
    words=lambda: f"Integrator: {_methods(impacts=False)}; with impact contacts {_methods(impacts=True)}.",
)
@click.option(
    "--rtol",
    type=float,
    cls=LateOption,
    words=lambda: f"Relative tolerance per step of {_steppers(True)}; default: as in the model, otherwise 1e-8.",
)
@click.option(
    "--atol",
    type=float,
    help="Absolute tolerance per step [m, rad, m/s, rad/s]; default: a hundredth of --rtol.",
)
@click.option(
    "--step",
    type=time,
    cls=LateOption,
    words=lambda: f"Step of {_steppers(False)}, largest step of the others, in s or as '10 us'.",
)
@click.option("--most-steps", type=int, help="End the run after this many steps; default: when it makes no progress.")
@click.option(
    "--horizon/--no-horizon",
    default=True,
    show_default=True,
    help="Run a second time with a tighter tolerance, to find out how long the curves can be trusted; "
    "doubles the time.",
)
@require_option
@click.option("--why", "-v", is_flag=True, help="Say why the result can be trusted so far: errors, contacts, remarks.")
@click.option("--json", "as_json", is_flag=True, help="Print table and trust as JSON.")
@click.pass_context
def run(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, output: str | None, csv: str | None,
    fallback: str | None, contact: str | None, t_end: float | None, method: str | None, rtol: float | None,
    atol: float | None, step: float | None, most_steps: int | None, horizon: bool, required: tuple[str, ...],
    why: bool, as_json: bool,
) -> None:  # fmt: skip
    """Motion in time: peak and RMS force of every joint, energy, and how far the result can be trusted.

    FILE is a model file or the name of a shipped example.

    \b
    Examples: rattle run fourbar --t-end 0.2 --set r3="2 mm" -o out.nc
              rattle run slider_crank --require "max(abs(motor.torque)) < 400 N*m"
    """
    from rattle.results.contact_summary import contact_lines, joint_table
    from rattle.results.film_summary import film_table

    m = read_model(file, settings, ideal)
    if contact is not None:
        m = m.with_contact(contact)
    check_results(file, output, csv, fallback)
    check_required(m, required, t_end=t_end)
    result = m.simulate(
        t_end, method=method, rtol=rtol, atol=atol, step=step, horizon=horizon, most_steps=most_steps,
        progress=shows_progress(ctx),
    )  # fmt: skip
    kept = keep(result, output, csv, fallback)
    verdicts = judge(result, required)
    if as_json:
        record = {
            "success": result.success,
            "message": result.message,
            "trust": result.trust.to_dict(),
            "stats": result.stats,
            "peaks": _peaks(result),
            **({"required": [verdict.record for verdict in verdicts]} if verdicts else {}),
            "contacts": {name: _contact(summary) for name, summary in result.contacts.items()},
        }
        click.echo(to_json(record))
    else:
        click.echo(joint_table(result))
        for line in contact_lines(result):
            click.echo(line)
        if films := film_table(result):
            click.echo(films)
        click.echo(result.trust.word)
        for line in result.trust.why if why else result.trust.notes:
            click.echo(line)
    finish(ctx, result, kept)
    finish_required(ctx, verdicts, None if as_json else click.echo)


def _contact(summary: ContactSummary) -> dict[str, float | bool | None]:
    """The contacts of a joint; peak and RMS are None where they say nothing of a real force."""
    return summary._asdict() | ({} if summary.readable else {"peak": None, "rms": None})


def _methods(impacts: bool) -> str:
    """Steppers for models with or without impact contacts, and how long their steps are."""
    from rattle.registry import kinds
    from rattle.solvers.stepper import FREE, SET_VALUED

    wanted = SET_VALUED if impacts else FREE
    able = {name: kind.leaf for name, kind in kinds("stepper").items() if wanted in kind.leaf.works_with}
    return " or ".join(f"{name} ({'adaptive' if leaf.adaptive else 'fixed --step'})" for name, leaf in able.items())


def _steppers(adaptive: bool) -> str:
    from rattle.description.schema import steppers

    return steppers(adaptive)


def _peaks(result: Result) -> dict[str, dict[str, float | str | None]]:
    """Largest magnitude, its time [s] and RMS of all forces, moments, efforts and powers, found within the steps.

    None where they say nothing of a real force, as between impacts of rigid contacts that turn or nearly lock.
    """
    from rattle.results.contact_summary import readable

    return {
        name: {"peak": peak.value if shown else None, "t": peak.t, "rms": peak.rms if shown else None, "unit": unit}
        for name, peak in result.peaks.items()
        if name in result
        for shown, unit in [(readable(result, name), result.unit(name))]
    }
