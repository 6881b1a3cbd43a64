"""Expressions in a model file: checked for dimensions and translated into small stack programs.

An expression consists of numbers, names (`l1`, `rocker.omega`), `+ - * / **`, parentheses, the functions of
`FUNCTIONS`, `pi`, the time `t`, and `a if x < y and not z > 0 else b`.  Everything else is refused, so a model file can
never run code.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, chain, islice

import numpy as np

from rattle.errors import suggest
from rattle.language import bytecode
from rattle.language.operation import Units
from rattle.language.operations import units_of
from rattle.language.recorded import Recorded, array_of, bare, operate, read
from rattle.language.syntax import (
    CALL,
    FUNCTIONS,
    RESERVED,
    Apply,
    ExpressionError,
    Name,
    Node,
    Number,
    names,
    parse,
    replaced,
    walk,
)
from rattle.language.tables import NO_TABLES, Tables
from rattle.language.units import DIMENSIONLESS, TIME, Dimension, describe, unit_name

__all__ = [
    "FUNCTIONS",
    "RESERVED",
    "Apply",
    "ExpressionError",
    "Name",
    "Node",
    "Number",
    "Program",
    "argument_of",
    "compile_program",
    "concatenate",
    "dimension",
    "names",
    "parse",
    "replaced",
    "require_finite",
    "value",
    "walk",
]


# ---------------------------------------------------------------- dimensions
def dimension(node: Node, lookup: Callable[[str], Dimension | None], time: Dimension | None = TIME) -> Dimension | None:
    """Dimension of an expression, None if it cannot be determined.

    lookup: dimension of a name, None if unknown.  time: dimension of `t`.  A number in the expression is assumed to
    have any dimension that fits, as in "9.81*m".  Tables are looked up by `call_name` and `argument_of`.  Raises
    ExpressionError for "m + kg", "sin(m)" and the like.
    """
    stack: list[Dimension | None] = []
    for part in walk(node):
        if isinstance(part, Number):
            stack.append(part.dimension)
        elif isinstance(part, Name):
            stack.append(time if part.name == "t" else lookup(part.name))
        else:
            size = len(part.operands)
            operands = stack[-size:]
            del stack[-size:]
            table = part.name.endswith(CALL)
            stack.append(_of_table(part, operands[0], lookup) if table else _combine(part, operands))
    return stack[0]


def _of_table(part: Apply, argument: Dimension | None, lookup: Callable[[str], Dimension | None]) -> Dimension | None:
    """Dimension of the value of a table; that of its argument is known under the name `argument_of` it."""
    expected = lookup(argument_of(part.name))
    if argument is not None and expected is not None and argument != expected:
        table = part.name.removesuffix(CALL)
        raise ExpressionError(f"the table '{table}' is over {_word(expected)}, not {_word(argument)}", part.column)
    return lookup(part.name)


def argument_of(table: str) -> str:
    """The name under which the dimension of a table's argument is looked up; table: see `syntax.call_name`."""
    return f"{table} of"


def _combine(part: Apply, operands: list[Dimension | None]) -> Dimension | None:
    """Dimension of one operation from those of its operands."""
    return _RULES[units_of(part.name)](part, operands)


def _combine_plain(part: Apply, operands: list[Dimension | None]) -> Dimension | None:
    if operands[0] not in (None, DIMENSIONLESS):
        function = part.called or part.name
        raise ExpressionError(
            f"cannot take {function} of {_word(operands[0])}; expected a plain number or angle", part.column
        )
    return DIMENSIONLESS


def _combine_root(part: Apply, operands: list[Dimension | None]) -> Dimension | None:
    return None if operands[0] is None else operands[0].power(0.5)


def _combine_product(part: Apply, operands: list[Dimension | None]) -> Dimension | None:
    x, y = operands
    if x is None or y is None:
        return None
    return x.times(y) if part.name == "*" else x.over(y)


def _combine_common(part: Apply, operands: list[Dimension | None]) -> Dimension | None:
    return _same(part, {"+": "add", "-": "subtract"}.get(part.name, f"take {part.name} of"), *operands)


def _combine_angle(part: Apply, operands: list[Dimension | None]) -> Dimension | None:
    _combine_common(part, operands)
    return DIMENSIONLESS


def _combine_comparison(part: Apply, operands: list[Dimension | None]) -> Dimension | None:
    _same(part, "compare", *operands[:2])
    return DIMENSIONLESS


def _combine_choice(part: Apply, operands: list[Dimension | None]) -> Dimension | None:
    if len(operands) == 4:
        _same(part, "compare", *operands[:2])
    return _same(part, "choose between", *operands[-2:])


