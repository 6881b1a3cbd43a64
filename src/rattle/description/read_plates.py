"""Bodies that are plates: a polygon with holes, and how heavy it is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rattle.description.model import Body, Vector
from rattle.description.polygon import fault, fault_of_holes, figure_of, watch
from rattle.description.read_values import Path, Values, is_computable, said

PLATE = ("polygon", "holes", "thickness", "density", "mass", "points")  # keys of a plate
FOLLOW = {"center": "the mass centre", "inertia": "the inertia"}  # what the polygon says
MOST_CORNERS = 1000  # of one plate


def read_plate(values: Values, name: str, given: Mapping[str, Any]) -> Body:
    """A plate of one thickness and density; its mass is their product with its area, or given.

    Its inertia about the mass centre is the second moment of its area times its mass per area.
    """
    path = ("bodies", name)
    for key, what in FOLLOW.items():
        if key in given:
            values.wrong((*path, key), f"the polygon says {what}; leave this out", at_key=True)
    values.keys({key: one for key, one in given.items() if key not in FOLLOW}, PLATE, path)
    before = len(values.problems)
    outline = _ring(values, given["polygon"], (*path, "polygon"))
    holes = _holes(values, given.get("holes", ()), (*path, "holes"))
    if len(values.problems) == before and sum(map(len, (outline, *holes))) > MOST_CORNERS:
        values.wrong((*path, "polygon"), f"a plate has at most {MOST_CORNERS} corners, those of its holes included")
    if len(values.problems) == before and (wrong := fault_of_holes(outline, holes)):
        values.wrong((*path, "holes", wrong[0]), wrong[1])
    sound = len(values.problems) == before
    points = values.points(given.get("points", {}), (*path, "points"))
    per_area, mass = _weight(values, given, path)
    if not sound:
        return Body(name, math.nan, math.nan, points)
    watch((outline, *holes))
    figure = figure_of(outline, holes)
    mass = per_area * figure.area if math.isnan(mass) else mass
    inertia = mass / figure.area * figure.second
    for what, number, unit in (("mass", mass, "kg"), ("inertia", inertia, "kg*m^2")):
        if not is_computable(number) and not math.isnan(number):
            values.wrong(path, f"its {what} = {number:g} {unit} is out of range")
            break
    cx, cy = figure.centre

    def of_centre(ring: list[Vector]) -> tuple[Vector, ...]:
        return tuple((x - cx, y - cy) for x, y in ring)

    placed = dict(zip(points, of_centre(list(points.values())), strict=True))
    return Body(name, mass, inertia, placed, outline=tuple(map(of_centre, (outline, *holes))))


def _ring(values: Values, given: Any, path: Path) -> list[Vector]:
    """Corners [m] in order around; a fault is reported."""
    if not isinstance(given, list | tuple):
        values.wrong(path, f"expected corners in order around, [[x, y], [x, y], [x, y]], got {said(given)}")
        return []
    before = len(values.problems)
    corners = [values.vector(one, "m", (*path, k)) for k, one in enumerate(given[: MOST_CORNERS + 1])]
    if len(values.problems) == before and len(corners) <= MOST_CORNERS and (wrong := fault(corners)):
        values.wrong(path, wrong)
    return corners


def _holes(values: Values, given: Any, path: Path) -> list[list[Vector]]:
    """The corners of every hole [m]."""
    if not isinstance(given, list | tuple) or not all(isinstance(one, list | tuple) for one in given):
        values.wrong(path, f"expected a list of holes, each a list of corners [x, y], got {said(given)}")
        return []
    return [_ring(values, one, (*path, k)) for k, one in enumerate(given)]


def _weight(values: Values, given: Mapping[str, Any], path: Path) -> tuple[float, float]:
    """Mass per area [kg/m^2] and mass [kg] of a plate, nan for the one that is not given, and after a problem."""
    both = [key for key in ("thickness", "density") if key in given]
    units = {"mass": "kg", "thickness": "m", "density": "kg/m^3"}
    found = {
        key: values.value(given[key], unit, (*path, key), "positive") for key, unit in units.items() if key in given
    }
    if "mass" in given and both:
        values.wrong((*path, "mass"), "give thickness and density, or a mass in kg, not both", at_key=True)
    elif "mass" not in given and len(both) < 2:
        missing = {"thickness": "a density in kg/m^3", "density": "a thickness in m"}.get("".join(both))
        values.wrong(path, f"needs {missing or 'thickness in m and density in kg/m^3, or a mass in kg'}")
    return found.get("thickness", math.nan) * found.get("density", math.nan), found.get("mass", math.nan)
