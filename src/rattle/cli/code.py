"""The command that writes a model as a program in another language."""

from __future__ import annotations

from pathlib import Path

import click

from rattle.cli.options import model_options, read_model, time
from rattle.cli.output import check_files, say_written


@click.command()
@model_options
@click.option(
    "-o", "--output", metavar="FILE", required=True, help="File to write: .c (C99, needs only the C library)."
)
@click.option("--t-end", metavar="TIME", default=None, help="End of the program's run unless it is told otherwise.")
@click.option("--step", metavar="TIME", default=None, help="Its step unless it is told otherwise.  [default: 0.1 ms]")
def code(file: str, settings: tuple[str, ...], ideal: bool, output: str, t_end: str | None, step: str | None) -> None:
    """Write a mechanism as a C program: right-hand side, projection onto the constraints, all result curves, rk4.

    Compiled with cc -std=c99 -O2 model.c -lm it prints the motion as CSV in SI units: ./a.out [t_end [step]], in s.
    It stops with a message where the energy error exceeds 0.1 %, as a run does.  It has no events, so models with
    contacts are refused; massless links, loads and drivers are not.

    \b
    Examples: rattle code fourbar -o model.c
              rattle code slider_crank --set "speed=3000 rpm" --step 10us -o model.c
    """
    from rattle.analyses.straight_line.code import LONGEST, c_program, straight_line
    from rattle.atomic_file import atomic

    if Path(output).suffix != ".c":
        raise click.UsageError(f"-o {output}: expected a name that ends in .c; other languages are not written yet")
    check_files(file, output)
    m = read_model(file, settings, ideal)
    until = m.model.settings.t_end if t_end is None else time(t_end)
    longest = time(step) if step is not None else m.model.settings.step or LONGEST
    if not (until > 0.0 and longest > 0.0 and until / longest <= 1e9):
        raise click.UsageError("--t-end and --step must be positive, with at most 1e9 steps")
    text = c_program(straight_line(m.recorded()), m.name or "A mechanism", until, longest)
    with atomic(output) as place:
        place.write_text(text, encoding="utf-8")
    say_written(output)
