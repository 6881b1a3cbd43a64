"""`Answer`: what a question answers, as blocks and numbers, and how it looks everywhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from rattle.answers.blocks import Block, Content
from rattle.errors import InputError, suggest

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Number(NamedTuple):
    """A number of an answer, by which ensembles, sweeps and JSON know it."""

    value: float  # [SI]
    unit: str = ""  # SI


@dataclass(frozen=True)
class Answer:
    """What a question answers.

    told: its result in one line.  blocks: see `rattle.answers.blocks`; None is left out.  numbers: by name, in SI.
    """

    told: str
    blocks: tuple[Block, ...] = ()
    numbers: Mapping[str, Number] = field(default_factory=dict)

    @classmethod
    def of(cls, told: str, *blocks: Block | None, numbers: Mapping[str, Number | float] | None = None) -> Answer:
        """An answer of these blocks; those that are None, as a table without rows is, are left out.

        numbers: by name; a float has no unit.
        """
        named = (numbers or {}).items()
        with_units = {name: number if isinstance(number, Number) else Number(number) for name, number in named}
        return cls(told, tuple(block for block in blocks if block is not None), with_units)

    def __getitem__(self, name: str) -> float:
        """A number of the answer [SI].  Raises InputError for a name that it has not."""
        if name not in self.numbers:
            raise InputError(f"the answer has no number {name!r}{suggest(name, self.numbers)}")
        return self.numbers[name].value

    def __str__(self) -> str:
        from rattle.answers.text import text_of

        return "\n".join([self.told, *filter(None, map(text_of, self.blocks))])

    def _repr_html_(self) -> str:
        from rattle.answers.html import html_of
        from rattle.results.display import card

        return card(self.told, *map(html_of, self.blocks))

    def plot(self) -> Figure:
        """Its curves and bars below each other.  Raises InputError for an answer that has none."""
        from rattle.answers.figures import figure_of

        return figure_of(self.blocks)

    def content(self) -> Content:
        """What a tab of the studio shows."""
        return {"told": self.told, "blocks": list(self.blocks)}

    def record(self) -> dict[str, object]:
        """What JSON holds: numbers in SI with their units, tables and curves."""
        numbers = {name: {"value": value, "unit": unit} for name, (value, unit) in self.numbers.items()}
        return {"told": self.told, "numbers": numbers, "blocks": _plain(self.blocks)}


def _plain(blocks: Iterable[Block]) -> list[Block]:
    """Blocks without their drawings, which no reader of JSON asks for."""
    return [block for block in blocks if block["kind"] != "svg"]
