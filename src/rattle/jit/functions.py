"""Compiled functions: how they are compiled, kept, found and called.

Every compiled function is ordinary Python until `start()`, and remains so with RATTLE_JIT=python; see `mode`.
"""

from __future__ import annotations

import importlib
import logging
import pickle
import secrets
import threading
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from types import ModuleType
from typing import Any

import numpy as np

from rattle.jit import mode
from rattle.jit.cache import KeptFile
from rattle.jit.families import SIGNATURE
from rattle.jit.folder import cache_folder, code_folder, compiled_modules
from rattle.value_types import Ints, Plain

log = logging.getLogger("rattle")

_lock = threading.RLock()
_jit = False


IN_PYTHON = "Python"  # handle of a workspace made before `start()`: functions that get it run as plain Python


class KernelFunction:
    """A function that becomes machine code on first use after `start()`; plain Python before.

    letters: types of result and arguments, as in `SIGNATURE`.  A function that has them is *native*: compiled once and
    only when it is called, and called by others by its address.  One without takes the types of its arguments, and
    machine code that calls it contains a copy of it.
    """

    def __init__(self, function: Plain, family: str = "", letters: Sequence[str] = ()) -> None:
        self.python = function
        self.family = family
        self.letters = tuple(letters) or SIGNATURE.get(family, ())
        self.native = bool(self.letters)
        self._callers: dict[
            object, Plain
        ] = {}  # Python functions that call machine code, by types and kinds of arguments
        self._address, self._trap = 0, 0
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__
        self.__module__ = function.__module__ or "__main__"  # what `exec` has made may be of no module
        if self.native:
            _natives.append(self)

    def __call__(self, *args: Any) -> Any:
        if not _jit:
            return self.python(*args)
        arguments = [getattr(argument, "handle", argument) for argument in args]
        for argument in arguments:
            if argument is IN_PYTHON:
                return self.python(*args)
        if self.native:
            types = None
        else:
            types = tuple(
                [
                    (argument.dtype.char, argument.ndim) if type(argument) is np.ndarray else type(argument)
                    for argument in arguments
                ]
            )
        called = self._callers.get(types)
        if called is None:
            called = self._callers[types] = self._caller(arguments)
        return called(*arguments)

    def _caller(self, args: Sequence[object]) -> Plain:
        """The Python function that calls the machine code for arguments like these."""
        if self.native:
            of_fixed_types: Plain = _machine().caller(self.__name__, self.address, self.letters)
            return of_fixed_types
        kinds = importlib.import_module("rattle.jit.translation.values").kinds_given(args)
        with _lock:
            if kinds not in self._callers:
                machine, kept = self._kept(kinds)
                letters, address = kept.read(lambda content: (content[0], machine.load(machine.Code(*content[1])))) or (
                    None,
                    0,
                )
                if letters is None:
                    say_once("compiling kernels (once)")
                    letters, code = _translation().for_kinds(self.python, self._new_symbol, kinds)
                    address = machine.load(code)
                    kept.write(lambda: pickle.dumps((letters, tuple(code))))
                self._callers[kinds] = machine.caller(self.__name__, address, letters)
        caller: Plain = self._callers[kinds]
        return caller

    @property
    def address(self) -> int:
        """Address of the machine code of a function with fixed types."""
        if self._address == 0:
            with _lock:
                self._address = self._address or self._made()
        return self._address

    @property
    def trap(self) -> int:
        """Address of what stands for this kernel in a table whose run must not call it."""
        if self._trap == 0:
            words = f"a kernel of the family '{self.family}' was called, but it is not in the table of this workspace"
            self._trap = int(_machine().trap(f"{words}: {self.__module__}.{self.__name__}"))
        return self._trap

    def _made(self) -> int:
        """Load kept machine code into memory, or compile it and keep it on disk; returns its address."""
        machine, kept = self._kept(self.letters)
        address = kept.read(lambda code: machine.load(machine.Code(*code)))
        if not address:
            say_once("compiling kernels (once)")
            code = _translation().native(self.python, self._new_symbol, self.letters)
            address = machine.load(code)
            kept.write(lambda: pickle.dumps(tuple(code)))
        return int(address)

    def loaded(self, python: Plain) -> int:
        """Address of the machine code of a Python function with the types of this one; it is kept nowhere."""
        return int(_announced().load(_translation().native(python, self._new_symbol, self.letters)))

    def _kept(self, kinds: object) -> tuple[ModuleType, KeptFile]:
        """The module `machine`, and the file of machine code for these kinds of arguments."""
        machine = _announced()
        ours = self.__module__.startswith("rattle.")
        return machine, KeptFile(cache_folder() if ours else None, self.symbol, (kinds, machine.processor()))

    @property
    def symbol(self) -> str:
        """Name of the place that holds the address of a native function, for the linker."""
        return f"rattle.place.{self.__module__}.{self.__name__}"

    @property
    def _new_symbol(self) -> str:
        """A name that no other machine code has: functions may have the same name, or several kinds of arguments."""
        return f"{self.symbol.replace('place', 'code', 1)}.{secrets.token_hex(8)}"


