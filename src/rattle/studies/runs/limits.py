"""Limits of outputs: numbers in SI units, or quantities such as "0.1 deg"."""

from __future__ import annotations

from rattle.analyses import arguments
from rattle.errors import InputError
from rattle.language.units import Dimension, QuantityError, describe, dimension_of, parse_quantity


def limit_of(wanted: float | str, unit: str, what: str = "limit", dimension: Dimension | None = None) -> float:
    """A limit [SI] of an output with this SI unit ("" if it has none or it is not known).

    dimension: of an output without a unit, None if it is not known.

    Raises InputError, TypeError.
    """
    if not isinstance(wanted, str):
        return arguments.number(what, wanted)
    try:
        quantity = parse_quantity(wanted)
    except QuantityError as error:
        raise InputError(f"{what}: {error}") from None
    if quantity is None:
        raise InputError(f"{what}: {wanted!r:.60} is not a value; expected a number in SI or such as '0.1 deg'")
    number, seen = quantity
    expected = dimension_of(unit) if unit else dimension
    if seen is not None and expected is not None and seen != expected:
        raise InputError(f"{what}: {wanted} is {describe(seen)}; expected {describe(expected)}")
    return number
