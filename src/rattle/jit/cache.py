"""Machine code kept on disk, in a folder that nobody else can write; rattle also works without it.

Code read from the folder is executed, so the folder must be the user's own.  If a file is damaged or missing it is
compiled again; a folder that is full or missing costs time, never a result.
"""

from __future__ import annotations

import atexit
import hashlib
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
    """A folder for machine code; its path is None if there is none at all."""

    path: Path | None
    lasting: bool  # False: removed at the end of the process
    why_not: str = ""  # why it is not the usual folder


def code_folder(name: str) -> Folder:
    """The folder `name` of machine code: below RATTLE_CACHE, otherwise ~/.cache/rattle.

    A folder is not used if it belongs to another user, if others can write it, if it is a link or cannot be written;
    a private temporary folder then replaces it for this process.
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
    log.warning(f"machine code is compiled again in every process: {why}; set RATTLE_CACHE to a folder of your own")
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
    """The folder that the environment names.  Raises RuntimeError if there is no home folder."""
    named = os.environ.get("RATTLE_CACHE", "")
    return Path(named).expanduser().absolute() if named else Path.home() / ".cache" / "rattle"


def _require_private(root: Path, folder: Path) -> None:
    """Refuse a folder into which another user could put code.  Raises PermissionError with an explanation."""
    if not hasattr(os, "getuid"):  # on Windows the profile's folders are the user's own
        return
    for path in (folder, root):
        seen = path.lstat()
        shared = path == root and bool(seen.st_mode & stat.S_ISVTX)  # as /tmp: entries belong to who made them
        if not stat.S_ISDIR(seen.st_mode):
            raise PermissionError(f"{path} is a link or not a folder, and is not used")
        if seen.st_uid != os.getuid() and not shared:
            raise PermissionError(f"{path} belongs to another user, and is not used")
        if seen.st_mode & OTHERS and not shared:
            raise PermissionError(f"{path} can be written by others, and is not used (chmod 700 makes it yours)")
    for path in root.resolve().parents:
        mode = path.stat().st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            raise PermissionError(f"{path} can be written by everybody, and nothing below it is used")


# ---------------------------------------------------------------- one file per function
class KeptFile:
    """One kept object: SHA-256 of what follows, and the pickled object.  The folder's name identifies the sources."""

    def __init__(self, folder: Path | None, name: str, key: object) -> None:
        short = DIGEST(repr((name, key)).encode()).hexdigest()[:16]
        self.file = None if folder is None else folder / f"{name}-{short}.code"

    def read(self, use: Callable[[Any], Any] = lambda thing: thing) -> Any:
        """The result of `use` for the kept object; None if there is none; a file that cannot be used is deleted."""
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
        except Exception as error:  # whatever is wrong with a kept file, it can be compiled again
            log.debug(f"{self.file} is compiled again: {error}")
            _drop(self.file)
            return None

    def write(self, pickled: Callable[[], bytes]) -> None:
        """Keep a pickled object if possible."""
        if self.file is None:
            return
        temporary = self.file.with_name(f".{secrets.token_hex(8)}")
        try:
            thing = pickled()
            temporary.write_bytes(DIGEST(thing).digest() + thing)
            os.replace(temporary, self.file)
        except Exception as error:  # full disk, missing folder: the next process compiles again
            log.debug(f"{self.file} was not kept: {error}")
        finally:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


def _drop(file: Path) -> None:
    """Remove the file, link or folder at the place of a code file."""
    with suppress(OSError):
        if file.is_dir() and not file.is_symlink():
            shutil.rmtree(file)
        else:
            file.unlink()
