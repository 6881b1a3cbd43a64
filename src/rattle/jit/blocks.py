"""Arrays as our compiled functions see them: a place in memory and a shape, with nothing around them.

A `Block` lies in memory as Numba's own array does, so that the two change into each other for nothing.  But its
elements are read and written straight away: no owner is counted, no index is looked at for a negative sign, which
saves a quarter of the time to run and more of the time to compile.  So a compiled function must not count from the
end.  With NUMBA_BOUNDSCHECK=1 indices are checked as in other arrays of Numba.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import Any

from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typeconv import Conversion
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global
from numba.extending import (
    NativeValue,
    lower_builtin,
    lower_cast,
    lower_getattr,
    lower_getattr_generic,
    register_model,
    unbox,
)

# Numba has no types: its classes and decorators are unknown
# mypy: disable-error-code="untyped-decorator, misc"


class Block(types.Array):
    """C-contiguous array of numbers that somebody else keeps alive."""

    def __init__(self, element: Any, dimensions: int) -> None:
        super().__init__(element, dimensions, "C", name=f"Block({element}, {dimensions})")

    def can_convert_from(self, typing_context: Any, other: Any) -> Any:
        """Any contiguous array of these numbers will do."""
        return Conversion.safe if block(other) == self else None


register_model(Block)(models.ArrayModel)
HANDLE = types.Array(types.int64, 3, "C")
VECTOR, MATRIX = Block(types.float64, 1), Block(types.float64, 2)
WHOLES, WHOLE_ROWS = Block(types.int64, 1), Block(types.int64, 2)


def block(kind: Any) -> Any:
    """The block for a contiguous array; any other type as it is."""
    if is_handle(kind):
        return WORKSPACE
    if isinstance(kind, types.Array) and kind.layout == "C" and kind.ndim in (1, 2):
        return Block(kind.dtype, kind.ndim)
    return kind


@lower_cast(types.Array, Block)
@lower_cast(Block, types.Array)
def _as_it_is(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return value


# ---------------------------------------------------------------- elements
def _index(array: Any, index: Any) -> Any:
    """Type of an index that names one element, else None."""
    if not isinstance(array, Block) or config.BOUNDSCHECK:
        return None
    if array.ndim == 1:
        return types.intp if isinstance(index, types.Integer) else None
    two = isinstance(index, types.BaseTuple) and len(index) == 2
    return types.UniTuple(types.intp, 2) if two and all(isinstance(one, types.Integer) for one in index) else None


class _Element(AbstractTemplate):
    """How an element is found; asked before Numba's own ways, being for one target only."""

    metadata = {"target": "cpu"}
    how = ""  # key of the code that does it

    def get_impl_key(self, sig: Any) -> Any:
        return self.how


@infer_global(operator.getitem)
class _Read(_Element):
    how = "read an element of a block"

    def generic(self, args: Any, kws: Any) -> Any:
        index = _index(*args)
        return None if index is None else signature(args[0].dtype, args[0], index)


@infer_global(operator.setitem)
class _Write(_Element):
    how = "write an element of a block"

    def generic(self, args: Any, kws: Any) -> Any:
        index = _index(*args[:2])
        return None if index is None else signature(types.none, args[0], index, args[0].dtype)


