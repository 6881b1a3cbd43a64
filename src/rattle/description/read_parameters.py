"""The tables [parameters] and [signals], names that other tables may use, and [tolerances]."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

from rattle.description.dependence import describe_cycle, in_order
from rattle.description.model import Parameter, ValueTable, within_limits
from rattle.description.read_fields import FieldReader
from rattle.description.read_play import FITTED, ROLLING, Hidden, hidden_names, hidden_parameters
from rattle.description.read_values import TooManyProblems, Values, expected, quoted
from rattle.description.reading import Path, Table, section
from rattle.description.tables import DISTRIBUTION, LIKELY, PARAMETER, TOLERANCES, VALUE
from rattle.description.tables import DISTRIBUTIONS as DISTRIBUTIONS  # ensembles take them from here
from rattle.errors import ModelError, Problem, suggest
from rattle.language.expression import Node, Number
from rattle.language.units import LENGTH, Dimension, QuantityError, as_difference, describe, parse_quantity, unit_name


def read_parameters(values: Values, document: Table) -> dict[str, Parameter]:
    """Read the table [parameters], written in any order; values [SI] and dimensions are stored in `values`."""
    table = values.table(document.get("parameters", {}), ("parameters",))
    written = _written_values(values, table, document)
    dependent: dict[str, Node] = {}
    for name, (number, path) in written.items():
        quantity = read_quantity(values, number, path)
        if isinstance(quantity, tuple):
            values.set_constant(name, *quantity)
        elif quantity is not None:
            dependent[name] = quantity
        else:
            values.broken.add(name)
    _dependent(values, dependent, written)
    defaults = dict(hidden_parameters(values, document))
    for name, default in defaults.items():
        if name not in values.constants or not _is_length(values, name, *written[name]):
            values.set_constant(name, default.value, LENGTH)
    parameters: dict[str, Parameter] = {}
    for name in (name for name in table if name in values.constants):
        with values.at(("parameters", name)):
            entry, own = table[name], defaults.get(name)
            entry = {"value": own.value, **entry} if own is not None and isinstance(entry, Mapping) else entry
            parameters[name] = _parameter(values, name, entry)
    for name, default in defaults.items():
        parameters[name] = _of_name(parameters.get(name, Parameter(name, values.constants[name], "m")), default)
    return parameters


def _written_values(values: Values, table: Table, document: Table) -> dict[str, tuple[object, Path]]:
    """What stands for the value of each parameter, and where; of those of fits and bearings it may be missing."""
    written: dict[str, tuple[object, Path]] = {}
    hidden = hidden_names(document)
    for name, entry in table.items():
        path: Path = ("parameters", name)
        if name not in hidden:
            if _is_left_over(values, name, document):
                continue
            values.name(name, path)
        if not isinstance(entry, Mapping):
            written[name] = (entry, path)
            continue
        values.keys(entry, PARAMETER.fields, path)
        if "value" in entry:
            written[name] = (entry["value"], (*path, "value"))
        elif name not in hidden:
            values.wrong(path, VALUE.missing)
            values.broken.add(name)
    return written


def _is_left_over(values: Values, name: str, document: Table) -> bool:
    """True, after a problem, of a parameter of a fit or a bearing that its joint has no more."""
    joint, _, key = name.partition(".")
    if key not in (*FITTED, *ROLLING) or joint not in section(document, "joints"):
        return False
    fault = f"is of a fit or a bearing that joint '{joint}' has not; leave it out"
    values.wrong(("parameters", name), fault, at_key=True)
    values.broken.add(name)
    return True


def _is_length(values: Values, name: str, entry: object, path: Path) -> bool:
    """True of a parameter whose value is a length, or says no unit; False after a problem."""
    seen = values.dimensions.get(name)
    if seen is None or seen == LENGTH:
        return True
    values.wrong(path, f"{quoted(entry)} is {describe(seen)}; expected {expected(unit_name(LENGTH))}")
    return False


def _of_name(parameter: Parameter, default: Hidden) -> Parameter:
    """A parameter of a fit or a bearing, with what its name says where its entry does not."""
    return replace(
        parameter, tol=default.tol if parameter.tol is None else parameter.tol, dist=parameter.dist or default.dist,
        description=parameter.description or default.description, deviates=True,
    )  # fmt: skip


def with_values(document: Table, values: Mapping[str, float]) -> dict[str, object]:
    """A document whose parameters have these values [SI]."""
    table = dict(section(document, "parameters"))
    for name, value in values.items():
        entry = table.get(name)
        table[name] = {**entry, "value": value} if isinstance(entry, Mapping) else value
    return {**document, "parameters": table}


def chosen_parameters(document: Table) -> list[str]:
    """Names of the parameters of a readable document that do not follow from others."""
    values, chosen = Values(), []
    for name, entry in section(document, "parameters").items():
        value = entry["value"] if isinstance(entry, Mapping) else entry
        if isinstance(read_quantity(values, value, ("parameters", name)), tuple):
            chosen.append(name)
    return [*chosen, *(name for name in hidden_names(document) if name not in chosen)]


def values_where(document: Table, numbers: Mapping[str, float]) -> dict[str, float]:
    """Values [SI] of the parameters of a readable document where some have these instead: expressions follow them.

    Limits are not checked.
    """

    def just(x: float) -> Callable[[float], float]:
        return lambda _: x

    values = Values({name: just(x) for name, x in numbers.items()})
    read_parameters(values, document)
    return values.constants


def parameters_with(document: Table, changes: Mapping[str, Table], place: str) -> dict[str, Parameter]:
    """Parameters of a readable document where some have these entries (tol, dist) instead.

    Raises ModelError with all that is wrong in the changes, at `place`.
    """
    table = dict(section(document, "parameters"))
    for name, entries in changes.items():
        entry = table.get(name, {})
        table[name] = {**(entry if isinstance(entry, Mapping) else {"value": entry}), **entries}
    values = Values()
    parameters: dict[str, Parameter] = {}
    with suppress(TooManyProblems):
        parameters = read_parameters(values, {"parameters": table, "joints": section(document, "joints")})
    if values.problems:
        wrong = [
            Problem((place, *problem.path[1:]), problem.message, problem.at_key, problem.column)
            for problem in values.problems
        ]
        raise ModelError(wrong)
    return parameters


def read_quantity(values: Values, written: object, path: Path) -> tuple[float, Dimension | None] | Node | None:
    """Value [SI] and dimension of a number or quantity, the tree of an expression, or None after a problem."""
    if not isinstance(written, str):
        number = values.value(written, "", path)
        return None if math.isnan(number) else (number, None)
    try:
        quantity = parse_quantity(written)
    except QuantityError as error:
        values.wrong(path, str(error))
        return None
    return values.parse(written, path) if quantity is None else quantity


def _dependent(values: Values, nodes: Mapping[str, Node], written: Mapping[str, tuple[object, Path]]) -> None:
    """Evaluate parameters that are given by other parameters, in order of dependence."""
    order, cycles = in_order(nodes)
    values.broken.update(nodes.keys() - set(order))
    for cycle in cycles:
        values.wrong(written[cycle[0]][1], describe_cycle(cycle))
    for name in order:
        formula, path = written[name]
        node, text = nodes[name], str(formula)
        right = values.names_known(node, text, path, None, live=False)
        number = values.constant(node, path) if right and values.dimension_fits(node, text, path, None) else None
        if number is None:
            values.broken.add(name)
        else:
            values.set_constant(name, number, values.dimension(node))


def _parameter(values: Values, name: str, entry: object) -> Parameter:
    """A parameter with its limits; its value is known by now."""
    seen = values.dimensions.get(name)
    unit = unit_name(seen) if seen is not None else ""
    if not isinstance(entry, Mapping):
        return Parameter(name, values.constants[name], unit)
    path: Path = ("parameters", name)
    other = _unlike_its_limits(entry, seen)
    if other is not None:
        said_of = describe(seen) if seen is not None else "a plain number"
        values.wrong(
            (*path, "value"), f"{quoted(entry['value'])} is {said_of}; expected {describe(other)}, as min and max are"
        )
        return Parameter(name, values.constants[name], unit)
    limits: dict[str, float | None] = {
        key: _limit(values, entry[key], unit, seen, (*path, key)) for key in ("min", "max", "tol") if key in entry
    }
    low, high, tol = (limits.get(key) for key in ("min", "max", "tol"))
    if beyond := _beyond(values.constants[name], low, high, entry):
        values.wrong((*path, "value"), f"{quoted(entry['value'])} is {beyond}")
    if tol is not None and tol < 0:
        values.wrong((*path, "tol"), f"{quoted(entry['tol'])} must not be negative")
    dist = _distribution(values, entry.get("dist", ""), unit, seen, (*path, "dist"))
    unit = unit if seen is not None else _unit_of_limits(entry)
    texts = FieldReader(values).read(PARAMETER, entry, path)
    label, description = texts["label"] or "", texts["description"] or ""
    return Parameter(name, values.constants[name], unit, low, high, tol, dist, label, description)


def _unit_of_limits(entry: Table) -> str:
    """SI unit of the limits of a value that says none, as 2*a does not; "" if they say none either."""
    return next((unit_name(seen) for seen in _dimensions_of_limits(entry)), "")


def _dimensions_of_limits(entry: Table) -> list[Dimension]:
    """The dimensions that limits say, each of which may be wrong."""
    dimensions: list[Dimension] = []
    for key in ("min", "max", "tol"):
        with suppress(QuantityError):
            written = entry.get(key)
            quantity = parse_quantity(as_difference(written)) if isinstance(written, str) else None
            if quantity is not None and quantity[1] is not None:
                dimensions.append(quantity[1])
    return dimensions


def _distribution(values: Values, written: object, unit: str, seen: Dimension | None, path: Path) -> str | ValueTable:
    """The name of a distribution, or a table of values [SI] of the parameter's dimension; "" after a problem."""
    if not isinstance(written, Mapping):
        if written in ("", *DISTRIBUTIONS):
            return str(written)
        either = f"{', '.join(DISTRIBUTIONS)} or {{ values = [...], weights = [...] }}"
        values.wrong(path, f"unknown distribution {quoted(written)}; expected {either}")
        return ""
    values.keys(written, DISTRIBUTION.fields, path)
    if "values" not in written:
        values.wrong(path, LIKELY.missing)
        return ""
    read = FieldReader(values).read(DISTRIBUTION, written, path)
    numbers = [
        _limit(values, number, unit, seen, (*path, "values", n)) for n, number in enumerate(read["values"] or ())
    ]
    weights = [1.0] * len(numbers)
    if numbers and read["weights"]:
        weights = _weights(values, read["weights"], len(numbers), (*path, "weights"))
    sound = tuple(number for number in numbers if number is not None)
    return ValueTable(sound, tuple(weights)) if len(sound) == len(weights) > 0 else ""


