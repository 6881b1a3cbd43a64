"""Columns of the arrays of a run: each is declared once, as `NAME = column(array, unit, meaning)`, in order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self


class Column(int):
    """The number of a column, which kernels take for a constant; with its unit and meaning."""

    unit: str
    meaning: str

    def __new__(cls, number: int, unit: str, meaning: str) -> Self:
        new = super().__new__(cls, number)
        new.unit, new.meaning = unit, meaning
        return new

    def __reduce__(self) -> tuple[type, tuple[int]]:
        return int, (int(self),)  # elsewhere it is a number


COLUMNS: dict[str, dict[str, Column]] = {}  # array -> name -> column, in order; once `layout` is imported
_declared: dict[str, list[Column]] = {}


def column(array: str, unit: str, meaning: str) -> Column:
    """The next column of an array."""
    declared = _declared.setdefault(array, [])
    declared.append(Column(len(declared), unit, meaning))
    return declared[-1]


def share(array: str, *columns: Column) -> None:
    """The next columns of an array are those of another one."""
    _declared.setdefault(array, []).extend(columns)


def name_columns(module: Mapping[str, object]) -> None:
    """Enter all columns into COLUMNS under the names that they have in a module."""
    names = {id(value): name for name, value in module.items() if isinstance(value, Column)}
    for array, columns in _declared.items():
        COLUMNS[array] = {names[id(declared)]: declared for declared in columns}


def width(array: str) -> int:
    """Number of columns of an array."""
    return len(_declared[array])
