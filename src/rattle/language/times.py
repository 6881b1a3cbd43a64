"""Times given as numbers in s or as texts such as "20 ms"."""

from __future__ import annotations

from typing import Any

from rattle.language.quantities import Quantity, in_si

Seconds = Quantity  # a time: a number in s, or a text such as "20 ms"


def seconds(value: Seconds, what: str) -> float:
    """A time in s, given as a number or as a text such as "20 ms".

    what: the name of the argument, for messages.  Raises ValueError if the text or number is not a time, TypeError for
    other types.
    """
    return in_si(value, what, "s", '0.02 or "20 ms"')


def seconds_or_none(value: Seconds | None, what: str) -> float | None:
    """A time in s as `seconds` reads it, or None if None is given.  Raises as `seconds` does."""
    return None if value is None else seconds(value, what)


def times(value: Any, what: str) -> Any:
    """One time or a list of times in s, with texts converted as by `seconds`; other values are returned unchanged.

    Raises as `seconds` does.
    """
    if isinstance(value, str):
        return seconds(value, what)
    if isinstance(value, list | tuple) and any(isinstance(part, str) for part in value):
        return [seconds(part, what) for part in value]
    return value
