"""The command `rattle equilibrium`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from rattle.cli.command import Command
from rattle.cli.instants import at_option, effort_option, notes, ranges, record, span_options, span_times
from rattle.cli.options import given, model_options, read_model
from rattle.cli.output import as_json as to_json
from rattle.cli.output import check_results, finish, keep, save_options
from rattle.cli.requirements import (
    check_required,
    finish_required,
    judge,
    require_option,
)
from rattle.questions.equilibrium.listing import entry, listed

if TYPE_CHECKING:
    from rattle.cli.requirements import Verdict
    from rattle.mechanism import Mechanism
    from rattle.questions.equilibrium.position import Equilibria
    from rattle.results.result import Result


@click.command(cls=Command)
@model_options
@at_option
@click.option(
    "--branches",
    type=click.Choice(["near", "all"]),
    default="near",
    show_default=True,
    help="all: also search the other ways in which the mechanism can be assembled.",
)
@effort_option
@require_option
@click.option(
    "--holds",
    "load",
    metavar="LOAD",
    help="Friction in joints: between which values of this load (or effort of this driver) the mechanism rests as put"
    " together, and whether it jams.",
)
@click.option("--path", "path", is_flag=True, help="Quasi-static motion: follow the equilibrium from t = 0 to --t-end.")
@span_options(181)
@save_options("With --path: ")
@click.option("--json", "as_json", is_flag=True, help="Everything as JSON.")
@click.pass_context
def equilibrium(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, t: float, branches: str, effort: float,
    required: tuple[str, ...], load: str | None, path: bool, t_end: float | None, points: int, output: str | None,
    csv: str | None, fallback: str | None, as_json: bool,
) -> None:  # fmt: skip
    """Equilibria: admissible (no bush has to pull) and stable ones first.

    FILE is a model file or the name of a shipped example.  A pin in oil floats where its film carries at the speeds
    that the drivers have at --at.  --require is about the first equilibrium, or about the --path.

    \b
    Examples: rattle equilibrium balanced_arm
              rattle equilibrium toggle_clamp --path -o clamp.nc
    """
    _require_one_question(ctx, path, load, (output, csv) != (None, None), bool(required))
    m = read_model(file, settings, ideal)
    if load is not None:
        held = m.holds(load, t)
        click.echo(to_json(held.record()) if as_json else str(held))
        return
    if path:
        check_results(file, output, csv, fallback)
        check_required(m, required, "equilibrium", t_end)
        result = m.equilibrium(span_times(m, t_end, points), effort=effort)
        verdicts = judge(result, required)
        click.echo(record(result, verdicts) if as_json else _path_lines(m, result))
        finish(ctx, result, keep(result, output, csv, fallback))
    else:
        check_required(m, required, "equilibrium", t or None)
        equilibria = m.equilibrium(t, branches=branches, effort=effort)
        verdicts = _listed(m, equilibria, required, as_json)
        if not equilibria:
            remedy = "" if equilibria.undefined else "; try other angles in [initial] or --branches all"
            click.echo(f"no equilibrium was found at t = {t:g} s{remedy}", err=True)
            ctx.exit(1)
    finish_required(ctx, verdicts, None if as_json else click.echo)


def _require_one_question(ctx: click.Context, path: bool, load: str | None, saved: bool, required: bool) -> None:
    """Raise click.UsageError for options that belong to different questions; saved: there are -o or --csv."""
    if not path and saved:
        raise click.UsageError("-o and --csv save a quasi-static motion; they need --path")
    if not path and (given(ctx, "t_end") or given(ctx, "points")):
        raise click.UsageError("--t-end and --points are those of a quasi-static motion; they need --path")
    if path and (given(ctx, "t") or given(ctx, "branches")):
        raise click.UsageError("--at and --branches are of equilibria at one time; a --path begins at t = 0")
    if load is not None and (path or given(ctx, "branches") or given(ctx, "effort")):
        raise click.UsageError("--holds is about the position as put together: without --path, --branches and --effort")
    if load is not None and required:
        raise click.UsageError("--require is about an equilibrium; leave it out with --holds")


def _path_lines(m: Mechanism, result: Result) -> str:
    """A quasi-static motion in lines: the ranges of forces and efforts, its events, its notes."""
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
    return "\n".join([ranges(m, result, finite), *events, notes(result)])


def _listed(m: Mechanism, equilibria: Equilibria, required: Sequence[str], as_json: bool) -> list[Verdict]:
    """Print equilibria; whether the first of them keeps what is required."""
    if equilibria.note:
        click.echo(equilibria.note, err=True)
    verdicts = judge(equilibria[0].result, required) if equilibria else []
    if as_json:
        asked = {"required": [verdict.record for verdict in verdicts]} if verdicts else {}
        click.echo(to_json([entry(rest) | (asked if n == 0 else {}) for n, rest in enumerate(equilibria)]))
    else:
        listed(m, equilibria)
    return verdicts