def _combine_power(part: Apply, operands: list[Dimension | None]) -> Dimension | None:
    base, exponent = operands
    if exponent not in (None, DIMENSIONLESS):
        raise ExpressionError(f"an exponent must be a plain number, not {_word(exponent)}", part.column)
    if base is None or base == DIMENSIONLESS:
        return base
    if any(isinstance(x, Name) or (isinstance(x, Apply) and x.name.endswith(CALL)) for x in walk(part.operands[1])):
        return None
    number = value(part.operands[1], {})
    return base.power(number) if abs(number) <= 100.0 else None


def _same(part: Apply, verb: str, x: Dimension | None, y: Dimension | None) -> Dimension | None:
    if x is not None and y is not None and x != y:
        where = f" in {part.called}" if part.called else ""
        raise ExpressionError(f"cannot {verb} {_word(x)} and {_word(y)}{where}", part.column)
    return y if x is None else x


def _word(dimension: Dimension | None) -> str:
    return describe(DIMENSIONLESS) if dimension is None or dimension == DIMENSIONLESS else unit_name(dimension)


_RULES: Mapping[Units, Callable[[Apply, list[Dimension | None]], Dimension | None]] = {
    Units.PLAIN: _combine_plain,
    Units.NUMBER: lambda part, operands: DIMENSIONLESS,
    Units.KEPT: lambda part, operands: operands[0],
    Units.ROOT: _combine_root,
    Units.COMMON: _combine_common,
    Units.ANGLE: _combine_angle,
    Units.COMPARISON: _combine_comparison,
    Units.JOINING: lambda part, operands: DIMENSIONLESS,
    Units.PRODUCT: _combine_product,
    Units.QUOTIENT: _combine_product,
    Units.POWER: _combine_power,
    Units.CHOICE: _combine_choice,
}


# ---------------------------------------------------------------- programs
@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """An expression as a stack program for `language.bytecode.evaluate`; all numbers in SI units."""

    code: np.ndarray  # (n, 4) int64: op, argument, side, crossed; see `language.bytecode`
    const: np.ndarray  # (nc,) constants [SI]
    depth: int  # size of the stack it needs
    uses_state: bool
    uses_time: bool
    signals: frozenset[int]  # indices of the signals it reads


def value(node: Node, constants: Mapping[str, float], tables: Tables = NO_TABLES) -> float:
    """Value of a constant expression [SI]; `constants` holds the values of names [SI].

    Raises ExpressionError for other names and if the value is not finite.
    """
    assembler = _Assembler(constants, {}, {}, time=False, tables=tables)
    assembler.read(node)
    return assembler.const[0]


def require_finite(node: Node, constants: Mapping[str, float], tables: Tables = NO_TABLES) -> None:
    """Raise ExpressionError if a part without `t`, state and signals has no finite value; `constants` in SI units."""
    live = {name: 0 for name in names(node) if name not in constants}
    _Assembler(constants, live, {}, time=True, tables=tables).read(node)


def compile_program(
    node: Node, constants: Mapping[str, float], state: Mapping[str, int], signals: Mapping[str, int],
    tables: Tables = NO_TABLES,
) -> Program:  # fmt: skip
    """Translate an expression into a program.  Every part without `t`, state and signals becomes one constant.

    constants: values of names [SI].  state: index of a state name in `body`, 8 * row + column.
    signals: index of a signal.  tables: their numbers must be the first constants of the run.  Raises ExpressionError
    for unknown names and for constants that are not finite.
    """
    return _Assembler(constants, state, signals, time=True, tables=tables).assemble(node)


