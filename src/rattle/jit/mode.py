"""How kernels run: as machine code, which `translation` and LLVM make, or as plain Python.

RATTLE_JIT=native (or nothing) and RATTLE_JIT=python in the environment choose.  Where LLVM does not do what is needed,
kernels run as plain Python, some hundred times slower.
"""

from __future__ import annotations

import importlib
import os

from rattle.errors import InputError

MODES = ("native", "python")
_failed: list[str] = []  # why there is no machine code in this process


def asked_for() -> str:
    """What the environment asks for.  Raises InputError for an unknown value."""
    wanted = os.environ.get("RATTLE_JIT", "") or "native"
    if wanted not in MODES:
        raise InputError(f"RATTLE_JIT is '{wanted}'; expected {' or '.join(MODES)}, or nothing")
    return wanted


def is_native() -> bool:
    """True where kernels are to run as machine code.  Raises InputError for an unknown value of RATTLE_JIT."""
    return asked_for() == "native" and not _failed


def compiler() -> str:
    """The version of LLVM's package."""
    llvmlite = importlib.import_module("llvmlite")
    return f"llvmlite {llvmlite.__version__}"


def give_up(error: Exception) -> str:
    """Use plain Python from now on, because a small test of machine code has raised this error; why, in words."""
    first = next(iter(str(error).splitlines()), "")
    _failed.append(f"{compiler()} does not do what is needed ({type(error).__name__}: {first})")
    return _failed[0]


def described() -> str:
    """One line for the user: how kernels run, and why if they run as plain Python."""
    if is_native():
        return f"{compiler()}; kernels run as machine code"
    why = _failed[0] if _failed else "RATTLE_JIT=python asks for it"
    return f"kernels run as plain Python, some hundred times slower: {why}"
