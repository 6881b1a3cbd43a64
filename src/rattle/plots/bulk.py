"""The part of an axis in which most of some values lie: a few that are orders of magnitude away do not flatten it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from rattle.studies.runs.columns import scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

FENCE = 3.0  # interquartile ranges beyond the quartiles: the "outer fences" of Tukey, Exploratory Data Analysis (1977)
DECADES = 1.0  # between the 5 % and 95 % quantiles, from which on a logarithmic axis is thought of
NEAR = 2.0  # what is near a single value: this factor
TAIL = 0.005  # share of the values that may lie beyond an end where the quartiles are equal


class Bulk(NamedTuple):
    """Where most of the values lie, in the unit in which they are shown."""

    low: float
    high: float
    log: bool  # on a logarithmic axis
    factor: float  # from SI
    unit: str
    below: int  # values that lie beyond an end
    above: int
    least: float  # of all values
    most: float
    spread: float  # standard deviation of those inside

    @property
    def outside(self) -> str:
        """What is said of the values beyond the ends, "" if there are none."""
        beyond = [
            f"{count} {side} {short(end)}, {word} {short(last)}"
            for count, side, end, word, last in (
                (self.below, "below", self.low, "down to", self.least),
                (self.above, "above", self.high, "up to", self.most),
            )
            if count
        ]
        return f"{'; '.join(beyond)} {self.unit}".rstrip().replace("*", "·") if beyond else ""


def short(number: float, digits: int = 3) -> str:
    """A number as it is written in a picture."""
    return f"{float(f'{number:.{digits}g}'):g}".replace("-", "\N{MINUS SIGN}")


def bulk_of(values: np.ndarray, unit: str, also: Iterable[float] = ()) -> Bulk:
    """Bulk of finite values (n,) [SI], n >= 1, with further values [SI] that the axis shall show if they are near.

    The scale is logarithmic where positive values spread over more than a decade, and more evenly so than on a linear
    one.
    """
    log = _logarithmic(values)
    seen = np.log(values) if log else values
    low, high = _fences(seen)
    inside = values[(seen >= low) & (seen <= high)]
    least, most = float(values.min()), float(values.max())
    further = [least, most, *(value for value in also if math.isfinite(value))]
    low, high = _extended(float(inside.min()), float(inside.max()), further, log)
    below, above = int((values < low).sum()), int((values > high).sum())
    spread = float(inside.std())
    factor, shown = scale_of((low, high, spread), unit)
    return Bulk(
        factor * low, factor * high, log, factor, shown, below, above, factor * least, factor * most, factor * spread
    )


def _extended(low: float, high: float, further: list[float], log: bool) -> tuple[float, float]:
    """A range with those further values that make it twice as long at most, on its scale."""
    if log:
        far = high / low if high > low else NEAR
        near = [value for value in further if low / far <= value <= high * far]
    else:
        reach = high - low or NEAR * abs(high)
        near = [value for value in further if low - reach <= value <= high + reach]
    return min([low, *near]), max([high, *near])


def _logarithmic(values: np.ndarray) -> bool:
    low, middle, high = (float(quantile) for quantile in np.quantile(values, [0.05, 0.5, 0.95]))
    if not (values.min() > 0.0 and low > 0.0 and math.log10(high / low) > DECADES):
        return False
    skew = abs(low + high - 2.0 * middle) / (high - low)
    return abs(math.log(low) + math.log(high) - 2.0 * math.log(middle)) / math.log(high / low) < skew


def _fences(values: np.ndarray) -> tuple[float, float]:
    first, third = np.quantile(values, [0.25, 0.75])
    if third > first:
        return float(first - FENCE * (third - first)), float(third + FENCE * (third - first))
    low, high = np.quantile(values, [TAIL, 1.0 - TAIL], method="inverted_cdf")
    return float(low), float(high)


def set_range(ax: Axes, bulk: Bulk, axis: Literal["x", "y"], margin: float = 0.04) -> None:
    """Give an axis the scale and range of a bulk."""
    set_scale, set_limits = (ax.set_xscale, ax.set_xlim) if axis == "x" else (ax.set_yscale, ax.set_ylim)
    scale = "log" if bulk.log else "linear"
    if scale != (ax.get_xscale() if axis == "x" else ax.get_yscale()):
        set_scale(scale)
    if bulk.log:
        if bulk.high / bulk.low < 100.0:
            _plain_numbers(ax.xaxis if axis == "x" else ax.yaxis)
        room = (bulk.high / bulk.low) ** margin if bulk.high > bulk.low else 1.1
        set_limits(bulk.low / room, bulk.high * room)
        return
    room = margin * (bulk.high - bulk.low) or 0.05 * abs(bulk.high) or 0.5
    set_limits(bulk.low - room, bulk.high + room)
    ax.ticklabel_format(axis=axis, useOffset=False)


def _plain_numbers(axis: Axis) -> None:
    """Write 200, 500, 1000 at a logarithmic axis."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: short(value)))
    axis.set_minor_formatter(NullFormatter())
