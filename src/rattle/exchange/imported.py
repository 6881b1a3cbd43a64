"""A mechanism that was read from a file of another program, and what that file did not say or could not give."""

from __future__ import annotations

from typing import Any, NamedTuple


class Assumptions(NamedTuple):
    """What a user states of a file whose format has no units, masses or times; None: what the format's reader takes."""

    scale: float | None = None  # length of a unit of the file [m]
    steps_per_second: float | None = None
    thickness: float | None = None  # of plates that are drawn as outlines [m]
    density: float | None = None  # of their material [kg/m^3]


class Imported(NamedTuple):
    """A mechanism of another program as the tables of a model file, in the order in which they are written."""

    document: dict[str, Any]
    source: str  # a comment on top of the text: which program's file it was
    taken: tuple[str, ...] = ()  # by the names that things have in the file
    assumed: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
