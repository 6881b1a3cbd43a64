"""In which unit people read a quantity: one table for pictures, pages and the studio.

The unit in which the model file writes a quantity of such a size comes first, where its number is handy; then a table.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rattle.language.units import (
    FORCE,
    LENGTH,
    MOMENT,
    POWER,
    Dimension,
    QuantityError,
    dimension_of,
    parse_quantity,
    unit_of_quantity,
)
from rattle.results.chosen_units import Shown, chosen
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


Ladders = Mapping[str, tuple[tuple[float, float, str], ...]]  # by SI unit: from which size [SI] on, factor, unit
# of axes and curves
HANDY: Ladders = {
    "m": ((0.0, 1e6, "µm"), (1e-4, 1e3, "mm"), (SMALL, 1.0, "m")),
    "rad": ((0.0, DEGREES, "deg"),),
    "rad/s": ((0.0, DEGREES, "deg/s"),),
    "rad/s^2": ((0.0, DEGREES, "deg/s^2"),),
    "N": ((0.0, 1.0, "N"), (2e4, 1e-3, "kN"), (2e7, 1e-6, "MN")),
    "N*m": ((0.0, 1.0, "N*m"), (2e4, 1e-3, "kN*m"), (2e7, 1e-6, "MN*m")),
    "W": ((0.0, 1.0, "W"), (2e4, 1e-3, "kW"), (2e7, 1e-6, "MW")),
    "J": ((0.0, 1e3, "mJ"), (0.05, 1.0, "J"), (2e4, 1e-3, "kJ"), (2e7, 1e-6, "MJ")),
    "Pa": ((0.0, 1.0, "Pa"), (1e4, 1e-3, "kPa"), (1e5, 1e-6, "MPa"), (1e9, 1e-9, "GPa")),
}
# of single numbers on paper, between which no scale is shared
PRINTED: Ladders = {
    "N": ((1e4, 1e-3, "kN"), (1e7, 1e-6, "MN")),
    "N*m": ((1e4, 1e-3, "kN*m"),),
    "W": ((0.0, 1e3, "mW"), (0.1, 1.0, "W"), (1e4, 1e-3, "kW")),
    "J": ((0.0, 1e3, "mJ"), (0.1, 1.0, "J"), (1e4, 1e-3, "kJ")),
    "s": ((0.0, 1e6, "us"), (1e-4, 1e3, "ms"), (0.1, 1.0, "s")),
    "m": ((0.0, 1e6, "um"), (1e-4, 1e3, "mm"), (0.05, 1.0, "m")),
    "Pa": ((1e3, 1e-3, "kPa"), (1e6, 1e-6, "MPa"), (1e9, 1e-9, "GPa")),
    "Hz": ((1e4, 1e-3, "kHz"),),
}
# SI units of curves by the dimension of what a model file writes; angles have none, so that their names decide
DIMENSIONS: dict[Dimension, str] = {LENGTH: "m", FORCE: "N", MOMENT: "N*m", POWER: "W", dimension_of("m/s"): "m/s"}
TURNING = {"deg": "rad", "°": "rad", "rad": "rad", "rpm": "rad/s", "rad/s": "rad/s", "deg/s": "rad/s"}
ENERGIES = ("J", "Wh")  # of the same dimension as a moment


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
    reached = [Shown(factor, name) for least, factor, name in rungs if least <= size]
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
    size, name = unit_of_quantity(text)
    unit = TURNING.get(name) or ("" if name in ENERGIES else DIMENSIONS.get(quantity[1], ""))
    return unit, Written(abs(quantity[0]), 1.0 / size, name) if unit else None
