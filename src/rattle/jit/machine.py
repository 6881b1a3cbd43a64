"""Machine code in this process: loading it, calling it from Python, and calls between functions.

A *native* function has fixed types.  It is compiled, or read from the cache, when it is first called, and is in memory
once.  Machine code that calls it contains no copy of it: it reads its address from a *place*, eight bytes known to the
linker by name, and requests it while there is none.  So a run compiles and reads only the functions that it calls.
Code in the cache runs without Numba, whose import and start take longer than a short run.
"""

from __future__ import annotations

import builtins
import ctypes
import pickle
import struct
import threading
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np

from rattle.jit.address import address_of

FIND = "rattle.find"  # symbol of the function that provides a missing address
FAULT = "rattle.fault"  # symbol of the function that machine code tells of an error
FINE = (0, -2)  # a function has returned a value, or None (numba.core.callconv)
_makers: dict[int, Callable[[], int]] = {}  # by place
_raised = threading.local()


class Code(NamedTuple):
    """Machine code of one function: its symbol, the object file, and the symbols that it needs from others."""

    symbol: str
    object: bytes
    needs: tuple[str, ...]


class NotMade(RuntimeError):
    """Machine code could not call a native function; `reason` returns the exception that caused it."""


# ---------------------------------------------------------------- loading
@cache
def _engine() -> Any:
    """The linker of object files."""
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), new_target())


def ready() -> Any:
    """LLVM, ready to make code for this machine."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


def parsed(text: str) -> Any:
    """A module from LLVM's text, in a context of its own, which goes when the module goes."""
    if ready().llvm_version_info[0] < 17:  # has pointers with types too, and llvmlite would take these
        context = llvm.context.ContextRef(llvm.ffi.lib.LLVMPY_ContextCreate(True))
    else:
        context = llvm.create_context()
    return llvm.parse_assembly(text, context)


def new_target() -> Any:
    """The processor and system for which machine code is made; each engine takes possession of one."""
    ready()
    triple, name, features = processor()
    one = llvm.Target.from_triple(triple)
    return one.create_target_machine(cpu=name, features=features, opt=2, reloc="default", codemodel="jitdefault")


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
def target() -> Any:
    """The same for all modules that are compiled here."""
    return new_target()


# ---------------------------------------------------------------- places
def announce(name: str, make: Callable[[], int]) -> Any:
    """A new place, known to the linker by name; `make` returns the address for it."""
    place = ctypes.c_int64(0)
    at = ctypes.addressof(place)
    _makers[at] = make
    llvm.add_symbol(name, at)
    return place  # to be kept alive


def where(place: Any) -> int:
    """Address of a place."""
    return ctypes.addressof(place)


def _find(at: int) -> int:
    try:
        address = _makers[at]()
        ctypes.c_int64.from_address(at).value = address
        return address
    except BaseException as error:  # no exception may pass through machine code, not even Ctrl-C
        _raised.error = error
        return 0


_FIND = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)(_find)
llvm.add_symbol(FIND, ctypes.cast(_FIND, ctypes.c_void_p).value)


def _fault(told: bytes) -> None:
    kind, _, words = told.decode().partition(": ")
    _raised.error = getattr(builtins, kind)(words)


_FAULT = ctypes.CFUNCTYPE(None, ctypes.c_char_p)(_fault)
llvm.add_symbol(FAULT, ctypes.cast(_FAULT, ctypes.c_void_p).value)


def reason() -> BaseException:
    """The exception raised when this thread requested a native function; KeyboardInterrupt if none was recorded."""
    error = getattr(_raised, "error", None) or KeyboardInterrupt()
    _raised.error = None
    return error


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


