"""Machine code in this process: loading it, calling it from Python, and calls between functions.

A *native* function has fixed types.  It is compiled, or read from the cache, when it is first called, and is in memory
once.  Machine code that calls it contains no copy of it: it reads its address from a *place*, eight bytes known to the
linker by name, and requests it while there is none.  So a run compiles and reads only the functions that it calls.

All machine code is called in the same way: with the place of the result, then the arguments, see
`translation.statements`; it returns 0, or 1 if it failed.  What has failed is kept as an exception of this thread.
"""

from __future__ import annotations

import builtins
import ctypes
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np

from rattle.jit.address import address_of
from rattle.jit.families import Kind
from rattle.value_types import Plain

FIND = "rattle.find"  # symbol of the function that provides a missing address
FAULT = "rattle.fault"  # symbol of the function that machine code tells of an error
_makers: dict[int, Callable[[], int]] = {}  # by place
_raised = threading.local()


class Code(NamedTuple):
    """Machine code of one function: its symbol, the object file, and the symbols that it needs from others."""

    symbol: str
    object: bytes
    needs: tuple[str, ...]


# ---------------------------------------------------------------- loading
@cache
def _engine() -> llvm.ExecutionEngine:
    """The linker of object files."""
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), new_target())


def ready() -> Any:
    """LLVM, ready to make code for this machine."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


def parsed(text: str) -> llvm.ModuleRef:
    """A module from LLVM's text, in a context of its own, which goes when the module goes."""
    if ready().llvm_version_info[0] < 17:  # has pointers with types too, and llvmlite would take these
        context = llvm.context.ContextRef(llvm.ffi.lib.LLVMPY_ContextCreate(True))
    else:
        context = llvm.create_context()
    return llvm.parse_assembly(text, context)


def new_target() -> llvm.TargetMachine:
    """The processor and system for which machine code is made; each engine takes possession of one."""
    ready()
    triple, name, features = processor()
    target = llvm.Target.from_triple(triple)
    return target.create_target_machine(cpu=name, features=features, opt=1, reloc="default", codemodel="jitdefault")


@cache
def processor() -> tuple[str, str, str]:
    """The target of machine code: triple, processor, its features."""
    return llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def load(code: Code) -> int:
    """Load a function into memory; returns its address.  Raises LookupError if a symbol that it needs is unknown."""
    engine = _engine()  # which also makes the functions of the process known
    for name in code.needs:  # with an unknown symbol the linker would end the process
        if llvm.address_of_symbol(name) is None:
            raise LookupError(f"{code.symbol} needs {name}")
    engine.add_object_file(llvm.ObjectFileRef.from_data(code.object))
    engine.finalize_object()
    return int(engine.get_function_address(code.symbol))


@cache
def target() -> llvm.TargetMachine:
    """The same for all modules that are compiled here."""
    return new_target()


# ---------------------------------------------------------------- places
def announce(name: str, make: Callable[[], int]) -> ctypes.c_int64:
    """A new place, known to the linker by name; `make` returns the address for it."""
    place = ctypes.c_int64(0)
    at = ctypes.addressof(place)
    _makers[at] = make
    llvm.add_symbol(name, at)
    return place  # to be kept alive


def where(place: ctypes.c_int64) -> int:
    """Address of a place."""
    return ctypes.addressof(place)


def _find(at: int) -> int:
    try:
        address = _makers[at]()
        ctypes.c_int64.from_address(at).value = address
        return address
    except BaseException as error:  # no exception may pass through machine code, not even Ctrl-C
        _raised.error = error
        return _address(_FAILED)


def _fault(told: bytes) -> None:
    kind, _, words = told.decode().partition(": ")
    _raised.error = getattr(builtins, kind)(words)


def _address(function: Any) -> int:
    return int(ctypes.cast(function, ctypes.c_void_p).value or 0)


_FIND = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)(_find)
_FAULT = ctypes.CFUNCTYPE(None, ctypes.c_char_p)(_fault)
_TRAP = ctypes.CFUNCTYPE(ctypes.c_int32)  # whatever the arguments are: who calls removes them
_FAILED = _TRAP(lambda: 1)
llvm.add_symbol(FIND, _address(_FIND))
llvm.add_symbol(FAULT, _address(_FAULT))
_kept: list[object] = []  # machine code may call these until the end


