"""Machine code for kernels, with the package's own elementary functions."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib import import_module
from pathlib import Path

from rattle.jit import functions

SOURCES = ("elementary.py", "graph.py", "library.py", "llvm.py")  # files of this room that these functions follow from


def start() -> bool:
    """Switch kernels from Python to machine code (no effect with RATTLE_JIT=python); True if it runs now."""
    return functions.start(_text, sources())


def _text() -> str:
    return str(import_module("rattle.trace.library").text_of_machine())  # when no code of it is kept


@cache
def sources() -> str:
    """What the elementary functions are made from, as a short text."""
    digest, here = hashlib.sha256(), Path(__file__)
    for name in SOURCES:
        digest.update(here.with_name(name).read_bytes())
    return digest.hexdigest()[:16]
