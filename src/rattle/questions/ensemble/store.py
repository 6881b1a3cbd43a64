"""Where the pieces of an ensemble are kept: in memory; `folder` keeps them in files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from rattle.errors import InputError
from rattle.questions.ensemble.pieces import WAITING, Piece

MOST_BYTES = 1e9  # of histories in memory


class Store(Protocol):
    """The pieces of n samples of k parameters and o outputs."""

    @property
    def place(self) -> str:
        """Where they are kept beyond the life of this process, "" if nowhere."""

    def add(self, piece: Piece) -> None:
        """Keep a piece.  Raises OSError if it cannot be written; those before it are kept."""

    def missing(self) -> list[tuple[int, int]]:
        """Ranges (first, last) of samples that have not been run, increasing."""

    def column(self, name: str) -> np.ndarray:
        """(n,) a parameter or output [SI], nan where it is not known."""

    def curves(self, name: str) -> np.ndarray:
        """(n, m) histories [SI], nan where they are not known."""

    def curve(self, name: str, sample: int) -> np.ndarray:
        """(m,) the history of a sample [SI], nan where it is not known."""

    def status(self) -> np.ndarray:
        """(n,) int8, see `pieces`."""

    def generic(self) -> np.ndarray:
        """(n,) bool: run one by one."""

    def messages(self) -> dict[int, str]:
        """Why samples failed, by number."""

    def reasons(self) -> dict[str, int]:
        """Why samples could not run side by side, and how many."""


class Memory:
    """All pieces as arrays."""

    def __init__(
        self, parameters: Sequence[str], outputs: Sequence[str], count: int, histories: Sequence[str] = (),
        instants: int = 0,
    ) -> None:  # fmt: skip
        """Raises InputError for histories that take too much memory."""
        size = 8.0 * len(histories) * count * instants
        if size > MOST_BYTES:
            raise InputError(
                f"histories: {count} samples of {len(histories)} curves take {size / 1e9:.1f} GB; in memory at most"
                f" {MOST_BYTES / 1e9:g} GB are kept: give a folder"
            )
        self._histories = list(histories)
        self._curves = np.full((len(histories), count, instants), np.nan)
        self._names = [*parameters, *outputs]
        self._values = np.full((len(self._names), count), np.nan)
        self._status = np.full(count, WAITING, dtype=np.int8)
        self._generic = np.zeros(count, dtype=bool)
        self._messages: dict[int, str] = {}
        self._reasons: dict[str, int] = {}

    @property
    def place(self) -> str:
        """Nowhere."""
        return ""

    def add(self, piece: Piece) -> None:
        """Keep a piece."""
        place = slice(piece.first, piece.last)
        self._values[:, place] = np.concatenate([piece.parameters, piece.values])
        self._status[place], self._generic[place] = piece.status, piece.generic
        self._messages |= piece.messages
        if self._histories:
            self._curves[:, place] = piece.curves
        add_counts(self._reasons, piece.reasons)

    def missing(self) -> list[tuple[int, int]]:
        """Ranges (first, last) of samples that have not been run, increasing."""
        return gaps(self._status != WAITING)

    def column(self, name: str) -> np.ndarray:
        """(n,) a parameter or output [SI], nan where it is not known."""
        return np.asarray(self._values[self._names.index(name)])

    def curves(self, name: str) -> np.ndarray:
        """(n, m) histories [SI], nan where they are not known."""
        return np.asarray(self._curves[self._histories.index(name)])

    def curve(self, name: str, sample: int) -> np.ndarray:
        """(m,) the history of a sample [SI], nan where it is not known."""
        return np.asarray(self._curves[self._histories.index(name), sample])

    def status(self) -> np.ndarray:
        """(n,) int8, see `pieces`."""
        return self._status

    def generic(self) -> np.ndarray:
        """(n,) bool: run one by one."""
        return self._generic

    def messages(self) -> dict[int, str]:
        """Why samples failed, by number."""
        return self._messages

    def reasons(self) -> dict[str, int]:
        """Why samples could not run side by side, and how many."""
        return self._reasons


def add_counts(counts: dict[str, int], more: Mapping[str, int]) -> None:
    """Add numbers to those under the same names."""
    for reason, count in more.items():
        counts[reason] = counts.get(reason, 0) + count


def gaps(done: np.ndarray) -> list[tuple[int, int]]:
    """Ranges (first, last) where done (n,) is false."""
    edges = np.flatnonzero(np.diff(np.concatenate([[True], done, [True]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
