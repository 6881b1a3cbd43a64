"""Writing files so that a reader never meets half of one, and nothing else is harmed."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
import signal
import stat
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

TERMINATED = 128 + 15  # exit status of a program that SIGTERM ended


def writable(path: str | os.PathLike[str]) -> Path:
    """The file that `path` means. Raises an OSError that says why it cannot be written and what to do."""
    target = Path(path).expanduser()
    if is_special(target):
        return _special(target)
    target = Path(os.path.realpath(target)) if target.is_symlink() else target
    if target.is_symlink():
        raise OSError(errno.ELOOP, f"cannot write {target}: its links lead round in a circle")
    folder = target.parent
    if target.is_dir():
        raise IsADirectoryError(f"cannot write {target}: it is a folder; give a file name")
    if not folder.exists():
        raise FileNotFoundError(f"cannot write {target}: the folder {folder} does not exist; create it first")
    if not folder.is_dir():
        raise NotADirectoryError(f"cannot write {target}: {folder} is not a folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"cannot write {target}: no permission to write in the folder {folder}")
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(f"cannot write {target}: the file is read-only")
    return target


def is_special(path: str | os.PathLike[str]) -> bool:
    """True for what is there but no plain file or folder: a device, a pipe, the program's own output."""
    try:
        seen = os.stat(path)
    except (OSError, ValueError):
        return False
    return not (stat.S_ISREG(seen.st_mode) or stat.S_ISDIR(seen.st_mode)) or _stream(seen) is not None


def _stream(seen: os.stat_result) -> Any:
    """The program's own output stream that is this file, if one is."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # closed, or not a file at all
            if os.path.samestat(os.fstat(stream.fileno()), seen):
                return stream
    return None


def _special(target: Path) -> Path:
    mode = target.stat().st_mode
    if stat.S_ISBLK(mode) or stat.S_ISSOCK(mode):
        raise OSError(errno.EINVAL, f"cannot write {target}: it is a {'disk' if stat.S_ISBLK(mode) else 'socket'}")
    if not os.access(target, os.W_OK):
        raise PermissionError(f"cannot write {target}: no permission")
    return target


def refuse_input(path: str | os.PathLike[str], *inputs: str | os.PathLike[str]) -> None:
    """Raise an OSError where a file to be written is one of those that are read."""
    for one in inputs:
        with suppress(FileNotFoundError):
            if os.path.samefile(path, one):
                raise FileExistsError(f"cannot write {path}: it is the file that is read; give another name")


@contextmanager
def atomic(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary name beside `path`; what is written there takes the place of `path` at the end.

    The temporary name keeps the suffix, from which writers choose their format.  If anything goes
    wrong nothing is left behind and an older file stays as it was; its permissions are kept.
    Devices and pipes are written to, never replaced; of a file with several names (hard links) the content is.

        with atomic("out.csv") as file:
            file.write_text(text)

    Raises an OSError (of the kind the system gave) that names `path` and what to do.
    """
    target = writable(path)
    folder = Path(tempfile.gettempdir()) if is_special(target) else target.parent
    temporary = folder / f".{target.stem[:100]}-{secrets.token_hex(4)}{target.suffix}"
    try:
        with _orderly_end():
            yield temporary
            _put(temporary, target)
    except OSError as error:
        named = type(error)(f"cannot write {target}: {error.strerror or error}")
        named.errno = error.errno
        raise named from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _put(temporary: Path, target: Path) -> None:
    """The finished temporary file becomes the target."""
    with temporary.open("r+b") as file:
        os.fsync(file.fileno())
    if not target.exists():
        os.replace(temporary, target)
        return
    seen = target.stat()
    if is_special(target):
        with temporary.open("rb") as source, _opened(target, seen) as out:
            shutil.copyfileobj(source, out)
    elif seen.st_nlink > 1:
        with temporary.open("rb") as source, target.open("r+b") as out:
            shutil.copyfileobj(source, out)
            out.truncate()
    else:
        if hasattr(os, "chown"):
            with suppress(OSError):
                os.chown(temporary, seen.st_uid, seen.st_gid)
        with suppress(OSError):
            os.chmod(temporary, stat.S_IMODE(seen.st_mode))
        os.replace(temporary, target)


def _opened(target: Path, seen: os.stat_result) -> Any:
    """A device or pipe for writing; the program's own output goes on where it is."""
    stream = _stream(seen)
    if stream is None:
        return target.open("wb")
    stream.flush()
    return os.fdopen(os.dup(stream.fileno()), "wb")


@contextmanager
def _orderly_end() -> Iterator[None]:
    """Inside, SIGTERM ends the program as an exception does: what was begun is cleared away."""
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return

    def end(number: int, frame: Any) -> None:
        raise SystemExit(TERMINATED)

    signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
