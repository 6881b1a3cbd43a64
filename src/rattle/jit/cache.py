"""Machine code kept on disk: in a folder that nobody else can write, and never needed.

What is read back is run, so the folder must be the user's own.  A file that is damaged or missing is compiled
again; a folder that is full or gone costs time, never a result.
"""

from __future__ import annotations

import atexit
import hashlib
import importlib
import logging
import os
import pickle
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

log = logging.getLogger("rattle")
DIGEST = hashlib.sha256
OTHERS = stat.S_IWGRP | stat.S_IWOTH


class Folder(NamedTuple):
    """Where machine code is kept; None where there is no place at all."""

    path: Path | None
    lasting: bool  # False: gone at the end of the process
    why_not: str = ""  # why it is not the folder that was meant


def code_folder(name: str) -> Folder:
    """The folder `name` of machine code: below RATTLE_CACHE, else ~/.cache/rattle.

    One that belongs to somebody else, that others may write, that is a link or cannot be written is not used; a
    private temporary folder takes its place for this process.
    """
    try:
        root = _root()
        folder = root / name
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        _require_private(root, folder)
        with tempfile.TemporaryFile(dir=folder):
            pass
        return Folder(folder, True)
    except (OSError, RuntimeError, ValueError) as error:
        why = _reason(error)
    log.warning(f"machine code is compiled anew in every process: {why}; set RATTLE_CACHE to a folder of your own")
    try:
        private = Path(tempfile.mkdtemp(prefix="rattle-"))
    except OSError:
        return Folder(None, False, why)
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    return Folder(private, False, why)


def _reason(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename or 'the folder for it'}: {error.strerror}"
    return str(error)


def _root() -> Path:
    """The folder that the environment names.  Raises RuntimeError where there is no home."""
    given = os.environ.get("RATTLE_CACHE", "")
    return Path(given).expanduser().absolute() if given else Path.home() / ".cache" / "rattle"


def _require_private(root: Path, folder: Path) -> None:
    """Refuse a folder into which somebody else could put code.  Raises PermissionError with an explanation."""
    if not hasattr(os, "getuid"):  # on Windows the profile's folders are the user's own
        return
    for path in (folder, root):
        seen = path.lstat()
        shared = path == root and bool(seen.st_mode & stat.S_ISVTX)  # as /tmp: entries belong to who made them
        if not stat.S_ISDIR(seen.st_mode):
            raise PermissionError(f"{path} is a link or no folder, and is not used")
        if seen.st_uid != os.getuid() and not shared:
            raise PermissionError(f"{path} belongs to another user, and is not used")
        if seen.st_mode & OTHERS and not shared:
            raise PermissionError(f"{path} can be written by others, and is not used (chmod 700 makes it yours)")
    for path in root.resolve().parents:
        mode = path.stat().st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            raise PermissionError(f"{path} can be written by everybody, and nothing below it is used")


# ---------------------------------------------------------------- one file per function and signature
class KeptFile:
    """One kept thing: SHA-256 of what follows, and the pickled thing.  The folder's name stands for all sources."""

    def __init__(self, folder: Path | None, name: str, key: Any) -> None:
        short = DIGEST(repr((name, key)).encode()).hexdigest()[:16]
        self.file = None if folder is None else folder / f"{name}-{short}.code"

    def read(self, use: Callable[[Any], Any] = lambda thing: thing) -> Any:
        """What `use` makes of the thing; None where there is none, and what could not be used is thrown away."""
        if self.file is None:
            return None
        try:
            content = self.file.read_bytes()
            digest, thing = content[: DIGEST().digest_size], content[DIGEST().digest_size :]
            if DIGEST(thing).digest() != digest:
                raise ValueError("damaged")
            return use(pickle.loads(thing))
        except FileNotFoundError:
            return None
        except Exception as error:  # whatever is wrong with a kept file, compiling is the remedy
            log.debug(f"{self.file} is compiled again: {error}")
            _drop(self.file)
            return None

    def write(self, pickled: Callable[[], bytes]) -> None:
        """Keep a pickled thing where that is possible."""
        if self.file is None:
            return
        temporary = self.file.with_name(f".{secrets.token_hex(8)}")
        try:
            thing = pickled()
            temporary.write_bytes(DIGEST(thing).digest() + thing)
            os.replace(temporary, self.file)
        except Exception as error:  # a full disk, a folder that is gone: the next process compiles again
            log.debug(f"{self.file} was not kept: {error}")
        finally:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


class CodeCache:
    """What a Numba dispatcher asks for compiled code; stands in for `numba.core.caching.FunctionCache`."""

    def __init__(self, function: Callable[..., Any], folder: Callable[[], Path | None]) -> None:
        self.name = f"{function.__module__}.{function.__qualname__}"
        self.folder = folder
        self.missed: Callable[[], None] = lambda: None  # called where something has to be compiled

    @property
    def cache_path(self) -> str | None:
        """The folder, as Numba's statistics show it."""
        folder = self.folder()
        return None if folder is None else str(folder)

    def _kept(self, signature: Any, codegen: Any) -> KeptFile:
        return KeptFile(self.folder(), self.name, (str(signature), codegen.magic_tuple()))

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """The compiled function, or None: then it is compiled, and what could not be read is thrown away."""
        target_context.refresh()
        compiler: Any = importlib.import_module("numba.core.compiler")
        found = self._kept(signature, target_context.codegen()).read(
            lambda state: compiler.CompileResult._rebuild(target_context, *state)
        )
        if found is None:
            self.missed()
        return found

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep a compiled function where that is possible."""
        if result.library.has_dynamic_globals or any(not one.can_cache for one in result.lifted):
            return
        serialize: Any = importlib.import_module("numba.core.serialize")
        self._kept(signature, result.codegen).write(lambda: serialize.dumps(result._reduce()))

    def enable(self) -> None:
        """Numba's own switch; kept code is always used."""

    def disable(self) -> None:
        """Numba's own switch; kept code is always used."""

    def flush(self) -> None:
        """Forget nothing: files are thrown away one by one, when they turn out to be damaged."""


def _drop(file: Path) -> None:
    """Take away what stands in place of a file of code."""
    with suppress(OSError):
        if file.is_dir() and not file.is_symlink():
            shutil.rmtree(file)
        else:
            file.unlink()
