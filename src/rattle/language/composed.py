"""Functions of expressions that are written as formulas of others: everything about them follows from the formula.

A record here is all that a new function takes which can be written so.  Where it is called, its formula stands in the
expression: with the values, rates, bounds, switches, units and code of the operations that it consists of.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rattle.language.motion_laws import LAWS, MEANING, law_text


@dataclass(frozen=True, slots=True)
class Composed:
    """A function by its formula.  Its arguments are in SI units, its numbers are plain numbers."""

    formula: str
    variables: tuple[str, ...] = ("x",)
    meaning: str = ""  # in the reference
    named: bool = True  # an error names the function, not the one of its formula


# by name; functions may be added before the first expression that calls them is read
COMPOSED: dict[str, Composed] = {name: Composed(law_text(name), ("u",), MEANING[name], named=False) for name in LAWS}


def sizes() -> Mapping[str, int]:
    """Number of arguments of each of them."""
    return {name: len(record.variables) for name, record in COMPOSED.items()}
