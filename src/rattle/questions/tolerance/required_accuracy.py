"""Required accuracy: limits between which an output has to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rattle.errors import InputError
from rattle.studies.runs.columns import in_one_unit, number, scale_of
from rattle.studies.runs.limits import limit_of

Within = float | str | Sequence[float | str]


@dataclass(frozen=True)
class Limits:
    """An output has to be from `low` to `high` [SI]."""

    low: float
    high: float
    text: str  # "within 0.1 deg of 62.1 deg"

    @property
    def half(self) -> float:
        """Half the distance of the limits [SI]."""
        return 0.5 * (self.high - self.low)

    def excess(self, outputs: np.ndarray) -> np.ndarray:
        """How far outputs [SI] are beyond the limits, in halves of their distance: -1 in the middle, 0 at a limit.

        inf for an output that has no value.
        """
        over = np.maximum(outputs - self.high, self.low - outputs) / self.half
        return np.where(np.isfinite(outputs), over, np.inf)


def limits_about(within: Within, nominal: float, unit: str) -> Limits:
    """Limits from a deviation from a nominal value [SI] such as "0.1 deg", or from two values (low, high).

    Raises InputError, TypeError.
    """
    if isinstance(within, str) or not isinstance(within, Sequence | np.ndarray):
        half = limit_of(within, unit, "within")
        if not half > 0.0:
            raise InputError(f"within: the deviation that is allowed must be positive, got {within!s:.60}")
        return about(nominal, half, unit)
    if len(within) != 2:
        raise InputError(
            f'within: expected a deviation such as "0.1 deg" or two limits (low, high), got {within!r:.60}'
        )
    low, high = (limit_of(limit, unit, "within") for limit in within)
    if not low < high:
        raise InputError(f"within: the lower limit comes first and is less than the upper one, got {within!r:.60}")
    least, most, shown = in_one_unit((low, high), unit)
    return Limits(low, high, f"from {least} to {most} {shown}".rstrip())


def about(nominal: float, half: float, unit: str) -> Limits:
    """Limits at this distance [SI] from a nominal value."""
    factor, shown = scale_of((half, nominal), unit)
    far, here = number(factor * half), number(factor * nominal, factor * half)
    text = f"within {far} {shown}".rstrip() + f" of {here} {shown}".rstrip()
    return Limits(nominal - half, nominal + half, text)
