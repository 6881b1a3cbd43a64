"""Declarations of the columns of the arrays of a run: name, unit and meaning of every column in order, one per line."""

from __future__ import annotations

import re
from typing import NamedTuple


class Column(NamedTuple):
    """One column of an array."""

    unit: str
    meaning: str


COLUMNS: dict[str, dict[str, Column]] = {}  # array -> name -> unit and meaning, in order


def declare(array: str, text: str) -> None:
    """Enter the columns of an array from lines "NAME [unit] meaning"."""
    matches = (re.fullmatch(r"\s*(\w+) \[(.*?)\] (.+)", line) for line in text.strip().splitlines())
    COLUMNS[array] = {line[1]: Column(line[2], line[3]) for line in matches if line}


def width(array: str) -> int:
    """Number of columns of an array."""
    return len(COLUMNS[array])
