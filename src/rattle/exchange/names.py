"""Names of another program made names of a model: letters, digits and _, each once, none of them reserved."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

from rattle.description.read_values import TAKEN

LONGEST = 60  # characters


class Names:
    """Hands out names; bodies, joints, drivers and signals of a model share one namespace, points of a body have one.

    `changed` keeps the names that had to be written in another way: of the file, and of the model.
    """

    def __init__(self) -> None:
        self._used: set[str] = set()
        self._last: dict[str, int] = {}  # number behind the name that was handed out last
        self.changed: list[tuple[str, str]] = []

    def new(self, name: str, kind: str) -> str:
        """A free name close to the one of the file; kind: what comes before a name that is a number, or empty."""
        close = _valid(name, kind)
        free, n = close, self._last.get(close, 1)
        while free in self._used:
            n += 1
            free = f"{close}_{n}"
        self._last[close] = n
        self._used.add(free)
        if free != name:
            self.changed.append((name, free))
        return free


def _valid(name: str, kind: str) -> str:
    plain = unicodedata.normalize("NFKD", name[: 4 * LONGEST]).encode("ascii", "ignore").decode()
    close = re.sub(r"[^A-Za-z0-9_]+", "_", plain).strip("_")[:LONGEST]
    if not close or close[0].isdigit():
        close = f"{kind}_{close}" if close else kind
    return f"{close}_" if close in TAKEN else close


def listed(names: Iterable[str], most: int = 12) -> str:
    """Names for a sentence: the first ones, and how many more there are."""
    every = [" ".join(name.split()) for name in names]
    more = f" and {len(every) - most} more" if len(every) > most else ""
    return ", ".join(every[:most]) + more


def counted(many: int, word: str) -> str:
    """A number with its noun: 1 body, 2 bodies."""
    if many == 1:
        return f"1 {word}"
    return f"{many} {word[:-1]}ies" if word.endswith("y") else f"{many} {word}s"
