"""Families of kinds, their kernel signatures, and how compiled functions are made and called.

A *family* (joint, load ...) has one kernel signature.  A *kind* (revolute, spring ...) is one class
in one file: its fields say what the user writes, its kernel says what it does.  Kernels are reached
through a table of native addresses, so one compile serves every mechanism and a new kind recompiles
nothing else.

Numba is imported on first use only: every compiled function is ordinary Python until `start()`.
With NUMBA_DISABLE_JIT=1 it stays so.
"""

from __future__ import annotations

import importlib
import logging
import os
import pickle
import pkgutil
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from rattle.jit.cache import CodeCache, KeptFile
from rattle.jit.folder import cache_folder, compiled_modules

log = logging.getLogger("rattle")

# one line per family: result and arguments of its kernels; i: int64, f: float64, v: (n,) and m: (n, k) of float64,
# h: (n,) of int64
SIGNATURE = {
    "joint": ("void", "m", "i", "i", "v", "i", "i", "m"),  # body, a, b, p, k, row, rows
    "load": ("void", "f", "m", "i", "i", "v", "i", "m", "v"),  # t, body, a, b, p, k, force, energy
    "clearance": ("void", "m", "i", "i", "v", "i", "i", "i", "m"),  # body, a, b, p, k, corner, row, touch
    "stiffness": ("f", "f", "v", "i"),  # delta, p, k -> F
    "normal": ("f", "f", "f", "f", "f", "v", "i"),  # F_static, delta, ddelta, v0, p, k -> F
    "friction": ("f", "f", "f", "f", "v", "i", "v"),  # u, N, z, p, k, dz -> T
    "hold": ("void", "h"),  # m, see rattle.equations.unilateral
    "problem": ("i", "h", "i"),  # m, number of contacts, see rattle.equations.unilateral
}
REQUIRED: Any = object()
_lock = threading.RLock()
_jit = False
_families: dict[str, dict[str, Kind]] = {}
_discovered = _discovering = False


# ---------------------------------------------------------------- what the user writes
@dataclass(frozen=True)
class Field:
    """One thing the user writes for a kind.

    shape: number | pair | point ("body.point") | body | joint | choice | size (a table of numbers)
    live: the value may use t, state and signals, and is then evaluated anew at every instant.
    least: "positive" or "not negative" where the number is limited.
    default: a number, or a function of the fields read so far.
    """

    unit: str
    meaning: str
    default: Any = REQUIRED
    shape: str = "number"
    least: str = ""
    live: bool = False
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class Kind:
    """A catalogue entry: the class a leaf file defines, its kernel and its place in the table."""

    family: str
    name: str
    tag: int
    kernel: Compiled | None
    leaf: Any  # the class; what it holds depends on the family
    fields: Mapping[str, Field]

    @property
    def summary(self) -> str:
        """First line of the leaf's docstring."""
        return (self.leaf.__doc__ or "").strip().splitlines()[0]

    @property
    def source(self) -> str:
        """Where the formula comes from, as the docstring says."""
        lines = (self.leaf.__doc__ or "").splitlines()
        found = [line.strip()[7:].strip() for line in lines if line.strip().startswith("Source:")]
        return found[0] if found else ""


def kind(family: str, name: str, kernel: Compiled | None = None) -> Callable[[type], type]:
    """Class decorator: enter the class in the catalogue as one kind of `family`."""

    def enter(leaf: type) -> type:
        entries = _families.setdefault(family, {})
        old = entries.get(name)
        if old is not None and old.leaf.__module__ != leaf.__module__:
            raise ValueError(f"{family} '{name}' is in the catalogue already ({old.leaf.__module__})")
        fields = {key: value for key, value in vars(leaf).items() if isinstance(value, Field)}
        tag = old.tag if old is not None else len(entries)
        entries[name] = Kind(family, name, tag, kernel, leaf, fields)
        return leaf

    return enter


def kinds(family: str) -> Mapping[str, Kind]:
    """All kinds of one family by name; the leaf packages are searched on first use."""
    _discover()
    return _families.setdefault(family, {})


