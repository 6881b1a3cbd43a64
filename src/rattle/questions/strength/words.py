"""What is told of several bars and necks: a row for each, and remarks."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.questions.strength.answer import BUCKLING, Strength

HEAD = ("bar or neck", "largest stress", "safety against yield", "life", BUCKLING)
NOTHING = "no bar has a section and a material, and no plate has necks"
NEEDS = (
    'a bar needs length, section = { shape = "round", diameter = "10 mm" } and material = "steel" in the model;'
    " a plate needs necks, cuts from edge to edge: necks = { root = [[x, y], [x, y]] }"
)


def in_rows(bars: Sequence[Strength]) -> list[tuple[str, ...]]:
    """A row for each, below `HEAD`."""
    rows = {s.name: dict(s.told()) for s in bars}
    return [(name, *(row.get(column, "") for column in HEAD[1:])) for name, row in rows.items()]


def remarks_of(bars: Sequence[Strength]) -> list[str]:
    """Remarks, each once, with names where not all share it."""
    mine: dict[str, list[str]] = {}
    for s in bars:
        for remark in s.remarks:
            mine.setdefault(remark, []).append(s.name)
    return [remark if len(names) == len(bars) else f"{', '.join(names)}: {remark}" for remark, names in mine.items()]


def worst_of(bars: Sequence[Strength]) -> Strength:
    """The one with the largest stress."""
    return max(bars, key=lambda s: -math.inf if math.isnan(s.peak) else s.peak)
