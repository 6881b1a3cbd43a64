"""Types for Numba: types of arguments, and the workspace.

Only Numba's documented extension interface is used, and nothing is registered for types that are not ours.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)

# Numba has no types: its classes and decorators are unknown
# mypy: disable-error-code="untyped-decorator, misc"

ArrayTypes = Mapping[str, Any]  # "f2" and so on, see `Array` in `workspace`, and Numba's type
OPTIONS = {"nogil": True, "error_model": "numpy"}
WHOLE_NUMBER = ir.IntType(64)
ELEMENTS = {"f": types.float64, "i": types.int64}
ARRAY_LETTERS = {"v": "f1", "m": "f2", "n": "i2"}
ORDINARY = {f"{e}{n}": types.Array(kind, n, "C") for e, kind in ELEMENTS.items() for n in (1, 2)}


class WorkspaceType(types.Type):
    """Numba's type of a workspace: the address of a table with address and shape of every array of a run."""

    def __init__(self) -> None:
        super().__init__("Workspace")


WORKSPACE = WorkspaceType()


@register_model(WorkspaceType)
class _WorkspaceModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, WHOLE_NUMBER.as_pointer())


@unbox(WorkspaceType)
def _from_python(kind: Any, value: Any, c: Any) -> Any:
    number = c.pyapi.object_getattr_string(value, "address")
    address = c.pyapi.long_as_longlong(number)
    c.pyapi.decref(number)
    return NativeValue(c.builder.inttoptr(address, WHOLE_NUMBER.as_pointer()), c.pyapi.c_api_error())


def signature(letters: Sequence[str], arrays: ArrayTypes = ORDINARY) -> Any:
    """Numba's signature for a result and arguments, one letter each.  A result of several letters is a tuple."""
    known = {"void": types.void, "h": WORKSPACE, **ELEMENTS}
    known |= {letter: arrays[kind] for letter, kind in ARRAY_LETTERS.items()}
    result, *arguments = letters
    several = len(result) > 1 and result != "void"
    found = types.BaseTuple.from_types([known[one] for one in result]) if several else known[result]
    return found(*(known[one] for one in arguments))


def teach_workspace(handle: type, fields: Mapping[str, str], arrays: ArrayTypes) -> None:
    """Teach Numba that `m.name` is the array whose address and shape are in the row of that name of a workspace.

    handle: class of the object passed from Python.  fields: kind of every array, "f2" and so on.
    """
    place = {name: 3 * n for n, name in enumerate(fields)}
    typeof_impl.register(handle)(lambda value, context: WORKSPACE)

    @infer_getattr
    class Attributes(AttributeTemplate):
        key = WorkspaceType

        def generic_resolve(self, kind: Any, name: str) -> Any:
            return arrays[fields[name]] if name in fields else None

    @lower_getattr_generic(WorkspaceType)
    def array(context: Any, builder: Any, kind: Any, first: Any, name: str) -> Any:
        kind = arrays[fields[name]]
        address, *shape = (
            builder.load(builder.gep(first, [WHOLE_NUMBER(place[name] + n)])) for n in range(1 + kind.ndim)
        )
        size = WHOLE_NUMBER(8)
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


def users_law(law: Callable[..., Any], count: int) -> tuple[Any, Any]:
    """The user's function, compiled, and a function that takes its `count` values from parameters: (p, k) -> tuple."""
    if not isinstance(law, numba.core.dispatcher.Dispatcher):
        law = numba.njit(**OPTIONS)(law)
    values = "".join(f"p[k + {n}], " for n in range(count))
    space: dict[str, Any] = {}
    exec(f"def part(p, k): return ({values})", space)
    return law, numba.njit(**OPTIONS)(space["part"])
