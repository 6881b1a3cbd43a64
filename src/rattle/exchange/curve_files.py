"""Files of curves for other programs, by the endings of their names: text, workbooks, MATLAB files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from rattle.errors import InputError
from rattle.exchange import matlab, result_workbook
from rattle.results.result import Result
from rattle.results.table_file import TABLES

WRITERS = {result_workbook.SUFFIX: Result.to_excel, matlab.SUFFIX: Result.to_mat}


def require_curve_file(path: str | os.PathLike[str]) -> None:
    """Raise InputError for a file name whose ending says none of these formats."""
    if Path(path).suffix.lower() not in (*TABLES, *WRITERS):
        raise InputError(
            f"{os.fspath(path)}: curves are written as text, workbook or MATLAB file; give a name ending in .csv,"
            f" {' or '.join(WRITERS)}"
        )


def write_curves(
    result: Result, path: str | os.PathLike[str], *, fallback: str | os.PathLike[str] | None = None,
    names: Sequence[str] | None = None,
) -> Path:  # fmt: skip
    """Write curves in the format that a name says; arguments, return value and errors as of `Result.to_csv`."""
    require_curve_file(path)
    write = WRITERS.get(Path(path).suffix.lower(), Result.to_csv)
    return write(result, path, fallback=fallback, names=names)
