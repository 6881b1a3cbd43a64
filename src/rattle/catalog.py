"""Families of kinds, their kernel signatures, and how compiled functions are made and called.

A *family* (joint, load ...) has one kernel signature.  A *kind* (revolute, spring ...) is one class
in one file: its fields say what the user writes, its kernel says what it does.  Kernels are reached
through a table of native addresses, so one compile serves every mechanism and a new kind recompiles
nothing else.

Numba is imported on first use only: every compiled function is ordinary Python until `start()`.
With NUMBA_DISABLE_JIT=1 it stays so.
"""

from __future__ import annotations

import hashlib
import importlib
import logging
import os
import pkgutil
import re
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rattle import codecache
from rattle.codecache import CodeCache, Folder

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
    "hold": ("void", "h"),  # m, see rattle.impact
    "problem": ("i", "h", "i"),  # m, number of contacts, see rattle.impact
    "state": ("i", "h", "f", "v", "v"),  # m, t, and two vectors: parts of the march that many others call
    "event": ("i", "h", "f", "v", "i", "i"),  # m, t, y, contact, what happens to it -> status, see steppers.event
    "search": ("f", "h", "f", "i", "f", "f"),  # m, h, contact, side, until -> share of the step
    "look_back": ("i", "h", "f", "f", "i", "i", "v", "m"),  # m, t, h, changed, method, t_out, out
    "gauge": ("void", "h", "i", "f"),  # m, sample, t, see steppers.peaks
    "peak": ("i", "h", "f", "f", "f", "i", "i"),  # m, t, h, until, layout, dense -> states solved for
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
            for package in ("joints", "clearances", "laws", "applied"):
                found = importlib.import_module(f"{__package__}.{package}")
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

    ours: follows the rules of `compiling` and `arrays`; a function with anything of the user's in it does not.
    """

    def __init__(self, function: Callable[..., Any], family: str = "", ours: bool = True) -> None:
        self.python = function
        self.family = family
        self.ours = ours
        self._whole: Any = None
        self._part: Any = None
        self._called = False  # from Python: its machine code is there
        self._address = 0
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__
        self.__module__ = function.__module__

    def __call__(self, *args: Any) -> Any:
        if not _jit or (args and type(args[0]) is PlainHandle):  # a memory made before machine code ran stays plain
            return self.python(*args)
        if self._called:
            return self.dispatcher(*args)
        with _compiling():
            found = self.dispatcher(*args)
        self._called = True
        return found

    @property
    def dispatcher(self) -> Any:
        """The Numba dispatcher for calls from outside, made when first asked for."""
        if self._whole is None:
            with _compiling() as compiling:
                if self._whole is None and self.ours:
                    kept = CodeCache(self.python, cache_folder) if self.__module__.startswith("rattle.") else None
                    self._whole = compiling.whole(self.python, SIGNATURE.get(self.family, ()), kept)
                elif self._whole is None:
                    self._whole = compiling.foreign(self.python, SIGNATURE.get(self.family, ()))
        return self._whole

    @property
    def _numba_type_(self) -> Any:  # how Numba finds the dispatcher when one compiled function calls another
        if self._part is None:
            with _compiling() as compiling:
                if self._part is None:
                    self._part = compiling.part(self.python)
        return self._part._numba_type_

    @property
    def address(self) -> int:
        """Native address of a kernel compiled for its family's signature."""
        if self._address == 0:
            with _compiling() as compiling:
                self._address = compiling.address(self.dispatcher)
        return self._address


def compiled(function: Callable[..., Any]) -> Compiled:
    """Decorator for a function of the compiled layer (types follow from the first call)."""
    return Compiled(function)


def kernel(family: str) -> Callable[[Callable[..., Any]], Compiled]:
    """Decorator for the kernel of a kind: compiled for the family's one signature."""
    return lambda function: Compiled(function, family)


@contextmanager
def _compiling() -> Iterator[Any]:
    """Our compiler, with its settings; one thread at a time."""
    compiling: Any = importlib.import_module("rattle.compiling")  # imports Numba
    with compiling.lock, compiling.settings():
        yield compiling


