"""The tables [parameters] and [signals], names that other tables may use, and [tolerances]."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from rattle.description.dependence import describe_cycle, in_order
from rattle.description.model import Parameter, ValueTable, within_limits
from rattle.description.read_values import Path, TooManyProblems, Values, expected, said
from rattle.errors import ModelError, Problem, suggest
from rattle.language.expression import Node, Number
from rattle.language.units import Dimension, QuantityError, describe, parse_quantity, unit_name

DISTRIBUTIONS = ("uniform", "normal", "triangular")
PARAMETER = ("value", "min", "max", "tol", "dist", "label", "description")  # keys of a parameter
LONGEST_LABEL = 60  # characters: what fits beside or above a slider; a description may be longer
TABLE = ("values", "weights")  # keys of a distribution of single values


def read_parameters(values: Values, document: Mapping[str, Any]) -> dict[str, Parameter]:
    """Read the table [parameters], written in any order; values [SI] and dimensions are stored in `values`."""
    table = values.table(document.get("parameters", {}), ("parameters",))
    written: dict[str, tuple[Any, Path]] = {}
    for name, given in table.items():
        path: Path = ("parameters", name)
        values.name(name, path)
        if not isinstance(given, Mapping):
            written[name] = (given, path)
            continue
        values.keys(given, PARAMETER, path)
        if "value" in given:
            written[name] = (given["value"], (*path, "value"))
        else:
            values.wrong(path, "expected { value = ... }")
            values.broken.add(name)
    dependent: dict[str, Node] = {}
    for name, (given, path) in written.items():
        quantity = read_quantity(values, given, path)
        if isinstance(quantity, tuple):
            values.set_constant(name, *quantity)
        elif quantity is not None:
            dependent[name] = quantity
        else:
            values.broken.add(name)
    _dependent(values, dependent, written)
    found: dict[str, Parameter] = {}
    for name in (name for name in table if name in values.constants):
        with values.at(("parameters", name)):
            found[name] = _parameter(values, name, table[name])
    return found


def chosen_parameters(document: Mapping[str, Any]) -> list[str]:
    """Names of the parameters of a readable document that do not follow from others."""
    values, found = Values(), []
    for name, given in document.get("parameters", {}).items():
        value = given["value"] if isinstance(given, Mapping) else given
        if isinstance(read_quantity(values, value, ("parameters", name)), tuple):
            found.append(name)
    return found


def values_where(document: Mapping[str, Any], numbers: Mapping[str, float]) -> dict[str, float]:
    """Values [SI] of the parameters of a readable document where some have these instead: expressions follow them.

    Limits are not checked.
    """

    def just(x: float) -> Callable[[float], float]:
        return lambda _: x

    values = Values({name: just(x) for name, x in numbers.items()})
    read_parameters(values, document)
    return values.constants


def parameters_with(
    document: Mapping[str, Any], changes: Mapping[str, Mapping[str, Any]], place: str
) -> dict[str, Parameter]:
    """Parameters of a readable document where some have these entries (tol, dist) instead.

    Raises ModelError with all that is wrong in the changes, at `place`.
    """
    table = dict(document["parameters"])
    for name, entries in changes.items():
        given = table[name]
        table[name] = {**(given if isinstance(given, Mapping) else {"value": given}), **entries}
    values = Values()
    found: dict[str, Parameter] = {}
    with suppress(TooManyProblems):
        found = read_parameters(values, {"parameters": table})
    if values.problems:
        wrong = [Problem((place, *one.path[1:]), one.message, one.at_key, one.column) for one in values.problems]
        raise ModelError(wrong)
    return found


def read_quantity(values: Values, given: Any, path: Path) -> tuple[float, Dimension | None] | Node | None:
    """Value [SI] and dimension of a number or quantity, the tree of an expression, or None after a problem."""
    if not isinstance(given, str):
        number = values.value(given, "", path)
        return None if math.isnan(number) else (number, None)
    try:
        quantity = parse_quantity(given)
    except QuantityError as error:
        values.wrong(path, str(error))
        return None
    return values.parse(given, path) if quantity is None else quantity


def _dependent(values: Values, nodes: Mapping[str, Node], written: Mapping[str, tuple[Any, Path]]) -> None:
    """Evaluate parameters that are given by other parameters, in order of dependence."""
    order, cycles = in_order(nodes)
    values.broken.update(nodes.keys() - set(order))
    for cycle in cycles:
        values.wrong(written[cycle[0]][1], describe_cycle(cycle))
    for name in order:
        given, path = written[name]
        node, text = nodes[name], str(given)
        right = values.names_known(node, text, path, None, live=False)
        number = values.constant(node, path) if right and values.dimension_fits(node, text, path, None) else None
        if number is None:
            values.broken.add(name)
        else:
            values.set_constant(name, number, values.dimension(node))


def _parameter(values: Values, name: str, given: Any) -> Parameter:
    """A parameter with its limits; its value is known by now."""
    seen = values.dimensions.get(name)
    unit = unit_name(seen) if seen is not None else ""
    if not isinstance(given, Mapping):
        return Parameter(name, values.constants[name], unit)
    path: Path = ("parameters", name)
    other = _unlike_its_limits(given, seen)
    if other is not None:
        said_of = describe(seen) if seen is not None else "a plain number"
        values.wrong(
            (*path, "value"), f"{said(given['value'])} is {said_of}; expected {describe(other)}, as min and max are"
        )
        return Parameter(name, values.constants[name], unit)
    limits: dict[str, float | None] = {
        key: _limit(values, given[key], unit, seen, (*path, key)) for key in ("min", "max", "tol") if key in given
    }
    low, high, tol = (limits.get(key) for key in ("min", "max", "tol"))
    if beyond := _beyond(values.constants[name], low, high, given):
        values.wrong((*path, "value"), f"{said(given['value'])} is {beyond}")
    if tol is not None and tol < 0:
        values.wrong((*path, "tol"), f"{said(given['tol'])} must not be negative")
    dist = _distribution(values, given.get("dist", ""), unit, seen, (*path, "dist"))
    unit = unit if seen is not None else _unit_of_limits(given)
    label, description = (_words(values, given.get(key, ""), (*path, key)) for key in ("label", "description"))
    if len(label) > LONGEST_LABEL:
        values.wrong((*path, "label"), f"{len(label)} characters are too long for a label, {LONGEST_LABEL} at most")
    return Parameter(name, values.constants[name], unit, low, high, tol, dist, label, description)


def _words(values: Values, given: Any, path: Path) -> str:
    """A text for people, on one line; "" after a problem."""
    if not isinstance(given, str):
        values.wrong(path, f"{said(given)} is no text; write words in quotes")
        return ""
    return " ".join(given.split())


def _unit_of_limits(given: Mapping[str, Any]) -> str:
    """SI unit of the limits of a value that says none, as 2*a does not; "" if they say none either."""
    return next((unit_name(seen) for seen in _dimensions_of_limits(given)), "")


def _dimensions_of_limits(given: Mapping[str, Any]) -> list[Dimension]:
    """The dimensions that limits say, each of which may be wrong."""
    found: list[Dimension] = []
    for key in ("min", "max", "tol"):
        with suppress(QuantityError):
            quantity = parse_quantity(given[key]) if isinstance(given.get(key), str) else None
            if quantity is not None and quantity[1] is not None:
                found.append(quantity[1])
    return found


def _distribution(values: Values, given: Any, unit: str, seen: Dimension | None, path: Path) -> str | ValueTable:
    """The name of a distribution, or a table of values [SI] of the parameter's dimension; "" after a problem."""
    if not isinstance(given, Mapping):
        if given in ("", *DISTRIBUTIONS):
            return str(given)
        either = f"{', '.join(DISTRIBUTIONS)} or {{ values = [...], weights = [...] }}"
        values.wrong(path, f"unknown distribution {said(given)}; expected {either}")
        return ""
    values.keys(given, TABLE, path)
    if "values" not in given:
        values.wrong(path, "expected { values = [...] }, the values that the parameter takes")
        return ""
    numbers = [
        _limit(values, one, unit, seen, (*path, "values", n))
        for n, one in enumerate(_list(values, given["values"], "values", (*path, "values")))
    ]
    weights = [1.0] * len(numbers)
    if numbers and "weights" in given:
        weights = _weights(values, given["weights"], len(numbers), (*path, "weights"))
    known = tuple(one for one in numbers if one is not None)
    return ValueTable(known, tuple(weights)) if len(known) == len(weights) > 0 else ""


