"""The command that writes a model as a program in another language."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model, time
from rattle.cli.output import check_files, say_written

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

WRITTEN = {".c": "C99 program", ".js": "ES module", ".mjs": "ES module", ".fmu": "FMI 3.0"}


@click.command(cls=Command)
@model_options
@click.option(
    "-o", "--output", metavar="FILE", required=True,
    help="File to write: .c (C99, needs only the C library), .js or .mjs (ES module for web pages and node), "
    ".fmu (FMI 3.0 for other simulation tools).",
)  # fmt: skip
@click.option("--t-end", metavar="TIME", default=None, help="End of a run unless it is told otherwise.")
@click.option("--step", metavar="TIME", default=None, help="Its step unless it is told otherwise.  [default: 0.1 ms]")
def code(file: str, settings: tuple[str, ...], ideal: bool, output: str, t_end: str | None, step: str | None) -> None:
    """Write a mechanism as a program that needs neither rattle nor Python: C, or JavaScript for a web page.

    It holds the right-hand side, the projection onto the constraints, all result curves, and a run by Runge-Kutta steps
    of order 4 that stops with a message where the energy error exceeds 0.1 %.  Numbers are in SI units.  Parameters of
    the model stay changeable: the start is found anew for their values.  The comment on top of the file lists them,
    those that are fixed and why, and the result curves.

    C: cc -std=c99 -O2 model.c -lm, then ./a.out [t_end [step]] [name=value ...] prints the motion as CSV.

    JavaScript: import { run, names, parameters } from "./model.js"; run(0.5, 1e-4, { ...parameters, r3: 0.002 })
    returns rows of what names lists; start, derivative, project and outputs serve steps of your own.

    FMU: for model exchange and co-simulation; the tool that runs it gives the tolerance.  It holds the C sources, and a
    library for this platform where there is a C compiler.

    Models with contacts, friction, clutches, oil, states or expressions that switch need the compiled kernels of
    rattle, with the steps and events of `rattle run`.  JavaScript: run(0.5, undefined, { r3: 0.002 }) returns
    { rows, events, success, message, statistics }.  FMU: for co-simulation, with a library for this platform, which a
    C compiler links; parameters are set before the start, and in event mode a step ends early at every event.  As C
    they are refused.

    \b
    Examples: rattle code fourbar -o model.c
              rattle code fourbar -o model.js
              rattle code fourbar -o model.fmu
              rattle code slider_crank --set "speed=3000 rpm" --step 10us -o model.c
    """
    from rattle.analyses.straight_line.code import LONGEST

    ending = Path(output).suffix
    if ending not in WRITTEN:
        listed = ", ".join(f"{name} ({what})" for name, what in WRITTEN.items())
        raise click.UsageError(f"-o {output}: expected a name that ends in {listed}")
    if ending == ".fmu" and step is not None:
        raise click.UsageError("--step has no meaning in an FMU: the tool that runs it gives a tolerance")
    check_files(file, output)
    m = read_model(file, settings, ideal)
    until = m.model.settings.t_end if t_end is None else time(t_end)
    asked = time(step) if step is not None else m.model.settings.step
    longest = asked or LONGEST
    if not (until > 0.0 and longest > 0.0 and until / longest <= 1e9):
        raise click.UsageError("--t-end and --step must be positive, with at most 1e9 steps")
    if ending == ".fmu":
        _write_fmu(m, Path(file).stem, until, output)
    elif ending == ".c":
        _write_straight_line(m, True, until, longest, output)
    else:
        _write_javascript(m, until, longest, asked, output)


def _write_straight_line(m: Mechanism, in_c: bool, until: float, longest: float, output: str) -> None:
    """Raises TraceError for what straight-line code cannot follow."""
    from rattle.analyses.straight_line.code import c_program, javascript_module, program
    from rattle.atomic_file import atomic

    straight = program(m.recorded())
    text = (c_program if in_c else javascript_module)(straight, m.name or "A mechanism", until, longest)
    with atomic(output) as place:
        place.write_text(text, encoding="utf-8")
    for name, why in straight.constants.items():
        click.echo(f"note: {name} stays fixed: {why}", err=True)
    say_written(output)


def _write_javascript(m: Mechanism, until: float, longest: float, step: float | None, output: str) -> None:
    """As straight-line code, whose parameters can be changed, or else with the compiled kernels."""
    from rattle.errors import TraceError

    try:
        _write_straight_line(m, False, until, longest, output)
    except TraceError as error:
        _write_compiled(m, until, step, output)
        click.echo(f"note: {error}: the file holds compiled kernels", err=True)


def _write_compiled(m: Mechanism, until: float, step: float | None, output: str) -> None:
    from rattle.atomic_file import atomic
    from rattle.pages.compiled_module import compiled_module

    text, fixed = compiled_module(m, m.name or "A mechanism", until, step)
    with atomic(output) as place:
        place.write_text(text, encoding="utf-8")
    for name, why in fixed.items():
        click.echo(f"note: {name} stays fixed: {why}", err=True)
    say_written(output)


def _write_fmu(m: Mechanism, name: str, until: float, output: str) -> None:
    """As straight-line code, for model exchange too, or else with the compiled kernels."""
    from rattle.analyses.straight_line.mock_up import mock_up
    from rattle.atomic_file import atomic
    from rattle.errors import TraceError

    why = ""
    try:
        unit = mock_up(m.recorded(), name, until)
    except TraceError as error:
        from rattle.pages.compiled_unit import compiled_unit

        unit, why = compiled_unit(m, name, until), f"note: {error}: the file holds compiled kernels, for co-simulation"
    with atomic(output) as place:
        place.write_bytes(unit.content)
    for note in unit.notes:
        click.echo(f"note: {note}", err=True)
    say_written(output)
    if why:
        click.echo(why, err=True)
