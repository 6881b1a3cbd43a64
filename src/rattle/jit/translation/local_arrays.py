"""Small arrays that a function of the user makes, of a size that is known: their numbers are on the stack.

The array of one place in the source stands in the same memory each time, so within a loop no other variable may hold
it, and no function returns one.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Sequence

import numpy as np

from rattle.jit.families import Kind
from rattle.jit.translation.values import TranslationError, Value, is_array, joined, known, members, parts_of, said
from rattle.jit.translation.writing import Writing

FILLED: dict[object, float] = {np.zeros: 0.0, np.empty: 0.0, np.ones: 1.0}
MAKING: tuple[object, ...] = (*FILLED, np.full, np.array, np.asarray)
MOST = 1000  # numbers in an array


class LocalArrays(Writing):
    """What makes arrays."""

    def made_array(
        self, called: object, arguments: list[Value], keywords: Sequence[ast.keyword], node: ast.Call
    ) -> Value:
        """The array that a call of NumPy makes."""
        wanted = _kind_wanted(keywords, node)
        if not self.careful or len(arguments) != (2 if called is np.full else 1):
            raise TranslationError(f"'{ast.unparse(node)}': no array is made here")
        if called in (np.array, np.asarray):
            return self._of_rows(arguments[0], wanted, node)
        sizes = members(arguments[0]) if isinstance(arguments[0].kind, tuple) else [arguments[0]]
        shape = [size.thing for size in sizes]
        if not all(type(size) is int and size >= 0 for size in shape) or len(shape) not in (1, 2):
            raise TranslationError(f"'{ast.unparse(node)}': the size of an array must be a known number")
        content = arguments[1] if called is np.full else known(FILLED[called])
        assert content is not None
        kind = wanted or (joined("i", content.kind) if called is np.full else "f")
        return self._filled(shape, [content] * math.prod(shape), kind)

    def _of_rows(self, value: Value, wanted: str, node: ast.Call) -> Value:
        """The array of the numbers in a tuple, or in a tuple of tuples."""
        if not isinstance(value.kind, tuple):
            raise TranslationError(f"'{ast.unparse(node)}': an array is made of numbers in brackets")
        rows = members(value)
        several = all(isinstance(row.kind, tuple) for row in rows) and bool(rows)
        shape = [len(rows), len(rows[0].kind)] if several else [len(rows)]
        numbers = [part for row in rows for part in (members(row) if several else [row])]
        if len(numbers) != math.prod(shape):
            raise TranslationError(f"'{ast.unparse(node)}': its rows differ in length")
        if wanted:
            return self._filled(shape, numbers, wanted)
        kind: Kind = "i"
        for entry in numbers:
            kind = joined(kind, entry.kind)
        return self._filled(shape, numbers, kind if numbers else "f")

    def _filled(self, shape: Sequence[int], numbers: Sequence[Value], kind: Kind) -> Value:
        if len(numbers) > MOST:
            raise TranslationError(f"an array of {len(numbers)} numbers is too large here")
        room = self.room(f"[{max(1, len(numbers))} x {parts_of(kind)[0]}]")
        array = Value(f"{kind}{len(shape)}", (room, *map(str, shape)))
        for n, entry in enumerate(numbers):
            self.write(kind, self.address(array, str(n)), entry)
        return array

    def require_own(self, value: Value, node: ast.expr, is_new: bool) -> None:
        """Refuse a second name for an array within a loop."""
        if self.careful and self.in_loop and not is_new and has_array(value.kind):
            raise TranslationError(f"'{ast.unparse(node)}': within a loop a variable cannot become {said(value.kind)}")


def _kind_wanted(keywords: Sequence[ast.keyword], node: ast.Call) -> str:
    """The kind of numbers that `dtype` asks for; "" without it."""
    wanted = ""
    for keyword in keywords:
        kind = ast.unparse(keyword.value)
        if keyword.arg != "dtype" or kind not in ("float", "np.float64", "int", "np.int64"):
            raise TranslationError(f"'{ast.unparse(node)}': an array takes no {keyword.arg}={kind} here")
        wanted = "i" if kind in ("int", "np.int64") else "f"
    return wanted


def has_array(kind: Kind) -> bool:
    """True for an array, and for a tuple with one."""
    return any(has_array(member) for member in kind) if isinstance(kind, tuple) else is_array(kind)
