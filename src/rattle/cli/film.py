"""Command that calculates a journal bearing: `rattle film`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.output import say_written

if TYPE_CHECKING:
    from rattle.studies.film.bearing import Film
    from rattle.studies.film.journal import JournalPosition

SHOWN = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)  # eccentricities of the table
PICTURES = (".svg", ".png", ".pdf")


@click.command()
@click.option(
    "--viscosity", required=True, metavar="VALUE", help='Dynamic, of the warm oil: "50 mPa*s", "50 cP", 0.05.'
)
@click.option("--length", required=True, metavar="VALUE", help="Of the bush, along its axis.")
@click.option("--radius", required=True, metavar="VALUE", help="Of the bore of the bush.")
@click.option("--clearance", required=True, metavar="VALUE", help="Radial: half of the difference of the diameters.")
@click.option("--load", metavar="VALUE", help='Steady load on one bearing, "500 N"; needs --speed.')
@click.option("--speed", metavar="VALUE", help='Of the pin in the bush at rest, "1000 rpm" or in rad/s; needs --load.')
@click.option(
    "--model", default="finite", show_default=True, metavar="NAME",
    help="finite: any length up to twice the diameter; short: closed form; pinkus-sternlicht: long, to repeat papers.",
)  # fmt: skip
@click.option(
    "--cavitation", default="reynolds", show_default=True, metavar="NAME",
    help="reynolds: no pressure below the surroundings; full: of either sign.",
)  # fmt: skip
@click.option(
    "--shear", default="whole", show_default=True, metavar="NAME",
    help="The film drags on the whole circumference, or where it has pressure: wetted.",
)  # fmt: skip
@click.option("-o", "--output", metavar="FILE", help="Chart (.svg, .png, .pdf) or table (.csv) to write.")
def film(load: str | None, speed: str | None, output: str | None, **bearing: str) -> None:
    """An oil film between pin and bush: what it carries, at which film thickness, and when the pin whirls.

    Prints a table of static positions, the same for every load and speed through the Sommerfeld number
    S = viscosity * N * (2 R L/load) * (R/c)^2, N in revolutions per second.  With --load and --speed it says where this
    load comes to rest.  A number without a unit is in SI units.

    \b
    Example:  rattle film --viscosity "50 mPa*s" --length "10 mm" --radius "10 mm" --clearance "50 um"
              rattle film --viscosity 0.02 --length 0.03 --radius 0.05 --clearance 1e-4 --load 1000 --speed "3000 rpm"
              rattle film --viscosity "20 cP" --length .03 --radius .05 --clearance 1e-4 --model short -o chart.svg

    e/c eccentricity over clearance; attitude from the load to the line of centres, in the sense of rotation; f R/c
    coefficient of friction; p_max over load/(2 R L); leakage over R c N L; m c w^2/W the mass from which the pin whirls
    and whirl/w the rate of whirl there, over the speed w ("never": every mass is stable).
    """
    from rattle.studies.film.bearing import Film

    table = output is not None and Path(output).suffix.lower() == ".csv"
    if output is not None and not table and Path(output).suffix.lower() not in PICTURES:
        raise ValueError(f"{output}: a film is written as .csv, or as a picture in .svg, .png or .pdf")
    if (load is None) != (speed is None):
        raise click.UsageError("the point of a load needs both, --load and --speed")
    made = Film(**bearing)
    found = None if load is None or speed is None else made.static(load, speed)
    click.echo("\n".join([*_locus(made), *(["", *_position(made, found)] if found is not None else [])]))
    for note in made.notes:
        click.echo(f"note: {note}", err=True)
    if output is None:
        return
    if table:
        _write(made.table(), output)
    else:
        from rattle.plots.curves import save_figure

        save_figure(made.plot(load, speed), output)
    say_written(output)


def _write(frame: Any, path: str) -> None:
    from rattle.atomic_file import atomic

    with atomic(path) as file:
        frame.to_csv(file, index=False, lineterminator="\n")


def _locus(made: Film) -> list[str]:
    """The static positions, a line each."""
    from rattle.studies.film.locus import locus

    columns = locus(made, SHOWN)
    heads = ("e/c", "S", "attitude", "f R/c", "p_max", "leakage", "m c w^2/W", "whirl/w")
    rows: list[tuple[str, ...]] = [heads]
    for k, e in enumerate(columns["eccentricity"]):
        numbers = [columns[name][k] for name in ("friction", "pressure", "leakage", "critical_mass", "whirl")]
        angle = f"{math.degrees(columns['attitude'][k]):.2f} deg"
        rows.append((f"{e:.2f}", f"{columns['sommerfeld'][k]:.4g}", angle, *map(_number, numbers)))
    widths = [max(len(row[k]) for row in rows) for k in range(len(heads))]
    said = f"film '{made.model}', L/D = {made.ratio:.3g}, R/c = {made.radius / made.clearance:.4g}"
    return [said, *("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)]


def _number(value: float) -> str:
    return "never" if value == math.inf else "-" if math.isnan(value) else f"{value:.4g}"


def _position(made: Film, found: JournalPosition) -> list[str]:
    """Where the load comes to rest."""
    from rattle.studies.film.journal import threshold

    mass, whirl = threshold(found.stiffness, found.damping)
    limit = "whirls with no mass at this speed" if mass == math.inf else f"whirls from {mass:.4g} kg on"
    lines = [
        f"load {found.load:.5g} N at {found.speed:.5g} rad/s",
        f"  Sommerfeld number  {found.sommerfeld:.5g}",
        f"  eccentricity       {found.eccentricity:.5f} of the clearance",
        f"  attitude           {math.degrees(found.attitude):.3f} deg",
        f"  least film         {1e6 * found.film_thickness:.4g} um",
        f"  peak pressure      {1e-6 * found.pressure:.4g} MPa",
        f"  friction           {found.friction:.4g} (coefficient), {found.loss:.4g} W",
        f"  leakage            {1e6 * found.leakage:.4g} cm^3/s",
        f"  stiffness [N/m]    {_matrix(found.stiffness)}",
        f"  damping [N*s/m]    {_matrix(found.damping)}",
        f"  stability          {limit}"
        + ("" if math.isnan(whirl) else f", {whirl / abs(found.speed):.4g} of the speed"),
    ]
    return [one for one in lines if "nan" not in one]


def _matrix(numbers: Any) -> str:
    """Two rows in one line; x along the load, y turned from it in the sense of the speed."""
    return "; ".join(f"{row[0]:.5g} {row[1]:.5g}" for row in numbers)