def _weights(values: Values, written: Sequence[object], count: int, path: Path) -> list[float]:
    """Weights [-] of `count` values; an empty list after a problem."""
    before = len(values.problems)
    weights = [values.value(weight, "", (*path, n), "not negative") for n, weight in enumerate(written)]
    if len(values.problems) > before:
        return []
    if len(weights) != count:
        values.wrong(path, f"{len(weights)} weights for {count} values; expected one for each")
        return []
    if not any(weight > 0.0 for weight in weights):
        values.wrong(path, "all weights are zero; at least one must be positive")
        return []
    return weights


def _unlike_its_limits(entry: Table, seen: Dimension | None) -> Dimension | None:
    """The common dimension of two or more limits if the value has another one, else None."""
    dimensions = _dimensions_of_limits(entry)
    if seen is None or len(dimensions) < 2 or len(set(dimensions)) > 1 or dimensions[0] == seen:
        return None
    return dimensions[0]


def _beyond(value: float, low: float | None, high: float | None, entry: Table) -> str:
    """What is said of a value [SI] that is not between its limits, "" if it is."""
    if within_limits(value, low, high):
        return ""
    bare = f" (a number without a unit is SI: {_unit_of(str(entry['min']))} here)" if _unit_missing(entry) else ""
    if high is None:
        return f"below min = {quoted(entry['min'])}"
    if low is None:
        return f"above max = {quoted(entry['max'])}"
    return f"not between min = {quoted(entry['min'])} and max = {quoted(entry['max'])}{bare}"


