"""The folder of machine code for the present sources: its name depends on everything that machine code depends on."""

from __future__ import annotations

import hashlib
import os
import re
import sys
import threading
from pathlib import Path

from rattle.jit import cache, compile_path
from rattle.jit.cache import Folder

MAKERS = ("compile_path", "families", "functions", "machine", "workspace")  # and these folders
MAKING = ("compiling", "translation")


def compiled_sources() -> list[Path]:
    """Files on which machine code depends: those with compiled functions, those that compile, and all they import."""
    here = Path(__file__).parents[1]
    text = {path: path.read_text(encoding="utf-8") for path in here.rglob("*.py")}
    makers = [here / "jit" / f"{name}.py" for name in MAKERS]
    makers += [file for folder in MAKING for file in (here / "jit" / folder).glob("*.py")]
    found = {path for path, source in text.items() if _DECORATED.search(source)} | set(makers)
    ahead = list(found)
    while ahead:
        for module, names in _IMPORTED.findall(text[ahead.pop()]):
            parts = module.split(".")[1:]
            folder = here.joinpath(*parts)
            for path in (folder.with_suffix(".py"), *(folder / f"{name}.py" for name in _NAME.findall(names))):
                if path in text and path not in found:
                    found.add(path)
                    ahead.append(path)
    return sorted(found)


def compiled_modules() -> list[str]:
    """Modules that define compiled functions."""
    here = Path(__file__).parents[1]
    found = (path for path in here.rglob("*.py") if _DECORATED.search(path.read_text(encoding="utf-8")))
    return sorted(".".join(("rattle", *path.relative_to(here).with_suffix("").parts)) for path in found)


_DECORATED = re.compile(r"^@(compiled|native\(|kernel\()", re.MULTILINE)
_IMPORTED = re.compile(r"^from (rattle[\w.]*) import (\([^)]*\)|.*)$", re.MULTILINE)
_NAME = re.compile(r"\w+")


def code_folder() -> Folder:
    """The folder of machine code: one for each state of the sources, version of Numba and way of compiling."""
    global _code_folder
    if _code_folder is None:
        here = Path(__file__).parents[1]
        way = "fast" if compile_path.chosen().fast else "plain"
        about = [way, *compile_path.compilers(), sys.version, str(here)]
        about += [os.environ.get(name, "") for name in _NUMBA_READS]
        digest = hashlib.sha256(repr(about).encode())
        for source in compiled_sources():
            digest.update(source.read_bytes())
        with _folder_lock:
            _code_folder = _code_folder or cache.code_folder(digest.hexdigest()[:16])
    return _code_folder


def forget_folder() -> None:
    """Choose the folder again after the way of compiling has changed."""
    global _code_folder
    _code_folder = None


def cache_folder() -> Path | None:
    """The folder of kept machine code; None if there is none."""
    return code_folder().path


# settings of Numba that change machine code
_NUMBA_READS = ("NUMBA_BOUNDSCHECK", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NUMBA_ENABLE_AVX", "NUMBA_OPT")
_code_folder: Folder | None = None
_folder_lock = threading.Lock()  # a separate lock: it is taken while others are held
