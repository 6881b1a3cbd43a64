"""Times given as numbers in s or as texts such as "20 ms"."""

from __future__ import annotations

from typing import Any

from rattle.language.units import TIME, QuantityError, describe, parse_quantity

Seconds = float | str  # a time: a number in s, or a text such as "20 ms"


def seconds(value: Seconds, what: str) -> float:
    """A time in s, given as a number or as a text such as "20 ms".

    what: the name of the argument, for messages.  Raises ValueError if the text or number is not a time, TypeError for
    other types.
    """
    if isinstance(value, str):
        try:
            found = parse_quantity(value)
        except QuantityError as error:
            raise ValueError(f"{what}: {error}") from None
        if found is None:
            raise ValueError(f'{what}: {value!r} is not a time; expected s, as in 0.02 or "20 ms"')
        if found[1] is not None and found[1] != TIME:
            raise ValueError(f'{what}: {value!r} is {describe(found[1])}; expected a time, as in 0.02 or "20 ms"')
        return found[0]
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{what}: the number is too large") from None
    except (TypeError, ValueError):
        raise TypeError(f'{what} is a time in s, as in 0.02 or "20 ms"; got {value!r}') from None


def seconds_or_none(value: Seconds | None, what: str) -> float | None:
    """A time in s as `seconds` reads it, or None if None is given.  Raises as `seconds` does."""
    return None if value is None else seconds(value, what)


def times(value: Any, what: str) -> Any:
    """One time or a list of times in s, with texts converted as by `seconds`; other values are returned unchanged.

    Raises as `seconds` does.
    """
    if isinstance(value, str):
        return seconds(value, what)
    if isinstance(value, list | tuple) and any(isinstance(one, str) for one in value):
        return [seconds(one, what) for one in value]
    return value
