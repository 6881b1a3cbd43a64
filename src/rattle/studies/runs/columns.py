"""Numbers of samples as texts: one unit for what stands side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.results.chosen_units import chosen, shown_in
from rattle.results.display import readable
from rattle.results.handy_units import SMALL

LONGEST = 10.0  # a length up to which mm are used beside short ones [m]
FEWEST, MOST = 5, 10  # digits


def scale_of(values: Sequence[float], unit: str) -> tuple[float, str]:
    """Factor from SI, and the unit in which these values [SI] are shown: as asked for, or deg, mm."""
    sizes = [abs(x) for x in values if math.isfinite(x) and x]
    if asked := chosen(unit):
        return asked
    if unit == "m" and sizes and min(sizes) < SMALL and max(sizes) < LONGEST:
        return shown_in("mm")
    return readable(1.0, unit)


def in_one_unit(values: Sequence[float], unit: str) -> list[str]:
    """Values [SI] as texts, then their common unit."""
    factor, shown = scale_of(values, unit)
    return [*(number(factor * x) for x in values), shown]


def number(value: float, spread: float = math.nan) -> str:
    """A number as text, with so many digits that a spread of its unit shows; "-" for what is not finite."""
    if not math.isfinite(value):
        return "-"
    finer = math.log10(abs(value) / spread) if 0.0 < spread < abs(value) else 0.0
    return f"{value:.{min(max(FEWEST, math.ceil(finer) + 2), MOST)}g}"
