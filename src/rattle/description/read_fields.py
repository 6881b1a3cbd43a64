"""Reading the fields of a kind: what the user wrote, or the default."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from rattle import registry
from rattle.description.read_values import Path, Values, said
from rattle.errors import suggest
from rattle.language.expression import ExpressionError, Name, Node, Number
from rattle.language.local_function import LocalFunction, local_function
from rattle.language.units import QuantityError, dimension_of, parse_quantity
from rattle.registry import REQUIRED, Field


class FieldReader:
    """Reads kinds and their fields; problems are collected in `values`."""

    def __init__(self, values: Values) -> None:
        self.values = values

    def choose(self, given: Mapping[str, Any], family: str, path: Path, key: str = "type") -> registry.Kind | None:
        """The kind that an entry names under `key`; None after a problem."""
        known = registry.kinds(family)
        if key not in given:
            self.values.wrong(path, f"needs a {key}: " + ", ".join(known))
            return None
        name = given[key]
        if isinstance(name, str) and name in known:
            return known[name]
        self.values.wrong((*path, key), f"unknown {family} {said(name)}{suggest(str(name), known)}")
        return None

    def field(self, one: Field, key: str, given: Mapping[str, Any], read: Mapping[str, Any], path: Path) -> Any:
        """One field of a kind [SI], as the user wrote it or its default; nan or None after a problem."""
        here = (*path, key)
        if key not in given:
            if one.default is REQUIRED:
                self.values.wrong(path, f"needs {key}: {one.meaning}" + (f" [{one.unit}]" if one.unit else ""))
                return (math.nan, math.nan) if one.shape == "pair" else math.nan
            default = one.default(read) if callable(one.default) else one.default
            if one.function_of:
                return read_function(self.values, default, one, here)
            if one.shape == "flag":
                return float(default)
            return float(one.choices.index(default)) if one.shape == "choice" else default
        if one.shape == "choice":
            word = one.flags[given[key]] if one.flags and isinstance(given[key], bool) else given[key]
            if word in one.choices:
                return float(one.choices.index(word))
            hint = suggest(str(given[key]), one.choices)
            self.values.wrong(here, f"expected one of {', '.join(one.choices)}, got {said(given[key])}{hint}")
            return math.nan
        if one.function_of:
            return read_function(self.values, given[key], one, here)
        if one.shape == "flag":
            if not isinstance(given[key], bool):
                self.values.wrong(here, f"expected true or false, got {said(given[key])}")
            return float(given[key] is True)
        if one.shape == "pair":
            return self.values.vector(given[key], one.unit, here, one.live, one.least)
        return self.values.value(given[key], one.unit, here, one.least, one.live)

    def fields(
        self, kind: registry.Kind, given: Mapping[str, Any], path: Path, unit: Callable[[str], str] = str
    ) -> dict[str, float]:
        """All fields of a kind [SI], in the order of its declaration; unit: what a unit of a field is here."""
        read: dict[str, float] = {}
        for key, one in kind.fields.items():
            read[key] = math.nan
            with self.values.at((*path, key)):
                read[key] = self.field(replace(one, unit=unit(one.unit)), key, given, read, path)
        return read


def read_function(values: Values, given: Any, one: Field, path: Path) -> LocalFunction | float:
    """A field that is a function of a variable of its kind; nan after a problem."""
    node: Node | None = None
    quantity = None
    with values.within({one.function_of: (Name(one.function_of, 0), dimension_of(one.of_unit))}):
        if isinstance(given, str):
            with suppress(QuantityError):
                quantity = parse_quantity(given)
        if isinstance(given, str) and quantity is None:
            node = values.expression(given, path, one.unit, live=False)
        else:
            number = values.value(given, one.unit, path, one.least)
            node = None if math.isnan(number) else Number(number, 0)
    if node is None:
        return math.nan
    try:
        return local_function(node, one.function_of, values.constants, values.tables)
    except ExpressionError as error:
        values.in_expression(error, path)
        return math.nan
