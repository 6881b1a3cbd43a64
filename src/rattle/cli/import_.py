"""The command that reads a file of another program."""

from __future__ import annotations

import click

from rattle.cli.command import Command
from rattle.cli.output import check_files, say_written


@click.command(cls=Command, name="import")
@click.argument("file", metavar="FILE")
@click.option(
    "-o", "--output", metavar="FILE", help="Model file to write, .toml or .json; without it the text is printed."
)
@click.option("--scale", metavar="LENGTH", help="Length of the file's unit, as 1mm, where the format has no units.")
@click.option("--steps-per-second", metavar="NUMBER", help="Of a pylinkage file, which counts steps.  [default: 25]")
@click.option("--thickness", metavar="LENGTH", help="Of outlines in a drawing.  [default: 10 mm]")
@click.option("--density", metavar="DENSITY", help="Of their material.  [default: 7850 kg/m^3]")
def import_(
    file: str, output: str | None, scale: str | None, steps_per_second: str | None, thickness: str | None,
    density: str | None,
) -> None:  # fmt: skip
    """Read a mechanism of another program and write it as a model file.

    FILE is an assembly of Ondsel or FreeCAD (.asmt), a drawing (.dxf, .svg), a text file with a link of PMKS+ (pmks:
    and the link, or the address of the page), or a mechanism of pylinkage (.json).  The content says which it is.  What
    was taken, what is assumed and what was left out is listed, by the names that things have in the file.

    A file that cannot be read, or a mechanism that does not move in a plane, is refused in one line, and nothing is
    written.

    \b
    Examples: rattle import bars.asmt -o bars.toml
              rattle import walker.json --scale 1cm --steps-per-second 50 > walker.toml
    """
    from rattle.cli.options import value
    from rattle.description.file import save, wants_json
    from rattle.exchange.read import assumptions, mechanism, read_import, words
    from rattle.mechanism import Mechanism

    json = output is not None and wants_json(output)
    check_files(file, output)
    stated = {"scale": scale, "steps_per_second": steps_per_second, "thickness": thickness, "density": density}
    read = read_import(file, assumptions(**{n: None if text is None else value(text) for n, text in stated.items()}))
    m = mechanism(read, file)
    text = m.to_json() if json else m.to_toml()
    lines = [f"taken: {file}, a model file"] if isinstance(read, Mechanism) else words(read)
    for line in lines:
        click.echo(line, err=output is None)
    if output is None:
        click.echo(text, nl=False)
    else:
        save(output, text)
        say_written(output)
