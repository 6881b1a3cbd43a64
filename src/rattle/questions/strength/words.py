"""What is told of several bars: a row for each, and remarks."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.questions.strength.compute import Strength

HEAD = ("bar", "largest stress", "safety against yield", "life", "least buckling factor")
NEEDS = 'a bar needs length, section = { shape = "round", diameter = "10 mm" } and material = "steel" in the model'


def in_rows(bars: Sequence[Strength]) -> list[tuple[str, ...]]:
    """A row for each bar, below `HEAD`."""
    rows = {s.body: dict(s.told()) for s in bars}
    return [(name, *(row[column] for column in HEAD[1:])) for name, row in rows.items()]


def remarks_of(bars: Sequence[Strength]) -> list[str]:
    """Remarks, each once, with the names of its bars where not all share it."""
    mine: dict[str, list[str]] = {}
    for s in bars:
        for remark in s.remarks:
            mine.setdefault(remark, []).append(s.body)
    return [remark if len(names) == len(bars) else f"{', '.join(names)}: {remark}" for remark, names in mine.items()]


def worst_of(bars: Sequence[Strength]) -> Strength:
    """The bar with the largest stress."""
    return max(bars, key=lambda s: -math.inf if math.isnan(s.peak) else s.peak)
