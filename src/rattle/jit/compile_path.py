"""Which of two ways functions are compiled: the fast one, or the plain one, which works with any version of Numba.

The fast way (`compiler`, `blocks`) uses internals of Numba, so it is taken only for versions with which it is known to
work, and after a small check.  The plain way (`plain`) uses documented functions of Numba: compiling takes several
times as long, the numbers are the same.  RATTLE_JIT=plain or RATTLE_JIT=fast in the environment selects one.
"""

from __future__ import annotations

import os
from functools import cache
from importlib.metadata import version
from typing import NamedTuple

KNOWN = (
    "0.61",
    "0.62",
    "0.63",
    "0.64",
    "0.65",
    "0.66",
    "0.67",
    "0.68",
)  # more are added when the tests pass


class Choice(NamedTuple):
    """The way taken in this process, and the reason if it is the plain one."""

    fast: bool
    why: str = ""


@cache
def _by_version() -> Choice:
    """The way by environment and version of Numba.  Raises ValueError for an unknown way."""
    wanted = os.environ.get("RATTLE_JIT", "")
    if wanted not in ("", "fast", "plain"):
        raise ValueError(f"RATTLE_JIT is '{wanted}'; expected fast or plain, or nothing")
    number = version("numba")
    if wanted == "plain":
        return Choice(False, "RATTLE_JIT=plain asks for it")
    if wanted == "" and ".".join(number.split(".")[:2]) not in KNOWN:
        return Choice(
            False, f"Numba {number} is not among the versions known to compile fast, {KNOWN[0]} to {KNOWN[7]}"
        )
    return Choice(True)


_failed: list[Choice] = []


def chosen() -> Choice:
    """The way in which functions are compiled.  Raises ValueError for an unknown value of RATTLE_JIT."""
    return _failed[0] if _failed else _by_version()


def give_up_fast(error: Exception) -> None:
    """Use the plain way from now on, because the check of the fast one has raised this error."""
    first = next(iter(str(error).splitlines()), "")
    said = f"Numba {version('numba')} does not do what fast compiling needs ({type(error).__name__}: {first})"
    _failed.append(Choice(False, said))


def described() -> str:
    """One line for the user: version of Numba, how functions are compiled, and why not the fast way."""
    way = chosen()
    plain = f"functions are compiled the plain way, which takes longer: {way.why}"
    return f"Numba {version('numba')}; " + ("functions are compiled the fast way" if way.fast else plain)
