"""Commands that need no time integration: kinematics, inverse-dynamics, equilibrium, modes, accuracy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.command import Command
from rattle.cli.options import given, model_options, read_model, time
from rattle.cli.output import as_json as to_json
from rattle.cli.output import check_pictures, check_results, finish, keep, save_options, say_written, zeroed
from rattle.cli.positions import entry, holding_record, listed, modes_record
from rattle.cli.requirements import (
    check_deviations,
    check_required,
    finish_required,
    judge,
    judge_deviation,
    require_option,
)

if TYPE_CHECKING:
    import numpy as np

    from rattle.analyses.accuracy.clearance_error import Accuracy
    from rattle.analyses.statics.modes import Modes
    from rattle.cli.requirements import Verdict
    from rattle.mechanism import Mechanism
    from rattle.results.result import Result

ZERO = 1e-12  # share of the largest value of the same unit below which a number is rounding


def span_options(points: int) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Add the options --t-end and --points (default `points`) to a command."""

    def add(function: Callable[..., Any]) -> Callable[..., Any]:
        function = click.option(
            "--points",
            type=click.IntRange(2, 10_000_000),
            default=points,
            show_default=True,
            help="Number of positions, evenly spaced in time.",
        )(function)
        return click.option(
            "--t-end", type=time, help="From t = 0 to this time, in s or as '20 ms'; default: as in the model."
        )(function)

    return add


def span_times(m: Mechanism, t_end: float | None, points: int) -> np.ndarray:
    import numpy as np

    end = m.model.settings.t_end if t_end is None else t_end
    if not 0.0 < end < math.inf:
        raise click.UsageError(f"--t-end must be positive, got {end}")
    return np.linspace(0.0, end, points)


def _ranges(m: Mechanism, result: Result, names: list[str]) -> str:
    """Table of the least and greatest value of curves and their times, interpolated where a curve is smooth.

    Instants without a value are left out.
    """
    import numpy as np

    from rattle.results.contact_summary import extreme
    from rattle.results.display import quantity, scale
    from rattle.results.handy_units import handy_unit, written_units

    wide = max([len(name) for name in names] + [8]) + 2
    lines = [f"{'':{wide}s}{'least':>14s} at t{'greatest':>22s} at t"]
    largest: dict[str, float] = {}
    written = written_units(m.to_json())
    for name in names:
        unit = result.unit(name)
        largest[unit] = max(largest.get(unit, 0.0), float(np.nanmax(np.abs(result[name]), initial=0.0)))
    for name in names:
        curve, unit = result[name], result.unit(name)
        if np.isnan(curve).all():
            lines.append(f"{name:{wide}s}{'no value':>12s}")
            continue
        (most, late), (least, early) = extreme(result.t, curve), extreme(result.t, -curve)
        floor = ZERO * max(largest[unit], 1.0 if unit == "rad" else 0.0)
        rates = unit == "rad/s"  # in rpm where the model file writes speeds so
        factor, shown = handy_unit(unit, largest[unit], written) if rates else scale(unit, largest[unit])
        low, high = factor * zeroed(-least, floor), factor * zeroed(most, floor)
        first, last = quantity(early, "s"), quantity(late, "s")
        lines.append(f"{name:{wide}s}{low:12.5g} {shown:6s}{first:>10s}{high:12.5g} {shown:6s}{last:>10s}")
    return "\n".join(lines)


def _notes(result: Result) -> str:
    lines = [f"{len(result.t)} positions, all joints close"]
    if result.trust.nonunique:
        lines.append(
            f"reactions not unique (redundant constraints) at {', '.join(result.trust.nonunique)}; "
            "the motion is correct"
        )
    return "\n".join([*lines, *result.trust.notes])


