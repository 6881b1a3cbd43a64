"""Kernels that call a function of the user.

The function is translated like a kernel.  What the translation refuses is compiled by Numba, if it is installed (the
extra `laws`), or else runs as plain Python, which machine code calls: slower, because every evaluation goes through
the interpreter.
"""

from __future__ import annotations

import hashlib
import logging
from abc import abstractmethod
from collections import namedtuple
from collections.abc import Callable, Iterator, Sequence
from inspect import isfunction, ismethod, ismodule
from types import CellType, CodeType, FunctionType
from typing import Any

import numpy as np

from rattle.errors import InputError
from rattle.jit.families import Kind
from rattle.jit.functions import KernelFunction

Outside = dict[tuple[object, ...], object]  # what a law uses from outside, by where it is used
log = logging.getLogger("rattle")
Law = Callable[..., Any]  # of a user, or a kernel around it: its arguments and result are those of its family


class UsersKernel(KernelFunction):
    """The kernel of a law: what takes its fields from the parameters, and how machine code comes to call the law.

    words: what the law is called in messages.  sizes: of its arguments before the fields: 0 for a number, n for a tuple
    of n.  result: kind of what it returns, "f" or a tuple of such.  compiled: False if it is to run as plain Python.
    """

    def __init__(
        self,
        family: str,
        words: str,
        law: Law,
        keys: Sequence[str],
        sizes: Sequence[int],
        result: Kind,
        compiled: bool,
    ) -> None:
        self.family, self.words, self.law, self.compiled = family, words, law, compiled
        self.sizes, self.result = tuple(sizes), result
        self.pack: Any = namedtuple("p", keys)  # type: ignore[misc]  # its keys are data
        self.fields = taking("pack", len(keys), {"pack": self.pack})
        super().__init__(self.plain(), family)
        self._outside: Outside = {}  # what the machine code has taken from outside the law
        self.__module__, self.__name__ = law.__module__ or "__main__", law.__name__

    @abstractmethod
    def plain(self) -> Law:
        """The kernel for plain Python."""

    @abstractmethod
    def around(self, law: Any) -> Law:
        """The kernel with this law in it, for machine code."""

    @abstractmethod
    def flat(self, *flattened: float) -> Sequence[float]:
        """What the law returns as plain Python; arguments and result are numbers one after the other."""

    @property
    def address(self) -> int:
        """Address of the machine code; made anew where what the law uses from outside has changed."""
        now = outside(self.law)
        if self._outside != now:
            self._address, self._outside = 0, now
            self._callers.clear()
        return super().address

    def _made(self) -> int:
        """Compile the kernel; returns its address."""
        if not self.compiled:
            log.info(f"{self.words} runs as plain Python, slower (compiled=False)")
            return self._loaded(self._in_python())
        try:
            return self._loaded(self.law)
        except Exception as error:  # whatever is the matter with a function of the user, others can run it
            why = next((line for line in str(error).splitlines() if line.strip()), type(error).__name__)
            why = why.partition(": kernels are written")[0]  # what else is known matters to kernels
        from rattle.jit import numba_laws  # imports llvmlite

        try:
            law = numba_laws.entry(self.law, self.pack, self.sizes, self.result)
        except Exception as error:  # Numba has many kinds of error
            log.debug(f"{self.words}: Numba cannot compile it: {error}")
            law = None
        if law is not None:
            log.info(f"{self.words} is compiled by Numba, which takes longer: {why}")
            return self._loaded(law)
        log.warning(f"{self.words} runs as plain Python, slower: {why}")
        return self._loaded(self._in_python())

    def _loaded(self, law: Any) -> int:
        return self.loaded(self.around(law))

    def _in_python(self) -> Any:
        from rattle.jit import machine  # imports llvmlite

        count = sum(max(1, size) for size in self.sizes) + len(self.pack._fields)
        return machine.python_entry(self.flat, self.result, count)


def place_of(law: Law, words: str) -> str:
    """Where a law is written.  Raises InputError for an object that is no function."""
    if not hasattr(law, "__qualname__"):
        raise InputError(f"{words}: a function is expected, got {law!r}; write one (def ...) that calls it")
    return f"{law.__module__}.{law.__qualname__}"


def outside(law: Law) -> Outside:
    """Numbers, texts and arrays that a function uses from outside, and those of the functions that it calls."""
    used: Outside = {}
    ahead: list[object] = [getattr(law, "py_func", law)]
    seen = set[int]()
    while ahead:
        function = ahead.pop()
        function = function.__func__ if ismethod(function) else function
        if not isfunction(function) or id(function) in seen:
            continue
        code = function.__code__
        seen.add(id(function))
        for name, value in _names_around(function, code):
            if isfunction(value):
                ahead.append(value)
            elif ismodule(value):
                numbers = {key: getattr(value, key, None) for key in code.co_names}
                used |= {(id(code), name, key): repr(x) for key, x in numbers.items() if isinstance(x, int | float)}
            elif isinstance(value, np.ndarray):
                used[id(code), name] = (value.shape, value.dtype.str, value.tobytes())
            else:
                used[id(code), name] = repr(value) if isinstance(value, int | float | str | tuple | list) else id(value)
    return used


def _names_around(function: FunctionType, code: CodeType) -> Iterator[tuple[str, object]]:
    """Names that a function takes from its module, from around it and as defaults, and what they are."""
    names = {name: function.__globals__[name] for name in code.co_names if name in function.__globals__}
    cells = zip(code.co_freevars, function.__closure__ or (), strict=True)
    names |= {name: content for name, cell in cells for content in _content(cell)}
    names |= {f"default {n}": value for n, value in enumerate(function.__defaults__ or ())}
    for name, value in names.items():
        yield name, getattr(value, "py_func", value)


def _content(cell: CellType) -> list[object]:
    """What a variable from around a function holds; nothing if it has not been set."""
    try:
        return [cell.cell_contents]
    except ValueError:
        return []


def taking(make: str, count: int, around: dict[str, object] | None = None) -> Law:
    """A function of an array p and a place k that makes something of the numbers from there; "": a tuple.

    around: what its code may name.
    """
    values = "".join(f"float(p[k + {n}]), " for n in range(count))
    text = f"def fields(p, k):\n    return {make}({values})\n"
    file = f"<fields {hashlib.sha256(text.encode()).hexdigest()[:16]}>"
    space: dict[str, Any] = {"__name__": "fields", **(around or {})}
    exec(compile(text, file, "exec"), space)
    space["fields"].source = text.splitlines(keepends=True)  # for the translation
    function: Law = space["fields"]
    return function
