"""Writing files so that a reader never meets half of one."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def writable(path: str | os.PathLike[str]) -> Path:
    """The file that `path` means. Raises an OSError that says why it cannot be written and what to do."""
    target = Path(path).expanduser()
    target = target.resolve() if target.is_symlink() else target
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


@contextmanager
def atomic(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary name beside `path`; what is written there takes the place of `path` at the end.

    The temporary name keeps the suffix, from which writers choose their format.  If anything goes
    wrong nothing is left behind and an older file stays as it was.

        with atomic("out.csv") as file:
            file.write_text(text)

    Raises an OSError (of the kind the system gave) that names `path` and what to do.
    """
    target = writable(path)
    temporary = target.parent / f".{target.stem[:100]}-{secrets.token_hex(4)}{target.suffix}"
    try:
        yield temporary
        os.replace(temporary, target)
    except OSError as error:
        raise type(error)(f"cannot write {target}: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)
