"""The command `rattle film`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.options import given, only_oiled, read_model
from rattle.cli.question_command import Asked, Shown, json_option, plain_command
from rattle.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from rattle.questions.film.bearing import Film
    from rattle.questions.film.journal import JournalPosition
    from rattle.results.result import Result

SHOWN = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)  # eccentricities of the table
SIZES = ("viscosity", "length", "radius", "clearance")
SPARSE = 25  # every so many rows of a Stribeck curve are printed


@plain_command
@click.option(
    "--of", "source", metavar="FILE",
    help="Model file or shipped example: takes the bearing from a joint with oil, and draws where that joint is.",
)  # fmt: skip
@click.option("--joint", metavar="JOINT", help="Which one of --of; default: the only joint with oil.")
@click.option("--viscosity", metavar="VALUE", help='Dynamic, of the warm oil: "50 mPa*s", "50 cP", 0.05.')
@click.option("--length", metavar="VALUE", help="Of the bush, along its axis.")
@click.option("--radius", metavar="VALUE", help="Of the bore of the bush.")
@click.option("--clearance", metavar="VALUE", help="Radial: half of the difference of the diameters.")
@click.option("--load", metavar="VALUE", help='Steady load on one bearing, "500 N"; needs --speed.')
@click.option("--speed", metavar="VALUE", help='Of the pin in the bush at rest, "1000 rpm" or in rad/s; needs --load.')
@click.option(
    "--boundary-film", metavar="VALUE",
    help='Thickness at which the surfaces touch, "1 um": adds the Stribeck curve of --load; -o then draws that.',
)  # fmt: skip
@click.option(
    "--friction", default=0.1, show_default=True, metavar="NUMBER", help="Dry coefficient of the Stribeck curve."
)
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
@json_option("Static positions, where the load rests and the Stribeck curve as JSON, in SI units.")
def film(
    asked: Asked, source: str | None, joint: str | None, load: str | None, speed: str | None,
    boundary_film: str | None, friction: float, **bearing: str | None,
) -> Shown:  # fmt: skip
    """An oil film between pin and bush: what it carries, at which film thickness, and when the pin whirls.

    Prints a table of static positions, the same for every load and speed through the Sommerfeld number
    S = viscosity * N * (2 R L/load) * (R/c)^2, N in revolutions per second.  With --load and --speed it says where this
    load comes to rest.  A number without a unit is in SI units.

    \b
    Example:  rattle film --viscosity "50 mPa*s" --length "10 mm" --radius "10 mm" --clearance "50 um"
              rattle film --viscosity 0.02 --length 0.03 --radius 0.05 --clearance 1e-4 --load 1000 --speed "3000 rpm"
              rattle film --viscosity "20 cP" --length .03 --radius .05 --clearance 1e-4 --model short -o chart.svg
              rattle film --of slider_crank_oil --load "500 N" --boundary-film "1 um" -o stribeck.svg
              rattle film --of slider_crank_oil -o load_points.svg

    e/c eccentricity over clearance; attitude from the load to the line of centres, in the sense of rotation; f R/c
    coefficient of friction; p_max over load/(2 R L); leakage over R c N L; m c w^2/W the mass from which the pin whirls
    and whirl/w the rate of whirl there, over the speed w ("never": every mass is stable).  With --of the chart has a
    dot for every output of its orbit; dots beside the line carry by squeezing oil.
    """
    _require_complete(load, speed, boundary_film, asked.output)
    asked = asked.by_suffix()._replace(file=source or "")
    asked.check()
    orbit = None
    if source is None:
        if joint is not None:
            raise click.UsageError("--joint names a joint of a model: give --of FILE")
        oil_film = _of_sizes(bearing)
    else:
        oil_film, orbit, joint = _of_model(source, joint, bearing)
    position = None if load is None or speed is None else oil_film.static(load, speed)
    curve = None
    if boundary_film is not None and load is not None:
        curve = oil_film.stribeck(load, boundary_film=boundary_film, friction=friction)

    def words() -> str:
        lines = [*_locus(oil_film), *(["", *_position(oil_film, position)] if position is not None else [])]
        if curve is not None:
            lines += ["", f"Stribeck curve at {load}, boundary film {boundary_film}", *_stribeck(curve)]
        return "\n".join(lines)

    def draw() -> Figure:
        if boundary_film is not None and load is not None:
            return oil_film.plot_stribeck(load, boundary_film=boundary_film, friction=friction)
        return oil_film.plot(load, speed, result=orbit, joint=joint or "")

    return Shown(
        words, lambda: _record(oil_film, position, curve),
        (*asked.tabled(lambda: oil_film.table() if curve is None else curve), *asked.drawn(draw)),
        remarks=[f"note: {note}" for note in oil_film.notes],
    )  # fmt: skip


def _record(oil_film: Film, position: JournalPosition | None, curve: DataFrame | None) -> dict[str, object]:
    """Columns of static positions and of the Stribeck curve, and where the load comes to rest."""
    from rattle.questions.film.journal import threshold
    from rattle.questions.film.locus import locus

    record: dict[str, object] = {"model": oil_film.model, "notes": oil_film.notes, "static": locus(oil_film, SHOWN)}
    if position is not None:
        mass, whirl = threshold(position.stiffness, position.damping)
        record["position"] = asdict(position) | {"critical_mass": mass, "whirl": whirl}
    return record | ({} if curve is None else {"stribeck": curve.to_dict("list")})


def _require_complete(load: str | None, speed: str | None, boundary_film: str | None, output: str | None) -> None:
    """Raise InputError for a file that cannot be written, click.UsageError for half of a question."""
    from rattle.plots.curves import SUFFIXES

    if output is not None and Path(output).suffix.lower() not in (".csv", *SUFFIXES):
        raise InputError(f"{output}: a film is written as .csv, or as a picture in .svg, .png or .pdf")
    if boundary_film is None and (load is None) != (speed is None):
        raise click.UsageError("the point of a load needs both, --load and --speed")
    if boundary_film is not None and load is None:
        raise click.UsageError("a Stribeck curve needs --load")


def _of_sizes(bearing: Mapping[str, str | None]) -> Film:
    """The film of a bearing that is given by itself.  Raises click.UsageError for sizes that are missing."""
    from rattle.questions.film.bearing import Film

    sizes = {name: size for name, size in bearing.items() if size is not None}
    missing = [f"--{name}" for name in SIZES if name not in sizes]
    if missing:
        raise click.UsageError(f"missing {', '.join(missing)}; or take them from a model: --of FILE")
    return Film(**sizes)


def _of_model(source: str, joint: str | None, bearing: Mapping[str, str | None]) -> tuple[Film, Result, str]:
    """The film of a joint of a model, its orbit, and its name.  Raises click.UsageError for sizes given twice."""
    options = [f"--{name}" for name in bearing if given(click.get_current_context(), name)]
    if options:
        raise click.UsageError(f"{', '.join(options)}: the model says that already; leave it out with --of")
    m = read_model(source, (), False)
    name = joint if joint is not None else only_oiled(m)
    oil_film = m.film(name)
    return oil_film, m.orbit(name), name


def _stribeck(frame: DataFrame) -> list[str]:
    """The Stribeck curve, a line for each speed."""
    from rattle.results.chosen_units import column_unit
    from rattle.results.display import quantity

    rate = column_unit("rad/s")
    lines = [f"{f'speed [{rate.unit}]':>13s}  friction  dry share  least film"]
    for row in frame.iloc[::SPARSE].itertuples():
        share, film = f"{100 * row.dry:.3g} %", quantity(row.film_thickness, "m", usual="um")
        lines.append(f"{rate.factor * row.speed:13.4g}  {row.friction:8.4g}  {share:>9}  {film:>10}")
    return lines


def _locus(oil_film: Film) -> list[str]:
    """The static positions, a line each."""
    from rattle.questions.film.locus import locus
    from rattle.results.display import in_columns

    columns = locus(oil_film, SHOWN)
    heads = ("e/c", "S", "attitude", "f R/c", "p_max", "leakage", "m c w^2/W", "whirl/w")
    rows: list[tuple[str, ...]] = [heads]
    for k, e in enumerate(columns["eccentricity"]):
        numbers = [columns[name][k] for name in ("friction", "pressure", "leakage", "critical_mass", "whirl")]
        angle = f"{math.degrees(columns['attitude'][k]):.2f} deg"
        rows.append((f"{e:.2f}", f"{columns['sommerfeld'][k]:.4g}", angle, *map(_number, numbers)))
    title = f"film '{oil_film.model}', L/D = {oil_film.ratio:.3g}, R/c = {oil_film.radius / oil_film.clearance:.4g}"
    return [title, *in_columns(rows, range(len(heads)))]


def _number(value: float) -> str:
    return "never" if value == math.inf else "-" if math.isnan(value) else f"{value:.4g}"


def _position(oil_film: Film, position: JournalPosition) -> list[str]:
    """Where the load comes to rest."""
    from rattle.questions.film.journal import threshold
    from rattle.results.chosen_units import chosen
    from rattle.results.display import quantity

    turned = quantity(position.attitude, "rad", 6) if chosen("rad") else f"{math.degrees(position.attitude):.3f} deg"
    film = quantity(position.film_thickness, "m", usual="um")

    mass, whirl = threshold(position.stiffness, position.damping)
    limit = "whirls with no mass at this speed" if mass == math.inf else f"whirls from {mass:.4g} kg on"
    lines = [
        f"load {quantity(position.load, 'N', 5)} at {quantity(position.speed, 'rad/s', 5, 'rad/s')}",
        f"  Sommerfeld number  {position.sommerfeld:.5g}",
        f"  eccentricity       {position.eccentricity:.5f} of the clearance",
        f"  attitude           {turned}",
        f"  least film         {film}",
        f"  peak pressure      {quantity(position.pressure, 'Pa', usual='MPa')}",
        f"  friction           {position.friction:.4g} (coefficient), {quantity(position.loss, 'W')}",
        f"  leakage            {quantity(position.leakage, 'm^3/s', usual='cm^3/s')}",
        f"  stiffness [N/m]    {_matrix(position.stiffness)}",
        f"  damping [N*s/m]    {_matrix(position.damping)}",
        f"  stability          {limit}"
        + ("" if math.isnan(whirl) else f", {whirl / abs(position.speed):.4g} of the speed"),
    ]
    return [line for line in lines if "nan" not in line]


def _matrix(numbers: Any) -> str:
    """Two rows in one line; x along the load, y turned from it in the sense of the speed."""
    return "; ".join(f"{row[0]:.5g} {row[1]:.5g}" for row in numbers)