def _unit_missing(entry: Table) -> bool:
    """True if the limits have units and the value is a number without one."""
    limits = entry.get("min"), entry.get("max")
    return not isinstance(entry["value"], str) and all(isinstance(limit, str) for limit in limits)


def _unit_of(limit: str) -> str:
    """The SI unit that matches a limit; "rad" for an angle and for a limit without a unit."""
    try:
        quantity = parse_quantity(limit)
    except QuantityError:
        return "rad"
    return (unit_name(quantity[1]) if quantity is not None and quantity[1] is not None else "") or "rad"


def _limit(values: Values, written: object, unit: str, seen: Dimension | None, path: Path) -> float | None:
    """One of min, max, tol in SI units: a quantity of the parameter's dimension, or an expression.

    A tolerance in degC is a difference, in K.
    """
    if path[-1] == "tol" and isinstance(written, str):
        written = as_difference(written)
    quantity = read_quantity(values, written, path)
    if quantity is None:
        return None
    if not isinstance(quantity, tuple):
        node = values.expression(str(written), path, unit if seen is not None else None, live=False)
        return None if node is None else values.constant(node, path)
    number, dimension = quantity
    if seen is not None and dimension is not None and dimension != seen:
        values.wrong(path, f"{quoted(written)} is {describe(dimension)}; expected {expected(unit)}")
        return None
    return number


