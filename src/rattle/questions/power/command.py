"""The command `rattle power`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.options import run_laws, settings_option, time
from rattle.cli.question_command import Asked, Shown, json_option, plain_command
from rattle.errors import InputError
from rattle.jit.choices import TINY
from rattle.questions.power.in_units import in_units, with_units

if TYPE_CHECKING:
    from rattle.questions.power.compute import Power

WHOLE = 1e-9  # [of the run] difference of a cycle from the whole run that is rounding
SEEN = 1e-9  # share of the largest energy below which one is rounding
WORDS = ("element", "kind", "body")
PORTS = ("element", "body", "E_in", "E_out", "net", "recirculated", "peak", "mean")
ENERGIES = ("supplied", "lost", "stored", "recirculated")
ELEMENTS = ("element", "kind", *ENERGIES)


@plain_command
@click.argument("file", metavar="RESULT")
@click.option("--cycle", type=time, metavar="TIME", help="Length of the cycle before the end, in s or as '20 ms'.")
@click.option("--at", "instant", type=time, metavar="TIME", help="Powers at this instant instead.")
@click.option("--curves", is_flag=True, help="Draw the powers over time, in place of where energy goes.")
@click.option(
    "--laws", multiple=True, metavar="FILE.py",
    help="Run this Python file, which defines laws of the model; may be given more than once.",
)  # fmt: skip
@settings_option
@click.option("-o", "--output", metavar="FILE", help="Picture (.svg, .png, .pdf) or table (.csv) to write.")
@json_option("All ports and elements as JSON, in SI units.")
def power(asked: Asked, cycle: float | None, instant: float | None, curves: bool, laws: tuple[str, ...]) -> Shown:
    """Where the energy of a saved motion goes: who gives it to which body, and where it is lost.

    Without --cycle it is the last turn of the driver, or the whole motion.  The motion is repeated from the model that
    the result holds.  Powers are positive into the body.

    \b
    Example:  rattle power out.nc
              rattle power out.nc --cycle "20 ms" -o power.svg
              rattle power out.nc -o power.csv
    """
    _require_sense(asked.output, curves, instant)
    prints = asked.output is None
    asked = asked.by_suffix()
    asked.check()
    run_laws(laws)
    r = asked.result()
    end = r.trust.t_end
    p = r.power() if cycle is None else r.power(0.0 if abs(end - cycle) < WHOLE * end else end - cycle)

    def words() -> str:
        if not prints:
            return ""
        return _cycle(p) if instant is None else _instant(p, instant)

    table = asked.tabled(lambda: with_units(p.table if instant is None else p.at(instant)))
    return Shown(words, lambda: _record(p, instant), (*table, *asked.drawn(p.plot_curves if curves else p.plot)))


def _record(p: Power, instant: float | None) -> dict[str, object]:
    """The powers at an instant, or the energies of the cycle."""
    if instant is not None:
        return {"t": instant, "ports": p.at(instant).to_dict("records")}
    ports, elements = (frame.to_dict("records") for frame in (p.table, p.elements))
    facts = {"t0": p.t0, "t1": p.t1, "residual": p.residual, "remark": p.remark}
    return {**facts, "ports": ports, "elements": elements}


def _require_sense(output: str | None, curves: bool, instant: float | None) -> None:
    """Raise InputError for a file that is none of a table or picture, click.UsageError for options that do not fit."""
    from rattle.plots.curves import SUFFIXES

    table = output is not None and Path(output).suffix.lower() not in SUFFIXES
    if table and Path(str(output)).suffix.lower() != ".csv":
        raise InputError(f"{output}: power is written as .csv, or as a picture in .svg, .png or .pdf")
    if curves and (output is None or table):
        raise click.UsageError("--curves draws a picture: give its name, -o power.svg")
    if instant is not None and output is not None and not table:
        raise click.UsageError("--at prints or writes a table: give the name of a .csv file, or leave -o out")


def _instant(p: Power, t: float) -> str:
    """The powers of all ports at an instant."""
    from rattle.results.display import quantity

    frame, (_, power) = in_units(p.at(t))
    return f"power into bodies [{power}] at t = {quantity(t, 's', 6)}\n{_lines(frame, (*WORDS, 'power'))}"


def _cycle(p: Power) -> str:
    """Energies of the cycle: of all ports, then of elements that give, lose or store any."""
    from rattle.results.display import quantity

    (ports, (energy, power)), (elements, _) = in_units(p.table), in_units(p.elements)
    largest = float(max((ports["E_in"] + ports["E_out"]).max() if len(ports) else 0.0, TINY))
    least = SEEN * largest
    numbers = elements[list(ENERGIES)]
    active = elements[(numbers.abs() > least).any(axis=1)]
    start = quantity(p.t0, "s", 6).split()[0]
    lines = [
        f"energy [{energy}] and power [{power}] into bodies, t = {start} to {quantity(p.t1, 's', 6)}",
        _lines(ports[ports["E_in"] + ports["E_out"] > least], PORTS, least),
        *([p.remark] if p.remark else []),
        "",
        f"elements [{energy}]",
        _lines(active, ELEMENTS, least),
        "",
        f"largest imbalance of a body: {quantity(p.residual, 'W', 2)}",
    ]
    return "\n".join(lines)


def _lines(frame: Any, columns: tuple[str, ...], least: float = 0.0) -> str:
    """Columns of a table as text; numbers below `least` are rounding."""
    from rattle.results.display import in_columns

    rows = [[_cell(value, least) for value in row] for row in frame[list(columns)].itertuples(index=False)]
    return "\n".join(in_columns([columns, *rows], [k for k, name in enumerate(columns) if name not in WORDS]))


def _cell(value: Any, least: float) -> str:
    if isinstance(value, str):
        return value
    if math.isnan(value):
        return "-"
    return "0" if abs(value) <= least else f"{value:.5g}"
