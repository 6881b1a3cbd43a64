"""Numbers as a person would write them: with the fewest digits that keep what is drawn, in the unit they had."""

from __future__ import annotations

import math

from rattle.errors import InputError
from rattle.language.units import dimension_of, parse_quantity, unit_of_quantity

MOST_DIGITS = 17
AT_REST = 1e-13  # share of a length, or angle [rad], by which a written number may miss the drawn one


def number_of(written: object) -> float | None:
    """The number that a value says [SI]; None for an expression.  Raises InputError for a unit that is not known."""
    if isinstance(written, int | float):
        return float(written)
    quantity = parse_quantity(str(written))
    return None if quantity is None else quantity[0]


def typed_number(text: str, unit: str) -> float | None:
    """The number that was typed [SI], of a field with this unit; None for an expression.

    Raises InputError for a quantity of another kind, and for one that is not finite.
    """
    quantity = parse_quantity(text)
    if quantity is None:
        return None
    if quantity[1] not in (None, dimension_of(unit)):
        raise InputError(f"'{text}' is not in {unit}: type a number with a unit of that kind")
    return quantity[0]


def shortest(value: float, within: float) -> float:
    """The number with the fewest digits that is at most `within` away from this one."""
    if abs(value) <= within:
        return 0.0
    for digits in range(1, MOST_DIGITS):
        rounded = float(f"{value:.{digits}g}")
        if abs(rounded - value) <= within:
            return rounded + 0.0  # not -0
    return value


def length(value: float, size: float = 0.0) -> float:
    """A length or coordinate [m] with the fewest digits; size: of what it belongs to [m]."""
    return shortest(value, AT_REST * max(abs(value), size))


def degrees(angle: float, within: float = AT_REST) -> str:
    """An angle [rad] as a text in degrees, between -180 and 180; within: by which it may be off [rad]."""
    turned = math.remainder(angle, math.tau)
    return f"{plain(shortest(math.degrees(turned), math.degrees(within)))} deg"


def plain(value: float) -> str:
    """A number as text: 5, 0.25, 1e-07."""
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def in_unit_of(written: object, value: float, size: float = 0.0) -> float | str:
    """A length or coordinate [m] in the unit of the quantity that stood there, or as a number in m; size as above."""
    if not isinstance(written, str) or parse_quantity(written) is None:
        return length(value, size)
    scale, unit = unit_of_quantity(written)
    return f"{plain(length(value / scale, size / scale))} {unit}" if unit else length(value, size)
