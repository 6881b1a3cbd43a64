"""Bodies that are plates: a polygon with holes, and how heavy it is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from rattle.description.cuts import Cut, CutFault
from rattle.description.model import Body, Sheet, Vector
from rattle.description.polygon import MOST_CORNERS, fault_of_holes, figure_of, watch, watch_sides
from rattle.description.read_fields import FieldReader
from rattle.description.read_materials import material_named
from rattle.description.read_values import Values, is_computable
from rattle.description.reading import Path, Table
from rattle.description.tables import PLATE
from rattle.language.materials import Material
from rattle.language.recorded import bare

NO_WEIGHT = "thickness in m and density in kg/m^3, or a mass in kg"
FOLLOW = {"center": "the mass centre", "inertia": "the inertia"}  # what the polygon says, unless both are given


def read_plate(reader: FieldReader, name: str, table: Table) -> Body:
    """A plate of one thickness and density; its mass is their product with its area, or given.

    Its inertia about the mass centre is the second moment of its area times its mass per area.
    """
    values, path = reader.values, ("bodies", name)
    own = _states_its_own(values, table, path)
    read = reader.form(PLATE, {key: written for key, written in table.items() if own or key not in FOLLOW}, path)
    material = material_named(values, table["material"], (*path, "material")) if "material" in table else None
    points = read["points"] or {}
    per_area, mass = _weight(values, table, read, material, path)
    rings = _rings(values, read, table, path)
    if not rings:
        return Body(name, math.nan, math.nan, points)
    watch(rings)
    figure = figure_of(rings[0], rings[1:])
    mass = per_area * figure.area if math.isnan(bare(mass)) else mass
    inertia = read["inertia"] if own else mass / figure.area * figure.second
    _require_in_range(values, mass, inertia, path)
    centre = (own and read["center"]) or figure.centre
    placed = dict(zip(points, _from(centre, list(points.values())), strict=True))
    outline = tuple(_from(centre, ring) for ring in rings)
    sheet = Sheet(read.get("thickness", math.nan), material, _necks(values, read, table, centre, outline, path))
    return Body(name, mass, inertia, placed, outline=outline, sheet=sheet, z=read["z"])


def _from(centre: Vector, places: Sequence[Vector]) -> tuple[Vector, ...]:
    """Places as they are seen from the mass centre."""
    return tuple((x - centre[0], y - centre[1]) for x, y in places)


def _rings(values: Values, read: Mapping[str, Any], table: Table, path: Path) -> list[list[Vector]]:
    """Corners of the polygon, then of each hole; none after a problem."""
    holes = read["holes"] if "holes" in table else []
    if not read["polygon"] or holes is None or not _rings_fit(values, read["polygon"], holes, path):
        return []
    return [read["polygon"], *holes]


def _necks(
    values: Values, read: Mapping[str, Any], table: Table, centre: Vector, rings: Sequence[Sequence[Vector]], path: Path
) -> dict[str, tuple[Vector, Vector]]:
    """Both ends of each neck, from the mass centre; those that do not divide the plate in two are noted."""
    necks: dict[str, tuple[Vector, Vector]] = {}
    for name, ends in (read["necks"] or {}).items():
        first, second = _from(centre, ends)
        necks[name] = first, second
        try:
            Cut(rings, (first, second))
        except CutFault as fault:
            values.wrong((*path, "necks", name), str(fault))
        else:
            watch_sides((first, second), rings)
    if necks and "thickness" not in table:
        values.wrong((*path, "necks"), "stresses there need the thickness of the plate in m", at_key=True)
    return necks


def _states_its_own(values: Values, table: Table, path: Path) -> bool:
    """True if mass, mass centre and inertia are all given; one that is given alone is refused."""
    stated = [key for key in FOLLOW if key in table]
    own = len(stated) == len(FOLLOW) and "mass" in table
    for key in () if own else stated:
        why = f"the polygon says {FOLLOW[key]}; leave this out, or give mass, center and inertia"
        values.wrong((*path, key), why, at_key=True)
    return own


def _require_in_range(values: Values, mass: float, inertia: float, path: Path) -> None:
    """Note a mass or inertia with which nothing can be computed."""
    for what, number, unit in (("mass", mass, "kg"), ("inertia", inertia, "kg*m^2")):
        if not is_computable(number) and not math.isnan(bare(number)):
            values.wrong(path, f"its {what} = {number:g} {unit} is out of range")
            return


def _rings_fit(values: Values, outline: Sequence[Vector], holes: Sequence[Sequence[Vector]], path: Path) -> bool:
    """True if the holes are inside of the outline, and all have not too many corners."""
    if sum(map(len, (outline, *holes))) > MOST_CORNERS:
        values.wrong((*path, "polygon"), f"a plate has at most {MOST_CORNERS} corners, those of its holes included")
        return False
    if wrong := fault_of_holes(outline, holes):
        values.wrong((*path, "holes", wrong[0]), wrong[1])
    return not wrong


def _weight(
    values: Values, table: Table, read: Mapping[str, float], material: Material | None, path: Path
) -> tuple[float, float]:
    """Mass per area [kg/m^2] and mass [kg] of a plate, nan for the one that is not given, and after a problem."""
    if "mass" in table:
        if "density" in table:
            values.wrong((*path, "mass"), "give thickness and density, or a mass in kg, not both", at_key=True)
        return math.nan, read.get("mass", math.nan)
    density = read.get("density", math.nan if material is None else material.density)
    weighs = "density" in table or ("material" in table and (material is None or not math.isnan(bare(density))))
    if "thickness" not in table or not weighs:
        missing = "a thickness in m" if weighs else "a density in kg/m^3" if "thickness" in table else NO_WEIGHT
        values.wrong(path, f"needs {missing}")
        return math.nan, math.nan
    return read["thickness"] * density, math.nan
