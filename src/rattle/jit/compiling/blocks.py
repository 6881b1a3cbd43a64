"""Unowned views of contiguous arrays, as our compiled functions use them: an address and a shape.

A `Block` has the same memory layout as Numba's own array, so that conversions cost nothing.  But its elements are read
and written directly, without reference counting and without a test for negative indices, which saves a quarter of the
time to run and more of the time to compile.  So a compiled function must not count from the end of an array.  With
NUMBA_BOUNDSCHECK=1 indices are checked as in other arrays of Numba.

Importing this module changes nothing for others; `register` registers these types with Numba for the whole process.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from numba import config, types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typeconv import Conversion
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import lower_builtin, lower_cast, register_model

from rattle.jit.compiling.numba_types import ORDINARY

# Numba has no types: its classes and decorators are unknown
# mypy: disable-error-code="untyped-decorator, misc"


class Block(types.Array):
    """C-contiguous array of numbers; its memory is owned by others."""

    def __init__(self, element: Any, dimensions: int) -> None:
        super().__init__(element, dimensions, "C", name=f"Block({element}, {dimensions})")

    def can_convert_from(self, typing_context: Any, other: Any) -> Any:
        """Any contiguous array of numbers of this type can be converted."""
        return Conversion.safe if block(other) == self else None


register_model(Block)(models.ArrayModel)
BLOCKS = {name: Block(kind.dtype, kind.ndim) for name, kind in ORDINARY.items()}


def block(kind: Any) -> Any:
    """The block type for a contiguous array; any other type unchanged."""
    if isinstance(kind, types.Array) and kind.layout == "C" and kind.ndim in (1, 2):
        return Block(kind.dtype, kind.ndim)
    return kind


@lower_cast(types.Array, Block)
@lower_cast(Block, types.Array)
def _as_it_is(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return value


# ---------------------------------------------------------------- elements
def _index(array: Any, index: Any) -> Any:
    """Type of an index to a single element, otherwise None."""
    if not isinstance(array, Block) or config.BOUNDSCHECK:
        return None
    if array.ndim == 1:
        return types.intp if isinstance(index, types.Integer) else None
    two = isinstance(index, types.BaseTuple) and len(index) == 2
    return types.UniTuple(types.intp, 2) if two and all(isinstance(one, types.Integer) for one in index) else None


class _Element(AbstractTemplate):
    """Typing of access to an element; tried before Numba's own, because it is for one target only."""

    metadata = {"target": "cpu"}
    how = ""  # key of the code that does it

    def get_impl_key(self, sig: Any) -> Any:
        return self.how


class _Read(_Element):
    how = "read an element of a block"

    def generic(self, args: Any, kws: Any) -> Any:
        index = _index(*args)
        return None if index is None else signature(args[0].dtype, args[0], index)


class _Write(_Element):
    how = "write an element of a block"

    def generic(self, args: Any, kws: Any) -> Any:
        index = _index(*args[:2])
        return None if index is None else signature(types.none, args[0], index, args[0].dtype)


def _part(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    """A part of an array, taken from its value: no copy in memory that the optimiser would have to remove."""
    return builder.extract_value(value, context.data_model_manager[kind].get_field_position(name))


def _place(context: Any, builder: Any, kind: Any, value: Any, index: Any) -> Any:
    if kind.ndim == 2:
        row, column = cgutils.unpack_tuple(builder, index, 2)
        width = builder.extract_value(_part(context, builder, kind, value, "shape"), 1)
        index = builder.add(builder.mul(row, width), column)
    return builder.gep(_part(context, builder, kind, value, "data"), [index])


def _read(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.load(_place(context, builder, sig.args[0], *args))


def _write(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    builder.store(args[2], _place(context, builder, sig.args[0], *args[:2]))


# ---------------------------------------------------------------- two numbers alike
class _Alike(AbstractTemplate):
    """Arithmetic of two floats or two integers: the common case first, before Numba compares all its overloads."""

    metadata = {"target": "cpu"}
    kinds: tuple[Any, ...] = ()
    compares = False

    def generic(self, args: Any, kws: Any) -> Any:
        if len(args) != 2:
            return None
        a, b = (types.unliteral(one) for one in args)
        return signature(types.boolean if self.compares else a, a, a) if a == b and a in self.kinds else None


def _common_case(name: str, kinds: tuple[Any, ...], compares: bool) -> None:
    key = getattr(operator, name)
    infer_global(key)(type(f"_{name}", (_Alike,), {"key": key, "kinds": kinds, "compares": compares}))


class _Extreme(_Element):
    """The largest or the smallest of several floats, or of several integers."""

    def generic(self, args: Any, kws: Any) -> Any:
        kinds = {types.unliteral(one) for one in args}
        if len(args) < 2 or len(kinds) != 1 or not kinds <= {types.float64, types.int64}:
            return None
        kind = kinds.pop()
        return signature(kind, *(kind,) * len(args))


class _Max(_Extreme):
    how = "the largest"


class _Min(_Extreme):
    how = "the least"


def _extreme(relation: str) -> Callable[..., Any]:
    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        beats = builder.fcmp_ordered if sig.return_type == types.float64 else builder.icmp_signed
        found = args[0]
        for one in args[1:]:  # as Python does, also with nan
            found = builder.select(beats(relation, one, found), one, found)
        return found

    return lower


# ---------------------------------------------------------------- for the whole process
def register() -> None:
    """Register all this with Numba, which uses it from now on for everything compiled in this process."""
    infer_global(operator.getitem)(_Read)
    infer_global(operator.setitem)(_Write)
    lower_builtin(_Read.how, types.Any, types.Any)(_read)
    lower_builtin(_Write.how, types.Any, types.Any, types.Any)(_write)
    for name in ("add", "sub", "mul", "iadd", "isub", "imul"):
        _common_case(name, (types.float64, types.int64), compares=False)
    _common_case("truediv", (types.float64,), compares=False)
    for name in ("lt", "le", "gt", "ge", "eq", "ne"):
        _common_case(name, (types.float64, types.int64), compares=True)
    infer_global(max)(_Max)
    infer_global(min)(_Min)
    lower_builtin(_Max.how, types.VarArg(types.Any))(_extreme(">"))
    lower_builtin(_Min.how, types.VarArg(types.Any))(_extreme("<"))
