"""The SI unit of an expression, in the words of its names: rad and J stay what they are where that is possible."""

from __future__ import annotations

from collections.abc import Callable

from rattle.language.syntax import Name, Node, Number, walk
from rattle.language.units import Dimension, dimension_of, unit_name


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
            given = stack[-len(part.operands) :]
            del stack[-len(part.operands) :]
            stack.append(_of_operation(part.name, given))
    kept = stack[0]
    if kept and seen == dimension_of(kept):
        return kept
    return unit_name(seen) if seen is not None else ""


def _of_operation(name: str, given: list[str | None]) -> str | None:
    """Unit of an operation if it is that of its operands, "" if it is another one, None for numbers."""
    if name == "choose" or name.startswith("if"):
        given = given[-2:]
    elif name not in ("neg", "abs", "+", "-", "min", "max", "mod", "hypot", "*", "/"):
        return None if all(one is None for one in given) else ""
    units = {one for one in given if one is not None}
    if (name == "*" and None not in given) or (name == "/" and given[1] is not None):
        return ""
    return units.pop() if len(units) == 1 else ("" if units else None)
