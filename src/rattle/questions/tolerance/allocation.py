"""Allocation: which tolerances keep a required accuracy, as loose or as cheap as they may be.

For an output that is linear with slopes s_i the tolerances T_i that keep |F - F0| <= T and cost least are

    cost sum c_i/T_i^p,   limit sum (|s_i| T_i)^q <= T^q,   q = 1 worst case, q = 2 root sum square

    T_i = a (c_i/|s_i|^q)^(1/(p + q)),   a so that the limit is met                                          (Lagrange)

Without costs the product of all T_i is to be greatest: p = 0 with equal c_i, where contributions |s_i| T_i are equal.
A tolerance that would go beyond the limits of its parameter stays there, and the others share what it leaves.

All are then scaled by one factor until samples of the mechanism itself keep the limits (see `edge`): corners and
samples in the worst case, the share that is wanted otherwise.

Source: Spotts, Allocation of tolerances to minimize cost of assembly, J. Eng. for Industry 95 (1973) 762-764;
Chase, Greenwood, Loosli, Hauglund, Least cost tolerance allocation for mechanical assemblies with automated process
selection, Manufacturing Review 3 (1990) 49-59.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rattle.analyses import arguments
from rattle.errors import InputError, WrongType, suggest
from rattle.questions.ensemble.contributors import added, at_ends, labels, members
from rattle.questions.ensemble.fields import TABLE, Fields
from rattle.questions.ensemble.sampling import points
from rattle.questions.tolerance import corners
from rattle.questions.tolerance.bracket import NotReachedError, edge
from rattle.questions.tolerance.largest import ROUND, SIDE_BY_SIDE
from rattle.questions.tolerance.required_accuracy import Limits
from rattle.questions.tolerance.trials import Trials
from rattle.results.display import in_columns, table
from rattle.studies.runs.columns import in_one_unit, number, scale_of
from rattle.value_types import Tree

ORDERS = {"worst-case": 1, "rss": 2}  # q by method
SMALLEST, GREATEST = 1e-4, 1e3  # factors by which the tolerances may be scaled
SLACK = 1e-6  # by which an output may be beyond its limits, as a share of their distance: errors of runs
HEADER = ("parameter", "now", "allocated", "by slopes alone")


@dataclass(frozen=True, eq=False)
class Linear:
    """An output, its parameters that vary, and what is known of it to first order; d contributors."""

    of: str
    unit: str
    nominal: float  # the output without deviations [SI]
    fields: Fields
    effects: np.ndarray  # (d,) first-order effects of the present fields [SI], nan where there is none
    why: str  # why there is none
    trials: Trials
    samples: int  # to look at where samples run one by one
    seed: int


@dataclass(frozen=True, eq=False, repr=False)
class Allocation:
    """Tolerances that keep an output within limits; `vary` is what `ensemble` and `tolerance` take."""

    of: str
    unit: str
    limits: Limits
    method: str
    tolerances: Mapping[str, float]  # by parameter [SI]
    by_slopes: Mapping[str, float]  # the closed form, before samples were looked at [SI]
    before: Mapping[str, float]  # those that the mechanism had [SI]
    vary: Mapping[str, Tree]  # all fields as entries of the model file
    cost: float  # sum c/tol**exponent [tol in SI]; nan without costs
    cost_by_slopes: float
    share: float  # of the samples that are within the limits
    band: tuple[float, float]  # least and greatest output of the samples [SI]
    units: Mapping[str, str]
    notes: tuple[str, ...] = ()

    @property
    def report(self) -> str:
        """The tolerances, what they cost, and what the samples say."""
        return "\n".join([self._title(), *in_columns([HEADER, *self._rows()]), *self._said()])

    def _title(self) -> str:
        what = "loosest" if math.isnan(self.cost) else "cheapest"
        how = "in the worst case" if self.method == "worst-case" else "by root sum square"
        return f"{what} tolerances that keep {self.of} {self.limits.text}, {how}"

    def _rows(self) -> list[tuple[str, ...]]:
        rows = []
        for name, value in self.tolerances.items():
            *texts, unit = in_one_unit((self.before[name], value, self.by_slopes[name]), self.units[name])
            rows.append((name, *(f"+-{text} {unit}".rstrip() for text in texts)))
        return rows

    def _said(self) -> list[str]:
        lines = []
        if not math.isnan(self.cost):
            lines.append(f"cost {self.cost:.6g} (by slopes alone {self.cost_by_slopes:.6g})")
        factor, unit = scale_of((self.limits.half, *self.band), self.unit)
        low, high = (number(factor * x, factor * self.limits.half) for x in self.band)
        lines.append(f"sampled: {100.0 * self.share:.5g} % within, all from {low} to {high} {unit}".rstrip())
        return [*lines, *self.notes]

    def __str__(self) -> str:
        return self.report

    def __repr__(self) -> str:
        return f"<rattle.Allocation: {self._title()[:90]}>"

    def _repr_html_(self) -> str:
        return table(HEADER, self._rows(), self._title(), self._said())


def closed_form(
    slopes: np.ndarray, costs: np.ndarray, limit: float, exponent: float, order: int, most: np.ndarray
) -> np.ndarray:
    """(d,) tolerances of a linear output with slopes (d,), none of them 0, at most `most` (d,).

    costs: c (d,).  limit: T.  exponent: p.  order: q, 1 worst case, 2 root sum square.  All in one system of units.
    """
    size = np.abs(slopes)
    ratio = (costs / size**order) ** (1.0 / (exponent + order))
    widths, held = np.array(most, dtype=float), np.zeros(len(size), dtype=bool)
    while not held.all():
        left = limit**order - float(((size * most)[held] ** order).sum())
        widths[~held] = ratio[~held] * (left / float(((size * ratio)[~held] ** order).sum())) ** (1.0 / order)
        beyond = ~held & (widths > most)
        if not beyond.any():
            break
        held |= beyond
        widths[held] = most[held]
    return widths


def allocate(
    t: Linear, limits: Limits, method: str, cost: Mapping[str, float] | None, exponent: float, share: float
) -> Allocation:
    """Tolerances that keep limits; see `Tolerance.allocate`."""
    if method not in ORDERS:
        raise InputError(f"unknown method '{method!s:.60}'{suggest(str(method), ORDERS)}")
    exponent = arguments.positive("exponent", exponent)
    if not 0.0 < arguments.number("share", share) <= 1.0:
        raise InputError(f"share must be from 0 to 1, got {share!s:.60}; 99.73 % is 0.9973")
    room = min(limits.high - t.nominal, t.nominal - limits.low)
    if not room > 0.0:
        raise InputError(
            "within: the output without deviations is not between the limits; move the nominal values first"
        )
    return _Scaled(t, limits, method, costs_of(t.fields, cost), exponent, share).result(room)


def costs_of(fields: Fields, cost: Mapping[str, float] | None) -> dict[str, float]:
    """Costs by parameter, empty if there are none.  Raises InputError, TypeError."""
    if cost is None:
        return {}
    if not isinstance(cost, Mapping):
        raise WrongType(f'cost: expected numbers by parameter such as {{"l2": 1.0}}, got {cost!r:.60}')
    names = [field.name for field in fields.fields if field.dist != TABLE]
    for name in cost:
        if name not in names:
            raise InputError(f"cost: '{name!s:.60}' is none of the tolerances{suggest(str(name), names)}")
    if missing := [name for name in names if name not in cost]:
        raise InputError(f"cost: what {', '.join(missing)} cost is missing")
    return {name: arguments.positive(f"cost: '{name}'", cost[name]) for name in names}


class _Scaled:
    """Tolerances by slopes, and what samples make of them when all are scaled."""

    def __init__(
        self, t: Linear, limits: Limits, method: str, costs: dict[str, float], exponent: float, share: float
    ) -> None:
        self.t, self.limits, self.method, self.costs, self.exponent = t, limits, method, costs, exponent
        self.share = 1.0 if method == "worst-case" else share
        self.given = np.array([field.tol for field in t.fields.fields])
        self.free = np.array([field.dist != TABLE for field in t.fields.fields])
        self.room = np.array([_room(t, name) for name in t.fields.names])  # (k,) greatest tolerances
        n = SIDE_BY_SIDE if t.trials.side_by_side else t.samples
        self.u = points("sobol", t.seed, t.fields.draws, n).points(0, n)
        self.ends = corners.every_corner(t.fields.draws) if t.fields.draws <= corners.ALL else None
        self.notes: list[str] = []
        self.base = self.given  # (k,) tolerances by slopes
        self._known: dict[float, tuple[float, float, tuple[float, float]]] = {}

    def result(self, room: float) -> Allocation:
        """The tolerances.  Raises InputError if none keep the limits."""
        self.base = self._by_slopes(room)
        rest = float(self.limits.excess(np.array([self.t.nominal]))[0])
        with np.errstate(divide="ignore"):
            most = float(min(GREATEST, np.max((self.room / self.base)[self.free])))
        try:
            limit = edge(lambda x: self._look(x)[0], 1.0, SMALLEST, most, rest)
        except NotReachedError:
            fixed = "" if self.free.all() else ", beside tables of values that stay as they are,"
            raise InputError(
                f"within: no tolerances however tight{fixed} keep {self.t.of} {self.limits.text}"
            ) from None
        scale = limit.value
        if not math.isnan(limit.gap):
            self.notes.append("NOT MONOTONE: some tighter tolerances do not keep the limits, though looser ones do")
        note = f"the output itself allows {scale:.4g} times the tolerances by slopes"
        if math.isnan(limit.over):
            note += "; all are as wide as they may be" if most < GREATEST else ", and more"
        self.notes.insert(0, note)
        return self._made(self.tolerances(scale), self._look(scale))

    def tolerances(self, scale: float) -> np.ndarray:
        """(k,) tolerances [SI] scaled from those by slopes."""
        return np.where(self.free, np.minimum(scale * self.base, self.room), self.given)

    def _by_slopes(self, limit: float) -> np.ndarray:
        """(k,) tolerances [SI] by the closed form; the parameters of a group keep their ratio."""
        t, order = self.t, ORDERS[self.method]
        effects, sets = np.abs(t.effects), members(t.fields)
        if not np.isfinite(effects).all():
            raise InputError(f"no tolerances without slopes: {t.why}")
        tables = np.array([not self.free[list(places)].any() for places in sets])
        idle = ~tables & (effects == 0.0)
        share = ~tables & ~idle
        left = limit**order - float((effects[tables] ** order).sum())
        names = labels(t.fields)
        if not left > 0.0:
            widest = ", ".join(name for name, fixed in zip(names, tables, strict=True) if fixed)
            raise InputError(f"within: tables of values ({widest}) alone take more than is allowed")
        if idle.any():
            idle_names = ", ".join(name for name, without in zip(names, idle, strict=True) if without)
            self.notes.append(f"to first order without effect, as wide as before by slopes: {idle_names}")
        if not share.any():
            return self.given
        costs = added(t.fields, self._cost_parts(self.given)) if self.costs else np.ones(len(effects))
        most = np.array([self._widest(places) if shares else 1.0 for places, shares in zip(sets, share, strict=True)])
        p = self.exponent if self.costs else 0.0
        factors = np.ones(len(effects))
        factors[share] = closed_form(effects[share], costs[share], left ** (1.0 / order), p, order, most[share])
        return self.given * factors[list(t.fields.draw)]

    def _widest(self, places: tuple[int, ...]) -> float:
        """The factor by which the tolerances of a contributor can grow until the first meets its limit."""
        return float(min((self.room / self.given)[k] for k in places if self.free[k]))

    def _cost_parts(self, tolerances: np.ndarray) -> np.ndarray:
        """(k,) what tolerances (k,) [SI] cost, 0 for tables."""
        parts = np.zeros(len(tolerances))
        for k, name in enumerate(self.t.fields.names):
            if name in self.costs:
                parts[k] = self.costs[name] / tolerances[k] ** self.exponent
        return parts

    def _fields(self, scale: float) -> Fields:
        every = []
        for field, tol, free in zip(self.t.fields.fields, self.tolerances(scale).tolist(), self.free, strict=True):
            limits = self.t.trials.task.mechanism.model.parameters[field.name]
            low = max(field.nominal - tol, -math.inf if limits.minimum is None else limits.minimum)
            high = min(field.nominal + tol, math.inf if limits.maximum is None else limits.maximum)
            every.append(replace(field, tol=tol, low=low, high=high) if free else field)
        return replace(self.t.fields, fields=tuple(every))

    def _look(self, scale: float) -> tuple[float, float, tuple[float, float]]:
        """How far the worst that has to keep the limits is beyond them (see `edge`), share within, band."""
        if scale not in self._known:
            fields, trials = self._fields(scale), self.t.trials
            sampled = trials.outputs(fields.values(self.u))
            over = self.limits.excess(sampled) - SLACK
            needed = max(math.ceil(self.share * len(over) - ROUND), 1)
            worst = float(np.sort(over)[needed - 1])
            if self.method == "worst-case":
                worst = max(worst, self._corners(fields))
            ends = (
                (float(np.nanmin(sampled)), float(np.nanmax(sampled))) if np.isfinite(over).any() else (math.nan,) * 2
            )
            self._known[scale] = worst, float((over <= 0.0).mean()), ends
        return self._known[scale]

    def _corners(self, fields: Fields) -> float:
        """How far the worst corner is beyond the limits."""
        if self.ends is not None:
            return float(self.limits.excess(self.t.trials.outputs(at_ends(fields, self.ends))).max()) - SLACK
        worst = corners.search(self.t.trials, fields, self.t.effects)
        return float(self.limits.excess(np.array([worst.low, worst.high])).max()) - SLACK

    def _made(self, tolerances: np.ndarray, looked: tuple[float, float, tuple[float, float]]) -> Allocation:
        t, names = self.t, self.t.fields.names
        chosen = [k for k in range(len(names)) if self.free[k]]
        held = [names[k] for k in chosen if tolerances[k] >= self.room[k]]
        limits = [f"as wide as the limits of the model, or the nominal value, allow: {', '.join(held)}"] if held else []
        vary: dict[str, dict[str, Any]] = {}
        for field, tol in zip(t.fields.fields, tolerances.tolist(), strict=True):
            table_of = {"dist": {"values": list(field.values), "weights": list(field.shares)}}
            vary[field.name] = table_of if field.dist == TABLE else {"tol": tol, "dist": field.dist}
        parts = (self._cost_parts(widths) if self.costs else np.array([np.nan]) for widths in (tolerances, self.base))
        cost, cost_by_slopes = (float(part.sum()) for part in parts)
        allocated, by_slopes, before = (
            {names[k]: float(widths[k]) for k in chosen} for widths in (tolerances, self.base, self.given)
        )
        units = {field.name: field.unit for field in t.fields.fields}
        return Allocation(
            t.of, t.unit, self.limits, self.method, allocated, by_slopes, before, vary, cost, cost_by_slopes, looked[1],
            looked[2], units, (*self.notes, *limits),
        )  # fmt: skip


def _room(t: Linear, name: str) -> float:
    """The greatest tolerance of a parameter [SI]: to its limits in the model, else all of its nominal value."""
    parameter = t.trials.task.mechanism.model.parameters[name]
    ends = [abs(limit - parameter.value) for limit in (parameter.minimum, parameter.maximum) if limit is not None]
    if parameter.deviates:  # a diameter of a fit, or the play of a bearing: at most until no play is left
        joint, _, what = name.rpartition(".")
        ends.append((1.0 if what == "play" else 2.0) * t.trials.task.mechanism.model.joints[joint].clearance)
    return min(ends, default=abs(parameter.value) or math.inf)