def families() -> Iterator[str]:
    """Names of all families that have at least one kind."""
    _discover()
    return iter(sorted(_families))


def _discover() -> None:
    """Search the leaf packages once; other threads wait until the catalogue is whole."""
    global _discovered, _discovering
    if _discovered:
        return
    with _lock:
        if _discovered or _discovering:  # the second: a leaf asks for the catalogue while it is being made
            return
        _discovering = True
        try:
            for package in ("joints", "clearances", "contact_laws", "loads"):
                found = importlib.import_module(f"rattle.elements.{package}")
                for module in pkgutil.iter_modules(found.__path__):
                    importlib.import_module(f"{found.__name__}.{module.name}")
            _discovered = True
        finally:
            _discovering = False


# ---------------------------------------------------------------- compiled functions
class PlainHandle(tuple[Any, ...]):
    """The arrays of a memory that was made before machine code ran: functions that get it stay plain Python."""

    __slots__ = ()


class Compiled:
    """A function that Numba compiles on first use after `start()`; plain Python before.

    letters: types of result and arguments, as in SIGNATURE.  A function that has them is *native*: compiled once and
    only when it is called, and called by others by its address.  One without takes the types of its arguments, and
    machine code that calls it holds a copy of it.
    ours: follows the rules of `compiling` and `arrays`; a function with anything of the user's in it does not.
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
        self._called: Any = None  # what calls its machine code from Python
        self._address = 0
        self._place: Any = None
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__
        self.__module__ = function.__module__
        if self.native:
            _natives.append(self)

    def __call__(self, *args: Any) -> Any:
        if not _jit or (args and type(args[0]) is PlainHandle):  # a memory made before machine code ran stays plain
            return self.python(*args)
        if self._called is None:
            if self.native:
                self._called = _machine().caller(self.__name__, self.address, self.letters)
            else:
                with _compiling():
                    found = self.dispatcher(*args)
                self._called = self.dispatcher
                return found
        return self._called(*args)

    @property
    def dispatcher(self) -> Any:
        """The Numba dispatcher for calls from outside, made when first asked for."""
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
        """Name of the place where the address of a native function stands, for the linker."""
        return f"rattle.place.{self.__module__}.{self.__name__}"

    @property
    def _numba_type_(self) -> Any:  # what Numba asks for when one compiled function calls another
        if self._type is None:
            with _compiling() as compiling:
                if self._type is None and self.native:
                    self._type = compiling.by_place(self.symbol, self.letters)
                elif self._type is None:
                    self._type = compiling.part(self.python)
        return self._type if self.native else self._type._numba_type_

    @property
    def address(self) -> int:
        """Native address of a function with fixed types."""
        if self._address == 0:
            with _lock:
                if self._address == 0:
                    self._address = self._load() if self.native else _compiling_address(self)
        return self._address

    def _load(self) -> int:
        """Put machine code into memory, from the cache or made now."""
        machine = _announced()
        kept = KeptFile(cache_folder() if self._is_kept else None, self.symbol, (self.letters, machine.processor()))
        found = kept.read(lambda code: machine.load(machine.Code(*code)))
        if found is None:
            with _compiling() as compiling:
                code = compiling.native(self.python, self.letters)
            found = machine.load(code)
            kept.write(lambda: pickle.dumps(tuple(code)))
        return int(found)


def natives() -> tuple[Compiled, ...]:
    """All functions with fixed types."""
    for name in compiled_modules():
        importlib.import_module(name)
    _discover()
    return tuple(_natives)


_natives: list[Compiled] = []
_places: dict[Compiled, Any] = {}  # of the first of them


def _announced() -> Any:
    """The module `machine`, which knows the places of all native functions that machine code may call."""
    machine = _machine()
    with _lock:
        for one in _natives[len(_places) :]:
            _places[one] = machine.announce(one.symbol, lambda one=one: one.address)
    return machine


def _machine() -> Any:
    return importlib.import_module("rattle.jit.machine")  # imports llvmlite


def _compiling_address(one: Compiled) -> int:
    with _compiling() as compiling:
        return int(compiling.address(one.dispatcher))


def compiled(function: Callable[..., Any]) -> Compiled:
    """Decorator for a function of the compiled layer (types follow from the first call)."""
    return Compiled(function)


def native(*letters: str) -> Callable[[Callable[..., Any]], Compiled]:
    """Decorator for a large function of the compiled layer, or one not every run needs; see `Compiled`, SIGNATURE."""
    return lambda function: Compiled(function, letters=letters)


def kernel(family: str) -> Callable[[Callable[..., Any]], Compiled]:
    """Decorator for the kernel of a kind: compiled for the family's one signature."""
    return lambda function: Compiled(function, family)


