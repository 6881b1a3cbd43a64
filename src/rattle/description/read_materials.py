"""Materials of a model's own, by name, and sections of bars."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from rattle.description.model import Section
from rattle.description.read_fields import FieldReader
from rattle.description.read_values import Values, quoted
from rattle.description.reading import Path, Table
from rattle.description.tables import MATERIAL_OF_MODEL, SECTION_NUMBERS, SECTION_SHAPES, Form
from rattle.errors import InputError, suggest
from rattle.language.materials import MATERIALS, OF_MODEL, Material, material

OWN_NAMES = {"yield": "yield_strength"}  # of keys that are no names of fields


def read_materials(values: Values, document: Table) -> dict[str, Material]:
    """Read the table [materials]; they are entered in `values` as well."""
    reader = FieldReader(values)
    for name, written in values.table(document.get("materials", {}), ("materials",)).items():
        path: Path = ("materials", name)
        with values.at(path):
            before, table = len(values.problems), values.table(written, path)
            read = reader.form(MATERIAL_OF_MODEL, table, path)
            _require_possible(values, read, path)
            constants = {OWN_NAMES.get(key, key): number for key, number in read.items() if number is not None}
            if len(values.problems) == before:
                values.materials[name] = Material(**constants, source=OF_MODEL, name=name)
            else:
                values.broken_materials.add(name)
    return values.materials


def _require_possible(values: Values, read: Mapping[str, float | None], path: Path) -> None:
    """Refuse numbers that no material has."""
    nu, yields, breaks = read["nu"], read["yield"], read["ultimate"]
    if nu is not None and not math.isnan(nu) and not -1.0 < nu <= 0.5:
        values.wrong((*path, "nu"), f"Poisson's ratio must lie within -1 ... 0.5, not {nu:g}")
    if yields is not None and breaks is not None and yields > breaks:
        values.wrong((*path, "yield"), f"{yields:g} Pa is above the ultimate strength of {breaks:g} Pa")


def material_named(values: Values, written: object, path: Path) -> Material | None:
    """The material of a name, of the model's own first, which is kept with its place; None after a problem."""
    material = _material_named(values, written, path)
    if material is not None:
        values.named_materials[".".join(map(str, path[1:]))] = material
    return material


def _material_named(values: Values, written: object, path: Path) -> Material | None:
    if not isinstance(written, str):
        values.wrong(path, f"expected the name of a material, got {quoted(written)}")
        return None
    if written in values.materials:
        return values.materials[written]
    if written in values.broken_materials:
        return None
    try:
        return material(written)
    except InputError:
        near = suggest(written, [*values.materials, *MATERIALS])
        hint = (
            near if "did you mean" in near else f"; define it under [materials], or use one of {', '.join(MATERIALS)}"
        )
        values.wrong(path, f"unknown material {quoted(written)}{hint}")
        return None


# ---------------------------------------------------------------- sections
def read_section(reader: FieldReader, written: object, path: Path) -> Section | None:
    """The section of a bar; None after a problem."""
    values, before = reader.values, len(reader.values.problems)
    table = values.table(written, path)
    if "shape" not in table:
        read = reader.form(Form({**SECTION_NUMBERS}), table, path)
        sound = len(values.problems) == before
        return Section(read["area"], read["inertia"], read["modulus"]) if sound else None
    shape = table["shape"]
    if not isinstance(shape, str) or shape not in SECTION_SHAPES:
        either = f"{', '.join(SECTION_SHAPES)}, or {{ area, inertia, modulus }} without a shape"
        near = suggest(str(shape), SECTION_SHAPES)
        hint = near if "did you mean" in near else f"; expected {either}"
        values.wrong((*path, "shape"), f"unknown section {quoted(shape)}{hint}")
        return None
    sizes = reader.form(Form({**SECTION_SHAPES[shape]}), {key: table[key] for key in table if key != "shape"}, path)
    if len(values.problems) > before:
        return None
    section = SECTIONS[shape](**sizes)
    if shape == "tube" and not 2 * sizes["wall"] < sizes["diameter"]:
        fault = f"{sizes['wall']:g} m is half of the diameter of {sizes['diameter']:g} m or more"
        values.wrong((*path, "wall"), fault)
        return None
    return section


def rectangle(width: float, height: float) -> Section:
    """A rectangle, its height in the plane of bending [m]."""
    area = width * height
    return Section(area, area * height * height / 12, area * height / 6, height, "rectangle")


def disc(diameter: float) -> Section:
    """A full circle [m]."""
    area = math.pi * diameter * diameter / 4
    return Section(area, area * diameter * diameter / 16, area * diameter / 8, diameter, "round")


def tube(diameter: float, wall: float) -> Section:
    """A circle with a hole [m]."""
    inner = diameter - 2 * wall
    area = math.pi * (diameter * diameter - inner * inner) / 4
    inertia = math.pi * (diameter * diameter * diameter * diameter - inner * inner * inner * inner) / 64
    return Section(area, inertia, 2 * inertia / diameter, diameter, "tube")


SECTIONS: Mapping[str, Callable[..., Section]] = {"rectangle": rectangle, "round": disc, "tube": tube}