def _weights(values: Values, given: Any, count: int, path: Path) -> list[float]:
    """Weights [-] of `count` values; an empty list after a problem."""
    before = len(values.problems)
    listed = _list(values, given, "weights", path)
    found: list[float] = [values.value(one, "", (*path, n), "not negative") for n, one in enumerate(listed)]
    if len(values.problems) > before:
        return []
    if len(found) != count:
        values.wrong(path, f"{len(found)} weights for {count} values; expected one for each")
        return []
    if not any(one > 0.0 for one in found):
        values.wrong(path, "all weights are zero; at least one must be positive")
        return []
    return found


def _list(values: Values, given: Any, what: str, path: Path) -> list[Any]:
    """The items of a list; an empty one after a problem."""
    if not isinstance(given, list | tuple):
        values.wrong(path, f"expected a list of {what}, got {said(given)}")
        return []
    if not given:
        values.wrong(path, f"expected a list of {what}, got an empty one")
    return list(given)


def _unlike_its_limits(given: Mapping[str, Any], seen: Dimension | None) -> Dimension | None:
    """The common dimension of two or more limits if the value has another one, else None."""
    found = _dimensions_of_limits(given)
    if seen is None or len(found) < 2 or len(set(found)) > 1 or found[0] == seen:
        return None
    return found[0]