@contextmanager
def _compiling() -> Iterator[Any]:
    """Our compiler, with its settings; one thread at a time."""
    with _lock:
        compiling: Any = importlib.import_module("rattle.jit.compiler")  # imports Numba
        with compiling.lock, compiling.settings():
            if not _taught:
                _teach(compiling)
            yield compiling


_taught: list[bool] = []


def _teach(compiling: Any) -> None:
    """What compiled code may call besides other functions."""
    _taught.append(True)
    for family, call in _CALLERS.items():
        compiling.jumps(call, SIGNATURE[family], family in ("hold", "problem"))
    importlib.import_module("rattle.jit.workspace").teach_numba()


# ---------------------------------------------------------------- tables of kernels
def call_joint(entry: Any, arguments: Any) -> None:
    """Call one joint kernel of a table."""
    entry(*arguments)


def call_load(entry: Any, arguments: Any) -> None:
    """Call one load kernel of a table."""
    entry(*arguments)


def call_clearance(entry: Any, arguments: Any) -> None:
    """Call one clearance kernel of a table: the geometry of one contact."""
    entry(*arguments)


def call_stiffness(entry: Any, arguments: Any) -> Any:
    """Static contact force [N] by one stiffness kernel of a table."""
    return entry(*arguments)


def call_normal(entry: Any, arguments: Any) -> Any:
    """Normal force [N] by one normal kernel of a table."""
    return entry(*arguments)


def call_friction(entry: Any, arguments: Any) -> Any:
    """Friction force [N] by one friction kernel of a table."""
    return entry(*arguments)


def call_hold(entry: Any, arguments: Any) -> None:
    """Call the kernel that adds the forces of lasting set-valued contacts."""
    entry(*arguments)


def call_problem(entry: Any, arguments: Any) -> Any:
    """Call one part of the solution of contact problems."""
    return entry(*arguments)


_CALLERS: dict[str, Callable[..., Any]] = {
    "joint": call_joint,
    "load": call_load,
    "clearance": call_clearance,
    "stiffness": call_stiffness,
    "normal": call_normal,
    "friction": call_friction,
    "hold": call_hold,
    "problem": call_problem,
}


def start() -> bool:
    """Switch from Python to machine code (no effect with NUMBA_DISABLE_JIT=1); True if it runs now."""
    global _jit
    if not _jit and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
        _jit = True
    return _jit


def table(*names: str, machine: bool | None = None, used: Any = None) -> Any:
    """Kernels of the given families in tag order, one family after the other.

    An int64 array of addresses when machine code runs (or is asked for), a tuple of Python functions otherwise.
    used: places in the table that may be called; others are 0.  None means all.
    """
    found = [entry.kernel for family in names for entry in kinds(family).values() if entry.kernel]
    if _jit if machine is None else machine:
        wanted = set(range(len(found))) if used is None else {int(n) for n in used}
        return np.array([one.address if n in wanted else 0 for n, one in enumerate(found)], dtype=np.int64)
    return tuple(one.python for one in found)


def entries(functions: Iterable[Compiled]) -> Any:
    """Functions by number, for those who cannot import them: places of their addresses, see `machine`."""
    if _jit:
        machine = _announced()
        return np.array([machine.where(_places[one]) for one in functions], dtype=np.int64)
    return tuple(one.python for one in functions)


def jit_runs() -> bool:
    """True once compiled functions run as machine code."""
    return _jit
