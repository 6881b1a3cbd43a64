"""Numbers of samples as texts: one unit for what stands side by side, columns of equal width."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.results.display import MILLIMETRES, readable


def scale_of(values: Sequence[float], unit: str) -> tuple[float, str]:
    """Factor from SI, and the unit in which these values [SI] are shown: angles in deg, short lengths in mm."""
    sizes = [abs(x) for x in values if math.isfinite(x)]
    if unit == "m" and 0.0 < max(sizes, default=0.0) < MILLIMETRES:
        return 1e3, "mm"
    return readable(1.0, unit)


def in_one_unit(values: Sequence[float], unit: str, digits: int = 5) -> list[str]:
    """Values [SI] as texts, then their common unit."""
    factor, shown = scale_of(values, unit)
    return [*(f"{factor * x:.{digits}g}" if math.isfinite(x) else "-" for x in values), shown]


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows as lines with columns of equal width."""
    widths = [max(len(row[n]) for row in rows) for n in range(len(rows[0]))]
    return ["  ".join(f"{text:{width}}" for text, width in zip(row, widths, strict=True)).rstrip() for row in rows]