def _record(result: Result, verdicts: Sequence[Verdict] = ()) -> str:
    import numpy as np

    curves = {
        n: {
            "min": float(np.min(result[n], initial=math.inf, where=~np.isnan(result[n]))),
            "max": float(np.max(result[n], initial=-math.inf, where=~np.isnan(result[n]))),
            "unit": result.unit(n),
        }
        for n in result.names
        if len(result.t)
    }
    events = [{"t": float(e.t), "joint": e.joint, "kind": e.kind} for e in result.events]
    record = {
        "success": result.success,
        "message": result.message,
        "trust": result.trust.to_dict(),
        "events": events,
        "curves": curves,
        **({"required": [verdict.record for verdict in verdicts]} if verdicts else {}),
    }
    return to_json(record)


at_option = click.option(
    "--at",
    "t",
    type=time,
    default=0.0,
    show_default=True,
    help="Time at which the drivers are held, in s or as '20 ms'.",
)
effort_option = click.option(
    "--effort",
    type=click.FloatRange(0.0, min_open=True),
    default=1.0,
    show_default=True,
    help="Work allowed for the search for equilibria; 10 allows ten times as much, at most 10000.",
)


@click.command(cls=Command)
@model_options
@span_options(1001)
@save_options()
@require_option
@click.option("--json", "as_json", is_flag=True, help="Ranges, events and trust as JSON.")
@click.pass_context
def kinematics(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, t_end: float | None, points: int,
    output: str | None, csv: str | None, fallback: str | None, required: tuple[str, ...], as_json: bool,
) -> None:  # fmt: skip
    """Driven motion: position, velocity and acceleration, dead centres and branch points.

    FILE is a model file or the name of a shipped example. Joints must have no clearance (--ideal closes them).

    \b
    Example:  rattle kinematics path_generator --ideal --points 361
    """
    m = read_model(file, settings, ideal)
    check_results(file, output, csv, fallback)
    check_required(m, required, "kinematics", t_end)
    result = m.kinematics(span_times(m, t_end, points))
    verdicts = judge(result, required)
    if as_json:
        click.echo(_record(result, verdicts))
    elif len(result.t):
        bodies = list(result.geometry["bodies"])
        click.echo(_ranges(m, result, [f"{body}.{key}" for body in bodies for key in ("x", "y", "angle", "omega")]))
        click.echo(_notes(result))
    finish(ctx, result, keep(result, output, csv, fallback))
    finish_required(ctx, verdicts, None if as_json else click.echo)


