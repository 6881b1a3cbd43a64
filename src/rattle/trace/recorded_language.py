"""Copies of kernels that take symbols, and what the operations of expressions are in a graph.

A rule of an operation (`rattle.language.operation`) is recorded as it stands.  Only those that branch on values, to
keep Python from raising, have a counterpart here: the operation of the graph that their record names.
"""

from __future__ import annotations

import builtins
import math
from collections.abc import Mapping, Sequence
from types import CodeType, FunctionType, SimpleNamespace
from typing import Any

import numpy as np

from rattle.jit import choices
from rattle.jit.functions import KernelFunction
from rattle.language import arithmetic, jets
from rattle.language import bytecode as code
from rattle.language.recorded import Operand, Recorded, symbol_of
from rattle.trace.graph import FUNCTIONS, Symbol, apply, select
from rattle.trace.recorded_table import recorded_table
from rattle.trace.symbol_arrays import Column
from rattle.value_types import Plain


class Copies:
    """Copies of plain Python functions in which other functions stand for some that they call."""

    def __init__(self, own: Mapping[Plain, Plain] | None = None, arrays: object = np) -> None:
        """own: what stands for functions besides those of expressions; arrays: for NumPy."""
        self._copies: dict[Plain, Plain] = {choices.select.python: select, **LANGUAGE, **(own or {})}
        self._arrays = arrays

    def replace(self, function: Plain, own: Plain) -> None:
        """Let another function stand for one; before anything that calls it is copied."""
        self._copies[function] = own

    def of(self, function: Plain) -> Plain:
        """The copy of a function."""
        copy = self._copies.get(function)
        if copy is None:
            assert isinstance(function, FunctionType)
            names: dict[str, object] = {"__builtins__": BUILTINS, "__name__": function.__module__}
            copy = self._copies[function] = FunctionType(
                function.__code__, names, function.__name__, function.__defaults__, function.__closure__
            )
            for name in _names(function.__code__):
                if name in function.__globals__:
                    names[name] = self._stand_in(function.__globals__[name], function.__module__)
        return copy

    def _stand_in(self, thing: object, module: str) -> object:
        if thing is math:
            return MATH
        if thing is np:
            return self._arrays
        if isinstance(thing, KernelFunction):
            return self.of(thing.python)
        if isinstance(thing, FunctionType) and (thing in self._copies or thing.__module__ == module):
            return self.of(thing)
        return thing


def _names(function: CodeType) -> set[str]:
    """Names that a function looks up, those of functions inside it included."""
    names = set(function.co_names)
    for constant in function.co_consts:
        if isinstance(constant, CodeType):
            names |= _names(constant)
    return names


# ---------------------------------------------------------------- Python's own
def _or_plain(op: str, plain: Plain) -> Plain:
    """An operation of a graph if an operand is a symbol, of numbers the plain function."""

    def call(*operands: Operand) -> Operand:
        recorded = any(isinstance(x, Symbol | Recorded) for x in operands)
        return apply(op, *operands) if recorded else plain(*operands)

    return call


def _as_it_is(x: Operand | Column) -> Operand | Column:
    if isinstance(x, Recorded):  # of a model, among columns of symbols
        return Column([symbol_of(x)])
    return x if isinstance(x, Symbol | Column) else float(x)


def _smaller(*operands: Any) -> Any:
    if not any(isinstance(x, Symbol) for x in operands):
        return min(*operands)
    a, b = operands
    return select(b < a, b, a)  # as Python and the machine: the first where they are equal or one is nan


def _larger(*operands: Any) -> Any:
    if not any(isinstance(x, Symbol) for x in operands):
        return max(*operands)
    a, b = operands
    return select(b > a, b, a)


MATH = SimpleNamespace(**{name: getattr(math, name) for name in dir(math)})
for _name in (*FUNCTIONS, "sqrt", "floor"):
    if hasattr(math, _name):
        setattr(MATH, _name, _or_plain(_name, getattr(math, _name)))
BUILTINS = {**vars(builtins), "float": _as_it_is, "min": _smaller, "max": _larger}


# ---------------------------------------------------------------- the language of expressions
def _chosen(condition: Operand, yes: Operand, no: Operand) -> Operand:
    plain = not isinstance(condition, Symbol)
    return code.chosen.python(condition, yes, no) if plain else select(condition > 0.0, yes, no)


def _choose_jet(stack: list[Operand], top: int) -> None:
    if not isinstance(stack[top], Symbol):
        jets.choose_jet.python(stack, top)
        return
    holds = stack[top] > 0.0
    for n in range(3):
        stack[top + n] = select(holds, stack[top + 3 + n], stack[top + 6 + n])


def _read_table(
    table: Sequence[Operand], k: int, side: int, x: Operand, dx: Operand, ddx: Operand
) -> tuple[Operand, Operand, Operand]:
    return recorded_table(table, k, x)


def _heading(s: Operand, ds: Operand, dds: Operand) -> int:
    if any(isinstance(x, Symbol) for x in (s, ds, dds)):
        return 0  # the values of the definition: where s = 0 itself counts, runs are left to the generic kernels
    return int(arithmetic.heading.python(s, ds, dds))


LANGUAGE: Mapping[Plain, Plain] = {
    **{x.value.python: _or_plain(x.recorded, x.value.python) for x in code.RECORDS.values() if x.recorded},
    arithmetic.whole.python: _or_plain("floor", arithmetic.whole.python),
    arithmetic.heading.python: _heading, code.chosen.python: _chosen, code.read_table.python: _read_table,
    jets.choose_jet.python: _choose_jet,
}  # fmt: skip
