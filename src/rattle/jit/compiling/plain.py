"""The plain way to machine code: Numba's own `njit` and arrays.

Nothing is changed for others and no part of Numba is replaced.  Undocumented functions of Numba are used only in
`calls`, `numba_types` and `cache`, to call a function by its address and to keep code; these parts are old and small.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numba
from numba.core.compiler_lock import global_compiler_lock

from rattle.jit import compile_path, functions
from rattle.jit.cache import CodeCache
from rattle.jit.compiling.numba_types import OPTIONS, ORDINARY, signature

lock = global_compiler_lock
ARRAY_TYPES = ORDINARY


def whole(function: Callable[..., Any], letters: Sequence[str], cache: CodeCache | None = None) -> Any:
    """A dispatcher, for calls from Python and compiled functions; with letters, compiled now for that signature."""
    dispatcher = numba.njit(**OPTIONS)(function)
    if cache is not None:
        cache.missed = lambda: functions.say_once(f"compiling kernels (once); {compile_path.described()}")
        dispatcher._cache = cache
    if letters:
        dispatcher.compile(signature(letters))
        dispatcher.disable_compile()
    return dispatcher


def foreign(function: Callable[..., Any], letters: Sequence[str]) -> Any:
    """A dispatcher for a function of the user; compiled at once."""
    return numba.njit(signature(letters), **OPTIONS)(function)
