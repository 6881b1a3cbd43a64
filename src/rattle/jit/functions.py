"""Compiled functions: how they are compiled, kept, found and called.

Numba is imported on first use only: every compiled function is ordinary Python until `start()`, and remains so with
NUMBA_DISABLE_JIT=1.
"""

from __future__ import annotations

import importlib
import logging
import os
import pickle
import secrets
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np

from rattle.jit import compile_path
from rattle.jit.cache import CodeCache, KeptFile
from rattle.jit.families import BY_PLACE, CALLERS, SIGNATURE
from rattle.jit.folder import cache_folder, code_folder, compiled_modules, forget_folder

log = logging.getLogger("rattle")

_lock = threading.RLock()
_jit = False


IN_PYTHON = "Python"  # handle of a workspace made before `start()`: functions that get it run as plain Python


class KernelFunction:
    """A function that becomes machine code on first use after `start()`; plain Python before.

    letters: types of result and arguments, as in `SIGNATURE`.  A function that has them is *native*: compiled once and
    only when it is called, and called by others by its address.  One without takes the types of its arguments, and
    machine code that calls it contains a copy of it.
    ours: one of the kernels, which `translation` knows; a function that contains a law of the user needs Numba.

    All this is the fast way.  On the plain way, see `compile_path`, each has one Numba dispatcher for all callers.
    """

    def __init__(
        self, function: Callable[..., Any], family: str = "", ours: bool = True, letters: Sequence[str] = ()
    ) -> None:
        self.python = function
        self.family = family
        self.ours = ours
        self.letters = tuple(letters) or SIGNATURE.get(family, ())
        self.native = ours and bool(self.letters)
        self._whole: Any = None
        self._type: Any = None
        self._called: Any = None  # the Python function that calls its machine code
        self._by_types: dict[Any, Any] = {}  # the same for a function without letters, by types of arguments
        self._by_kinds: dict[Any, Any] = {}
        self._address = 0
        self._foreign = not ours  # whether only Numba can compile it
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__
        self.__module__ = function.__module__
        if self.native:
            _natives.append(self)

    def __call__(self, *args: Any) -> Any:
        if not _jit:
            return self.python(*args)
        handle = getattr(args[0], "handle", None) if args else None
        if handle is IN_PYTHON:
            return self.python(*args)
        if handle is not None:
            args = (handle, *args[1:])
        if self._called is not None:
            return self._called(*args)
        types = tuple([(one.dtype.char, one.ndim) if type(one) is np.ndarray else type(one) for one in args])
        called = self._by_types.get(types)
        if called is None:
            called = self._by_types[types] = self._caller(args)
        return called(*args)

    def _caller(self, args: Sequence[Any]) -> Callable[..., Any]:
        """The Python function that calls the machine code for arguments like these."""
        if self.native and self._fast:
            address = self.address  # which may need Numba
            if self._fast:
                self._called = _machine().caller(self.__name__, address, self.letters)
        elif self._fast:
            kinds = _translation("values").kinds_given(args)
            if kinds not in self._by_kinds:
                self._by_kinds[kinds] = self._made_for(kinds)
            if self._fast:
                found: Callable[..., Any] = self._by_kinds[kinds]
                return found
        if self._called is None:
            self._called = _machine().checked(self.dispatcher)
        called: Callable[..., Any] = self._called
        return called

    def _made_for(self, kinds: Any) -> Any:
        """The Python function that calls the machine code for arguments of these kinds; None if it needs Numba."""
        with _lock:
            if kinds in self._by_kinds:
                return self._by_kinds[kinds]
            machine = _announced()
            kept = KeptFile(cache_folder() if self._is_kept else None, self.symbol, (kinds, machine.processor()))
            called = kept.read(lambda found: machine.packed_caller(self.__name__, *found))
            if called is None:
                say_once("compiling kernels (once)")
                found = self._translated(lambda unit: unit.packed(self.python, self._new_symbol, kinds))
                if found is None:
                    return None
                called = machine.packed_caller(self.__name__, *found)
                kept.write(lambda: pickle.dumps(found))
            return called

    @property
    def _fast(self) -> bool:
        """True for a function whose machine code is made, and runs, without Numba."""
        return not self._foreign and compile_path.chosen().fast

    def _translated(self, make: Callable[[Any], Any]) -> Any:
        """What `make` returns for the module that translates; None if Numba has to compile this function."""
        try:
            return make(_translation())
        except _translation("values").TranslationError as error:
            if self._is_kept:  # one of rattle's own
                raise
            log.info(f"compiled by Numba, which takes longer: {error}")
            self._foreign = True
            return None

    @property
    def dispatcher(self) -> Any:
        """The Numba dispatcher, made at first use."""
        if self._whole is None:
            with _compiling() as compiling:
                if self._whole is None and self.ours:
                    kept = CodeCache(self.python, cache_folder) if self._is_kept else None
                    self._whole = compiling.whole(self.python, self.letters, kept)
                elif self._whole is None:
                    self._whole = compiling.foreign(self.python, self.letters)
        return self._whole

    @property
    def _is_kept(self) -> bool:
        return self.__module__.startswith("rattle.")

    @property
    def symbol(self) -> str:
        """Name of the place that holds the address of a native function, for the linker."""
        return f"rattle.place.{self.__module__}.{self.__name__}"

    @property
    def _new_symbol(self) -> str:
        """A name that no other machine code has: functions may have the same name, or several kinds of arguments."""
        return f"{self.symbol.replace('place', 'code', 1)}.{secrets.token_hex(8)}"

    @property
    def _numba_type_(self) -> Any:  # what Numba asks for when one of its functions calls this one
        if not self.native:
            return self.dispatcher._numba_type_
        if self._type is None:
            with _compiling() as compiling:
                self._type = self._type or _calls().by_place(self.symbol, self.letters, compiling.ARRAY_TYPES)
        return self._type

    @property
    def address(self) -> int:
        """Native address of a function with fixed types."""
        if self._address == 0 and self._fast:
            with _lock:
                self._address = self._address or self._read() or self._made()
        if self._address == 0:
            with _compiling():
                self._address = self._address or int(_calls().address(self.dispatcher))
        return self._address

    def _read(self) -> int:
        """Load kept machine code into memory; returns its address, 0 if there is none."""
        machine = _announced()
        return int(self._kept(machine).read(lambda code: machine.load(machine.Code(*code))) or 0)

    def _made(self) -> int:
        """Compile, load the machine code into memory and keep it on disk; its address, 0 if Numba has to do it."""
        machine = _announced()
        say_once("compiling kernels (once)")
        code = self._translated(lambda unit: unit.native(self.python, self._new_symbol, self.letters))
        if code is None:
            return 0
        found = machine.load(code)
        self._kept(machine).write(lambda: pickle.dumps(tuple(code)))
        return int(found)

    def _kept(self, machine: Any) -> KeptFile:
        return KeptFile(cache_folder() if self._is_kept else None, self.symbol, (self.letters, machine.processor()))


