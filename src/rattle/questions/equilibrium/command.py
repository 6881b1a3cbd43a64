"""The command `rattle equilibrium`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click

from rattle.cli.instants import at_option, effort_option, moved, ranges, span_options
from rattle.cli.options import given
from rattle.cli.output import save_options
from rattle.cli.question_command import Asked, Shown, json_option, model_command
from rattle.cli.requirements import check_required, judge, require_option, required_record
from rattle.questions.equilibrium.listing import entry, listed

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


@model_command
@at_option
@click.option(
    "--branches", type=click.Choice(["near", "all"]), default="near", show_default=True,
    help="all: also search the other ways in which the mechanism can be assembled.",
)  # fmt: skip
@effort_option
@require_option
@click.option(
    "--holds", "load", metavar="LOAD",
    help="Friction in joints: between which values of this load (or effort of this driver) the mechanism rests as put"
    " together, and whether it jams.",
)  # fmt: skip
@click.option("--path", "path", is_flag=True, help="Quasi-static motion: follow the equilibrium from t = 0 to --t-end.")
@span_options(181)
@save_options("With --path: ")
@json_option("Everything as JSON.")
def equilibrium(
    asked: Asked, t: float, branches: str, effort: float, load: str | None, path: bool, t_end: float | None, points: int
) -> Shown:
    """Equilibria: admissible (no bush has to pull) and stable ones first.

    FILE is a model file or the name of a shipped example.  A pin in oil floats where its film carries at the speeds
    that the drivers have at --at.  --require is about the first equilibrium, or about the --path.

    \b
    Examples: rattle equilibrium balanced_arm
              rattle equilibrium toggle_clamp --path -o clamp.nc
    """
    _require_one_question(asked, path, load)
    m = asked.model()
    if load is not None:
        held = m.holds(load, t)
        return Shown(lambda: str(held), held.record)
    if path:
        return moved(
            asked, m, "equilibrium", t_end, points, lambda t: m.equilibrium(t, effort=effort),
            lambda result: _path_lines(m, result),
        )  # fmt: skip
    return _listed(asked, m, t, branches, effort)


def _require_one_question(asked: Asked, path: bool, load: str | None) -> None:
    """Raise click.UsageError for options that belong to different questions."""
    ctx = click.get_current_context()
    if not path and (asked.output, asked.csv) != (None, None):
        raise click.UsageError("-o and --csv save a quasi-static motion; they need --path")
    if not path and (given(ctx, "t_end") or given(ctx, "points")):
        raise click.UsageError("--t-end and --points are those of a quasi-static motion; they need --path")
    if path and (given(ctx, "t") or given(ctx, "branches")):
        raise click.UsageError("--at and --branches are of equilibria at one time; a --path begins at t = 0")
    if load is not None and (path or given(ctx, "branches") or given(ctx, "effort")):
        raise click.UsageError("--holds is about the position as put together: without --path, --branches and --effort")
    if load is not None and asked.required:
        raise click.UsageError("--require is about an equilibrium; leave it out with --holds")


def _path_lines(m: Mechanism, result: Result) -> list[str]:
    """A quasi-static motion in lines: the ranges of forces and efforts, its events."""
    wanted = (".torque", ".thrust", ".normal", ".advantage", ".stiffness")
    efforts = [
        n
        for n in result.stored
        if n.endswith(wanted) or (n.endswith(".force") and n.partition(".")[0] in m.model.drivers)
    ]
    events = [
        f"t = {event.t:.8g} s: "
        + (f"{event.joint} changes sides (N through zero)" if event.kind == "side" else "snap-through")
        for event in result.events
    ]
    finite = [name for name in efforts if abs(result[name]).max() < math.inf]
    return [ranges(m, result, finite), *events]


def _listed(asked: Asked, m: Mechanism, t: float, branches: str, effort: float) -> Shown:
    """The equilibria at a time, and whether the first of them keeps what is required."""
    check_required(m, asked.required, "equilibrium", t or None)
    equilibria = m.equilibrium(t, branches=branches, effort=effort)
    if equilibria.note:
        click.echo(equilibria.note, err=True)
    if not equilibria:
        remedy = "" if equilibria.undefined else "; try other angles in [initial] or --branches all"
        return Shown(record=list, status=1, remarks=[f"no equilibrium was found at t = {t:g} s{remedy}"])
    verdicts = judge(equilibria[0].result, asked.required)
    judged = [required_record(verdicts), *({} for _ in equilibria[1:])]
    return Shown(
        lambda: listed(m, equilibria),
        lambda: [entry(rest) | more for rest, more in zip(equilibria, judged, strict=True)],
        verdicts=verdicts,
    )
