"""Curves of a recorded model that follow from its result columns, by the names of a result."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from rattle.description.model import Model
from rattle.equations.system import System
from rattle.language.recorded import Operand, symbol_of
from rattle.results.columns import geometry
from rattle.results.derived import rules, unit_of_rule, value_of
from rattle.trace.graph import Graph
from rattle.value_types import Plain


def derived_curve(
    graph: Graph, recorded: System, curves: Mapping[str, Operand], name: str
) -> tuple[Operand, str] | None:
    """Symbol and SI unit of a derived curve (points, forces, coordinates), from result columns; None for other names.

    recorded: the system with its recorded numbers.  The same as `results.result` derives.
    """
    by_name = rules(geometry(recorded.model), curves)
    if name not in by_name:
        return None

    def curve(key: str) -> Operand:
        return curves[key] if key in curves else derived(key)

    def function(op: str) -> Plain:
        return lambda *operands: graph.apply(op, *operands)

    def derived(key: str) -> Any:
        rule = by_name[key]
        points = tuple((symbol_of(x), symbol_of(y)) for x, y in rule.points)
        rule = rule._replace(points=points, number=symbol_of(rule.number))
        return value_of(rule, curve, function("cos"), function("sin"), function("hypot"))

    return derived(name), unit_of_rule(name, by_name[name])


def derived_units(model: Model, curves: Collection[str]) -> dict[str, str]:
    """SI units of all names that `derived_curve` knows; curves: names of the result columns."""
    return {name: unit_of_rule(name, rule) for name, rule in rules(geometry(model), curves).items()}


def derived_names(model: Model, curves: Collection[str]) -> list[str]:
    """All names that `derived_curve` knows; curves: names of the result columns."""
    return list(rules(geometry(model), curves))