@click.command(cls=Command)
@model_options
@span_options(1001)
@click.option(
    "--effort-at",
    metavar="JOINT",
    help="Effort and power that a motor on this joint would need in place of the driver [N m or N, W].",
)
@save_options()
@require_option
@click.option("--json", "as_json", is_flag=True, help="Ranges, events and trust as JSON.")
@click.pass_context
def inverse_dynamics(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, t_end: float | None, points: int,
    effort_at: str | None, output: str | None, csv: str | None, fallback: str | None,
    required: tuple[str, ...], as_json: bool,
) -> None:  # fmt: skip
    """Driven motion with all reactions, and torque and power of the drivers.

    FILE is a model file or the name of a shipped example. Joints must have no clearance (--ideal closes them).

    \b
    Example:  rattle inverse-dynamics slider_crank
    """
    from rattle.results.contact_summary import joint_table

    m = read_model(file, settings, ideal)
    check_results(file, output, csv, fallback)
    check_required(m, required, "inverse-dynamics", t_end)
    result = m.inverse_dynamics(span_times(m, t_end, points), effort_at=effort_at)
    verdicts = judge(result, required)
    if as_json:
        click.echo(_record(result, verdicts))
    elif len(result.t):
        efforts = [name for name in result.stored if name.endswith((".torque", ".thrust", ".power", ".force"))]
        click.echo(joint_table(result))
        click.echo(_ranges(m, result, efforts))
        click.echo(_notes(result))
    finish(ctx, result, keep(result, output, csv, fallback))
    finish_required(ctx, verdicts, None if as_json else click.echo)


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
    if not path and (output, csv) != (None, None):
        raise click.UsageError("-o and --csv save a quasi-static motion; they need --path")
    if not path and (given(ctx, "t_end") or given(ctx, "points")):
        raise click.UsageError("--t-end and --points are those of a quasi-static motion; they need --path")
    if path and (given(ctx, "t") or given(ctx, "branches")):
        raise click.UsageError("--at and --branches are of equilibria at one time; a --path begins at t = 0")
    if load is not None and (path or given(ctx, "branches") or given(ctx, "effort")):
        raise click.UsageError("--holds is about the position as put together: without --path, --branches and --effort")
    if load is not None and required:
        raise click.UsageError("--require is about an equilibrium; leave it out with --holds")
    m = read_model(file, settings, ideal)
    if load is not None:
        held = m.holds(load, t)
        click.echo(to_json(holding_record(held)) if as_json else str(held))
        return
    if path:
        check_results(file, output, csv, fallback)
        check_required(m, required, "equilibrium", t_end)
        result = m.equilibrium(span_times(m, t_end, points), effort=effort)
        verdicts = judge(result, required)
        if as_json:
            click.echo(_record(result, verdicts))
        else:
            wanted = (".torque", ".thrust", ".normal", ".advantage", ".stiffness")
            efforts = [
                n
                for n in result.stored
                if n.endswith(wanted) or (n.endswith(".force") and n.partition(".")[0] in m.model.drivers)
            ]
            click.echo(_ranges(m, result, [name for name in efforts if abs(result[name]).max() < math.inf]))
            for event in result.events:
                click.echo(
                    f"t = {event.t:.8g} s: "
                    + (f"{event.joint} changes sides (N through zero)" if event.kind == "side" else "snap-through")
                )
            click.echo(_notes(result))
        finish(ctx, result, keep(result, output, csv, fallback))
        finish_required(ctx, verdicts, None if as_json else click.echo)
        return
    check_required(m, required, "equilibrium", t or None)
    found = m.equilibrium(t, branches=branches, effort=effort)
    if found.note:
        click.echo(found.note, err=True)
    verdicts = judge(found[0].result, required) if found else []
    if as_json:
        asked = {"required": [verdict.record for verdict in verdicts]} if verdicts else {}
        click.echo(to_json([entry(one) | (asked if n == 0 else {}) for n, one in enumerate(found)]))
    else:
        listed(m, found)
    if not found:
        remedy = "" if found.undefined else "; try other angles in [initial] or --branches all"
        click.echo(f"no equilibrium was found at t = {t:g} s{remedy}", err=True)
        ctx.exit(1)
    finish_required(ctx, verdicts, None if as_json else click.echo)


@click.command(cls=Command)
@model_options
@at_option
@effort_option
@require_option
@click.option(
    "--mode", type=click.IntRange(1), default=1, show_default=True,
    help="Which mode -o draws; 1 has the lowest frequency.",
)  # fmt: skip
@click.option(
    "-o", "--output", metavar="FILE", help="Draw the mode: .svg, .png or .pdf; .gif or .mp4 for an animation."
)
@click.option("--json", "as_json", is_flag=True, help="Everything as JSON.")
@click.pass_context
def modes(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, t: float, effort: float,
    required: tuple[str, ...], mode: int, output: str | None, as_json: bool,
) -> None:  # fmt: skip
    """Natural frequencies about the first equilibrium.

    FILE is a model file or the name of a shipped example.  A mode that an oil film makes grow is named as oil whirl,
    with its frequency over the turning speed.  --require asks for mode1.frequency, mode1.damping or mode1.growth.

    \b
    Examples: rattle modes balanced_arm -o mode.svg
              rattle modes balanced_arm --require "final(mode1.frequency) >= 0.2 Hz"
    """
    from rattle.plots.curves import SUFFIXES, save_figure

    check_pictures(file, output, moving=True)
    m = read_model(file, settings, ideal)
    check_required(m, required, "modes", t or None)
    found = m.modes(t, effort=effort)
    if len(found) < mode and (output is not None or mode > 1):
        raise click.UsageError(f"--mode {mode}: the modes are numbered from 1 to {len(found)}")
    verdicts = _judge_modes(m, t, found, required) if required else []
    if as_json:
        asked = {"required": [verdict.record for verdict in verdicts]} if verdicts else {}
        click.echo(to_json(modes_record(found) | asked))
    else:
        click.echo(f"about: {found.about}")
        click.echo(str(found))
    if output is not None:
        if output.lower().endswith(SUFFIXES):
            save_figure(found.plot(mode - 1), output)
        else:
            found.animate(mode - 1, output)
        if not as_json:
            say_written(output)
    finish_required(ctx, verdicts, None if as_json else click.echo)


