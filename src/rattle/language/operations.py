"""All operations of expressions: a function is added by its record, or by a formula of others (`composed`).

What operations are called in the tree of an expression, and which of them are functions that a text may call.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from rattle.language import functions_of_one, functions_of_two
from rattle.language.operation import Operation, Units

OF_ONE, OF_TWO = functions_of_one.OPERATIONS, functions_of_two.OPERATIONS
NOT = replace(functions_of_one.NEG, name="not", units=Units.JOINING)  # a condition is a number: positive where it holds
OPERATIONS: Mapping[str, Operation] = {record.name: record for record in (*OF_ONE, *OF_TWO, NOT)}
# choices by one comparison: `a if x < y else b` is "if<" of x, y, a, b
CHOICES: Mapping[str, Callable[[Any, Any], Any]] = {
    "if<": operator.lt, "if<=": operator.le, "if>": operator.gt, "if>=": operator.ge,
}  # fmt: skip
CHOOSE = "choose"  # a choice by any condition, of it, then and otherwise

SAME: Mapping[str, str] = {record.also: record.name for record in OF_ONE if record.also}  # two names of one function
# functions: number of arguments (-2: two or more)
FUNCTIONS: Mapping[str, int] = {
    **{record.name: record.size for record in OF_ONE if record.function},
    **{name: OPERATIONS[of].size for name, of in SAME.items()},
    **{record.name: record.size for record in OF_TWO if record.function},
}
RESERVED = frozenset(name for name in FUNCTIONS if name not in SAME and OPERATIONS[name].reserved)


def units_of(name: str) -> Units:
    """How an operation, by its name in a tree, finds the unit of its result."""
    return Units.CHOICE if name == CHOOSE or name in CHOICES else OPERATIONS[name].units


def record_of(function: str) -> Operation:
    """The record of a function by one of its names."""
    return OPERATIONS[SAME.get(function, function)]
