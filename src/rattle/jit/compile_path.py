"""Which of two ways functions are compiled: the fast one, or the plain one.

On the fast way our own `translation` and LLVM compile them, after a small check; Numba is imported only for laws that
a user has written in Python.  On the plain way Numba compiles all of them, which takes many times as long; the numbers
are the same.  RATTLE_JIT=plain or RATTLE_JIT=fast in the environment selects one.
"""

from __future__ import annotations

import importlib
import os
from functools import cache
from typing import Any, NamedTuple

from rattle.errors import InputError


class Choice(NamedTuple):
    """The way taken in this process, and the reason if it is the plain one."""

    fast: bool
    why: str = ""


@cache
def _by_environment() -> Choice:
    """The way that the environment asks for.  Raises InputError for an unknown one."""
    wanted = os.environ.get("RATTLE_JIT", "")
    if wanted not in ("", "fast", "plain"):
        raise InputError(f"RATTLE_JIT is '{wanted}'; expected fast or plain, or nothing")
    return Choice(False, "RATTLE_JIT=plain asks for it") if wanted == "plain" else Choice(True)


def version(package: str) -> str:
    """The version of a package that is installed."""
    from importlib import metadata  # takes longer to import than a short analysis

    return metadata.version(package)


def compilers() -> tuple[str, ...]:
    """What machine code depends on: versions of the packages that make it."""
    llvmlite: Any = importlib.import_module("llvmlite")
    return (llvmlite.__version__,) if chosen().fast else (llvmlite.__version__, version("numba"))


_failed: list[Choice] = []


def chosen() -> Choice:
    """The way in which functions are compiled.  Raises InputError for an unknown value of RATTLE_JIT."""
    return _failed[0] if _failed else _by_environment()


def give_up_fast(error: Exception) -> None:
    """Use the plain way from now on, because the check of the fast one has raised this error."""
    first = next(iter(str(error).splitlines()), "")
    said = f"llvmlite {version('llvmlite')} does not do what fast compiling needs ({type(error).__name__}: {first})"
    _failed.append(Choice(False, said))


def described() -> str:
    """One line for the user: what compiles, and why it is not the fast way."""
    way = chosen()
    if way.fast:
        return f"llvmlite {version('llvmlite')}; functions are compiled the fast way"
    return f"Numba {version('numba')}; functions are compiled the plain way, which takes longer: {way.why}"
