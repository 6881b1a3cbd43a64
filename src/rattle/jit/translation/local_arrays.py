"""Small arrays that a function of the user makes, of a size that is known: their numbers are on the stack.

The array of one place in the source stands in the same memory each time, so within a loop no other variable may hold
it, and no function returns one.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle.jit.translation.values import TranslationError, Value, is_array, joined, known, members, parts_of, said
from rattle.jit.translation.writing import Writing

FILLED: dict[Any, float] = {np.zeros: 0.0, np.empty: 0.0, np.ones: 1.0}
MAKING: tuple[Any, ...] = (*FILLED, np.full, np.array, np.asarray)
MOST = 1000  # numbers in an array


class LocalArrays(Writing):
    """What makes arrays."""

    def made_array(self, called: Any, given: list[Value], keywords: Sequence[ast.keyword], node: ast.Call) -> Value:
        """The array that a call of NumPy makes."""
        whole = False
        for keyword in keywords:
            kind = ast.unparse(keyword.value)
            if keyword.arg != "dtype" or kind not in ("float", "np.float64", "int", "np.int64"):
                raise TranslationError(f"'{ast.unparse(node)}': an array takes no {keyword.arg}={kind} here")
            whole = kind in ("int", "np.int64")
        if not self.careful or len(given) != (2 if called is np.full else 1):
            raise TranslationError(f"'{ast.unparse(node)}': no array is made here")
        if called in (np.array, np.asarray):
            if not isinstance(given[0].kind, tuple):
                raise TranslationError(f"'{ast.unparse(node)}': an array is made of numbers in brackets")
            rows = members(given[0])
            several = all(isinstance(one.kind, tuple) for one in rows) and bool(rows)
            shape = [len(rows), len(rows[0].kind)] if several else [len(rows)]
            numbers = [part for one in rows for part in (members(one) if several else [one])]
            if len(numbers) != math.prod(shape):
                raise TranslationError(f"'{ast.unparse(node)}': its rows differ in length")
            if keywords:
                return self._filled(shape, numbers, "i" if whole else "f")
            kind = "i"
            for one in numbers:
                kind = joined(kind, one.kind)
            return self._filled(shape, numbers, kind if numbers else "f")
        sizes = members(given[0]) if isinstance(given[0].kind, tuple) else [given[0]]
        shape = [one.thing for one in sizes]
        if not all(type(one) is int and one >= 0 for one in shape) or len(shape) not in (1, 2):
            raise TranslationError(f"'{ast.unparse(node)}': the size of an array must be a known number")
        with_what = given[1] if called is np.full else known(FILLED[called])
        assert with_what is not None
        kind = ("i" if whole else "f") if keywords or called is not np.full else joined("i", with_what.kind)
        return self._filled(shape, [with_what] * math.prod(shape), kind)

    def _filled(self, shape: Sequence[int], numbers: Sequence[Value], kind: str) -> Value:
        if len(numbers) > MOST:
            raise TranslationError(f"an array of {len(numbers)} numbers is too large here")
        room = self.room(f"[{max(1, len(numbers))} x {parts_of(kind)[0]}]")
        made = Value(f"{kind}{len(shape)}", (room, *map(str, shape)))
        for n, one in enumerate(numbers):
            self.write(kind, self.address(made, str(n)), one)
        return made

    def require_own(self, value: Value, node: ast.expr, made: bool) -> None:
        """Refuse a second name for an array within a loop."""
        if self.careful and self.in_loop and not made and has_array(value.kind):
            raise TranslationError(f"'{ast.unparse(node)}': within a loop a variable cannot become {said(value.kind)}")


def has_array(kind: Any) -> bool:
    """True for an array, and for a tuple with one."""
    return any(has_array(one) for one in kind) if isinstance(kind, tuple) else is_array(kind)
