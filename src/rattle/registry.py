"""Registry of families, kinds and their fields; kinds are found by importing the folders of their classes.

A *family* (joint, load ...) has one kernel signature.  A *kind* (revolute, spring ...) is one class in one file: its
fields say what the user writes, its kernel says what it does.  Kernels are reached through a table of native
addresses, so one compile serves every mechanism and a new kind recompiles nothing else.

What other modules need to know about a kind are attributes and methods of its class; no code tests for the name of a
kind or of its fields.  The interfaces, with their defaults, are the classes in `rattle.interfaces`, one for each
family: `kinds("joint")` are kinds of `JointKind`.
"""

from __future__ import annotations

import importlib
import pkgutil
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Literal, TypeVar, overload

import numpy as np

from rattle.errors import InputError
from rattle.interfaces.contacts import ClearanceKind, ClutchKind, ContactKind, OneSidedKind, StopKind, WornKind
from rattle.interfaces.fields import REQUIRED as REQUIRED
from rattle.interfaces.fields import Field as Field
from rattle.interfaces.fields import Fields, fields_of
from rattle.interfaces.fields import LocalName as LocalName
from rattle.interfaces.joints import DriverKind, JointKind
from rattle.interfaces.laws import FilmLaw, FrictionLaw, NormalLaw, StiffnessLaw, TangentKind
from rattle.interfaces.loads import LoadKind
from rattle.interfaces.steppers import StepperKind
from rattle.jit.functions import KernelFunction, jit_runs

ELEMENTS = tuple(
    f"rattle.elements.{folder}"
    for folder in ("joints", "clearances", "one_sided", "stops", "clutches", "contact_laws", "film", "loads")
)
PACKAGES = {"stepper": ("rattle.solvers.steppers",)}  # packages of the families that are elsewhere
Leaf = TypeVar("Leaf")
Interface = TypeVar("Interface", covariant=True)
_lock = threading.RLock()
_families: dict[str, dict[str, Kind[object]]] = {}
_complete: dict[str, dict[str, Kind[object]]] = {}  # those of them whose packages were searched
_searched: set[str] = set()  # packages
_searching: set[str] = set()


@dataclass(frozen=True)
class Kind(Generic[Interface]):
    """An entry of the registry: the class that a leaf file defines, its kernel, its index (`tag`) in the table."""

    family: str
    name: str
    tag: int
    kernel: KernelFunction | None
    leaf: type[Interface]  # the class; what it holds depends on the family
    fields: Mapping[str, Field]

    @property
    def summary(self) -> str:
        """First line of the leaf's docstring."""
        return (self.leaf.__doc__ or "").strip().splitlines()[0]

    @property
    def source(self) -> str:
        """Source of the formula: the line "Source: ..." of the leaf's docstring, "" if there is none."""
        lines = (self.leaf.__doc__ or "").splitlines()
        sources = [line.strip()[7:].strip() for line in lines if line.strip().startswith("Source:")]
        return sources[0] if sources else ""


def kind(family: str, name: str, kernel: KernelFunction | None = None) -> Callable[[type[Leaf]], type[Leaf]]:
    """Class decorator: register the class as a kind of `family`.

    Raises InputError if another module has registered a kind of that name.
    """

    def enter(leaf: type[Leaf]) -> type[Leaf]:
        entries = _families.setdefault(family, {})
        old = entries.get(name)
        if old is not None and old.leaf.__module__ != leaf.__module__:
            raise InputError(f"{family} '{name}' is already registered ({old.leaf.__module__})")
        tag = old.tag if old is not None else len(entries)
        entries[name] = Kind(family, name, tag, kernel, leaf, fields_of(leaf))
        return leaf

    return enter


@overload
def kinds(family: Literal["joint"]) -> Mapping[str, Kind[JointKind]]: ...
@overload
def kinds(family: Literal["driver"]) -> Mapping[str, Kind[DriverKind]]: ...
@overload
def kinds(family: Literal["clearance"]) -> Mapping[str, Kind[ClearanceKind]]: ...
@overload
def kinds(family: Literal["worn"]) -> Mapping[str, Kind[WornKind]]: ...
@overload
def kinds(family: Literal["one-sided"]) -> Mapping[str, Kind[OneSidedKind]]: ...
@overload
def kinds(family: Literal["stop"]) -> Mapping[str, Kind[StopKind]]: ...
@overload
def kinds(family: Literal["clutch"]) -> Mapping[str, Kind[ClutchKind]]: ...
@overload
def kinds(family: Literal["contact"]) -> Mapping[str, Kind[ContactKind]]: ...
@overload
def kinds(family: Literal["stiffness"]) -> Mapping[str, Kind[StiffnessLaw]]: ...
@overload
def kinds(family: Literal["friction"]) -> Mapping[str, Kind[FrictionLaw]]: ...
@overload
def kinds(family: Literal["film"]) -> Mapping[str, Kind[FilmLaw]]: ...
@overload
def kinds(family: Literal["load"]) -> Mapping[str, Kind[LoadKind]]: ...
@overload
def kinds(family: Literal["tangent"]) -> Mapping[str, Kind[TangentKind]]: ...
@overload
def kinds(family: Literal["stepper"]) -> Mapping[str, Kind[StepperKind]]: ...
@overload
def kinds(family: Literal["normal", "tension"]) -> Mapping[str, Kind[NormalLaw]]: ...
@overload
def kinds(family: str) -> Mapping[str, Kind[object]]: ...
def kinds(family: str) -> Mapping[str, Kind[object]]:
    """All kinds of one family by name; its packages are searched on first use."""
    entries = _complete.get(family)
    if entries is None:
        if not _searched.issuperset(packages := PACKAGES.get(family, ELEMENTS)):
            discover(packages)
        entries = _families.setdefault(family, {})
        if _searched.issuperset(packages):  # not while a kind that is being imported asks
            with _lock:
                if family in PACKAGES and family not in _complete:  # in one order, whichever file was imported first
                    entries.update({name: entries.pop(name) for name in names(family)})
                _complete[family] = entries
    return entries


