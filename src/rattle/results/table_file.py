"""Tables as plain text: which names of files stand for them, and writing a data frame."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from rattle.atomic_file import atomic
from rattle.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame

TABLES = (".csv", ".txt", ".dat", "")  # suffixes under which text is expected


def require_table(path: str | os.PathLike[str]) -> None:
    """Raise InputError for a file name whose suffix belongs to another format than CSV."""
    if Path(path).suffix.lower() not in TABLES:
        raise InputError(f"{os.fspath(path)}: curves are written as plain text; give a name ending in .csv")


def write_frame(frame: DataFrame, path: str | os.PathLike[str]) -> Path:
    """Write a data frame as CSV, completely or not at all; the path.

    Raises InputError for a suffix of another format, OSError.
    """
    require_table(path)
    with atomic(Path(path)) as file:
        frame.to_csv(file, index=False, lineterminator="\n")
    return Path(path)
