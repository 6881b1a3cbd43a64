"""Expressions on arrays: the values of `language.bytecode`, for all instants of a result at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rattle.language.operations import CHOICES, CHOOSE, OPERATIONS
from rattle.language.syntax import Apply, Name, Node, Number, walk

Array = NDArray[np.float64]


def evaluate(node: Node, lookup: Callable[[str], Array | float]) -> Array:
    """Values [SI] of an expression; those of its names are given by `lookup` and are broadcast.

    Outside its domain a function gives nan or inf.  Raises what `lookup` raises for an unknown name.
    """
    stack: list[Array] = []
    with np.errstate(all="ignore"):
        for part in walk(node):
            if isinstance(part, Number):
                stack.append(np.asarray(part.value))
            elif isinstance(part, Name):
                stack.append(np.asarray(lookup(part.name), dtype=np.float64))
            else:
                size = len(part.operands)
                operands = stack[-size:]
                del stack[-size:]
                stack.append(_apply(part, operands))
    return stack[0]


def _apply(part: Apply, operands: list[Array]) -> Array:
    """One operation."""
    if part.name in CHOICES:
        return np.asarray(np.where(CHOICES[part.name](operands[0], operands[1]), operands[2], operands[3]))
    if part.name == CHOOSE:
        return np.asarray(np.where(operands[0] > 0.0, operands[1], operands[2]))
    return np.asarray(OPERATIONS[part.name].array(*operands))