def caller(name: str, address: int, letters: Sequence[str]) -> Callable[..., Any]:
    """A Python function that calls the one at this address, with Numba's convention.

    letters: result and arguments.  It raises TypeError for an array that is not contiguous or of another type.
    """
    result, *kinds = letters
    types: list[Any] = [ctypes.c_void_p, ctypes.c_void_p]
    for kind in kinds:
        if kind in ARRAYS:  # owner, parent, size, bytes of an element, place, shape, strides
            types += [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p]
            types += [ctypes.c_int64] * (2 * ARRAYS[kind][1])
        else:
            types.append(RESULTS[kind])
    target = ctypes.CFUNCTYPE(ctypes.c_int32, *types)(address)
    room, read = _room(result), _reader(result)

    def call(*args: Any) -> Any:
        if len(args) != len(kinds):
            raise TypeError(f"{name} takes {len(kinds)} arguments, got {len(args)}")
        flat: list[Any] = []
        for kind, one in zip(kinds, args, strict=True):
            if kind == "f":
                flat.append(float(one))
            elif kind == "i":
                flat.append(int(one))
                if flat[len(flat) - 1] != one:
                    raise TypeError(f"{name} takes a whole number, got {one}")
            elif kind == "h":
                if (place := getattr(one, "address", None)) is None:
                    raise TypeError(f"{name} takes a workspace, got {type(one).__name__}")
                flat.append(place)
            else:
                if (one.dtype, one.ndim) != ARRAYS[kind] or not one.flags.c_contiguous:
                    raise TypeError(f"{name} takes a contiguous array of {ARRAYS[kind]}, got {one.dtype}, {one.shape}")
                flat += (None, None, one.size, 8, address_of(one), *one.shape, *one.strides)
        answer, exception = room(), ctypes.c_void_p()
        status = target(ctypes.addressof(answer), ctypes.addressof(exception), *flat)
        if status not in FINE:
            raise _error(exception)
        return read(answer)

    call.__name__ = name
    return call


PACKED = {"f": "d", "i": "q", "h": "q", "v": "qq", "w": "qq", "m": "qqq", "n": "qqq"}  # in `struct`, by letter


def packed_caller(name: str, letters: Sequence[str], code: Code) -> Callable[..., Any]:
    """A Python function that calls machine code which takes its arguments in one piece of memory.

    letters: result and arguments, which must be of these kinds.  It raises TypeError for an array that is not
    contiguous.
    """
    result, *kinds = letters
    pack = struct.Struct("=" + "".join(PACKED[kind] for kind in kinds)).pack
    pointers = ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p
    target = ctypes.CFUNCTYPE(ctypes.c_int32, *pointers)(load(code))
    room, read = _room(result), _reader(result)

    def call(*args: Any) -> Any:
        flat: list[Any] = []
        for kind, one in zip(kinds, args, strict=True):
            if kind == "h":
                flat.append(one.address)
            elif kind in ARRAYS:
                if not one.flags.c_contiguous:
                    raise TypeError(f"{name} takes contiguous arrays, got one with steps of {one.strides} bytes")
                flat += (address_of(one), *one.shape)
            else:
                flat.append(int(one) if kind == "i" else one)  # it may be a truth value
        answer, exception = room(), ctypes.c_void_p()
        status = target(ctypes.addressof(answer), ctypes.addressof(exception), pack(*flat))
        if status not in FINE:
            raise _error(exception)
        return read(answer)

    call.__name__ = name
    return call


def _reader(result: str) -> Callable[[Any], Any]:
    """What makes a Python value of a result in memory."""
    if len(result) > 1 and result != "void":
        names = [f"_{n}" for n in range(len(result))]
        return lambda answer: tuple([getattr(answer, name) for name in names])
    return (lambda answer: None) if result == "void" else lambda answer: answer.value


def checked(dispatcher: Callable[..., Any]) -> Callable[..., Any]:
    """The same function; if it could not call a native one, it raises the reason."""

    def call(*args: Any) -> Any:
        try:
            return dispatcher(*args)
        except NotMade:
            raise reason() from None

    return call


class _Raised(ctypes.Structure):
    """Numba's record of an exception: a pickle of its class and arguments, and a function for arguments known later."""

    _fields_ = (("pickle", ctypes.c_void_p), ("size", ctypes.c_int32), ("late", ctypes.c_void_p))


def _error(exception: ctypes.c_void_p) -> BaseException:
    """The exception that machine code has raised, such as IndexError with NUMBA_BOUNDSCHECK=1."""
    if exception.value:
        raised = _Raised.from_address(exception.value)
        kind, arguments, _ = pickle.loads(ctypes.string_at(raised.pickle, raised.size))
        if kind is not NotMade:
            return kind(*(arguments or ()))  # type: ignore[no-any-return]  # the class that was raised
    return reason()


def _room(result: str) -> Any:
    """A ctypes type that holds a result."""
    if result in RESULTS:
        return RESULTS[result]
    fields = [(f"_{n}", RESULTS[one]) for n, one in enumerate(result)]
    return type("Several", (ctypes.Structure,), {"_fields_": fields})