def _judge_modes(m: Mechanism, t: float, found: Modes, required: Sequence[str]) -> list[Verdict]:
    """Whether the modes keep what is required."""
    import numpy as np

    from rattle.studies.runs.analyses import modes_table

    return judge(modes_table(m, np.array([t]), [found]), required)


@click.command(cls=Command)
@model_options
@click.option(
    "--of", "curves", multiple=True, required=True, metavar="NAME",
    help="The output that may deviate, e.g. rocker.angle, coupler.P.x or a signal; may be given more than once.",
)  # fmt: skip
@span_options(73)
@click.option("--extremes/--no-extremes", default=True, show_default=True, help="Also compute the exact extremes.")
@click.option(
    "--limit", metavar="VALUE",
    help='The deviation that is allowed, e.g. "0.1 deg", of every --of; exit status 1 where it is exceeded.',
)  # fmt: skip
@click.option(
    "-o", "--output", metavar="FILE",
    help="Draw the error band and contributions: .svg, .png or .pdf; of several --of FILE-NAME.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Everything as JSON.")
@click.pass_context
def accuracy(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, curves: tuple[str, ...],
    t_end: float | None, points: int, extremes: bool, limit: str | None, output: str | None, as_json: bool,
) -> None:  # fmt: skip
    """What the play of the joints does to the accuracy of an output, and which joint to tighten first.

    FILE is a model file or the name of a shipped example.

    \b
    Examples: rattle accuracy path_generator --of coupler.P.y -o accuracy.svg
              rattle accuracy path_generator --of coupler.P.x --of coupler.P.y --limit "2 mm"
    """
    from rattle.plots.curves import save_figure

    check_pictures(file, output)
    if ideal:
        raise click.UsageError("accuracy is about play, and --ideal removes all of it; leave --ideal out")
    m = read_model(file, settings, False)
    times = span_times(m, t_end, points)
    check_deviations(m, curves, limit)
    answers = [m.accuracy(curve, times, extremes=extremes) for curve in curves]
    verdicts = [] if limit is None else [judge_deviation(answer, limit) for answer in answers]
    if as_json:
        records = [_accuracy_record(answer) for answer in answers]
        records = (
            [one | verdict.record for one, verdict in zip(records, verdicts, strict=True)] if verdicts else records
        )
        click.echo(to_json(records[0] if len(records) == 1 else records))
    else:
        click.echo("\n\n".join(map(str, answers)))
    for answer in answers if output is not None else ():
        target = Path(str(output))
        target = target if len(answers) == 1 else target.with_name(f"{target.stem}-{answer.of}{target.suffix}")
        save_figure(answer.plot(), target)
        if not as_json:
            say_written(target)
    finish_required(ctx, verdicts, None if as_json else click.echo)


def _accuracy_record(answer: Accuracy) -> dict[str, Any]:
    """The play of one output as a record; arrays over time [SI]."""
    keys = ("t", "nominal", "worst", "rss", "low", "high", "loaded", "pressed", "rule")
    contributions = dict(zip(answer.joints, answer.contributions.T.tolist(), strict=True))
    record = {"of": answer.of, "unit": answer.unit, "share": answer.share, "tighten": answer.tighten}
    return {**record, **{key: getattr(answer, key).tolist() for key in keys}, "contributions": contributions}
