"""Tokens of expressions: numbers, numbers with units, names and operators."""

from __future__ import annotations

import functools
import re

from rattle.errors import InputError
from rattle.language.units import FoundUnit, unit_at

_REFUSED = {
    "^": "'^' is not an operator; use ** for powers",
    "=": "'=' is not allowed in an expression; compare with < <= > >=",
    '"': "an expression cannot contain text",
    "'": "an expression cannot contain text",
    "[": "an expression cannot contain indices",
}


class ExpressionError(InputError):
    """A fault in an expression; `column` is where it stands, in characters counted from 0."""

    def __init__(self, message: str, column: int = 0) -> None:
        super().__init__(message)
        self.message = message
        self.column = column


_NUMBER = r"(?:[0-9]++(?:\.[0-9]*+)?+|\.[0-9]++)(?:[eE][+-]?[0-9]++)?+"


_TIME = re.compile(r"\s*+t\b")  # behind a number: the time rather than a ton


@functools.cache
def _token(parts: int) -> re.Pattern[str]:
    """Pattern of one token; a name has at most so many parts."""
    return re.compile(
        r"(?P<space>\s++)|(?P<number>" + _NUMBER + ")"
        r"|(?P<name>[A-Za-z_]\w*+" + r"(?:\.[A-Za-z_]\w*+)?+" * (parts - 1) + ")"
        r"|(?P<operator>\*\*|<=|>=|[-+*/(),<>])",
        re.ASCII,
    )


def tokens(text: str, parts: int, possible: str) -> list[tuple[str, str, int]]:
    """Kind ("number", "quantity", "name", "operator", "end"), word and column of every token.

    parts: of a name, at most; possible: what is said of one with more.  Raises ExpressionError.
    """
    read: list[tuple[str, str, int]] = []
    at = 0
    while at < len(text):
        match = _token(parts).match(text, at)
        if match is None:
            shown = text[at] if text[at].isprintable() else repr(text[at])[1:-1]
            if text[at] == "." and read and read[-1][0] == "name":
                raise ExpressionError(f"'{read[-1][1]}.' has too many parts; {possible}", at)
            raise ExpressionError(_REFUSED.get(text[at], f"unexpected character '{shown}'"), at)
        end = match.end()
        unit = unit_at(text, end) if match.lastgroup == "number" else None
        if unit is not None and not _TIME.match(text, end):
            read.append(("quantity", text[at : unit.end], at))
            end = unit.end
        elif match.lastgroup != "space":
            read.append((match.lastgroup or "", match[0], at))
        at = end
    read.append(("end", "", len(text.rstrip())))
    return read


def number_of(quantity: str) -> tuple[float, FoundUnit]:
    """The number and the unit of a token of that kind."""
    number = re.match(_NUMBER, quantity)
    assert number is not None
    unit = unit_at(quantity, number.end())
    assert unit is not None
    return float(number[0]), unit
