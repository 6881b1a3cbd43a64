"""What commands about positions share: the options of instants, tables and records of curves."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.command import Options
from rattle.cli.options import time
from rattle.cli.question_command import Asked, Shown
from rattle.cli.requirements import check_required

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result

ZERO = 1e-12  # share of the largest value of the same unit below which a number is rounding


def span_options(points: int) -> Options:
    """Add the options --t-end and --points (default `points`) to a command."""

    def add(function: Callable[..., Any]) -> Callable[..., Any]:
        function = click.option(
            "--points", type=click.IntRange(2, 10_000_000), default=points, show_default=True,
            help="Number of positions, evenly spaced in time.",
        )(function)  # fmt: skip
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


def ranges(m: Mechanism, result: Result, names: list[str]) -> str:
    """Table of the least and greatest value of curves and their times, interpolated where a curve is smooth.

    Instants without a value are left out.
    """
    import numpy as np

    from rattle.results.contact_summary import extreme
    from rattle.results.display import quantity, scale, zeroed
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


def notes(result: Result) -> str:
    """How many positions, where reactions are not unique, and what the result says of its trust."""
    lines = [f"{len(result.t)} positions, all joints close"]
    if result.trust.nonunique:
        lines.append(
            f"reactions not unique (redundant constraints) at {', '.join(result.trust.nonunique)}; "
            "the motion is correct"
        )
    return "\n".join([*lines, *result.trust.notes])


def record(result: Result) -> dict[str, object]:
    """What JSON holds of a motion: its events, its trust and the range of every curve, in SI."""
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
    facts = {"success": result.success, "message": result.message, "trust": result.trust.to_dict()}
    return {**facts, "events": events, "curves": curves}


def moved(
    asked: Asked, m: Mechanism, analysis: str, t_end: float | None, points: int,
    ask: Callable[[np.ndarray], Result], words: Callable[[Result], list[str]],
) -> Shown:  # fmt: skip
    """What is shown of a motion position by position.

    ask: for the motion at instants (points,) [s].  words: lines about it, before its notes.
    """
    check_required(m, asked.required, analysis, t_end)
    result = ask(span_times(m, t_end, points))
    return asked.shown(result, lambda: "\n".join([*words(result), notes(result)]), lambda: record(result))


at_option = click.option(
    "--at", "t", type=time, default=0.0, show_default=True,
    help="Time at which the drivers are held, in s or as '20 ms'.",
)  # fmt: skip
effort_option = click.option(
    "--effort", type=click.FloatRange(0.0, min_open=True), default=1.0, show_default=True,
    help="Work allowed for the search for equilibria; 10 allows ten times as much, at most 10000.",
)  # fmt: skip
