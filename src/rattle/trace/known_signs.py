"""Symbols whose signs are known where they count: kernels of laws ask for them before they compute."""

from __future__ import annotations

from rattle.language.recorded import Flag, Operand
from rattle.trace.graph import Symbol, select

SHALLOW = 1e-30  # least depth for which laws are computed: a step may end beyond that of a contact [m or rad]


class Positive(Symbol):
    """A symbol that is positive where it counts."""

    __slots__ = ()

    def __le__(self, other: Operand) -> Flag:
        return False if isinstance(other, float | int) and other <= 0.0 else super().__le__(other)

    def __gt__(self, other: Operand) -> Flag:
        return True if isinstance(other, float | int) and other <= 0.0 else super().__gt__(other)


class Depth(Symbol):
    """A gap of either sign whose size is a depth of laws."""

    __slots__ = ()

    def __abs__(self) -> Operand:
        size = super().__abs__()
        return positive(select(size > SHALLOW, size, SHALLOW))


def positive(x: Operand) -> Operand:
    """The same number, known to be positive where it counts."""
    return Positive(x.graph, x.place) if isinstance(x, Symbol) else x
