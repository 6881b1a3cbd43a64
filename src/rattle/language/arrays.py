"""Expressions on arrays: the values of `language.bytecode`, for all instants of a result at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from rattle.language.syntax import Apply, Name, Node, Number, walk

Array = NDArray[np.float64]

_CHOICES: Mapping[str, Callable[[Array, Array], NDArray[np.bool_]]] = {
    "if<": np.less,
    "if<=": np.less_equal,
    "if>": np.greater,
    "if>=": np.greater_equal,
}


def _step(x: Array) -> Array:
    return np.where(np.isnan(x), x, np.where(x >= 0.0, 1.0, 0.0))


def _power(x: Array, y: Array) -> Array:
    """x ** y as `bytecode.power` has it: without the sign of a zero, and no root of -inf."""
    root = (x < 0.0) & np.isfinite(y) & (y % 1.0 != 0.0)
    return np.where(root, np.nan, np.power(x + 0.0, y))


def _mod(x: Array, y: Array) -> Array:
    return np.asarray(x - y * np.floor(x / y))


def _compared(test: Callable[[Array, Array], NDArray[np.bool_]]) -> Callable[[Array, Array], Array]:
    """A comparison as a number: 1 where it holds, -1 where not."""
    return lambda x, y: np.where(test(x, y), 1.0, -1.0)


_FUNCTIONS: Mapping[str, Callable[..., Array]] = {
    "neg": np.negative, "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "**": _power,
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "tanh": np.tanh, "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "abs": np.abs, "sign": np.sign, "step": _step,
    "atan2": np.arctan2, "hypot": np.hypot, "min": np.minimum, "max": np.maximum, "floor": np.floor, "mod": _mod,
    "and": np.minimum, "or": np.maximum, "not": np.negative,
    **{name[2:]: _compared(test) for name, test in _CHOICES.items()},
}  # fmt: skip


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
                given = stack[-size:]
                del stack[-size:]
                stack.append(_apply(part, given))
    return stack[0]


def _apply(part: Apply, given: list[Array]) -> Array:
    """One operation."""
    if part.name in _CHOICES:
        return np.asarray(np.where(_CHOICES[part.name](given[0], given[1]), given[2], given[3]))
    if part.name == "choose":
        return np.asarray(np.where(given[0] > 0.0, given[1], given[2]))
    return np.asarray(_FUNCTIONS[part.name](*given))
