"""The SI unit of an expression, in the words of its names: rad and J stay what they are where that is possible."""

from __future__ import annotations

from collections.abc import Callable

from rattle.language.operation import Units
from rattle.language.operations import units_of
from rattle.language.syntax import Name, Node, Number, walk
from rattle.language.units import Dimension, dimension_of, unit_name

KEEP = (Units.KEPT, Units.COMMON, Units.PRODUCT, Units.QUOTIENT)  # operations whose result may have their unit


def unit_of(node: Node, lookup: Callable[[str], str], seen: Dimension | None) -> str:
    """SI unit of an expression of dimension `seen`: that of its curves where they are added and compared only (rad and
    J stay what they are), otherwise made from the dimension."""
    stack: list[str | None] = []  # None: a number, which has any unit
    for part in walk(node):
        if isinstance(part, Number):
            stack.append(None)
        elif isinstance(part, Name):
            stack.append("s" if part.name == "t" else lookup(part.name))
        else:
            operands = stack[-len(part.operands) :]
            del stack[-len(part.operands) :]
            stack.append(_of_operation(part.name, operands))
    unit = stack[0]
    if unit and seen == dimension_of(unit):
        return unit
    return unit_name(seen) if seen is not None else ""


def _of_operation(name: str, operands: list[str | None]) -> str | None:
    """Unit of an operation if it is that of its operands, "" if it is another one, None for numbers."""
    rule = units_of(name)
    if rule is Units.CHOICE:
        operands = operands[-2:]
    elif rule not in KEEP:
        return None if all(unit is None for unit in operands) else ""
    units = {unit for unit in operands if unit is not None}
    if (rule is Units.PRODUCT and None not in operands) or (rule is Units.QUOTIENT and operands[1] is not None):
        return ""
    return units.pop() if len(units) == 1 else ("" if units else None)