def natives() -> tuple[KernelFunction, ...]:
    """All functions with fixed types."""
    for name in compiled_modules():
        importlib.import_module(name)
    return tuple(_natives)


_natives: list[KernelFunction] = []
_places: dict[KernelFunction, object] = {}  # of the first of them


def _announced() -> ModuleType:
    """The module `machine`, which knows the addresses of all native functions that machine code may call."""
    machine = _machine()
    with _lock:
        for kernel in _natives[len(_places) :]:
            _places[kernel] = machine.announce(kernel.symbol, lambda kernel=kernel: kernel.address)
    return machine


def _machine() -> ModuleType:
    return importlib.import_module("rattle.jit.machine")  # imports llvmlite


def _translation() -> ModuleType:
    return importlib.import_module("rattle.jit.translation.unit")  # imports llvmlite


def say_once(words: str) -> None:
    """Tell the user, once, that something is being compiled and not just read from the cache."""
    if not _said:
        _said.append(words)
        log.info(words)


_said: list[str] = []


def compiled(function: Plain) -> KernelFunction:
    """Decorator for a function of the compiled layer (types follow from the first call)."""
    return KernelFunction(function)


def native(*letters: str) -> Callable[[Plain], KernelFunction]:
    """Decorator for a large function, or one that not every run needs; see `KernelFunction` and SIGNATURE."""
    return lambda function: KernelFunction(function, letters=letters)


def kernel(family: str) -> Callable[[Plain], KernelFunction]:
    """Decorator for the kernel of a kind: compiled for the family's one signature."""
    return lambda function: KernelFunction(function, family)


# ---------------------------------------------------------------- for the whole process
def start() -> bool:
    """Switch from Python to machine code (no effect with RATTLE_JIT=python); True if it runs now."""
    global _jit
    if not _jit and mode.is_native():
        _jit = _works()
    return _jit


def _works() -> bool:
    """Whether LLVM does what is needed; tested once for each state of sources and version of its package."""
    folder = code_folder()
    passed = folder.path / "native-works" if folder.path is not None and folder.lasting else None
    if passed is not None and passed.exists():
        return True
    try:
        _translation().check()
    except Exception as error:  # whatever an unknown LLVM says, plain Python still works
        log.warning(f"kernels run as plain Python, some hundred times slower: {mode.give_up(error)}")
        return False
    if passed is not None:
        with suppress(OSError):
            passed.touch()
    return True


def entries(functions: Iterable[KernelFunction]) -> Ints | tuple[Plain, ...]:
    """A table of functions by number, for modules that cannot import them: places of their addresses, see `machine`."""
    if _jit:
        machine = _announced()
        return np.array([machine.where(_places[function]) for function in functions], dtype=np.int64)
    return tuple(function.python for function in functions)


def names_in_tables() -> dict[object, str]:
    """Symbols of all kernels of the package, by what stands for them in tables: place, address or Python function."""
    symbols: dict[object, str] = {}
    for kernel in natives():
        if kernel.family and kernel.__module__.startswith("rattle."):
            symbols[kernel.python] = kernel.symbol
            if kernel._address:
                symbols[kernel._address] = kernel.symbol
            if kernel in _places:
                symbols[_machine().where(_places[kernel])] = kernel.symbol
    return symbols


def jit_runs() -> bool:
    """True once compiled functions run as machine code."""
    return _jit
