"""The table [heat]: the ways of the heat of joints to the air, and between them."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

from rattle.description.model import HeatPaths
from rattle.description.read_fields import FieldReader
from rattle.description.read_values import Values, quoted
from rattle.description.reading import Path, Table
from rattle.description.tables import CONDUCTION, HEAT
from rattle.errors import suggest

LIKE = '{ between = ["A", "B"], conductance = "0.5 W/K" }'


def read_heat(reader: FieldReader, document: Table, joints: Collection[str]) -> HeatPaths | None:
    """Where the heat of joints goes; None if the model does not say it."""
    if "heat" not in document:
        return None
    values, path = reader.values, ("heat",)
    table = values.table(document["heat"], path)
    ambient = reader.form(HEAT, table, path)["ambient"]
    cooling = values.table(table.get("cooling", {}), (*path, "cooling"))
    to_air = {}
    for name, written in cooling.items():
        _require_joint(values, name, joints, (*path, "cooling", name))
        to_air[name] = values.value(written, "W/K", (*path, "cooling", name), "positive")
    between: dict[tuple[str, str], float] = {}
    ways = table.get("conduction", [])
    if not isinstance(ways, list | tuple):
        values.wrong((*path, "conduction"), f"expected [{LIKE}, ...], got {quoted(ways)}")
        return None
    for n, written in enumerate(ways):
        way = _way(reader, written, joints, (*path, "conduction", n))
        if way is not None:
            between[way[0]] = between.get(way[0], 0.0) + way[1]
    return HeatPaths(ambient, to_air, between)


def _way(
    reader: FieldReader, written: object, joints: Collection[str], path: Path
) -> tuple[tuple[str, str], float] | None:
    """Two joints and the conductance between them [W/K]; None after a problem."""
    if not isinstance(written, Mapping):
        reader.values.wrong(path, f"expected a way such as {LIKE}, got {quoted(written)}")
        return None
    read = reader.form(CONDUCTION, written, path)
    ends, conductance = read["between"], read["conductance"]
    if not isinstance(ends, tuple) or math.isnan(conductance):
        return None
    for k, name in enumerate(ends):
        _require_joint(reader.values, name, joints, (*path, "between", k), at_key=False)
    if ends[0] == ends[1]:
        reader.values.wrong((*path, "between"), f"{quoted(ends[0])} stands at both ends; name two joints")
        return None
    first, second = sorted(ends)
    return (first, second), conductance


def _require_joint(values: Values, name: str, joints: Collection[str], path: Path, at_key: bool = True) -> None:
    if name not in joints:
        values.wrong(path, f"no joint {quoted(name)}{suggest(name, joints)}", at_key=at_key)
