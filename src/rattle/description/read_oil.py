"""The oil of a lubricated contact by its name and temperature: viscosity and density, in place of their numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rattle.catalogue.oils import AT_15, COLDEST, EXPANSION, HOTTEST, MM2, SHIFT, Oil, oil
from rattle.description.model import OilAt
from rattle.description.read_fields import FieldReader
from rattle.description.reading import Path, Table
from rattle.description.tables import OIL
from rattle.errors import InputError
from rattle.language.expression import parse, value
from rattle.language.recorded import bare
from rattle.language.units import FREEZING

OIL_KEYS = ("oil", "temperature")
# the law as `Oil.viscosity` has it, so that a temperature that is recorded keeps its record
KINEMATIC = "(10**(10**(A - B*log(T)/log(10))) - shift)/mm2"
DENSITY = "density15*(1 - expansion*(T - at_15))"


def read_oil(reader: FieldReader, table: Table, path: Path) -> tuple[OilAt | None, Table]:
    """The oil of a lubricated contact, None if it is not named or after a problem; and the table with its numbers."""
    values, before = reader.values, len(reader.values.problems)
    if "oil" not in table:
        if "temperature" in table:
            why = 'is that of an oil: name it, oil = "ISO VG 46", in place of its viscosity'
            values.wrong((*path, "temperature"), why, at_key=True)
        return None, table
    for key in ("viscosity", "density"):
        if key in table:
            values.wrong((*path, key), f"the oil says its {key}; leave one of them out", at_key=True)
    if "temperature" not in table:
        values.wrong(path, 'oil needs temperature: viscosity follows from it, such as "60 degC"')
    read = reader.read(OIL, {key: table[key] for key in ("temperature",) if key in table}, path)
    warm, lubricant = read["temperature"], _oil(reader, table["oil"], (*path, "oil"))
    rest = {key: part for key, part in table.items() if key not in OIL_KEYS}
    if lubricant is None or len(values.problems) > before or math.isnan(bare(warm)):
        return None, {**rest, "viscosity": 1.0}  # told already: nothing more of it
    if not (warm >= COLDEST and warm <= HOTTEST):
        values.wrong((*path, "temperature"), _outside(bare(warm)))
        return None, {**rest, "viscosity": 1.0}
    a, b = lubricant.law
    names = {
        "T": warm, "A": a, "B": b, "shift": SHIFT, "mm2": MM2, "density15": lubricant.density15, "expansion": EXPANSION,
        "at_15": AT_15,
    }  # fmt: skip
    density = value(parse(DENSITY), names)
    viscosity = value(parse(f"({KINEMATIC})*({DENSITY})"), names)
    return OilAt(lubricant, warm, viscosity, density), {**rest, "viscosity": viscosity, "density": density}


def _outside(warm: float) -> str:
    """What is said of a temperature [K] at which oils are not used."""
    asked = f"; a number is kelvin: write '{warm:.9g} degC'" if COLDEST <= warm + FREEZING <= HOTTEST else ""
    ends = f"{COLDEST - FREEZING:g} ... {HOTTEST - FREEZING:g} degC"
    return f"{warm - FREEZING:.6g} degC is outside {ends}, where oils set or burn{asked}"


def _oil(reader: FieldReader, written: Any, path: Path) -> Oil | None:
    try:
        return oil(dict(written) if isinstance(written, Mapping) else written)
    except InputError as error:
        reader.values.wrong(path, str(error).removeprefix("oil: "))
        return None
