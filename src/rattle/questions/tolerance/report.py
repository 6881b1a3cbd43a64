"""What the tolerances of parts do to an output: worst case, root sum square and samples side by side.

    worst case       least and greatest output at the corners of the fields (see `corners`)
    root sum square  F0 -+ sqrt(sum E_i^2),  E_i the first-order effects of independent contributors (`contributors`)
    Monte Carlo      the band that holds 99.73 % of samples, as +-3 sd would of a normal distribution

F0 is the output without deviations.  Root sum square holds the same share as Monte Carlo only if the output is linear
and the fields are normal with tol = 3 sd; with uniform fields, parts are spread more widely.

Source: Chase, Parkinson, A survey of research in the application of tolerance analysis to the design of mechanical
assemblies, Research in Engineering Design 3 (1991) 23-37; Sobol indices: see `sobol`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.questions.ensemble import statistics
from rattle.questions.ensemble.contributors import added, half_width, half_widths, labels, members
from rattle.questions.ensemble.fields import Fields
from rattle.questions.ensemble.runs import Samples
from rattle.questions.ensemble.statistics import Bounded
from rattle.questions.tolerance.allocation import Allocation, Linear, allocate
from rattle.questions.tolerance.required_accuracy import Limits, Within, limits_about
from rattle.questions.tolerance.sobol import Indices
from rattle.questions.tolerance.trials import Trials
from rattle.results.archive import package
from rattle.results.display import in_columns, table
from rattle.studies.runs.columns import number, scale_of
from rattle.value_types import Json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BAND = math.erf(3.0 / math.sqrt(2.0))  # share within three standard deviations of a normal distribution
TAIL = 0.5 * (1.0 - BAND)
HEADER = ("parameter", "nominal", "tolerance", "slope", "effect", "share", "first", "total (95 %)")
BANDS = ("", "low", "high", "below nominal", "above nominal")

Band = tuple[float, float]


@dataclass(frozen=True, eq=False, repr=False)
class Tolerance:
    """An output whose parameters have tolerances; d contributors, each a parameter or a group.  All in SI units."""

    of: str
    unit: str
    nominal: float  # the output without deviations
    fields: Fields
    slopes: Mapping[str, float]  # dF/dp by parameter, nan where there is none
    how: str  # how the slopes were found
    worst_case: Band  # at the corners; nan where a corner cannot be run
    indices: Indices = field(repr=False)
    drawn: np.ndarray = field(repr=False)  # (m,) outputs of independent samples, nan where there is none
    samples: Samples = field(repr=False)  # all that were run together
    trials: Trials = field(repr=False)
    seed: int
    notes: tuple[str, ...] = ()

    @property
    def contributors(self) -> tuple[str, ...]:
        """(d,) parameters, or the names of a group: "l2, l3"."""
        return labels(self.fields)

    @cached_property
    def effects(self) -> np.ndarray:
        """(d,) first-order effects: the change of the output when a contributor goes to the upper end of its field."""
        return added(self.fields, np.array(list(self.slopes.values())) * half_widths(self.fields))

    @property
    def root_sum_square(self) -> Band:
        """Nominal -+ sqrt(sum of squared effects)."""
        half = math.sqrt(float(self.effects @ self.effects))
        return self.nominal - half, self.nominal + half

    @cached_property
    def known(self) -> np.ndarray:
        """Outputs of the independent samples that have one."""
        return np.asarray(self.drawn[np.isfinite(self.drawn)])

    @property
    def enough(self) -> bool:
        """True if there are samples enough for the band of 99.73 %: one beyond each end, at least."""
        return bool(len(self.known) * TAIL >= 1.0)

    @property
    def monte_carlo(self) -> Band:
        """The band that holds 99.73 % of the samples; of all samples where these are too few to tell (`enough`)."""
        if not len(self.known):
            return math.nan, math.nan
        low, high = np.quantile(self.known, [TAIL, 1.0 - TAIL] if self.enough else [0.0, 1.0])
        return float(low), float(high)

    @property
    def mean(self) -> float:
        """Mean of the samples."""
        return statistics.mean(self.known).value

    @property
    def sd(self) -> float:
        """Standard deviation of the samples."""
        return statistics.sd(self.known).value

    @property
    def sobol(self) -> Any:
        """A pandas DataFrame of Sobol indices: first, total, and their 95 % bounds first_low ... total_high.

        One row per contributor; a group of parameters is one, named "l2, l3".
        """
        pandas = package("pandas", "a table of Sobol indices")
        columns = [name for name in Indices._fields if name != "rows"]
        index = pandas.Index(self.contributors, name="parameter")
        return pandas.DataFrame({name: getattr(self.indices, name) for name in columns}, index=index)

    @property
    def tighten(self) -> tuple[str, ...]:
        """Contributors by their total index, the greatest first; by their effects where there are no indices."""
        return tuple(self.contributors[n] for n in self.order)

    @property
    def order(self) -> list[int]:
        """Places of the contributors in the order of `tighten`."""
        size = self.indices.total if self.indices.rows else np.nan_to_num(np.abs(self.effects))
        return [int(n) for n in np.argsort(-size, kind="stable")]

    def yield_within(self, within: Within) -> Bounded:
        """Share of the mechanisms within a deviation from the nominal output, or between two limits (low, high).

        Numbers in SI or texts such as "0.1 deg".  Returns (share, low, high), bounds with 95 % confidence; samples
        without a value count as beyond the limits, for the upper bound as within.
        """
        inside = int((self.limits(within).excess(self.known) <= 0.0).sum())
        return statistics.share(inside, len(self.known), len(self.drawn) - len(self.known))

    def limits(self, within: Within) -> Limits:
        """Limits about the nominal output, or those given.  Raises ValueError."""
        return limits_about(within, self.nominal, self.unit)

    def allocate(
        self, within: Within, method: str = "rss", cost: Mapping[str, float] | None = None, *, exponent: float = 1.0,
        share: float = BAND,
    ) -> Allocation:  # fmt: skip
        """The loosest tolerances, or the cheapest, that keep the output within limits.

        within: a deviation from the nominal output such as "0.1 deg", [SI] without a unit, or limits (low, high).
        method: "rss": this share of the mechanisms keeps the limits; "worst-case": all corners do.
        cost: what tolerances cost, sum c/tol**exponent [tol in SI], with c by parameter; None: equal contributions,
        which is the largest product of tolerances.

        The tolerances follow from the slopes and are then scaled, all by one factor, until samples of the mechanism
        itself keep the limits.  No field goes beyond the limits of its parameter in the model; tables of values stay.
        Returns `a.tolerances` by name [SI], `a.vary` to use in `ensemble` and `tolerance`, `a.report`.
        Raises ValueError.
        """
        missing = [name for name, slope in self.slopes.items() if not math.isfinite(slope)]
        linear = Linear(
            self.of, self.unit, self.nominal, self.fields, self.effects, f"none by {', '.join(missing)}", self.trials,
            len(self.drawn), self.seed,
        )  # fmt: skip
        return allocate(linear, self.limits(within), method, cost, exponent, share)

    def plot(self) -> Figure:
        """The samples with the three bands, and the contributions with their bounds."""
        from rattle.questions.tolerance.pictures import plot_tolerance

        return plot_tolerance(self)

    def record(self) -> dict[str, Json]:
        """What was found as plain data, in SI units."""
        names = [name for name in Indices._fields if name != "rows"]
        indices = {name: getattr(self.indices, name) for name in names}
        return {
            "of": self.of, "unit": self.unit, "nominal": self.nominal, "worst_case": self.worst_case,
            "root_sum_square": self.root_sum_square, "monte_carlo": self.monte_carlo, "mean": self.mean, "sd": self.sd,
            "samples": len(self.known), "slopes": dict(self.slopes), "how": self.how, "tighten": list(self.tighten),
            "sobol": {
                contributor: {name: float(x[n]) for name, x in indices.items()}
                for n, contributor in enumerate(self.contributors)
            },
            "notes": [*self.samples.remarks(), *self.notes],
        }  # fmt: skip

    def __repr__(self) -> str:
        name, low, high, *_ = _bands(self)[0]
        return f"<rattle.Tolerance: {self.of[:60]}, {name} {low} to {high}>"

    def __str__(self) -> str:
        return "\n".join(_lines(self))

    def _repr_html_(self) -> str:
        return _html(self)


# ---------------------------------------------------------------- words
def _scale(t: Tolerance) -> tuple[float, str]:
    """Factor from SI, and the unit in which the output is shown."""
    return scale_of([t.nominal, _spread(t)], t.unit)


def _spread(t: Tolerance) -> float:
    """Half the width of a band [SI], whose digits have to show."""
    halves = (0.5 * (high - low) for low, high in (t.root_sum_square, t.monte_carlo))
    return max((half for half in halves if math.isfinite(half)), default=0.0)


def _rows(t: Tolerance) -> list[tuple[str, ...]]:
    """Contributors in the order of `tighten`, see HEADER; share: of the sum of squared effects."""
    factor, unit = _scale(t)
    whole = float(t.effects @ t.effects)
    slopes, rows = list(t.slopes.values()), []
    for n in t.order:
        cells: list[list[str]] = [[], [], []]
        for k in members(t.fields)[n]:
            field = t.fields.fields[k]
            scale, shown = scale_of([half_width(field)], field.unit)
            per = _per(unit, shown)
            cells[0].append(f"{number(scale * field.nominal, scale * half_width(field))} {shown}".rstrip())
            cells[1].append(f"+-{number(scale * half_width(field))} {shown}".rstrip() + _shape(field.dist))
            cells[2].append(f"{number(slopes[k] * factor / scale)} {per}".rstrip())
        effect = float(t.effects[n])
        share = f"{100.0 * effect**2 / whole:.3g} %" if whole > 0.0 else "-"
        first, total = float(t.indices.first[n]), float(t.indices.total[n])
        low, high = float(t.indices.total_low[n]), float(t.indices.total_high[n])
        bounded = f"{total:.3f} ({low:.3f} to {high:.3f})" if math.isfinite(total) else "-"
        rows.append((
            t.contributors[n], *(", ".join(cell) for cell in cells),
            f"+-{number(factor * abs(effect))} {unit}".rstrip(), share,
            f"{first:.3f}" if math.isfinite(first) else "-", bounded,
        ))  # fmt: skip
    return rows


def _per(unit: str, by: str) -> str:
    """The unit of a slope."""
    return f"{unit or '1'}/{f'({by})' if set(by) & set('/*^') else by}" if by else unit


def _shape(dist: str) -> str:
    return "" if dist == "uniform" else f" {dist}"


def _bands(t: Tolerance) -> list[tuple[str, ...]]:
    """The three bands, see BANDS."""
    factor, unit = _scale(t)
    sampled = "Monte Carlo, 99.73 %" if t.enough else f"Monte Carlo, all {len(t.known)}"
    rows = []
    for name, (low, high) in (
        ("worst case", t.worst_case), ("root sum square", t.root_sum_square), (sampled, t.monte_carlo),
    ):  # fmt: skip
        ends = (f"{number(factor * x, factor * _spread(t))} {unit}".rstrip() for x in (low, high))
        off = (f"{factor * (x - t.nominal):+.4g} {unit}".rstrip() if math.isfinite(x) else "-" for x in (low, high))
        rows.append((name, *ends, *off))
    return rows


def _below(t: Tolerance) -> list[str]:
    """What stands below the tables."""
    factor, unit = _scale(t)
    lines = []
    if len(t.known) > 1:
        mean, sd = number(factor * t.mean, factor * t.sd), number(factor * t.sd)
        units = f" {unit}".rstrip()
        lines.append(f"samples: mean {mean}{units}, standard deviation {sd}{units}, {len(t.known)} of them")
    return [*lines, _advice(t), f"slopes: {t.how}", *t.samples.remarks(), *t.notes]


def _advice(t: Tolerance) -> str:
    """What to tighten first, and what that brings."""
    factor, unit = _scale(t)
    n = t.order[0]
    squares = t.effects**2
    now = math.sqrt(float(squares.sum()))
    if now == 0.0 and t.sd == 0.0:
        return "nothing to tighten: no deviation has an effect"
    words = f"tighten {t.contributors[n]} first"
    if not now > 0.0:
        return words
    then = math.sqrt(float(squares.sum() - 0.75 * squares[n]))
    what = "half its tolerance makes" if len(members(t.fields)[n]) == 1 else "half their tolerances make"
    ends = (f"+-{number(factor * x)} {unit}".rstrip() for x in (then, now))
    return "{}: {} the root sum square {} instead of {}".format(words, what, *ends)


def _title(t: Tolerance) -> str:
    """The output with its nominal value."""
    factor, unit = _scale(t)
    return (
        f"{t.of} = {number(factor * t.nominal, factor * _spread(t))} {unit}".rstrip()
        + f" without deviations ({t.trials.task.analysis})"
    )


def _lines(t: Tolerance) -> Sequence[str]:
    """The report as it is printed."""
    return [_title(t), *in_columns([HEADER, *_rows(t)]), "", *in_columns([BANDS, *_bands(t)]), "", *_below(t)]


def _html(t: Tolerance) -> str:
    """The report in a notebook."""
    return table(HEADER, _rows(t), _title(t)) + table(BANDS, _bands(t), "", _below(t))
