"""The command `rattle run`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rattle.cli.options import LateOption, contact_option, time
from rattle.cli.output import save_options
from rattle.cli.question_command import Asked, Shown, json_option, model_command
from rattle.cli.requirements import check_required, require_option

if TYPE_CHECKING:
    from rattle.results.contact_summary import ContactSummary
    from rattle.results.result import Result


@model_command
@save_options()
@contact_option
@click.option("--t-end", type=time, help="End of the run, in s or as '20 ms'; default: as in the model.")
@click.option(
    "--method", metavar="NAME", cls=LateOption,
    words=lambda: f"Integrator: {_methods(impacts=False)}; with impact contacts {_methods(impacts=True)}.",
)  # fmt: skip
@click.option(
    "--rtol", type=float, cls=LateOption,
    words=lambda: f"Relative tolerance per step of {_steppers(True)}; default: as in the model, otherwise 1e-8.",
)  # fmt: skip
@click.option(
    "--atol", type=float, help="Absolute tolerance per step [m, rad, m/s, rad/s]; default: a hundredth of --rtol."
)
@click.option(
    "--step", type=time, cls=LateOption,
    words=lambda: f"Step of {_steppers(False)}, largest step of the others, in s or as '10 us'.",
)  # fmt: skip
@click.option("--most-steps", type=int, help="End the run after this many steps; default: when it makes no progress.")
@click.option(
    "--horizon/--no-horizon", default=True, show_default=True,
    help="Run a second time with a tighter tolerance, to find out how long the curves can be trusted; "
    "doubles the time.",
)  # fmt: skip
@require_option
@click.option("--why", "-v", is_flag=True, help="Say why the result can be trusted so far: errors, contacts, remarks.")
@json_option("Print table and trust as JSON.")
def run(asked: Asked, contact: str | None, t_end: float | None, why: bool, **stepping: Any) -> Shown:
    """Motion in time: peak and RMS force of every joint, energy, and how far the result can be trusted.

    FILE is a model file or the name of a shipped example.

    \b
    Examples: rattle run fourbar --t-end 0.2 --set r3="2 mm" -o out.nc
              rattle run slider_crank --require "max(abs(motor.torque)) < 400 N*m"
    """
    m = asked.model()
    if contact is not None:
        m = m.with_contact(contact)
    check_required(m, asked.required, t_end=t_end)
    result = m.simulate(t_end, progress=asked.progress, **stepping)
    return asked.shown(result, lambda: _lines(result, why), lambda: _record(result))


def _lines(result: Result, why: bool) -> str:
    """Forces of the joints, contacts, films, and how far to trust them."""
    from rattle.results.contact_summary import contact_lines, joint_table
    from rattle.results.film_summary import film_table

    trust = result.trust
    films = film_table(result)
    tables = [joint_table(result), *contact_lines(result), *([films] if films else [])]
    return "\n".join([*tables, trust.word, *(trust.why if why else trust.notes)])


def _record(result: Result) -> dict[str, object]:
    contacts = {name: _contact(summary) for name, summary in result.contacts.items()}
    facts = {"success": result.success, "message": result.message, "trust": result.trust.to_dict()}
    return {**facts, "stats": result.stats, "peaks": _peaks(result), "contacts": contacts}


def _contact(summary: ContactSummary) -> dict[str, float | bool | None]:
    """The contacts of a joint; peak and RMS are None where they say nothing of a real force."""
    return summary._asdict() | ({} if summary.readable else {"peak": None, "rms": None})


def _methods(impacts: bool) -> str:
    """Steppers for models with or without impact contacts, and how long their steps are."""
    from rattle.registry import kinds, names
    from rattle.solvers.stepper import FREE, SET_VALUED

    wanted = SET_VALUED if impacts else FREE
    leaves = {name: kinds("stepper")[name].leaf for name in names("stepper")}
    able = {name: leaf for name, leaf in leaves.items() if wanted in leaf.works_with}
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
