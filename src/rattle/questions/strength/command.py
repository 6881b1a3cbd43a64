"""The command `rattle strength`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rattle.cli.question_command import Asked, Shown, Written, json_option, model_command
from rattle.errors import InputError
from rattle.questions.strength.moved import by_suffix, motion_options, moved

if TYPE_CHECKING:
    from rattle.questions.strength.answer import Strength


@model_command
@click.option("--of", "name", metavar="NAME",
    help="The bar, or plate.neck; default: a row for every bar with section and material, and for every neck.",
)  # fmt: skip
@motion_options
@click.option(
    "-o", "--output", metavar="FILE",
    help="Picture (.svg, .png, .pdf): forces in what --of names, or of the mechanism; or table (.csv) in SI units.",
)  # fmt: skip
@json_option("The numbers, and its curves at the instant of the largest stress, as JSON in SI units.")
def strength(asked: Asked, name: str | None, analysis: str, t_end: float | None, points: int) -> Shown:
    """Whether bars and plates are strong enough: stress, safety, life, buckling, deflection.

    FILE is a model file or the name of a shipped example. A bar needs length, section and material:

    \b
    [bodies.rod]
    bar = ["A", "B"]
    length = "0.12 m"
    section = { shape = "rectangle", width = "10 mm", height = "20 mm" }
    material = "steel"

    \b
    A plate needs cuts through it, from edge to edge in the frame of its polygon:
    [bodies.rocker]
    necks = { root = [["50 mm", "-20 mm"], ["50 mm", "20 mm"]] }

    \b
    Examples: rattle strength piston_engine
              rattle strength piston_engine --of rod -o rod.svg
              rattle strength piston_engine --of rod --t-end "80 ms" -o rod.csv

    Safety needs the material's yield; life its ultimate, endurance and exponent, under [materials] in the model: they
    belong to a grade and a part, and never follow from the word "steel". A life is in runs of this motion, which
    repeats.
    """
    from rattle.questions.strength.compute import require_stressed, strengths, stressed_of
    from rattle.questions.strength.words import NEEDS, NOTHING

    asked = by_suffix(asked, "strength is")
    m = asked.model()
    if name is not None:
        name = require_stressed(m.model, name)
    elif not stressed_of(m.model):
        raise InputError(f"{NOTHING}; {NEEDS}")
    result = moved(asked, m, analysis, t_end, points)
    bars = list(strengths(result, None if name is None else (name,)).values())
    return Shown(
        lambda: _words(bars, name is not None), lambda: {s.name: _record(s) for s in bars},
        _files(asked, bars, name is not None),
        result=result,
    )  # fmt: skip


def _files(asked: Asked, bars: list[Strength], alone: bool) -> tuple[Written, ...]:
    """The picture or the table, if there is to be one."""
    from rattle.questions.strength.pictures import draw_stressed
    from rattle.questions.strength.words import worst_of

    if alone:
        return (*asked.tabled(lambda: bars[0].table), *asked.drawn(bars[0].plot))
    return (*asked.tabled(lambda: _table(bars)), *asked.drawn(lambda: draw_stressed(bars, worst_of(bars).peak_at[0])))


def _table(bars: list[Strength]) -> Any:
    """A pandas.DataFrame with a row for each."""
    from rattle.results.archive import package

    return package("pandas", "a table of strength").DataFrame([{"name": s.name, **s.numbers()} for s in bars])


def _words(bars: list[Strength], alone: bool) -> str:
    """One with all that is known, or a row for each."""
    from rattle.questions.strength.words import HEAD, in_rows, remarks_of
    from rattle.results.display import in_columns

    if alone:
        (s,) = bars
        lines = [f"{s.name}, {len(s.t)} instants", *in_columns(s.told()), *s.remarks]
        return "\n".join(lines)
    return "\n".join([*in_columns([HEAD, *in_rows(bars)]), *remarks_of(bars)])


def _record(s: Strength) -> dict[str, object]:
    """Numbers, and curves when the stress is largest."""
    import numpy as np

    row = int(np.argmin(np.abs(s.t - s.peak_at[0])))
    curves = {name: getattr(s, name)[row] for name in s.curves}
    return {"told": dict(s.told()), **s.numbers(), "x": s.x, **curves, "remarks": list(s.remarks)}
