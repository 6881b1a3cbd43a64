"""Quantities given as numbers in SI units or as texts with a unit, such as "50 um"."""

from __future__ import annotations

from rattle.errors import InputError, WrongType
from rattle.language.units import QuantityError, describe, dimension_of, parse_quantity

Quantity = float | str  # a number in SI units, or a text such as "20 ms"


def in_si(value: Quantity, what: str, unit: str, example: str) -> float:
    """A quantity as a number in its SI unit.

    what: the name of the argument, unit: its SI unit, example: how it may be written, for messages.  Raises InputError
    if a text or number is no such quantity, TypeError for other types.
    """
    dimension = dimension_of(unit)
    kind = describe(dimension)
    if isinstance(value, str):
        try:
            quantity = parse_quantity(value)
        except QuantityError as error:
            raise InputError(f"{what}: {error}") from None
        if quantity is None:
            raise InputError(f"{what}: {value!r} is not {kind}; expected {unit}, as in {example}")
        if quantity[1] is not None and quantity[1] != dimension:
            raise InputError(f"{what}: {value!r} is {describe(quantity[1])}; expected {kind}, as in {example}")
        return quantity[0]
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{what}: the number is too large") from None
    except (TypeError, ValueError):
        raise _wrong_type(value, what, f"{kind} in {unit}", example) from None


def _wrong_type(value: object, what: str, kind: str, example: str) -> WrongType:
    return WrongType(f"{what} is {kind}, as in {example}; got {value!r}")