def compiled_sources() -> list[Path]:
    """Files that machine code depends on: those with compiled functions, those that make it, and all they import."""
    here = Path(__file__).parent
    text = {path: path.read_text(encoding="utf-8") for path in here.rglob("*.py")}
    makers = [here / f"{name}.py" for name in ("arrays", "catalog", "compiling", "memory")]
    found = {path for path, source in text.items() if _DECORATED.search(source)} | set(makers)
    ahead = list(found)
    while ahead:
        for module, names in _IMPORTED.findall(text[ahead.pop()]):
            parts = module.split(".")[1:]
            folder = here.joinpath(*parts)
            for path in (folder.with_suffix(".py"), *(folder / f"{name}.py" for name in _NAME.findall(names))):
                if path in text and path not in found:
                    found.add(path)
                    ahead.append(path)
    return sorted(found)


_DECORATED = re.compile(r"^@(compiled|kernel\()", re.MULTILINE)
_IMPORTED = re.compile(r"^from (rattle[\w.]*) import (\([^)]*\)|.*)$", re.MULTILINE)
_NAME = re.compile(r"\w+")


def code_folder() -> Folder:
    """Where machine code is kept: one folder for each state of the compiled sources and Numba version."""
    global _code_folder
    if _code_folder is None:
        import numba

        here = Path(__file__).parent
        digest = hashlib.sha256(f"{numba.__version__} {numba.config.BOUNDSCHECK} {sys.version} {here}".encode())
        for source in compiled_sources():
            digest.update(source.read_bytes())
        with _folder_lock:
            _code_folder = _code_folder or codecache.code_folder(digest.hexdigest()[:16])
    return _code_folder


def cache_folder() -> Path | None:
    """The folder of kept machine code; None where there is no place for it."""
    return code_folder().path


_code_folder: Folder | None = None
_folder_lock = threading.Lock()  # of its own: asked for while others are held


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


def call_state(entry: Any, arguments: Any) -> int:
    """Call a part of the march; returns what it returns."""
    return int(entry(*arguments))


def call_event(entry: Any, arguments: Any) -> int:
    """Call what follows an event; returns a status."""
    return int(entry(*arguments))


def call_search(entry: Any, arguments: Any) -> Any:
    """Call the search for the instant at which a gap reaches its wall; returns a share of the step."""
    return entry(*arguments)


def call_look_back(entry: Any, arguments: Any) -> int:
    """Call the search of a step just taken; returns the contact that changes, or -1."""
    return int(entry(*arguments))


def call_gauge(entry: Any, arguments: Any) -> None:
    """Call what measures all forces of one instant."""
    entry(*arguments)


def call_peak(entry: Any, arguments: Any) -> int:
    """Call the search of a step for peaks; returns for how many states it solved."""
    return int(entry(*arguments))


def call_hold(entry: Any, arguments: Any) -> None:
    """Call the kernel that adds the forces of lasting set-valued contacts."""
    entry(*arguments)


def call_problem(entry: Any, arguments: Any) -> Any:
    """Call one part of the solution of contact problems; by its address, so that callers need not compile it again."""
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
    "state": call_state,
    "event": call_event,
    "search": call_search,
    "look_back": call_look_back,
    "gauge": call_gauge,
    "peak": call_peak,
}


def start() -> bool:
    """Switch from Python to machine code (no effect with NUMBA_DISABLE_JIT=1); True if it runs now."""
    global _jit
    if not _jit and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
        with _lock:
            if not _jit:
                with _compiling() as compiling:
                    for family, call in _CALLERS.items():
                        compiling.jumps(call, SIGNATURE[family])
                    importlib.import_module("rattle.memory").teach_numba()
                _jit = True
    return _jit


def table(*names: str, machine: bool | None = None) -> Any:
    """Kernels of the given families in tag order, one family after the other.

    An int64 array of addresses when machine code runs (or is asked for), a tuple of Python functions otherwise.
    """
    found = [entry.kernel for family in names for entry in kinds(family).values() if entry.kernel]
    if _jit if machine is None else machine:
        return np.array([one.address for one in found], dtype=np.int64)
    return tuple(one.python for one in found)


def entries(functions: Iterable[Compiled]) -> Any:
    """The same for given functions. Called this way a function is not linked into its callers again and again."""
    if _jit:
        return np.array([one.address for one in functions], dtype=np.int64)
    return tuple(one.python for one in functions)


def jit_runs() -> bool:
    """True once compiled functions run as machine code."""
    return _jit
