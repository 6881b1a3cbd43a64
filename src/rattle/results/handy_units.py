"""In which unit people read a quantity: one table for tables, reports, pictures, pages and the studio.

What the user asks for comes first; then, in pictures and pages, the unit in which the model file writes a quantity of
such a size, where its number is handy; then the table.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rattle.language.units import QuantityError, parse_quantity, unit_of_quantity
from rattle.results.chosen_units import Shown, chosen, shown_in, si_unit
from rattle.value_types import Tree

DEGREES = 180.0 / math.pi
SMALL = 0.2  # a length below it is written in mm, in drawings, curves and tables [m]
LEAST, MOST = 0.1, 1e5  # numbers that are handy in the unit of the model file


class Written(NamedTuple):
    """A quantity as a model file writes it: its size [SI], factor from the SI unit, and the name of its unit."""

    size: float
    factor: float
    unit: str


Units = Mapping[str, Sequence[Written]]  # by SI unit the quantities of a model file


class Rung(NamedTuple):
    """A unit, and the size [SI] from which on it is used."""

    least: float
    factor: float  # from the SI unit
    unit: str


Ladders = Mapping[str, tuple[Rung, ...]]  # by SI unit


def _ladders(units: Mapping[str, Mapping[str, float]]) -> Ladders:
    return {si: tuple(Rung(least, *shown_in(unit)) for unit, least in rungs.items()) for si, rungs in units.items()}


ANGLES: Mapping[str, Mapping[str, float]] = {"rad": {"deg": 0.0}, "rad/s": {"deg/s": 0.0}, "rad/s^2": {"deg/s^2": 0.0}}
# units, each with the size [SI] from which on it is used: of curves, pictures and pages, and of single numbers on paper
HANDY = _ladders({
    **ANGLES,
    "m": {"µm": 0.0, "mm": 1e-4, "m": SMALL},
    "s": {"µs": 0.0, "ms": 1e-4, "s": 0.1},
    "Hz": {"Hz": 0.0, "kHz": 1e4},
    "N": {"N": 0.0, "kN": 1e4, "MN": 1e7},
    "N*m": {"N*m": 0.0, "kN*m": 1e4, "MN*m": 1e7},
    "W": {"mW": 0.0, "W": 0.1, "kW": 1e4, "MW": 1e7},
    "J": {"mJ": 0.0, "J": 0.1, "kJ": 1e4, "MJ": 1e7},
    "Pa": {"Pa": 0.0, "kPa": 1e4, "MPa": 1e5, "GPa": 1e9},
})  # fmt: skip
# of numbers in a terminal, which stand below each other: all else in SI
IN_TABLES = _ladders({**ANGLES, "m": {"mm": 0.0, "m": SMALL}})
QUANTITY = {  # what has an SI unit, in words
    "s": "time", "Hz": "frequency", "m": "length", "rad": "angle", "N": "force", "N*m": "moment", "Pa": "pressure",
    "m/s": "speed", "rad/s": "angular rate", "m/s^2": "acceleration", "rad/s^2": "angular acceleration", "J": "energy",
    "W": "power",
}  # fmt: skip
LENT = ("m", "rad", "rad/s", "N", "N*m", "W", "m/s")  # SI units of quantities that a model file lends its units


def handy_unit(unit: str, size: float, written: Units | None = None) -> Shown:
    """Factor from the SI unit, and the unit in which a quantity of this size [SI] is shown.

    written: quantities of the model file, see `written_units`: the one nearest in size lends its unit.  A unit that the
    user asks for comes before all others.
    """
    if asked := chosen(unit):
        return asked
    near = min((written or {}).get(unit, ()), key=lambda unit_written: _distance(unit_written.size, size), default=None)
    if near is not None and (size == 0.0 or LEAST <= near.factor * size < MOST):
        return Shown(near.factor, near.unit)
    return rung(HANDY, unit, size)


def rung(ladders: Ladders, unit: str, size: float) -> Shown:
    """The factor and unit that a size [SI] reaches; the SI unit for 0 where there are several, and where none is."""
    rungs = ladders.get(unit, ())
    if len(rungs) > 1 and not size > 0.0:
        return Shown(1.0, unit)
    reached = [Shown(rung.factor, rung.unit) for rung in rungs if rung.least <= size]
    return reached[-1] if reached else Shown(1.0, unit)


def _distance(size: float, other: float) -> float:
    """How far two sizes are from each other, as the logarithm of their ratio; 0 beside zero."""
    return abs(math.log(size / other)) if other > 0.0 else 0.0


def written_units(document: Any) -> dict[str, list[Written]]:
    """Lengths, angles, rates, forces, moments, powers and speeds of a model file with their units, each size once.

    document: its tables, or their JSON.
    """
    units: dict[str, list[Written]] = {}
    for text in _texts(json.loads(document) if isinstance(document, str) else document):
        unit, quantity = _unit_of(text)
        if quantity is not None and quantity not in units.setdefault(unit, []):
            units[unit].append(quantity)
    return units


def units_of_result(provenance: Tree) -> dict[str, list[Written]]:
    """The same of the model that a result holds; none without a model."""
    document = provenance.get("document")
    return written_units(str(document)) if document else {}


def _texts(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _texts(item)


def _unit_of(text: str) -> tuple[str, Written | None]:
    """SI unit and unit of a quantity in a model file; None for other texts and for other kinds of quantities."""
    try:
        quantity = parse_quantity(text)
    except QuantityError:
        return "", None
    if quantity is None or quantity[1] is None or quantity[0] == 0.0:
        return "", None
    name = unit_of_quantity(text)[1]
    unit = si_unit(name, quantity[1])
    return unit, Written(abs(quantity[0]), *shown_in(name)) if unit in LENT else None
