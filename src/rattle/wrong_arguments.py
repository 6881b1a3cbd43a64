"""Public methods answer an argument of a wrong type in words: what is expected, and what was given.

Nothing is checked before a call.  If it ends in an error that is none of ours, its arguments are compared with the
types that the method declares: the first one that does not fit is to blame; if all fit, the error stays what it is.
"""

from __future__ import annotations

import builtins
import collections.abc
import functools
import inspect
import numbers
import sys
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, TypeVar, cast

from rattle.errors import ANSWERS, WrongType

C = TypeVar("C", bound=type)
F = TypeVar("F", bound=Callable[..., Any])
WORDS = {
    str: "a text", bool: "True or False", int: "a whole number", float: "a number", types.NoneType: "None",
    collections.abc.Callable: "a function",
}  # fmt: skip
LATER = {"np": "numpy", "os": "os", "Path": "pathlib:Path", "Axes": "matplotlib.axes:Axes"}  # imported for types


def answers_in_words(cls: C) -> C:
    """Class decorator: every public method, inherited ones too, blames the argument that does not fit."""
    for name, method in inspect.getmembers_static(cls, inspect.isfunction):
        if not name.startswith("_") and method.__module__.startswith("rattle."):
            setattr(cls, name, answer_in_words(method))
    return cls


def answer_in_words(method: F) -> F:
    """Decorator: foreign errors of a method or function become WrongType where an argument does not fit."""

    @functools.wraps(method)
    def called(*args: Any, **options: Any) -> Any:
        try:
            return method(*args, **options)
        except ANSWERS:
            raise
        except Exception as error:
            blame = _blame(method, args, options)
            if not blame:
                raise
            raise WrongType(blame) from error

    return cast(F, called)


def _blame(method: Callable[..., Any], args: tuple[Any, ...], options: Mapping[str, Any]) -> str:
    """Which argument does not fit the type that is declared for it, in words; "" if all do."""
    signature = inspect.signature(method)
    try:
        bound = signature.bind(*args, **options)
    except TypeError:
        return ""  # Python says which argument is missing or too many
    for key, value in bound.arguments.items():
        parameter = signature.parameters[key]
        wanted = _evaluated(parameter.annotation, method)
        each = [value]
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            each = list(value if parameter.kind is parameter.VAR_POSITIONAL else value.values())
        for argument in each:
            if not fits(argument, wanted):
                return f"{method.__name__}: {key}: expected {in_words(wanted)}, got {argument!r:.60}"
    return ""


class _Names(dict[str, Any]):
    """Names of a module; of those that only type checkers import, the usual ones, and for others anything."""

    def __missing__(self, name: str) -> Any:
        if hasattr(builtins, name):
            raise KeyError(name)  # Python looks there next
        module, _, attribute = LATER.get(name, "").partition(":")
        imported = sys.modules.get(module)
        return Any if imported is None else getattr(imported, attribute) if attribute else imported


def _evaluated(annotation: Any, method: Callable[..., Any]) -> Any:
    """The type that an annotation means; Any where it means none that can be looked at."""
    if not isinstance(annotation, str):
        return Any if annotation is inspect.Parameter.empty else annotation
    try:
        return eval(annotation, {}, _Names(method.__globals__))  # of our own sources
    except (AttributeError, NameError, TypeError):
        return Any


def fits(value: Any, wanted: Any) -> bool:
    """True unless a value is surely not of a type; numbers of NumPy are numbers, its arrays sequences."""
    kind, parts = typing.get_origin(wanted) or wanted, typing.get_args(wanted)
    if kind is Any or isinstance(kind, TypeVar | str) or kind is typing.Literal:
        return True
    if kind in (types.UnionType, typing.Union):
        return any(fits(value, part) for part in parts)
    if kind in (None, types.NoneType):
        return value is None
    if kind in (float, int):
        number = numbers.Real if kind is float else numbers.Integral
        return isinstance(value, number) and not isinstance(value, bool) and (kind is int or _has_a_float(value))
    return _fits_class(value, kind, parts) if isinstance(kind, type) else True


def _fits_class(value: Any, kind: type, parts: tuple[Any, ...]) -> bool:
    """The same of a class, with the types of what it holds."""
    if issubclass(kind, str):
        return isinstance(value, str)
    if issubclass(kind, collections.abc.Iterable) and hasattr(value, "__array__"):
        return getattr(value, "ndim", 1) > 0 and not issubclass(kind, collections.abc.Mapping)
    if not isinstance(value, kind) or (isinstance(value, str | bytes) and kind is not bytes and parts):
        return False
    return _parts_fit(value, kind, parts)


def _has_a_float(number: Any) -> bool:
    """False for a whole number beyond all floats."""
    try:
        float(number)
    except OverflowError:
        return False
    return True


def _parts_fit(value: Any, kind: type, parts: tuple[Any, ...]) -> bool:
    """True unless something in a table or list is surely not of the type declared for it."""
    if issubclass(kind, collections.abc.Mapping) and len(parts) == 2:
        return all(fits(key, parts[0]) and fits(item, parts[1]) for key, item in value.items())
    if isinstance(value, tuple) and kind is tuple and parts and parts[-1] is not Ellipsis:
        return len(value) == len(parts) and all(map(fits, value, parts))
    if isinstance(value, list | tuple | set) and parts:
        return all(fits(item, parts[0]) for item in value)
    return True


def in_words(wanted: Any) -> str:
    """A type as a message says it."""
    kind, parts = typing.get_origin(wanted) or wanted, typing.get_args(wanted)
    if kind in (types.UnionType, typing.Union):
        return " or ".join(dict.fromkeys(in_words(part) for part in parts))
    if kind in WORDS:
        return WORDS[kind]
    if not isinstance(kind, type):
        return "something else" if kind is not Any else "anything"
    if issubclass(kind, collections.abc.Mapping):
        return f"a dict from {in_words(parts[0])} to {in_words(parts[1])}" if len(parts) == 2 else "a dict"
    if issubclass(kind, collections.abc.Iterable) and kind.__module__ in ("builtins", "collections.abc"):
        of = [in_words(part) for part in parts if part is not Ellipsis]
        return f"a list, each {' or '.join(dict.fromkeys(of))}" if of else "a list"
    return f"a {kind.__name__}" if kind.__name__ != "ndarray" else "an array"
