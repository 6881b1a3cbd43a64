"""The folder of machine code for the present sources: its name depends on everything that machine code depends on."""

from __future__ import annotations

import hashlib
import os
import re
import sys
import threading
from functools import cache
from pathlib import Path

from rattle.jit import mode
from rattle.jit.cache import Folder
from rattle.jit.cache import code_folder as private_folder

# all that defines or compiles kernels, or holds numbers that they contain; a test looks whether others do
COMPILED = ("elements", "equations", "interfaces", "jit", "language", "solvers", "registry.py")
_HERE = Path(__file__).parents[1]
_DECORATED = re.compile(r"^@(compiled|native\(|kernel\()", re.MULTILINE)
_code_folder: Folder | None = None
_folder_lock = threading.Lock()  # a separate lock: it is taken while others are held


def compiled_sources() -> list[Path]:
    """Files on which machine code depends."""
    return sorted(
        file for name in COMPILED for file in ((_HERE / name).rglob("*.py") if "." not in name else [_HERE / name])
    )


@cache
def compiled_modules() -> tuple[str, ...]:
    """Modules that define compiled functions."""
    paths = (path for path in compiled_sources() if _DECORATED.search(path.read_text(encoding="utf-8")))
    return tuple(sorted(".".join(("rattle", *path.relative_to(_HERE).with_suffix("").parts)) for path in paths))


def code_folder() -> Folder:
    """The folder of machine code: one for each state of the sources, version of LLVM's package and of Python."""
    global _code_folder
    if _code_folder is None:
        about = mode.compiler(), sys.version, str(_HERE), os.environ.get("RATTLE_BOUNDSCHECK", "")
        digest = hashlib.sha256(repr(about).encode())
        for source in compiled_sources():
            digest.update(source.read_bytes())
        with _folder_lock:
            _code_folder = _code_folder or private_folder(digest.hexdigest()[:16])
    return _code_folder


def cache_folder() -> Path | None:
    """The folder of kept machine code; None if there is none."""
    return code_folder().path
