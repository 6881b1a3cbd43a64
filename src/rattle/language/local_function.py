"""Functions of one variable of a kind: an expression such as "0.03 + 0.01*cos(a)", evaluated within a kernel.

The parameters of a joint, clearance or load hold, in the place of a field that is such a function, the distance to its
block of numbers among the same parameters:

    number of operations, distance to the stack, then two numbers for each operation (operation, argument),
    the blocks of the tables that it reads, and room for the stack (three numbers for each level)

The argument of a constant is its value, that of a table the distance to its block.  `function_jet` runs it as
`language.jets` runs programs: the variable has rate 1, so the rates are derivatives, exact and without a step.
Switches take the branch of their value; at a kink the derivative is that towards greater arguments.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rattle.language.bytecode import BENT, CONST, CURVE, JUMPS
from rattle.language.expression import Apply, Name, Node, compile_program, replaced
from rattle.language.local_jet import HEAD, function_jets
from rattle.language.syntax import CALL, walk
from rattle.language.tables import Tables, tables_of


class LocalFunction(NamedTuple):
    """A function of one variable: its block of numbers [SI], of which some may be recorded."""

    block: tuple[float, ...]
    constant: bool  # it does not use its variable
    switches: bool  # its derivatives may jump

    def __call__(self, x: ArrayLike) -> np.ndarray:
        """Values, first and second derivatives at numbers x [SI]: (3, *shape of x)."""
        p = np.array([1.0, *map(float, self.block)])
        points = np.asarray(x, dtype=float)
        values = np.empty((points.size, 3))
        function_jets(p, 0, points.ravel(), values)
        return np.moveaxis(values.reshape(*points.shape, 3), -1, 0)


def local_function(node: Node, variable: str, constants: Mapping[str, float], tables: Tables) -> LocalFunction:
    """The function of `variable` that an expression is; constants: values of other names [SI].

    Raises ExpressionError for unknown names and for constants that are not finite.
    """
    used = {part.name.removesuffix(CALL) for part in walk(node) if isinstance(part, Apply)} & tables.curves.keys()
    own = tables_of({name: tables.curves[name] for name in sorted(used)})
    program = compile_program(replaced(node, {variable: Name("t", 0)}), constants, {}, {}, own)
    size = HEAD + 2 * len(program.code)
    rows: list[float] = []
    for op, argument in program.code[:, :2].tolist():
        place = float(size + argument) if op in (CURVE, BENT) else float(argument)
        rows += [float(op), program.const[argument] if op == CONST else place]
    stack = size + len(own.numbers)
    block = (float(len(program.code)), float(stack), *rows, *own.numbers, *[0.0] * (3 * program.depth))
    jumps = any(op in JUMPS for op in program.code[:, 0].tolist())
    return LocalFunction(block, not program.uses_time, jumps)


def packed(values: Iterable[Any]) -> list[Any]:
    """Parameters of a kind as kernels read them: a function is the distance to its block, which comes at the end."""
    numbers: list[Any] = []
    functions: list[tuple[int, Sequence[float]]] = []
    for value in values:
        if isinstance(value, LocalFunction):
            functions.append((len(numbers), value.block))
        numbers.append(0.0 if isinstance(value, LocalFunction) else value)
    for place, block in functions:
        numbers[place] = float(len(numbers) - place)
        numbers += block
    return numbers