def play_of(joint: str) -> Kind[ClearanceKind] | None:
    """The kind of clearance of a kind of joint; None if it cannot have clearance."""
    return next((entry for entry in kinds("clearance").values() if entry.leaf.joint == joint), None)


def one_sided_of(joint: str) -> Kind[OneSidedKind] | None:
    """The contacts that stand for the rows of a kind of joint without clearance, the first of them; None without."""
    return next((entry for entry in kinds("one-sided").values() if entry.leaf.joint == joint), None)


def sides_of(joint: str, fields: Fields) -> list[Kind[OneSidedKind]]:
    """All kinds of such contacts of a joint with these fields."""
    return [entry for entry in kinds("one-sided").values() if entry.leaf.joint == joint and entry.leaf.suits(fields)]


def stop_of(joint: str) -> Kind[StopKind] | None:
    """The kind of stop of a kind of joint: that of the coordinate that a motor moves, or of one that only stops hold.

    None if it has no coordinate.
    """
    leaf = kinds("joint")[joint].leaf
    return kinds("stop").get(leaf.motor.driver if leaf.motor else leaf.stops)


def normal_law(name: str) -> Kind[NormalLaw]:
    """A law of the normal force: of contacts that the user chooses, or of strands."""
    return kinds("normal").get(name) or kinds("tension")[name]


def damped_law() -> Kind[NormalLaw]:
    """The law of a contact whose damping is stated, whatever law the user names."""
    return next(kind for kind in kinds("tension").values() if kind.leaf.ends_by_force)


def law(family: str, name: str) -> Kind[NormalLaw] | Kind[StiffnessLaw] | Kind[FrictionLaw]:
    """A law of a contact: normal, stiffness or friction."""
    if family == "normal":
        return normal_law(name)
    return kinds("stiffness")[name] if family == "stiffness" else kinds("friction")[name]


def names(family: str) -> tuple[str, ...]:
    """Names of all kinds of one family; leaves in PACKAGES have files of their names and are not imported for that."""
    if family not in PACKAGES:
        return tuple(kinds(family))
    folders = [importlib.import_module(package).__path__ for package in PACKAGES[family]]
    files = [module.name for folder in folders for module in pkgutil.iter_modules(folder)]
    return tuple(dict.fromkeys([*files, *_families.get(family, {})]))


def families() -> Iterator[str]:
    """Names of all families that have at least one kind."""
    discover((*ELEMENTS, *(package for packages in PACKAGES.values() for package in packages)))
    return iter(sorted(_families))


def discover(packages: Sequence[str] = ELEMENTS) -> None:
    """Import the modules of packages that define kinds, once; other threads wait until the registry has all of them."""
    if _searched.issuperset(packages):
        return
    with _lock:
        for package in packages:
            if package in _searched or package in _searching:  # a kind uses the registry while it is being filled
                continue
            _searching.add(package)
            try:
                searched = importlib.import_module(package)
                for module in pkgutil.iter_modules(searched.__path__):
                    importlib.import_module(f"{package}.{module.name}")
                _searched.add(package)
            finally:
                _searching.remove(package)


def table(*names: str, machine: bool | None = None, used: Any = None) -> Any:
    """Kernels of the given families in tag order, one family after the other.

    machine: an int64 array of native addresses if True, a tuple of Python functions if False; None: as the JIT is on.
    used: indices in the table that may be called; the others are traps, which name the kernel.  None means all.
    """
    kernels = [entry.kernel for family in names for entry in kinds(family).values() if entry.kernel]
    if not (jit_runs() if machine is None else machine):
        return tuple(kernel.python for kernel in kernels)
    wanted = set(range(len(kernels)) if used is None else used)
    return np.array(
        [kernel.address if n in wanted else kernel.trap for n, kernel in enumerate(kernels)], dtype=np.int64
    )
