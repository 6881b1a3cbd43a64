"""Recorded numbers that tell where their record is lost.

A `Recorded` is a float: a function of C, or `float(x)`, takes its value and leaves its record behind.  A `Watched`
passes for a `Recorded`, but whatever asks for its value has to ask itself, which is kept.  So a calculation with
watched numbers shows that everything which follows from them, and every decision, is in the record.
"""

from __future__ import annotations

import sys
from typing import Any

from rattle.errors import TraceError
from rattle.language import bytecode
from rattle.language.recorded import Flag, Journal, Operand, Recorded, bare, symbol_of


class Watch:
    """What watched numbers tell."""

    def __init__(self) -> None:
        self.lost: list[str] = []  # where records were left behind: file and line

    def require_record(self) -> None:
        """Raise TraceError where a record was left behind."""
        if self.lost:
            raise TraceError(f"a value is taken without its record in {self.lost[0]}")

    def tell(self) -> None:
        """Keep the place that asks for a value."""
        frame = sys._getframe(2)
        self.lost.append(f"{frame.f_code.co_filename}:{frame.f_lineno}")


class Watched:
    """A number [SI], its symbol, and who is told where the record is lost."""

    __slots__ = ("bare", "journal", "symbol", "watch")

    def __init__(self, value: float, symbol: Operand, journal: Journal, watch: Watch) -> None:
        self.bare, self.symbol, self.journal, self.watch = value, symbol, journal, watch

    @property  # type: ignore[misc]  # mypy knows no property of this name
    def __class__(self) -> Any:  # what isinstance asks
        return Recorded

    def made(self, value: float, symbol: Operand) -> Watched:
        """Another number with a record, which follows from this one."""
        return Watched(value, symbol, self.journal, self.watch)

    def _kept(self, condition: Flag, holds: bool) -> bool:
        self.journal.assume(condition, holds)
        return holds

    # ---------------------------------------------------------------- the value is taken
    def __float__(self) -> float:
        self.watch.tell()
        return self.bare

    def __int__(self) -> int:
        self.watch.tell()
        return int(self.bare)

    __trunc__ = __int__

    def __round__(self, digits: int | None = None) -> float:
        self.watch.tell()
        return round(self.bare, digits)

    def __format__(self, form: str) -> str:
        self.watch.tell()
        return format(self.bare, form)

    def __repr__(self) -> str:
        self.watch.tell()
        return repr(self.bare)

    def __hash__(self) -> int:
        self.watch.tell()
        return hash(self.bare)

    def __mod__(self, other: float) -> float:
        self.watch.tell()
        return self.bare % other

    def __rmod__(self, other: float) -> float:
        self.watch.tell()
        return other % self.bare

    def __floordiv__(self, other: float) -> float:
        self.watch.tell()
        return self.bare // other

    def __rfloordiv__(self, other: float) -> float:
        self.watch.tell()
        return other // self.bare

    # ---------------------------------------------------------------- the record goes on
    def __add__(self, other: float) -> Watched:
        return self.made(self.bare + bare(other), self.symbol + symbol_of(other))

    __radd__ = __add__

    def __sub__(self, other: float) -> Watched:
        return self.made(self.bare - bare(other), self.symbol - symbol_of(other))

    def __rsub__(self, other: float) -> Watched:
        return self.made(bare(other) - self.bare, symbol_of(other) - self.symbol)

    def __mul__(self, other: float) -> Watched:
        return self.made(self.bare * bare(other), self.symbol * symbol_of(other))

    __rmul__ = __mul__

    def __truediv__(self, other: float) -> Watched:
        return self.made(self.bare / bare(other), self.symbol / symbol_of(other))

    def __rtruediv__(self, other: float) -> Watched:
        return self.made(bare(other) / self.bare, symbol_of(other) / self.symbol)

    def __pow__(self, other: float) -> Watched:
        return self.made(self.bare ** bare(other), self.journal.operation(bytecode.POW, self.symbol, symbol_of(other)))

    def __rpow__(self, other: float) -> Watched:
        return self.made(bare(other) ** self.bare, self.journal.operation(bytecode.POW, symbol_of(other), self.symbol))

    def __neg__(self) -> Watched:
        return self.made(-self.bare, -self.symbol)

    def __pos__(self) -> Watched:
        return self

    def __abs__(self) -> Watched:
        return self.made(abs(self.bare), abs(self.symbol))

    def __lt__(self, other: float) -> bool:
        return self._kept(self.symbol < symbol_of(other), self.bare < bare(other))

    def __le__(self, other: float) -> bool:
        return self._kept(self.symbol <= symbol_of(other), self.bare <= bare(other))

    def __gt__(self, other: float) -> bool:
        return self._kept(self.symbol > symbol_of(other), self.bare > bare(other))

    def __ge__(self, other: float) -> bool:
        return self._kept(self.symbol >= symbol_of(other), self.bare >= bare(other))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, int | float):
            return False
        return self._kept(self.symbol == symbol_of(other), self.bare == bare(other))

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __bool__(self) -> bool:
        return self != 0.0
