"""Writing files completely or not at all, without damage to any other file."""

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

from rattle.user_paths import expanded

TERMINATED = 128 + 15  # exit status of a program that SIGTERM ended


def writable(path: str | os.PathLike[str]) -> Path:
    """The file that `path` refers to.  Raises an OSError that says why it cannot be written and what to do."""
    target = expanded(path)
    if is_special(target):
        return _special(target)
    target = Path(os.path.realpath(target)) if target.is_symlink() else target
    if target.is_symlink():
        raise OSError(errno.ELOOP, f"cannot write {target}: its symbolic links form a circle")
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
    """True if `path` exists but is not a plain file or folder: a device, a pipe, the program's own output."""
    try:
        seen = os.stat(path)
    except (OSError, ValueError):
        return False
    return not (stat.S_ISREG(seen.st_mode) or stat.S_ISDIR(seen.st_mode)) or _stream(seen) is not None


def _stream(seen: os.stat_result) -> Any:
    """The output stream of this program (stdout, stderr) that is the file `seen`, or None."""
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
    """Raise an OSError if the file to be written is one of the input files."""
    for source in inputs:
        with suppress(FileNotFoundError):
            if os.path.samefile(path, source):
                raise FileExistsError(f"cannot write {path}: it is the input file; give another name")


@contextmanager
def atomic(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary file name in the folder of `path`; on success that file replaces `path`.

    The temporary name keeps the suffix, from which writers choose their format.  After a failure nothing is left
    behind and an existing file is unchanged.  A file that is replaced keeps its permissions.
    Devices and pipes are written to, not replaced; so is a file with several names (hard links).

        with atomic("out.csv") as file:
            file.write_text(text)

    Raises an OSError (of the same class as the system's) that names `path` and says what is wrong.
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
    """Move or copy the finished temporary file to the target."""
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
    """A device or pipe opened for writing; the program's own output is continued at its position."""
    stream = _stream(seen)
    if stream is None:
        return target.open("wb")
    stream.flush()
    return os.fdopen(os.dup(stream.fileno()), "wb")


@contextmanager
def _orderly_end() -> Iterator[None]:
    """While active, SIGTERM ends the program through an exception, so that temporary files are removed."""
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