def read_groups(values: Values, document: Table) -> tuple[tuple[str, ...], ...]:
    """Read the table [tolerances]: groups of parameters that are made together."""
    path: Path = ("tolerances",)
    table = values.table(document.get("tolerances", {}), path)
    groups: tuple[tuple[str, ...], ...] = FieldReader(values).form(TOLERANCES, table, path)["groups"] or ()
    grouped: dict[str, int] = {}
    for n, group in enumerate(groups):
        _check_group(values, group, n, grouped)
    return groups


def _check_group(values: Values, group: Sequence[str], n: int, grouped: dict[str, int]) -> None:
    """Check group number n; the group of each name is entered in `grouped`."""
    path: Path = ("tolerances", "groups", n)
    for k, name in enumerate(group):
        if name not in values.constants and name not in values.broken:
            values.wrong((*path, k), f"no parameter {quoted(name)}{suggest(name, values.constants)}")
        elif name in grouped:
            where = "twice in this group" if grouped[name] == n else "in another group already"
            values.wrong((*path, k), f"'{name}' is {where}; join groups that are made together")
        grouped[name] = n
    if len(group) < 2:
        values.wrong(path, f"a group of {len(group)}; expected two or more parameters that are made together")


def read_signals(values: Values, document: Table) -> tuple[dict[str, Node], dict[str, str]]:
    """Read the table [signals]: expressions in order of evaluation, and their SI units."""
    table = values.table(document.get("signals", {}), ("signals",))
    values.live.update(dict.fromkeys(table))
    nodes: dict[str, Node] = {}
    fixed: dict[str, Dimension | None] = {}
    for name, written in table.items():
        quantity = _signal(values, name, written)
        if isinstance(quantity, tuple):
            nodes[name], fixed[name] = Number(quantity[0], 0), quantity[1]
        elif quantity is not None:
            nodes[name] = quantity
    order, cycles = in_order(nodes)
    for cycle in cycles:
        values.wrong(("signals", cycle[0]), describe_cycle(cycle))
    units = {}
    for name in order:
        free = name not in fixed
        if free and not values.dimension_fits(nodes[name], str(table[name]), ("signals", name), None):
            continue
        if not values.is_finite(nodes[name], ("signals", name)):
            continue
        seen = values.dimension(nodes[name]) if free else fixed[name]
        values.dimensions[name] = seen
        if free and not values.has_units(nodes[name]):
            values.numbers.add(name)
        units[name] = unit_name(seen) if seen is not None else ""
    return {name: nodes[name] for name in order}, units


def _signal(values: Values, name: str, written: object) -> tuple[float, Dimension | None] | Node | None:
    """What a signal is, as by `read_quantity`; None after a problem."""
    path: Path = ("signals", name)
    values.name(name, path)
    if name in values.constants:
        values.wrong(path, f"'{name}' is already a parameter; choose another name", at_key=True)
    if isinstance(written, bool) or not isinstance(written, int | float | str):
        values.wrong(path, f"expected an expression, got {quoted(written)}")
        return None
    quantity = read_quantity(values, written, path)
    if quantity is None or isinstance(quantity, tuple):
        return quantity
    return quantity if values.names_known(quantity, str(written), path, None, live=True) else None
