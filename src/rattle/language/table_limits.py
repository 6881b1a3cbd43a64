"""Which table an expression has left, and where its argument was."""

from __future__ import annotations

import math

import numpy as np

from rattle.language import bytecode
from rattle.language.tables import Tables


def left_table(
    code: np.ndarray, const: np.ndarray, first: int, last: int, t: float, body: np.ndarray, signals: np.ndarray,
    tables: Tables,
) -> str:  # fmt: skip
    """In words, which table the program in rows first..last-1 reads outside of its points; "" if none.

    The other arguments are those of `bytecode.evaluate`.
    """
    names = {place: name for name, place in tables.place.items()}
    starts: list[int] = []  # first rows of the operands on the stack
    stack = np.empty(last - first + 1)
    for row in range(first, last):
        op, k = int(code[row, 0]), int(code[row, 1])
        count = bytecode.operands_of(op)
        start = starts[-count] if count else row
        if op in (bytecode.CURVE, bytecode.BENT):
            x = bytecode.evaluate.python(code, const, start, row, t, body, signals, stack)
            value = bytecode.read_table.python(const, k, 0, x, 0.0, 0.0)[0]
            if math.isfinite(x) and not math.isfinite(value):
                return f"{x:.6g} {tables.curves[names[k]].said_outside(names[k])}"
        del starts[len(starts) - count :]
        starts.append(start)
    return ""
