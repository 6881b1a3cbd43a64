"""The tables of named data, read from files of the package when they are first asked for."""

from __future__ import annotations

import csv
import functools
from collections.abc import Mapping, Sequence
from importlib import resources

Row = Mapping[str, str]


@functools.cache
def rows(name: str) -> Sequence[Row]:
    """Rows of a table of this room by the names of their columns; lines that begin with # name its source."""
    text = (resources.files("rattle.catalogue") / "data" / f"{name}.csv").read_text(encoding="utf-8")
    return tuple(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def in_mm(metres: float) -> float:
    """A size [m] in mm, rounded so that 0.006 m is 6 mm and lies in the range that ends there."""
    return round(metres * 1e3, 9)


def in_metres(micrometres: float) -> float:
    """A size [um] in m, rounded once."""
    return micrometres / 1e6
