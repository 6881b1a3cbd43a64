"""Commands that look up named data: the play of a fit, the viscosity of an oil."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rattle.cli.command import Command
from rattle.cli.options import value

if TYPE_CHECKING:
    from rattle.catalogue.fits import Fit

MICRO, MILLI, MM2 = 1e6, 1e3, 1e6  # um in a m, mPa s in a Pa s, mm^2/s in a m^2/s
DIGITS = 6  # of figures printed
USUAL = ("20 degC", "40 degC", "60 degC", "80 degC", "100 degC")  # temperatures of a table that names none


@click.command(cls=Command)
@click.argument("fit_", metavar="FIT")
@click.argument("sizes", metavar="DIAMETER...", nargs=-1, required=True)
@click.option("--json", "wants_json", is_flag=True, help="The answer as JSON, in SI units.")
def fit(fit_: str, sizes: tuple[str, ...], wants_json: bool) -> None:
    """Play of a pin in its bush by a fit of ISO 286.

    FIT is hole and shaft with their grades: holes A to H and JS, shafts a to h and js, grades 01 to 18.  DIAMETER is
    the nominal size, a text with a unit or a number in m, up to 500 mm; several give a line each.  A fit that can
    come out with interference is refused.

    EI and ES are the limits of the hole, ei and es those of the shaft, as deviations from the nominal size.  `least`
    and `largest` are the play as a difference of diameters; half of it is the radial play, which models call clearance:
    `radial` is its middle, and parts within their tolerances differ from it by `tol` at most.

    \b
    Examples: rattle fit H7/g6 "8 mm"
              rattle fit H8/f7 6mm 10mm 25mm
              rattle fit E9/h9 "20 mm" --json
    """
    from rattle.answers.text import columns
    from rattle.catalogue.fits import fit as look_up
    from rattle.cli.output import as_json

    fits = [look_up(fit_, value(size)) for size in sizes]
    if wants_json:
        record = {"fit": fits[0].text, "source": fits[0].source, "sizes": [_record(fit) for fit in fits]}
        click.echo(as_json(record))
        return
    click.echo(f"{fits[0].text}: limits of hole and shaft, and their play ({fits[0].source})")
    lengths = ("EI", "ES", "ei", "es", "least", "largest", "radial", "tol")
    head = ("diameter", *(f"{name} [um]" for name in lengths))
    click.echo(columns(head, [_row(fit) for fit in fits]))
    for fit in fits:
        click.echo(fit.words)


def _record(fit: Fit) -> dict[str, Any]:
    """A fit at one size, in m."""
    keys = ("diameter", "hole", "shaft", "least", "largest", "radial", "tol", "bore", "pin")
    return {key: getattr(fit, key) for key in keys}


def _row(fit: Fit) -> list[str]:
    """A fit at one size as a line of a table."""
    figures = (*fit.hole, *fit.shaft, fit.least, fit.largest, fit.radial, fit.tol)
    return [f"{fit.diameter * 1e3:.9g} mm", *(f"{figure * MICRO:.{DIGITS}g}" for figure in figures)]


@click.command(cls=Command, context_settings={"ignore_unknown_options": True})  # -10 degC is no option
@click.argument("oil_", metavar="OIL")
@click.argument("temperatures", metavar="[TEMPERATURE]...", nargs=-1)
@click.option("--vi", metavar="NUMBER", help="Viscosity index.  [default: 95, typical of mineral oils]")
@click.option("--density", metavar="DENSITY", help="Density at 15 degC.  [default: 880 kg/m^3, typical]")
@click.option("--json", "wants_json", is_flag=True, help="The answer as JSON, in SI units.")
def oil(oil_: str, temperatures: tuple[str, ...], vi: str | None, density: str | None, wants_json: bool) -> None:
    """Viscosity of an oil over temperature, by its grade.

    OIL is a grade of ISO 3448, such as "ISO VG 46".  TEMPERATURE is a text with a unit, or a number in kelvin, from
    -30 to 230 degC; without one the table goes from 20 to 100 degC.  The law is that of ASTM D341, with the viscosity
    index by ASTM D2270.  What is typical rather than of this oil is said below the table.

    \b
    Examples: rattle oil "ISO VG 46" "40 degC" "60 degC"
              rattle oil "ISO VG 100" --vi 140 --density "860 kg/m^3" "-10 degC"
              rattle oil "ISO VG 32" --json
    """
    from rattle.answers.text import columns
    from rattle.catalogue.oils import oil as look_up
    from rattle.catalogue.oils import temperature
    from rattle.cli.output import as_json

    stated = {key: value(text) for key, text in (("vi", vi), ("density", density)) if text is not None}
    named = look_up({"vg": oil_, **stated} if stated else oil_)
    kelvins = [temperature(value(text)) for text in temperatures or USUAL]
    figures = [(T, named.kinematic(T), named.density(T), named.viscosity(T)) for T in kelvins]
    if wants_json:
        names = ("temperature", "kinematic", "density", "viscosity")
        record = {"oil": named.title, "vi": named.vi, "nu40": named.nu40, "nu100": named.nu100}
        rows = [dict(zip(names, row, strict=True)) for row in figures]
        click.echo(as_json({**record, "assumed": list(named.assumed), "temperatures": rows}))
        return
    click.echo(f"{named.title}: viscosity index {named.vi:.4g} (ASTM D341, D2270)")
    head = ("temperature", "viscosity [mPa s]", "kinematic [mm^2/s]", "density [kg/m^3]")
    click.echo(columns(head, [_of_oil(*row) for row in figures]))
    for words in named.assumed:
        click.echo(f"assumed: {words}")


def _of_oil(kelvin: float, kinematic: float, density: float, viscosity: float) -> list[str]:
    """An oil at one temperature as a line of a table."""
    from rattle.language.units import FREEZING

    figures = (viscosity * MILLI, kinematic * MM2, density)
    return [f"{round(kelvin - FREEZING, 6) + 0.0:g} degC", *(f"{figure:.5g}" for figure in figures)]