@cache
def trap(words: str) -> int:
    """Address of a function that fails with a RuntimeError, whatever its arguments are."""

    def stop() -> int:
        _raised.error = RuntimeError(words)
        return 1

    entry = _TRAP(stop)
    keep(entry)
    return _address(entry)


def reason() -> BaseException:
    """The exception with which machine code of this thread has failed; KeyboardInterrupt if none was recorded."""
    error = getattr(_raised, "error", None) or KeyboardInterrupt()
    _raised.error = None
    return error


# ---------------------------------------------------------------- functions of others
@dataclass(frozen=True)
class Entry:
    """A function from outside that kernels call: its address, and letters of result and arguments."""

    address: int
    letters: tuple[Kind, ...]  # the result as a kind, see `translation.values`


def keep(thing: object) -> None:
    """Keep something that machine code may call until the end."""
    _kept.append(thing)


def python_entry(function: Callable[..., Sequence[float]], result: Kind, count: int) -> Entry:
    """A Python function of floats that returns several; an exception of it is what the call fails with.

    result: kind of the result: "f" or a tuple of such.  count: of the arguments.
    """
    numbers = ctypes.c_double * _count(result)

    def call(place: int, *operands: float) -> int:
        try:
            numbers.from_address(place)[:] = list(function(*operands))
            return 0
        except BaseException as error:
            _raised.error = error
            return 1

    kind = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, *[ctypes.c_double] * count)
    entry = kind(call)
    keep(entry)
    return Entry(_address(entry), (result, *"f" * count))


def _count(kind: Kind) -> int:
    return sum(map(_count, kind)) if isinstance(kind, tuple) else 1


# ---------------------------------------------------------------- calls from Python
RESULTS: dict[str, Any] = {
    "void": ctypes.c_void_p,
    "i": ctypes.c_int64,
    "f": ctypes.c_double,
    "b": ctypes.c_bool,
    "h": ctypes.c_void_p,
}
ARRAYS = {
    "v": (np.dtype(np.float64), 1),
    "m": (np.dtype(np.float64), 2),
    "w": (np.dtype(np.int64), 1),
    "n": (np.dtype(np.int64), 2),
}


def caller(name: str, address: int, letters: Sequence[str]) -> Plain:
    """A Python function that calls the one at this address.

    letters: result and arguments.  It raises TypeError for an array that is not contiguous or of another type.
    """
    result, *kinds = letters
    types: list[Any] = [ctypes.c_void_p]
    for kind in kinds:
        types += [ctypes.c_void_p, *[ctypes.c_int64] * ARRAYS[kind][1]] if kind in ARRAYS else [RESULTS[kind]]
    target = ctypes.CFUNCTYPE(ctypes.c_int32, *types)(address)
    room, several = _room(result), range(len(result)) if len(result) > 1 and result != "void" else None
    wanted = [(kind, *ARRAYS.get(kind, (None, 0))) for kind in kinds]

    def call(*args: Any) -> Any:  # in one piece: a function for each argument would take as long as a short kernel
        if len(args) != len(wanted):
            raise TypeError(f"{name} takes {len(wanted)} arguments, got {len(args)}")
        flat: list[object] = []
        for (kind, numbers, dimensions), argument in zip(wanted, args, strict=True):
            if dimensions:
                if argument.dtype != numbers or argument.ndim != dimensions or not argument.flags.c_contiguous:
                    steps = f"{argument.dtype}, {argument.shape} with steps of {argument.strides} bytes"
                    raise TypeError(f"{name} takes a contiguous array of {ARRAYS[kind]}, got {steps}")
                flat += (address_of(argument), *argument.shape)
            elif kind == "f":
                flat.append(float(argument))
            elif kind == "i":
                flat.append(int(argument))
                if flat[len(flat) - 1] != argument:
                    raise TypeError(f"{name} takes a whole number, got {argument}")
            else:
                if (place := getattr(argument, "address", None)) is None:
                    raise TypeError(f"{name} takes a workspace, got {type(argument).__name__}")
                flat.append(place)
        answer = room()
        if target(ctypes.addressof(answer), *flat):
            raise reason()
        if several is not None:
            return tuple([getattr(answer, f"_{n}") for n in several])
        return None if result == "void" else answer.value

    call.__name__ = name
    return call


def _room(result: str) -> Any:
    """A ctypes type that holds a result."""
    if result in RESULTS:
        return RESULTS[result]
    fields = [(f"_{n}", RESULTS[letter]) for n, letter in enumerate(result)]
    return type("Several", (ctypes.Structure,), {"_fields_": fields})
