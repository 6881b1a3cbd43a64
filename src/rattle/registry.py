"""What a kind is: families, kinds and their fields, found by looking into the folders of `rattle.elements`.

A *family* (joint, load ...) has one kernel signature.  A *kind* (revolute, spring ...) is one class in one file: its
fields say what the user writes, its kernel says what it does.  Kernels are reached through a table of native
addresses, so one compile serves every mechanism and a new kind recompiles nothing else.
"""

from __future__ import annotations

import importlib
import pkgutil
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rattle.jit.functions import KernelFunction, jit_runs

REQUIRED: Any = object()
_lock = threading.RLock()
_families: dict[str, dict[str, Kind]] = {}
_discovered = _discovering = False


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
    """An entry of the registry: the class a leaf file defines, its kernel and its place in the table."""

    family: str
    name: str
    tag: int
    kernel: KernelFunction | None
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


def fields_of(leaf: type) -> dict[str, Field]:
    """The fields of a leaf, those it inherits first; one declared anew keeps its place."""
    declared: dict[str, Any] = {}
    for one in reversed(leaf.__mro__):
        declared.update(vars(one))
    return {key: value for key, value in declared.items() if isinstance(value, Field)}


def kind(family: str, name: str, kernel: KernelFunction | None = None) -> Callable[[type], type]:
    """Class decorator: enter the class in the registry as one kind of `family`."""

    def enter(leaf: type) -> type:
        entries = _families.setdefault(family, {})
        old = entries.get(name)
        if old is not None and old.leaf.__module__ != leaf.__module__:
            raise ValueError(f"{family} '{name}' is in the registry already ({old.leaf.__module__})")
        tag = old.tag if old is not None else len(entries)
        entries[name] = Kind(family, name, tag, kernel, leaf, fields_of(leaf))
        return leaf

    return enter


def kinds(family: str) -> Mapping[str, Kind]:
    """All kinds of one family by name; the leaf packages are searched on first use."""
    discover()
    return _families.setdefault(family, {})


def families() -> Iterator[str]:
    """Names of all families that have at least one kind."""
    discover()
    return iter(sorted(_families))


def discover() -> None:
    """Search the leaf packages once; other threads wait until the registry is whole."""
    global _discovered, _discovering
    if _discovered:
        return
    with _lock:
        if _discovered or _discovering:  # the second: a leaf asks for the registry while it is being made
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


def table(*names: str, machine: bool | None = None, used: Any = None) -> Any:
    """Kernels of the given families in tag order, one family after the other.

    An int64 array of addresses when machine code runs (or is asked for), a tuple of Python functions otherwise.
    used: places in the table that may be called; others are 0.  None means all.
    """
    found = [entry.kernel for family in names for entry in kinds(family).values() if entry.kernel]
    if jit_runs() if machine is None else machine:
        wanted = set(range(len(found))) if used is None else {int(n) for n in used}
        return np.array([one.address if n in wanted else 0 for n, one in enumerate(found)], dtype=np.int64)
    return tuple(one.python for one in found)
