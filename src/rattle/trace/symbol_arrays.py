"""What recorded functions over NumPy arrays find in place of NumPy: columns and tables of symbols."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from types import SimpleNamespace

import numpy as np

from rattle.language.recorded import Operand
from rattle.trace.graph import Graph, Symbol, fold, select


class Column:
    """A few numbers or symbols side by side, for functions over arrays: NumPy asks comparisons for truth values."""

    def __init__(self, values: Iterable[Operand]) -> None:
        self.values = list(values)

    @staticmethod
    def each(function: Callable[..., Operand], *columns: Column | Operand) -> Column:
        """A function element by element; numbers stand for columns of them."""
        count = max((len(x.values) for x in columns if isinstance(x, Column)), default=1)
        spread = [x.values * (count // len(x.values)) if isinstance(x, Column) else [x] * count for x in columns]
        return Column(function(*row) for row in zip(*spread, strict=True))

    @property
    def shape(self) -> tuple[int]:
        """How many there are."""
        return (len(self.values),)

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, part: int | slice) -> Column | Operand:
        return Column(self.values[part]) if isinstance(part, slice) else self.values[part]

    def __setitem__(self, place: int, value: Operand) -> None:
        self.values[place] = value

    def clip(self, low: float, high: float) -> Column:
        """Values outside of the bounds become the bounds."""
        return self.each(lambda x: select(x < low, low, select(x > high, high, x)), self)

    def __neg__(self) -> Column:
        return self.each(operator.neg, self)

    def __abs__(self) -> Column:
        return self.each(abs, self)

    def __add__(self, other: Column | Operand) -> Column:
        return self.each(operator.add, self, other)

    def __radd__(self, other: Column | Operand) -> Column:
        return self.each(operator.add, other, self)

    def __sub__(self, other: Column | Operand) -> Column:
        return self.each(operator.sub, self, other)

    def __mul__(self, other: Column | Operand) -> Column:
        return self.each(operator.mul, self, other)

    def __rmul__(self, other: Column | Operand) -> Column:
        return self.each(operator.mul, other, self)

    def __rsub__(self, other: Column | Operand) -> Column:
        return self.each(operator.sub, other, self)

    def __truediv__(self, other: Column | Operand) -> Column:
        return self.each(_quotient, self, other)

    def __rtruediv__(self, other: Column | Operand) -> Column:
        return self.each(_quotient, other, self)

    def __pow__(self, other: int) -> Column:
        return self.each(lambda x: x**other, self)

    def __lt__(self, other: Column | Operand) -> Column:
        return self.each(operator.lt, self, other)

    def __gt__(self, other: Column | Operand) -> Column:
        return self.each(operator.gt, self, other)


def _quotient(a: Operand, b: Operand) -> Operand:
    return a / b if isinstance(a, Symbol) or isinstance(b, Symbol) else fold("div", a, b)


class Table:
    """Rows of numbers or symbols, of which columns are taken as of an array."""

    def __init__(self, rows: Sequence[Sequence[Operand]]) -> None:
        self.rows = rows

    def __getitem__(self, part: tuple[slice, int | slice]) -> Column | SimpleNamespace:
        everything, columns = part
        assert everything == slice(None)
        if isinstance(columns, slice):
            width = range(len(self.rows[0]))[columns]
            return SimpleNamespace(T=[self[:, c] for c in width])
        return Column(row[columns] for row in self.rows)

    def take(self, columns: Sequence[int], axis: int) -> Taken:
        """Some columns, in this order."""
        assert axis == 1
        return Taken([[row[c] for row in self.rows] for c in columns])


class Taken:
    """Columns of numbers or symbols, which can be replaced as in an array, and are gone through one by one."""

    def __init__(self, columns: list[list[Operand]]) -> None:
        self.columns = columns

    def __setitem__(self, place: tuple[slice, int], values: Column) -> None:
        everything, column = place
        assert everything == slice(None)
        self.columns[column] = values.values

    def __iter__(self) -> Iterator[list[Operand]]:
        return iter(self.columns)


def arrays(graph: Graph) -> SimpleNamespace:
    """What functions over columns of symbols find under the name of NumPy."""

    def each(op: str) -> Callable[..., Column]:
        return lambda *columns: Column.each(lambda *row: graph.apply(op, *row), *columns)

    def chosen(a: Operand, b: Operand, first: Operand) -> Operand:  # as NumPy: nan if one of them is
        return select(first | (a != a), a, b) if isinstance(first, Symbol) else a if first or a != a else b

    return SimpleNamespace(
        arcsin=each("asin"), exp=each("exp"), clip=lambda x, low, high: x.clip(low, high), pi=math.pi,
        hypot=each("hypot"), cos=each("cos"), sin=each("sin"), arctan2=each("atan2"), copysign=each("copysign"),
        abs=lambda x: Column.each(abs, x), where=lambda *columns: Column.each(select, *columns),
        minimum=lambda *columns: Column.each(lambda a, b: chosen(a, b, a <= b), *columns),
        maximum=lambda *columns: Column.each(lambda a, b: chosen(a, b, a >= b), *columns),
        zeros_like=lambda x: Column([0.0] * len(x.values)), empty=lambda n: Column([0.0] * n),
        ones=lambda n: Column([1.0] * n), full=lambda n, value: Column([value] * n), array=lambda x: x, nan=math.nan,
        errstate=np.errstate, ndarray=np.ndarray,
    )  # fmt: skip
