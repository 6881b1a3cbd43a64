"""Kinds of values in kernels, how LLVM holds them, and conversions between them.

A kind is a letter or two: `f` float64, `i` int64, `b` truth, `h` workspace, `f1` `f2` `i1` `i2` C-contiguous arrays
with one or two dimensions; `""` is no value; a tuple of kinds is a tuple of values.  LLVM holds a value in *parts*: a
number in one, an array in the address of its first number and its length (with two dimensions: number of rows, length
of a row), a tuple in the parts of its members.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from types import FunctionType
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from rattle.jit.families import Kind

NOTHING = ""
PARTS: dict[str, tuple[str, ...]] = {
    NOTHING: (), "f": ("double",), "i": ("i64",), "b": ("i1",), "h": ("ptr",),
    "f1": ("ptr", "i64"), "i1": ("ptr", "i64"), "f2": ("ptr", "i64", "i64"), "i2": ("ptr", "i64", "i64"),
}  # fmt: skip
NUMBERS = "bif"  # each is converted to those after it where two meet
WORDS = {
    NOTHING: "nothing", "f": "a float", "i": "an integer", "b": "a truth value", "h": "a workspace",
    "f1": "a vector", "f2": "a matrix", "i1": "a vector of integers", "i2": "a matrix of integers",
}  # fmt: skip


class Record(tuple["Kind", ...]):
    """The kind of a named tuple: those of its members, and their names."""

    names: tuple[str, ...]

    def __new__(cls, kinds: Sequence[Kind], names: Sequence[str]) -> Record:
        """Kinds and names in the same order."""
        if len(kinds) != len(names):
            raise TranslationError(f"{len(names)} fields are expected ({', '.join(names)}), {len(kinds)} are given")
        record = super().__new__(cls, kinds)
        record.names = tuple(names)
        return record

    def __eq__(self, other: object) -> bool:
        return tuple.__eq__(self, other) is True and self.names == getattr(other, "names", None)

    def __hash__(self) -> int:
        return hash((tuple(self), self.names))


class TranslationError(TypeError):
    """A function uses something that kernels cannot use; the message says what, and where."""


class Value(NamedTuple):
    """A value of known kind, by the names of its parts in LLVM's text.

    thing: what it is if that is known while translating: a number, a function, a module.
    """

    kind: Kind
    parts: tuple[str, ...] = ()
    thing: Any = None


def parts_of(kind: Kind) -> list[str]:
    """LLVM's types of the parts of a kind."""
    if isinstance(kind, tuple):
        return [part for member in kind for part in parts_of(member)]
    return list(PARTS[kind])


def said(kind: Kind) -> str:
    """A kind in words."""
    return f"({', '.join(said(part) for part in kind)})" if isinstance(kind, tuple) else WORDS[kind]


def is_number(kind: Kind) -> TypeGuard[str]:
    """True for a float, an integer or a truth value."""
    return kind in ("b", "i", "f")


def is_array(kind: Kind) -> TypeGuard[str]:
    """True for an array."""
    return isinstance(kind, str) and len(kind) == 2


def joined(kind: Kind, other: Kind) -> Kind:
    """The kind to which both can be converted.  Raises TranslationError if there is none."""
    if kind == other:
        return kind
    if is_number(kind) and is_number(other):
        return max(kind, other, key=NUMBERS.index)
    if isinstance(kind, tuple) and isinstance(other, tuple) and len(kind) == len(other):
        return tuple(joined(a, b) for a, b in zip(kind, other, strict=True))
    raise TranslationError(f"a value is {said(kind)} in one place and {said(other)} in another")


def members(value: Value) -> list[Value]:
    """The members of a tuple."""
    values, first = [], 0
    for kind in value.kind:
        last = first + len(parts_of(kind))
        values.append(Value(kind, value.parts[first:last]))
        first = last
    return values


def number(x: float) -> str:
    """LLVM's text of a float."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"


def known(thing: object) -> Value | None:
    """The value of a number that is known while translating; None for anything else."""
    if isinstance(thing, bool | np.bool_):
        return Value("b", ("true" if thing else "false",), bool(thing))
    if isinstance(thing, int | np.integer) and -(2**63) <= int(thing) < 2**63:
        return Value("i", (str(int(thing)),), int(thing))
    if isinstance(thing, float | np.floating):
        return Value("f", (number(float(thing)),), float(thing))
    return None


def kinds_given(args: Sequence[object]) -> tuple[Kind, ...] | None:
    """The kinds of arguments from Python; None if one is of no kind."""
    kinds = []
    for argument in args:
        value = known(argument)
        if value is not None:
            kinds.append("i" if value.kind == "b" else value.kind)
        elif isinstance(argument, np.ndarray) and argument.ndim in (1, 2) and argument.dtype in (np.float64, np.int64):
            kinds.append(f"{'f' if argument.dtype == np.float64 else 'i'}{argument.ndim}")
        elif hasattr(argument, "address"):
            kinds.append("h")
        else:
            return None
    return tuple(kinds)


def python_function(called: Any) -> FunctionType | None:
    """The Python function of a user that is called, also within one of Numba's; None for anything else."""
    inside = getattr(called, "py_func", called)
    foreign = isinstance(inside, FunctionType) and not _OURS.match(inside.__module__ or "")
    return inside if foreign else None


_OURS = re.compile(
    r"(numpy|scipy)\b|rattle\.(?!jit\.translation\.library)"
)  # kernels call those that are compiled functions