def concatenate(parts: Sequence[Program], tables: Tables = NO_TABLES) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Several programs joined into one: code (n, 4), const (nc,) [SI], first (np+1,) and the greatest stack depth.

    Program i is rows first[i] to first[i + 1] - 1 of `code`; its constants are indexed from the start of `const`, which
    begins with the numbers of the tables.
    """
    first = np.zeros(len(parts) + 1, dtype=np.int64)
    first[1:] = list(accumulate(len(part.code) for part in parts))
    code = np.zeros((int(first[-1]), 4), dtype=np.int64)
    const = array_of([*tables.numbers, *(number for part in parts for number in part.const)])
    offset = len(tables.numbers)
    for part, start in zip(parts, first, strict=False):
        rows = code[start : start + len(part.code)]
        rows[:] = part.code
        rows[rows[:, 0] == bytecode.CONST, 1] += offset
        offset += len(part.const)
    return code, const, first, max((part.depth for part in parts), default=1)


class _Assembler:
    """Writes the rows of a program in the order of evaluation and folds constants."""

    def __init__(
        self, constants: Mapping[str, float], state: Mapping[str, int], signals: Mapping[str, int], time: bool,
        tables: Tables,
    ) -> None:  # fmt: skip
        self.constants, self.state, self.signals, self.time = constants, state, signals, time
        self.tables = tables
        self.code: list[tuple[int, int]] = []
        self.const: list[float] = []
        self.columns: list[int] = []  # of the constants in the text, or of the operand that made them not finite
        self.folded: list[bool] = []  # for each operand on the stack: is it a constant?
        self.depth = 0

    def read(self, node: Node) -> None:
        """Write rows and constants of an expression.  Raises ExpressionError for unknown names and for inf or nan."""
        for part in walk(node):
            if isinstance(part, Number):
                self.constant(part.value, part.column)
            elif isinstance(part, Name):
                self.name(part)
            else:
                self.operation(part)
            self.depth = max(self.depth, len(self.folded))
        for number, column in zip(self.const, self.columns, strict=True):
            if not math.isfinite(bare(number)):
                raise ExpressionError(f"the result is not a finite number ({number})", column)

    def assemble(self, node: Node) -> Program:
        self.read(node)
        code = np.zeros((len(self.code), 4), dtype=np.int64)
        code[:, :2] = self.code
        return Program(
            code=code,
            const=array_of(self.const),
            depth=self.depth,
            uses_state=bool((code[:, 0] == bytecode.STATE).any()),
            uses_time=bool((code[:, 0] == bytecode.TIME).any()),
            signals=frozenset(code[code[:, 0] == bytecode.SIGNAL, 1].tolist()),
        )

    def constant(self, number: float, column: int) -> None:
        self.code.append((bytecode.CONST, len(self.const)))
        self.const.append(number if isinstance(number, Recorded) else float(number))
        self.columns.append(column)
        self.folded.append(True)

    def name(self, part: Name) -> None:
        name = part.name
        if name in self.constants:
            self.constant(self.constants[name], part.column)
            return
        if name == "t" and self.time:
            row = (bytecode.TIME, 0)
        elif name in self.state:
            row = (bytecode.STATE, self.state[name])
        elif name in self.signals:
            row = (bytecode.SIGNAL, self.signals[name])
        else:
            near = suggest(name[:40], islice(chain(self.constants, self.signals, self.state), 2000))
            raise ExpressionError(f"unknown name '{name}'{near}", part.column)
        self.code.append(row)
        self.folded.append(False)

    def table(self, part: Apply) -> None:
        """The value of a table."""
        name = part.name.removesuffix(CALL)
        curve = self.tables.curves[name]
        if not self.folded[-1]:
            self.code.append((bytecode.BENT if curve.bends else bytecode.CURVE, self.tables.place[name]))
            return
        x, block = self.const.pop(), curve.block
        del self.code[-1], self.columns[-1], self.folded[-1]
        numbers = np.array([bare(number) for number in block])  # an array, as what it calls may be machine code
        result = float(bytecode.read_table.python(numbers, 0, 0, bare(x), 0.0, 0.0)[0])
        if math.isfinite(bare(x)) and not math.isfinite(result):
            raise ExpressionError(f"{x:g} {curve.said_outside(name)}", part.column)
        self.constant(read(block, result, x), part.column)

    def operation(self, part: Apply) -> None:
        if part.name.endswith(CALL):
            self.table(part)
            return
        op, size = bytecode.CODE[part.name], len(part.operands)
        if all(self.folded[-size:]):
            operands, columns = self.const[-size:], self.columns[-size:]
            del self.code[-size:], self.const[-size:], self.columns[-size:], self.folded[-size:]
            number = _fold(op, operands)
            blamed = [c for x, c in zip(operands, columns, strict=True) if not math.isfinite(bare(x))]
            self.constant(number, blamed[0] if blamed else part.column)
            return
        if op == bytecode.POW and self.folded[-1] and self.const[-1] == 2.0:
            del self.code[-1], self.const[-1], self.columns[-1]
            op = bytecode.SQUARE
        self.code.append((op, 0))
        self.folded[-size:] = [False]


def _fold(op: int, operands: list[float]) -> float:
    """Value of one operation on constants, computed by the functions that the kernels use."""
    if len(operands) == 1:
        return operate(op, float(bytecode.unary.python(op, *map(bare, operands))), *operands)
    if len(operands) == 2:
        return operate(op, float(bytecode.binary.python(op, *map(bare, operands))), *operands)
    if op == bytecode.CHOOSE:
        return operands[1] if operands[0] > 0.0 else operands[2]
    return operands[2] if bytecode.holds.python(op, *operands[:2]) else operands[3]