def natives() -> tuple[KernelFunction, ...]:
    """All functions with fixed types."""
    for name in compiled_modules():
        importlib.import_module(name)
    return tuple(_natives)


_natives: list[KernelFunction] = []
_places: dict[KernelFunction, Any] = {}  # of the first of them


def _announced() -> Any:
    """The module `machine`, which knows the addresses of all native functions that machine code may call."""
    machine = _machine()
    with _lock:
        for one in _natives[len(_places) :]:
            _places[one] = machine.announce(one.symbol, lambda one=one: one.address)
    return machine


def _machine() -> Any:
    return importlib.import_module("rattle.jit.machine")  # imports llvmlite


def _translation(part: str = "unit") -> Any:
    return importlib.import_module(f"rattle.jit.translation.{part}")  # imports llvmlite


def say_once(words: str) -> None:
    """Tell the user, once, that something is being compiled and not just read from the cache."""
    if not _said:
        _said.append(words)
        log.info(words)


_said: list[str] = []


def _calls() -> Any:
    return importlib.import_module("rattle.jit.compiling.calls")  # imports Numba


def users_law(law: Callable[..., Any], count: int) -> tuple[Any, Any]:
    """The same function compiled by Numba, and one that takes its `count` values from parameters: (p, k) -> tuple."""
    with _compiling():
        found: tuple[Any, Any] = importlib.import_module("rattle.jit.compiling.numba_types").users_law(law, count)
    return found


def compiled(function: Callable[..., Any]) -> KernelFunction:
    """Decorator for a function of the compiled layer (types follow from the first call)."""
    return KernelFunction(function)


def native(*letters: str) -> Callable[[Callable[..., Any]], KernelFunction]:
    """Decorator for a large function, or one that not every run needs; see `KernelFunction` and SIGNATURE."""
    return lambda function: KernelFunction(function, letters=letters)


def kernel(family: str) -> Callable[[Callable[..., Any]], KernelFunction]:
    """Decorator for the kernel of a kind: compiled for the family's one signature."""
    return lambda function: KernelFunction(function, family)


@contextmanager
def _compiling() -> Iterator[Any]:
    """The module that compiles with Numba; one thread at a time.

    Numba's lock is taken first: a thread that compiles something else may need one of our functions meanwhile.
    """
    compiling = importlib.import_module("rattle.jit.compiling.plain")
    with compiling.lock, _lock:
        _announced()  # the linker gives an unknown name the address zero
        while _lessons:
            _lessons.pop(0)(compiling)
        yield compiling


def before_compiling(lesson: Callable[[Any], None]) -> Callable[[Any], None]:
    """Decorator for a function that registers something with Numba before anything is compiled; its argument is the
    module that compiles."""
    _lessons.append(lesson)
    return lesson


_lessons: list[Callable[[Any], None]] = []


@before_compiling
def _teach_calls(compiling: Any) -> None:
    """Register the calls that compiled code may make besides other functions."""
    for family, call in CALLERS.items():
        _calls().teach(call, family, SIGNATURE[family], compiling.ARRAY_TYPES, family in BY_PLACE)


# ---------------------------------------------------------------- for the whole process
def start() -> bool:
    """Switch from Python to machine code (no effect with NUMBA_DISABLE_JIT=1); True if it runs now."""
    global _jit
    if not _jit and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
        _check_fast()
        _jit = True
    return _jit


def _check_fast() -> None:
    """Use the plain way if the fast one does not work; tested once for each state of sources and Numba."""
    if not compile_path.chosen().fast:
        return
    folder = code_folder()
    passed = folder.path / "fast-way-works" if folder.path is not None and folder.lasting else None
    if passed is not None and passed.exists():
        return
    try:
        _translation().check()
    except Exception as error:  # whatever an unknown LLVM says, the plain way still works
        compile_path.give_up_fast(error)
        forget_folder()
        return
    if passed is not None:
        with suppress(OSError):
            passed.touch()


def entries(functions: Iterable[KernelFunction]) -> Any:
    """A table of functions by number, for modules that cannot import them: places of their addresses, see `machine`."""
    if _jit:
        machine = _announced()
        return np.array([machine.where(_places[one]) for one in functions], dtype=np.int64)
    return tuple(one.python for one in functions)


def jit_runs() -> bool:
    """True once compiled functions run as machine code."""
    return _jit
