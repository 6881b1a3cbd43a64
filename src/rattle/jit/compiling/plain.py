"""The plain way to machine code: Numba's own `njit` and arrays, for versions of Numba that the fast way does not know.

Nothing is changed for others and no part of Numba is replaced.  Undocumented functions of Numba are used only in
`calls`, `numba_types` and `cache`, to call a function by its address and to keep code; these parts are old and small.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import Any

import numba
from numba.core.compiler_lock import global_compiler_lock

from rattle.jit import compile_path
from rattle.jit.cache import CodeCache
from rattle.jit.compiling.numba_types import OPTIONS, ORDINARY, signature

log = logging.getLogger("rattle")
lock = global_compiler_lock
ARRAY_TYPES = ORDINARY


def whole(function: Callable[..., Any], letters: Sequence[str], cache: CodeCache | None = None) -> Any:
    """A dispatcher, for calls from Python and compiled functions; with letters, compiled now for that signature."""
    dispatcher = numba.njit(**OPTIONS)(function)
    if cache is not None:
        cache.missed = _say_once
        dispatcher._cache = cache
    if letters:
        dispatcher.compile(signature(letters))
        dispatcher.disable_compile()
    return dispatcher


_said: list[str] = []


def _say_once() -> None:
    """Tell the user, once, that something is being compiled and not just read from the cache."""
    if not _said:
        _said.append(f"compiling kernels (once); {compile_path.described()}")
        log.info(_said[0])


def foreign(function: Callable[..., Any], letters: Sequence[str]) -> Any:
    """A dispatcher for a function of the user; compiled at once."""
    return numba.njit(signature(letters), **OPTIONS)(function)
