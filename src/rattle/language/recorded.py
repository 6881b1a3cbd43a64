"""Numbers of a model that remember how they follow from chosen parameters.

A `Recorded` is a float that also holds its symbol in a graph (`rattle.trace.graph`).  Reading a model whose chosen
parameters are such numbers gives a model of such numbers: its arithmetic is recorded, its checks and comparisons go
as for the numbers at hand, and what they found is kept as an assumption about other values of the parameters.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Protocol, TypeAlias

import numpy as np

from rattle.errors import WrongType
from rattle.language import bytecode

ROUNDING = 1e-12  # share of a number that expressions may be off


class Symbolic(Protocol):
    """A number or flag of a recorded calculation: a `Symbol` of `rattle.trace.graph`."""

    def __add__(self, other: Operand, /) -> Operand: ...
    def __radd__(self, other: Operand, /) -> Operand: ...
    def __sub__(self, other: Operand, /) -> Operand: ...
    def __rsub__(self, other: Operand, /) -> Operand: ...
    def __mul__(self, other: Operand, /) -> Operand: ...
    def __rmul__(self, other: Operand, /) -> Operand: ...
    def __truediv__(self, other: Operand, /) -> Operand: ...
    def __rtruediv__(self, other: Operand, /) -> Operand: ...
    def __pow__(self, other: Operand, /) -> Operand: ...
    def __neg__(self) -> Operand: ...
    def __abs__(self) -> Operand: ...
    def __lt__(self, other: Operand, /) -> Flag: ...
    def __le__(self, other: Operand, /) -> Flag: ...
    def __gt__(self, other: Operand, /) -> Flag: ...
    def __ge__(self, other: Operand, /) -> Flag: ...
    def __and__(self, other: Flag, /) -> Flag: ...
    def __rand__(self, other: Flag, /) -> Flag: ...
    def __or__(self, other: Flag, /) -> Flag: ...
    def __ror__(self, other: Flag, /) -> Flag: ...
    def __float__(self) -> float: ...  # refused


Operand: TypeAlias = "Symbolic | float"
Flag: TypeAlias = "Symbolic | bool"


class Journal(Protocol):
    """What keeps the record."""

    def operation(self, op: int, *operands: Operand) -> Operand:
        """Symbol of an operation of `language.bytecode` on symbols and numbers."""

    def table(self, block: Sequence[Operand], x: Operand) -> Operand:
        """Symbol of the value at x of a table, given by its block of numbers, see `language.tables`."""

    def assume(self, condition: Flag, holds: bool) -> None:
        """Keep that a condition between symbols and numbers was true or false."""


class Recorded(float):
    """A number [SI] and its symbol."""

    __slots__ = ("journal", "symbol")
    symbol: Operand
    journal: Journal

    def __new__(cls, value: float, symbol: Operand, journal: Journal) -> Recorded:
        number = super().__new__(cls, value)
        number.symbol, number.journal = symbol, journal
        return number

    def __reduce__(self) -> tuple[type[float], tuple[float]]:
        return float, (float(self),)

    @property
    def bare(self) -> float:
        """Its value without the record."""
        return float.__add__(self, 0.0)

    def made(self, value: float, symbol: Operand) -> Recorded:
        """Another number with a record, which follows from this one."""
        return Recorded(value, symbol, self.journal)

    def _kept(self, condition: Flag, holds: bool) -> bool:
        self.journal.assume(condition, holds)
        return holds

    def __add__(self, other: float) -> Recorded:
        return self.made(float(self) + float(other), self.symbol + symbol_of(other))

    __radd__ = __add__

    def __sub__(self, other: float) -> Recorded:
        return self.made(float(self) - float(other), self.symbol - symbol_of(other))

    def __rsub__(self, other: float) -> Recorded:
        return self.made(float(other) - float(self), symbol_of(other) - self.symbol)

    def __mul__(self, other: float) -> Recorded:
        return self.made(float(self) * float(other), self.symbol * symbol_of(other))

    __rmul__ = __mul__

    def __truediv__(self, other: float) -> Recorded:
        return self.made(float(self) / float(other), self.symbol / symbol_of(other))

    def __rtruediv__(self, other: float) -> Recorded:
        return self.made(float(other) / float(self), symbol_of(other) / self.symbol)

    def __neg__(self) -> Recorded:
        return self.made(-float(self), -self.symbol)

    def __abs__(self) -> Recorded:
        return self.made(abs(float(self)), abs(self.symbol))

    def __lt__(self, other: float) -> bool:
        return self._kept(self.symbol < symbol_of(other), float(self) < float(other))

    def __le__(self, other: float) -> bool:
        return self._kept(self.symbol <= symbol_of(other), float(self) <= float(other))

    def __gt__(self, other: float) -> bool:
        return self._kept(self.symbol > symbol_of(other), float(self) > float(other))

    def __ge__(self, other: float) -> bool:
        return self._kept(self.symbol >= symbol_of(other), float(self) >= float(other))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, int | float):
            return False
        return self._kept(self.symbol == symbol_of(other), float(self) == float(other))

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __bool__(self) -> bool:
        return self != 0.0

    __hash__ = float.__hash__


def symbol_of(x: Operand) -> Operand:
    """The symbol of a recorded number; any other number as it is."""
    return x.symbol if isinstance(x, Recorded) else float(x)


def bare(x: float) -> float:
    """The value of a number, for what leaves no trace in a record.

    For checks that only tell numbers which can be computed with from all others, and for values that are recorded.
    """
    return x.bare if isinstance(x, Recorded) else float(x)


def as_number(x: object) -> float:
    """A number as a float; one that is recorded as it is.  Raises TypeError for what is none."""
    if isinstance(x, Recorded):
        return x
    if not isinstance(x, float | int | np.integer):
        raise WrongType(f"{x!r} is no number")
    return float(x)


def hypot(x: float, y: float) -> float:
    """Length of a vector, with its record."""
    return operate(bytecode.HYPOT, math.hypot(bare(x), bare(y)), x, y)


def sqrt(x: float) -> float:
    """Square root of a number that is not negative, with its record."""
    return operate(bytecode.SQRT, math.sqrt(bare(x)), x)


def cos(x: float) -> float:
    """Cosine of an angle [rad], with its record."""
    return operate(bytecode.COS, math.cos(bare(x)), x)


def sin(x: float) -> float:
    """Sine of an angle [rad], with its record."""
    return operate(bytecode.SIN, math.sin(bare(x)), x)


def acos(x: float) -> float:
    """Angle [rad] with this cosine, from -1 to 1, with its record."""
    return operate(bytecode.ACOS, math.acos(bare(x)), x)


def log(x: float) -> float:
    """Natural logarithm of a number above 0, with its record."""
    return operate(bytecode.LOG, math.log(bare(x)), x)


def is_whole(x: float) -> bool:
    """True of a number without a fraction, but for the rounding of what it was computed by."""
    return bool(abs(operate(bytecode.FLOOR, float(math.floor(bare(x) + 0.5)), x + 0.5) - x) <= ROUNDING * abs(x))


def largest(first: float, *others: float) -> float:
    """The largest of some numbers, with its record, whichever it is."""
    for other in others:
        first = operate(bytecode.MAX, max(bare(first), bare(other)), first, other)
    return as_number(first)


def least(first: float, *others: float) -> float:
    """The least of some numbers, with its record, whichever it is."""
    for other in others:
        first = operate(bytecode.MIN, min(bare(first), bare(other)), first, other)
    return as_number(first)


def operate(op: int, value: float, *operands: float) -> float:
    """`value`, found by an operation of `language.bytecode`, with its record if an operand has one."""
    for operand in operands:
        if isinstance(operand, Recorded):
            return operand.made(value, operand.journal.operation(op, *map(symbol_of, operands)))
    return value


def read(block: Sequence[float], value: float, x: float) -> float:
    """`value` of a table at x, with its record if x or a number of its block has one."""
    for number in (x, *block):
        if isinstance(number, Recorded):
            return number.made(value, number.journal.table(block, x))
    return value


def array_of(numbers: Iterable[object]) -> np.ndarray:
    """An array of numbers (nested as they are); of objects if any of them is recorded."""
    if {float, int}.issuperset(map(type, numbers := list(numbers))):
        return np.array(numbers, dtype=float)
    array = np.array(numbers, dtype=object)
    recorded = any(isinstance(x, Recorded) for x in array.ravel())
    return array if recorded else array.astype(float)
