"""Fields of parameters: how the values of parts that are made with tolerances are distributed.

A value with a tolerance is nominal + tol*z.  z is in [-1, 1], with the quantile function z(u), 0 <= u < 1:

    uniform     z = 2 u - 1                                                 sd z = 1/sqrt(3)
    triangular  z = sqrt(2 u) - 1, from u = 1/2 on 1 - sqrt(2 (1 - u))      sd z = 1/sqrt(6)
    normal      z = Phi^-1(p + u (1 - 2 p))/3, p = Phi(-3)                  sd z = sqrt(1 - 6 phi(3)/(1 - 2 p))/3

Phi and phi are distribution function and density of the standard normal distribution: tol is three standard
deviations of the distribution before it is cut there.

Source: Johnson, Kotz, Balakrishnan, Continuous Univariate Distributions (1994, 1995), section 13.10.1 (cut normal),
chapter 26 (uniform, triangular).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rattle.analyses.straight_line.recorded_model import require_parameters
from rattle.description.changes import plain
from rattle.description.model import Parameter, ValueTable
from rattle.description.read_parameters import DISTRIBUTIONS
from rattle.errors import InputError, ModelError, Problem, WrongType, suggest

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

ROUNDING = 1e-12  # share of a value by which the end of a field may miss a limit: it is written in other units
TABLE = "table"  # distribution of single values
Tolerance = float | str | Mapping[str, Any]
Vary = Sequence[str] | Mapping[str, Tolerance] | None


class Shape(NamedTuple):
    """A symmetric distribution on [-1, 1]."""

    quantile: Callable[[np.ndarray], np.ndarray]  # z of u
    below: Callable[[float], float]  # share of the values below z
    sd: float


def _triangular(u: np.ndarray) -> np.ndarray:
    return np.where(u < 0.5, np.sqrt(2.0 * u) - 1.0, 1.0 - np.sqrt(2.0 * (1.0 - u)))


def _below_triangular(z: float) -> float:
    return 0.5 * (1.0 + z) ** 2 if z < 0.0 else 1.0 - 0.5 * (1.0 - z) ** 2


CUT = 3.0  # standard deviations in tol
BEYOND = 0.5 * math.erfc(CUT / math.sqrt(2.0))  # share of a normal distribution beyond each cut
INSIDE = 1.0 - 2.0 * BEYOND
DENSITY = math.exp(-0.5 * CUT**2) / math.sqrt(2.0 * math.pi)  # at the cut


def _normal(u: np.ndarray) -> np.ndarray:
    from scipy.special import ndtri

    return np.asarray(ndtri(BEYOND + u * INSIDE) / CUT)


def _below_normal(z: float) -> float:
    return (0.5 * math.erfc(-CUT * z / math.sqrt(2.0)) - BEYOND) / INSIDE


SHAPES = {
    "uniform": Shape(lambda u: 2.0 * u - 1.0, lambda z: 0.5 * (1.0 + z), 1.0 / math.sqrt(3.0)),
    "normal": Shape(_normal, _below_normal, math.sqrt(1.0 - 2.0 * CUT * DENSITY / INSIDE) / CUT),
    "triangular": Shape(_triangular, _below_triangular, 1.0 / math.sqrt(6.0)),
}


@dataclass(frozen=True)
class Field:
    """The distribution of one parameter; all in the SI unit of the parameter."""

    name: str
    unit: str  # "" for angles and plain numbers
    nominal: float
    tol: float  # half the width of the field
    dist: str  # uniform, normal, triangular or table
    low: float  # ends of the field: no value is outside
    high: float
    values: tuple[float, ...] = ()  # (k,) of a table, increasing
    shares: tuple[float, ...] = ()  # (k,) of the samples that have them [-], positive

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """(n,) values below which shares u (n,) of all samples are, 0 <= u < 1: increasing with u."""
        u = np.asarray(u, dtype=float)
        if self.dist == TABLE:
            last = len(self.values) - 1
            place = np.searchsorted(np.cumsum(self.shares)[:last], u, side="right")
            return np.asarray(np.array(self.values)[place])
        z = SHAPES[self.dist].quantile(u)
        return np.asarray(np.clip(self.nominal + self.tol * z, self.low, self.high))

    @property
    def mean(self) -> float:
        """Mean of the values; the nominal value unless they are a table."""
        return _weighted(self.values, self.shares) if self.dist == TABLE else self.nominal

    @property
    def sd(self) -> float:
        """Standard deviation of the values."""
        if self.dist == TABLE:
            mean = self.mean
            return math.sqrt(_weighted([(number - mean) ** 2 for number in self.values], self.shares))
        return self.tol * SHAPES[self.dist].sd

    def share_outside(self, least: float, most: float) -> float:
        """Share [-] of the values that are below `least` or above `most`."""
        if self.dist == TABLE:
            pairs = zip(self.values, self.shares, strict=True)
            return math.fsum(share for value, share in pairs if not least <= value <= most)
        below, above = ((end - self.nominal) / self.tol for end in (least, most))
        return sum(SHAPES[self.dist].below(min(max(z, -1.0), 1.0)) for z in (below, -above))


def _weighted(values: Sequence[float], shares: Sequence[float]) -> float:
    return math.fsum(value * share for value, share in zip(values, shares, strict=True))


@dataclass(frozen=True)
class Fields:
    """Fields of the parameters that vary, and which of them are drawn together."""

    fields: tuple[Field, ...]  # (k,)
    draw: tuple[int, ...]  # (k,) number of the draw that moves a parameter, from 0 on in order of appearance

    @property
    def draws(self) -> int:
        """Number d of independent draws."""
        return len(set(self.draw))

    @property
    def names(self) -> tuple[str, ...]:
        """(k,) names of the parameters."""
        return tuple(field.name for field in self.fields)

    @property
    def description(self) -> dict[str, Any]:
        """The fields and which are drawn together, as plain data."""
        return {"fields": {field.name: asdict(field) for field in self.fields}, "draw": list(self.draw)}

    def values(self, points: np.ndarray) -> np.ndarray:
        """(k, c) values of the parameters [SI] at points (c, d) in [0, 1)."""
        return np.array([field.quantile(points[:, n]) for field, n in zip(self.fields, self.draw, strict=True)])


def fields_of(m: Mechanism, vary: Vary = None) -> Fields:
    """Fields of parameters about the values of a mechanism.

    vary: parameters with their tolerance, half the width of the field, as a number in SI or a text with a unit:
    {"l2": "0.1 mm"}; or with entries as in the model file: {"l2": {"tol": "0.1 mm", "dist": "normal"}}, where what is
    missing is as in the file.  A list of names takes all from the file, and None all parameters that have a tolerance
    (not zero) or a table of values there.  The parameters of a group of the file have one draw, also if only some of
    them vary.

    A parameter that the file gives by another one (l3 = { value = "l2", tol = ... }) keeps the nominal value of that
    one and has a deviation of its own: two parts of one nominal size are made independently.  Where l3 itself does not
    vary, it follows l2.

    Raises UnknownName; TypeError and ValueError for a question that makes no sense; ModelError for tolerances and
    distributions that cannot be read, and for fields that go beyond the limits (min, max) of the model.
    """
    asked = _with_tolerances(m) if vary is None else _asked(m, vary)
    fields = [_field(parameter) for parameter in asked]
    problems = [
        why for field, parameter in zip(fields, asked, strict=True) if (why := _beyond(field, parameter)) is not None
    ]
    if problems:
        raise ModelError(problems)
    group = {name: n for n, names in enumerate(m.model.groups) for name in names}
    numbers: dict[str | int, int] = {}
    draw = [numbers.setdefault(group.get(parameter.name, parameter.name), len(numbers)) for parameter in asked]
    return Fields(tuple(fields), tuple(draw))


# ---------------------------------------------------------------- what is asked
def varies(parameter: Parameter) -> bool:
    return isinstance(parameter.dist, ValueTable) or bool(parameter.tol)


def _with_tolerances(m: Mechanism) -> list[Parameter]:
    """All parameters with a tolerance.  Raises InputError if there are none, ModelError for groups."""
    every = m.model.parameters
    parameters = [parameter for parameter in every.values() if varies(parameter)]
    if not parameters:
        name = next(iter(every), "l2")
        raise InputError(f"no parameter of the model has a tolerance; {_give_one(name)}")
    problems = []
    for n, names in enumerate(m.model.groups):
        moved = [name for name in names if varies(every[name])]
        for name in names:
            if moved and every[name].tol is None and not varies(every[name]):
                words = f"'{name}' is made together with '{moved[0]}' but has no tolerance; {_give_one(name)}"
                problems.append(Problem(("tolerances", "groups", n), words))
    if problems:
        raise ModelError(problems)
    return parameters


def _give_one(name: str) -> str:
    return f'give it one in the file: {name} = {{ value = ..., tol = ... }}, or here: vary={{"{name}": ...}}'


def _asked(m: Mechanism, vary: Sequence[str] | Mapping[str, Tolerance]) -> list[Parameter]:
    """The parameters that are named, with their tolerances.  Raises what `fields_of` raises."""
    if isinstance(vary, str):
        listed = ", ".join(f'"{name.strip()}"' for name in vary.split(","))
        raise InputError(f"vary: expected a list of parameters; write vary=[{listed}]")
    if not isinstance(vary, Mapping | Sequence) or not vary:
        got = "nothing" if isinstance(vary, Mapping | Sequence) else f"{vary!r:.60}"
        raise InputError(f'vary: expected parameters such as ["l2"] or {{"l2": "0.1 mm"}}, got {got}')
    names = list(vary)
    for name in names:
        if not isinstance(name, str):
            raise WrongType(f"vary: expected names of parameters, got {name!r:.60}")
        if names.count(name) > 1:
            raise InputError(f"vary: '{name}' is named twice")
    require_parameters(m.system, names)
    changes = {name: _entries(name, tolerance) for name, tolerance in vary.items()} if isinstance(vary, Mapping) else {}
    every = m.parameters_with(changes, "vary")
    for name in names:
        _require_spread(every[name], changes.get(name, {}))
    return [every[name] for name in names]


def _entries(name: str, tolerance: Any) -> dict[str, Any]:
    """The entries of the model file that a tolerance in `vary` stands for."""
    if isinstance(tolerance, Mapping):
        for key in tolerance:
            if key not in ("tol", "dist"):
                raise InputError(f"vary: '{name}': unknown key {key!r:.60}{suggest(str(key), ('tol', 'dist'))}")
        return dict(plain(tolerance))
    if isinstance(tolerance, str) and tolerance in DISTRIBUTIONS:
        raise InputError(f"vary: '{name}': '{tolerance}' is no tolerance; write {{\"dist\": \"{tolerance}\"}}")
    if isinstance(tolerance, bool) or not isinstance(tolerance, int | float | str | np.number):
        like = 'expected a tolerance such as "0.1 mm" or {"tol": "0.1 mm", "dist": "normal"}'
        raise InputError(f"vary: '{name}': {like}, got {tolerance!r:.60}")
    return {"tol": plain(tolerance)}


def _require_spread(parameter: Parameter, entries: Mapping[str, Any]) -> None:
    """Raise InputError for a parameter that would not vary, or has a tolerance of no use."""
    if isinstance(parameter.dist, ValueTable):
        if "tol" in entries:
            hint = 'leave tol out, or give another distribution such as "dist": "uniform"'
            raise InputError(
                f"vary: '{parameter.name}' is distributed by a table of values, which needs no tol; {hint}"
            )
    elif parameter.tol is None:
        raise InputError(f"vary: '{parameter.name}' has no tolerance; {_give_one(parameter.name)}")
    elif parameter.tol == 0.0:
        where = "" if "tol" in entries else " in the file"
        raise InputError(
            f"vary: '{parameter.name}' has tol = 0{where} and would not vary; leave it out or give it more"
        )


# ---------------------------------------------------------------- one field
def _field(parameter: Parameter) -> Field:
    """The field of a parameter with a tolerance or a table of values."""
    if isinstance(parameter.dist, ValueTable):
        return _table(parameter, parameter.dist)
    tol = parameter.tol or 0.0
    low, high = (_at_limits(end, parameter, tol) for end in (parameter.value - tol, parameter.value + tol))
    return Field(parameter.name, parameter.unit, parameter.value, tol, parameter.dist or DISTRIBUTIONS[0], low, high)


def _table(parameter: Parameter, table: ValueTable) -> Field:
    most = max(table.weights)  # their sum might overflow
    pairs = sorted(zip(table.values, (weight / most for weight in table.weights), strict=True))
    whole = math.fsum(weight for _, weight in pairs)
    values = tuple(_at_limits(value, parameter, 0.0) for value, weight in pairs if weight > 0.0)
    shares = tuple(weight / whole for _, weight in pairs if weight > 0.0)
    half = 0.5 * (values[-1] - values[0])
    return Field(parameter.name, parameter.unit, parameter.value, half, TABLE, values[0], values[-1], values, shares)


def _at_limits(value: float, parameter: Parameter, tol: float) -> float:
    """The value, or a limit of the parameter to which it only rounds: what is exactly at a limit is not beyond it."""
    for limit in (parameter.minimum, parameter.maximum):
        if limit is not None and abs(value - limit) <= ROUNDING * max(abs(value), abs(parameter.value), tol):
            return limit
    return value


def _beyond(field: Field, parameter: Parameter) -> Problem | None:
    """What is said of a field that goes beyond the limits of the model."""
    least = -math.inf if parameter.minimum is None else parameter.minimum
    most = math.inf if parameter.maximum is None else parameter.maximum
    if least <= field.low and field.high <= most:
        return None
    unit = f" {parameter.unit}".rstrip()
    limits = [f"min = {least:g}{unit}"] * (field.low < least) + [f"max = {most:g}{unit}"] * (field.high > most)
    span = f"{field.dist}, {field.low:g} to {field.high:g}{unit}"
    room = min(parameter.value - least, most - parameter.value)
    what = "take other values"
    if field.dist != TABLE:
        what = f"take tol = {room:g}{unit} at most" if room > 0.0 else "choose another value"
    words = f"{100.0 * field.share_outside(least, most):.2g} % of its values ({span}) are beyond {' and '.join(limits)}"
    return Problem(("parameters", parameter.name), f"{words}; {what}, or widen the limits in the file")
