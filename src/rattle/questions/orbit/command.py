"""The command `rattle orbit`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.command import Command
from rattle.cli.instants import span_options, span_times
from rattle.cli.options import model_options, only_oiled, read_model
from rattle.cli.output import as_json as to_json
from rattle.cli.output import check_pictures, check_results, fallback_option, finish, keep, say_written

if TYPE_CHECKING:
    from rattle.results.result import Result


@click.command(cls=Command)
@model_options
@click.option("--joint", metavar="JOINT", help="Whose pin is followed; default: the only joint with oil.")
@span_options(1001)
@click.option(
    "-o", "--output", metavar="FILE",
    help="Picture of the orbit to write (.svg, .png, .pdf), or the result (.nc, .npz) for plot, animate and export.",
)  # fmt: skip
@click.option("--csv", metavar="FILE", help="Also write all curves as CSV.")
@fallback_option
@click.option(
    "--json", "as_json", is_flag=True, help="The summary of the film, ranges of its curves and trust as JSON."
)
@click.pass_context
def orbit(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, joint: str | None, t_end: float | None,
    points: int, output: str | None, csv: str | None, fallback: str | None, as_json: bool,
) -> None:  # fmt: skip
    """Orbit of a pin in its oil film, under the forces of the mechanism without play.

    FILE is a model file or the name of a shipped example; its drivers have to determine every position.  The pin starts
    in the middle of its bush, or at its offset in [initial], and gets onto its closed orbit within a turn or two.
    Quicker than `rattle run` by the time that the motion of the pin in its clearance takes, whose inertia is left out:
    the least film agrees while the film is loaded, the path differs while it is not.

    \b
    Example:  rattle orbit slider_crank_oil
              rattle orbit slider_crank_oil --joint B --set mu="20 cP" --t-end "24 ms" -o orbit.svg

    The table: least thickness of the film, when, and where the crank (the first driven joint) is then; largest
    pressure; mean and largest power that the film and dry friction lose; share of the time in which the dry contact
    carries too; oil that leaves both ends, and by how much the lost power warms it.
    """
    from rattle.plots.curves import SUFFIXES, save_figure

    if ideal:
        raise click.UsageError("an orbit is about play, and --ideal removes all of it; leave --ideal out")
    picture = output is not None and Path(output).suffix.lower() in SUFFIXES
    saved = None if picture else output
    check_results(file, saved, csv, fallback)
    check_pictures(file, output if picture else None)
    m = read_model(file, settings, False)
    name = joint if joint is not None else only_oiled(m)
    result = m.orbit(name, span_times(m, t_end, points))
    if as_json:
        click.echo(to_json(_record(result, name)))
    elif len(result.t):
        from rattle.results.film_summary import film_table

        click.echo(film_table(result))
        click.echo("\n".join([result.trust.word, *result.trust.notes]))
    if picture and output is not None and len(result.t):
        save_figure(result.plot_orbit(name), output)
        if not as_json:
            say_written(output)
    finish(ctx, result, keep(result, saved, csv, fallback))


def _record(result: Result, name: str) -> dict[str, Any]:
    """Whether the orbit was followed, what to trust of it, the films, and the range of every curve of the joint."""
    curves = {
        key: {"min": float(result[key].min()), "max": float(result[key].max()), "unit": result.unit(key)}
        for key in result.stored
        if key.startswith(f"{name}.") and len(result.t)
    }
    films = {key: film._asdict() for key, film in result.films.items()}
    facts = {"success": result.success, "message": result.message, "trust": result.trust.to_dict()}
    return {**facts, "films": films, "curves": curves}
