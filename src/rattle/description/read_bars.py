"""Bodies that are straight bars: ends, section and material, and how their mass lies along them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rattle.description.model import Beam, Body, Section, Vector
from rattle.description.read_fields import FieldReader
from rattle.description.read_materials import material_named, read_section
from rattle.description.read_values import Values, is_computable
from rattle.description.reading import Path, Table
from rattle.description.tables import BAR
from rattle.language.materials import Material
from rattle.language.recorded import bare

ROUNDING = 1e-9  # share of the length by which the last x of `mass_per_length` may miss the end of the bar
NO_MASS = "needs a mass in kg, or a section and a material whose density is known"
OF_WEIGHT = ("section", "material")
TOLD_TWICE = "mass_per_length says mass and inertia; leave this out"


class _Weight(NamedTuple):
    """Mass [kg], mass centre from the first end [m], inertia about it [kg*m^2], and how the mass lies along the bar."""

    mass: float
    centre: float
    inertia: float
    line: tuple[Vector, ...] = ()
    at_ends: Vector = (0.0, 0.0)


def read_bar(reader: FieldReader, name: str, table: Table) -> tuple[Body, bool]:
    """A bar; and whether the names of its ends are sound, without which its points are not all known."""
    values, path = reader.values, ("bodies", name)
    read = reader.form(BAR, table, path)
    length = read["length"]
    section = read_section(reader, table["section"], (*path, "section")) if "section" in table else None
    material = material_named(values, table["material"], (*path, "material")) if "material" in table else None
    read |= {"section": section, "material": material}
    weight = _weight(values, read, table, path)
    ends, sound = _ends(values, read["bar"], length, weight.centre, read["points"] or {}, path)
    points = {**ends, **(read["points"] or {})}
    if not (is_computable(weight.inertia) or weight.mass == 0) and not math.isnan(bare(weight.inertia)):
        values.wrong(path, f"its inertia m l^2/12 = {weight.inertia:g} kg*m^2 is out of range")
    beam = None
    if sound and read["bar"] is not None:
        beam = Beam(read["bar"], length, weight.centre, section, material, weight.line, weight.at_ends)
    return Body(name, weight.mass, weight.inertia, points, True, beam=beam, z=read["z"]), sound


def _ends(
    values: Values, ends: tuple[str, str] | None, length: float, centre: float, points: Mapping[str, Vector], path: Path
) -> tuple[dict[str, Vector], bool]:
    """The two end points of a bar [m], and whether they are sound."""
    if ends is None:
        return {}, False
    first, second = ends
    sound = True
    for end in {first: 0, second: 0}:
        if end in points or first == second:
            values.wrong((*path, "bar"), f"the point name '{end}' is used twice")
            sound = False
    return {first: (-centre, 0.0), second: (length - centre, 0.0)}, sound


# ---------------------------------------------------------------- how heavy it is
def _weight(values: Values, read: Mapping[str, Any], table: Table, path: Path) -> _Weight:
    length = read["length"]
    if "mass_per_length" in table:
        return _of_line(values, read, table, length, path)
    mass, inertia = read["mass"], read["inertia"]
    if mass is None:
        mass = _of_material(read["section"], read["material"], length)
        if mass is None and "mass" not in table and all(read[key] is not None for key in OF_WEIGHT if key in table):
            values.wrong(path, NO_MASS if any(key in table for key in OF_WEIGHT) else "needs a mass in kg")
        mass = math.nan if mass is None else mass
    uniform = mass * length * length / 12
    if inertia is None:
        line = _along(mass, length)
        return _Weight(mass, length / 2, uniform, line)
    end = (inertia - uniform) / (length * length / 3)
    return _Weight(mass, length / 2, inertia, _along(mass - 2 * end, length), (end, end))


def _along(mass: float, length: float) -> tuple[Vector, ...]:
    """A mass [kg] that is spread evenly."""
    return (0.0, mass / length), (length, mass / length)


def _of_material(section: object, material: object, length: float) -> float | None:
    """The mass [kg] of a bar of this section and material; None if that does not say it."""
    if isinstance(section, Section) and isinstance(material, Material) and not math.isnan(bare(material.density)):
        return section.area * material.density * length
    return None


def _of_line(values: Values, read: Mapping[str, Any], table: Table, length: float, path: Path) -> _Weight:
    """Mass, mass centre and inertia of a bar whose mass per length is given."""
    nothing = _Weight(math.nan, length / 2, math.nan)
    for key in ("mass", "inertia"):
        if key in table:
            values.wrong((*path, key), TOLD_TWICE, at_key=True)
    line: Sequence[Vector] = read["mass_per_length"] or ()
    if not line or any(math.isnan(bare(number)) for pair in line for number in pair):
        return nothing
    if fault := _fault(line, length):
        values.wrong((*path, "mass_per_length"), fault)
        return nothing
    mass = first = second = 0.0
    for (a, p), (b, q) in itertools.pairwise(line):
        h = b - a  # density p + (q - p) s at x = a + h s
        mass += h * (p + q) / 2
        first += h * (a * (p + q) / 2 + h * (p + 2 * q) / 6)
        second += h * (a * a * (p + q) / 2 + a * h * (p + 2 * q) / 3 + h * h * (p + 3 * q) / 12)
    centre = first / mass
    return _Weight(mass, centre, second - mass * centre * centre, tuple(line))


def _fault(line: Sequence[Vector], length: float) -> str:
    """What is wrong with a mass per length, in words; "" if nothing is."""
    places = [bare(x) for x, _ in line]
    size = bare(length)
    if abs(places[0]) > ROUNDING * size or abs(places[-1] - size) > ROUNDING * size:
        return f"goes from x = {places[0]:g} m to {places[-1]:g} m; expected from 0 to the length, {size:g} m"
    if any(not a < b for a, b in itertools.pairwise(places)):
        return "x must increase from one pair to the next"
    return "" if any(bare(density) > 0.0 for _, density in line) else "is 0 everywhere; expected mass somewhere"