def _beyond(value: float, low: float | None, high: float | None, given: Mapping[str, Any]) -> str:
    """What is said of a value [SI] that is not between its limits, "" if it is."""
    if within_limits(value, low, high):
        return ""
    bare = f" (a number without a unit is SI: {_unit_of(given['min'])} here)" if _unit_missing(given) else ""
    if high is None:
        return f"below min = {said(given['min'])}"
    if low is None:
        return f"above max = {said(given['max'])}"
    return f"not between min = {said(given['min'])} and max = {said(given['max'])}{bare}"


def _unit_missing(given: Mapping[str, Any]) -> bool:
    """True if the limits have units and the value is a number without one."""
    limits = given.get("min"), given.get("max")
    return not isinstance(given["value"], str) and all(isinstance(one, str) for one in limits)


def _unit_of(limit: str) -> str:
    """The SI unit that matches a limit; "rad" for an angle and for a limit without a unit."""
    try:
        quantity = parse_quantity(limit)
    except QuantityError:
        return "rad"
    return (unit_name(quantity[1]) if quantity is not None and quantity[1] is not None else "") or "rad"


def _limit(values: Values, given: Any, unit: str, seen: Dimension | None, path: Path) -> float | None:
    """One of min, max, tol in SI units: a quantity of the parameter's dimension, or an expression."""
    found = read_quantity(values, given, path)
    if found is None:
        return None
    if not isinstance(found, tuple):
        node = values.expression(given, path, unit if seen is not None else None, live=False)
        return None if node is None else values.constant(node, path)
    number, dimension = found
    if seen is not None and dimension is not None and dimension != seen:
        values.wrong(path, f"{said(given)} is {describe(dimension)}; expected {expected(unit)}")
        return None
    return number


def read_groups(values: Values, document: Mapping[str, Any]) -> tuple[tuple[str, ...], ...]:
    """Read the table [tolerances]: groups of parameters that are made together."""
    path: Path = ("tolerances",)
    table = values.table(document.get("tolerances", {}), path)
    values.keys(table, ("groups",), path)
    given = table.get("groups", [])
    if not isinstance(given, list | tuple):
        values.wrong((*path, "groups"), f'expected groups of parameters such as [["l2", "l3"]], got {said(given)}')
        return ()
    for n, one in enumerate(given):
        if not isinstance(one, list | tuple) or not all(isinstance(name, str) for name in one):
            like = 'expected a group of parameters such as ["l2", "l3"]'
            values.wrong((*path, "groups", n), f"{like}, got {said(one)}")
            return ()
    grouped: dict[str, int] = {}
    for n, one in enumerate(given):
        _check_group(values, one, n, grouped)
    return tuple(tuple(one) for one in given)


def _check_group(values: Values, given: Sequence[str], n: int, grouped: dict[str, int]) -> None:
    """Check group number n; the group of each name is entered in `grouped`."""
    path: Path = ("tolerances", "groups", n)
    for k, name in enumerate(given):
        if name not in values.constants and name not in values.broken:
            values.wrong((*path, k), f"no parameter {said(name)}{suggest(name, values.constants)}")
        elif name in grouped:
            where = "twice in this group" if grouped[name] == n else "in another group already"
            values.wrong((*path, k), f"'{name}' is {where}; join groups that are made together")
        grouped[name] = n
    if len(given) < 2:
        values.wrong(path, f"a group of {len(given)}; expected two or more parameters that are made together")


def read_signals(values: Values, document: Mapping[str, Any]) -> tuple[dict[str, Node], dict[str, str]]:
    """Read the table [signals]: expressions in order of evaluation, and their SI units."""
    table = values.table(document.get("signals", {}), ("signals",))
    values.live.update(dict.fromkeys(table))
    nodes: dict[str, Node] = {}
    fixed: dict[str, Dimension | None] = {}
    for name, given in table.items():
        path: Path = ("signals", name)
        values.name(name, path)
        if name in values.constants:
            values.wrong(path, f"'{name}' is already a parameter; choose another name", at_key=True)
        if isinstance(given, bool) or not isinstance(given, int | float | str):
            values.wrong(path, f"expected an expression, got {said(given)}")
            continue
        found = read_quantity(values, given, path)
        if isinstance(found, tuple):
            nodes[name], fixed[name] = Number(found[0], 0), found[1]
        elif found is not None and values.names_known(found, str(given), path, None, live=True):
            nodes[name] = found
    order, cycles = in_order(nodes)
    for cycle in cycles:
        values.wrong(("signals", cycle[0]), describe_cycle(cycle))
    units = {}
    for name in order:
        if name not in fixed and not values.dimension_fits(nodes[name], str(table[name]), ("signals", name), None):
            continue
        if not values.is_finite(nodes[name], ("signals", name)):
            continue
        seen = fixed[name] if name in fixed else values.dimension(nodes[name])
        values.dimensions[name] = seen
        if name not in fixed and not values.has_units(nodes[name]):
            values.numbers.add(name)
        units[name] = unit_name(seen) if seen is not None else ""
    return {name: nodes[name] for name in order}, units