def _part(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    """A part of an array, straight from its value: no copy in memory that the optimiser would have to take away."""
    return builder.extract_value(value, context.data_model_manager[kind].get_field_position(name))


def _place(context: Any, builder: Any, kind: Any, value: Any, index: Any) -> Any:
    if kind.ndim == 2:
        row, column = cgutils.unpack_tuple(builder, index, 2)
        width = builder.extract_value(_part(context, builder, kind, value, "shape"), 1)
        index = builder.add(builder.mul(row, width), column)
    return builder.gep(_part(context, builder, kind, value, "data"), [index])


@lower_builtin(_Read.how, types.Any, types.Any)
def _read(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.load(_place(context, builder, sig.args[0], *args))


@lower_builtin(_Write.how, types.Any, types.Any, types.Any)
def _write(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    builder.store(args[2], _place(context, builder, sig.args[0], *args[:2]))


# ---------------------------------------------------------------- two numbers alike
class _Alike(AbstractTemplate):
    """Two floats, or two integers, in arithmetic: the common case first, before Numba rates all its ways."""

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


for _name in ("add", "sub", "mul", "iadd", "isub", "imul"):
    _common_case(_name, (types.float64, types.int64), compares=False)
_common_case("truediv", (types.float64,), compares=False)
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    _common_case(_name, (types.float64, types.int64), compares=True)


class _Extreme(_Element):
    """The largest or the least of several floats, or of several integers."""

    def generic(self, args: Any, kws: Any) -> Any:
        kinds = {types.unliteral(one) for one in args}
        if len(args) < 2 or len(kinds) != 1 or not kinds <= {types.float64, types.int64}:
            return None
        kind = kinds.pop()
        return signature(kind, *(kind,) * len(args))


@infer_global(max)
class _Max(_Extreme):
    how = "the largest"


@infer_global(min)
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


lower_builtin(_Max.how, types.VarArg(types.Any))(_extreme(">"))
lower_builtin(_Min.how, types.VarArg(types.Any))(_extreme("<"))


# ---------------------------------------------------------------- the workspace: arrays behind a handle
class _WorkspaceType(types.Type):
    """A place in memory at which the address and shape of every array of a run stand.

    In Python it is the only array of integers with three dimensions that there is.
    """

    def __init__(self) -> None:
        super().__init__("Workspace")

    def can_convert_from(self, typing_context: Any, other: Any) -> Any:
        """The array with the addresses will do."""
        return Conversion.safe if is_handle(other) else None


def is_handle(kind: Any) -> bool:
    """True for the type of the array with the addresses."""
    return isinstance(kind, types.Array) and kind.ndim == 3 and kind.dtype == types.int64


WORKSPACE = _WorkspaceType()


@register_model(_WorkspaceType)
class _WorkspaceModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, ir.IntType(64).as_pointer())


@lower_cast(types.Array, _WorkspaceType)
def _only_the_place(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return _part(context, builder, given, value, "data")


@unbox(_WorkspaceType)
def _from_python(kind: Any, value: Any, c: Any) -> Any:
    found = c.unbox(HANDLE, value)
    return NativeValue(_only_the_place(c.context, c.builder, HANDLE, kind, found.value), found.is_error)


def attributes(fields: Mapping[str, str]) -> None:
    """Teach Numba that `m.name` is the array whose address and shape stand in the line of that name of a workspace."""
    blocks = {"f1": VECTOR, "f2": MATRIX, "i1": WHOLES, "i2": WHOLE_ROWS}
    place = {name: 3 * n for n, name in enumerate(fields)}

    class Attributes(AttributeTemplate):
        def generic_resolve(self, kind: Any, name: str) -> Any:
            known = name in fields and (kind is WORKSPACE or is_handle(kind))
            return blocks[fields[name]] if known else None

    for key in (_WorkspaceType, types.Array):
        infer_getattr(type(f"_{key.__name__}Attributes", (Attributes,), {"key": key}))

    def array(context: Any, builder: Any, first: Any, name: str) -> Any:
        kind, whole = blocks[fields[name]], ir.IntType(64)
        address, *shape = (builder.load(builder.gep(first, [whole(place[name] + n)])) for n in range(1 + kind.ndim))
        size = whole(8)
        made, model = context.get_constant_null(kind), context.data_model_manager[kind]
        for part, value in (
            ("nitems", builder.mul(shape[0], shape[1]) if kind.ndim == 2 else shape[0]),
            ("itemsize", size),
            ("data", builder.inttoptr(address, made.type.elements[model.get_field_position("data")])),
            ("shape", cgutils.pack_array(builder, shape)),
            ("strides", cgutils.pack_array(builder, [builder.mul(one, size) for one in shape[1:]] + [size])),
        ):
            made = builder.insert_value(made, value, model.get_field_position(part))
        return made

    @lower_getattr_generic(_WorkspaceType)
    def of_workspace(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
        return array(context, builder, value, name)

    def of_handle(name: str) -> Any:  # by name: Numba has a way of its own for all other names
        def lower(context: Any, builder: Any, kind: Any, value: Any) -> Any:
            return array(context, builder, _part(context, builder, kind, value, "data"), name)

        return lower

    for name in fields:
        lower_getattr(types.Array, name)(of_handle(name))
