"""The command `rattle orbit`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rattle.cli.instants import span_options, span_times
from rattle.cli.options import only_oiled
from rattle.cli.output import fallback_option
from rattle.cli.question_command import Asked, Shown, json_option, model_command

if TYPE_CHECKING:
    from rattle.results.result import Result


@model_command
@click.option("--joint", metavar="JOINT", help="Whose pin is followed; default: the only joint with oil.")
@span_options(1001)
@click.option(
    "-o", "--output", metavar="FILE",
    help="Picture of the orbit to write (.svg, .png, .pdf), or the result (.nc, .npz) for plot, animate and export.",
)  # fmt: skip
@click.option("--csv", metavar="FILE", help="Also write all curves as CSV.")
@fallback_option
@json_option("The summary of the film, ranges of its curves and trust as JSON.")
def orbit(asked: Asked, joint: str | None, t_end: float | None, points: int) -> Shown:
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
    from rattle.results.film_summary import film_table

    if asked.ideal:
        raise click.UsageError("an orbit is about play, and --ideal removes all of it; leave --ideal out")
    asked = asked.by_suffix(tables=False)
    m = asked.model()
    name = joint if joint is not None else only_oiled(m)
    result = m.orbit(name, span_times(m, t_end, points))
    return asked.shown(
        result, lambda: "\n".join([film_table(result), result.trust.word, *result.trust.notes]),
        lambda: _record(result, name), asked.drawn(lambda: result.plot_orbit(name)),
    )  # fmt: skip


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
