"""Calls of machine code by address, as Numba writes them.

A function with fixed types is in memory once, and others call it by its address, with Numba's calling convention:
exceptions are passed on to the caller.  The address is read from a named place, see `machine`, or from a table of
kernels.  A tuple of first-class functions as argument would cost 60 us per function and call to unbox (Numba 0.68);
an address in an integer array costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.registry import cpu_target
from numba.core.typing.templates import ConcreteTemplate
from numba.extending import lower_builtin, type_callable

from rattle.jit import machine
from rattle.jit.compiling.numba_types import WHOLE_NUMBER, ArrayTypes, signature

# Numba has no types: its classes and decorators are unknown
# mypy: disable-error-code="untyped-decorator, misc"


def address(dispatcher: Any) -> int:
    """Address of a function compiled for one signature."""
    result = dispatcher.get_compile_result(dispatcher.nopython_signatures[0])
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


def by_place(name: str, letters: Sequence[str], arrays: ArrayTypes) -> Any:
    """Numba's type of a function that calls the one whose place has this name, see `machine`."""
    wanted = signature(letters, arrays)

    def call() -> None:
        """The key under which Numba finds the code of the call."""

    def jump(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        place = builder.module.globals.get(name) or ir.GlobalVariable(builder.module, WHOLE_NUMBER, name)
        return _jump_to(context, builder, _found(context, builder, place), wanted, args, fails=True)

    template = type(name, (ConcreteTemplate,), {"key": call, "cases": [wanted], "unsafe_casting": False})
    cpu_target.target_context.insert_func_defn([(jump, call, wanted.args)])
    return types.Function(template)


def _found(context: Any, builder: Any, place: Any) -> Any:
    """The address at a place; it is requested if there is none yet."""
    known, before = builder.load(place), builder.block
    with cgutils.if_unlikely(builder, builder.icmp_unsigned("==", known, WHOLE_NUMBER(0))):
        asked = ir.FunctionType(WHOLE_NUMBER, [WHOLE_NUMBER])
        find = cgutils.get_or_insert_function(builder.module, asked, machine.FIND)
        made = builder.call(find, [builder.ptrtoint(place, WHOLE_NUMBER)])
        with cgutils.if_unlikely(builder, builder.icmp_unsigned("==", made, WHOLE_NUMBER(0))):
            context.call_conv.return_user_exc(builder, machine.NotMade, ())
        after = builder.block
    address = builder.phi(WHOLE_NUMBER)
    address.add_incoming(known, before)
    address.add_incoming(made, after)
    return address


def _jump_to(context: Any, builder: Any, address: Any, wanted: Any, args: Sequence[Any], fails: bool) -> Any:
    """Call the function at an address; its exceptions are passed on, or ignored if `fails` is false."""
    convention = context.call_conv
    pointer = convention.get_function_type(wanted.return_type, wanted.args).as_pointer()
    target = builder.inttoptr(address, pointer)
    status, result = convention.call_function(builder, target, wanted.return_type, wanted.args, args)
    if fails:
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
    return context.get_dummy_value() if wanted.return_type == types.void else result


def teach(call: Callable[..., Any], family: str, letters: Sequence[str], arrays: ArrayTypes, by_place: bool) -> None:
    """Teach Numba that `call(address, arguments)` calls the kernel of a family at an address from its table.

    by_place: the table holds places of addresses, see `machine`, and exceptions of the kernel are passed on; otherwise
    they are ignored, as with a law of the user.  An address of zero raises RuntimeError.
    """
    wanted = signature(letters, arrays)

    @type_callable(call)
    def result(context: Any) -> Any:
        return lambda address, arguments: wanted.return_type

    @lower_builtin(call, types.Integer, types.BaseTuple)
    def jump(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        packed = sig.args[1]
        parts = [
            context.cast(builder, builder.extract_value(args[1], n), packed[n], want)
            for n, want in enumerate(wanted.args)
        ]
        address = args[0]
        if by_place:
            address = _found(context, builder, builder.inttoptr(address, WHOLE_NUMBER.as_pointer()))
        else:
            with cgutils.if_unlikely(builder, builder.icmp_unsigned("==", address, WHOLE_NUMBER(0))):
                said = f"a kernel of the family '{family}' was called, but it is not in the table of this workspace"
                context.call_conv.return_user_exc(builder, RuntimeError, (said,))
        return _jump_to(context, builder, address, wanted, parts, fails=by_place)
