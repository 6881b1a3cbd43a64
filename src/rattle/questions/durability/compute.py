"""How long joints and links last, as an answer.

Source: docs/heat-and-life.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from rattle.analyses import arguments
from rattle.answers.answer import Answer, Number
from rattle.answers.blocks import Block, Content, drawing, table, words
from rattle.errors import ModelError, Problem
from rattle.mechanism import Mechanism
from rattle.questions.durability.bands import FATIGUE, SLOPE, WEAR, Bands, bands, failed
from rattle.questions.durability.cases import Duty, with_duty
from rattle.questions.durability.larger import advice
from rattle.questions.durability.rows import HOUR, TIRED, WORN, Row, rows_of
from rattle.results.archive import package
from rattle.results.display import quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

HEAD = ("", "load", "pressure", "shear of pin", "PV", "film", "wear life", "fatigue life", "safety")
COLUMNS = ("load", "pressure", "shear of pin", "pv", "film", "wear life", "fatigue life", "safety")
UNITS = ("N", "Pa", "Pa", "Pa*m/s", "", "s", "s", "")
NOTHING = "nothing"


class First(NamedTuple):
    """What fails first, by what, after how many hours: "nothing" and inf if nothing does, nan if no life is known."""

    name: str
    what: str
    hours: float


@dataclass(frozen=True, repr=False, kw_only=True)
class Durability(Answer):
    """How long joints and links last.

    rows: of joints, then of links.  first: what fails first.  bands: hours by which 10, 50 and 90 % have failed by it.
    hours: that it needs to last.  remarks: what is assumed, and what is nan and why.
    """

    rows: tuple[Row, ...]
    first: First
    bands: Bands
    hours: float | None
    remarks: tuple[str, ...]
    mechanism: Mechanism

    def __repr__(self) -> str:
        return f"<rattle.Durability: {self.told}>"

    def __str__(self) -> str:
        return "\n".join(filter(None, (super().__str__(), self.advice)))

    @cached_property
    def table(self) -> DataFrame:
        """pandas.DataFrame by names of joints and links: load [N], pressure and shear of the pin [Pa], pv [Pa m/s],
        film (least thickness over roughness), wear life and fatigue life [h], safety; nan where not known.

        Raises MissingPackage.
        """
        columns = {column: [row.figures[k] for row in self.rows] for k, column in enumerate(COLUMNS)}
        frame: DataFrame = package("pandas", "a table of lives").DataFrame(columns, [row.name for row in self.rows])
        return frame.rename_axis("name")

    @cached_property
    def advice(self) -> str:
        """What the first to fail would last with a larger size, computed anew; "" where no size is known."""
        if not 0.0 < self.first.hours < math.inf:
            return ""
        return advice(self.mechanism, *self.first)

    def plot(self) -> Figure:
        """Lives as bars with their bands, hours on a logarithmic axis.  Raises InputError if nothing fails."""
        from rattle.questions.durability.pictures import plot_lives

        return plot_lives(self)

    def content(self) -> Content:
        """What a tab of the studio shows."""
        return {"told": self.told, "blocks": list(self.shown)}

    @property
    def shown(self) -> tuple[Block, ...]:
        """The blocks, advice and picture."""
        from rattle.questions.durability.pictures import has_lives

        advice = words(self.advice)
        return (*self.blocks, *((advice,) if advice else ()), *((drawing(self.plot()),) if has_lives(self) else ()))

    def _repr_html_(self) -> str:
        from rattle.answers.html import html_of
        from rattle.results.display import card

        return card(self.told, *map(html_of, self.shown), hint="d.table, d.plot()")

    def record(self) -> dict[str, object]:
        """What JSON holds: SI, lives in hours, what fails first and its band."""
        rows = [{"name": row.name, **dict(zip(COLUMNS, row.figures, strict=True))} for row in self.rows]
        facts = {"rows": rows, "first": self.first._asdict(), "bands": self.bands._asdict(), "hours": self.hours}
        return {**super().record(), **facts, "advice": self.advice, "remarks": list(self.remarks)}


def durability(m: Mechanism, duty: Duty, hours: float | None) -> Durability:
    """How long everything lasts; see `Mechanism.durability`."""
    hours = None if hours is None else arguments.positive("hours", hours)
    m = with_duty(m, duty)
    if not m.model.joints and not m.model.bodies:
        raise ModelError([Problem((), "there is no joint and no link that could fail")])
    rows, notes = rows_of(m)
    first, factors = _first(rows)
    middle = bands(first.hours, factors)
    remarks = (*notes, *_remarks(rows))
    blocks = (
        table(HEAD, [_shown(row) for row in rows], "Over all duty cases"),
        words(_told_bands(first, middle)), words("\n".join(remarks)),
    )  # fmt: skip
    return Durability(
        _told(first, factors, hours), tuple(block for block in blocks if block is not None),
        _numbers(rows, first, middle), rows=rows, first=first, bands=middle, hours=hours, remarks=remarks, mechanism=m,
    )  # fmt: skip


def _first(rows: Sequence[Row]) -> tuple[First, tuple[float, float]]:
    """What fails first, and the factors of its band."""
    lives = [(hours, row.name, what, factors) for row in rows for what, hours, factors in row.lives]
    hours, name, what, factors = min(lives, key=lambda life: life[0], default=(math.nan, "", "", WEAR))
    if not math.isfinite(hours):
        return First(NOTHING, NOTHING if lives else "no life is known", hours), factors
    return First(name, what, hours), factors


def _told(first: First, factors: tuple[float, float], hours: float | None) -> str:
    """The answer in one line."""
    if math.isnan(first.hours):
        return "no life is known: no joint says how it wears, and no bar what it endures"
    if math.isinf(first.hours):
        return "nothing fails of what is known"
    if first.hours == 0.0:
        return f"{first.name} fails at once, by {first.what}: it bears less than a single cycle"
    told = f"{first.name} fails first, by {first.what} after {_hours(first.hours)}"
    if hours is None:
        return told
    chance = f"{100 * failed(hours, first.hours, factors):.2g} % have failed by then"
    verdict = "lasts" if first.hours >= hours else "DOES NOT LAST"
    return f"{told}; {verdict} {_hours(hours)}, {chance}"


def _told_bands(first: First, middle: Bands) -> str:
    if not 0.0 < first.hours < math.inf:
        return ""
    spans = ", ".join(f"{share} % by {_hours(hours)}" for share, hours in zip((10, 50, 90), middle, strict=True))
    return f"of {first.name} have failed {spans}"


def _shown(row: Row) -> tuple[str, ...]:
    """A row of the table for people."""
    sizes = (
        quantity(row.load, "N", 5), quantity(row.pressure, "Pa", usual="MPa"),
        quantity(row.shear, "Pa", usual="MPa"), f"{1e-6 * row.pv:.4g} MPa*m/s",
        f"{row.film:.3g}", _hours(row.wear_life), _hours(row.fatigue_life), f"{row.safety:.3g}",
    )  # fmt: skip
    return (row.name, *("-" if math.isnan(value) else size for value, size in zip(row.figures, sizes, strict=True)))


def _hours(hours: float) -> str:
    return "no end" if math.isinf(hours) else f"{hours:.4g} h"


def _remarks(rows: Sequence[Row]) -> tuple[str, ...]:
    """What is assumed of bands; then what is nan and why, and how lives were found, by what is the same of many."""
    remarks = []
    ends = [(row, what) for row in rows for what, hours, _ in row.lives if 0.0 < hours < math.inf]
    lives = {what: [row for row, named in ends if named == what] for what in (WORN, TIRED)}
    if any(row.assumed for row in lives[WORN]):
        remarks.append(
            f"assumed, not measured: 10 and 90 % of wear lives at {WEAR[0]:.2g} and {WEAR[1]:g} times the life"
        )
    if any(row.fatigue_band == FATIGUE for row in lives[TIRED]):
        remarks.append(
            f"assumed, not measured: 10 and 90 % of fatigue lives at {FATIGUE[0]:g} and {FATIGUE[1]:g} times the life"
        )
    if any(row.fatigue_band != FATIGUE for row in lives[TIRED]):
        remarks.append(f"assumed: lives of rolling bearings scatter with Weibull's slope {SLOPE:g} beyond L10 too")
    named: dict[str, list[str]] = {}
    for row in rows:
        for note in row.notes:
            named.setdefault(note, []).append(row.name)
    return (*remarks, *(f"{', '.join(names)}: {note}" for note, names in named.items()))


def _numbers(rows: Sequence[Row], first: First, middle: Bands) -> dict[str, Number]:
    """What ensembles and JSON know, lives in s."""
    numbers = {"life": Number(first.hours * HOUR, "s")}
    numbers |= {f"life_{share}": Number(hours * HOUR, "s") for share, hours in zip((10, 90), middle[::2], strict=True)}
    for row in rows:
        for column, unit, value in zip(COLUMNS, UNITS, row.figures, strict=True):
            if not math.isnan(value):
                size = HOUR if unit == "s" else 1.0
                numbers[f"{row.name}.{column.replace(' ', '_')}"] = Number(size * value, unit)
    return numbers
